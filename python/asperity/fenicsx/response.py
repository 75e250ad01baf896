"""The laws of all points of the joints at once, without the checks of `Interface.update` at every call."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from .. import _core, calls, contract
from ..contract import Floats
from .model import Model
from .ranks import COMM


class LawError(RuntimeError):
    """The law has no result for a separation."""


class Start(Protocol):
    """What the law needs of the start of an increment."""

    @property
    def s(self) -> Floats:
        """Separations."""

    @property
    def joints(self) -> tuple[Floats, ...]:
        """States by law."""


@dataclass(frozen=True)
class Response:
    """Total tractions t (p, 3), tangents D (p, 3, 3) and states by law at the end of an increment."""

    t: Floats
    D: Floats
    joints: tuple[Floats, ...]


def damages(model: Model, joints: tuple[Floats, ...]) -> Floats:
    """Damages of the planes of all points here, in one row, of states by law."""
    first, step = contract.N_POINT_STATEV, contract.N_PLANE_STATEV
    rows = zip(model.laws, joints, strict=True)
    by_law = (states[:, first : first + step * law.n_planes : step].ravel() for law, states in rows)
    return np.concatenate([np.zeros(0), *by_law])


@dataclass
class Clock:
    """Processor seconds and calls of the law."""

    seconds: float = 0.0
    calls: int = 0


def respond(
    model: Model,
    start: Start,
    s: Floats,
    dt: float,
    p: Floats,
    aim: Floats | None = None,
    clock: Clock | None = None,
    iterate: bool = False,
) -> Response:
    """Take all points from a start to separations s (p, 3) under pressures p (p,), as `Interface.update`.

    aim (p, 3): separations whose damage, friction bounds and slopes the law then has.  iterate: without the
    dissipated energies, which are NaN in the states and take most of the time of a long increment.  Raises
    LawError on all ranks where a point of one of them has no result.
    """
    begin, message, text = time.process_time(), calls.message_room(), ""
    t, D = np.empty((len(s), 3)), np.empty((len(s), 3, 3))
    law = _core.asperity_iterate if iterate else _core.asperity_update
    joints = tuple(states.copy() for states in start.joints)
    at, wet = s if aim is None else aim, bool(p.any())
    for props, part, new in zip(model.props, model.parts, joints, strict=True):
        if part.stop > part.start and law(
            props, dt, start.s[part], s[part], aim is not None, at[part], wet, p[part], new, t[part], D[part],
            message,
        ):  # fmt: skip
            text = calls.text_of(message)
            break
    if clock:
        clock.seconds += time.process_time() - begin
        clock.calls += 1
    if worst := (text if COMM.size == 1 else max(COMM.allgather(text))):
        raise LawError(worst)
    return Response(t, D, joints)
