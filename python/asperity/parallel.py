"""Independent computations in order, on any executor of concurrent.futures."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from concurrent.futures import BrokenExecutor, Executor, ThreadPoolExecutor
from multiprocessing import parent_process
from threading import current_thread, main_thread
from typing import TypeVar

Item = TypeVar("Item")
Value = TypeVar("Value")


def map_in_order(
    function: Callable[[Item], Value],
    items: Iterable[Item],
    executor: Executor | None = None,
    progress: Callable[[], object] = lambda: None,
) -> list[Value]:
    """Values of a function in the order of the items, whatever the executor and the order of its work.

    executor: of concurrent.futures; where it has other processes, function and items must be picklable.
    Without one the calls run in threads, one for each processor, and within a worker one after the other.
    progress: called in this thread after each call.  Raises the exception of the first item that has one,
    and OSError where a process is lost.
    """
    if executor is None:
        in_worker = parent_process() is not None or current_thread() is not main_thread()
        with ThreadPoolExecutor(1 if in_worker else os.cpu_count()) as threads:
            return map_in_order(function, items, threads, progress)
    results = []
    try:
        for value in executor.map(function, items):  # cancels the others after an exception
            results.append(value)
            progress()
    except BrokenExecutor as error:
        wanted = "expected enough memory for every process; --jobs 1 needs least"
        raise OSError(f"a process was lost: {wanted} ({error})") from error
    return results
