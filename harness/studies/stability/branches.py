"""Snaps as jumps and as whole branches: the energy between both, and its picture."""

from __future__ import annotations

import functools
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from asperity.contract import Floats
from asperity.history import History
from asperity.interface import Interface
from asperity.pattern import Pattern

from .modes import TABLE_2

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

STEEP = Pattern.regular(8, 60.0, flat=0.0, turn=298.64)
"""Eight steep planes; the seventh faces the slip along Tx best."""

SLIP, STEPS, ARC = 0.3, 3000, 0.02
"""Slip along Tx, mm, increments of the path with the jump, and longest step along the branch over s_0."""

JUMP, BRANCH = "#D55E00", "#0072B2"
"""Colours."""


@dataclass(frozen=True, eq=False)
class Snap:
    """Slip without pressure, by increments and along the branch.

    turns: rows of the branch at its folds.  back: fractional row where the slip is again that of the first.
    """

    jump: History
    branch: History
    turns: tuple[int, ...]
    back: float

    @property
    def area(self) -> float:
        """Energy between branch and jump: what the traction gives back while the slip is smaller."""
        return float(self.branch.work[self.turns[0]] - self.at(self.branch.work))

    @property
    def released(self) -> float:
        """Energy that the jump releases."""
        return self.jump.snaps[0].released

    @property
    def dissipated_more(self) -> float:
        """Energy that is stored and dissipated in the jump less that on the branch."""
        first, last = (h.stored + h.rupture + h.friction for h in (self.jump, self.branch))
        return float(first[self.jump.snaps[0].row] - self.at(last))

    def at(self, column: Floats) -> float:
        """Value of a column of the branch where the slip is again that of the first fold."""
        return float(np.interp(self.back, np.arange(len(column)), column))


@functools.cache
def steep_snap(mu: float) -> Snap:
    """Slip of the steep planes; only one of their jumps is expected."""
    rough = Interface(replace(TABLE_2, mu=mu), STEEP)
    jump = rough.confined_slip(0.0, np.linspace(0.0, SLIP, STEPS + 1)[1:], 0.0)
    branch = rough.confined_slip(0.0, [SLIP], 0.0, follow="branch", arc=ARC)
    turns = tuple(row for row, text in branch.events if "turn" in text.split("+"))
    slip = branch.separation[:, 1]
    after = turns[-1] + int(np.argmax(slip[turns[-1] :] >= slip[turns[0]]))
    share = (slip[turns[0]] - slip[after - 1]) / (slip[after] - slip[after - 1])
    return Snap(jump, branch, turns, after - 1 + float(share))


def draw() -> Figure:
    """Draw traction and dilation over the slip, by jump and by branch, without and with friction."""
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(2, 2, figsize=(10.0, 6.6), layout="constrained", sharex="col")
    for column, mu in enumerate((0.0, 0.5)):
        snap = steep_snap(mu)
        _draw(axes[0, column], snap, "traction", 1)
        _draw(axes[1, column], snap, "separation", 0)
        first, last = snap.turns[0], int(np.ceil(snap.back))
        slip, traction = snap.branch.separation[: last + 1, 1], snap.branch.traction[: last + 1, 1]
        axes[0, column].fill(slip[first:], traction[first:], color=BRANCH, alpha=0.25, linewidth=0)
        title = f"$\\mu$ = {mu:g}: area {1e3 * snap.area:.2f} J/m², "
        title += f"the jump releases {1e3 * snap.released:.2f} J/m²"
        if mu > 0.0:
            title += f"\nand dissipates {1e3 * snap.dissipated_more:.2f} J/m² more than the branch"
        axes[0, column].set_title(title, fontsize="small")
        axes[1, column].set_xlabel("slip $s_L$ [mm]")
        axes[1, column].set_xlim(0.09, 1.15 * slip.max())
        axes[1, column].set_ylim(0.04, 0.3)
    axes[0, 0].set_ylabel("traction along the slip [MPa]")
    axes[1, 0].set_ylabel("opening $s_N$ [mm]")
    axes[0, 0].legend(fontsize="small", loc="lower left")
    return figure


def _draw(ax: Axes, snap: Snap, name: str, component: int) -> None:
    """Draw one component of both paths over the slip, and the jump between its rows."""
    jump, branch = getattr(snap.jump, name)[:, component], getattr(snap.branch, name)[:, component]
    slip, row = snap.jump.separation[:, 1], snap.jump.snaps[0].row
    first, last = snap.turns[0], int(np.ceil(snap.back))
    ax.plot(slip[:row], jump[:row], color="black", label="stable path")
    ax.plot(slip[row:], jump[row:], color="black")
    ax.plot(slip[row - 1 : row + 1], jump[row - 1 : row + 1], "--", color=JUMP, label="jump")
    ax.plot(
        snap.branch.separation[first : last + 1, 1], branch[first : last + 1], color=BRANCH, label="branch"
    )
    turned = list(snap.turns)
    ax.plot(snap.branch.separation[turned, 1], branch[turned], "o", color=BRANCH, markersize=4, label="turn")
    ax.grid(alpha=0.3)
