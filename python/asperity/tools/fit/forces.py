"""Forces of a shear box as tractions over its contact area."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

import numpy as np

from ...contract import Floats

if TYPE_CHECKING:
    from pandas import DataFrame

Area = Callable[[Floats], Floats]
"""Area over the slip, as `area_of` makes it."""


def over_area(rows: DataFrame, area: Area, forces: Mapping[str, str]) -> tuple[DataFrame, bool]:
    """Rows with tractions in place of forces, and whether the area shrinks in a way that a test must follow.

    forces: names of the tractions by those of the forces.
    """
    columns = [name for name in forces if name in rows]
    slip = rows["slip"].fillna(0.0).to_numpy() if "slip" in rows else np.zeros(len(rows))
    over = area(slip)
    tractions = {forces[name]: rows[name] / over for name in columns}
    changed = rows.drop(columns=columns).assign(**tractions)
    if {"peak", "residual"} & {*tractions}:
        return changed, bool(np.ptp(area(np.array([0.0, 1e-6]))) > 0.0)
    return changed, "normal_force" in columns and bool(np.ptp(over) > 0.0)


def shrinking(area: Area | None, rows: DataFrame) -> Floats | float:
    """Factor on the normal traction of a constant normal force at each row, 1 at the start of the slip."""
    if area is None or "slip" not in rows or "peak" in rows:
        return 1.0
    return np.asarray(area(np.zeros(1)) / area(rows["slip"].to_numpy()))
