"""Material of the planes."""

from __future__ import annotations

from dataclasses import asdict, dataclass, make_dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from . import contract


class ModelWarning(UserWarning):
    """The input is admissible, but leaves the ground the model stands on."""


def _field(row: contract.Prop) -> tuple[str, type] | tuple[str, type, float]:
    """Name, type and default of a constant of the law; one that is 0 or 1 is a truth value."""
    kind = bool if row.integral and row.upper == 1.0 else float
    return (row.name, kind) if row.default is None else (row.name, kind, kind(row.default))


_Constants: Any = make_dataclass("_Constants", map(_field, contract.owned("law")), frozen=True)


@dataclass(frozen=True)
class Material(_Constants):
    """Material of the planes (Section 2.2): the constants of PROPS that belong to the law.

    Raises ValueError naming every value out of range.  The constants, in their order:
    """

    if TYPE_CHECKING:

        def __init__(self, sigma0: float, Gc: float, eta: float, mu: float, **others: float) -> None:
            """All of them: the four that have no default, and others by name."""

    def __post_init__(self) -> None:
        """Check the ranges."""
        contract.check(contract.pack(self.values()))

    def values(self) -> dict[str, float]:
        """Entries of PROPS that belong to the material, by name."""
        return asdict(self)

    @property
    def wears(self) -> bool:
        """Whether the facets wear: a state then holds two values more for each plane."""
        return self.W0 > 0.0

    @property
    def s_f(self) -> float:
        """Separation at complete rupture in mode I, 2 Gc/sigma0 (12), length."""
        return 2.0 * self.Gc / self.sigma0

    @property
    def s_0(self) -> float:
        """Separation at the onset of damage in mode I, (1 - eta) s_f (12), length."""
        return (1.0 - self.eta) * self.s_f

    @property
    def K(self) -> float:
        """Stiffness of the undamaged bond in mode I, sigma0/s_0 (12), stress/length."""
        return self.sigma0 / self.s_0

    def residual_strength(self, theta: ArrayLike, phi: ArrayLike = 0.0) -> contract.Floats:
        """Strength over |sigma_N| of the fully damaged interface that slides up a plane; inf where it locks.

        theta: inclination of the plane; phi: angle between the slip and its line of steepest ascent; degrees
        (docs/theory.md, section 8).  At phi = 0: (mu + tan theta)/(1 - mu tan theta).
        """
        angle, c = np.radians(theta), np.cos(np.radians(phi))
        slope = np.tan(angle) * c
        w = np.sqrt(1.0 + slope**2)
        below = np.cos(angle) - self.mu * slope / w
        locked = np.full(np.shape(below), np.inf)
        return np.divide(np.sin(angle) * c + self.mu / w, below, out=locked, where=below > 0.0)[()]


Material.__doc__ = f"{Material.__doc__}\n" + "".join(
    f"    {row.name} [{row.unit}]: {row.meaning}; {row.admissible}\n" for row in contract.owned("law")
)
