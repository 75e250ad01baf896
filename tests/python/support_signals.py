"""Signals of programs that tests start, and a start of many of them that costs one import."""

from __future__ import annotations

import signal
import subprocess
import sys
from pathlib import Path

STARTER = """import os, signal, sys
import asperity.cli, asperity.foreign, asperity.sweeps
for line in sys.stdin:
    folder, script = eval(line)
    number = os.fork()
    if number == 0:
        break
    print(number, flush=True)
    print(os.waitstatus_to_exitcode(os.waitpid(number, 0)[1]), flush=True)
else:
    os._exit(0)
for stream in 1, 2:
    os.dup2(os.open(os.devnull, os.O_WRONLY), stream)
os.chdir(folder)
signal.alarm(60)
exec(script)
"""
"""Forks for each script, the rest of a program then: it ends as one does, by a signal, or after a minute."""


def heeds_signals() -> None:
    """Let a program heed signals; a shell in the background starts it without SIGINT, nohup without HUP."""
    for number in (signal.SIGINT, signal.SIGHUP, signal.SIGTERM):
        signal.signal(number, signal.SIG_DFL)


class Starter:
    """Process that has imported the package and runs scripts one after another, each in a copy of itself."""

    def __init__(self) -> None:
        """Import the package."""
        self.process = subprocess.Popen(
            [sys.executable, "-c", STARTER],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, preexec_fn=heeds_signals,
        )  # fmt: skip

    def start(self, script: str, folder: Path) -> int:
        """Number of the process in which a script begins."""
        print(repr((str(folder), script)), file=self.process.stdin, flush=True)
        return int(self.process.stdout.readline())

    def code(self) -> int:
        """Exit code of the script, negative for a signal, once it has ended."""
        return int(self.process.stdout.readline())

    def end(self) -> None:
        """End the process."""
        self.process.communicate(timeout=60.0)
