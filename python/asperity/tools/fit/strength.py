"""Strengths of a test without its curve."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np


@dataclass(frozen=True)
class Strength:
    """Peak and residual strength of a test at a normal traction, stress; nan where it was not measured.

    sigma_N: compression is negative; 0 shows the initial shear strength, and tension, where the peak may be
    0, the bond.  peak_slip: slip at the peak, slip: at the residual strength, length.  name: file and line.
    units: of length and stress where the file has them.  Raises ValueError for inadmissible values.
    """

    name: str
    sigma_N: float
    peak: float
    residual: float = np.nan
    peak_slip: float = np.nan
    slip: float = np.nan
    units: dict[str, str] = field(default_factory=dict)
    WHAT: ClassVar[str] = "strengths alone"

    def __post_init__(self) -> None:
        """Check the values."""
        if not np.isfinite(self.sigma_N):
            raise ValueError(f"{self.name}: sigma_N = {self.sigma_N:g}: expected a finite normal traction")
        if not (0.0 < self.peak < np.inf or (self.peak == 0.0 and self.sigma_N > 0.0)):
            raise ValueError(
                f"{self.name}: peak = {self.peak:g}: expected a strength > 0, 0 in tension alone"
            )
        for name in ("peak_slip", "slip"):
            value = getattr(self, name)
            if not (np.isnan(value) or 0.0 < value < np.inf):
                raise ValueError(f"{self.name}: {name} = {value:g}: expected > 0")
        if not (np.isnan(self.residual) or 0.0 <= self.residual < np.inf):
            raise ValueError(f"{self.name}: residual = {self.residual:g}: expected >= 0")
        if self.residual > self.peak:
            raise ValueError(
                f"{self.name}: residual = {self.residual:g}: expected at most the peak, {self.peak:g}"
            )

    @property
    def level(self) -> float:
        """Pressure, tension negative."""
        return 0.0 - self.sigma_N

    @property
    def covers(self) -> tuple[float, float, float]:
        """Smallest and largest pressure, and no slip of a curve."""
        return self.level, self.level, 0.0
