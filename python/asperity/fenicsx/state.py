"""The state of a model: what an accepted equilibrium leaves, and the files that a run goes on from."""

from __future__ import annotations

import zipfile
import zlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import ufl
from dolfinx import fem
from mpi4py import MPI
from numpy.typing import ArrayLike, NDArray

from ..contract import Floats
from .model import Model
from .ranks import COMM, agree, doubles, real
from .response import Response, respond
from .water import ROUNDING, Pressure, in_joint, weights_of_faces


def frozen(array: ArrayLike, kind: type = float) -> NDArray[Any]:
    """Read-only array of its own, or the same where nobody else can write to it."""
    values: NDArray[Any] = np.asarray(array, kind)
    if values.flags.writeable or values.base is not None:
        values = values.copy()
        values.flags.writeable = False
    return values


@dataclass(frozen=True)
class State:
    """Everything of a model that an equilibrium changes; its arrays are read-only.

    u (n d,): displacements of the owned nodes.  s, t (p, 3): separations and total tractions of the points of
    the joints.  joints: of each law, the states (its points, nstatv).  p (p,): pressures of the water there.
    forces (n d,): internal forces of solids and joints.  stress (n d,): those of the initial stress of the
    solids.  v, a (n d,): velocities and accelerations.  scale: largest forces of the equilibria so far, of
    which a small share counts as nothing.  floating: whether a tangent was singular, as where a block lies in
    no contact.  at: parameter of the path, or time.
    """

    u: Floats
    s: Floats
    t: Floats
    joints: tuple[Floats, ...]
    p: Floats
    forces: Floats
    stress: Floats
    v: Floats
    a: Floats
    scale: float = 0.0
    floating: bool = False
    at: float = 0.0

    def __post_init__(self) -> None:
        """Make the arrays read-only; those that a caller can write to are copied."""
        for name in ARRAYS:
            object.__setattr__(self, name, frozen(getattr(self, name)))
        object.__setattr__(self, "joints", tuple(frozen(states) for states in self.joints))

    @classmethod
    def virgin(cls, model: Model) -> State:
        """State of a model that carries nothing."""
        nodal, points = np.zeros(model.n * model.d), len(model.pairs)
        rows = zip(model.laws, model.parts, strict=True)
        joints = tuple(np.zeros((part.stop - part.start, law.nstatv)) for law, part in rows)
        three = np.zeros((points, 3))
        return cls(nodal, three, three, joints, np.zeros(points), nodal, nodal, nodal, nodal)

    @classmethod
    def initial(
        cls,
        model: Model,
        stress: ArrayLike | Callable[[Floats], Floats],
        *blocks: str,
        damage: float = 0.0,
        pressures: Mapping[str, Pressure] | None = None,
    ) -> State:
        """State of a model whose solids have an initial stress, tension positive.

        stress: (d, d), or a function of places (n, d) that returns (n, d, d), linear in each cell.  blocks:
        all by default.  Joints inside them carry the total traction of this stress at zero separation, with a
        damage of their planes and the pressures of their water; raises ValueError where they cannot.
        """
        m, size = model, (model.d, model.d)
        if m.axisymmetric:
            raise ValueError("initial stress of a body of revolution: expected a plane mesh, or one in space")

        def tensors(x: Floats) -> Floats:
            values, message = doubles("stress", stress(x) if callable(stress) else stress), ""
            if values.shape not in (size, (len(x), *size)):
                message = f"stress of the shape {values.shape}: expected {size} or {(len(x), *size)}"
            elif not np.isfinite(values).all() or (
                np.abs(values - values.swapaxes(-1, -2)).max(initial=0.0)
                > 1e-9 * np.abs(values).max(initial=0.0)
            ):
                message = "stress: expected finite, symmetric components"
            agree(message)
            return np.broadcast_to(values, (len(x), *size))

        tensor_field = fem.Function(fem.functionspace(m.mesh, ("DG", 1, size)))
        tensor_field.interpolate(lambda x: tensors(x[: m.d].T).reshape(-1, m.d**2).T)
        virtual = ufl.grad(ufl.TestFunction(m.V))
        stressed = m.assembled(m.inside(blocks) * ufl.inner(tensor_field, virtual))
        inside, on_points = m.faces_inside(blocks), np.zeros(len(m.pairs), bool)
        on_points[m.face_points[inside]] = True
        on_points &= m.area > 0.0
        # nodal forces as those of the solids beside, for no other ones balance them
        places, shares = weights_of_faces(m)
        axes = m.axes[m.face_points[:, 0]]
        on = np.einsum(
            "fqij,fj->fqi", tensors(places.reshape(-1, m.d)).reshape(*places.shape, -1), axes[:, 0]
        )
        traction, start = np.zeros((len(m.pairs), 3)), cls.virgin(m)
        forces = np.einsum("fqk,fqd,fcd->fkc", m.thickness * shares, on, axes, optimize=True)
        np.add.at(traction, m.face_points[inside], forces[inside])
        traction /= np.where(m.area > 0.0, m.area, np.inf)[:, None]
        p = np.zeros(len(m.pairs))
        for name, pressure in (pressures or {}).items():
            agree("" if name in m.joints else f"{name}: no such joint: expected one of {', '.join(m.joints)}")
            p[m.parts[m.joints.index(name)]] = in_joint(m, name, pressure, start.s)
        free = traction + np.outer(p, [1.0, 0.0, 0.0])
        free = np.abs(free).max(1) <= ROUNDING * np.abs(traction).max(initial=0.0)  # as at the surface
        traction[free] = np.outer(-p[free], [1.0, 0.0, 0.0])
        message, joints = "", [states.copy() for states in start.joints]
        for k, (part, law) in enumerate(zip(m.parts, m.laws, strict=True)):
            at = on_points[part]
            try:
                joints[k][at] = law.initial(traction[part][at], damage, p=p[part][at])
            except ValueError as error:
                message = message or f"{m.joints[k]}: {error}"
        agree(message)
        start = replace(start, joints=tuple(joints), p=p, stress=stressed)
        t = respond(m, start, start.s, 1.0, p).t
        return replace(start, t=t, forces=stressed + m.pulled(t))

    def check(self, model: Model) -> None:
        """Raise ValueError on all ranks where the state has not the sizes of a model, or is not finite."""
        virgin = State.virgin(model)
        same = len(self.joints) == len(virgin.joints) and all(
            mine.shape == theirs.shape
            for name in (*ARRAYS, "joints")
            for mine, theirs in zip(_arrays_of(self, name), _arrays_of(virgin, name), strict=True)
        )
        agree(
            "" if same else "state: expected one of this model",
            ""
            if real(scale := self.scale) and scale >= 0.0
            else f"scale = {scale} of the state: expected 0 or more",
            "" if real(self.at) else f"at = {self.at} of the state: expected a finite number",
            *(
                f"{name} of the state: expected finite numbers"
                for name in (*ARRAYS, "joints")
                if not all(np.isfinite(values).all() for values in _arrays_of(self, name))
            ),
        )

    def response(self, model: Model) -> Response:
        """What the law has at this state without a further increment: tractions, tangents, states."""
        return respond(model, self, self.s, 1.0, self.p)

    def differences(self, other: State) -> dict[str, float]:
        """Largest difference on this rank, by the name of each field in which two states differ."""
        found: dict[str, float] = {}
        for part in fields(self):
            pairs = zip(*(_arrays_of(state, part.name) for state in (self, other)), strict=True)
            gaps = [float(np.abs(mine - theirs).max(initial=0.0)) for mine, theirs in pairs]
            if any(gap != 0.0 for gap in gaps):
                found[part.name] = max(gaps)
        return found

    def save(self, file: str | Path) -> None:
        """Write the state, FILE.RANK.npz."""
        write(file, {"state": self})

    @classmethod
    def load(cls, file: str | Path, model: Model) -> State:
        """State from the files of a run with the same mesh, laws and ranks; ValueError for others."""
        return read(file, model, ("state",))[0]["state"]


ARRAYS = "u", "s", "t", "p", "forces", "stress", "v", "a"
NUMBERS = "scale", "floating", "at"
"""Fields of a state that are arrays of their own, and numbers."""


def _arrays_of(state: State, name: str) -> list[Floats]:
    """Field of a state as a list of arrays."""
    value = getattr(state, name)
    return [np.asarray(one, float) for one in (value if name == "joints" else [value])]


def file_of_rank(file: str | Path) -> Path:
    """FILE.RANK.npz of this rank; a point in the name of the file, as in at_0.25, belongs to the name."""
    return Path(f"{file}.{COMM.rank}.npz")


def write(file: str | Path, states: Mapping[str, State], **numbers: ArrayLike) -> None:
    """Write states and numbers of a run, FILE.RANK.npz."""
    rows: dict[str, ArrayLike] = {name: np.asarray(number) for name, number in numbers.items()}
    for key, state in states.items():
        rows |= {f"{key}.{name}": getattr(state, name) for name in (*ARRAYS, *NUMBERS)}
        rows |= {f"{key}.joints{k}": joint for k, joint in enumerate(state.joints)}
    new = (path := file_of_rank(file)).with_suffix(".new.npz")
    np.savez(new, **{"ranks": COMM.size, **rows})
    new.replace(path)  # whole even if the run is ended here


def read(
    file: str | Path, model: Model, states: Sequence[str], **numbers: tuple[int, ...]
) -> tuple[dict[str, State], dict[str, Floats]]:
    """States and numbers of a file, by names; ValueError if it is of another run or version.

    numbers: their shapes.
    """
    path, saved = file_of_rank(file), {}
    try:
        with np.load(path) as data:
            saved = dict(data)
    except (OSError, EOFError, ValueError, TypeError, AttributeError, zipfile.BadZipFile, zlib.error):
        saved = {}  # all ranks refuse it below
    virgin, shapes = State.virgin(model), {"ranks": (), **numbers}
    for key in states:
        shapes |= {f"{key}.{name}": getattr(virgin, name).shape for name in ARRAYS}
        shapes |= {f"{key}.{name}": () for name in NUMBERS}
        shapes |= {f"{key}.joints{k}": joint.shape for k, joint in enumerate(virgin.joints)}
    same = all(name in saved and saved[name].shape == shape for name, shape in shapes.items())
    if not COMM.allreduce(bool(same and saved["ranks"] == COMM.size), MPI.LAND):
        raise ValueError(f"{file}: expected the files of a run with the same mesh, laws and ranks")
    of_names = {
        key: State(
            **{name: saved[f"{key}.{name}"] for name in ARRAYS},
            joints=tuple(saved[f"{key}.joints{k}"] for k in range(len(model.laws))),
            scale=float(saved[f"{key}.scale"]),
            floating=bool(saved[f"{key}.floating"]),
            at=float(saved[f"{key}.at"]),
        )
        for key in states
    }
    return of_names, {name: saved[name] for name in numbers}
