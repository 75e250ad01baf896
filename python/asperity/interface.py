"""The interface law for arrays of points and for the history of one point."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from . import _core, contract
from .cards import blocks as cards
from .contract import Floats
from .errors import EquilibriumLost, InputError, slip_words
from .history import History, Update
from .load_path import no_rows, rows_of
from .material import Material, ModelWarning
from .model_checks import check_model, warn_of_physics
from .pattern import Pattern
from .steps import Point, Step, slip_path


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
        made_by = {"material": (Material, "Material(...)"), "pattern": (Pattern, "Pattern.regular(8, theta)")}
        for name, (kind, call) in made_by.items():
            if not isinstance(given := getattr(self, name), kind):
                raise ValueError(f"{name} = {contract.shown(given)}: expected a {kind.__name__}, as {call}")
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
        out: tuple[Floats, Floats, Floats] | None = None,
    ) -> Update:
        """Take n points over one increment; the arguments are not modified, except for out.

        Parameters
        ----------
        s
            Separation at the end (n, 3), length.
        state, s_old
            State (n, nstatv) and separation (n, 3) at the start; None means zero, a virgin point. s_old
            enters the energies, the guard and, with facets that wear, their wear.
        dt
            Duration of the increment, time, used only if tau_v > 0 and then required.
        out
            Arrays to which traction (n, 3), state (n, nstatv) and tangent (n, 3, 3) are written: contiguous
            doubles in C order. The state at the end may replace that at the start: `out[1] is state`.

        Returns
        -------
        Update
            Traction, state and tangent; with out it shows these arrays, so it changes with them.

        Raises
        ------
        ValueError
            For wrong shapes and for values that are missing, not finite or out of range. A state that was to
            be replaced is then unchanged.

        Examples
        --------
        >>> import numpy as np
        >>> from asperity import Interface, Material, Pattern
        >>> joint = Interface(Material(3.0, 0.3, 0.9, 0.5), Pattern.regular(4, 30.0))
        >>> s_old, state = np.zeros((2, 3)), np.zeros((2, joint.nstatv))
        >>> out = np.empty((2, 3)), state, np.empty((2, 3, 3))
        >>> for slip in (0.01, 0.02, 0.03):
        ...     s = np.array([[0.0, slip, 0.0], [0.0, 0.0, slip]])
        ...     end = joint.update(s, state, s_old, out=out)
        ...     s_old = s
        >>> bool(end.damage[0] == state[0, 0] > 0.0)
        True
        """
        s = _array("s", s, 3)
        n = len(s)
        start = None if state is None else _array("state", state, self.nstatv, n)
        s_old = np.zeros((n, 3)) if s_old is None else _array("s_old", s_old, 3, n)
        shapes = (n, 3), (n, self.nstatv), (n, 3, 3)
        if out is None:
            traction, new, tangent = map(np.empty, shapes)
        else:
            traction, new, tangent = _outputs(out, shapes, {"s": s, "state": start, "s_old": s_old})
        duration = 0.0 if self._is_missing("dt", dt) else float(dt)
        if start is None:
            new[:] = 0.0
        elif start is not new:
            new[:] = start
        if n > 0:  # f2py accepts no empty arrays
            _raise(
                *_core.interface_update(self._props, s_old.T, s.T, duration, new.T, traction.T, tangent.T),
            )
        return Update(traction.view(), new.view(), tangent.view(), self.n_planes)

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

    def run(
        self,
        steps: Sequence[Step] | Step,
        state: ArrayLike | Point | None = None,
        tolerance: float | None = None,
    ) -> History:
        """Take one point along a load path; each row is the end of an increment.

        Parameters
        ----------
        steps
            The load path, as the groups `&step` of a case file: what is prescribed for each component.
        state
            Start: STATEV (nstatv,) at separation zero, as from `initial`; a `Point`, as `History.end` of an
            earlier run; None is a virgin point.
        tolerance
            1e-8 to 0.1: the increments are halved until the rows of two runs of the whole path agree, and
            rows are left out where straight lines stay within the tolerance. It is relative to the largest
            traction (at least sigma0), separation (at least s_f) and work (at least Gc). Where the path
            jumps, it is the distance between the curves.

        Returns
        -------
        History
            The rows of all steps.

        Raises
        ------
        ValueError
            For every value that is out of range, by its name, and for a tolerance that is not reached.
        EquilibriumLost
            Where no equilibrium is found, with the rows before and the reason.

        Warns
        -----
        ModelWarning
            As `confined_slip`, for the largest pressure and slip of the rows.

        Examples
        --------
        >>> from asperity import Interface, Material, Pattern, Step
        >>> joint = Interface(Material(3.0, 0.3, 0.9, 0.5, kc=20.0), Pattern.regular(4, 30.0))
        >>> start = joint.initial([-0.2, 0.0, 0.0], damage=0.3)
        >>> path = [Step(t_N=-0.4, increments=20), Step(slip=[0.4, -0.4], direction=20.0, increments=160)]
        >>> test = joint.run(path, start)
        >>> len(test), round(float(test.damage[-1]), 12)
        (340, 1.0)
        >>> round(float(joint.run(Step(slip=0.0, increments=80), test.end).separation[-1, 1]), 6)
        0.0
        """
        history, lost = self.rows(steps, state, tolerance)
        path = [steps] if isinstance(steps, Step) else steps
        if state is None and path[0].s_N is None and path[0].t_N is None and path[0].slip is not None:
            text = "steps[0]: neither t_N nor s_N is given, so s_N is held at 0"
            warnings.warn(text, ModelWarning, stacklevel=2)
        prescribed = (np.max(step.t_N) for step in path if step.t_N is not None)
        warn_of_physics(
            self.material,
            self.pattern,
            history.traction[:, 0].min(initial=0.0),
            max(prescribed, default=0.0),
            slip=np.hypot(*history.separation[:, 1:].T).max(initial=0.0),
        )
        if lost:
            raise EquilibriumLost(lost, history)
        return history

    def rows(
        self,
        steps: Sequence[Step] | Step,
        state: ArrayLike | Point | None = None,
        tolerance: float | None = None,
    ) -> tuple[History, str]:
        """Rows of a load path, and why it ends before its end ("" if it does not).

        It is `run` without its warnings and without `EquilibriumLost`, for many runs in threads: the library
        works without the lock of the interpreter.
        """
        start = self._start(state)
        return rows_of(
            self._props, self.n_planes, [steps] if isinstance(steps, Step) else steps, start, tolerance
        )

    def _start(self, state: ArrayLike | Point | None) -> Point:
        """Start of a path; raises ValueError for a wrong shape."""
        point = Point(np.zeros(self.nstatv)) if state is None else state
        if not isinstance(point, Point):
            point = Point(contract.array("state", state))
        separation = contract.array("separation", point.separation)
        for name, value, size in (("state", point.state, self.nstatv), ("separation", separation, 3)):
            if np.shape(value) != (size,):
                raise ValueError(f"{name} has shape {np.shape(value)}: expected ({size},)")
        return point

    def replay(self, S: ArrayLike, times: ArrayLike | None = None) -> History:
        """Take one virgin point along separations; each row is the end of an increment.

        Parameters
        ----------
        S
            Separations (T, 3), length.
        times
            Ends of the increments (T,), which start at 0, not decreasing; required if tau_v > 0.

        Returns
        -------
        History
            T rows.

        Raises
        ------
        ValueError
            For a wrong shape and for values that are missing, not finite or too large.

        Examples
        --------
        >>> from asperity import Interface, Material, Pattern
        >>> flat = Interface(Material(3.0, 0.3, 0.9, 0.5), Pattern.regular(0, 0.0))
        >>> flat.replay([[0.02, 0.0, 0.0], [0.2, 0.0, 0.0]]).traction[:, 0].round(12).tolist()
        [3.0, 0.0]
        """
        S = _array("S", S, 3)
        durations = np.diff(self._times(times, len(S)), prepend=0.0)
        if len(S) == 0:
            return self._empty()
        step = Step(s_N=S[:, 0], s_Tx=S[:, 1], s_Ty=S[:, 2], increments=1, time=durations)
        try:
            history, lost = self.rows(step)
        except InputError as error:
            rows = f"(of 0 to {len(S) - 1})"
            texts = (
                f"row {one.at} {rows}: {one.name} = {one.value}: {one.text}" if one.at >= 0 else one.words
                for one in error.records
            )
            raise ValueError("\n".join(texts)) from None
        if lost:
            raise EquilibriumLost(lost, history)
        return history

    def confined_slip(
        self,
        direction: float,
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
        """Slip test of Section 4: slips along a direction under a constant normal traction, zero across it.

        Parameters
        ----------
        direction
            Direction of the slip, degrees, from Tx towards Ty.
        slips
            Slips (T,), length, that are reached one after the other: a row for each of them or, with a
            tolerance or follow="branch", as many rows as it takes.
        sigma_N
            Normal traction, stress. It is applied first at zero slip, which may damage the joint and gives no
            row, and is then constant.
        preload
            Number of increments of sigma_N.
        times
            Times (T,) of the slips, from 0 at the end of the preload, not decreasing; required if tau_v > 0.
        preload_time
            Duration of the preload.
        tolerance
            As in `run`.
        stiffness
            Of the surroundings (CNS, constant normal stiffness), >= 0, stress/length: from the start of the
            slip on, the normal traction changes by -stiffness times the change of s_N.
        follow, arc
            As in `Step`: follow="branch" continues along the unstable part, where "stable" jumps.

        Returns
        -------
        History
            Rows of the slip; its work includes that of the preload.

        Raises
        ------
        ValueError
            For wrong input.
        EquilibriumLost
            Where no equilibrium is found, with the rows before.

        Warns
        -----
        ModelWarning
            With the sentences of the driver (docs/reference/driver.md), for the largest pressure and slip.

        Examples
        --------
        >>> from asperity import Interface, Material, Pattern
        >>> flat = Interface(Material(3.0, 0.3, 0.9, 0.5), Pattern.regular(0, 0.0))
        >>> flat.confined_slip(0.0, [0.1, 0.2, 0.3], -1.0).traction[-1].round(6).tolist()
        [-1.0, 0.5, 0.0]
        """
        slips = contract.array("slips", slips)
        sigma_N = contract.number("sigma_N", sigma_N, "a finite traction")
        if slips.ndim != 1:
            raise ValueError(f"slips have shape {slips.shape}: expected (T,)")
        times = self._times(times, len(slips))
        if not 0.0 <= preload_time < np.inf:
            raise ValueError(f"preload_time = {preload_time!r}: expected a finite time >= 0")
        path = slip_path(
            contract.number("direction", direction, "a finite angle"),
            slips if slips.size else [0.0],
            sigma_N,
            contract.number("preload", preload, "a whole number from 1 on"),
            contract.number("stiffness", stiffness, "a finite stiffness >= 0"),
            times,
            preload_time,
            follow,
            arc,
            each=tolerance is None,
        )
        try:
            history, lost = self.rows(path, tolerance=tolerance)
        except InputError as error:
            raise ValueError("\n".join(filter(None, map(slip_words, error.records)))) from None
        slip = abs(slips).max(initial=0.0)
        pressed = history.traction[:, 0].min(initial=0.0)
        warn_of_physics(self.material, self.pattern, sigma_N, pressed, slip=slip)
        reached = int(history.position[-1]) - 1 if len(history) else -1
        history = history.after_step(1)
        if slips.size == 0:
            return self._empty()
        if lost:
            why = lost.partition(": ")[2]
            if reached < 0:
                where, text = "", f"no equilibrium in the preload to sigma_N = {sigma_N:g}"
            else:
                each = tolerance is None and follow == "stable"
                where = f"row {len(history)} (of 0 to {len(slips) - 1}): " if each else ""
                place = "at" if each else "before"
                text = f"no equilibrium {place} slip {slips[reached]:g}, sigma_N = {sigma_N:g}"
            history = history.ended(text)
            raise EquilibriumLost(f"{where}{text}: {why}", history)
        return history

    def _empty(self) -> History:
        return no_rows(self.nstatv, self.n_planes)

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
        direction: float | None = None,
        notes: Sequence[str] = (),
    ) -> str:
        """Material block of the input of a host: "abaqus", "akantu", "calculix", "fenicsx", "kratos",
        "mtest", "ogs" or "oofem".

        explicit: for Abaqus/Explicit, which needs a density (mass per area and thickness h).  stress: largest
        compression, sigma_N < 0; modulus and size: E of the solid beside the interface and length of its
        elements; direction: of the slip, degrees from Tx towards Ty.  They are checked: the findings go into
        the block after the notes, and problems also give a ModelWarning.
        Raises ValueError for an unknown host, a value out of range, or what the host cannot take.
        """
        found = check_model(self.material, self.pattern, stress, modulus, size, direction)
        texts = [*notes]
        texts += [one.text if one.good else f"WARNING: {one.text}" for one in found]
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
        for one in found:
            if not one.good:
                warnings.warn(one.text, ModelWarning, stacklevel=2)
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


def _array(name: str, value: ArrayLike, columns: int, rows: int | None = None) -> Floats:
    """Contiguous array of doubles of shape (rows, columns)."""
    array = contract.array(name, value)
    if array.ndim != 2 or array.shape[1] != columns or rows not in (None, len(array)):
        expected = f"({'n' if rows is None else rows}, {columns})"
        raise ValueError(f"{name} has shape {array.shape}: expected {expected}")
    return array


def _outputs(
    out: Sequence[Floats], shapes: Sequence[tuple[int, ...]], inputs: dict[str, Floats | None]
) -> Sequence[Floats]:
    """Arrays for traction, state and tangent; raises ValueError for one that cannot be written to."""
    if not isinstance(out, Sequence):
        raise ValueError(f"out = {contract.shown(out)}: expected traction, state and tangent")
    if len(out) != len(shapes):
        raise ValueError(f"out has {len(out)} entries: expected traction, state and tangent")
    taken = dict(inputs)
    for i, (array, shape) in enumerate(zip(out, shapes, strict=True)):
        name = f"out[{i}]"
        if not isinstance(array, np.ndarray) or array.dtype != np.float64 or not array.flags.carray:
            found = f"a {array.dtype} array" if isinstance(array, np.ndarray) else contract.shown(array)
            raise ValueError(f"{name} is {found}: expected writable float64, contiguous in C order")
        if array.shape != shape:
            raise ValueError(f"{name} has shape {array.shape}: expected {shape}")
        for other, values in taken.items():
            in_place = i == 1 and other == "state" and values is array
            # exact for contiguous arrays
            if not in_place and values is not None and np.may_share_memory(values, array):
                raise ValueError(f"{name} overlaps {other}: expected memory of its own")
        taken[name] = array
    return out


def _raise(status: int, message: bytes) -> None:
    """Raise ValueError with the message of the library, if there is one."""
    if status != 0:
        raise ValueError(message.decode("ascii").rstrip())
