"""Independent computations in order, on any executor of concurrent.futures."""

from __future__ import annotations

import argparse
import os
import signal
import threading
from collections.abc import Callable, Iterable
from concurrent.futures import BrokenExecutor, Executor, Future, ThreadPoolExecutor, as_completed
from contextlib import AbstractContextManager, nullcontext
from typing import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:
    from tqdm import tqdm

Item = TypeVar("Item")
Value = TypeVar("Value")

PATIENCE = 2.0
"""Seconds before progress is shown."""

_task = threading.local()
"""Its `runs` is set within a call of a worker, whose own loops then need no threads."""


def map_in_order(
    function: Callable[[Item], Value],
    items: Iterable[Item],
    executor: Executor | None = None,
    progress: Callable[[], object] = lambda: None,
) -> list[Value]:
    """Values of a function in the order of the items, whatever the executor and the order of its work.

    executor: of concurrent.futures; where it has other processes, function and items must be picklable.
    Without one the calls run in threads, one for each processor, and within a call of another
    `map_in_order` one after the other.  progress: called in this thread after each call.  Raises the
    exception of the first item that has one, and OSError where a process is lost.
    """
    todo = list(items)
    if executor is None:
        count = 1 if getattr(_task, "runs", False) else min(os.cpu_count() or 1, len(todo))
        if count > 1:
            with ThreadPoolExecutor(count) as threads:
                return map_in_order(function, todo, threads, progress)
        return [(function(item), progress())[0] for item in todo]
    futures: list[Future[Value]] = []
    try:
        futures.extend(executor.submit(_call, function, item) for item in todo)
        for future in as_completed(futures):
            if future.exception() is not None:
                break
            progress()
        return [future.result() for future in futures]
    except BrokenExecutor as error:
        wanted = "expected enough memory for every process; --jobs 1 needs least"
        raise OSError(f"a process was lost: {wanted} ({error})") from error
    finally:
        for future in futures:
            future.cancel()


def _call(function: Callable[[Item], Value], item: Item) -> Value:
    """Value of a function, computed by a worker."""
    before, _task.runs = getattr(_task, "runs", False), True
    try:
        return function(item)
    finally:
        _task.runs = before


def add_workers(parser: argparse.ArgumentParser, default: str) -> None:
    """Add the option --jobs; default: what is used without it, for the help."""
    parser.add_argument("--jobs", type=int, metavar="N", help=f"number of processes (default: {default})")


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

    # A copy of this process by fork would have the locks of its threads, but not the threads. Ctrl-C reaches
    # all processes; this one ends the others.
    ignore = (signal.SIGINT, signal.SIG_IGN)
    return ProcessPoolExecutor(count, get_context("spawn"), initializer=signal.signal, initargs=ignore)


def progress_bar(total: int | None, unit: str) -> tqdm:
    """Count and remaining time on a terminal, of work that takes longer than PATIENCE."""
    from tqdm import tqdm

    return tqdm(total=total, unit=unit, delay=PATIENCE, disable=None, leave=False)
