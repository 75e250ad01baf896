"""Material of the planes."""

from __future__ import annotations

from dataclasses import dataclass, fields, make_dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from . import contract


class ModelWarning(UserWarning):
    """The input is admissible, but leaves the ground the model stands on."""


def _field(row: contract.Prop) -> tuple[str, type] | tuple[str, type, float]:
    """Name, type and default of a constant of the law; one that is 0 or 1 is a truth value."""
    kind = bool if row.integral and row.upper == 1.0 else float
    return (row.name, kind) if row.default is None else (row.name, kind, kind(row.default))


if TYPE_CHECKING:

    class _Constants:
        """Constants, whose names the library has."""

        def __getattr__(self, name: str) -> float: ...

else:
    _Constants = make_dataclass("_Constants", map(_field, contract.owned("law")), frozen=True)


@dataclass(frozen=True)
class Material(_Constants):
    """Material of the planes (Section 2.2): the constants of PROPS that belong to the law.

    Raises ValueError naming every value out of range.  The constants, in their order:
    """

    if TYPE_CHECKING:

        def __init__(self, sigma0: float, Gc: float, eta: float, mu: float, **others: float) -> None:
            """All of them: the four that have no default, and others by name."""

    def __post_init__(self) -> None:
        """Check the ranges; texts of numbers become numbers."""
        contract.check(contract.pack(self.values()))
        for name, value in self.values().items():
            if not isinstance(value, (int, float)):
                object.__setattr__(self, name, contract.number(name, value))

    @classmethod
    def from_joint(cls, kn: float, ks: float, mu: float, **others: float) -> Material:
        """Material of a joint without bond, such as a rock joint.

        kn, ks: stiffness in closing and in shear, stress/length, by a bond that gives the stiffness only:
        K = ks, kc = kn/ks.  mu: coefficient of friction.  others: further constants by name, such as the
        dashpot c = 2 xi sqrt(kn m) that damps the mass m per area by xi.  Raises ValueError
        naming every value out of range, and every constant that kn and ks give.

        Examples
        --------
        >>> joint = Material.from_joint(kn=20.0, ks=5.0, mu=0.6, height=0.2)
        >>> round(joint.K, 12), joint.kc
        (5.0, 4.0)
        """
        *of_bond, damage = contract.joint_constants(1.0, 1.0)
        text = "expected without kn and ks, which give sigma0, Gc, eta and kc"
        bad = [f"{name} = {contract.shown(others[name])}: {text}" for name in of_bond if name in others]
        if others.get(damage, 1.0) != 1.0:
            bad.append(f"{damage} = {contract.shown(others[damage])}: expected 1 for a joint without bond")
        others = {name: value for name, value in others.items() if name not in of_bond}
        try:
            cls(1.0, 1.0, 0.5, mu, **others)
        except ValueError as error:
            bad.append(str(error))
        stiffness = _in_range(bad, "> 0 (1e-44 to 1e50)", 1e-44, 1e50, kn=kn, ks=ks)
        if len(stiffness) == 2 and not stiffness["kn"] <= 1e10 * stiffness["ks"]:
            bad.append(f"kn = {contract.shown(kn)}: expected at most 1e10 ks")
        if bad:
            raise ValueError("\n".join(bad))
        return cls(mu=mu, **others | contract.joint_constants(**stiffness))

    @classmethod
    def from_masonry(
        cls,
        kn: float,
        ks: float,
        ft: float,
        GfI: float,
        c: float,
        GfII: float,
        tan_phi: float,
        tan_psi: float = 0.0,
        delta: float = 0.0,
        fm: float = 0.0,
        Gfc: float = 0.0,
        Css: float = contract.default("Css"),
        kp: float = contract.default("kp"),
    ) -> Material:
        """Material of a mortar joint from the constants of interface models of masonry (Lourenço 1996).

        kn, ks: stiffness in opening (in closing the same, kc = 1) and in shear, stress/length; ks has no
        effect: the shear stiffness of the law is c^2/(2 GfII (1 - eta)), because both modes have one eta.
        ft, GfI, c, GfII: tensile strength and cohesion, stress, and the energies of modes I and II,
        stress*length.  tan_phi: slope of the residual strength; the peak is below c + tan_phi |sigma_N|,
        because friction acts on the damaged part only.  tan_psi, delta: dilatancy tan_psi exp(-delta u) at
        the slip u; delta: 1/length.  It is that of planes of the slope tan_psi,
        `Pattern.regular(2, degrees(arctan(tan_psi)), flat=0.0)` for a slip along Tx, with the friction
        mu = tan(phi - psi) and the height tan_psi/delta, infinite if delta = 0.  fm, Gfc, Css, kp:
        compressive strength of the masonry, stress, which is fc of the joint, 0 for none; the energy of its
        softening, stress*length; weight of the shear; plastic closure at the peak, length.  Raises ValueError
        naming every value out of range.

        Examples
        --------
        >>> joint = Material.from_masonry(kn=82, ks=36, ft=.25, GfI=.018, c=.35, GfII=.125, tan_phi=.75)
        >>> round(joint.eta, 5), round(joint.K, 9)
        (0.97883, 82.0)
        """
        bad: list[str] = []
        slopes = {"tan_phi": tan_phi, "tan_psi": tan_psi, "delta": delta}
        slopes = _in_range(bad, ">= 0 (at most 1e10)", 0.0, 1e10, **slopes)
        if len(slopes) == 3:
            tan_phi, tan_psi, delta = slopes.values()
            if tan_psi > tan_phi:
                bad.append(f"tan_psi = {contract.shown(tan_psi)}: expected at most tan_phi")
            if delta > 0.0 and not tan_psi > 0.0:
                bad.append(f"delta = {contract.shown(delta)}: expected with tan_psi > 0, which decays")
        constants = {"kn": kn, "ks": ks, "ft": ft, "GfI": GfI, "c": c, "GfII": GfII}
        constants = _in_range(bad, "> 0 (1e-50 to 1e50)", 1e-50, 1e50, **constants)
        if bad:
            raise ValueError("\n".join(bad))
        kn, ks, ft, GfI, c, GfII = constants.values()
        if not 2.0 * kn * GfI > ft**2:
            least = ft**2 / (2.0 * GfI)
            raise ValueError(f"kn = {contract.shown(kn)}: expected more than ft^2/(2 GfI) = {least:g}")
        eta = 1.0 - ft**2 / (2.0 * kn * GfI)
        mu = (tan_phi - tan_psi) / (1.0 + tan_phi * tan_psi)
        height = tan_psi / delta if delta > 0.0 else 0.0
        strength = {"fc": fm, "Gfc": Gfc, "Css": Css, "kp": kp}
        return cls(sigma0=ft, Gc=GfI, eta=eta, mu=mu, sigma02=c, Gc2=GfII, height=height, **strength)

    def values(self) -> dict[str, float]:
        """Entries of PROPS that belong to the material, by name."""
        return {field.name: getattr(self, field.name) for field in fields(self)}

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
        strength: contract.Floats = np.divide(
            np.sin(angle) * c + self.mu / w, below, out=locked, where=below > 0.0
        )[()]
        return strength


def _in_range(
    bad: list[str], expected: str, low: float, high: float, **values: float | str
) -> dict[str, float]:
    """Those values, as numbers, that are in a range; a line is added to bad for each other one."""
    good = {}
    for name, value in values.items():
        try:
            number = contract.number(name, value, expected)
        except ValueError:
            number = np.nan
        if low <= number <= high:
            good[name] = number
        else:
            bad.append(f"{name} = {contract.shown(value)}: expected {expected}")
    return good


Material.__doc__ = f"{Material.__doc__}\n" + "".join(
    f"    {row.name} [{row.unit}]: {row.meaning}; {row.admissible}\n" for row in contract.owned("law")
)
