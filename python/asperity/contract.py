"""What callers may rely on: PROPS and STATEV by index, name, unit, range, default, from the library."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from . import _core

Floats = NDArray[np.float64]

(N_FIXED_PROPS, N_REQUIRED_PROPS, N_LISTED_VALUES, N_POINT_STATEV, N_PLANE_STATEV, MAX_INCLINED) = (
    _core.contract_sizes()
)
"""Constants before the listed planes, without a default, of a listed plane; state variables of a point, of a
plane; most inclined planes."""


@dataclass(frozen=True)
class Prop:
    """One entry of PROPS; index counts from 1, default is None where a value is required."""

    index: int
    name: str
    meaning: str
    unit: str
    admissible: str
    default: float | None


@dataclass(frozen=True)
class Statev:
    """One state variable; index counts from 1, that of a plane is the one in the first plane."""

    index: int
    name: str
    meaning: str
    unit: str


def _text(value: bytes) -> str:
    return value.decode("ascii").rstrip()


def props_table() -> tuple[Prop, ...]:
    """Entries of PROPS before the listed planes, the reserved ones included, in their order."""
    rows = []
    for index in range(1, N_FIXED_PROPS + 1):
        name, meaning, unit, admissible, default = _core.contract_prop(index)
        texts = _text(name), _text(meaning), _text(unit), _text(admissible)
        rows.append(Prop(index, *texts, None if index <= N_REQUIRED_PROPS else default))
    return tuple(rows)


def statev_table() -> tuple[Statev, ...]:
    """State variables of a point, then those of the first plane, in their order."""
    return tuple(
        Statev(index, *map(_text, _core.contract_statev(index)))
        for index in range(1, N_POINT_STATEV + N_PLANE_STATEV + 1)
    )


def statev_names(n_planes: int) -> tuple[str, ...]:
    """Names of the columns of a state of n_planes planes: damage, ..., alpha_1, s_dit_1, s_dih_1, ..."""
    names = [row.name for row in statev_table()]
    planes = [f"{name}_{k}" for k in range(1, n_planes + 1) for name in names[N_POINT_STATEV:]]
    return tuple(names[:N_POINT_STATEV] + planes)


def n_statev(n_planes: int) -> int:
    """Number of state variables of a pattern of n_planes planes."""
    return N_POINT_STATEV + N_PLANE_STATEV * n_planes


_PROPS = {row.name: row for row in props_table() if row.name != "reserved"}


def index(name: str) -> int:
    """Position of an entry in a PROPS vector, from 0; raises KeyError for an unknown name."""
    return _PROPS[name].index - 1


def default(name: str) -> float:
    """Default of an entry of PROPS; raises KeyError for an unknown name, ValueError for a required one."""
    value = _PROPS[name].default
    if value is None:
        raise ValueError(f"{name} has no default")
    return value


def pack(values: dict[str, float], listed: Iterable[float] = ()) -> Floats:
    """Vector PROPS from values by name, the others at their default, and the values of the listed planes."""
    props = np.array([0.0 if row.default is None else row.default for row in props_table()])
    for name, value in values.items():
        props[index(name)] = value
    return np.concatenate([props, np.array(list(listed), dtype=float)])


def check(props: Floats) -> int:
    """Number of planes of a PROPS vector; raises ValueError naming every bad value and what was expected."""
    n_planes, status, message = _core.interface_review(props)
    if status != 0:
        raise ValueError(_text(message))
    return n_planes


def library_version() -> str:
    """Version compiled into the library."""
    return _text(_core.contract_version())
