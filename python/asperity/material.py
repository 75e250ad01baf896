"""Material of the planes."""

from __future__ import annotations

import warnings
from dataclasses import asdict, dataclass

from . import contract


class ModelWarning(UserWarning):
    """The input is admissible, but leaves the ground the model stands on."""


@dataclass(frozen=True)
class Material:
    """Material of the planes (Section 2.2): strength, rupture energy, ductility, friction.

    sigma0, sigma02: stress; Gc, Gc2: stress*length; tau_v: time; eta, mu, kc: dimensionless.  sigma02, Gc2
    = 0: equal to the mode I value.  guard: the damage of a plane grows only where that releases energy, so
    that no increment has a negative dissipation.  Raises ValueError naming every value out of range; warns
    where mode II differs (Remark 2).
    """

    sigma0: float
    Gc: float
    eta: float
    mu: float
    sigma02: float = contract.default("sigma02")
    Gc2: float = contract.default("Gc2")
    tau_v: float = contract.default("tau_v")
    kc: float = contract.default("kc")
    guard: bool = bool(contract.default("guard"))

    def __post_init__(self) -> None:
        """Check the ranges."""
        contract.check(contract.pack(self.values()))
        for name, value, other in (("sigma02", self.sigma02, "sigma0"), ("Gc2", self.Gc2, "Gc")):
            if value not in (0.0, getattr(self, other)):
                warnings.warn(
                    f"{name} = {value:g} differs from {other} = {getattr(self, other):g}: "
                    "the thermodynamic argument of the law no longer holds (Remark 2)",
                    ModelWarning,
                    stacklevel=3,
                )

    def values(self) -> dict[str, float]:
        """Entries of PROPS that belong to the material, by name."""
        return asdict(self)
