"""A closure test: pressure and closure of a joint, loading and unloading."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from ... import contract
from ...contract import Floats
from .thresholds import FALL


@dataclass(frozen=True, eq=False)
class ClosureTest:
    """Pressure (T,), stress, >= 0, and closure (T,) since the first row, length, both growing as it closes.

    name: file and test.  units: of length and stress where the file has them.  Raises ValueError for
    inadmissible values.
    """

    name: str
    pressure: Floats
    closure: Floats
    units: dict[str, str] = field(default_factory=dict)
    WHAT: ClassVar[str] = "closures"

    def __post_init__(self) -> None:
        """Check the values."""
        for name in ("pressure", "closure"):
            values = contract.array(name, getattr(self, name))
            object.__setattr__(self, name, values)
            wrong = values.shape != (self.pressure.size,) or not np.isfinite(values).all()
            if wrong:
                raise ValueError(
                    f"{self.name}: {name} has shape {values.shape}: expected finite numbers (T,)"
                )
            same = not (values.size and np.ptp(values) > 0.0)
            column = "sigma_N" if name == "pressure" else name
            if same:
                raise ValueError(
                    f"{self.name}: column {column} is the same in all rows: expected values that change"
                )
        if self.pressure.min() < 0.0:
            raise ValueError(f"{self.name}: pressure = {self.pressure.min():g}: expected >= 0")
        rows = self.loading
        if len(rows) < 3:
            raise ValueError(f"{self.name}: {len(rows)} rows of loading: expected at least 3")
        opens = self.closure[rows][-1] <= self.closure[0]
        if opens:
            raise ValueError(f"{self.name}: column closure: the joint does not close as the pressure grows")

    @property
    def loading(self) -> np.ndarray:
        """Rows of the first loading."""
        top = np.maximum.accumulate(self.pressure)
        fallen = np.flatnonzero(top - self.pressure > FALL * np.ptp(self.pressure))
        end = self.pressure.size if not fallen.size else int(fallen[0])
        return np.arange(int(np.argmax(self.pressure[:end])) + 1)

    @property
    def unloading(self) -> np.ndarray:
        """Rows of the first unloading, which may be none."""
        start = self.loading[-1] + 1
        rest = self.pressure[start:]
        risen = np.flatnonzero(rest - np.minimum.accumulate(rest) > FALL * np.ptp(self.pressure))
        return np.arange(
            start, start + (rest.size if not risen.size else int(np.argmin(rest[: risen[0]])) + 1)
        )

    @property
    def level(self) -> float:
        """Pressure at the end of the first loading."""
        return float(self.pressure[self.loading[-1]])

    @property
    def covers(self) -> tuple[float, float, float]:
        """Smallest pressure, that at the end of the first loading, and no slip."""
        return float(self.pressure.min()), self.level, 0.0

    @property
    def size(self) -> float:
        """Closure at the end of the loading."""
        return float(self.closure[self.loading[-1]] - self.closure[0])
