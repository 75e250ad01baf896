"""What happens along a history, by the rules of the driver's column `event`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

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
    first = contract.statev_names(len(normals)).index("alpha_1")
    planes = state[:, first : first + 3 * len(normals)].reshape(len(state), len(normals), 3)
    s_n = separation @ normals.T
    last = np.zeros((len(normals), 3))
    contact = apart = slides = np.zeros(len(normals), dtype=bool)
    found = []
    for row, (plane, gap) in enumerate(zip(planes, s_n, strict=True)):
        now_contact = (gap < 0.0) | (contact & (gap <= 0.0))
        now_apart = (gap > 0.0) | (apart & (gap >= 0.0))
        alpha, old_alpha = plane[:, 0], last[:, 0]
        now_slides = now_contact & (alpha > 0.0) & np.any(plane[:, 1:] != last[:, 1:], axis=1)
        happened = {
            "onset": alpha.any() and not old_alpha.any(),
            "damaged": np.all(alpha >= 1.0) and not np.all(old_alpha >= 1.0),
            "open": np.any(contact & ~now_contact),
            "close": np.any(apart & now_contact),
            "slip": np.any(now_slides & ~slides),
        }
        names = [name for name, yes in happened.items() if yes]
        text = "+".join(dict.fromkeys([*names, *((more or {}).get(row, ()))]))
        if text:
            found.append((row, text))
        contact, apart, slides, last = now_contact, now_apart, now_slides, plane
    return tuple(found)
