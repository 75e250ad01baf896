"""Ranks of MPI, which share a mesh: sums, and errors that all of them have."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from types import TracebackType
from typing import TypeGuard, TypeVar

import numpy as np
from mpi4py import MPI  # loads the library of MPI that dolfinx needs
from numpy.typing import ArrayLike

from .. import contract
from ..contract import Floats

COMM = MPI.COMM_WORLD

T = TypeVar("T")


def _abort(kind: type[BaseException], error: BaseException, trace: TracebackType | None) -> None:
    """End all ranks where one has an error that nobody handles."""
    sys.__excepthook__(kind, error, trace)
    COMM.Abort(1)


if COMM.size > 1:
    sys.excepthook = _abort


def total(x: float | ArrayLike) -> float:
    """Sum over the ranks."""
    return float(COMM.allreduce(float(np.asarray(x))))


def totals(*x: float | ArrayLike) -> list[float]:
    """Sums over the ranks."""
    here = [float(np.asarray(value)) for value in x]
    return list(COMM.allreduce(np.array(here))) if COMM.size > 1 else here


def largest(values: ArrayLike) -> float:
    """Largest magnitude on all ranks, 0 of nothing."""
    return float(COMM.allreduce(float(np.abs(np.asarray(values)).max(initial=0.0)), MPI.MAX))


def agree(*messages: str, error: type[ValueError] = ValueError) -> None:
    """Raise an error on all ranks where one of them has a message that is not empty."""
    if worst := max(COMM.allgather(max(messages, default=""))):
        raise error(worst)


def called(function: Callable[..., T], *words: object) -> T:
    """Result of a function of a caller; where it raises a ValueError on one rank, all of them have one."""
    failed: ValueError | None = None
    results: list[T] = []
    try:
        results.append(function(*words))
    except ValueError as error:
        failed = error
    worst = max(COMM.allgather(str(failed) or type(failed).__name__ if failed else ""))
    if failed:
        raise failed
    if worst:
        raise ValueError(worst)
    return results[0]


def real(value: object) -> TypeGuard[float]:
    """Whether a value is a finite number; no bool, text, array or complex number is one."""
    if isinstance(value, bool) or not isinstance(value, float | int | np.floating | np.integer):
        return False
    try:
        return math.isfinite(value)
    except OverflowError:  # an integer that no double is as large as
        return False


def whole_number(value: object, least: int) -> bool:
    """Whether a value is a whole number, and at least so large."""
    return real(value) and not isinstance(value, float | np.floating) and int(value) >= least


def expect(kind: type, **values: object) -> None:
    """Raise ValueError on all ranks where one of the values, by its name, is of another type."""
    agree(
        *(
            f"{name} of the type {type(value).__name__}: expected {kind.__name__}"
            for name, value in values.items()
            if not isinstance(value, kind)
        )
    )


def doubles(name: str, value: ArrayLike) -> Floats:
    """Array of a value; ValueError on all ranks where one has no real numbers, such as bools and texts."""
    try:
        array, message = contract.array(name, value), ""
        if (kind := np.asarray(value).dtype).kind not in "iuf":
            message = f"{name} of the type {kind}: expected numbers"
    except ValueError as error:
        array, message = np.zeros(0), str(error)
    agree(message)
    return array
