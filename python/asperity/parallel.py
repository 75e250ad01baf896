"""Independent computations on any executor of concurrent.futures: threads, processes, a Dask cluster."""

from __future__ import annotations

import argparse
import os
import re
import signal
import threading
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import (
    BrokenExecutor,
    CancelledError,
    Executor,
    Future,
    ThreadPoolExecutor,
    as_completed,
)
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, TypeVar

if TYPE_CHECKING:
    from concurrent.futures import ProcessPoolExecutor

    from tqdm import tqdm

Item = TypeVar("Item")
Value = TypeVar("Value")

PATIENCE = 2.0
"""Seconds before progress is shown."""

MOST_LOSSES = 3
"""Number of times that the work of lost processes is given to others, as on a Dask cluster."""

CONNECTING = 10.0
"""Seconds in which a scheduler must answer."""


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
    exception of the first item that has one, and OSError where workers are lost again and again.
    """
    todo = list(items)
    if executor is None:
        threads = 1 if getattr(_here, "inside", False) else min(os.cpu_count() or 1, len(todo))
        if threads > 1:
            with ThreadPoolExecutor(threads) as pool:
                return map_in_order(function, todo, pool, progress)
        values = []
        for item in todo:
            values.append(function(item))
            progress()
        return values
    found: dict[int, Value] = {}
    counted = 0
    for _ in range(MOST_LOSSES + 1):
        futures: list[Future[Value]] = []
        places: list[int] = []
        loss: Exception | None = None
        try:
            for place, item in enumerate(todo):
                if place not in found:
                    futures.append(executor.submit(_call, function, item))
                    places.append(place)
            for future in as_completed(futures):
                if future.exception() is not None:
                    break
                counted += 1
                progress()
            # in the order of the items, so that the first error of these is raised
            for place, future in zip(places, futures, strict=True):
                try:
                    found[place] = future.result()
                except BrokenExecutor as error:
                    loss = error
        except BrokenExecutor as error:
            loss = error
        finally:
            for future in futures:
                future.cancel()
        for _ in range(len(found) - counted):
            counted += 1
            progress()
        if loss is None:
            return [found[place] for place in range(len(todo))]
    raise OSError(
        f"processes were lost {MOST_LOSSES + 1} times, {len(found)} of {len(todo)} results are there: "
        "expected enough memory for every process; --jobs 1 needs least"
    ) from loss


_here = threading.local()
"""Whether this thread is inside a call of `map_in_order`, whose own loops then need no threads."""


def _call(function: Callable[[Item], Value], item: Item) -> Value:
    """Value of a function, computed by a worker."""
    before = getattr(_here, "inside", False)
    _here.inside = True
    try:
        return function(item)
    finally:
        _here.inside = before


class Serial(Executor):
    """No other processes or threads: a call is made at once."""

    def submit(self, function: Callable[..., Value], /, *arguments: Any, **named: Any) -> Future[Value]:
        """Future of a call, which is done."""
        future: Future[Value] = Future()
        try:
            future.set_result(function(*arguments, **named))
        except Exception as error:
            future.set_exception(error)
        return future


class Processes(Executor):
    """Processes of this machine; where one is lost, its pool is replaced at the next call of `submit`."""

    def __init__(self, count: int) -> None:
        """Number of processes."""
        self.count = count
        self._pool: ProcessPoolExecutor | None = None

    def submit(self, function: Callable[..., Value], /, *arguments: Any, **named: Any) -> Future[Value]:
        """Future of a call."""
        if self._pool is not None:
            try:
                return self._pool.submit(function, *arguments, **named)
            except BrokenExecutor:
                self.shutdown()
        import multiprocessing
        from concurrent.futures import ProcessPoolExecutor

        # A copy of this process by fork would have the locks of its threads, but not the threads. Ctrl-C
        # reaches all processes; this one ends the others.
        self._pool = ProcessPoolExecutor(
            self.count,
            multiprocessing.get_context("spawn"),
            initializer=signal.signal,
            initargs=(signal.SIGINT, signal.SIG_IGN),
        )
        return self._pool.submit(function, *arguments, **named)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """End the processes."""
        pool, self._pool = self._pool, None
        if pool is not None:
            pool.shutdown(wait, cancel_futures=cancel_futures)


def add_workers(parser: argparse.ArgumentParser, default: str) -> None:
    """Add the options --jobs and --scheduler; default: what is used without them, for the help."""
    where = parser.add_mutually_exclusive_group()
    where.add_argument(
        "--jobs", type=int, metavar="N", help=f"number of processes on this machine (default: {default})"
    )
    where.add_argument(
        "--scheduler", metavar="tcp://HOST:PORT", help="scheduler of a Dask cluster that does the work"
    )


@contextmanager
def workers(options: argparse.Namespace, jobs: int | None = None) -> Iterator[Executor | None]:
    """Executor that --jobs or --scheduler asks for; otherwise `jobs` processes, or None: threads."""
    if options.scheduler is not None:
        with cluster(options.scheduler) as executor:
            yield executor
        return
    count = jobs if options.jobs is None else options.jobs
    if count is None:
        yield None
        return
    if count < 1:
        raise ValueError(f"--jobs {count}: expected at least 1")
    executor = Serial() if count == 1 else Processes(count)
    try:
        yield executor
    finally:
        executor.shutdown(cancel_futures=True)


@contextmanager
def cluster(address: str) -> Iterator[Executor]:
    """Executor of a Dask cluster, which gives the work of a lost worker to the others.

    Raises ValueError where dask.distributed is not installed here or the workers have another version of
    asperity, and OSError where there is no scheduler or too many workers are lost.
    """
    try:
        from distributed import Client, KilledWorker
    except ImportError:
        raise ValueError(
            f"--scheduler {address}: expected dask.distributed: pip install 'asperity[dask]'"
        ) from None
    from . import contract

    # distributed itself needs 20 seconds and a traceback to refuse another text
    parts = re.fullmatch(r"(?:(?:tcp|tls|ws|wss|ucx)://)?[^/\s]+:(\d{1,5})", address)
    if parts is None or not 0 < int(parts[1]) < 65536:
        raise ValueError(f"--scheduler {address}: expected the address of a Dask scheduler, tcp://HOST:PORT")
    try:
        client = Client(address, timeout=CONNECTING, set_as_default=False)
    except (OSError, ValueError) as error:
        raise OSError(f"--scheduler {address}: expected the address of a Dask scheduler ({error})") from None
    try:
        mine = contract.library_version()
        for worker, found in client.run(_version, on_error="return").items():
            if found != mine:
                raise ValueError(
                    f"--scheduler {address}: worker {worker}: {found}: expected asperity {mine} there"
                )
        with client.get_executor(pure=False) as executor:
            yield executor
    except (KilledWorker, CancelledError) as error:
        raise OSError(f"--scheduler {address}: {error or 'the scheduler was lost'}") from None
    finally:
        client.close()


def _version() -> str:
    """Version of the library of a worker."""
    from .contract import library_version

    return library_version()


@contextmanager
def progress_bar(total: int | None, unit: str) -> Iterator[tqdm]:
    """Count and remaining time on a terminal, of work that takes longer than PATIENCE."""
    from tqdm import tqdm

    bar = tqdm(total=total, unit=unit, delay=PATIENCE, disable=None, leave=False)
    try:
        yield bar
    finally:
        bar.close()
