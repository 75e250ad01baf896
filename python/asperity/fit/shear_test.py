"""A shear-box test."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from .. import contract
from ..contract import Floats
from ..steps import turns_of

SATURATED, LEAST_PART = 0.7, 4
"""Ratio of two slopes of the dilation below which it ends, and smallest number of rows of a slope."""


@dataclass(frozen=True, eq=False)
class ShearTest:
    """One test: slip (T,) and s_N (T,), None where not measured, length; tau (T,), stress.

    s_N counts from the start of the slip, opening positive.  sigma_N: normal traction there, stress, <= 0;
    k_N: normal stiffness of the box, stress/length, 0 where sigma_N is constant.  name: file and test.
    units: of length and stress where the file has them.  lines (T,): of the file, empty where there is none.
    path_N (T,): measured normal traction of each row, None where sigma_N and k_N give it.  envelope: the two
    rows are the peak, at a slip that is not known, and the residual strength.
    Raises ValueError for inadmissible data.
    """

    name: str
    slip: Floats
    tau: Floats
    s_N: Floats | None
    sigma_N: float
    k_N: float = 0.0
    units: dict[str, str] = field(default_factory=dict)
    lines: tuple[int, ...] = ()
    path_N: Floats | None = None
    envelope: bool = False

    def __post_init__(self) -> None:
        """Check shapes and values."""
        for name in ("slip", "tau", "s_N", "path_N"):
            if getattr(self, name) is None:
                continue
            values = contract.array(name, getattr(self, name))
            object.__setattr__(self, name, values)
            if not values.size:
                raise ValueError(f"{self.name}: {name} has no rows: expected some")
            if values.shape != (self.slip.size,) or not np.isfinite(values).all():
                wanted = f"finite numbers of shape ({self.slip.size},)"
                raise ValueError(f"{self.name}: {name} has shape {values.shape}: expected {wanted}")
            if name in ("slip", "tau") and not np.ptp(values) > 0.0 and not self.envelope:
                raise ValueError(
                    f"{self.name}: column {name} is {values[0]:g} in all rows: expected values that change"
                )
        for name in ("sigma_N", "k_N"):
            object.__setattr__(self, name, contract.number(name, getattr(self, name)))
        worst = self.sigma_N if self.path_N is None else max(self.sigma_N, *self.path_N)
        if not -np.inf < worst <= 0.0:
            raise ValueError(f"{self.name}: sigma_N = {worst:g}: expected a finite compression, <= 0")
        if not 0.0 <= self.k_N < np.inf:
            raise ValueError(f"{self.name}: k_N = {self.k_N:g}: expected a finite stiffness >= 0")

    @property
    def pressed(self) -> float:
        """Normal traction of the largest size, stress."""
        return self.sigma_N if self.path_N is None else float(self.path_N.min())

    @property
    def turns(self) -> list[float]:
        """Slips at the reversals, and the last slip."""
        path = np.append(0.0, self.slip)
        turns: list[float] = path[turns_of(path)[1:]].tolist()
        return turns

    @property
    def saturates(self) -> bool:
        """Whether the dilation ends: its slope at the end of the first stroke is well below that before."""
        if self.s_N is None or self.envelope:
            return False
        end = int(np.argmax(np.abs(self.slip) >= 0.98 * np.abs(self.slip).max()))
        way, slopes = self.slip[: end + 1] / self.slip[end], []
        for low, high in ((0.25, 0.5), (0.75, 1.0)):
            part = (way >= low) & (way <= high)
            if np.count_nonzero(part) < LEAST_PART:
                return False
            slopes.append(np.polyfit(way[part], self.s_N[: end + 1][part], 1)[0])
        return bool(slopes[1] < SATURATED * slopes[0])
