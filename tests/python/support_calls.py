"""UMAT, VUMATs and C API of a shared library, called as hosts call them, with a fence behind each output."""

from __future__ import annotations

import contextlib
import ctypes
import fcntl
import os
import platform
import re
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
import pytest
from asperity import installed
from asperity.contract import N_PLANE_STATEV, N_POINT_STATEV

FLAGS = ctypes.CDLL(None)
FLOATING = 13 if platform.machine() in ("x86_64", "AMD64") else 0
"""Flags of the floating-point exceptions: invalid, division by zero, overflow."""

SIGNALLING = float(np.array(0x7FF4000000000000).view(float))
"""A signalling NaN."""

LIBRARY = ctypes.CDLL(os.environ.get("ASPERITY_LIBRARY") or str(installed.library()))
"""The library of the package, or another build of it."""

FENCE = 4
"""Number of elements behind each array that is written, which must not change."""


def mark(kind: type) -> float:
    """Value of outputs before a call, of their fences, and of arguments that hosts do not define."""
    return -7.5e30 if kind == np.float32 else -7.5e77


def address(array: np.ndarray | None) -> ctypes.c_void_p:
    """Address of an array, NULL for None."""
    return ctypes.c_void_p(None if array is None else array.ctypes.data)


class Written:
    """Arrays that a call writes, each in the order of Fortran and with a fence behind it."""

    def __init__(self, kind: type, **starts: tuple[tuple[int, ...], np.ndarray | float]) -> None:
        """Take the shape and the values at the start of each array."""
        self.mark, self.status, self.message = mark(kind), 0, ""
        self.buffers = {}
        for name, (shape, start) in starts.items():
            size = int(np.prod(shape))
            buffer = np.full(size + FENCE, self.mark, dtype=kind)
            array = buffer[:size].reshape(shape, order="F")
            array[...] = start
            setattr(self, name, array)
            self.buffers[name] = buffer

    def at(self, name: str) -> ctypes.c_void_p:
        """Address of an array."""
        return address(self.buffers[name])

    def by(self, routine: ctypes._CFuncPtr, *arguments: object) -> Written:
        """Call a routine; status is what it returns, exceptions are the flags that it raises."""
        FLAGS.feclearexcept(FLOATING)
        self.status = routine(*arguments)
        self.exceptions = FLAGS.fetestexcept(FLOATING)
        return self

    @property
    def whole(self) -> bool:
        """Whether no fence has changed."""
        return all((buffer[-FENCE:] == self.mark).all() for buffer in self.buffers.values())


NAME = ctypes.create_string_buffer(b"JOINT".ljust(80), 80)
ANY = np.full(64, mark(float))


def _integers(*values: int) -> list[ctypes._Pointer]:
    return [ctypes.byref(ctypes.c_int(value)) for value in values]


def umat(
    library: ctypes.CDLL,
    props: np.ndarray,
    stress: np.ndarray,
    statev: np.ndarray,
    stran: np.ndarray,
    dstran: np.ndarray,
    dtime: float | None = 0.0,
    pnewdt: float | None = 1.0,
    fields: tuple[np.ndarray | None, np.ndarray | None] = (ANY, ANY),
    kinc: int = 1,
    **sizes: int,
) -> Written:
    """Call the UMAT for a point: stress, state, tangent, energies, pnewdt; None: the host passes NULL.

    fields: PREDEF and DPRED.  sizes: nprops and nstatv, absent: those of the arrays.
    """
    ntens, any_value = len(stress), address(ANY)
    out = Written(
        float,
        stress=((ntens,), stress),
        state=((len(statev),), statev),
        tangent=((ntens, ntens), mark(float)),
        energies=((3,), mark(float)),
        pnewdt=((1,), 0.0 if pnewdt is None else pnewdt),
    )
    energies, time = out.at("energies").value, None if dtime is None else np.array([dtime])
    out.by(
        library.umat_,
        *(out.at("stress"), out.at("state"), out.at("tangent")),
        *(ctypes.c_void_p(energies + 8 * i) for i in range(3)),
        *[any_value] * 4,
        *(address(stran), address(dstran), any_value, address(time)),
        *(any_value, any_value, *map(address, fields)),
        *(NAME, *_integers(1, ntens - 1, ntens, sizes.get("nstatv", len(statev)))),
        *(address(props), *_integers(sizes.get("nprops", len(props)))),
        *(any_value, any_value, address(None) if pnewdt is None else out.at("pnewdt")),
        *[any_value] * 3,
        *_integers(*[1] * 5, kinc),
        ctypes.c_size_t(80),
    )
    out.status = 0  # a subroutine
    return out


def vumat(
    library: ctypes.CDLL,
    props: np.ndarray,
    density: np.ndarray,
    times: tuple[float, float],
    strain: np.ndarray,
    stress: np.ndarray,
    state: np.ndarray,
    energies: np.ndarray | float = 0.0,
    ndir: int = 1,
    fields: tuple[np.ndarray, np.ndarray] | None = None,
    **sizes: int,
) -> Written:
    """Call the VUMAT of the precision of props for a block, points in rows: stress, state, 2 energies.

    times: total time and increment.  fields: fieldOld and fieldNew, points in rows.  sizes: as for umat, and
    n.
    """
    kind, n = props.dtype.type, len(density)
    out = Written(
        kind,
        stress=(stress.shape, np.nan),
        state=(state.shape, np.nan),
        energies=((n, 2), np.nan),
    )
    total, dt = np.array([times[0]], kind), np.array([times[1]], kind)
    strain, stress, state = (np.asfortranarray(a, dtype=kind) for a in (strain, stress, state))
    old = np.asfortranarray(np.broadcast_to(energies, (n, 2)), dtype=kind)
    unused = np.full(9 * n + 1, np.nan, dtype=kind)
    none, second = address(unused), n * unused.itemsize
    of_fields = [np.asfortranarray(a, dtype=kind) for a in fields or ()]
    n_fields = of_fields[0].shape[1] if of_fields else 0
    before, after = map(address, of_fields or (unused, unused))
    out.by(
        library.vumat_single_ if kind == np.float32 else library.vumat_,
        *_integers(
            sizes.get("n", n), ndir, stress.shape[1] - ndir, sizes.get("nstatv", state.shape[1]), n_fields
        ),
        *_integers(sizes.get("nprops", len(props)), 0),
        *(address(total), address(total), address(dt), NAME, none, none, address(props), address(density)),
        *(address(strain), *[none] * 4, before, address(stress), address(state)),
        *(address(old), ctypes.c_void_p(old.ctypes.data + second), *[none] * 3, after),
        *(out.at("stress"), out.at("state"), out.at("energies")),
        ctypes.c_void_p(out.at("energies").value + second),
        ctypes.c_size_t(80),
    )
    out.status = 0  # a subroutine
    return out


def c_update(
    library: ctypes.CDLL,
    props: np.ndarray,
    dt: float,
    s_old: np.ndarray | None,
    s: np.ndarray,
    state: np.ndarray,
    tangent: bool = True,
    size: int = 400,
    aim: np.ndarray | None = None,
    function: str = "asperity_update",
    **sizes: int,
) -> Written:
    """Call asperity_update or asperity_iterate, points in columns: stress, state, tangent, status, message.

    aim None: NULL.  size: bytes of the message, 0: NULL.  sizes: n, nprops and nstatv, absent: those of the
    arrays.
    """
    n, nstatv = s.shape[1], len(state)
    out = Written(
        float,
        stress=((3, n), mark(float)),
        state=((nstatv, n), state),
        **({"tangent": ((3, 3, n), mark(float))} if tangent else {}),
    )
    text = ctypes.create_string_buffer(b"#" * (size + FENCE), size + FENCE)
    out.by(
        library[function],
        *(address(props), sizes.get("nprops", len(props)), ctypes.c_double(dt), sizes.get("n", n)),
        *(address(s_old), address(s), address(aim), address(None), sizes.get("nstatv", nstatv)),
        *(out.at("state"), out.at("stress")),
        *(out.at("tangent") if tangent else None, text if size else None, size),
    )
    assert text.raw[size:] == b"#" * FENCE, "a message beyond its buffer"
    out.message = text.value.decode() if size else ""
    return out


@dataclass
class Call:
    """Arguments of a call, points in rows, strains as separations over h."""

    props: np.ndarray
    strain: np.ndarray
    increment: np.ndarray
    stress: np.ndarray
    state: np.ndarray
    times: tuple[float, float]
    energies: np.ndarray
    density: np.ndarray
    n_planes: int
    optional: dict[str, object]


Routine = Callable[[np.random.Generator, Call], Written]


def call_umat(draw: np.random.Generator, call: Call) -> Written:
    """One point; DTIME and PNEWDT may be NULL."""
    arrays = (call.stress[0], call.state[0], call.strain[0], call.increment[0])
    return umat(LIBRARY, call.props, *arrays, **{"dtime": call.times[1]} | call.optional)


def call_vumat(draw: np.random.Generator, call: Call) -> Written:
    """A block of points."""
    arrays = (call.increment, call.stress, call.state)
    return vumat(LIBRARY, call.props, call.density, call.times, *arrays, call.energies, **call.optional)


def call_c(draw: np.random.Generator, call: Call) -> Written:
    """Points with or without old separation, aim, tangent and message."""
    s_old, s = (np.asfortranarray(a.T) for a in (call.strain, call.strain + call.increment))
    aim = np.asfortranarray((call.strain + draw.uniform(-2.0, 2.0) * call.increment).T)
    arguments = (call.props, call.times[1], None if draw.random() < 0.25 else s_old, s, call.state.T)
    sizes = call.optional | {"tangent": draw.random() < 0.75, "aim": aim if draw.random() < 0.3 else None}
    out = c_update(LIBRARY, *arguments, size=int(draw.integers(300)), **sizes)
    if out.status:
        again = c_update(LIBRARY, *arguments, size=400, **sizes)
        assert again.status == out.status and again.message.startswith(out.message)
        out.message = again.message
    return out


def judge(routine: Routine, call: Call, out: Written, must_reject: bool, admissible: bool) -> bool:
    """Assert what a call must keep; return whether it was rejected."""
    rejected = (
        out.status != 0 or bool(np.isnan(out.stress).any()) or bool(out.message and not out.stress.size)
    )
    state = out.state if routine is call_vumat else out.state.T.reshape(call.state.shape)
    assert out.whole, "an array is written beyond its end"
    assert not out.exceptions, "a floating-point exception"
    assert not (rejected and admissible), f"admissible input is rejected: {out.message}"
    assert rejected or not must_reject or not out.stress.size, "input that is not admissible is accepted"
    if rejected:
        assert state.tobytes() == call.state.astype(state.dtype).tobytes(), "a rejection changes the state"
        assert re.search(": expected | it carries ", out.message), (
            f"a rejection without reason: {out.message}"
        )
        for array in (getattr(out, name) for name in ("stress", "tangent") if name in out.buffers):
            assert np.all(array == out.mark if out.status else np.isnan(array)), "a rejection leaves results"
        assert routine is not call_vumat or np.array_equal(out.energies, call.energies)
        return True
    assert not out.message, f"an accepted call says {out.message}"
    for name, buffer in out.buffers.items():
        assert np.isfinite(buffer).all() and not (buffer[:-FENCE] == out.mark).any(), f"{name} is not set"
    if call.times[0] > 0.0:
        planes = slice(N_POINT_STATEV, N_POINT_STATEV + N_PLANE_STATEV * call.n_planes, N_PLANE_STATEV)
        assert ((state[:, planes] >= 0.0) & (state[:, planes] <= 1.0)).all(), "a damage outside 0 to 1"
        assert (state[:, 4] == 1.0).all(), "the status is not 1"
    return False


@contextlib.contextmanager
def errors() -> Iterator[Callable[[], str]]:
    """Redirect the standard error of the library; the function returns and removes what was written to it."""
    with tempfile.TemporaryFile() as file:
        own, kept = file.fileno(), os.dup(2)
        fcntl.fcntl(own, fcntl.F_SETFL, fcntl.fcntl(own, fcntl.F_GETFL) | os.O_APPEND)

        def read() -> str:
            size = os.fstat(own).st_size
            text = os.pread(own, size, 0).decode() if size else ""
            if size:
                os.ftruncate(own, 0)
            return text

        os.dup2(own, 2)
        try:
            yield read
        finally:
            os.dup2(kept, 2)
            os.close(kept)


ADAPTERS = pytest.mark.parametrize(
    ("routine", "kind"),
    [(call_umat, np.float64), (call_vumat, np.float64), (call_vumat, np.float32), (call_c, np.float64)],
    ids=["umat", "vumat", "vumat_single", "c"],
)
