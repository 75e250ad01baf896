"""The driver as a process of its own, which ends with this one, however this one ends."""

from __future__ import annotations

import os
import signal
import subprocess
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from threading import current_thread, main_thread

from .installed import driver

ENDING = tuple(getattr(signal, name) for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name))
"""Signals of `kill` and of a terminal that is closed, which end a program; Ctrl-C raises an exception."""


def end_program(number: int, _: object) -> None:
    """End this program on a signal, with what it has started."""
    raise SystemExit(128 + number)


def run_driver(
    *arguments: str | os.PathLike[str], stdout: int | None = None, stderr: int | None = None
) -> tuple[int, str]:
    """Run the driver, and return its exit code and what it wrote to stdout=subprocess.PIPE.

    In the main thread a signal ends the driver first, and takes its usual way here once it has ended; a
    second one kills it.  Raises BrokenPipeError where the reader of its output has gone, ChildProcessError
    where another signal has ended it.
    """
    noted: list[int] = []
    process: subprocess.Popen[bytes] | None = None

    def note(number: int, _: object) -> None:
        noted.append(number)
        if process is not None:
            process.terminate() if len(noted) == 1 else process.kill()

    with handled((signal.SIGINT, *ENDING), note):
        # an exception of a handler while the process starts would leave it behind
        watched, held = os.pipe()  # it ends with this process, also by SIGKILL
        try:
            command = [driver(), "--until-eof", *arguments]
            process = subprocess.Popen(command, stdin=watched, stdout=stdout, stderr=stderr)
            if noted:
                process.terminate()
            written = process.communicate()[0]
        finally:
            os.close(watched)
            os.close(held)
    if noted:
        signal.raise_signal(noted[0])
    code = process.returncode
    if hasattr(signal, "SIGPIPE") and code == -signal.SIGPIPE:
        raise BrokenPipeError
    if code < 0:
        raise ChildProcessError(f"rie_driver was ended by signal {-code} ({signal.strsignal(-code)})")
    return code, (written or b"").decode("utf-8", "replace")


@contextmanager
def handled(numbers: Iterable[int], handler: Callable[[int, object], None]) -> Iterator[None]:
    """Handle signals in the main thread, but not those that are ignored or that others than Python handle."""
    before = {}
    if current_thread() is main_thread():
        before = {number: signal.getsignal(number) for number in numbers}
    before = {
        number: previous for number, previous in before.items() if previous not in (signal.SIG_IGN, None)
    }
    try:
        for number in before:
            signal.signal(number, handler)
        yield
    finally:
        for number, previous in before.items():
            signal.signal(number, previous)
