"""Arrays of points that `Interface` takes and fills."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from . import contract
from .contract import Floats
from .material import Material


def check_given(name: str, value: object, material: Material) -> None:
    """Raise ValueError for a time that is None although viscous damage or a dashpot needs one."""
    if value is None and material.tau_v > 0.0:
        raise ValueError(f"{name} is missing: expected for viscous damage, tau_v = {material.tau_v:g}")
    if value is None and material.c > 0.0:
        raise ValueError(f"{name} is missing: expected for a dashpot, c = {material.c:g}")


def times_of(times: ArrayLike | None, rows: int, material: Material) -> Floats:
    """Times (rows,), zeros if none are given."""
    check_given("times", times, material)
    if times is None:
        return np.zeros(rows)
    array = contract.array("times", times, (rows,))
    before = np.append(0.0, array)[:-1]
    for i in np.flatnonzero(~(np.isfinite(array) & (array >= before)))[:1]:
        raise ValueError(
            f"times[{i}] = {array[i]:g}: expected a finite number from {before[i]:g}, the time before, on"
        )
    return array


def pressures(p: ArrayLike, n: int) -> Floats:
    """Water pressures (n,) of one or n values; raises ValueError for one that is negative or not finite."""
    p_of_points = contract.array("p", p, (), (n,))
    good = np.atleast_1d(np.isfinite(p_of_points) & (p_of_points >= 0.0))
    if not good.all():
        k = int(np.argmin(good))
        place = f"p[{k}]" if p_of_points.ndim else "p"
        raise ValueError(
            f"{place} = {np.atleast_1d(p_of_points)[k]:g}: expected a finite water pressure >= 0"
        )
    return np.broadcast_to(p_of_points, (n,))


def outputs(
    out: Sequence[Floats], shapes: Sequence[tuple[int, ...]], inputs: dict[str, Floats | None]
) -> Sequence[Floats]:
    """Arrays for traction, state and tangent; raises ValueError for one that cannot be written to."""
    if not isinstance(out, Sequence) or len(out) != len(shapes):
        found = f"has {len(out)} entries" if isinstance(out, Sequence) else f"= {contract.shown(out)}"
        raise ValueError(f"out {found}: expected traction, state and tangent")
    taken = dict(inputs)
    for i, (array, shape) in enumerate(zip(out, shapes, strict=True)):
        name = f"out[{i}]"
        if not isinstance(array, np.ndarray) or array.dtype != np.float64 or not array.flags.carray:
            found = f"a {array.dtype} array" if isinstance(array, np.ndarray) else contract.shown(array)
            raise ValueError(f"{name} is {found}: expected writable float64, contiguous in C order")
        contract.array(name, array, shape)
        for earlier, values in taken.items():
            in_place = i == 1 and earlier == "state" and values is array
            # exact for contiguous arrays
            if not in_place and values is not None and np.may_share_memory(values, array):
                raise ValueError(f"{name} overlaps {earlier}: expected memory of its own")
        taken[name] = array
    return out
