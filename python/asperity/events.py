"""What happens along a history, by the rules of the driver's column `event`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from . import contract
from .contract import Floats


def find_events(
    normals: Floats, separation: Floats, state: Floats, more: Mapping[int, Sequence[str]] | None = None
) -> tuple[tuple[int, str], ...]:
    """Events (row, names joined by +) of a point that was virgin and at rest before the first row.

    normals (Np, 3); separation (T, 3), length; state (T, nstatv).  Names: onset (first damage), damaged (all
    planes fully), open, close (a plane leaves or comes into contact), slip (a damaged plane starts to slide);
    and those of `more`, by row.
    """
    first = contract.plane_statev(1)
    count = len(normals)
    planes = state[:, first : first + 3 * count].reshape(len(state), count, 3)
    alpha, slips = planes[:, :, 0], planes[:, :, 1:]
    # in contact or apart is what the last gap was that is not zero
    signs = np.sign(separation @ normals.T)
    rows = np.maximum.accumulate(np.where(signs != 0.0, np.arange(len(signs))[:, None], -1), axis=0)
    signs = np.where(rows >= 0, np.take_along_axis(signs, np.maximum(rows, 0), axis=0), 0.0)
    contact, apart = signs < 0.0, signs > 0.0
    slides = contact & (alpha > 0.0) & np.any(slips != _before(slips), axis=2)
    damaged, broken = np.any(alpha != 0.0, axis=1), np.all(alpha >= 1.0, axis=1)
    happened = {
        "onset": damaged & ~_before(damaged),
        "damaged": broken & ~_before(broken),
        "open": np.any(_before(contact) & ~contact, axis=1),
        "close": np.any(_before(apart) & contact, axis=1),
        "slip": np.any(slides & ~_before(slides), axis=1),
    }
    names: dict[int, list[str]] = {}
    for name, yes in happened.items():
        for row in np.flatnonzero(yes).tolist():
            names.setdefault(row, []).append(name)
    for row, texts in (more or {}).items():
        if row < len(state):
            names.setdefault(row, []).extend(texts)
    return tuple((row, "+".join(dict.fromkeys(names[row]))) for row in sorted(names))


def _before(values: Any) -> Any:
    """The row before each, zero or False before the first."""
    return np.concatenate([np.zeros_like(values[:1]), values[:-1]])
