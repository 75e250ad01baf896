"""Load path of a case for many sets of constants: curves over the prescribed slip or opening."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .. import contract
from ..case_files import Case, Run
from ..contract import Floats
from ..history import SEPARATION
from ..load_path import rows_of
from ..pattern import direction_vector
from ..steps import Point, Step, prescribed

CURVES = ("traction", "dilation", "damage")
"""Curves of a sample: traction along the slip (without slip along N), s_N and damage."""


@dataclass(frozen=True, eq=False)
class LoadPath:
    """Load path of one run of a case, as PROPS -> curves over the abscissa x (n,), which is prescribed.

    value: of the sweep, None without one.  props: of the case.  slips: whether x is a slip (or an opening).
    steps: the load path; first: first of its rows on the curves, where 0 is the virgin point before them.
    e (3,): direction of x, in which the traction is shown.
    """

    value: float | None
    props: Floats
    x: Floats
    slips: bool
    steps: tuple[Step, ...]
    first: int
    e: Floats

    def curve(self, props: Floats) -> tuple[Floats, Floats]:
        """Curves of a joint with these constants, (n, 3), and work (n,); n is smaller where it is lost."""
        n_planes = contract.check(props)
        wears = bool(max(props[contract.index(name)] for name in ("W0", "crush")) > 0.0)
        start = Point(np.zeros(contract.n_statev(n_planes, wears)))
        rows, _ = rows_of(props, n_planes, self.steps, start)
        values = np.column_stack([rows.traction @ self.e, rows.dilation, rows.damage])
        whole = np.vstack([np.zeros(3), values])
        return whole[self.first :], np.append(0.0, rows.work)[self.first :]


def load_paths(case: Case) -> list[LoadPath]:
    """Load paths of the runs of a case; raises ValueError for one without a prescribed x or that is lost."""
    return [_load_path(case.path, run) for run in case.runs]


def _load_path(path: Path, run: Run) -> LoadPath:
    if run.start != "virgin" or not run.steps:
        what = f"&{run.start}" if run.steps else "&replay"
        raise ValueError(f"{path}: {what}: expected &step from a virgin state")
    if run.tolerance is not None or any(step.follow == "branch" for step in run.steps):
        what = "tolerance" if run.tolerance is not None else "follow = 'branch'"
        raise ValueError(f"{path}: {what}: expected increments, which all samples share")
    e = _abscissa(path, run.steps)
    rows, lost = run.interface.rows(run.steps)
    x = np.append(0.0, rows.separation @ e)
    if lost:
        raise ValueError(
            f"the case itself loses equilibrium beyond {x[-1]:g}: expected one to the end of its path"
        )
    # the row before x moves is the start of the curve
    first = int(np.argmax(np.diff(x) != 0.0))
    return LoadPath(run.value, np.array(run.props), x[first:], bool(e[0] == 0.0), run.steps, first, e)


def _abscissa(path: Path, steps: Sequence[Step]) -> Floats:
    """Unit vector (3,) of the prescribed separation over which curves are drawn: of a slip, or of s_N."""
    unit = dict(zip(SEPARATION, np.eye(3), strict=True))
    for names in (("slip", "s_Tx", "s_Ty"), ("s_N",)):
        for step in steps:
            moved = [name for name in names if getattr(step, name) is not None]
            if moved:
                along = direction_vector(step.direction or 0.0)
                e = np.array([0.0, *along]) if moved[0] == "slip" else unit[moved[0]]
                if not any(traction[i] for traction in prescribed(steps) for i in np.flatnonzero(e)):
                    return e
                break
    raise ValueError(f"{path}: expected &step with a prescribed slip or opening, over which curves are drawn")
