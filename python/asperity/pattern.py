"""Patterns of planes (the representative interface element)."""

from __future__ import annotations

import numbers
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from . import _core, contract

_ANY_MATERIAL = {"sigma0": 1.0, "Gc": 1.0, "eta": 0.5, "mu": 0.0}
"""Admissible constants, with which the library can check a pattern alone."""

ACROSS = 1.0  # a plane faces across a slip if its azimuth is within so many degrees of a right angle to it


def direction_vector(direction: ArrayLike) -> contract.Floats:
    """Unit vectors (Tx, Ty), shape (..., 2), of directions in degrees, shape (...), from Tx towards Ty."""
    return unit_vector(np.radians(direction))


def unit_vector(angle: ArrayLike) -> contract.Floats:
    """Unit vectors (Tx, Ty), shape (..., 2), at angles in radians, shape (...), from Tx towards Ty."""
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)


@dataclass(frozen=True)
class Pattern:
    """Planes of the representative interface element; build one with `Pattern.regular` or `Pattern.planes`.

    m, theta, flat and turn are PROPS 6, 5, 7 and 8 (angles in degrees); listed holds (n_N, n_Tx, n_Ty,
    gamma) of every plane of a free list, as given.
    """

    m: int
    theta: float = contract.default("theta")
    flat: float = contract.default("flat")
    turn: float = contract.default("turn")
    listed: tuple[tuple[float, ...], ...] = ()

    def __post_init__(self) -> None:
        """Check the ranges."""
        if not isinstance(self.m, numbers.Real):
            text = "expected a number of planes; Pattern.planes(normals, weights) takes a list"
            raise ValueError(f"m = {contract.shown(self.m)}: {text}")
        if (self.listed or self.m < 0) and self.m != -len(self.listed):
            k = len(self.listed)
            raise ValueError(f"m = {contract.shown(self.m)}: expected {-k} for {k} listed planes")
        contract.check(contract.pack(_ANY_MATERIAL | self.values(), self.constants()))

    @classmethod
    def regular(
        cls,
        sides: int,
        theta: float,
        flat: float = contract.default("flat"),
        turn: float = contract.default("turn"),
    ) -> Pattern:
        """Regular pattern (41)-(43): `sides` equal inclined planes and a flat plane of the weight `flat`.

        theta: inclination; turn: rotation about N; both in degrees. sides = 0 gives the flat interface. RT of
        Table 4 is regular(2, theta), RP-m is regular(m, theta), the five planes of Table 3 are regular(4,
        theta, flat=1/5). Raises ValueError for a value out of range.
        """
        if not isinstance(sides, numbers.Real) or sides not in (0, *range(2, contract.MAX_INCLINED + 1)):
            raise ValueError(f"sides = {contract.shown(sides)}: expected 0 or 2 to {contract.MAX_INCLINED}")
        return cls(sides, theta, flat, turn)

    @classmethod
    def planes(cls, normals: ArrayLike, weights: ArrayLike) -> Pattern:
        """Pattern of listed planes: normals (k, 3) of any length, n_N > 0, and weights (k,) that sum to 1.

        Raises ValueError for wrong shapes and for values out of range.
        """
        gamma = contract.array("weights", weights)
        if gamma.ndim != 1 or not 1 <= gamma.size <= contract.MAX_INCLINED:
            expected = f"(k,) with k = 1 to {contract.MAX_INCLINED}"
            raise ValueError(f"weights has shape {gamma.shape}: expected {expected}")
        n = contract.array("normals", normals, (gamma.size, 3))
        return cls(-gamma.size, listed=tuple(map(tuple, np.column_stack([n, gamma]).tolist())))

    @property
    def normals(self) -> contract.Floats:
        """Unit normals (N, Tx, Ty) of the planes, (Np, 3), the flat plane first; read-only."""
        return self._planes[0]

    @property
    def weights(self) -> contract.Floats:
        """Weights gamma of the planes, (Np,); read-only."""
        return self._planes[1]

    def across(self, direction: float) -> list[int]:
        """Numbers, from 1, of the planes that face across a slip along a direction in degrees from Tx."""
        n_T = self.normals[:, 1:]
        away = np.abs(n_T @ direction_vector(direction)) / np.maximum(np.hypot(*n_T.T), 1e-300)
        inclined = np.hypot(*n_T.T) > 0.0
        return (1 + np.flatnonzero(inclined & (away < np.sin(np.radians(ACROSS))))).tolist()

    def turned_from(self, direction: float) -> Pattern:
        """This regular pattern, turned so that the planes are farthest from facing across a slip."""
        # angle between the lines along which planes face
        between = (360.0 if self.m % 2 == 0 else 180.0) / self.m
        return replace(self, turn=(direction + 90.0 + between / 2.0) % between)

    def values(self) -> dict[str, float]:
        """Entries of PROPS that belong to the pattern, by name."""
        return {row.name: getattr(self, row.name) for row in contract.owned("pattern")}

    def constants(self) -> list[float]:
        """Values of the listed planes, which follow the entries that have a name."""
        return [value for plane in self.listed for value in plane]

    @cached_property
    def _planes(self) -> tuple[contract.Floats, contract.Floats]:
        props = contract.pack(_ANY_MATERIAL | self.values(), self.constants())
        n = contract.check(props)[0]
        normals, weights = np.empty((n, 3)), np.empty(n)
        _core.asperity_planes(props, normals, weights)
        for array in (normals, weights):
            array.flags.writeable = False
        return normals, weights
