"""What commands have in common: tables of arguments, --jobs, --units, names of pictures, a progress bar."""

from __future__ import annotations

import argparse
import os
import signal
from concurrent.futures import Executor, ThreadPoolExecutor
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from typing import Any


def add_options(parser: argparse._ActionsContainer, *rows: tuple[Any, ...]) -> None:
    """Add arguments to a parser, a row for each: usage, help, and unless it is a flag its type or default.

    usage: its names and that of its value, as "-o --output FILE" or "case CASE.nml".  The type is that of the
    default, which stands in the help; list: the option may be repeated.  A fourth entry are further settings
    of argparse, by name.
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
        parser.add_argument(*names, help=text, **settings | (more[1] if len(more) > 1 else {}))


def add_workers(parser: argparse.ArgumentParser, default: str) -> None:
    """Add the option --jobs; default: what is used without it, for the help."""
    add_options(parser, ("--jobs N", f"number of processes (default: {default})", int))


def workers(options: argparse.Namespace, jobs: int | None = None) -> AbstractContextManager[Executor | None]:
    """Executor with as many processes as --jobs asks for; otherwise with `jobs`, or None: threads."""
    count, most = jobs if options.jobs is None else options.jobs, os.cpu_count() or 1
    if count is None:
        return nullcontext()
    if not 1 <= count <= most:
        raise ValueError(f"--jobs {count}: expected 1 to {most}, the number of processors")
    if count == 1:
        return ThreadPoolExecutor(1)
    from concurrent.futures import ProcessPoolExecutor
    from multiprocessing import get_context

    # A fork would copy the locks of threads, but not the threads. On Ctrl-C this process ends the others.
    ignore = (signal.SIGINT, signal.SIG_IGN)
    return ProcessPoolExecutor(count, get_context("spawn"), initializer=signal.signal, initargs=ignore)


def progress_bar(total: int | None, unit: str) -> Any:
    """Count and remaining time on a terminal, of work that takes longer than two seconds, by tqdm."""
    from tqdm import tqdm

    return tqdm(total=total, unit=unit, delay=2.0, disable=None, leave=False)


def units_of(text: str) -> tuple[str, str]:
    """Units of length and stress of the option --units."""
    length, comma, stress = text.partition(",")
    if not comma or "," in stress:
        raise ValueError(f"--units {text}: expected LENGTH,STRESS")
    return length, stress


def check_picture(path: Path) -> None:
    """Raise ValueError unless the name of a picture ends in .png or .pdf."""
    if path.suffix not in (".png", ".pdf"):
        raise ValueError(f"{path}: expected a name that ends in .png or .pdf")
