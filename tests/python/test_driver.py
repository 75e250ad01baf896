"""Tests of the driver `rie_driver`: closed forms, load paths, replay, exit codes, bad input."""

from __future__ import annotations

import math
import os
import random
import re
import subprocess
from pathlib import Path

import numpy as np
import pytest
from asperity import installed
from asperity.oracle import reference

ROOT = Path(__file__).resolve().parents[2]
CASES = ROOT / "harness" / "cases"
COLUMNS = (
    "step increment time s_N s_Tx s_Ty t_N t_Tx t_Ty damage stored rupture friction work iterations event"
).split()

# The parameters of Table 2 of the paper, and the quantities that follow from them by (12).
SIGMA0, GC, ETA, MU = 3.0, 0.3, 0.9, 0.5
S_F = 2 * GC / SIGMA0
S_0 = (1 - ETA) * S_F
K = SIGMA0 / S_0

MATERIAL = f"&material sigma0 = {SIGMA0}, Gc = {GC}, eta = {ETA}, mu = {MU} /\n"
FLAT = "&pattern sides = 0 /\n"
RP_4 = "&pattern sides = 4, theta = 30.0 /\n"

# The solver accepts a residual of 1e-13 (K |s| + |sigma|), here at most 1e-13 (150*0.6 + 20) MPa.
# The tolerance is ten times that.
TRACTION_TOLERANCE = 1.1e-10


@pytest.fixture(scope="session")
def driver() -> Path:
    """Return the path of the driver."""
    return installed.driver().resolve()


class Result:
    """Results of a run of the driver: exit code, messages and rows."""

    def __init__(self, process: subprocess.CompletedProcess[str], output: Path):
        """Read the CSV if there is one."""
        self.code, self.messages, self.stdout = process.returncode, process.stderr, process.stdout
        self.header, self.rows = read_csv(output.read_text()) if output.exists() else ([], [])

    def __getitem__(self, name: str) -> np.ndarray:
        """A column as numbers."""
        return np.array([float(row[self.header.index(name)]) for row in self.rows])

    @property
    def events(self) -> list[set[str]]:
        """Events of every row."""
        column = self.header.index("event")
        return [set(row[column].split("+")) - {""} for row in self.rows]

    def vector(self, prefix: str) -> np.ndarray:
        """(T, 3): components N, Tx, Ty of `s` or `t`."""
        return np.stack([self[f"{prefix}_{c}"] for c in ("N", "Tx", "Ty")], axis=1)


def read_csv(text: str) -> tuple[list[str], list[list[str]]]:
    """Return header and rows; every row must be complete."""
    assert text.endswith("\n")
    lines = [line.split(",") for line in text.splitlines()]
    assert {len(line) for line in lines} == {len(lines[0])}
    return lines[0], lines[1:]


def call(driver: Path, *arguments: str | Path, folder: Path) -> subprocess.CompletedProcess[str]:
    """Run the driver in a folder."""
    return subprocess.run([driver, *arguments], cwd=folder, capture_output=True, text=True, timeout=120)


@pytest.fixture
def run(driver: Path, tmp_path: Path):
    """Run a case given by its text; the exit code must be the expected one."""

    def run_text(text: str | bytes, *options: str, code: int = 0) -> Result:
        case = tmp_path / "case.nml"
        case.write_bytes(text if isinstance(text, bytes) else text.encode())
        output = tmp_path / "case.csv"
        output.unlink(missing_ok=True)
        process = call(driver, "case.nml", *options, folder=tmp_path)
        assert process.returncode == code, process.stderr
        return Result(process, output)

    return run_text


@pytest.fixture(scope="session")
def shipped(driver: Path, tmp_path_factory: pytest.TempPathFactory):
    """Run a shipped case once; return its results by the value of the sweep ("" without a sweep)."""
    done: dict[str, dict[str, Result]] = {}

    def run_case(name: str) -> dict[str, Result]:
        if name not in done:
            folder = tmp_path_factory.mktemp(name)
            process = call(driver, CASES / f"{name}.nml", folder=folder)
            assert process.returncode == 0, process.stderr
            found = {path.stem[len(name) + 1 :]: Result(process, path) for path in folder.glob("*.csv")}
            assert found
            done[name] = found
        return done[name]

    return run_case


def assert_traction(actual: np.ndarray, expected: np.ndarray | float) -> None:
    """Assert that tractions are equal within the residual that the solver accepts."""
    np.testing.assert_allclose(actual, expected, rtol=0, atol=TRACTION_TOLERANCE)


# --- the paper's figures ------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", sorted(path.stem for path in CASES.glob("*.nml")))
def test_shipped_cases_end_as_expected(shipped, name: str) -> None:
    """Every shipped case ends with 0, needs few Newton iterations in a row, and balances its energies."""
    for result in shipped(name).values():
        assert result.header == COLUMNS
        regular = [i for i, event in enumerate(result.events) if not event & {"lost", "substeps"}]
        assert len(regular) >= len(result.rows) - 1
        iterations = result["iterations"][regular]
        assert (iterations <= 6).sum() >= 0.9 * len(iterations)  # quadratic convergence, a switch or two
        assert iterations.max() <= 100  # where the branch has to be followed in smaller steps
        ledger = result["stored"] + result["rupture"] + result["friction"]
        # second order in the step of 0.0025 mm = s_0/8 (1.25 s_0 for eta = 0.99); the largest is 0.0043 N/mm
        assert np.abs(result["work"] - ledger).max() < 0.005
        assert (np.diff(result["friction"]) >= 0).all()


def test_every_figure_has_its_case() -> None:
    """There is a case for every figure that the project promises."""
    names = " ".join(path.stem for path in CASES.glob("*.nml"))
    wanted = "02 04a 04b 05a 05b 07a 07b 08a 08b 09a 09b 10a 10b 11 12 13a 13b".split()
    assert [figure for figure in wanted if not re.search(rf"(figure|_){figure}(_| |$)", names)] == []


def test_figure_2_is_the_triangle(shipped) -> None:
    """In mode I the slope is K up to sigma0, then a straight line leads to s_f; area and work are Gc."""
    result = shipped("figure02")[""]
    s, t = result["s_N"], result["t_N"]
    law = np.where(s <= S_0, K * s, np.maximum(0.0, SIGMA0 * (S_F - s) / (S_F - S_0)))
    np.testing.assert_allclose(t, law, rtol=0, atol=1e-13 * K * S_F)
    area = np.trapezoid(np.append(0.0, t), np.append(0.0, s))
    assert area == pytest.approx(GC, rel=1e-12)
    assert result["work"][-1] == pytest.approx(GC, rel=1e-12)
    assert result["rupture"][-1] == pytest.approx(GC, rel=2e-3)  # the trapezoid of Y is second order
    # onset in the first row beyond s_0, full damage in the first at s_f
    onset = next(i for i, event in enumerate(result.events) if "onset" in event)
    assert s[onset - 1] <= S_0 * (1 + 1e-12) < s[onset] * (1 + 1e-9)
    broken = next(i for i, event in enumerate(result.events) if "damaged" in event)
    assert s[broken - 1] < S_F * (1 - 1e-9) and s[broken] == pytest.approx(S_F, rel=1e-12)


def tension_limit(eta: float, sigma: float) -> float:
    """Return the slip beyond which no opening s_N satisfies (1-alpha) K s_N = sigma (7)."""
    s_0 = (1 - eta) * S_F
    opening = np.linspace(0.0, S_F, 200001)

    def largest(slip: float) -> float:
        r = np.maximum(1.0, np.hypot(opening, slip) / s_0)
        return float(((1 - np.minimum(1.0, (1 - 1 / r) / eta)) * SIGMA0 / s_0 * opening).max())

    low, high = 0.0, S_F
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if largest(middle) > sigma else (low, middle)
    return low


@pytest.mark.parametrize(
    ("name", "eta"), [("figure04a", 0.9), ("figure07a_08a_10a", 0.99), ("figure07b_08b_10a", 0.99)]
)
def test_tension_loses_equilibrium_where_the_law_does(shipped, name: str, eta: float) -> None:
    """sigma_N = +2: the last row is the last equilibrium, where the closed form has its maximum."""
    result = shipped(name)["2"]
    assert "lost" in result.events[-1] and not any("lost" in event for event in result.events[:-1])
    slip = np.hypot(result["s_Tx"], result["s_Ty"])[-1]
    # 2**-20 of a step, and the grid of the closed form
    assert slip == pytest.approx(tension_limit(eta, 2.0), abs=1e-6)
    assert_traction(result["t_N"][-11:], 2.0)


def test_flat_residual_is_the_friction_strength(shipped) -> None:
    """Figure 4(a): under constant sigma_N the fully damaged flat plane slides at mu |sigma_N|."""
    for value, result in shipped("figure04a").items():
        if float(value) > 0:
            continue
        dead = result["damage"] == 1.0
        assert dead.sum() > 100
        assert_traction(result["t_Tx"][dead], MU * abs(float(value)))
        assert_traction(result["t_N"][result["step"] == 2], float(value))


def test_residual_up_the_slope(shipped) -> None:
    """Figure 5(a): sliding straight up one facing plane, (mu + tan theta)/(1 - mu tan theta)."""
    slope = math.tan(math.radians(35.0))
    for value, result in shipped("figure05a").items():
        expected = abs(float(value)) * (MU + slope) / (1 - MU * slope)
        assert result["t_Tx"][-1] == pytest.approx(expected, abs=TRACTION_TOLERANCE)


def test_direction_symmetry(shipped) -> None:
    """Figure 11: theta_L and 90 - theta_L mirror each other at 45 degrees, Tx and Ty exchanged."""
    results = shipped("figure11")
    for a, b in (("0", "90"), ("15", "75"), ("30", "60")):
        s, t = results[a].vector("s"), results[b].vector("s")
        np.testing.assert_allclose(s, t[:, [0, 2, 1]], rtol=0, atol=1e-12)
        s, t = results[a].vector("t"), results[b].vector("t")
        assert_traction(s, t[:, [0, 2, 1]])


def test_frictionless_energy_is_gc_to_second_order(run) -> None:
    """Figure 13(b): without friction G_T = Gc whatever the slope; the error of the work is second order."""
    for theta in (0.0, 30.0, 45.0):
        errors = []
        for increments in (240, 1920):
            result = run(
                f"&material sigma0 = 3.0, Gc = 0.3, eta = 0.9, mu = 0.0 /\n"
                f"&pattern sides = 4, theta = {theta}, flat = 0.2 /\n"
                f"&step t_N = 0.0, slip = 0.6, direction = 45.0, increments = {increments} /\n"
            )
            errors.append(abs(result["work"][-1] - GC))
        assert errors[0] < 1e-4
        assert errors[1] < errors[0] / 32 or errors[1] < 1e-12  # 64 but for kinks between the points


def test_known_point(run) -> None:
    """RP-4, 30 degrees, direction 0, sigma_N = -10: |tau| = 10.5781, s_N = -0.053572 at s_L = 0.6."""
    result = run(MATERIAL + RP_4 + "&step t_N = -10.0 /\n&step slip = 0.6, increments = 2400 /\n")
    assert result["t_Tx"][-1] == pytest.approx(10.5781, abs=5e-5)
    assert result["s_N"][-1] == pytest.approx(-0.053572, abs=5e-7)


# --- load paths ---------------------------------------------------------------------------------------------


def test_rows_and_targets(run) -> None:
    """Lists, increments by target, cycles and time: one row per increment, targets hit exactly."""
    result = run(
        MATERIAL + FLAT + "&step s_N = 0.001, time = 3.0 /\n"
        "&step s_Tx = 0.4, -0.4, increments = 10, 20, cycles = 2, time = 6.0 /\n"
    )
    assert len(result.rows) == 100 + 2 * 30
    assert [int(row[0]) for row in result.rows] == [1] * 100 + [2] * 60
    assert [int(row[1]) for row in result.rows] == [*range(1, 101), *range(1, 61)]
    times = [*np.arange(1, 101) * 0.03, *(3 + np.arange(1, 61) * 0.1)]
    np.testing.assert_allclose(result["time"], times, rtol=1e-14)
    slip = result["s_Tx"][100:]
    assert list(slip[[9, 29, 39, 59]]) == [0.4, -0.4, 0.4, -0.4]
    assert slip[19] == 0.0 and slip[14] == pytest.approx(0.2)
    assert (result["s_N"][100:] == 0.001).all() and (result["s_Ty"] == 0.0).all()


def test_slip_along_a_direction(run) -> None:
    """A slip step follows its direction, exactly along the axes; the next step has the same direction."""
    for degrees in (0.0, 30.0, 90.0, 180.0, 270.0, -90.0, 450.0):
        result = run(MATERIAL + RP_4 + f"&step slip = 0.01, direction = {degrees} /\n&step slip = 0.02 /\n")
        slip = np.repeat([0.01, 0.02], 100) * 0.01 * np.tile(np.arange(1, 101), 2)
        slip[100:] = 0.01 + 0.0001 * np.arange(1, 101)
        angle = math.radians(degrees)
        np.testing.assert_allclose(result["s_Tx"], slip * math.cos(angle), rtol=0, atol=1e-16)
        np.testing.assert_allclose(result["s_Ty"], slip * math.sin(angle), rtol=0, atol=1e-16)
        if degrees % 90 == 0:
            assert (result["s_Tx"] == 0).all() or (result["s_Ty"] == 0).all()


def test_steps_go_on(run) -> None:
    """Two steps equal one step; a component that is not named keeps its condition and value."""
    whole = run(MATERIAL + RP_4 + "&step t_N = -5.0 /\n&step slip = 0.4, increments = 160 /\n")
    parts = run(
        MATERIAL + RP_4 + "&step t_N = -5.0 /\n&step s_Tx = 0.1, increments = 40 /\n"
        "&step s_Tx = 0.4, increments = 120 /\n"
    )
    for name in COLUMNS[3:14]:
        np.testing.assert_allclose(parts[name], whole[name], rtol=0, atol=1e-10, err_msg=name)
    assert_traction(parts["t_N"][100:], -5.0)


def test_normal_stiffness(run) -> None:
    """CNS: t_N = t_N0 - k (s_N - s_N0) from the start of the step on, until it is switched off."""
    k = 20.0
    result = run(
        MATERIAL + RP_4 + f"&step t_N = -1.0 /\n&step k_N = {k}, slip = 0.3, 0.6 /\n&step slip = 0.5 /\n"
        "&step k_N = 0.0, slip = 0.6 /\n&step k_N = 5.0, t_N = -4.0 /\n"
    )
    s, t, step = result["s_N"], result["t_N"], result["step"]
    springy = (step == 2) | (step == 3)
    assert_traction(t[springy], -1.0 - k * (s[springy] - s[99]))
    assert t[step == 2][-1] < -3.0  # the dilation built up pressure
    before = t[step == 3][-1]
    assert_traction(t[step == 4], before)
    s_start = s[step == 4][-1]
    ramp = before + (-4.0 - before) * np.arange(1, 101) / 100
    assert_traction(t[step == 5], ramp - 5.0 * (s[step == 5] - s_start))


def test_free_transverse_traction(run) -> None:
    """s_Tx given, t_Ty = 0 on a turned pattern: the point moves aside."""
    result = run(
        MATERIAL + "&pattern sides = 2, theta = 30.0, turn = 20.0 /\n&step t_N = -2.0, t_Ty = 0.0 /\n"
        "&step s_Tx = 0.3 /\n"
    )
    assert_traction(result["t_Ty"], 0.0)
    assert abs(result["s_Ty"][-1]) > 0.01


def test_traction_control_of_all_components(run) -> None:
    """Below the onset of damage and without inclined planes s = t/K."""
    result = run(MATERIAL + FLAT + "&step t_N = 1.5, t_Tx = 1.0, -2.0, t_Ty = -0.5 /\n")
    np.testing.assert_allclose(result.vector("s"), result.vector("t") / K, rtol=1e-12, atol=1e-17)
    assert list(np.round(result.vector("t")[-1], 12)) == [1.5, -2.0, -0.5]
    assert result["damage"].max() == 0.0


def test_control_may_change(run) -> None:
    """Control changes from traction to separation and back; the point continues from its state."""
    result = run(
        MATERIAL + RP_4 + "&step t_N = -5.0 /\n&step s_N = -0.05 /\n&step s_Tx = 0.1 /\n&step t_N = -5.0 /\n"
        "&step s_Tx = 0.12, s_Ty = 0.05 /\n"
    )
    step = result["step"]
    assert (result["s_N"][step == 3] == -0.05).all()
    t_start, t = result["t_N"][step == 3][-1], result["t_N"][step == 4]
    assert_traction(t, t_start + (-5.0 - t_start) * np.arange(1, 101) / 100)
    assert_traction(result["t_N"][step == 5], -5.0)


def test_listed_planes_are_the_regular_pattern(run) -> None:
    """Table 1 as listed planes gives what the trapezoidal pattern gives; normals need not be of length 1."""
    path = "&step t_N = -5.0 /\n&step slip = 0.3, direction = 25.0 /\n"
    slope = math.tan(math.radians(30.0))
    regular = run(MATERIAL + "&pattern sides = 2, theta = 30.0 /\n" + path)
    listed = run(
        MATERIAL
        + f"&pattern normals = 1, 0, 0, 2, {-2 * slope}, 0, 1, {slope}, 0, weights = 3*0.3333333333333333 /\n"
        + path
    )
    for name in COLUMNS[3:14]:
        np.testing.assert_allclose(listed[name], regular[name], rtol=0, atol=1e-9, err_msg=name)


def test_columns_per_plane(run) -> None:
    """--planes and &case planes: alpha_k, s_dit_k, s_dih_k, whose weighted sum is the damage."""
    path = MATERIAL + RP_4 + "&step t_N = -5.0 /\n&step slip = 0.1, direction = 10.0 /\n"
    result = run(path, "--planes")
    names = [f"{name}_{k}" for k in range(1, 6) for name in ("alpha", "s_dit", "s_dih")]
    assert result.header == COLUMNS + names
    weights = [1 / 3] + [1 / 6] * 4
    total = sum(w * result[f"alpha_{k}"] for k, w in enumerate(weights, 1))
    np.testing.assert_allclose(total, result["damage"], rtol=1e-14, atol=1e-16)
    assert np.abs(result["s_dit_2"]).max() > 0 and np.abs(result["s_dih_1"]).max() > 0
    assert run("&case planes = .true. /\n" + path).header == result.header
    assert run("&case planes = F /\n" + path).header == COLUMNS


def test_events(run) -> None:
    """Each event at the row where the columns show it."""
    result = run(
        MATERIAL + FLAT + "&step s_N = 0.03, increments = 30 /\n&step s_N = -0.02, increments = 50 /\n"
        "&step s_Tx = 0.05, increments = 50 /\n&step s_N = 0.25, increments = 27 /\n",
        "--planes",
    )
    s, alpha = result["s_N"], result["alpha_1"]
    rows = {name: [i for i, event in enumerate(result.events) if name in event] for name in COLUMNS_OF_EVENTS}
    assert rows["onset"] == [int(np.argmax(alpha > 0))]
    assert rows["damaged"] == [int(np.argmax(alpha >= 1))]
    assert rows["close"] == [int(np.argmax((s < 0) & (np.arange(len(s)) > 30)))]
    assert rows["open"] == [int(np.argmax((s > 0) & (np.arange(len(s)) > 100)))]
    # the slip starts where the elastic shear of the damaged part reaches mu p: s_Tx = mu |s_N|
    start = int(np.argmax(np.abs(result["s_dit_1"]) > 0))
    assert rows["slip"] == [start]
    assert result["s_Tx"][start] == pytest.approx(MU * 0.02, abs=0.05 / 50 + 1e-12)
    assert rows["lost"] == rows["snap"] == rows["substeps"] == rows["cut"] == []


COLUMNS_OF_EVENTS = "onset damaged open close slip snap substeps cut lost".split()


def test_numbers_come_back_exactly(run) -> None:
    """17 digits: a value reads back as it was; also in very small and very large units."""
    result = run(MATERIAL + FLAT + "&step s_N = 0.1234567890123456789 /\n")
    assert result["s_N"][-1] == 0.1234567890123456789
    opening = FLAT + "&step s_N = 0.25 /\n"
    small = run("&material sigma0 = 3.0e-40, Gc = 3.0e-41, eta = 0.9, mu = 0.5 /\n" + opening)
    large = run("&material sigma0 = 3.0e40, Gc = 3.0e39, eta = 0.9, mu = 0.5 /\n" + opening)
    np.testing.assert_allclose(small["t_N"] * 1e40, large["t_N"] * 1e-40, rtol=1e-12, atol=1e-12)


# --- which root ---------------------------------------------------------------------------------------------

SLOPE = math.tan(math.radians(30.0))


def test_dead_interface_closes(run) -> None:
    """A fully damaged, open point closes under pressure, and the jump is an event."""
    for pattern in (FLAT, RP_4):
        result = run(MATERIAL + pattern + "&step s_N = 0.5 /\n&step t_N = -5.0 /\n")
        assert_traction(result["t_N"][100:], -0.05 * np.arange(1, 101))
        assert np.all(result["s_N"][100:] < 0.0)
        jumps = [i for i, event in enumerate(result.events) if "snap" in event]
        assert jumps == [100] and "close" in result.events[100]
        if pattern == FLAT:
            np.testing.assert_allclose(result["s_N"][100:], result["t_N"][100:] / K, rtol=1e-9)


def test_dead_states_take_the_smallest_opening(run, shipped) -> None:
    """Figure 9(a), sigma_N = 0: after full damage s_N = |s_L| tan(theta), up and down."""
    result = run(
        MATERIAL + "&pattern sides = 2, theta = 30.0 /\n&step t_N = 0.0, increments = 1 /\n"
        "&step slip = 0.4, -0.4, 0.0, increments = 40 /\n"
    )
    dead = result["damage"] >= 1.0 - 1e-15
    assert dead.sum() > 60 and result["s_Tx"][-1] == 0.0
    np.testing.assert_allclose(
        result["s_N"][dead], SLOPE * np.abs(result["s_Tx"][dead]), rtol=0, atol=1e-11 * S_F
    )
    figure = shipped("figure09a_10b")["0"]
    rest = (figure["damage"] >= 1.0 - 1e-15) & (figure["s_Tx"] == 0.0)
    assert rest.any() and np.all(np.abs(figure["s_N"][rest]) <= 1e-11 * S_F)


@pytest.mark.parametrize("steps", [20, 200, 20000])
@pytest.mark.parametrize(
    ("sides", "slip", "before", "after"),
    [(4, None, 0, 0), (12, None, 0, 0), (13, 0.1732, 0.0993, 0.1), (14, 0.1733, 0.096, 0.1),
     (16, 0.1736, 0.0926, 0.1002), (32, 0.1737, 0.0983, 0.1003)],
)  # fmt: skip
def test_fold_is_noticed(
    run, sides: int, slip: float | None, before: float, after: float, steps: int
) -> None:
    """RP-13 and finer snap to s_N = s_L tan(theta), fully damaged, at one slip for any increment."""
    result = run(
        MATERIAL + f"&pattern sides = {sides}, theta = 30.0 /\n&step t_N = 0.0, increments = 1 /\n"
        f"&step slip = 0.2, increments = {steps} /\n"
    )
    jumps = [i for i, event in enumerate(result.events) if "snap" in event]
    assert len(jumps) == (slip is not None)
    told = re.findall(
        r"step 2 increment (\d+): snap from s = \((\S+), (\S+), 0\) to \((\S+), \S+, 0\), (\S+) released",
        result.messages,
    )
    assert len(told) == len(jumps)
    for row, (increment, *values) in zip(jumps, told, strict=True):
        assert int(increment) == row  # row 0 is the preload
        s_n, s_l, s_n_after, released = map(float, values)
        assert s_l == pytest.approx(slip, abs=6e-5)
        # the last equilibrium is 2^-20 of an increment away from the fold, s_N by the root of that
        assert s_n == pytest.approx(before, abs=2e-4) and s_n_after == pytest.approx(after, abs=6e-5)
        assert 0.0 < released < 1e-5
        assert result["s_N"][row] == pytest.approx(SLOPE * result["s_Tx"][row], abs=1e-11)
    if slip is not None:
        assert result["s_N"][-1] == pytest.approx(SLOPE * 0.2, abs=1e-11)


# --- sweeps and output --------------------------------------------------------------------------------------


def test_sweep(run, tmp_path: Path) -> None:
    """A sweep writes one CSV per value, equal to that of a case file with this value."""
    text = (
        MATERIAL + "&pattern sides = 2, theta = THETA /\n&sweep name = 'Theta', values = 0.0, 30.0, 12.5 /\n"
        "&step t_N = -5.0 /\n&step slip = 0.1 /\n"
    )
    run(text)
    names = ["case_0.csv", "case_12.5.csv", "case_30.csv"]
    assert sorted(path.name for path in tmp_path.glob("*.csv")) == names
    run(text, "-o", "other.csv")
    renamed = [name.replace("case", "other") for name in names]
    assert sorted(path.name for path in tmp_path.glob("other*")) == renamed
    run(re.sub("&sweep.*\n", "", text).replace("THETA", "12.5"))
    assert (tmp_path / "case.csv").read_bytes() == (tmp_path / "case_12.5.csv").read_bytes()
    assert (tmp_path / "other_30.csv").read_bytes() == (tmp_path / "case_30.csv").read_bytes()
    assert "standard output" in run(text, "-o", "-", code=1).messages


def test_output(run, driver: Path, tmp_path: Path) -> None:
    """-o FILE, -o - on standard output; the default is the name of the case in the current directory."""
    text = MATERIAL + FLAT + "&step s_N = 0.1, increments = 3 /\n"
    default = run(text)
    assert "written to case.csv" in default.messages and len(default.messages.splitlines()) == 1
    quiet = run(text, "--quiet", "-o", "-")
    assert quiet.messages == "" and quiet.rows == []
    assert read_csv(quiet.stdout) == (default.header, default.rows)
    (tmp_path / "elsewhere").mkdir()
    subprocess.run([driver, "../case.nml"], cwd=tmp_path / "elsewhere", check=True, capture_output=True)
    assert read_csv((tmp_path / "elsewhere" / "case.csv").read_text())[1] == default.rows
    assert "cannot be written" in run(text, "-o", "no/such/folder.csv", code=1).messages
    assert "replace the case file" in run(text, "-o", "case.nml", code=1).messages
    if Path("/dev/full").exists():
        assert "cannot be written" in run(text, "-o", "/dev/full", code=1).messages
        with Path("/dev/full").open("w") as full:
            echo = subprocess.run(
                [driver, "case.nml", "--echo"], cwd=tmp_path, stdout=full, stderr=subprocess.PIPE
            )
        assert echo.returncode == 1 and b"standard output: cannot be written" in echo.stderr


def test_input_is_not_replaced(run, driver: Path, tmp_path: Path) -> None:
    """Neither the case nor the record can be the output, by whatever name."""
    text = MATERIAL + FLAT + "&step s_N = 0.1, increments = 3 /\n"
    (tmp_path / "link.nml").symlink_to("case.nml")
    (tmp_path / "sub").mkdir()
    for name in ("./case.nml", "sub/../case.nml", "link.nml", str(tmp_path / "case.nml")):
        assert "would replace the case file" in run(text, "-o", name, code=1).messages
        assert (tmp_path / "case.nml").read_text() == text
    record = "0.01,0,0\n"
    (tmp_path / "rec.csv").write_text(record)
    replay = MATERIAL + FLAT + "&replay file = 'rec.csv' /\n"
    (tmp_path / "rec.nml").write_text(replay)
    (tmp_path / "link.csv").symlink_to("rec.csv")
    for arguments in (["rec.nml"], ["rec.nml", "-o", "./rec.csv"], ["rec.nml", "-o", "link.csv"]):
        process = call(driver, *arguments, folder=tmp_path)
        assert process.returncode == 1 and "would replace the recorded strains" in process.stderr
        assert (tmp_path / "rec.csv").read_text() == record
    assert call(driver, "rec.nml", "-o", "out.csv", folder=tmp_path).returncode == 0
    (tmp_path / "out_2.csv").write_text(record)
    sweep = replay.replace("mu = 0.5", "mu = x") + "&sweep name = 'x', values = 0.5, 2 /\n"
    assert "would replace" in run(sweep.replace("rec.csv", "out_2.csv"), "-o", "out.csv", code=1).messages
    assert (tmp_path / "out_2.csv").read_text() == record and not (tmp_path / "out_0.5.csv").exists()


def test_killed_run_leaves_whole_rows(driver: Path, tmp_path: Path) -> None:
    """A long run shows its progress on a terminal; killed, its CSV holds whole rows."""
    (tmp_path / "long.nml").write_text(
        MATERIAL + "&pattern sides = 64, theta = 30.0 /\n&step slip = 0.02, increments = 10000000 /\n"
    )
    screen, terminal = os.openpty()
    with subprocess.Popen([driver, "long.nml", "--planes"], cwd=tmp_path, stderr=terminal) as process:
        os.close(terminal)
        # the first progress line, after two seconds
        line = os.read(screen, 200).decode()
        process.kill()
        process.wait()
    os.close(screen)
    assert re.fullmatch(
        r"\r\x1b\[Krie_driver: long.nml: \d+ of 10000000 increments \(0 %\), \d+ (s|min) left", line
    )
    assert process.returncode != 0
    header, rows = read_csv((tmp_path / "long.csv").read_text())
    assert len(rows) > 100 and len(header) == len(COLUMNS) + 3 * 65
    assert [int(row[1]) for row in rows] == [*range(1, len(rows) + 1)]
    assert float(rows[-1][4]) == pytest.approx(0.02 * len(rows) / 1e7, rel=1e-14)


@pytest.mark.parametrize("options", [[], ["--quiet"]])
def test_no_progress(options: list[str], driver: Path, tmp_path: Path) -> None:
    """A long run shows no progress in a file, nor with --quiet on a terminal."""
    (tmp_path / "long.nml").write_text(
        MATERIAL + "&pattern sides = 64, theta = 30.0 /\n&step slip = 0.02, increments = 10000000 /\n"
    )
    screen, terminal = os.openpty() if options else os.pipe()
    with subprocess.Popen([driver, "long.nml", *options], cwd=tmp_path, stderr=terminal) as process:
        os.close(terminal)
        with pytest.raises(subprocess.TimeoutExpired):
            process.wait(3.0)
        process.kill()
        process.wait()
    os.set_blocking(screen, False)
    try:
        written = os.read(screen, 200)
    except OSError:  # the terminal has gone with its last user
        written = b""
    os.close(screen)
    assert written == b""


# --- ends and exit codes ------------------------------------------------------------------------------------

LOSES = MATERIAL + FLAT + "&step t_N = 2.0 /\n&step slip = 0.1, increments = 100 /\n"


def test_lost_equilibrium_is_exit_2(run) -> None:
    """An unexpected loss of equilibrium gives a message and exit code 2.

    The CSV has every converged row, and the last equilibrium is marked.
    """
    result = run(LOSES, code=2)
    assert "equilibrium lost" in result.messages
    assert len(result.rows) == 100 + 31 + 1
    assert "lost" in result.events[-1]
    assert result["s_Tx"][-1] == pytest.approx(tension_limit(ETA, 2.0), abs=1e-6)


@pytest.mark.parametrize(
    ("expect", "code", "fragment"),
    [
        ("end = 'lost'", 0, ""),
        ("end = 'lost', slip = 0.031, s_Tx = 0.031, t_N = 2.0, tolerance = 1e-4", 0, ""),
        ("end = 'lost', slip = 0.05, tolerance = 1e-4", 2, "expected 0.05 within"),
        ("end = 'complete'", 2, "equilibrium lost"),
    ],
)
def test_expected_loss(run, expect: str, code: int, fragment: str) -> None:
    """The exit code is 0 if the run ends as the case states, and 2 otherwise."""
    assert fragment in run(LOSES + f"&expect {expect} /\n", code=code).messages


@pytest.mark.parametrize(
    ("steps", "fragment"),
    [
        (
            "&step t_N = 2.0 /\n&step slip = 0.1, increments = 100 /\n",
            "no equilibrium: largest t_N over s_N in [",
        ),
        ("&step s_N = 0.5 /\n&step t_N = 1.0 /\n", " is 0 < prescribed 9.5"),
        (
            "&step t_N = -5.0, t_Tx = 0.0 /\n&step t_Tx = 25.0 /\n",
            "reaches none, the smallest residual over",
        ),
    ],
)
def test_failed_increment_alone(run, driver: Path, tmp_path: Path, steps: str, fragment: str) -> None:
    """A failed increment is reported without equilibrium, and OUT.failed.nml fails in the same way."""
    pattern = "&pattern normals = 1, 0, 0, 0.9, 0.3, 0.1, weights = 0.4, 0.6 /\n" if "-5" in steps else FLAT
    result = run(MATERIAL + pattern + steps, code=2)
    assert fragment in result.messages
    assert "the failed increment was written to case.failed.nml" in result.messages
    assert "lost" in result.events[-1]
    process = call(driver, "case.failed.nml", "-o", "again.csv", folder=tmp_path)
    assert process.returncode == 2 and fragment.split(" held")[0] in process.stderr
    again = Result(process, tmp_path / "again.csv")
    assert len(again.rows) == 1 and "lost" in again.events[0]
    # the same state but for rounding; s_N at a fold by its root
    for name in ("s", "t"):
        np.testing.assert_allclose(again.vector(name)[0], result.vector(name)[-1], rtol=1e-6, atol=1e-6)
    for name in ("damage", "stored", "rupture", "friction", "work"):
        assert again[name][0] == pytest.approx(result[name][-1], rel=1e-6, abs=1e-9)


def test_no_replay_file_where_the_loss_is_expected(run, tmp_path: Path) -> None:
    """No OUT.failed.nml is written after a loss that the case states or after a completed run."""
    run(LOSES + "&expect end = 'lost' /\n")
    run(MATERIAL + FLAT + "&step s_N = 0.1 /\n")
    assert not list(tmp_path.glob("*.failed.nml"))


def test_state(run) -> None:
    """A run that starts from a row of another run continues as that run."""
    path = "&step t_N = -5.0, increments = 10 /\n&step slip = 0.1, increments = 20 /\n"
    whole = run(MATERIAL + RP_4 + path, "--planes")
    row = 19
    names = ["damage", "stored", "rupture", "friction"]
    planes = whole.header[len(COLUMNS) :]
    statev = [whole[name][row] for name in names] + [1, 0, 0, 0] + [whole[name][row] for name in planes]
    state = "&state separation = {}, statev = {}, work = {} /\n".format(
        *(", ".join(repr(float(x)) for x in values) for values in (whole.vector("s")[row], statev)),
        float(whole["work"][row]),
    )
    rest = run(MATERIAL + RP_4 + state + "&step t_N = -5.0, slip = 0.1, increments = 10 /\n", "--planes")
    for name in [*COLUMNS[3:14], *planes]:
        np.testing.assert_allclose(rest[name], whole[name][row + 1 :], rtol=1e-9, atol=1e-12, err_msg=name)
    assert rest.events[1:] == whole.events[row + 2 :]  # that a plane slides is not in the state


@pytest.mark.parametrize(
    ("state", "fragment"),
    [
        ("&state separation = 0, 0, statev = 11*0 /", "2 values of separation: expected three"),
        ("&state separation = 0, 0, 0, statev = 10*0 /", "10 values of statev: expected 11"),
        ("&state separation = 0, 0, 0, statev = 8*0, 2, 0, 0 /", "statev(9) alpha = 2"),
        ("&state separation = 0, 1e99, 0, statev = 11*0 /", "1e99"),
        ("&state s = 0, 0, 0 /", "unknown name, expected one of separation, statev, work"),
    ],
)
def test_bad_state(run, state: str, fragment: str) -> None:
    """A state that the law rejects is an input error."""
    result = run(MATERIAL + FLAT + state + "\n&step s_N = 0.1 /\n", code=1)
    assert fragment.lower() in result.messages.lower() and "&state" in result.messages


def test_expected_end_that_does_not_come(run) -> None:
    """A run that completes where a loss is expected, or with other values, is exit 2 with all rows."""
    completes = MATERIAL + FLAT + "&step s_N = 0.1, increments = 7 /\n"
    result = run(completes + "&expect end = 'lost' /\n", code=2)
    assert "loss of equilibrium was expected" in result.messages and len(result.rows) == 7
    result = run(completes + "&expect t_N = 1.0, damage = 0.5, tolerance = 0.01 /\n", code=2)
    for fragment in ("t_N = 1.66", "damage = 0.88", "line 4"):
        assert fragment in result.messages
    run(completes + "&expect t_N = 1.6667, tolerance = 0.001 /\n")


def test_commands(driver: Path, tmp_path: Path) -> None:
    """--help and --version; a wrong command line is exit 1."""

    version = re.search(r'version = "(.*)"', (ROOT / "src" / "law" / "asperity_contract.f90").read_text())
    assert version is not None
    assert call(driver, "--version", folder=tmp_path).stdout == f"rie_driver {version[1]}\n"
    assert "usage: rie_driver CASE.nml" in call(driver, "--help", folder=tmp_path).stdout
    for arguments in ([], ["a.nml", "b.nml"], ["--no-such"], ["a.nml", "-o"], [""], ["a.nml", "-o", ""]):
        process = call(driver, *arguments, folder=tmp_path)
        assert process.returncode == 1 and "--help" in process.stderr, arguments


def test_example_of_the_help(run, driver: Path, tmp_path: Path) -> None:
    """The example that --help prints runs."""
    text = call(driver, "--help", folder=tmp_path).stdout
    example = text[text.index("example:") : text.index("rows:")].partition("\n")[2]
    result = run(example)
    assert result["t_N"][-1] == pytest.approx(-5.0, abs=TRACTION_TOLERANCE)
    assert math.hypot(result["s_Tx"][-1], result["s_Ty"][-1]) == pytest.approx(0.6, rel=1e-14)


def test_warnings(run) -> None:
    """Different mode II values and a contact as soft as the bond give a warning."""
    path = RP_4 + "&step t_N = -10.0 /\n"
    assert "warning: the contact is soft" in run(MATERIAL + path).messages
    stiff = MATERIAL.replace("/", ", kc = 1000.0 /")
    assert "warning" not in run(stiff + path).messages
    assert "warning" not in run(MATERIAL + path.replace("-10.0", "-0.1")).messages
    assert "warning" not in run(MATERIAL + FLAT + "&step t_N = -10.0 /\n").messages
    # closure/s_f = |sigma_N| (1-eta)/(gamma sigma0) with gamma = 1/6
    assert "close by 2 s_f" in run(MATERIAL + path).messages
    # s_f = 0.2, so that the closure is 0.4/kc
    high = MATERIAL.replace("/", ", kc = 40.0, height = {} /")
    assert "warning" not in run(high.format(0.21) + path).messages
    assert "close by 0.2 height" in run(high.replace("40", "10").format(0.2) + path).messages
    assert (
        "warning: s_f is 2 height: expected" in run(high.format(0.1) + RP_4 + "&step t_N = -0.1 /\n").messages
    )
    assert "warning" not in run(high.format(0.1) + FLAT + "&step t_N = -0.1 /\n").messages
    # mu |sigma_N|/gamma = 30, Kt = 150: 3/W0
    wears = MATERIAL.replace("/", ", kc = 1000.0, W0 = {} /")
    assert "warning" not in run(wears.format(301.0) + path).messages
    assert "stores 0.02 W0" in run(wears.format(150.0) + path).messages
    for other in ("sigma02 = 4.0", "Gc2 = 0.5"):
        text = MATERIAL.replace("/", f", {other} /") + FLAT + "&step s_N = 0.1 /\n"
        assert "warning: sigma02 or Gc2 differ" in run(text).messages
    text = MATERIAL.replace("/", ", sigma02 = 3.0, Gc2 = 0.0 /") + FLAT + "&step s_N = 0.1 /\n"
    assert "warning" not in run(text).messages


# --- case files ---------------------------------------------------------------------------------------------

PLAIN = (
    MATERIAL + RP_4 + "&step t_N = -5.0, increments = 10 /\n"
    "&step s_Tx = 0.1, 0.0, 0.0, 0.0, increments = 9 /\n"
)


@pytest.mark.parametrize(
    "text",
    [
        PLAIN.replace("\n", "\r\n"),
        PLAIN.rstrip("\n"),
        "! before\n\n" + PLAIN.replace(" /\n", " / ! after\n") + "! behind /\n",
        PLAIN.upper(),
        PLAIN.replace(", ", "\n\t"),
        PLAIN.replace(", ", " ! a comment, with 'quotes' and / in it\n"),
        PLAIN.replace("0.0, 0.0, 0.0", "3*0.0").replace(" = ", "="),
        PLAIN.replace("0.1", "1d-1").replace("9.", "+.9D+1"),
        "\ufeff" + PLAIN + "! Umlaute: äöü /\n",
        "&case title = 'it''s / not ! the \"end\"' /" + PLAIN.replace("\n", ""),
    ],
    ids="crlf no-newline comments case tabs inner-comments repeats exponents bom one-line".split(),
)
def test_ways_to_write_a_case(run, text: str) -> None:
    """Line ends, comments, blanks, case, repeat counts and exponents change nothing."""
    assert run(text).rows == run(PLAIN).rows


END = "increments = 9 /"
PATTERN = "sides = 4, theta = 30.0"


@pytest.mark.parametrize(
    ("old", "new", "line", "fragments"),
    [
        ("sigma0 = 3.0", "sigma0 = -3.0", 1, ["&material: sigma0 = -3.0", "expected > 0"]),
        ("sigma0 = 3.0, ", "", 1, ["&material: sigma0 is missing", "expected > 0"]),
        ("sigma0", "sigma_0", 1, ["sigma_0 = 3.0: unknown name, expected one of sigma0, Gc, eta, mu"]),
        ("eta = 0.9", "eta = 1.0", 1, ["eta = 1.0", "0 < eta < 1"]),
        ("eta = 0.9", "eta = nan", 1, ['eta = "nan": expected a number']),
        ("eta = 0.9", "eta = inf", 1, ['eta = "inf": expected a number']),
        ("eta = 0.9", "eta = 1e999", 1, ['eta = "1e999": expected a number']),
        ("eta = 0.9", "eta = 0.9.1", 1, ['eta = "0.9.1": expected a number']),
        ("eta = 0.9", "eta = '0.9'", 1, ["eta", "expected a number"]),
        ("eta = 0.9", "eta = 0.9, 0.8", 1, ["eta = 0.9, 0.8: expected one number"]),
        ("eta = 0.9", "eta =", 1, ["&material: eta: empty value before a comma"]),
        ("mu = 0.5", "mu =", 1, ["mu = : no value"]),
        ("eta = 0.9", "eta = ,", 1, ["&material: eta: empty value"]),
        ("eta = 0.9", "eta = 0.9, eta = 0.9", 1, ["eta is given twice, first in line 1"]),
        ("eta = 0.9", "eta(1) = 0.9", 1, ["eta(1): subscripts are not read"]),
        ("mu = 0.5", "mu = 0.5, tau_v = -1.0", 1, ["tau_v = -1.0", ">= 0"]),
        ("mu = 0.5", "mu = 0.5, kc = -1", 1, ["kc = -1", ">= 0"]),
        ("sides = 4", "sides = 1", 2, ["sides = 1", "expected 0 (flat) or 2 to 64"]),
        ("sides = 4", "sides = 2.5", 2, ["sides = 2.5", "whole number from 0 to 64"]),
        ("sides = 4", "sides = -3", 2, ["sides = -3", "whole number from 0 to 64"]),
        ("sides = 4, ", "", 2, ["&pattern: expected sides (0: flat), or normals and weights"]),
        ("theta = 30.0", "theta = 90.0", 2, ["theta = 90.0", "0 <= theta < 90"]),
        ("theta = 30.0", "flat = 1.5", 2, ["flat = 1.5", "0 <= flat <= 1"]),
        ("sides = 4", "normals = 1, 0, 0, weights = 1", 2, ["do not go with normals"]),
        (PATTERN, "normals = 1, 0, 0, 1, weights = 1", 2, ["4 values of normals and 1 weights"]),
        (PATTERN, "normals = 0, 1, 0, weights = 1", 2, ["n_N of listed plane 1 = 0: expected > 0"]),
        (PATTERN, "normals = 1, 0, 0, weights = .5", 2, ["sum to 0.5: expected 1"]),
        ("&pattern", "&patern", 2, ["&patern: unknown group: expected &case, &material, &pattern"]),
        ("&pattern", "pattern", 2, ["outside a group"]),
        ("30.0 /", "30.0", 2, ["&pattern: no closing / before &step in line 3"]),
        ("&step t_N", "&step s_N = 0.1, t_N", 3, ["s_N and t_N: expected the one or the other"]),
        ("&step t_N", "&step k_N = -1, t_N", 3, ["k_N = -1: expected >= 0"]),
        ("&step t_N", "&step k_Tx = 1, t_N", 3, ["k_Tx where the separation is given: expected t_Tx"]),
        ("&step t_N", "&step slip = 0.1, s_Ty = 0, t_N", 3, ["slip sets s_Tx and s_Ty"]),
        ("&step t_N", "&step direction = 45, t_N", 3, ["direction without slip"]),
        ("&step t_N", "&step time = -1, t_N", 3, ["time = -1: expected >= 0"]),
        ("increments = 10", "increments = 0", 3, ["increments = 0: expected a whole number from 1"]),
        ("increments = 10", "increments = 10, 20", 3, ["2 values of increments: expected 1 to 1"]),
        ("increments = 10", "increments = 10.5", 3, ["increments = 10.5: expected a whole number"]),
        ("increments = 10", "cycles = 0", 3, ["cycles = 0"]),
        ("increments = 10", "cycles = 1000001", 3, ["cycles = 1000001"]),
        ("s_Tx = 0.1", "s_Tx = 1e60", 4, ["s_Tx = ", "expected a magnitude up to"]),
        ("s_Tx = 0.1", "s_Tx = what", 4, ['s_Tx = "what": expected a number']),
        (END, END + "\n&step /\n&expect end = 'x' /", 6, ["'x': expected 'complete' or 'lost'"]),
        (END, END + "\n&expect t_N = 1 /", 5, ["tolerance"]),
        (END, END + "\n&expect when = 1 /", 5, ["when = 1: expected a value of &sweep"]),
        (END, END + "\n&expect s_n = 1, tol = 1 /", 5, ["tol = 1: unknown name"]),
        (END, END + "\n&sweep name = 'x', values = 1, 2, 1 /", 5, ["1 is given twice"]),
        (END, END + "\n&sweep name = '1', values = 1 /", 5, ["expected a name of letters"]),
        (END, END + "\n&sweep values = 1 /", 5, ["expected name and values"]),
        (END, END + "\n&material /", 5, ["given twice, first in line 1"]),
        (END, END + "\n&case planes = 3 /", 5, ["planes = 3: expected .true. or .false."]),
        (END, END + "\n&case title = x /", 5, ["expected one string in quotes"]),
        (END, END + "\n&case title = 'x /", 5, ["string without its closing '"]),
    ],
)  # fmt: skip
def test_bad_case(run, tmp_path: Path, old: str, new: str, line: int, fragments: list[str]) -> None:
    """A bad case gives exit code 1 and no output file.

    The message has file, line, group, name, value and the expected value.
    """
    assert old in PLAIN
    messages = run(PLAIN.replace(old, new, 1), code=1).messages
    assert f"case.nml:{line}: " in messages
    for fragment in fragments:
        assert fragment in messages, messages
    assert not (tmp_path / "case.csv").exists()


def test_all_bad_values_at_once(run) -> None:
    """All errors of a file are reported at once."""
    messages = run(
        "&material sigma0 = -1, Gc = 0, eta = 2, mu = -0.1, sigma02 = -1, Gc2 = -1, tau_v = -1, kc = -1 /\n"
        "&pattern sides = 65, theta = -1, flat = 2 /\n&step t_N = x /\n",
        code=1,
    ).messages
    for name in "sigma0 Gc eta mu sigma02 Gc2 tau_v kc sides theta flat t_N".split():
        assert re.search(rf": {name} = .*: expected", messages), name


def test_separations_are_checked_once(run) -> None:
    """One line per bad value, not per cycle; of very many the first ones and their number."""
    step = "&step s_N = 1e60, 0, increments = 1, cycles = 20000 /\n"
    messages = run(MATERIAL + FLAT + step, code=1).messages
    assert messages.count("\n") == messages.count("expected a magnitude up to") == 1
    values = ", ".join(f"{i}e60" for i in range(1, 101))
    lines = run(MATERIAL + FLAT + f"&step s_N = {values}, increments = 1 /\n", code=1).messages.splitlines()
    assert len(lines) == 21 and "s_N = 1e60: expected" in lines[0] and "and 80 more" in lines[-1]


def test_missing_parts(run) -> None:
    """A case needs material, pattern, and steps or a replay."""
    lines = PLAIN.splitlines(keepends=True)
    assert "no group &material" in run("".join(lines[1:]), code=1).messages
    assert "no group &pattern" in run(lines[0] + "".join(lines[2:]), code=1).messages
    assert "0 groups &step and 0 &replay" in run("".join(lines[:2]), code=1).messages
    assert "2 groups &step and 1 &replay" in run(PLAIN + "&replay file = 'x' /\n", code=1).messages


@pytest.mark.parametrize(
    "content", [b"", b"\x00\x01\x02", b"\x7fELF" + bytes(range(256)), PLAIN.encode() + b"\x00"]
)
def test_no_text(run, content: bytes) -> None:
    """Empty and binary files are input errors."""
    messages = run(content, code=1).messages
    assert "case.nml" in messages and "expected a" in messages


def test_no_file(driver: Path, tmp_path: Path) -> None:
    """A missing file and a directory are input errors."""
    for name in ("none.nml", "."):
        process = call(driver, name, folder=tmp_path)
        assert process.returncode == 1 and name in process.stderr


def test_truncated_case(run) -> None:
    """A case file that is truncated anywhere is rejected, or is a shorter case of complete groups."""
    for cut in range(1, len(PLAIN), 7):
        groups = PLAIN[:cut].count("/")
        whole = groups >= 3 and PLAIN[:cut].count("&") == groups
        run(PLAIN[:cut], code=0 if whole else 1)


def test_mangled_cases(driver: Path, tmp_path: Path) -> None:
    """Random damage (seeded): exit 0, 1 or 2, a message with every 1 and 2, whole rows, no crash."""
    rng = random.Random(5)
    base = PLAIN + (
        "&expect end = 'complete', t_N = -5.0, tolerance = 1e-6 /\n&sweep name = 'x', values = 1.0, 2.0 /\n"
    )
    pieces = ["", "=", "/", "&", ",", "'", "1", "-", "*", "\n", "é", "x", "."]
    codes = set()
    for _ in range(150):
        text = list(base)
        for _ in range(rng.randint(1, 6)):
            i = rng.randrange(len(text))
            text[i : i + rng.randint(0, 3)] = rng.choice(pieces)
        (tmp_path / "m.nml").write_text("".join(text))
        process = call(driver, "m.nml", "--quiet", folder=tmp_path)
        assert process.returncode in (0, 1, 2), "".join(text)
        assert process.returncode == 0 or process.stderr.startswith("rie_driver: "), "".join(text)
        codes.add(process.returncode)
        for path in tmp_path.glob("m*.csv"):
            read_csv(path.read_text())
            path.unlink()
    assert {0, 1} <= codes


# --- initial states -----------------------------------------------------------------------------------------

# sub-increments of the load path to an initial traction, as in docs/solver.md
PARTS = 32


def test_dead_joint_at_rest(run) -> None:
    """A cracked flat joint, pressed and sheared below friction, is in equilibrium, sticks, slides at mu p."""
    p, tau = 10.0, 4.0
    result = run(
        MATERIAL + FLAT + f"&initial traction = {-p}, {tau}, 0, damage = 1 /\n&step increments = 3 /\n"
        f"&step t_N = {-p}, increments = 1 /\n&step slip = 0.021, increments = 60 /\n"
    )
    assert (result.vector("s")[:3] == 0.0).all()
    np.testing.assert_allclose(result.vector("t")[:3], [[-p, tau, 0.0]] * 3, rtol=0, atol=1e-10)
    np.testing.assert_allclose(result["stored"][0], (p**2 + tau**2) / (2 * K), rtol=1e-12)
    np.testing.assert_allclose(result["work"][0], result["stored"][0], rtol=1e-12)
    assert (result["damage"] == 1.0).all()
    s = result["s_Tx"]
    assert_traction(result["t_Tx"], np.minimum(tau + K * s, MU * p))
    slides = tau + K * s > MU * p
    np.testing.assert_allclose(result["friction"], MU * p * np.maximum(s - (MU * p - tau) / K, 0), atol=1e-13)
    assert [i for i, event in enumerate(result.events) if event] == [np.argmax(slides)]
    assert result.events[np.argmax(slides)] == {"slip"}


def carried_by_reference(pattern, traction: np.ndarray, damage: np.ndarray, s: np.ndarray, slips: np.ndarray):
    """Offset and state at which the independent law carries a traction: in proportion, by Newton's method."""
    law = reference.Parameters(SIGMA0, GC, ETA, MU)
    state = reference.virgin(pattern)
    state[reference.HEADER :] = np.column_stack([damage, slips]).ravel()
    state = reference.update(law, pattern, s, state, s).state
    first = reference.update(law, pattern, s, state, s).traction
    for part in np.linspace(0.0, 1.0, PARTS + 1)[1:]:
        goal = first + part * (traction - first)
        s_new = s
        for _ in range(20):
            response = reference.update(law, pattern, s_new, state, s)
            if np.abs(goal - response.traction).max() < 1e-13 * K:
                break
            s_new = s_new + np.linalg.solve(response.tangent, goal - response.traction)
        s, state = s_new, response.state
    assert np.abs(response.traction - traction).max() < TRACTION_TOLERANCE
    return law, s, state


@pytest.mark.parametrize("s", [[0.0, 0.0, 0.0], [0.0, 0.03, -0.01]])
def test_initial_state_is_the_reference(run, s: list[float]) -> None:
    """With the offset added the independent law has the tractions and energies of the rows."""
    pattern = reference.regular_pattern(4, 30.0)
    traction, damage = np.array([-5.0, 1.0, 0.5]), np.array([0.5, 0.25, 0.0, 0.75, 1.0])
    # The slips are compatible with one separation, at which the load path to the traction starts.
    slips = reference.frames(pattern[0])[:, 1:] @ s
    law, offset, state = carried_by_reference(pattern, traction, damage, np.array(s), slips)
    slip = ", ".join(repr(x) for x in slips.ravel().tolist())
    result = run(
        MATERIAL + RP_4 + f"&initial traction = -5, 1, 0.5, damage = 0.5, 0.25, 0, 0.75, 1, slip = {slip} /\n"
        "&step increments = 1 /\n&step s_N = 0.01, -0.02, s_Tx = 0.2, s_Ty = 0.1, -0.1, increments = 40 /\n"
        "&step t_N = -5, increments = 20 /\n"
    )
    s_old, t_old, work = offset, traction, state[1:4].sum()  # energies at the start
    for row, separation in enumerate(result.vector("s")):
        s_new = separation + offset
        response = reference.update(law, pattern, s_new, state, s_old)
        work += 0.5 * (t_old + response.traction) @ (s_new - s_old)
        s_old, t_old, state = s_new, response.traction, response.state
        assert_traction(result.vector("t")[row], response.traction)
        energies = [result[name][row] for name in ("damage", "stored", "rupture", "friction", "work")]
        np.testing.assert_allclose(energies, [*state[:4], work], rtol=1e-9, atol=1e-12)


LISTED = "&pattern normals = 1, 0, 0, 0.9, 0.3, 0.1, 0.8, -0.2, 0.3, weights = 0.4, 0.3, 0.3 /\n"
VISCOUS, GUARDED = ", tau_v = 0.5 /", ", guard = .true. /"


@pytest.mark.parametrize(
    ("extra", "pattern", "damage", "steps"),
    [
        ("", RP_4, "0.3", "&step t_N = -4, increments = 1 /\n&step {s_Tx}, {s_Ty}, increments = 60 /\n"),
        ("", RP_4, "0.9", "&step k_N = 20.0, t_N = -4, {s_Tx}, {s_Ty}, increments = 60 /\n"),
        ("", LISTED, "0", "&step t_N = -4, {s_Tx}, t_Ty = 0.0, increments = 60 /\n"),
        ("", LISTED, "1", "&step t_N = -1, t_Tx = 0, t_Ty = 0, increments = 60 /\n"),
        ("", RP_4, "1", "&step t_N = 0.0, {s_Tx}, {s_Ty}, increments = 40 /\n"),
        (VISCOUS, RP_4, "0.3", "&step t_N = -4, {s_Tx}, {s_Ty}, increments = 60, time = 2.0 /\n"),
        (GUARDED, RP_4, "0.3", "&step t_N = -4, {s_Tx}, {s_Ty}, increments = 60 /\n"),
        ("", RP_4, "0.3", "&step t_N = -4, {s_Tx}, {s_Ty}, tolerance = 1e-4 /\n"),
        (VISCOUS, RP_4, "0.3", "&step t_N = -4, {s_Tx}, {s_Ty}, tolerance = 1e-2, time = 2.0 /\n"),
    ],
)
def test_initial_state_is_a_preload(run, extra: str, pattern: str, damage: str, steps: str) -> None:
    """Every kind of path goes on as from a run that applied the traction, shifted by its separation."""
    head = MATERIAL.replace(" /", extra or " /") + pattern
    planes = 5 if pattern == RP_4 else 3
    traction = {"t_N": -4.0, "t_Tx": 0.8, "t_Ty": -0.4}

    def path(s: list[float]) -> str:
        targets = [f"s_Tx = {s[1] + 0.05!r}, {s[1] - 0.1!r}", f"s_Ty = {s[2] + 0.1!r}, {s[2] + 0.02!r}"]
        return steps.format(s_Tx=targets[0], s_Ty=targets[1])

    state = f"&state separation = 3*0, statev = 8*0{f', {damage}, 0, 0' * planes} /\n"
    # The preload is so slow that viscous damage is in equilibrium, to 1e-9 of its growth.
    preload = f"{', '.join(f'{name} = {value}' for name, value in traction.items())}, time = 1e9"
    before = head + state + f"&step {preload}, increments = {PARTS} /\n"
    offset = run(before, "--planes").vector("s")[-1]
    loaded = run(before + path(offset.tolist()), "--planes")
    values = ", ".join(str(value) for value in traction.values())
    initial = run(
        head + f"&initial traction = {values}, damage = {damage} /\n" + path([0.0, 0.0, 0.0]), "--planes"
    )
    if "tolerance" in steps:
        # The step sizes depend on the separation; one run starts at separation zero, the other at its offset.
        rows, tolerance = slice(-1, None), float(re.search(r"tolerance = ([^ ,]+)", steps)[1])
    else:
        assert len(initial.rows) == len(loaded.rows) - PARTS
        # The state does not record that a plane slides. Sliding may be due to rounding, as may the contact of
        # fully damaged planes.
        ignored = {"slip", "open", "close"} if damage == "1" else {"slip"}
        events = [[event - ignored for event in result.events] for result in (initial, loaded)]
        assert events[0] == events[1][PARTS:]
        rows, tolerance = slice(None), 1e-9
    first = slice(PARTS, None) if "tolerance" not in steps else rows
    size = np.abs(loaded.vector("t")).max()
    np.testing.assert_allclose(
        initial.vector("t")[rows], loaded.vector("t")[first], rtol=0, atol=tolerance * size
    )
    np.testing.assert_allclose(
        initial.vector("s")[rows], loaded.vector("s")[first] - offset, rtol=0, atol=tolerance * S_F
    )
    for name in ("damage", "stored", "rupture", "friction", "work", "alpha_1", "s_dit_2", "s_dih_3"):
        scale = max(np.abs(loaded[name]).max(), GC)
        np.testing.assert_allclose(
            initial[name][rows], loaded[name][first], rtol=0, atol=tolerance * scale, err_msg=name
        )


def test_contact_is_told_by_the_planes(run) -> None:
    """A pressed crack opens at the separation that cancels its offset, where the traction is zero."""
    head = MATERIAL + FLAT + "&initial traction = -10, 0, 0, damage = 1 /\n"
    closure = 10.0 / K
    opens = run(head + "&step s_N = 0.1, increments = 40 /\n")
    (row,) = [i for i, event in enumerate(opens.events) if event]
    assert opens.events[row] == {"open"} and opens["s_N"][row - 1] < closure < opens["s_N"][row]
    adaptive = run(head + "&step s_N = 0.1, tolerance = 1e-4 /\n")
    kink = np.interp(closure, adaptive["s_N"], adaptive["t_N"])
    assert abs(kink) < 1e-3  # the opening has its row
    free = run(head + "&step t_N = 0.0, increments = 10 /\n")
    np.testing.assert_allclose(free["s_N"], closure * np.arange(1, 11) / 10, rtol=1e-12)
    assert abs(free["t_N"][-1]) < 1e-12


def test_far_slipped_joint(run) -> None:
    """A run continues from a crack with a slip of 5000 s_f; the rounding error scales with this slip."""
    p, tau, slip = 10.0, 4.0, 1000.0
    result = run(
        MATERIAL + FLAT + f"&initial traction = {-p}, {tau}, 0, damage = 1, slip = {slip}, 0 /\n"
        f"&step t_N = {-p}, t_Tx = {tau + 0.5}, increments = 10 /\n&step slip = 0.02, increments = 10 /\n"
    )
    # The solver accepts 1e-13 K s; the tolerance is ten times that.
    tolerance = 1e-12 * K * slip
    np.testing.assert_allclose(result["t_Tx"][:10], tau + 0.05 * np.arange(1, 11), rtol=0, atol=tolerance)
    np.testing.assert_allclose(result["s_Tx"][:10], 0.05 * np.arange(1, 11) / K, rtol=0, atol=tolerance / K)
    np.testing.assert_allclose(result["t_Tx"][15:], MU * p, rtol=0, atol=tolerance)


def test_cracked_without_traction(run) -> None:
    """With `damage` alone a run starts as from &state at separation zero, without the event onset."""
    path = "&step t_N = -1, increments = 5 /\n&step slip = 0.3, increments = 30 /\n"
    damage = [1.0, 0.2, 0.4, 0.6, 0.8]
    cracked = run(MATERIAL + RP_4 + f"&initial damage = {str(damage)[1:-1]} /\n" + path, "--planes")
    planes = ", ".join(f"{alpha}, 0, 0" for alpha in damage)
    state = run(MATERIAL + RP_4 + f"&state separation = 3*0, statev = 8*0, {planes} /\n" + path, "--planes")
    assert cracked.rows == state.rows
    assert not any("onset" in event for event in cracked.events)
    swept = run(
        MATERIAL + RP_4 + "&initial damage = x /\n&sweep name = 'x', values = 0.0, 1.0 /\n" + path, "--planes"
    )
    assert "case_0.csv" in swept.messages and "case_1.csv" in swept.messages


@pytest.mark.parametrize(
    ("start", "steps"),
    [
        ("traction = 2, 0, 0", "&step t_N = 2.0, increments = 1 /\n&step slip = 0.1, increments = 100 /\n"),
        ("traction = -5, 1, 0, damage = 0.5", "&step t_N = -5.0, t_Tx = 25.0 /\n"),
    ],
)
def test_failed_increment_from_an_initial_state(
    run, driver: Path, tmp_path: Path, start: str, steps: str
) -> None:
    """The file of the failed increment has the offset in its &state, and fails as the run did."""
    result = run(MATERIAL + RP_4 + f"&initial {start} /\n" + steps, code=2)
    assert "lost" in result.events[-1]
    text = (tmp_path / "case.failed.nml").read_text()
    statev = np.array(re.search(r"statev =([^/a-z]*(?:e[^/a-z]*)*) work", text)[1].split(","), dtype=float)
    assert (statev[5:8] != 0.0).any()
    process = call(driver, "case.failed.nml", "-o", "again.csv", folder=tmp_path)
    again = Result(process, tmp_path / "again.csv")
    assert process.returncode == 2 and len(again.rows) == 1 and "lost" in again.events[0]
    reason = re.search(r"lost: no solution found beyond [^:]*: (.*)", result.messages)[1]
    assert reason.split(" held")[0][:60] in process.stderr
    for name in ("s", "t"):
        np.testing.assert_allclose(again.vector(name)[0], result.vector(name)[-1], rtol=1e-6, atol=1e-6)
    for name in ("damage", "stored", "rupture", "friction", "work"):
        assert again[name][0] == pytest.approx(result[name][-1], rel=1e-6, abs=1e-9)


@pytest.mark.parametrize(
    ("pattern", "initial", "fragments"),
    [
        (FLAT, "traction = 1, 0", ["traction = 1, 0: 2 values: expected three (t_N, t_Tx, t_Ty)"]),
        (FLAT, "traction = 1, nan, 0", ['traction = "nan": expected a number']),
        (FLAT, "traction = 1, 1e999, 0", ['traction = "1e999": expected a number']),
        (FLAT, "damage = 1.5", ["damage = 1.5: expected 0 to 1"]),
        (FLAT, "damage = -0.1", ["damage = -0.1: expected 0 to 1"]),
        (FLAT, "damage = nan", ['damage = "nan": expected a number']),
        (FLAT, "damage = 2*0.5", ["damage = 2*0.5: 2 values: expected 1 for all planes"]),
        (RP_4, "damage = 6*0.5", ["6 values: expected 1 for all planes or 5 for 5 planes"]),
        (FLAT, "slip = 0.1", ["slip = 0.1: 1 values: expected 2 for all planes, in pairs s_dit, s_dih"]),
        (RP_4, "slip = 9*0.1", ["9 values: expected 2 for all planes or 10 for 5 planes, in pairs"]),
        (FLAT, "slip = 0, 1e99", ["slip = 0, 1e99: expected a magnitude up to"]),
        (FLAT, "opening = 1", ["opening = 1: unknown name, expected one of traction, damage, slip"]),
        (FLAT, "", ["nothing given: expected traction, damage or slip"]),
        (FLAT, "damage = 1 /\n&initial damage = 1", ["&initial: given twice, first in line 3"]),
        (
            FLAT,
            "traction = 0.1, 0, 0, damage = 1",
            ["traction = 0.1, 0, 0: initial t_N = 0.1: tension on a crack", "it carries t_N = 0"],
        ),
        (
            FLAT,
            "traction = -10, 7.5, 0, damage = 1",
            ["traction = -10, 7.5, 0: initial t_Tx, t_Ty = 7.5, 0: outside the friction of the pattern"],
        ),
        (FLAT, "traction = 3.1, 0, 0", ["traction = 3.1, 0, 0: initial t_N = 3.1: beyond the strength"]),
        (RP_4, "traction = -1, 10, 1", ["&initial: traction = -1, 10, 1: "]),
        (RP_4, "traction = 1e299, 0, 0", ["&initial: traction = 1e299, 0, 0: initial t_N = 1e299: "]),
        (
            FLAT,
            "damage = 1 /\n&state separation = 3*0, statev = 11*0",
            ["a run starts from &initial or from &state, in line 4: expected the one or the other"],
        ),
    ],
)
def test_bad_initial_state(run, tmp_path: Path, pattern: str, initial: str, fragments: list[str]) -> None:
    """Exit 1 with file, line, group, name and value; what the planes cannot carry says what they do carry."""
    messages = run(MATERIAL + pattern + f"&initial {initial} /\n&step s_N = 0.1 /\n", code=1).messages
    assert "case.nml:3: &initial: " in messages or "case.nml:4: &initial: " in messages
    for fragment in fragments:
        assert fragment in messages, messages
    assert not (tmp_path / "case.csv").exists()


# --- replay -------------------------------------------------------------------------------------------------

CYCLE = (
    "&step t_N = -5.0, increments = 20 /\n&step slip = 0.3, -0.2, 0.1, direction = 20.0, increments = 40 /\n"
)


@pytest.mark.parametrize(
    ("options", "pattern"),
    [
        ("", RP_4),
        ("h = 0.01", RP_4),
        ("ntens = 6, h = 0.5", RP_4),
        ("ntens = 6, map = 1", RP_4),
        ("ntens = 6, r = 0.1", RP_4),
        ("ntens = 2", "&pattern sides = 2, theta = 30.0 /\n"),
    ],
)
def test_replay_is_the_direct_run(run, tmp_path: Path, options: str, pattern: str) -> None:
    """The separations of a direct run through umat, with trial calls in every increment, give its rows."""
    path = CYCLE.replace("20.0", "0.0") if "ntens = 2" in options else CYCLE
    direct = run(MATERIAL + pattern + path, "--planes")
    (tmp_path / "case.csv").rename(tmp_path / "record.csv")
    replay = run(MATERIAL + pattern + f"&replay file = 'record.csv', {options} /\n", "--planes")
    assert replay.header == direct.header and len(replay.rows) == len(direct.rows)
    assert [row[1] for row in replay.rows] == [str(i) for i in range(1, len(direct.rows) + 1)]
    for name in direct.header:
        if name in ("step", "increment", "iterations", "event"):
            continue
        # strain = separation/h and the sum of the increments round: some units in the last place of K |s|
        np.testing.assert_allclose(replay[name], direct[name], rtol=1e-12, atol=1e-12 * K, err_msg=name)
    assert replay.events == direct.events
    assert set(replay["iterations"]) == {4.0}


@pytest.mark.parametrize("block", [1, 7, 64, 65, 136, 1000])
@pytest.mark.parametrize(
    ("options", "pattern"),
    [
        ("", RP_4),
        ("h = 0.01", RP_4),
        ("h = 0.5, map = 1, r = 0.1", RP_4),
        ("ntens = 2", "&pattern sides = 2, theta = 30.0 /\n"),
    ],
)
def test_blocks_of_vumat_are_umat(run, tmp_path: Path, options: str, pattern: str, block: int) -> None:
    """A record through vumat, in blocks of points that follow each other, gives the rows of umat."""
    path = CYCLE.replace("20.0", "0.0") if "ntens = 2" in options else CYCLE
    direct = run(MATERIAL + pattern + path)
    (tmp_path / "case.csv").rename(tmp_path / "record.csv")
    umat = run(MATERIAL + pattern + f"&replay file = 'record.csv', {options} /\n", "--planes")
    through = f"&replay file = 'record.csv', through = 'vumat', block = {block}, {options} /\n"
    vumat = run(MATERIAL + pattern + through, "--planes")
    assert vumat.header == umat.header and len(vumat.rows) == len(umat.rows) == len(direct.rows)
    for name in umat.header:
        if name in ("iterations", "event"):
            continue
        # sums of increments and totals: an ulp of K |s| an increment
        np.testing.assert_allclose(vumat[name], umat[name], rtol=1e-12, atol=1e-12 * K, err_msg=name)
    assert vumat.events == umat.events
    assert set(vumat["iterations"]) == {1.0}
    assert vumat["friction"][-1] > 0.0 and vumat["damage"][-1] > 0.5


@pytest.mark.parametrize(
    ("options", "extra"),
    [
        ("", ""),
        ("h = 0.01", ""),
        ("ntens = 6, map = 1, r = 0.1", ""),
        ("ntens = 2", ""),
        ("through = 'vumat'", ""),
        ("through = 'vumat', block = 65, h = 0.01", ", tau_v = 0.5"),
        ("through = 'vumat', ntens = 2", ""),
    ],
)
@pytest.mark.parametrize(
    "initial",
    ["traction = -5, 1, 0.5, damage = 0.5, slip = 0.01, 0", "damage = 0.5", "traction = -5, 0.1, 0.0"],
)
def test_replay_of_an_initial_state(run, tmp_path: Path, options: str, extra: str, initial: str) -> None:
    """Initial planes in STATEV, the traction in STRESS: both routines start where the driver does."""
    plane = "ntens = 2" in options
    head = MATERIAL.replace(" /", extra + " /") + (
        RP_4 if not plane else "&pattern sides = 2, theta = 30.0 /\n"
    )
    start = f"&initial {initial.replace('0.5, damage', '0, damage') if plane else initial} /\n"
    path = "&step increments = 3 /\n" + (CYCLE.replace("20.0", "0.0") if plane else CYCLE)
    direct = run(head + start + path, "--planes")
    (tmp_path / "case.csv").rename(tmp_path / "record.csv")
    replay = run(head + start + f"&replay file = 'record.csv', {options} /\n", "--planes")
    assert len(replay.rows) == len(direct.rows)
    if "traction" in start:
        given = [float(x) for x in re.search("traction = ([^a-z]*)[,/]", start)[1].rstrip(", ").split(",")]
        np.testing.assert_allclose(replay.vector("t")[0], given, rtol=0, atol=1e-10)
    assert (replay.vector("s")[:3] == 0.0).all()
    for name in direct.header:
        if name in ("step", "increment", "iterations", "event"):
            continue
        # sums of increments and totals: an ulp of K |s| an increment
        np.testing.assert_allclose(replay[name], direct[name], rtol=1e-12, atol=1e-12 * K, err_msg=name)
    # the event slip may be due to a rounding error in equilibrium
    events = [[event - {"slip"} for event in result.events] for result in (replay, direct)]
    assert events[0] == events[1]


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("h", [1.0, 0.01])
def test_random_path_from_a_stress(run, tmp_path: Path, seed: int, h: float) -> None:
    """UMAT and VUMAT agree on random increments from a random stress, and are the independent law."""
    draw = np.random.default_rng(seed)
    pattern = reference.regular_pattern(4, 30.0)
    traction = np.array([-3.0, 0.6, 0.6]) + draw.uniform(-0.5, 0.5, 3)
    damage = draw.uniform(0.0, 0.8, 5)
    law, offset, state = carried_by_reference(pattern, traction, damage, np.zeros(3), np.zeros((5, 2)))
    steps = np.cumsum(draw.normal(scale=[0.003, 0.02, 0.02], size=(200, 3)), axis=0)
    steps[0] = 0.0
    record = "\n".join(",".join(repr(x) for x in row) for row in steps.tolist())
    (tmp_path / "record.csv").write_text("s_N,s_Tx,s_Ty\n" + record + "\n")
    numbers = [", ".join(repr(x) for x in values.tolist()) for values in (traction, damage)]
    start = f"&initial traction = {numbers[0]}, damage = {numbers[1]} /\n"
    umat, vumat = (
        run(
            MATERIAL + RP_4 + start + f"&replay file = 'record.csv', through = '{through}', h = {h} /\n",
            "--planes",
        )
        for through in ("umat", "vumat")
    )
    assert len(umat.rows) == len(vumat.rows) == len(steps)
    for name in umat.header:
        if name not in ("iterations", "event"):
            # sums of increments and totals: an ulp of K |s| an increment
            np.testing.assert_allclose(vumat[name], umat[name], rtol=1e-12, atol=1e-12 * K, err_msg=name)
    np.testing.assert_allclose(umat.vector("t")[0], traction, rtol=0, atol=1e-10 * SIGMA0)
    s_old, t_old, work = offset, np.asarray(traction), state[1:4].sum()
    for s, row in zip(steps, umat.vector("t"), strict=True):
        response = reference.update(law, pattern, s + offset, state, s_old)
        work += 0.5 * (t_old + response.traction) @ (s + offset - s_old)
        s_old, t_old, state = s + offset, response.traction, response.state
        assert_traction(row, response.traction)
    assert umat["damage"][-1] == pytest.approx(state[0], abs=1e-10)
    for name, energy in zip(("stored", "rupture", "friction", "work"), (*state[1:4], work), strict=True):
        assert umat[name][-1] == pytest.approx(energy, abs=1e-10 * GC), name


@pytest.mark.parametrize(
    ("initial", "options", "fragment"),
    [
        ("traction = -1, 0, 0.1", "ntens = 2,", "traction = -1, 0, 0.1: expected t_Ty = 0 with ntens = 2"),
        ("slip = 0.1, 0, damage = 1", "", "slip = 0.1, 0: expected a traction with it"),
        (
            "traction = 1, 0, 0, damage = 1",
            "through = 'vumat',",
            "traction = 1, 0, 0: initial t_N = 1: tension",
        ),
    ],
)
def test_bad_replay_of_an_initial_state(
    run, tmp_path: Path, initial: str, options: str, fragment: str
) -> None:
    """Initial states that the host routine rejects are input errors."""
    (tmp_path / "record.csv").write_text("s_N,s_Tx,s_Ty\n0,0,0\n")
    case = MATERIAL + FLAT + f"&initial {initial} /\n&replay {options} file = 'record.csv' /\n"
    assert f"case.nml:3: &initial: {fragment}" in run(case, code=1).messages


def test_vumat_strains(run, tmp_path: Path) -> None:
    """Strains for vumat: normal, 23 and 13, tensor shears; a sticking plane is elastic along each of them."""
    (tmp_path / "record.csv").write_text("e_1,e_2,e_3\n0,0.0002,-0.0001\n0,0.0003,0.0\n")
    rows = run(MATERIAL + FLAT + "&replay file = 'record.csv', through = 'vumat', h = 2.0 /\n")
    s = 2 * 2.0 * np.array([[0, -0.0001, 0.0002], [0, 0, 0.0003]])
    np.testing.assert_allclose(rows.vector("s"), s, rtol=0, atol=1e-17)
    np.testing.assert_allclose(rows.vector("t"), K * s, rtol=0, atol=1e-14 * K)


def test_replay_of_strains(run, tmp_path: Path) -> None:
    """Strains without a header, or with e_1.. and time in any order, other columns, blank lines, comments."""
    rows = [(0.001 * i, 0.002 * i, -0.0005 * i) for i in range(1, 60)]
    (tmp_path / "plain.csv").write_text("".join(f"{a}, {b},{c}\n" for a, b, c in rows))
    (tmp_path / "named.csv").write_text(
        "# a record\r\ne_3,note,time,e_1,E_2\r\n\r\n"
        + "\r\n".join(f"{c},x,{0.5 * i},{a},{b}" for i, (a, b, c) in enumerate(rows, 1))
    )
    plain = run(MATERIAL + RP_4 + "&replay file = 'plain.csv', h = 2.0, dtime = 0.5 /\n")
    named = run(MATERIAL + RP_4 + "&replay file = 'named.csv', h = 2.0 /\n")
    assert plain.rows == named.rows
    np.testing.assert_allclose(plain.vector("s"), 2 * np.array(rows), rtol=1e-14)
    np.testing.assert_allclose(plain["time"], 0.5 * np.arange(1, 60), rtol=1e-14)
    direct = run(MATERIAL + RP_4 + "&step s_N = 0.118, s_Tx = 0.236, s_Ty = -0.059, increments = 59 /\n")
    np.testing.assert_allclose(plain.vector("t"), direct.vector("t"), rtol=0, atol=1e-12 * K)


def test_replay_file_is_beside_the_case(driver: Path, tmp_path: Path) -> None:
    """A relative file name of a record is relative to the folder of the case."""
    (tmp_path / "a").mkdir()
    (tmp_path / "a" / "record.csv").write_text("0.01,0,0\n")
    (tmp_path / "a" / "r.nml").write_text(MATERIAL + FLAT + "&replay file = 'record.csv' /\n")
    subprocess.run([driver, "a/r.nml"], cwd=tmp_path, check=True, capture_output=True)
    _, rows = read_csv((tmp_path / "r.csv").read_text())
    assert float(rows[0][6]) == pytest.approx(0.01 * K, rel=1e-14)


@pytest.mark.parametrize(
    ("options", "record", "fragments"),
    [
        ("", None, ["record.csv", "cannot be opened"]),
        ("through = 'vumat', ntens = 6,", "0,0,0\n", ["case.nml:3: &replay: ntens = 6", "expected 2 or 3"]),
        ("through = 'vumat', block = 0,", "0,0,0\n", ["block = 0: expected a whole number from 1 to 1000"]),
        ("block = 4,", "0,0,0\n", ["case.nml:3: &replay: block without through = 'vumat'"]),
        ("through = 'hypela',", "0,0,0\n", ["through = 'hypela': expected 'umat' or 'vumat'"]),
        ("ntens = 4,", "0,0,0\n", ["ntens = 4: expected 2, 3 or 6"]),
        ("h = -1,", "0,0,0\n", ["h = -1: expected > 0"]),
        ("map = 2,", "0,0,0\n", ["map = 2: expected 0 or 1"]),
        ("r = 2,", "0,0,0\n", ["r = 2: expected 0 <= r <= 1"]),
        ("dtime = -1,", "0,0,0\n", ["dtime = -1: expected >= 0"]),
        ("", "0,0,0\n0,0\n", ["record.csv:2: column 3", "expected a number"]),
        ("", "0,0,0\n0,nan,0\n", ['record.csv:2: column 2 = "nan": expected a number']),
        ("", "0,0,0\n0,1e60,0\n", ["record.csv:2: expected strains of a magnitude up to"]),
        ("", "0,0,0\n0,0,0,0,0\n", ["record.csv:2: 5 columns: expected 3 (ntens)"]),
        ("ntens = 2,", "0,0,0\n", ["record.csv:1: 3 columns: expected 2 (ntens)"]),
        (
            "",
            "time,e_1,e_2,e_3\n1,0,0,0\n0.5,0,0,0\n",
            ["record.csv:3: time = 0.5: expected at least 1"],
        ),
        ("", "time,e_1,e_2,e_3\n-1,0,0,0\n", ["record.csv:2: time = -1: expected at least 0"]),
        (
            "",
            "0,0,0\nx,0,0\n0,1e60,0\n0,0\n",
            ['record.csv:2: column 1 = "x"', "record.csv:3: expected strains", "record.csv:4: column 3"],
        ),
        ("", "x,0,0\n1,0,y\n" + 49 * "0,0,y\n", ["record.csv:1: no column e_1"]),
        ("", "0,0,0\n" + 50 * "0,0,y\n", ["record.csv:21: column 3", "... and 30 more bad lines"]),
        ("", "s_N,s_Tx\n0,0\n", ["record.csv:1: no column s_ty"]),
        ("", "e_1,e_2\n0,0\n", ["record.csv:1: no column e_3"]),
        ("ntens = 2,", "s_N,s_Tx,s_Ty\n0,0,1\n", ["record.csv:2: s_Ty = 1: expected 0 with ntens = 2"]),
        ("", "s_N,s_Tx,s_Ty\n", ["no line of numbers"]),
        ("", "", ["record.csv", "expected a"]),
        ("", "0,0,0\n\x00", ["record.csv:2: byte 0: expected a text file"]),
        ("files = 'x',", "0,0,0\n", ["files = 'x': unknown name"]),
    ],
)
def test_bad_replay(run, tmp_path: Path, options: str, record: str | None, fragments: list[str]) -> None:
    """A bad replay gives exit code 1 and the line of the record or of the case."""
    if record is not None:
        (tmp_path / "record.csv").write_text(record)
    messages = run(MATERIAL + FLAT + f"&replay {options} file = 'record.csv' /\n", code=1).messages
    for fragment in fragments:
        assert fragment in messages, messages
    assert not (tmp_path / "case.csv").exists()
