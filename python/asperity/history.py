"""Results with names: points after an increment, one point along a load path, and one whose path ends."""

from __future__ import annotations

import csv
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from . import contract
from .contract import Floats
from .pattern import direction_vector
from .steps import Point

SEPARATION, TRACTION = ("s_N", "s_Tx", "s_Ty"), ("t_N", "t_Tx", "t_Ty")
"""Names of columns, as in the results of the driver."""

ENERGIES = ("stored", "rupture", "friction", "work")  # energies per unit area, in the order of the columns
COLUMNS = (*SEPARATION, *TRACTION, "p", "aperture", "damage", *ENERGIES, "event")
"""Columns of the results of the driver without the state of the planes."""

EVENTS = ("onset", "damaged", "open", "close", "slip", "snap", "turn", "fork", "substeps", "cut", "lost")
"""Names of events in the order in which a row has them."""


ARRAYS = (
    "separation", "traction", "damage", "state", "work", "step", "position", "time", "iterations", "p",
    "aperture", "tangent",
)  # fmt: skip
"""Fields of a history with a value for each row."""


class _Named:
    """State variables by name; the first axis is the point or the row."""

    state: Floats
    n_planes: int | None
    yields: bool

    @property
    def planes(self) -> int:
        """Number of planes."""
        if self.n_planes is not None:
            return self.n_planes
        return int(self.state.shape[1] - contract.N_POINT_STATEV) // contract.N_PLANE_STATEV

    @property
    def stored(self) -> Floats:
        """Stored energy per unit area, stress*length."""
        return self._column("stored")

    @property
    def rupture(self) -> Floats:
        """Energy dissipated by rupture per unit area, stress*length."""
        return self._column("rupture")

    @property
    def friction(self) -> Floats:
        """Energy dissipated by friction and wear per unit area, stress*length."""
        return self._column("friction")

    @property
    def crushing(self) -> Floats:
        """Energy dissipated by the plastic closure per unit area, stress*length; 0 without fc."""
        return self.state[:, -1] if self.yields else np.zeros(len(self.state))

    @property
    def kappa(self) -> Floats:
        """Plastic closure of a joint with a compressive strength, length; 0 without fc."""
        return self.state[:, -contract.N_CAP_STATEV] if self.yields else np.zeros(len(self.state))

    def alpha(self, plane: int) -> Floats:
        """Damage of a plane, 0 to 1; planes count from 1 in the order of `Pattern.normals`."""
        return self.state[:, self._place(plane)]

    def slip(self, plane: int) -> Floats:
        """Frictional slip of a plane, (s_dit, s_dih), (..., 2), length; planes count from 1."""
        first = self._place(plane) + 1
        return self.state[:, first : first + 2]

    @property
    def wears(self) -> bool:
        """Whether the state has variables of wear."""
        return bool(self.state.shape[1] > contract.n_statev(self.planes, yields=self.yields))

    def worn(self, plane: int) -> Floats:
        """Worn share of the asperity of a plane, 0 to 1; raises ValueError for a material without wear."""
        at = self._place(plane)
        if not self.wears:
            raise ValueError("worn: expected a material whose facets wear (W0 > 0)")
        return self.state[:, contract.statev_names(self.planes, True).index(f"worn_{plane}", at)]

    def _column(self, name: str) -> Floats:
        return self.state[:, contract.statev_index(name)]

    def _place(self, plane: int) -> int:
        """Position in the state of the damage of a plane; its slips follow."""
        if isinstance(plane, bool) or not isinstance(plane, int) or not 1 <= plane <= self.planes:
            raise ValueError(f"plane = {contract.shown(plane)}: expected 1 to {self.planes}")
        return contract.N_POINT_STATEV + contract.N_PLANE_STATEV * (plane - 1)


@dataclass(frozen=True, eq=False, repr=False)
class Update(_Named):
    """Points at the end of an increment; the first axis of every field is the point.

    traction (n, 3): (N, Tx, Ty), stress.  state (n, nstatv): contract.statev_table(), by name in stored,
    rupture, friction, crushing, damage, kappa, alpha(plane), slip(plane).  tangent (n, 3, 3): [i, j] =
    d traction_i / d s_j, stress/length, consistent and not symmetric.  yields: whether fc > 0.
    """

    traction: Floats
    state: Floats
    tangent: Floats
    n_planes: int | None = None
    yields: bool = False

    def __post_init__(self) -> None:
        """Make the arrays read-only."""
        _freeze(self.traction, self.state, self.tangent)

    def __repr__(self) -> str:
        """Number of points and planes."""
        return f"Update({len(self.traction)} points, {self.planes} planes)"

    @property
    def damage(self) -> Floats:
        """Mean damage of the planes by their weights, 0 to 1."""
        return self._column("damage")


class Stability(NamedTuple):
    """Stability of points, from the eigenvalues of their tangents; the first axis is the point.

    second_order (n,): smallest eigenvalue of the symmetric part of the tangent over the stiffness of the
    bond; where it is negative, the joint may go in the direction of mode (n, 3), its unit vector
    (N, Tx, Ty), by itself.  real, flutter (n,): smallest real and largest imaginary part of the eigenvalues
    of the tangent over the same stiffness; a tangent with complex ones can flutter.
    """

    second_order: Floats
    real: Floats
    flutter: Floats
    mode: Floats


@dataclass(frozen=True)
class Snap:
    """Jump to another branch of equilibria: row, separation (N, Tx, Ty) before and after it, length.

    released: energy per unit area that the jump sets free. It is the work of the prescribed tractions less
    the change of the stored and dissipated energy; for a fall by wear, which sets nothing free, it is the
    error of the steps of the fall, of either sign.
    """

    row: int
    before: tuple[float, float, float]
    after: tuple[float, float, float]
    released: float


@dataclass(frozen=True, eq=False, repr=False)
class History(_Named):
    """One point along a load path; the first axis of every field is the row.

    separation (T, 3), length; traction (T, 3), total, stress; p (T,): water pressure, by which the law
    carries more than the total normal traction; aperture (T,): of the water's flow, length, the larger one
    of a_min and a_0 + s_N (`with_aperture`); damage (T,); state (T, nstatv), by name in stored, rupture,
    friction, crushing, kappa, alpha(plane), slip(plane); work (T,): of the traction of the law on the
    separation, the preload included, stress*length; events: (row, text), those of a preload with row 0;
    snaps: the jumps among them, the longest of each row.  step (T,): from 1; position (T,): number of targets
    that were reached before, plus the share of the way to the next one; time (T,); iterations (T,) of
    Newton's method; yields: whether fc > 0; tangent
    (T, 3, 3): as in `Update`; rows of a file have none.
    """

    separation: Floats
    traction: Floats
    damage: Floats
    state: Floats
    work: Floats
    events: tuple[tuple[int, str], ...] = ()
    snaps: tuple[Snap, ...] = ()
    n_planes: int | None = None
    step: NDArray[np.int_] = field(default_factory=lambda: np.zeros(0, dtype=int))
    position: Floats = field(default_factory=lambda: np.zeros(0))
    time: Floats = field(default_factory=lambda: np.zeros(0))
    iterations: NDArray[np.int_] = field(default_factory=lambda: np.zeros(0, dtype=int))
    p: Floats = field(default_factory=lambda: np.zeros(0))
    aperture: Floats = field(default_factory=lambda: np.zeros(0))
    tangent: Floats = field(default_factory=lambda: np.zeros((0, 3, 3)))
    yields: bool = False

    def __post_init__(self) -> None:
        """Make the arrays read-only; what is not given of p, a_0 and a_min is zero."""
        if self.p.size == 0:
            object.__setattr__(self, "p", np.zeros(len(self.damage)))
        if self.aperture.size == 0:
            object.__setattr__(self, "aperture", np.maximum(0.0, self.separation[:, 0]))
        _freeze(*(getattr(self, name) for name in ARRAYS))

    def __len__(self) -> int:
        """Number of rows."""
        return len(self.damage)

    def __repr__(self) -> str:
        """Number of rows, and the last one."""
        if len(self) == 0:
            return "History(no rows)"
        s, t = (", ".join(f"{value:.5g}" for value in rows[-1]) for rows in (self.separation, self.traction))
        counts = f"rows: {len(self)}, events: {len(self.events)}"
        return f"History({counts}; at the end s = ({s}), t = ({t}), damage {self.damage[-1]:.4g})"

    @property
    def dilation(self) -> Floats:
        """Opening s_N of the rows, length; it begins negative under pressure."""
        return self.separation[:, 0]

    @property
    def tau(self) -> Floats:
        """Traction along the slip of the history, stress."""
        return self.tau_along()

    def tau_along(self, direction: float | None = None) -> Floats:
        """Shear traction along a direction, degrees from Tx towards Ty; None: that of the slip."""
        return self.traction[:, 1:] @ self._along(direction)

    def slip_along(self, direction: float | None = None) -> Floats:
        """Slip along a direction, length; None: along the first slip of at least half the largest size.

        Examples
        --------
        >>> from asperity import Interface, Material, Pattern
        >>> joint = Interface(Material(3.0, 0.3, 0.9, 0.5), Pattern.regular(0, 0.0))
        >>> test = joint.confined_slip(30.0, [0.1, 0.4], sigma_N=-1.0)
        >>> test.slip_along().round(9).tolist(), test.slip_along(120.0).round(9).tolist()
        ([0.1, 0.4], [0.0, 0.0])
        >>> round(float(test.tau[-1]), 9)
        0.5
        """
        return self.separation[:, 1:] @ self._along(direction)

    def _along(self, direction: float | None) -> Floats:
        if direction is not None:
            angle = contract.number("direction", direction)
            if not np.isfinite(angle):
                raise ValueError(f"direction = {angle:g}: expected a finite angle in degrees")
            return direction_vector(angle)
        slip = self.separation[:, 1:]
        size = np.hypot(*slip.T)
        if not size.any():
            return np.array([1.0, 0.0])
        first = (size >= 0.5 * size.max()).argmax()
        along: Floats = slip[first] / size[first]
        return along

    def with_aperture(self, a_0: float, a_min: float = 0.0) -> History:
        """The same rows with other apertures, max(a_min, a_0 + s_N), length, as in the cubic law of a flow.

        a_0: aperture where s_N = 0.  a_min: least one, >= 0.  Raises ValueError for other values.

        Examples
        --------
        >>> from asperity import Interface, Material, Pattern
        >>> joint = Interface(Material(3.0, 0.3, 0.9, 0.5, kc=1e4), Pattern.regular(2, theta=30.0))
        >>> test = joint.confined_slip(0.0, [0.1, 0.4], sigma_N=-1.0).with_aperture(0.01, 0.001)
        >>> test.aperture.round(3).tolist()
        [0.068, 0.241]
        """
        first, least = contract.number("a_0", a_0), contract.number("a_min", a_min)
        for name, value, good in (("a_0", first, True), ("a_min", least, least >= 0.0)):
            if not (np.isfinite(value) and good):
                wanted = "a finite length" if name == "a_0" else "a finite length >= 0"
                raise ValueError(f"{name} = {value:g}: expected {wanted}")
        return replace(self, aperture=np.maximum(least, first + self.separation[:, 0]))

    @property
    def lost(self) -> bool:
        """Whether equilibrium is lost after the last row."""
        return any(row >= len(self) or "lost" in text for row, text in self.events)

    @property
    def end(self) -> Point:
        """Point of the last row, from which `Interface.run` may continue."""
        if len(self) == 0:
            raise ValueError("end: expected a history with rows")
        s_N, s_Tx, s_Ty = self.separation[-1].tolist()
        t_N, t_Tx, t_Ty = self.traction[-1].tolist()
        work, p = float(self.work[-1]), float(self.p[-1])
        return Point(self.state[-1], (s_N, s_Tx, s_Ty), work, p, (t_N, t_Tx, t_Ty))

    def after_step(self, step: int) -> History:
        """Rows after a step; the events before belong to the first of them.

        Raises ValueError for rows of a file, which have no steps.
        """
        if len(self.step) != len(self):
            raise ValueError(f"step = {step}: expected rows of Interface.run, rows of a file have no steps")
        n = int(np.sum(self.step <= step))
        rows = {name: getattr(self, name)[n:] for name in ARRAYS}
        before = {name for row, text in self.events if row < n for name in text.split("+")}
        events = {row - n: text for row, text in self.events if row >= n}
        if before and len(self) > n:
            names = before | {name for name in events.get(0, "").split("+") if name}
            later = {row: text for row, text in events.items() if row > 0}
            events = {0: "+".join(sorted(names, key=EVENTS.index))} | later
        snaps = tuple(replace(snap, row=max(snap.row - n, 0)) for snap in self.snaps)
        return replace(self, events=tuple(events.items()), snaps=snaps, **rows)

    def ended(self, text: str) -> History:
        """The same rows with this text as the event after the last one."""
        events = tuple((row, name) for row, name in self.events if row < len(self))
        return replace(self, events=(*events, (len(self), text)))

    def columns(self, planes: bool = False) -> dict[str, Any]:
        """Columns by their names in the results of the driver, as for `pandas.DataFrame(history.columns())`.

        planes: also the state of every plane.
        """
        table: dict[str, Any] = dict(zip(SEPARATION, self.separation.T, strict=True))
        table |= dict(zip(TRACTION, self.traction.T, strict=True))
        table |= {"p": self.p, "aperture": self.aperture, "damage": self.damage} | {
            name: getattr(self, name) for name in ENERGIES
        }
        table["event"] = self._events()
        if planes:
            names = contract.statev_names(self.planes, self.wears, self.yields)
            table |= {name: self.state[:, i] for i, name in enumerate(names) if i >= contract.N_POINT_STATEV}
        return table

    def to_csv(self, path: str | Path, planes: bool = False) -> None:
        """Write the columns of `columns` to a CSV file, with all digits."""
        columns = self.columns(planes)
        values = [column if isinstance(column, list) else column.tolist() for column in columns.values()]
        with Path(path).open("w", encoding="utf-8", newline="") as file:
            rows = csv.writer(file, lineterminator="\n")
            rows.writerow(columns)
            rows.writerows(zip(*values, strict=True))

    @classmethod
    def from_csv(cls, path: str | Path) -> History:
        """Rows of a CSV file of the driver or of `to_csv`, without the state of the planes.

        p and aperture may be absent.

        Raises ValueError if a column or all rows are missing, and for every cell that is no finite number.
        """
        table = csv_columns(path)
        if missing := [name for name in COLUMNS if name not in table and name not in ("p", "aperture")]:
            raise ValueError(f"{path}: expected columns {', '.join(missing)}")
        if not table["event"]:
            raise ValueError(f"{path}: expected rows after the header")
        numbers = {name: finite_column(path, table, name) for name in COLUMNS[:-1] if name in table}
        state = np.zeros((len(table["event"]), contract.N_POINT_STATEV))
        for name in ("damage", *ENERGIES[:3]):
            state[:, contract.statev_index(name)] = numbers[name]
        events = tuple((row, text) for row, text in enumerate(table["event"]) if text)
        s, t = (np.column_stack([numbers[name] for name in names]) for names in (SEPARATION, TRACTION))
        p, aperture = (numbers.get(name, np.zeros(0)) for name in ("p", "aperture"))
        return cls(s, t, numbers["damage"], state, numbers["work"], events, p=p, aperture=aperture)

    def _events(self) -> list[str]:
        """Events of each row, joined by +; one after the last row belongs to it."""
        texts = [""] * len(self)
        for row, text in self.events:
            i = min(row, len(self) - 1)
            if i >= 0:
                texts[i] = f"{texts[i]}+{text}" if texts[i] else text
        return texts


class EquilibriumLost(RuntimeError):
    """No equilibrium was found for the row with number `row`; `history` holds the rows before it.

    If the preload has no equilibrium, there are no rows and `row` is 0.
    """

    def __init__(self, message: str, history: History) -> None:
        """Message and converged rows."""
        super().__init__(message)
        self.history = history

    @property
    def row(self) -> int:
        """Number of the row without equilibrium, from 0."""
        return len(self.history.damage)

    def __reduce__(self) -> tuple[type[EquilibriumLost], tuple[str, History]]:
        """Arguments for pickle, which sends the exception between processes."""
        return type(self), (str(self), self.history)


def _freeze(*arrays: Floats) -> None:
    for array in arrays:
        array.flags.writeable = False


def csv_columns(path: str | Path) -> dict[str, list[str]]:
    """Cells of a CSV file by the names in its first line; raises ValueError where a line has other values."""
    with Path(path).open(encoding="utf-8-sig", errors="replace", newline="") as file:
        lines = csv.reader(file)
        names = next(lines, [])
        rows = []
        for row in lines:
            if len(row) not in (0, len(names)):
                raise ValueError(f"{path}: line {lines.line_num}: {len(row)} values: expected {len(names)}")
            rows += [row] if row else []
    columns = zip(*rows, strict=True) if rows else ((),) * len(names)
    return {name: [*cells] for name, cells in zip(names, columns, strict=True)}


def finite_column(path: str | Path, table: dict[str, list[str]], name: str) -> Floats:
    """Column of `csv_columns` as numbers; raises ValueError for the first cell that is no finite number."""
    cells = table[name]
    # float alone is fast, but ends at a cell that is no number, and takes 1_0 for 10
    numbers_alone = "_" not in "".join(cells)
    try:
        numbers = np.array([*map(float if numbers_alone else _number, cells)])
    except ValueError:
        numbers = np.array([*map(_number, cells)])
    bad = np.flatnonzero(~np.isfinite(numbers))
    if len(bad):
        place = f"line {bad[0] + 2}, column {name}: {cells[bad[0]] or 'empty'}"
        raise ValueError(f"{path}: {place}: expected a finite number")
    return numbers


def _number(cell: str) -> float:
    """Number of a cell, nan if there is none."""
    try:
        return float(cell.replace("_", "?"))
    except ValueError:
        return np.nan
