"""The interface law for arrays of points and for the history of one point."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from . import _core, calls, contract
from .cards import blocks as cards
from .contract import Floats
from .errors import InputError, slip_words
from .history import EquilibriumLost, History, Stability, Update
from .load_path import rows_of
from .material import Material, ModelWarning
from .model_checks import check_model, warn_of_physics
from .pattern import Pattern
from .point_arrays import check_given, outputs, pressures, times_of
from .steps import Point, Step, largest_tension, slip_path


@dataclass(frozen=True)
class Interface:
    """Rough quasi-brittle interface: a material on a pattern of planes (Albarella et al. 2015).

    Components are (N, Tx, Ty), tension and opening positive; units are the user's consistent set.
    Raises ValueError naming every value out of range.
    """

    material: Material
    pattern: Pattern
    n_planes: int = field(init=False, repr=False, compare=False)
    nstatv: int = field(init=False, repr=False, compare=False)
    _props: Floats = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        """Pack the constants, and count planes and state variables."""
        made_by = {"material": (Material, "Material(...)"), "pattern": (Pattern, "Pattern.regular(8, theta)")}
        for name, (kind, call) in made_by.items():
            if not isinstance(part := getattr(self, name), kind):
                raise ValueError(f"{name} = {contract.shown(part)}: expected a {kind.__name__}, as {call}")
        props = self.props()
        props.flags.writeable = False
        sizes = contract.check(props)
        nstatv = contract.n_statev(*sizes, contract.yields(props))
        for name, value in (("_props", props), ("n_planes", sizes[0]), ("nstatv", nstatv)):
            object.__setattr__(self, name, value)

    def update(
        self,
        s: ArrayLike,
        state: ArrayLike | None = None,
        s_old: ArrayLike | None = None,
        dt: float | None = None,
        out: tuple[Floats, Floats, Floats] | None = None,
        aim: ArrayLike | None = None,
        p: ArrayLike | None = None,
    ) -> Update:
        """Take n points over one increment; the arguments are not modified, except for out.

        s (n, 3): separation at the end, length.  state (n, nstatv), s_old (n, 3): state and separation at the
        start; None means zero, a virgin point.  s_old enters the energies, the guard and, with facets that
        wear, their wear.  dt: duration of the increment, time, used only if tau_v or c > 0 and then required.
        out: arrays to which traction (n, 3), state (n, nstatv) and tangent (n, 3, 3) are written, contiguous
        doubles in C order, which the result then shows.  The state at the end may replace that at the start:
        `out[1] is state`.
        aim (n, 3), length: traction and tangent take the damage, the friction bound and the facets that the
        law has at the separation aim; the contact stays unilateral, and the state is that at s all the same.
        The tangent is then symmetric and has no negative eigenvalue (docs/theory.md, section 10).
        p: water pressure at the end, one or (n,), stress, >= 0: the traction is total, so that the law
        carries its normal component + p.

        Raises ValueError for wrong shapes and for values that are missing, not finite or out of range; a
        state that was to be replaced is then unchanged.

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
        s = contract.array("s", s, ("n", 3))
        n = len(s)
        start = None if state is None else contract.array("state", state, (n, self.nstatv))
        s_old = np.zeros((n, 3)) if s_old is None else contract.array("s_old", s_old, (n, 3))
        shapes = (n, 3), (n, self.nstatv), (n, 3, 3)
        at = s if aim is None else contract.array("aim", aim, (n, 3))
        water = None if p is None else pressures(p, n)
        if out is None:
            traction, new, tangent = map(np.empty, shapes)
        else:
            inputs = {"s": s, "state": start, "s_old": s_old, "aim": at, "p": water}
            traction, new, tangent = outputs(out, shapes, inputs)
        check_given("dt", dt, self.material)
        duration = 0.0 if dt is None else float(dt)
        if start is not new:
            new[:] = 0.0 if start is None else start
        if n > 0:  # f2py accepts no empty arrays
            message = calls.message_room()
            pressed = self._props if water is None else water  # not read without water
            status = _core.asperity_update(
                self._props, duration, s_old, s, aim is not None, at, water is not None, pressed, new,
                traction, tangent, message,
            )  # fmt: skip
            if status != 0:
                raise ValueError(calls.text_of(message))
        return Update(traction.view(), new.view(), tangent.view(), self.n_planes, self.material.fc > 0.0)

    def stability(self, tangent: ArrayLike) -> Stability:
        """Stability of n points with tangents (n, 3, 3), stress/length, of an `Update` or a `History`.

        Raises ValueError for a wrong shape and for values that are not finite.

        Examples
        --------
        >>> from asperity import Interface, Material, Pattern
        >>> flat = Interface(Material(3.0, 0.3, 0.9, 0.5), Pattern.regular(0, 0.0))
        >>> elastic, softening = flat.stability(flat.replay([[0.01, 0, 0], [0.1, 0, 0]]).tangent).second_order
        >>> round(float(elastic), 12), round(float(softening), 6)
        (1.0, -0.111111)
        """
        tangent = contract.array("tangent", tangent, ("n", 3, 3))
        for i in np.flatnonzero(~np.isfinite(tangent).all(axis=(1, 2)))[:1]:
            raise ValueError(f"tangent[{i}]: expected finite numbers")
        numbers = np.zeros((len(tangent), len(contract.tables()["stability"])))
        if len(tangent) > 0:
            _core.asperity_stability_of(self._props, tangent, numbers)
        second_order, real, flutter = numbers[:, :3].T
        return Stability(second_order, real, flutter, numbers[:, 3:])

    def initial(
        self,
        traction: ArrayLike,
        damage: ArrayLike = 0.0,
        slip: ArrayLike | None = None,
        p: ArrayLike = 0.0,
    ) -> Floats:
        """State (nstatv,) or (n, nstatv) of points that carry a traction (3,) or (n, 3) at separation zero.

        damage, 0 to 1: of all planes, or (Np,) of each.  slip, length: inelastic slips (s_dit, s_dih) of
        all planes, (2,), or of each, (Np, 2); None is zero.  p: water pressure, one or (n,), stress: the
        traction is total, and the state carries the normal traction t_N + p.  The traction is applied in
        proportion, from zero; the separation that belongs to it becomes the offset (STATEV 6 to 8).  Rupture
        and friction count from this state on, so they are zero in it.  Raises ValueError for wrong input and
        for a traction that the state cannot carry; the message contains the traction that it can.
        """
        checked = contract.array("traction", traction, (3,), ("n", 3))
        tractions = np.array(checked, ndmin=2)
        water = pressures(p, len(tractions))
        tractions[:, 0] += water
        state = np.zeros((len(tractions), self.nstatv))
        shape = (len(tractions), self.n_planes, contract.N_PLANE_STATEV)
        planes = state[:, contract.N_POINT_STATEV : contract.n_statev(self.n_planes)].reshape(shape)
        planes[:, :, 0] = contract.array("damage", damage, (), (self.n_planes,))
        if slip is not None:
            planes[:, :, 1:] = contract.array("slip", slip, (2,), (self.n_planes, 2))
        if len(tractions) > 0:
            message = calls.message_room()
            if _core.asperity_initial_state(self._props, tractions, state, message) != 0:
                effective = "; t_N is the total one and p" if water.any() else ""
                raise ValueError(calls.text_of(message) + effective)
        return state[0] if checked.ndim == 1 else state

    def run(
        self,
        steps: Sequence[Step] | Step,
        state: ArrayLike | Point | None = None,
        tolerance: float | None = None,
    ) -> History:
        """Take one point along a load path; each row is the end of an increment.

        steps: the load path, as the groups `&step` of a case file.  state: the start, STATEV (nstatv,) at
        separation zero, as from `initial`, or a `Point`, as `History.end` of an earlier run; None is a virgin
        point.  tolerance, 1e-8 to 0.1: the increments are halved until the rows of two runs of the whole path
        agree, and rows are left out where straight lines stay within the tolerance.  It is relative to the
        largest traction (at least sigma0), separation (at least s_f) and work (at least Gc).  Where the path
        jumps, it is the distance between the curves.

        Raises ValueError for every value that is out of range, by its name, for a tolerance that is not
        reached, and for a fork that is not taken; EquilibriumLost, with the rows before and the reason, where
        no equilibrium is found.  Warns by ModelWarning of the largest pressure and slip of the rows, and of
        work that differs from their energies, with the sentences of the driver.

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
        history, lost = rows_of(self._props, steps, state, tolerance, warns=True)
        path = [steps] if isinstance(steps, Step) else steps
        if state is None and path[0].s_N is None and path[0].t_N is None and path[0].slip is not None:
            text = "steps[0]: neither t_N nor s_N is given, so s_N is held at 0"
            warnings.warn(text, ModelWarning, stacklevel=2)
        warn_of_physics(
            self.material,
            self.pattern,
            (history.traction[:, 0] + history.p).min(initial=0.0),
            largest_tension(path, state.p if isinstance(state, Point) else 0.0),
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
        return rows_of(self._props, steps, state, tolerance)

    def replay(self, S: ArrayLike, times: ArrayLike | None = None) -> History:
        """Take one virgin point along separations S (T, 3), length; each of the T rows is an increment.

        times (T,): ends of increments, which start at 0, not decreasing; required if tau_v or c > 0.  Raises
        ValueError for a wrong shape and for values that are missing, not finite or too large.

        Examples
        --------
        >>> from asperity import Interface, Material, Pattern
        >>> flat = Interface(Material(3.0, 0.3, 0.9, 0.5), Pattern.regular(0, 0.0))
        >>> flat.replay([[0.02, 0.0, 0.0], [0.2, 0.0, 0.0]]).traction[:, 0].round(12).tolist()
        [3.0, 0.0]
        """
        S = contract.array("S", S, ("n", 3))
        durations = np.diff(times_of(times, len(S), self.material), prepend=0.0)
        if len(S) == 0:
            return self.rows(Step(increments=1))[0].after_step(1)
        step = Step(s_N=S[:, 0], s_Tx=S[:, 1], s_Ty=S[:, 2], increments=1, time=durations)
        try:
            history, lost = self.rows(step)
        except InputError as error:
            of_rows = f"(of 0 to {len(S) - 1})"
            texts = (
                f"row {record.at} {of_rows}: {record.name} = {record.value}: {record.text}"
                if record.at >= 0
                else record.words
                for record in error.records
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

        The normal traction sigma_N, stress, is applied first, at zero slip, in `preload` increments that last
        preload_time; it may damage the joint and gives no row.  slips (T,), length, are then reached one
        after the other along the direction, degrees from Tx towards Ty: a row for each of them or, with a
        tolerance or follow="branch", as many rows as it takes.  times (T,): of the slips, from 0 at the end
        of the preload, not decreasing; required if tau_v, c > 0.  stiffness: of the surroundings (CNS), >= 0,
        stress/length: from the start of the slip on, the normal traction changes by -stiffness times the
        change of s_N.  tolerance as in `run`; follow and arc as in `Step`.  The work of the rows includes
        that of the preload.

        Raises ValueError for wrong input, EquilibriumLost, with the rows before, where no equilibrium is
        found.  Warns as `run`.

        Examples
        --------
        >>> from asperity import Interface, Material, Pattern
        >>> flat = Interface(Material(3.0, 0.3, 0.9, 0.5), Pattern.regular(0, 0.0))
        >>> flat.confined_slip(0.0, [0.1, 0.2, 0.3], -1.0).traction[-1].round(6).tolist()
        [-1.0, 0.5, 0.0]
        """
        slips = contract.array("slips", slips, ("T",))
        sigma_N = contract.number("sigma_N", sigma_N, "a finite traction")
        times = times_of(times, len(slips), self.material)
        if not 0.0 <= preload_time < np.inf:
            raise ValueError(f"preload_time = {preload_time!r}: expected a finite time >= 0")
        each = tolerance is None and follow == "stable"
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
            each,
        )
        try:
            history, lost = self.rows(path, tolerance=tolerance)
        except InputError as error:
            raise ValueError("\n".join(filter(None, map(slip_words, error.records)))) from None
        slip = abs(slips).max(initial=0.0)
        pressed = history.traction[:, 0].min(initial=0.0)
        warn_of_physics(self.material, self.pattern, sigma_N, pressed, slip=slip)
        reached = int(history.position[-1]) - 1 if len(history) else -1
        history = history.after_step(1 if slips.size else 2)
        if lost and slips.size:
            where, text = "", f"no equilibrium in the preload to sigma_N = {sigma_N:g}"
            if reached >= 0:
                where = f"row {len(history)} (of 0 to {len(slips) - 1}): " if each else ""
                place = "at" if each else "before"
                text = f"no equilibrium {place} slip {slips[reached]:g}, sigma_N = {sigma_N:g}"
            raise EquilibriumLost(f"{where}{text}: {lost.partition(': ')[2]}", history.ended(text))
        return history

    def props(self, **of_host: float) -> Floats:
        """Vector PROPS for a host, contract.props_table(): h=1 and 0 for the others, where not given.

        h is the thickness by which the host divides.  Raises ValueError naming every value out of range.
        """
        known = [row.name for row in contract.owned("host", "numerics")]
        for name in of_host:
            if name not in known:
                raise ValueError(f"{name}: expected one of {', '.join(known)}")
        props = contract.pack(
            self.material.values() | self.pattern.values() | of_host, self.pattern.constants()
        )
        contract.check(props)
        return props

    def card(
        self,
        host: str,
        *,
        name: str = "INTERFACE",
        dimension: int = 3,
        explicit: bool = False,
        contact: bool = False,
        density: float | None = None,
        stress: float | None = None,
        modulus: float | None = None,
        size: float | None = None,
        direction: float | None = None,
        notes: Sequence[str] = (),
        **of_host: float,
    ) -> str:
        """Material block of the input of a host, such as "abaqus"; `asperity card --help` has the names.

        explicit: for Abaqus/Explicit, which needs a density (mass per area and thickness h), but not for
        contact pairs.  contact: for contact pairs of Abaqus.  stress: largest compression, sigma_N < 0;
        modulus and size: E of the solid beside the interface and length of its elements; direction: of the
        slip, degrees from Tx towards Ty.  They are checked: the findings go into the block after the notes,
        and problems also give a ModelWarning.  of_host: h, map, dalpha, r, water and implex, as in `props`.
        Raises ValueError for an unknown host, a value out of range, or what the host cannot take.
        """
        props = self.props(**of_host)
        implex = float(props[contract.index("implex")])
        verdicts = check_model(self.material, self.pattern, stress, modulus, size, direction, implex)
        texts = [
            *notes,
            *(verdict.text if verdict.good else f"WARNING: {verdict.text}" for verdict in verdicts),
        ]
        names = contract.umat_names(*contract.check(props), implex, contract.yields(props))
        block = cards.Block(
            name, props, names, texts, dimension, explicit, contact, density, self._largest_stiffness()
        )
        text = cards.card(host, block)
        for verdict in verdicts:
            if not verdict.good:
                warnings.warn(verdict.text, ModelWarning, stacklevel=2)
        return text

    def _largest_stiffness(self) -> tuple[float, float]:
        """Stiffness in shear and in opening of a virgin joint, or that of its contact if it is larger."""
        tangent = self.update(np.zeros((1, 3)), dt=1.0).tangent[0]
        factor = max(1.0, self.material.kc)
        return factor * float(tangent[1, 1]), factor * float(tangent[0, 0])
