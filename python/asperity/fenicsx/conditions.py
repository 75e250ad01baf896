"""What holds and loads a model at a value of a path: functions return it, and set nothing."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from ..contract import Floats
from ..mesh.shapes import Integers
from .model import Model
from .ranks import agree, doubles, expect
from .water import Flow, Pressure

__all__ = ["Conditions", "Flow", "Held", "Pressure", "held"]


@dataclass(frozen=True)
class Conditions:
    """Components that are prescribed, loads, and water.

    fixed: owned components, as of `Model.dofs`.  values: their displacements, one or one for each.  load:
    nodal forces (n d,), or 0.  pressures: of water by joint, on both of its sides, or by group of faces, at
    least 0; a number, or a function of places (n, d), in a joint also of places and openings (n,): the
    equilibrium is then repeated until p belongs to the openings.  Tractions of the joints are total: the law
    carries t_N + p.  flows: of water along joints.
    """

    fixed: Integers
    values: ArrayLike = 0.0
    load: ArrayLike = 0.0
    pressures: Mapping[str, Pressure] = field(default_factory=dict)
    flows: Sequence[Flow] = ()


@dataclass(frozen=True)
class Held:
    """Checked conditions: sorted components, their displacements, and loads (n d,)."""

    fixed: Integers
    values: Floats
    load: Floats


def _wrong(name: str, values: Floats, shape: tuple[int, ...], alone: str = "one") -> str:
    """What is wrong with values for some components, or nothing; alone: which number stands for all."""
    if values.shape not in ((), shape):
        return f"{name} of the shape {values.shape}: expected {alone} or {shape}, one for each on this rank"
    return "" if np.isfinite(values).all() else f"{name}: expected finite numbers"


def held(model: Model, conditions: Conditions) -> Held:
    """Check conditions; raises ValueError that names what is wrong."""
    size = model.n * model.d
    expect(Conditions, conditions=conditions)
    expect(Mapping, pressures=conditions.pressures)
    expect(Sequence, flows=conditions.flows)
    expect(Flow, **{f"flows[{k}]": flow for k, flow in enumerate(conditions.flows)})
    indices = np.asarray(conditions.fixed)
    kind = (
        ""
        if indices.ndim == 1 and (not len(indices) or indices.dtype.kind in "iu")
        else f"fixed of the type {indices.dtype} and the shape {indices.shape}: expected a row of indices"
    )
    agree(kind)
    indices = indices.astype(np.int64)
    values, load = doubles("values", conditions.values), doubles("load", conditions.load)
    low, high = indices.min(initial=0), indices.max(initial=0)
    agree(
        ""
        if 0 <= low and high < max(size, 1)
        else f"fixed {low} to {high}: expected components 0 to {size - 1}",
        _wrong("values", values, indices.shape),
        "" if load.shape or not load else f"load = {load:g} on every component: expected 0 or {(size,)}",
        _wrong("load", load, (size,), "0"),
    )  # fmt: skip
    fixed, first, back = np.unique(indices, return_index=True, return_inverse=True)
    all_values = np.broadcast_to(values, indices.shape)
    first_values = all_values[first]
    twice = np.flatnonzero(first_values[back] != all_values)
    agree(
        *(
            f"component {indices[k]}: prescribed as {first_values[back[k]]:g} and as {all_values[k]:g}"
            for k in twice[:1]
        )
    )
    return Held(fixed, first_values.copy(), np.broadcast_to(load, size).copy())
