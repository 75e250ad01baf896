"""Snaps as jumps and as whole branches: the energy between both, and its picture."""

from __future__ import annotations

import functools
from dataclasses import dataclass, replace

import numpy as np
from asperity.contract import Floats
from asperity.history import History
from asperity.interface import Interface
from asperity.pattern import Pattern
from asperity.tools.style import COLOURS, TWO, label_axes, new_figure, printed
from matplotlib.figure import Figure

from harness.studies.paper.fracture_energy import MATERIAL as TABLE_2

STEEP = Pattern.regular(8, 60.0, flat=0.0, turn=298.64)
"""Eight steep planes; the seventh faces the slip along Tx best."""

SLIP, STEPS, ARC = 0.3, 3000, 0.02
"""Slip along Tx, mm, increments of the path with the jump, and longest step along the branch over s_0."""


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


SHOWN = (("traction", 1, "traction along the slip [MPa]"), ("separation", 0, "opening $s_N$ [mm]"))
"""Columns of a history that are drawn over the slip, their component and label."""


@printed()
def draw() -> Figure:
    """Draw traction and dilation over the slip, by jump and by branch, without and with friction."""
    figure, axes = new_figure(TWO, 4.8, nrows=2, ncols=2, sharex="col")
    for (upper, lower), mu in zip(axes.reshape(2, 2).T, (0.0, 0.5), strict=True):
        snap = steep_snap(mu)
        part, row = slice(snap.turns[0], int(np.ceil(snap.back)) + 1), snap.jump.snaps[0].row
        slip, along, turns = snap.jump.separation[:, 1], snap.branch.separation[:, 1], list(snap.turns)
        for ax, (name, k, label) in zip((upper, lower), SHOWN, strict=True):
            jump, branch = getattr(snap.jump, name)[:, k], getattr(snap.branch, name)[:, k]
            ax.plot(slip[:row], jump[:row], color=COLOURS[3], label="stable path")
            ax.plot(slip[row:], jump[row:], color=COLOURS[3])
            ax.plot(slip[row - 1 : row + 1], jump[row - 1 : row + 1], "--", color=COLOURS[1], label="jump")
            ax.plot(along[part], branch[part], color=COLOURS[0], label="branch")
            ax.plot(along[turns], branch[turns], "o", color=COLOURS[0], label="turn")
            label_axes(ax, "slip $s_L$ [mm]" if k == 0 else "", label if mu == 0.0 else "")
        upper.fill(along[part], snap.branch.traction[part, 1], color=COLOURS[0], alpha=0.25, linewidth=0)
        area, released = (f"{1e3 * energy:.2f} J/m²" for energy in (snap.area, snap.released))
        title = f"$\\mu$ = {mu:g}: area {area}, the jump releases {released}"
        more = f"\nand dissipates {1e3 * snap.dissipated_more:.2f} J/m² more than the branch"
        upper.set_title(title + more if mu > 0.0 else title)
        lower.set(xlim=(0.09, 1.15 * along[: part.stop].max()), ylim=(0.04, 0.3))
    axes[0].legend(loc="lower left")
    return figure
