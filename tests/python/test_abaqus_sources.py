"""The single sources for Abaqus, compiled as Abaqus compiles them and called as it calls user routines."""

from __future__ import annotations

import ctypes
import os
import shutil
import subprocess
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from asperity import Interface, Material, Pattern, installed
from asperity.contract import N_PLANE_STATEV, N_POINT_STATEV
from support_calls import LIBRARY, Written, umat, vumat

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not shutil.which("gfortran"), reason="no gfortran"),
]

JOINT = Interface(Material(sigma0=3.0, Gc=0.3, eta=0.9, mu=0.5), Pattern.regular(2, theta=30.0))
PROPS, NSTATV, SLOPE = np.array(JOINT.props()), JOINT.nstatv, np.tan(np.radians(30.0))
DENSITY, BLOCK = 2.0e-9, 136
"""Mass density, and points of a block (n_vec_length of Abaqus)."""

# what stands for Intel's -auto, -free, -extend_source and -nostandard-realloc-lhs
FLAGS = (
    "-shared -fPIC -O0 -cpp -frecursive -ffree-form -ffree-line-length-132 -Werror=line-truncation "
    "-fno-realloc-lhs"
).split()

UTILITIES = """
#include <stddef.h>
void (*said)(int solver, int lop, const char *text, size_t length), (*ended)(int solver);
#define SOLVER(number, message, end) \\
  void message(int *lop, char *text, int *intv, double *realv, char *charv, size_t length, size_t) { \\
    if (*intv == 0 && *realv == 0.0 && *charv == ' ') said(number, *lop, text, length); \\
  } \\
  void end(void) { ended(number); }
SOLVER(0, stdb_abqerr_, xit_)
SOLVER(1, xplb_abqerr_, xplb_exit_)
"""
"""Routines that Abaqus/Standard and Abaqus/Explicit provide; those of Abaqus end the analysis."""

STANDARD, EXPLICIT, ENDS = "standard", "explicit", "end of the analysis"

CALLS: list[tuple[str, int, str]] = []
"""Calls of these routines: solver, kind of message, text."""


@ctypes.CFUNCTYPE(None, ctypes.c_int, ctypes.c_int, ctypes.c_void_p, ctypes.c_size_t)
def _said(solver: int, lop: int, text: int, length: int) -> None:
    CALLS.append(((STANDARD, EXPLICIT)[solver], lop, ctypes.string_at(text, length).decode()))


@ctypes.CFUNCTYPE(None, ctypes.c_int)
def _ended(solver: int) -> None:
    CALLS.append(((STANDARD, EXPLICIT)[solver], 0, ENDS))


@pytest.fixture(scope="module")
def sources(tmp_path_factory: pytest.TempPathFactory) -> dict[str, ctypes.CDLL]:
    """Libraries of the single sources by the end of their names, beside the routines of Abaqus."""
    folder = tmp_path_factory.mktemp("abaqus")
    (folder / "utilities.c").write_text(UTILITIES)
    command = [os.environ.get("CC", "cc"), "-w", "-shared", "-fPIC", "utilities.c", "-o", "utilities.so"]
    subprocess.run(command, cwd=folder, check=True)
    utilities = ctypes.CDLL(str(folder / "utilities.so"), mode=ctypes.RTLD_GLOBAL)
    for name, routine in (("said", _said), ("ended", _ended)):
        ctypes.c_void_p.in_dll(utilities, name).value = ctypes.cast(routine, ctypes.c_void_p).value

    def library(part: str) -> ctypes.CDLL:
        source, made = installed.abaqus() / f"asperity_abaqus{part}.f90", folder / f"user{part}.so"
        modules = folder / f"modules{part}"
        modules.mkdir()
        subprocess.run(["gfortran", *FLAGS, f"-J{modules}", source, "-o", made], check=True)
        return ctypes.CDLL(str(made))

    parts = ("", "_standard", "_explicit", "_single")
    with ThreadPoolExecutor(2) as pool:
        return dict(zip(parts, pool.map(library, parts), strict=True))


@pytest.fixture(autouse=True)
def forgotten() -> None:
    """No calls of the test before."""
    CALLS.clear()


class Single:
    """The VUMAT in single precision under the name by which `support_calls` calls it."""

    def __init__(self, library: ctypes.CDLL) -> None:
        """Of a single source, where it has the name of the one in double precision."""
        self.vumat_single_ = library.vumat_


def at_rest(
    library: ctypes.CDLL, props: np.ndarray = PROPS, statev: np.ndarray | None = None, t_N: float = 0.0
) -> Written:
    """Call the UMAT without a strain."""
    start = np.zeros(NSTATV) if statev is None else statev
    return umat(library, props, np.array([t_N, 0.0, 0.0]), start, np.zeros(3), np.zeros(3))


def block(
    library: ctypes.CDLL | Single, strain: np.ndarray, stress: np.ndarray, kind: type = float
) -> Written:
    """Call the VUMAT for a block of virgin points after the first increment."""
    arrays = strain, stress, np.zeros((len(strain), NSTATV))
    return vumat(library, PROPS.astype(kind), np.full(len(strain), DENSITY, kind), (1.0, 1.0), *arrays)


def test_routines_of_every_source(sources: dict[str, ctypes.CDLL]) -> None:
    """Each source has its own routines, and none that the other solver provides."""
    names = "umat_", "uinter_", "vumat_", "vuinter_", "vumat_single_", "vuinter_single_"
    routines = {part: [name for name in names if hasattr(library, name)] for part, library in sources.items()}
    standard, explicit = ["umat_", "uinter_"], ["vumat_", "vuinter_"]
    parts = {"_standard": standard, "_explicit": explicit, "_single": explicit}
    assert routines == {"": standard + explicit} | parts
    folder = installed.abaqus()
    texts = {part: (folder / f"asperity_abaqus{part}.f90").read_text(encoding="utf-8") for part in sources}
    for part, word in (
        ("_standard", "xplb_"), ("_explicit", "call xit"), ("_explicit", "stdb_"), ("_single", "stdb_"),
        ("", "bind("), ("", "include '"), ("", "!$omp"),
    ):  # fmt: skip
        assert word not in texts[part], (part, word)
    assert "call xit" in texts[""] and "call xplb_exit" in texts[""]


@pytest.mark.parametrize("part", ["", "_standard"])
def test_standard_is_the_library(sources: dict[str, ctypes.CDLL], part: str) -> None:
    """A point that is pressed and slides up its facing plane until it is cracked has the library's numbers.

    They are not the same bits: the sources have no directives by which planes are added in another order.
    """
    press = np.outer(np.arange(1, 5) / 4.0, [-1.0 / JOINT.material.K, 0.0, 0.0])
    path = [*press, *(press[-1] + np.outer(np.arange(1, 49) / 48.0, [0.8 * SLOPE, 0.8, 0.0]))]
    ends = []
    for library in (LIBRARY, sources[part]):
        stress, statev, old = np.zeros(3), np.zeros(NSTATV), np.zeros(3)
        for strain in path:
            out = umat(library, PROPS, stress, statev, old, strain - old, 1.0)
            assert out.pnewdt == 1.0
            stress, statev, old = out.stress, out.state, strain
        ends.append(np.concatenate([stress / 3.0, statev, out.energies]))
    assert np.abs(ends[1] - ends[0]).max() <= 1e-12 and not CALLS


def bad_state() -> np.ndarray:
    """STATEV whose planes have numbers out of range."""
    state = np.zeros(NSTATV)
    state[N_POINT_STATEV:] = np.finfo(float).max
    return state


@pytest.mark.parametrize(
    ("given", "lines"),
    [
        ({"t_N": 6.0}, ["initial t_N = 6: beyond the strength of the planes"]),
        ({"props": np.r_[PROPS[:2], 1.5, -0.5, PROPS[4:]]},
         ["PROPS(3) eta = 1.5: expected 0 < eta < 1", "PROPS(4) mu = -0.5: expected >= 0"]),
        ({"statev": bad_state()}, [f"STATEV({i}) " for i in range(N_POINT_STATEV + 1, NSTATV + 1)]),
    ],
)  # fmt: skip
def test_rejected_call_ends_standard(
    sources: dict[str, ctypes.CDLL], given: dict[str, np.ndarray], lines: list[str]
) -> None:
    """One message for each bad value, then XIT; the state is unchanged. The library itself calls nothing."""
    out = at_rest(sources["_standard"], **given)
    assert out.pnewdt < 1.0 and np.array_equal(out.state, given.get("statev", np.zeros(NSTATV)))
    *messages, end = CALLS
    assert end == (STANDARD, 0, ENDS) and len(messages) == len(lines)
    for (solver, lop, text), line in zip(messages, lines, strict=True):
        assert (solver, lop, len(text)) == (STANDARD, -2, 500) and "%" not in text
        assert text.startswith(f"asperity umat: {line}")
    assert ("it carries t_N = " in messages[0][2]) == ("t_N" in given)
    CALLS.clear()
    assert at_rest(LIBRARY, **given).pnewdt < 1.0 and not CALLS


@pytest.mark.parametrize("part", ["", "_explicit", "_single"])
def test_explicit_is_the_library(sources: dict[str, ctypes.CDLL], part: str) -> None:
    """After the packager's probe blocks of 136, 136 and 28 points slide until they are cracked.

    In single precision each of 200 increments loses 6e-8 of the separation, and the closure is 1/40 of that.
    """
    number, steps = np.arange(1, 301), 200
    strain = np.tile([0.6 / steps * SLOPE, 0.0, 0.3 / steps], (300, 1))
    first = strain - np.outer(0.01 + 1e-5 * (number % 97), [1.0, 0.0, 0.0])
    kind = np.float32 if part == "_single" else np.float64
    own = Single(sources[part]) if part == "_single" else sources[part]
    ends = []
    for library, real in ((LIBRARY, kind), (own, kind), (LIBRARY, np.float64)):
        parts = []
        for points in np.split(np.arange(300), [BLOCK, 2 * BLOCK]):
            n, total = len(points), 0.0
            props, density = PROPS.astype(real), np.full(n, DENSITY, real)
            stress, state, energies = np.zeros((n, 3)), np.zeros((n, NSTATV)), np.zeros((n, 2))
            probe = np.tile([1.0, 2.0, 3.0], (n, 1))
            out = vumat(library, props, density, (0.0, 0.0), probe, stress, state, energies)
            assert not out.state.any()
            for k in range(steps):
                total += 1e-6
                increments = (strain if k else first)[points]
                out = vumat(library, props, density, (total, 1e-6), increments, stress, state, energies)
                stress, state, energies = out.stress, out.state, out.energies
            parts.append((stress.astype(float) / 3.0, state.astype(float), energies.astype(float)))
        ends.append([np.concatenate(column) for column in zip(*parts, strict=True)])
    library, numbers, double = ends
    assert (library[1][:, N_POINT_STATEV::N_PLANE_STATEV] == 1.0).all() and not CALLS
    assert np.abs(numbers[0] - double[0]).max() <= (1e-3 if kind == np.float32 else 1e-12)
    assert np.abs(numbers[0] - library[0]).max() <= (1e-3 if kind == np.float32 else 1e-12)
    if kind == np.float64:
        assert np.abs(numbers[1] - library[1]).max() <= 1e-12
        assert (np.abs(numbers[2] - library[2]) <= 1e-12 * library[2].max(axis=0)).all()


@pytest.mark.parametrize(
    ("part", "strain", "stress", "line"),
    [
        ("", 0.0, 6.0, "initial t_N = 6: beyond"),
        ("_explicit", np.nan, 0.0, "strainInc(2) = NaN: expected"),
        ("_single", 1e30, 0.0, "strainInc(2) = 1.0"),
    ],
)
def test_rejected_block_ends_explicit(
    sources: dict[str, ctypes.CDLL], part: str, strain: float, stress: float, line: str
) -> None:
    """A message names the point of the block, then XPLB_EXIT is called; the state is unchanged."""
    single = part == "_single"
    strains, stresses = np.zeros((BLOCK, 3)), np.zeros((BLOCK, 3))
    strains[76, 1], stresses[76, 0] = strain, stress
    library = Single(sources[part]) if single else sources[part]
    out = block(library, strains, stresses, np.float32 if single else np.float64)
    (message, end) = CALLS
    assert (message[:2], end) == ((EXPLICIT, -2), (EXPLICIT, 0, ENDS))
    assert message[2].startswith(f"asperity vumat: point 77 of the block: {line}")
    assert not out.state.any()
