"""Delamination with a rough crack: double cantilever beam with uneven bending moments, on FEniCSx."""

from __future__ import annotations

import sys
from collections.abc import Mapping

import numpy as np
from asperity.contract import Floats
from asperity.tools.style import ONE, new_figure
from asperity.tools.tables import markdown
from matplotlib.figure import Figure

from ..concepts_draw import BLACK, BLUE, GREEN, panel
from .common import Constants, Study
from .wall_runs import printed_by

NAMES = "moments", "share", "J", "spent", "friction"
GC = 0.15
"""Rupture energy, N/mm."""


def runs() -> dict[str, Constants]:
    """Numbers of the runs, by friction and turn."""
    return {name: dict(zip(NAMES, values, strict=True)) for name, values in printed_by("", "delamination")}


def rows_of(results: Mapping[str, Constants], mu: str) -> Floats:
    """Rows of the runs with a friction, in the order of NAMES."""
    return np.array(
        [[values[name] for name in NAMES] for run, values in results.items() if run.startswith(f"mu {mu} ")]
    )


def tables(results: Mapping[str, Constants]) -> dict[str, str]:
    """J by the moments and by the ledger, over the mix."""
    body = []
    smooth = rows_of(results, "0")
    for row, frictionless in zip(rows_of(results, "0.8"), smooth, strict=True):
        moments, share, J, spent, friction = row
        numbers = f"{moments:.2f}", f"{max(share, 0.0):.2f}", f"{J:.4f}", f"{spent:.4f}", f"{friction:.4f}"
        body.append([*numbers, f"{100.0 * (J / spent - 1.0):+.1f} %", f"{frictionless[2]:.4f}"])
    head = ["M2/M1", "share of mode II", "J of the moments", "spent by the joint", "of it friction", "error",
            "J without friction"]  # fmt: skip
    return {"mixes": markdown(head, body)}


def draw(results: Mapping[str, Constants]) -> Figure:
    """Draw J over the share of mode II."""
    figure, [ax] = new_figure(ONE, 3.0)
    for mu, colour, label in (("0.8", BLUE, "mu = 0.8"), ("0", GREEN, "no friction")):
        rows = rows_of(results, mu)
        ax.plot(
            rows[:, 1], rows[:, 2] / GC, "o-", color=colour, markersize=4, label=f"J of the moments, {label}"
        )
        ax.plot(rows[:, 1], rows[:, 3] / GC, "x", color=BLACK, markersize=5)
    ax.plot([], [], "x", color=BLACK, label="spent by the joint")
    panel(ax, "share of mode II in J [-]", "energy over Gc [-]")
    ax.legend()
    return figure


STUDY = Study("delamination", runs, tables, draw)

if __name__ == "__main__":
    sys.exit(STUDY.main())
