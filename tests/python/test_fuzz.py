"""Corrupted input: files of the driver, arguments of the package, and runs that are killed.

Expected are finite values, whole rows, a message for every rejection, and neither crash nor endless run.  The
long version is ASPERITY_EXAMPLES=20000 pytest tests/python/test_fuzz.py.  test_random_calls.py tests UMAT,
VUMAT and C API in the same way.
"""

from __future__ import annotations

import os
import signal
import subprocess
from pathlib import Path

import numpy as np
import pytest
from asperity import EquilibriumLost, Interface, Material, Pattern
from asperity.installed import driver
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

pytestmark = pytest.mark.slow

EXAMPLES = int(os.environ.get("ASPERITY_EXAMPLES", "120"))

PATIENCE = 60.0
"""Seconds after which a run must have written many rows: a corrupted file may request ten million."""

MATERIAL = (
    b"&material sigma0 = 3.0, Gc = 0.3, eta = 0.9, mu = 0.5, kc = 2.0, tau_v = 0.0, guard = .false. /\n"
)
PATTERN = b"&pattern sides = 4, theta = 30.0, flat = 0.25, turn = 5.0 /\n"
CUT = """
#include <signal.h>
#include <sys/syscall.h>
#include <unistd.h>
ssize_t write(int file, const void *bytes, size_t n) {
  static int rows = 0;
  if (n < 100 || ++rows != 20) return syscall(SYS_write, file, bytes, n);
  const ssize_t part = syscall(SYS_write, file, bytes, n / 2);
  raise(SIGTERM);
  return part;
}
"""
"""A write that the 20th time is cut by a signal, as the kernel does it at a page."""

CASES = (
    MATERIAL + PATTERN + b"&step t_N = -5.0, increments = 9, time = 2.0 /\n"
    b"&step slip = 0.3, -0.2, direction = 20.0, increments = 30, 9 /\n"
    b"&expect t_N = -5.0, tolerance = 0.001, end = 'complete' /\n",
    b"&case title = 'two runs', planes = .true. /\n" + MATERIAL + b"! a comment\n"
    b"&pattern normals = 1, 0, 0, 0.9, 0.1, 2*0.2, weights = 0.25, 0.75 /\n"
    b"&step s_N = x, s_Tx = 0.05, t_Ty = 0.0, k_Ty = 10.0, increments = 20, cycles = 2 /\n"
    b"&sweep name = 'x', values = 0.01, -0.01 /\n&expect end = 'complete', when = 0.01 /\n",
    MATERIAL
    + PATTERN
    + b"&replay file = 'record.csv', h = 0.5, map = 0, r = 0.0, dtime = 0.1, ntens = 3 /\n",
    MATERIAL + PATTERN + b"&initial traction = -1.0, 0.2, 0.1, damage = 0.5, slip = 0.01, 0.0 /\n"
    b"&step t_N = -2.0, s_Tx = 0.1, increments = 9 /\n",
)
RECORDS = (
    b"time,s_N,s_Tx,s_Ty\n0.5,0.01,0.02,-0.01\n1.0,-0.02,0.1,0.05\n2.0,-0.02,-0.1,1e-3\n",
    b"# recorded\ne_1,e_2,e_3\n0.01,0.02,-0.01\n\n-0.02,0.1,0.05\n",
    b"0.01,0.02,-0.01\n-0.02,0.1,0.05\n",
)
TOKENS = [
    *(
        b"nan inf -inf 1e999 1e-999 1e308 -1e300 5e-324 0 -0.0 1e50 -1 1.5 99999999999 2147483648 "
        b".true. '' ' \""
    ).split(),
    *(b"/ & = , ! * \n \r\n \r \t \x00 \x7f \xff \xef\xbb\xbf 3* *3 1d5 &step &replay /* %n %s ../ x").split(
        b" "
    ),
    b"9" * 400,
    b"a" * 5000,
    b"1," * 3000,
]


@st.composite
def spoilt(draw: st.DrawFn, texts: tuple[bytes, ...]) -> bytes:
    """A text with one to four changes: cut, doubled, moved, overwritten or torn bytes, or awkward words."""
    text = draw(st.sampled_from(texts))
    for _ in range(draw(st.integers(1, 4))):
        at, length = draw(st.integers(0, len(text))), draw(st.integers(0, 40))
        piece = text[at : at + length]
        change = draw(st.sampled_from(["cut", "double", "word", "word", "bytes", "flip", "end"]))
        if change == "cut":
            text = text[:at] + text[at + length :]
        elif change == "double":
            text = text[:at] + piece + text[at:]
        elif change == "word":
            text = text[:at] + draw(st.sampled_from(TOKENS)) + text[at + draw(st.integers(0, 4)) :]
        elif change == "bytes":
            text = text[:at] + draw(st.binary(max_size=30)) + text[at:]
        elif change == "flip" and piece:
            text = text[:at] + bytes([piece[0] ^ (1 << draw(st.integers(0, 7)))]) + text[at + 1 :]
        else:
            text = text[:at]
    return text


def rows_are_whole(folder: Path) -> int:
    """Rows of all results; each must be complete and finite."""
    rows = 0
    for path in folder.glob("*.csv"):
        if path.name == "record.csv":
            continue
        text = path.read_text(encoding="ascii")
        assert text == "" or text.endswith("\n")
        header, *lines = [line.split(",") for line in text.splitlines()] or [[]]
        event = header.index("event") if header else 0
        for line in lines:
            assert len(line) == len(header), line
            numbers = [float(cell) for i, cell in enumerate(line) if i != event]
            assert np.isfinite(numbers).all(), line
        rows += len(lines)
    return rows


def run_spoilt(folder: Path, case: bytes, record: bytes) -> None:
    """The driver ends with one of its exit codes, and with a message if the code is not 0."""
    folder.mkdir(exist_ok=True)
    for path in folder.iterdir():
        path.unlink()
    (folder / "case.nml").write_bytes(case)
    (folder / "record.csv").write_bytes(record)
    try:
        done = subprocess.run(
            [driver(), "case.nml"], cwd=folder, capture_output=True, timeout=PATIENCE, check=False
        )
    except subprocess.TimeoutExpired:
        assert rows_are_whole(folder) > 1000
        return
    messages = done.stderr.decode("utf-8", errors="replace")
    assert done.returncode in (0, 1, 2), messages
    assert "Fortran" not in messages and "rror termination" not in messages
    lines = messages.replace("\r", "\n").splitlines()
    assert all(line.startswith("rie_driver: ") for line in lines if line), messages[:2000]
    if done.returncode > 0:
        assert any(len(line) > len("rie_driver: ") + 10 for line in lines), messages
    if done.returncode == 1:
        assert ":" in lines[0], messages
    rows_are_whole(folder)


QUICK = {"deadline": None, "suppress_health_check": list(HealthCheck)}
ANY = st.binary(max_size=300)


@settings(max_examples=4 * EXAMPLES, derandomize="ASPERITY_EXAMPLES" not in os.environ, **QUICK)
@given(
    case=st.one_of(spoilt(CASES), spoilt(CASES), st.sampled_from(CASES[2:]), ANY),
    record=st.one_of(spoilt(RECORDS), st.sampled_from(RECORDS), ANY),
)
def test_spoilt_files(tmp_path_factory: pytest.TempPathFactory, case: bytes, record: bytes) -> None:
    """The driver reads corrupted and random case files and strain records to a regular end."""
    run_spoilt(tmp_path_factory.getbasetemp() / "spoilt", case, record)


any_float = st.floats(allow_nan=True, allow_infinity=True, allow_subnormal=True)
sizes = st.one_of(any_float, st.floats(-1.0, 1.0), st.floats(1e-6, 1e3))


USUAL = (3.0, 0.3, 0.9, 0.5, 0.0, 1.0, 30.0, 0.3, 0.0)


@pytest.mark.filterwarnings("ignore::asperity.ModelWarning")
@settings(max_examples=3 * EXAMPLES, derandomize=True, **QUICK)
@given(
    values=st.tuples(*(st.one_of(st.just(usual), sizes) for usual in USUAL)),
    s=st.lists(st.tuples(sizes, sizes, sizes), min_size=1, max_size=3),
    entry=st.tuples(st.integers(0, 23), st.one_of(st.just(0.0), sizes)),
    dt=st.one_of(st.none(), sizes),
)
def test_any_numbers(
    values: tuple[float, ...], s: list[tuple[float, ...]], entry: tuple[int, float], dt: float | None
) -> None:
    """Arbitrary numbers give a ValueError with the expectation, or finite results that can be continued."""
    sigma0, Gc, eta, mu, tau_v, kc, theta, flat, turn = values
    times, arrays = None if dt is None else abs(dt) * np.arange(len(s)), []
    try:
        material = Material(sigma0, Gc, eta, mu, tau_v=tau_v, kc=kc)
        interface = Interface(material, Pattern.regular(4, theta, flat, turn))
        state = np.zeros((len(s), interface.nstatv))
        state[:, entry[0] % interface.nstatv] = entry[1]
        result = interface.update(s, state, dt=dt)
        again = interface.update(s, result.state, s, dt=dt)
        arrays += [result.traction, result.tangent, result.state, again.traction]
        arrays.append(interface.replay(s, times).state)
        try:
            slips = [row[1] for row in s]
            history = interface.confined_slip(turn, slips, s[0][0], preload=3, times=times)
        except EquilibriumLost as lost:
            history = lost.history
            assert str(lost)
        arrays += [history.traction, history.state]
    except ValueError as error:
        assert "expected" in str(error)
    assert all(np.isfinite(array).all() for array in arrays)


def test_signal_within_a_row(tmp_path: Path) -> None:
    """A row of which a part is written when the run is ended is written to its end."""
    (tmp_path / "cut.c").write_text(CUT, encoding="ascii")
    subprocess.run(["cc", "-shared", "-fPIC", "cut.c", "-o", "cut.so"], cwd=tmp_path, check=True)
    case = (MATERIAL + PATTERN).decode() + "&step slip = 0.3, increments = 100 /\n"
    (tmp_path / "case.nml").write_text(case, encoding="ascii")
    environment = {**os.environ, "LD_PRELOAD": str(tmp_path / "cut.so")}
    done = subprocess.run([driver(), "case.nml", "--planes", "--quiet"], cwd=tmp_path, env=environment)
    assert done.returncode == -signal.SIGTERM
    assert 0 < rows_are_whole(tmp_path) < 100
