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
            if getattr(self, name) is not None:
                object.__setattr__(self, name, contract.array(name, getattr(self, name)))
        for name in ("sigma_N", "k_N"):
            object.__setattr__(self, name, contract.number(name, getattr(self, name)))
        for name, values in (("slip", self.slip), ("tau", self.tau), ("s_N", self.s_N)):
            if values is None:
                continue
            if not values.size:
                raise ValueError(f"{self.name}: {name} has no rows: expected some")
            if values.shape != (self.slip.size,) or not np.all(np.isfinite(values)):
                raise ValueError(
                    f"{self.name}: {name} has shape {values.shape}: expected finite numbers of shape "
                    f"({self.slip.size},)"
                )
            if name != "s_N" and not np.ptp(values) > 0.0 and not self.envelope:
                raise ValueError(
                    f"{self.name}: column {name} is {values[0]:g} in all rows: expected values that change"
                )
        if self.path_N is not None and (
            self.path_N.shape != self.slip.shape
            or not np.all((self.path_N <= 0.0) & np.isfinite(self.path_N))
        ):
            raise ValueError(f"{self.name}: path_N: expected a finite compression, <= 0, for each row")
        if not -np.inf < self.sigma_N <= 0.0:
            raise ValueError(f"{self.name}: sigma_N = {self.sigma_N:g}: expected a finite compression, <= 0")
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


def saturates(test: ShearTest) -> bool:
    """Whether the dilation ends: its slope at the end of the first stroke is well below that before."""
    if test.s_N is None or test.envelope:
        return False
    end = int(np.argmax(np.abs(test.slip) >= 0.98 * np.abs(test.slip).max()))
    way, stroke = test.slip / test.slip[end], np.arange(test.slip.size) <= end
    slopes = []
    for low, high in ((0.25, 0.5), (0.75, 1.0)):
        part = stroke & (way >= low) & (way <= high)
        if np.count_nonzero(part) < LEAST_PART:
            return False
        slopes.append(np.polyfit(way[part], test.s_N[part], 1)[0])
    return bool(slopes[1] < SATURATED * slopes[0])
