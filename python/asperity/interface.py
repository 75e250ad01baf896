"""The interface law for arrays of points and for the history of one point."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core, contract
from .cards import blocks as cards
from .contract import Floats
from .history import History, Snap, Update
from .material import Material, ModelWarning
from .pattern import Pattern
from .remarks import remarks, warn_of_physics

DEFAULT_ARC = 0.05
"""Longest step along a branch over s0, as in the driver."""


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


@dataclass(frozen=True)
class Interface:
    """Rough quasi-brittle interface: a material on a pattern of planes (Albarella et al. 2015).

    Components are (N, Tx, Ty), tension and opening positive; units are the user's consistent set.
    Raises ValueError naming every value out of range.
    """

    material: Material
    pattern: Pattern
    n_planes: int = field(init=False, repr=False, compare=False)
    _props: Floats = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        """Pack the constants."""
        props = self._pack()
        props.flags.writeable = False
        object.__setattr__(self, "_props", props)
        object.__setattr__(self, "n_planes", contract.check(props))

    @property
    def nstatv(self) -> int:
        """State variables of a point."""
        return contract.n_statev(self.n_planes, self.material.wears)

    def update(
        self,
        s: ArrayLike,
        state: ArrayLike | None = None,
        s_old: ArrayLike | None = None,
        dt: float | None = None,
    ) -> Update:
        """Take n points over one increment; the arguments are not modified.

        s (n, 3): separation at the end, length.  state (n, nstatv) and s_old (n, 3): state and separation at
        the start; None means zero, a virgin point.  s_old enters the energies, the guard and, with W0 > 0,
        the wear.  dt: duration of the increment, time, used only if tau_v > 0 and then required.  Raises
        ValueError for wrong shapes and for values that are missing, not finite or out of range.
        """
        s = _array("s", s, 3)
        n = len(s)
        new = np.zeros((n, self.nstatv)) if state is None else _array("state", state, self.nstatv, n).copy()
        s_old = np.zeros((n, 3)) if s_old is None else _array("s_old", s_old, 3, n)
        traction, tangent = np.empty((n, 3)), np.empty((n, 3, 3))
        duration = 0.0 if self._is_missing("dt", dt) else float(dt)
        if n > 0:  # f2py accepts no empty arrays
            _raise(
                *_core.interface_update(self._props, s_old.T, s.T, duration, new.T, traction.T, tangent.T),
            )
        return Update(traction, new, tangent, self.n_planes)

    def initial(self, traction: ArrayLike, damage: ArrayLike = 0.0, slip: ArrayLike | None = None) -> Floats:
        """State (nstatv,) or (n, nstatv) of points that carry a traction (3,) or (n, 3) at separation zero.

        damage, 0 to 1: of all planes, or (Np,) of each.  slip, length: inelastic slips (s_dit, s_dih) of
        all planes, (2,), or of each, (Np, 2); None is zero.  The traction is applied in proportion, from
        zero; the separation that belongs to it becomes the offset (STATEV 6 to 8).  Rupture and friction
        count from this state on, so they are zero in it.  Raises ValueError for wrong input and for a
        traction that the state cannot carry; the message contains the traction that it can.
        """
        given = contract.array("traction", traction)
        tractions = _array("traction", np.atleast_2d(given), 3).copy()
        alpha = contract.array("damage", damage)
        if alpha.shape not in ((), (self.n_planes,)):
            raise ValueError(f"damage has shape {alpha.shape}: expected () or {(self.n_planes,)}")
        slips = contract.array("slip", (0.0, 0.0) if slip is None else slip)
        if slips.shape not in ((2,), (self.n_planes, 2)):
            raise ValueError(f"slip has shape {slips.shape}: expected (2,) or {(self.n_planes, 2)}")
        state = np.zeros((len(tractions), self.nstatv))
        shape = (len(tractions), self.n_planes, contract.N_PLANE_STATEV)
        planes = state[:, contract.N_POINT_STATEV : contract.n_statev(self.n_planes)].reshape(shape)
        planes[:, :, 0] = alpha
        planes[:, :, 1:] = slips
        if len(tractions) > 0:
            _raise(*_core.interface_initial(self._props, tractions.T, state.T))
        return state[0] if given.ndim == 1 else state

    def replay(self, S: ArrayLike, times: ArrayLike | None = None) -> History:
        """Take one virgin point along the separations S (T, 3), length; each row is the end of an increment.

        times (T,): ends of the increments, which start at 0, not decreasing; required if tau_v > 0.  Raises
        ValueError for a wrong shape and for values that are missing, not finite or too large.
        """
        S = _array("S", S, 3)
        traction, state = np.empty((len(S), 3)), np.empty((len(S), self.nstatv))
        steps = np.diff(self._times(times, len(S)), prepend=0.0)
        if len(S) > 0:
            _raise(*_core.interface_replay(self._props, S.T, steps, traction.T, state.T))
        return self._history(S.copy(), traction, state, work_along(S, traction))

    def confined_slip(
        self,
        direction_deg: float,
        slips: ArrayLike,
        sigma_N: float,
        preload: int = 100,
        times: ArrayLike | None = None,
        preload_time: float = 0.0,
        tolerance: float | None = None,
        stiffness: float = 0.0,
        follow: str = "stable",
        arc: float | None = None,
    ) -> History:
        """Slip test of Section 4 under a constant normal traction: a row for each of the slips (T,), length.

        The slip is along direction_deg (degrees, from Tx towards Ty), zero across it.  sigma_N, stress, is
        applied first at zero slip in `preload` increments, which may damage the joint and give no row, and is
        then constant.  stiffness >= 0, stress/length, is that of the surroundings (CNS, constant normal
        stiffness): from the start of the slip on, the normal traction changes by -stiffness times the change
        of s_N.  times (T,): of the slips, from 0 at the end of the preload, not decreasing, required if
        tau_v > 0; the preload takes preload_time.

        With a tolerance (1e-8 to 0.1) the slips are the reversals of the path and increments are adaptive,
        also in the preload.  The rows are then the increments: straight lines between them are off by at most
        the tolerance times the larger of sigma0 and the largest traction so far (traction), or of s_f and the
        largest s_N so far (s_N).  The energies of the state and the work are extrapolated (Richardson): the
        area under tau is the change of work less that of sigma_N s_N.

        follow="branch" continues along the unstable part of a branch, where follow="stable" jumps. The slips
        are then targets that are reached one after the other; in between the slip may turn back and forward
        again, which the event turn names. Every step along the branch is a row; it moves the separation by at
        most arc (1e-5 to 1, 0.05 without a value) times s0, or by four times that where all planes are fully
        damaged.

        Raises ValueError for wrong input and EquilibriumLost, with the converged rows, where no equilibrium
        is found; warns where sigma_N closes an inclined plane by more than a small fraction of s_f or of the
        asperity height, where a plane locks or may wear off in a jump, where the height is below s_f, where
        theta may be in radians, and where sigma_N is not below the strength.
        """
        slips = contract.array("slips", slips)
        direction_deg = contract.number("direction_deg", direction_deg, "a finite angle")
        sigma_N = contract.number("sigma_N", sigma_N, "a finite traction")
        preload = contract.whole("preload", preload)
        stiffness = contract.number("stiffness", stiffness, "a finite stiffness >= 0")
        if slips.ndim != 1:
            raise ValueError(f"slips have shape {slips.shape}: expected (T,)")
        n = n_done = len(slips)
        times = self._times(times, n)
        if not 0.0 <= preload_time < np.inf:
            raise ValueError(f"preload_time = {preload_time!r}: expected a finite time >= 0")
        if follow not in ("stable", "branch"):
            raise ValueError(f"follow = {follow!r}: expected 'stable' or 'branch'")
        if follow == "branch":
            if tolerance is not None:
                raise ValueError(f"tolerance = {tolerance!r}: expected None with follow = 'branch'")
            if preload_time != 0.0 or times.any():
                raise ValueError("times or preload_time with follow = 'branch': expected none")
            warn_of_physics(self.material, self.pattern, sigma_N)
            return self._branch_slip(direction_deg, slips, sigma_N, preload, stiffness, arc)
        if arc is not None:
            raise ValueError(f"arc = {arc!r}: expected None with follow = 'stable'")
        if tolerance is not None:
            if stiffness != 0.0:
                raise ValueError(f"stiffness = {stiffness:g}: expected 0 with a tolerance")
            if self.material.wears:
                raise ValueError(
                    f"tolerance = {tolerance:g} with W0 = {self.material.W0:g}: expected increments (slips) "
                    "instead, on which wear depends to first order"
                )
            warn_of_physics(self.material, self.pattern, sigma_N)
            return self._adaptive_slip(
                direction_deg, slips, sigma_N, float(tolerance), times, float(preload_time)
            )
        separation, traction, state = np.empty((n, 3)), np.empty((n, 3)), np.empty((n, self.nstatv))
        work, jumps = np.empty(n), np.zeros((n + 1, 9))
        if n > 0:
            n_done, status, message = _core.interface_confined_slip(
                self._props, direction_deg, slips, sigma_N, preload,
                times, float(preload_time), stiffness,
                separation.T, traction.T, state.T, work, jumps.T,
            )  # fmt: skip
            _raise(status, message)
            warn_of_physics(self.material, self.pattern, sigma_N)
        rows = max(n_done, 0)
        lost = ""
        if n_done < 0:
            lost = f"no equilibrium in the preload to sigma_N = {sigma_N:g}"
        elif n_done < n:
            lost = f"no equilibrium at slip {slips[n_done]:g}, sigma_N = {sigma_N:g}"
        history = self._history(separation[:rows], traction[:rows], state[:rows], work[:rows], lost, jumps)
        if lost:
            where = "" if n_done < 0 else f"row {n_done} (of 0 to {n - 1}): "
            raise EquilibriumLost(where + lost, history)
        return history

    def _adaptive_slip(
        self,
        direction: float,
        turns: Floats,
        sigma_N: float,
        tolerance: float,
        times: Floats,
        preload_time: float,
    ) -> History:
        """Rows of adaptive increments between reversals."""
        if len(turns) == 0:
            return self._history(np.empty((0, 3)), np.empty((0, 3)), np.empty((0, self.nstatv)), np.empty(0))
        rows = 512
        while True:
            room = rows
            separation, traction = np.empty((room, 3)), np.empty((room, 3))
            state, work = np.empty((room, self.nstatv)), np.empty(room)
            rows, reached, status, message = _core.interface_adaptive_slip(
                self._props, direction, turns, sigma_N, tolerance,
                times, preload_time, separation.T, traction.T, state.T, work,
            )  # fmt: skip
            _raise(status, message)
            if rows <= room:
                break
        return self._ended((separation, traction, state, work), rows, turns, reached, sigma_N)

    def _branch_slip(
        self,
        direction: float,
        slips: Floats,
        sigma_N: float,
        preload: int,
        stiffness: float,
        arc: float | None,
    ) -> History:
        """Rows along the branch to each of the slips."""
        longest = DEFAULT_ARC if arc is None else contract.number("arc", arc, "a finite number")
        rows = 1024
        while True:
            room = rows
            separation, traction = np.empty((room, 3)), np.empty((room, 3))
            state, work = np.empty((room, self.nstatv)), np.empty(room)
            jumps, turned = np.zeros((room + 1, 9)), np.zeros(room, dtype=np.int32)
            if len(slips) == 0:
                rows, reached, message = 0, 0, b""
                break
            rows, reached, status, message = _core.interface_branch_slip(
                self._props, direction, slips, sigma_N, preload, stiffness, longest,
                separation.T, traction.T, state.T, work, jumps.T, turned,
            )  # fmt: skip
            _raise(status, message)
            if rows <= room:
                break
        why = message.decode("ascii").rstrip()
        return self._ended(
            (separation, traction, state, work), rows, slips, reached, sigma_N, why, (jumps, turned)
        )

    def _ended(
        self,
        buffers: tuple[Floats, ...],
        rows: int,
        targets: Floats,
        reached: int,
        sigma_N: float,
        why: str = "",
        events: tuple[Floats, ...] = (),
    ) -> History:
        """History of the used rows; EquilibriumLost unless every target was reached (< 0: preload)."""
        lost = ""
        if reached < 0:
            lost = f"no equilibrium in the preload to sigma_N = {sigma_N:g}"
        elif reached < len(targets):
            lost = f"no equilibrium before slip {targets[reached]:g}, sigma_N = {sigma_N:g}"
            lost += f": {why}" if why else ""
        # copies of the used rows free the larger buffers
        history = self._history(*(part[:rows].copy() for part in buffers), lost, *events)
        if lost:
            raise EquilibriumLost(lost, history)
        return history

    def props(
        self,
        h: float = contract.default("h"),
        map: int = int(contract.default("map")),
        dalpha: float = contract.default("dalpha"),
        r: float = contract.default("r"),
    ) -> Floats:
        """Vector PROPS for a host, contract.props_table(); h is the thickness it divides by.

        Raises ValueError naming every value out of range.
        """
        return self._pack(h=h, map=map, dalpha=dalpha, r=r)

    def _pack(self, **of_host: float) -> Floats:
        """Vector PROPS, checked."""
        values = self.material.values() | self.pattern.values() | of_host
        props = contract.pack(values, self.pattern.constants())
        contract.check(props)
        return props

    def card(
        self,
        host: str,
        h: float = contract.default("h"),
        map: int = int(contract.default("map")),
        dalpha: float = contract.default("dalpha"),
        r: float = contract.default("r"),
        name: str = "INTERFACE",
        dimension: int = 3,
        explicit: bool = False,
        density: float | None = None,
        stress: float | None = None,
        modulus: float | None = None,
        size: float | None = None,
    ) -> str:
        """Material block of the input of a host: "abaqus", "akantu", "calculix", "kratos", "ogs" or "oofem".

        explicit: for Abaqus/Explicit, which needs a density (mass per area and thickness h).  stress: largest
        compression, sigma_N < 0; modulus and size: E of the solid beside the interface and length of its
        elements.  They are checked: remarks go into the block, and problems also give a ModelWarning.
        Raises ValueError for an unknown host, a value out of range, or what the host cannot take.
        """
        found = remarks(self.material, self.pattern, stress, modulus, size)
        texts = [remark.text if remark.good else f"WARNING: {remark.text}" for remark in found]
        block = cards.Block(
            name,
            self.props(h, map, dalpha, r),
            contract.statev_names(self.n_planes, self.material.wears),
            texts,
            dimension,
            explicit,
            density,
        )
        text = cards.card(host, block)
        for remark in found:
            if not remark.good:
                warnings.warn(remark.text, ModelWarning, stacklevel=2)
        return text

    def _is_missing(self, name: str, value: object) -> bool:
        """Return whether the time is None; raises ValueError if viscous damage needs a time."""
        if value is None and self.material.tau_v > 0.0:
            tau_v = self.material.tau_v
            raise ValueError(f"{name} is missing: expected for viscous damage, tau_v = {tau_v:g}")
        return value is None

    def _times(self, times: ArrayLike | None, rows: int) -> Floats:
        """Times (rows,), zeros if none are given."""
        if self._is_missing("times", times):
            return np.zeros(rows)
        array = contract.array("times", times)
        if array.shape != (rows,):
            raise ValueError(f"times have shape {array.shape}: expected ({rows},)")
        before = np.concatenate([[0.0], array])[:-1]
        bad = np.flatnonzero(~(np.isfinite(array) & (array >= before)))
        if bad.size > 0:
            i = bad[0]
            raise ValueError(
                f"times[{i}] = {array[i]:g}: expected a finite number from {before[i]:g}, the time before, on"
            )
        return array

    def _history(
        self,
        separation: Floats,
        traction: Floats,
        state: Floats,
        work: Floats,
        lost: str = "",
        jumps: Floats | None = None,
        turned: NDArray[np.int32] | None = None,
    ) -> History:
        """History with events.

        jumps (1 + T', 9): of preload and rows, as from interface_confined_slip.  turned (T',): of the rows,
        as from interface_branch_slip.
        """
        rows = len(separation)
        damage = contract.statev_index("damage")
        snaps: list[Snap] = []
        flags = np.zeros((rows, 3), dtype=np.int32)
        if jumps is not None:
            for i in np.flatnonzero(jumps[:, 0] > 0.0).tolist():
                before, after = (tuple(jumps[i, k : k + 3].tolist()) for k in (2, 5))
                snaps.append(Snap(max(i - 1, 0), before, after, float(jumps[i, 8])))
            flags[:, 0] = jumps[1 : rows + 1, 0] > 0.0
            flags[:, 2] = jumps[1 : rows + 1, 1] > 1.0
            flags[:1, 0] |= jumps[0, 0] > 0.0
        if turned is not None:
            flags[:, 1] = turned[:rows]
        names = np.zeros(rows, dtype="S64")
        if rows > 0:
            _core.interface_events(self._props, separation.T, state.T, flags.T, names)
        happened = enumerate(name.decode("ascii").rstrip() for name in names.tolist())
        events = tuple((row, name) for row, name in happened if name)
        if lost:
            events += ((rows, lost),)
        parts = separation, traction, state[:, damage].copy(), state, work
        return History(*parts, events, tuple(snaps), self.n_planes)


def work_along(separation: Floats, traction: Floats) -> Floats:
    """Work (T,) of a traction (T, 3) along separations (T, 3) that start at zero, by the trapezoidal rule."""
    before = np.concatenate([np.zeros((1, 3)), traction])[:-1]
    change = np.diff(separation, axis=0, prepend=0.0)
    return np.cumsum(0.5 * np.sum((before + traction) * change, axis=1))


def _array(name: str, value: ArrayLike, columns: int, rows: int | None = None) -> Floats:
    """Contiguous array of doubles of shape (rows, columns)."""
    array = contract.array(name, value)
    if array.ndim != 2 or array.shape[1] != columns or rows not in (None, len(array)):
        expected = f"({'n' if rows is None else rows}, {columns})"
        raise ValueError(f"{name} has shape {array.shape}: expected {expected}")
    return array


def _raise(status: int, message: bytes) -> None:
    """Raise ValueError with the message of the library, if there is one."""
    if status != 0:
        raise ValueError(message.decode("ascii").rstrip())
