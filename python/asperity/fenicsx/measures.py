"""What an engineer asks of a joint: how far it is cracked, open and sliding, and what it carries."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .. import contract
from ..contract import Floats
from .model import Model
from .ranks import COMM, expect, largest, totals
from .state import State

DAMAGED = 1.0 - 1e-9
"""Damage from which a point counts as cracked."""


@dataclass(frozen=True)
class Measures:
    """A joint on all ranks; areas are lengths times the thickness in two dimensions.

    area; cracked: area that is fully damaged; open: of it, that without pressure between the sides.  opening,
    slip: the largest.  sliding: share of the pressed area where friction has spent energy in the last step.
    normal: force that presses the sides on each other, without the water; shear (3,): force in their planes
    by the axes Tx and Ty, the first component is 0.  place (d,): where the normal force acts.
    against_sliding: friction mu of that force over the shear force; bond and planes carry more.
    against_overturning: distance of the edge over that of the normal force from the middle of the joint, for
    a plane joint; 1: it stands on its edge.
    """

    area: float
    cracked: float
    open: float
    opening: float
    slip: float
    sliding: float
    normal: float
    shear: Floats
    place: Floats
    against_sliding: float
    against_overturning: float


def measure(model: Model, name: str, state: State, before: State | None = None) -> Measures:
    """Measure a joint in a state; before: of the step before, for the share that slides.

    Raises ValueError on all ranks for wrong input, by its name.
    """
    expect(Model, model=model)
    expect(str, name=name)
    for key, given in {"state": state, "before": state if before is None else before}.items():
        expect(State, **{key: given})
        given.check(model)
    if name not in model.joints:
        raise ValueError(f"{name}: no such joint: expected one of {', '.join(model.joints)}")
    if model.axisymmetric:
        raise ValueError("resultants of a body of revolution: expected a plane mesh, or one in space")
    k = model.joints.index(name)
    part, law = model.parts[k], model.laws[k]
    area, x, s = model.area[part], model.places[part], state.s[part]
    effective = state.t[part] + np.outer(state.p[part], [1.0, 0.0, 0.0])
    cracked, pressed = state.joints[k][:, 0] >= DAMAGED, effective[:, 0] < 0.0
    friction = contract.statev_index("friction")
    slides = np.zeros(len(area), bool)
    if before is not None:
        slides = pressed & (state.joints[k][:, friction] > before.joints[k][:, friction])
    forces = np.where(pressed, -effective[:, 0], 0.0) * area
    total_area, broken, apart, held, moving, normal, *rest = totals(
        area.sum(), area @ cracked, area @ (cracked & ~pressed), area @ pressed, area @ slides, forces.sum(),
        *(area @ x), *(forces @ x), *(area @ effective[:, 1:]),
    )  # fmt: skip
    d = model.d
    middle, place = np.array(rest[:d]) / (total_area or 1.0), np.array(rest[d : 2 * d]) / (normal or np.nan)
    shear, away = np.r_[0.0, rest[2 * d :]], place - middle
    distance, resisted = float(np.linalg.norm(away)), float(np.linalg.norm(shear))
    edge = 0.0
    if distance > 0.0:
        along = (x - middle)[area > 0.0] @ (away / distance)
        edge = max(COMM.allgather(float(along.max(initial=0.0))))
    return Measures(
        total_area,
        broken,
        apart,
        largest(np.maximum(s[:, 0], 0.0)),
        largest(np.linalg.norm(s[:, 1:], axis=1)),
        moving / held if held else 0.0,
        normal,
        shear,
        place,
        law.material.mu * normal / resisted if resisted else np.inf,
        edge / distance if distance > 0.0 else np.inf,
    )
