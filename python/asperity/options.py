"""What commands have in common: tables of arguments, --jobs, --force, files, a progress bar."""

from __future__ import annotations

import argparse
import glob
import os
import re
import shutil
import signal
import sys
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import Executor, ThreadPoolExecutor
from contextlib import AbstractContextManager, contextmanager, nullcontext
from pathlib import Path
from typing import Any, Protocol

from .contract import plain
from .driver_process import ENDING, end_program
from .installed import needed

NO_EQUILIBRIUM = 2  # exit code of the driver after a lost equilibrium


class Parser(argparse.ArgumentParser):
    """Parser for which a list of numbers that begins with a minus sign is a value, as a number is.

    Numbers are those of `contract.plain`.  An option with a value may be given once, unless it is a list.
    """

    def __init__(self, *words: Any, **settings: Any) -> None:
        """Make a parser, as of argparse."""
        super().__init__(*words, **settings)
        self.register("type", float, lambda text: float(plain(text)))
        self.register("type", int, lambda text: int(plain(text)))
        for name in (None, "store"):
            self.register("action", name, Once)
        self.given: set[str] = set()

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Namespace and other words; a word that begins with a blank is a value."""
        words = sys.argv[1:] if args is None else args
        self.given.clear()
        self._check_commas(words)
        values = [f" {word}" if NEGATIVES.fullmatch(word) else word for word in words]
        return super().parse_known_args(values, namespace)

    def _check_commas(self, words: Sequence[str]) -> None:
        """Refuse a number after a number of an option whose values stand between commas."""
        parted = [
            part.strip() for word in words for part in (word.split("=", 1) if word[:2] == "--" else [word])
        ]
        for option, *numbers in zip(parted, parted[1:], parted[2:], strict=False):
            action = self._option_string_actions.get(option)
            listed = action is not None and "," in str(action.metavar) and action.nargs is None
            if listed and all(map(NUMBERS.fullmatch, numbers)):
                wanted = f"expected {','.join(numbers)}, with a comma between"
                self.error(f"{option} {' '.join(numbers)}: {wanted}")


class Once(argparse.Action):
    """Value of an argument; an option that is given a second time is an error."""

    def __call__(self, parser: Any, namespace: argparse.Namespace, values: Any, option: Any = None) -> None:
        """Store the value."""
        if option and self.dest in parser.given:
            text = f"{' or '.join(self.option_strings)}: given twice: expected it once"
            parser.error(f"{text}, as {option} {self.metavar}" if "," in str(self.metavar) else text)
        parser.given.add(self.dest)
        setattr(namespace, self.dest, values)


NEGATIVES = re.compile(r"-[\d.][-+.\deE]*,[-+.,\deE]*|-\d+\.|-(\d+\.?\d*|\.\d+)[eE][-+]?\d+")
"""List of numbers of which the first one is negative, or such a number that argparse takes for an option."""

NUMBERS = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?(,[-+.,\deE]*)?")
"""Number, or several with commas between them."""


class Arguments(Protocol):
    """Parser, or a group of its arguments."""

    def add_argument(self, *names: str, **settings: Any) -> argparse.Action:
        """Add an argument, as of argparse."""


def report(text: str) -> None:
    """Print a line of the command on standard error, behind the name of the program."""
    print("asperity", text, sep=": ", file=sys.stderr)


def report_warning(text: str) -> None:
    """Print a warning of the command on standard error."""
    report(f"warning: {text}")


def add_options(parser: Arguments, *rows: tuple[Any, ...]) -> None:
    """Add arguments to a parser, a row for each: usage, help, and unless it is a flag its type or default.

    usage: its names and that of its value, as "-o --output FILE" or "case CASE.nml".  The type is that of the
    default, which stands in the help; list: the option may be repeated, another one may not.  A fourth
    entry are further settings of argparse, by name.
    """
    for usage, text, *more in rows:
        words = usage.split()
        names = [word for word in words if word.startswith("-")] or words[:1]
        settings: dict[str, Any] = {"metavar": " ".join(words[len(names) :]) or None}
        kind = more[0] if more else bool
        if kind is bool:
            settings = {"action": "store_true"}
        elif kind is list:
            settings |= {"action": "append", "default": []}
        elif callable(kind):
            settings |= {"type": kind}
        else:
            settings |= {"type": type(kind), "default": kind}
            text += "" if "default" in text else " (default: %(default)s)"
        if settings.get("type") is str and words[-1].endswith(",..."):
            settings["type"] = str.strip  # of the blank of `Parser`
        parser.add_argument(*names, help=text, **settings | (more[1] if len(more) > 1 else {}))


def add_workers(parser: argparse.ArgumentParser, default: str = "") -> None:
    """Add the option --jobs; default: what the help says of the processes after their number."""
    add_options(parser, ("--jobs N", f"number of processes {default}".rstrip(), int))


def add_output(parser: argparse.ArgumentParser, usage: str, text: str, default: Any = Path) -> None:
    """Add the options -o, the main result of a command, and --force."""
    force = ("--force", "replace files that this command did not write itself")
    add_options(parser, (f"-o --output {usage}", text, default), force)


def workers(options: argparse.Namespace, jobs: int | None = None) -> AbstractContextManager[Executor | None]:
    """Executor with as many processes as --jobs asks for; otherwise with `jobs`, or None: threads."""
    count, most = jobs if options.jobs is None else options.jobs, os.cpu_count() or 1
    if count is None:
        return nullcontext()
    if not 1 <= count <= most:
        raise ValueError(f"--jobs {count}: expected 1 to {most}, the number of processors")
    if count == 1:
        return ThreadPoolExecutor(1)
    return _processes(count)


@contextmanager
def _processes(count: int) -> Iterator[Executor]:
    """Processes that end, with what they compute, where an exception as that of Ctrl-C leaves the block."""
    from concurrent.futures import ProcessPoolExecutor
    from multiprocessing import active_children, get_context

    earlier = active_children()
    # a fork would copy the locks of threads, but not the threads
    pool = ProcessPoolExecutor(count, get_context("spawn"), initializer=_begin_worker)
    try:
        yield pool
    except BaseException:
        for process in set(active_children()).difference(earlier):
            while process.is_alive():  # each time it ends what it computes, or itself if it waits
                process.terminate()
                process.join(0.1)
        raise
    finally:
        pool.shutdown(cancel_futures=True)


def _begin_worker() -> None:
    # the process that has started this one ends it by TERM
    for number in {signal.SIGINT, *ENDING}:
        signal.signal(number, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, end_program)


def progress_bar(total: int | None, unit: str) -> Any:
    """Count and remaining time on a terminal, of work that takes longer than two seconds, by tqdm."""
    needed("tools", "tqdm")
    from tqdm import tqdm

    return tqdm(total=total, unit=unit, delay=2.0, disable=None, leave=False)


def replace_file(path: Path, content: str | bytes) -> None:
    """Write a file; one that is there is replaced when the new one is complete, as on a full disk."""
    data = content.encode("utf-8") if isinstance(content, str) else content
    target = path.resolve()
    part = target.with_name(f".{target.name}.{os.getpid()}")
    try:
        if target.exists() and not target.is_file():
            target.write_bytes(data)
            return
        part.write_bytes(data)
        if target.exists():
            shutil.copymode(target, part)
        os.replace(part, target)
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(path)) from None
    finally:
        part.unlink(missing_ok=True)


def assigned(
    texts: Iterable[str], option: str = "", form: str = "NAME=VALUE, as sigma0=3.0", value: str = r"[-+.\w]+"
) -> dict[str, str]:
    """Values by name of NAME=VALUE entries; value: regular expression; option, form: for messages."""
    by_name: dict[str, str] = {}
    for text in texts:
        parts = re.fullmatch(rf"\s*([\w,]+)\s*=\s*({value})\s*", text)
        if not parts:
            raise ValueError(f"{option} {text}: expected {form}".strip())
        if parts[1] in by_name:
            raise ValueError(f"{option} {text}: {parts[1]} is given twice: expected one value".strip())
        by_name[parts[1]] = parts[2]
    return by_name


def numbers(option: str, texts: Iterable[str], count: int) -> dict[str, list[float]]:
    """Numbers of the NAME=VALUE or NAME=LOW,HIGH entries of an option, separated by blanks."""
    form, lists = "NAME=VALUE" if count == 1 else "NAME=LOW,HIGH", {}
    texts_by_name = assigned((entry for several in texts for entry in several.split()), option, form, "[^=]*")
    for name, text in texts_by_name.items():
        try:
            lists[name] = [float(plain(value)) for value in text.split(",")]
        except ValueError:
            kind = "a number" if count == 1 else "two numbers"
            raise ValueError(f"{option} {name}={text}: expected {form}, {kind}") from None
        if len(lists[name]) != count:
            raise ValueError(f"{option} {name}={text}: expected {form}")
    return lists


def units_of(text: str) -> tuple[str, str]:
    """Units of length and stress of the option --label-units."""
    length, comma, stress = text.partition(",")
    if not comma or "," in stress:
        raise ValueError(f"--label-units {text}: expected LENGTH,STRESS")
    return length, stress


def check_picture(path: Path, option: str = "") -> None:
    """Raise ValueError unless the name of a picture ends in .png or .pdf."""
    if path.suffix not in (".png", ".pdf"):
        raise ValueError(f"{option}{path}: expected a name that ends in .png or .pdf")


def check_outputs(
    force: bool, read: Iterable[Path | None], *written: tuple[str, Path | None] | tuple[str, Path | None, str]
) -> None:
    """Raise ValueError, before the work starts, for outputs that cannot be written or replace other files.

    A file that is there is replaced if the command wrote it itself, or with `force`; what is read never is.
    written: option, file and, unless it is a picture, a regular expression for the start of what the command
    writes there; without one the file must be a new one.  Those of --plot are pictures.
    """
    taken = [path.resolve() for path in read if path is not None]
    for option, path, *start in written:
        if path is None:
            continue
        if option == "--plot":
            check_picture(path, "--plot ")
        if not path.parent.is_dir():
            raise ValueError(f"{option} {path}: no folder {path.parent}: expected one that is there")
        if path.is_dir() or not os.access(path if path.exists() else path.parent, os.W_OK):
            raise ValueError(f"{option} {path}: expected a file that can be written")
        if path.resolve() in taken:
            raise ValueError(
                f"{option} {path}: this file is read or written by the same command: expected another name"
            )
        own_start = start[0] if start else PICTURES.get(path.suffix)
        if not (force or may_replace(path, own_start)):
            raise ValueError(
                f"{option} {path}: this file is there and is not replaced: expected another name, or --force"
            )
        taken.append(path.resolve())


PICTURES = {
    ".png": "\x89PNG.{,200}Software\0asperity",
    ".pdf": r"%PDF.*/Creator \(asperity\)",
}
"""Starts of the pictures that this package writes, by ending."""


def may_replace(path: Path, start: str | None) -> bool:
    """Whether a file is new, empty, a device, or begins as the command begins it (regular expression)."""
    if not path.is_file() or path.stat().st_size == 0:
        return True
    return bool(start) and bool(re.match(start or "", path.read_bytes().decode("latin-1"), re.DOTALL))


def results_of(output: Path) -> dict[float | None, Path]:
    """Result files of a run by the value of the sweep, in ascending order; None without a sweep."""
    single: dict[float | None, Path] = {None: output} if output.is_file() else {}
    values = {}
    # as in the driver, only the ending .csv is removed before the value is appended
    stem = output.name.removesuffix(".csv")
    for path in output.parent.glob(f"{glob.escape(stem)}_*.csv"):
        try:
            values[float(path.stem.removeprefix(stem + "_"))] = path
        except ValueError:
            continue
    return single | dict(sorted(values.items()))
