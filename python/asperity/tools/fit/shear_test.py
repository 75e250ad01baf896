"""A shear-box test: slip, traction and dilation, under a normal traction or stiffness."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ... import contract
from ...contract import Floats
from ...steps import turns_of

FAR = 0.98
"""Slip over the largest one that counts as it."""


@dataclass(frozen=True, eq=False)
class ShearTest:
    """One test: slip (T,) and s_N (T,), None where not measured, length; tau (T,), stress.

    s_N counts from the start of the slip, opening positive.  sigma_N: normal traction there, stress, <= 0;
    k_N: normal stiffness of the box, stress/length, 0 where sigma_N is constant.  name: file and test.
    units: of length and stress where the file has them.  lines (T,): of the file, empty where there is none.
    path_N (T,): measured normal traction of each row, None where sigma_N and k_N give it.
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

    def __post_init__(self) -> None:
        """Check shapes and values."""
        for name in ("slip", "tau", "s_N", "path_N"):
            if getattr(self, name) is None:
                continue
            values = contract.array(name, getattr(self, name))
            object.__setattr__(self, name, values)
            wrong = values.shape != (self.slip.size,) or not (values.size and np.isfinite(values).all())
            if wrong:
                wanted = f"expected finite numbers of shape ({self.slip.size or 'T'},)"
                raise ValueError(f"{self.name}: {name} has shape {values.shape}: {wanted}")
            same = name in ("slip", "tau") and not np.ptp(values) > 0.0
            if same:
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
    def levels(self) -> tuple[float, float]:
        """Pressure at the start of the slip, and the largest one of those that are prescribed."""
        return 0.0 - self.sigma_N, 0.0 - self.pressed

    @property
    def turns(self) -> list[float]:
        """Slips at the reversals, and the last slip."""
        path = np.append(0.0, self.slip)
        return list(path[turns_of(path)[1:]].tolist())

    @property
    def ends_far(self) -> bool:
        """Whether the test ends at its largest slip, and not within a cycle."""
        return bool(abs(self.slip[-1]) >= FAR * np.abs(self.slip).max())

    def place(self, row: int) -> str:
        """Name of the test, with the line of a row where it comes from a file."""
        return f"{self.name}: line {self.lines[row]}" if self.lines else self.name
