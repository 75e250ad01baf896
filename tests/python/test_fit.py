"""Parameters from shear-box records: recovered within their intervals, doubts told, bad records refused."""

from __future__ import annotations

import builtins
import re
from pathlib import Path
from typing import Any

import asperity
import numpy as np
import pytest
from asperity import fit as fitting
from asperity import fit_model, reference
from asperity import fit_study as study
from asperity.card_command import read_interface
from asperity.case_files import slip_tests
from asperity.cli import main
from asperity.fit import fit, residual_ratio
from asperity.fit_records import ShearTest, read_records
from asperity.fit_report import case_text, identifiability, report

pytest.importorskip("scipy")

TRUTH = study.TRUTH
AT_TRUTH = {name: TRUTH[name] for name in fitting.DEFAULT_FREE}
HEADER = "slip,tau,dilation,sigma_N\n"
ROWS = "".join(f"{0.1 * i:.1f},{min(i, 4) * 0.2:.1f},{0.02 * i:.2f},-1\n" for i in range(1, 8))


def write(folder: Path, text: str, name: str = "record.csv") -> Path:
    """A file."""
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def three_percent() -> fitting.Fit:
    """Fit of a record with 3 % noise, from its own starts."""
    return fit(study.synthetic(0.03, 0), fixed=study.SET)


@pytest.fixture(scope="module")
def no_dilation() -> fitting.Fit:
    """The same without dilation."""
    return fit(study.synthetic(0.03, 0, dilation=False), fixed=study.SET, start=AT_TRUTH, starts=1)


# --- constant normal stiffness ------------------------------------------------------------------------------


@pytest.mark.filterwarnings("ignore::asperity.ModelWarning")
@pytest.mark.parametrize("sides", [0, 2, 5])
def test_normal_stiffness_against_reference(sides: int) -> None:
    """The reference law along the same separations carries sigma_N - k (s_N - s_N at the start)."""
    sigma_N, k, preload = -3.0, 4.0, 4
    material = {"sigma0": 3.0, "Gc": 0.3, "eta": 0.9, "mu": 0.5, "kc": 10.0}
    interface = asperity.Interface(asperity.Material(**material), asperity.Pattern.regular(sides, 25.0))
    slips = np.concatenate([[0.0], np.linspace(0, 0.3, 40)[1:], np.linspace(0.3, -0.1, 40)[1:]])
    path = interface.confined_slip(20.0, slips, sigma_N, preload, stiffness=k)
    before = [
        interface.confined_slip(20.0, [0.0], sigma_N * i / preload, i).separation[0]
        for i in range(1, preload + 1)
    ]
    law = reference.replay(
        reference.Parameters(**material),
        reference.regular_pattern(sides, 25.0),
        np.concatenate([before, path.separation]),
    )
    traction = law.traction[preload:]
    rise = path.separation[:, 0] - path.separation[0, 0]
    assert sides == 0 or np.ptp(rise) > 0.05
    # of the largest terms, as the solver promises
    assert np.allclose(traction[:, 0], sigma_N - k * rise, rtol=0.0, atol=1e-9)
    assert np.allclose(traction, path.traction, rtol=0.0, atol=1e-9)


@pytest.mark.filterwarnings("ignore::asperity.ModelWarning")
def test_normal_stiffness_refused() -> None:
    """Negative or no number; with adaptive increments."""
    flat = asperity.Interface(asperity.Material(3.0, 0.3, 0.9, 0.5), asperity.Pattern.regular(0, 0.0))
    for bad in (-1.0, np.nan, np.inf):
        with pytest.raises(ValueError, match=r"stiffness = .*: expected a finite stiffness >= 0"):
            flat.confined_slip(0.0, [0.1], -1.0, stiffness=bad)
    with pytest.raises(ValueError, match="stiffness = 2: expected 0 with a tolerance"):
        flat.confined_slip(0.0, [0.1], -1.0, tolerance=1e-3, stiffness=2.0)


# --- recovery -----------------------------------------------------------------------------------------------


@pytest.mark.filterwarnings("ignore::asperity.ModelWarning")
def test_record_of_the_reference_model() -> None:
    """A record computed by the independent reference, without noise, gives back what it was made with."""
    slips = np.linspace(0.0, 0.8, 401)[1:]
    parameters = reference.Parameters(**{name: TRUTH[name] for name in ("sigma0", "Gc", "eta", "mu", "kc")})
    pattern = reference.regular_pattern(study.SIDES, TRUTH["theta"], TRUTH["flat"])
    tests = []
    for sigma_N in (-1.0, -4.0):
        rows = reference.confined_slip(
            parameters, pattern, 0.0, np.concatenate([[0.0], slips]), sigma_N, preload_increments=50
        )
        s_N = rows.separation[1:, 0] - rows.separation[0, 0]
        tests.append(ShearTest("reference", slips, rows.traction[1:, 1], s_N, sigma_N))
    found = fit(tests, fixed=study.SET, start=AT_TRUTH | {"mu": 0.7, "theta": 10.0, "Gc": 0.4}, starts=1)
    for name, value in AT_TRUTH.items():
        # same increments and roots: the tolerances of the least squares are left
        assert found.values[name] == pytest.approx(value, rel=1e-6), name


@pytest.mark.parametrize("noise", study.NOISES)
def test_intervals_hold_at_their_rate(noise: float) -> None:
    """95 % intervals of every parameter and of the ratio: at most 4 of 16 miss (odds of 0.1 %)."""
    repetitions, most = 16, 4
    shares, fits = study.coverage(noise, repetitions, starts=1, start=AT_TRUTH)
    assert np.all(shares >= 1.0 - most / repetitions), shares
    # wide intervals would hold, too: the scatter is the noise (which widens the range it is told of), and
    # 50 % intervals of the same fits miss
    assert all(abs(np.log(one.scatter[0] / noise)) < 0.2 + 5.0 * noise for one in fits)
    misses = 0
    for one in fits:
        half = 0.6745 * np.sqrt(np.diag(one.covariance))
        exact = [fit_model.SCALES[name].to(TRUTH[name]) for name in one.problem.free]
        misses += int(np.sum(np.abs(one.x - exact) > half))
    of = repetitions * len(AT_TRUTH)
    assert 0.25 < misses / of < 0.75


def test_own_starts_and_derivatives(three_percent: fitting.Fit) -> None:
    """Starts drawn from the record find the minimum near the truth; a smaller step agrees."""
    problem = three_percent.problem
    truth = np.array([fit_model.SCALES[name].to(TRUTH[name]) for name in problem.free])
    assert three_percent.costs[0] <= float(np.sum(problem.residuals(truth) ** 2))
    assert three_percent.agreeing > 1
    assert three_percent.derivative_error < 1e-3
    again = fit(problem.tests, fixed=study.SET)
    assert again.values == three_percent.values


def test_stiffness_and_cycles() -> None:
    """Records under a normal stiffness and with reversals."""
    for record in ({"k_N": study.K_N}, {"turns": study.CYCLE, "rows": 120}):
        found = fit(study.synthetic(0.01, 0, **record), fixed=study.SET, start=AT_TRUTH, starts=1)
        for name, value in AT_TRUTH.items():
            assert found.values[name] == pytest.approx(value, rel=0.05), name


# --- what cannot be known -----------------------------------------------------------------------------------


def test_coupling_without_dilation(no_dilation: fitting.Fit, three_percent: fitting.Fit) -> None:
    """mu and theta are not separated, their ratio is, and the text says by how much."""
    free = no_dilation.problem.free
    i, j = free.index("mu"), free.index("theta")
    assert no_dilation.correlation[i, j] < -fitting.COUPLED
    assert abs(three_percent.correlation[i, j]) < fitting.COUPLED
    ratio = no_dilation.of(residual_ratio)
    assert ratio.low <= residual_ratio(TRUTH) <= ratio.high
    mu = no_dilation.estimates["mu"]
    worse = (mu.high - mu.low) / mu.value / ((ratio.high - ratio.low) / ratio.value)
    assert worse > 5.0
    text = identifiability(no_dilation)[0]
    assert "no dilation: mu and theta cannot be separated" in text
    assert f"= {ratio.value:.5g} is known" in text and f"{no_dilation.correlation[i, j]:.4f}" in text
    told = re.search(r"known (\d+) times worse", text)
    assert told and int(told[1]) >= int(worse)
    assert "are separated by the dilation" in identifiability(three_percent)[0]


def test_residual_alone_does_not_tell_the_bond() -> None:
    """A record that begins when the bond is gone (s_L > s_f) determines neither sigma0 nor Gc."""
    late = []
    for test in study.synthetic(0.01, 0):
        rows = test.slip > 3.0 * 2.0 * TRUTH["Gc"] / TRUTH["sigma0"]
        assert test.s_N is not None
        late.append(ShearTest(test.name, test.slip[rows], test.tau[rows], test.s_N[rows], test.sigma_N))
    found = fit(late, fixed=study.SET, start=AT_TRUTH, starts=1)
    text = "\n".join(identifiability(found))
    assert "Gc is not determined" in text or "sigma0 and Gc cannot be separated" in text, text


def test_model_that_does_not_fit_is_told() -> None:
    """A flat joint cannot dilate: residuals go together."""
    found = fit(study.synthetic(0.01, 0), ("sigma0", "Gc", "mu"), sides=0, starts=1)
    assert found.neighbours > 0.9
    assert "intervals are too narrow" in "\n".join(identifiability(found))


# --- records ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "slip,shear,sigma_N\n1,2,-1\n",
            r"record.csv: line 1: columns slip, shear, sigma_N: expected tau, too",
        ),
        ("slip,slip,tau,sigma_N\n", "line 1: column slip is there twice"),
        ("", "no rows: expected a header"),
        (HEADER, "no rows: expected a header"),
        (HEADER + "".join(ROWS.splitlines(True)[:4]), "record.csv: 4 rows: expected at least 5"),
        (HEADER + ROWS + "0.9,nan,0.1,-1\n", "line 9, column tau: nan: expected a finite number"),
        (HEADER + ROWS + "0.9,1,0.1,inf\n", "line 9, column sigma_N: inf: expected a finite number"),
        (HEADER + ROWS + "0.9,high,0.1,-1\n", "line 9, column tau: high: expected a finite number"),
        (HEADER + ROWS + "0.9,,0.1,-1\n", "line 9, column tau: empty: expected a finite number"),
        (HEADER + ROWS + "0.9,1,,-1\n", "line 9, column dilation: empty: expected a number, or none in the"),
        (HEADER + ROWS + "0.9,1,0.1\n", "line 9: 3 values: expected 4"),
        (HEADER + ROWS.replace(",-1", ",1"), "line 2, column sigma_N: 1 is tension: expected compression"),
        (HEADER + ROWS + "0.9,1,0.1,-2\n", "line 9, column sigma_N: -2 is more than 5% off the mean -1.125"),
        (
            HEADER + ROWS.replace(",-1", ",-1e6"),
            "column tau: 0.8 where |sigma_N| is up to 1e+06: expected the",
        ),
        (HEADER + ROWS.replace(",-1", ",-1e-6"), "column tau: 0.8 where |sigma_N| is up to 1e-06: expected"),
        (HEADER + "".join(f"{i},1,0,-1\n" for i in range(7)), "column tau is 1 in all rows: expected it to"),
        (
            HEADER + "".join(f"{i}e-3,{i},{i},-1\n" for i in range(7)),
            "line 8, column dilation: 6 over slips up",
        ),
        (
            "slip,tau,sigma_N,k_N\n" + "".join(f"{i},{i},-1,{-i}\n" for i in range(7)),
            "column k_N: 7 values: expected one a test",
        ),
        (
            "slip,tau,sigma_N,k_N\n" + "".join(f"{i},{i},-1,-2\n" for i in range(7)),
            "line 2, column k_N: -2: expected a stiffness >= 0",
        ),
        (
            HEADER.replace("\n", ",k_N\n") + "".join(f"{i},{i},{i},-1,1e6\n" for i in range(7)),
            "column k_N: 1e+06 changes sigma_N by 6e+06: expected stress/length",
        ),
    ],
)
def test_bad_records(text: str, message: str, tmp_path: Path) -> None:
    """Errors name file, line, column, value and what was expected."""
    path = write(tmp_path, text)
    with pytest.raises(ValueError, match=re.escape(message)) as caught:
        read_records([path])
    assert "record.csv" in str(caught.value)


def test_records_of_all_kinds(tmp_path: Path) -> None:
    """Units in the header, comments, interleaved tests, an alias, unused columns, several files."""
    text = "# a box\ntest,slip [mm],tau [MPa],s_N [mm],sigma_N [MPa],k_N,time\n"
    for i in range(1, 7):
        text += f"a,{i},{i},{0.1 * i},2,,{i}\nb,{-i},{-i},{0.2 * i},3,4,{i}\n"
    path = write(tmp_path, text)
    plain = write(tmp_path, "slip,tau,sigma_N\n" + "".join(f"{i},{i},1\n" for i in range(6)), "plain.csv")
    with pytest.warns(asperity.ModelWarning, match=r"record.csv: columns not used: time"):
        a, b, c = read_records([path, plain], k_N=7.0, compression_positive=True)
    assert (a.sigma_N, a.k_N, b.sigma_N, b.k_N, c.sigma_N, c.k_N) == (-2.0, 7.0, -3.0, 4.0, -1.0, 7.0)
    assert "test a" in a.name and c.s_N is None and b.slip.tolist() == [-1, -2, -3, -4, -5, -6]
    assert a.s_N is not None and a.s_N.tolist() == pytest.approx([0.1, 0.2, 0.3, 0.4, 0.5, 0.6])
    assert ShearTest("", np.array([0, 1, 2, 1, -1, 0.5]), a.tau, None, -1.0).turns == [2.0, -1.0, 0.5]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"free": ("sigma0", "cohesion")}, "free: cohesion: expected one of sigma0, Gc"),
        ({"free": ()}, "free: none: expected names"),
        ({"fixed": {"mu": 0.5}}, "mu: expected it free or set, not both"),
        ({"free": ("sigma0", "Gc", "mu")}, "theta: expected it among the free ones, or a value set"),
        ({"free": ("sigma0", "Gc", "mu", "theta"), "sides": 0}, "expected inclined planes"),
        ({"fixed": {"eta": 1.5}}, "eta = 1.5"),
        ({"bounds": {"mu": (0.5, 0.1)}}, "bounds: mu = 0.5, 0.1: expected 0 < low < high"),
        ({"start": {"eta": 0.5}}, "start: eta = 0.5: expected one of the free ones"),
        ({"starts": 0}, "starts = 0: expected 1 to"),
        ({"confidence": 1.0}, "confidence = 1: expected between 0 and 1"),
        (
            {"free": ("mu", "theta"), "fixed": {"sigma0": 1.5, "Gc": 150e-6}},
            "column slip: up to 0.7 where s_f = 2 Gc/sigma0 is 0.0002 to 0.0002: expected the unit",
        ),
        ({"free": tuple(TRUTH)}, "14 values in 1 tests: expected more than 14, twice the 7 free"),
    ],
)
def test_bad_arguments(arguments: dict[str, Any], message: str, tmp_path: Path) -> None:
    """Errors name the parameter, its value and what was expected."""
    tests = read_records([write(tmp_path, HEADER + ROWS)])
    with pytest.raises(ValueError, match=re.escape(message)):
        fit(tests, **arguments)


# --- command ------------------------------------------------------------------------------------------------


def test_command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """Record, report, picture and a case that driver, card and select read."""
    monkeypatch.chdir(tmp_path)
    assert study.main(["record.csv"]) == 0
    start = " ".join(f"{name}={value}" for name, value in AT_TRUTH.items())
    options = ["--set", "kc=20", "--start", start, "--starts", "1", "--plot", "fit.png", "--case", "fit.nml"]
    assert main(["fit", "record.csv", *options]) == 0
    printed = capsys.readouterr().out
    assert printed.endswith("fit.png\nfit.nml\n")
    assert Path("fit.png").read_bytes().startswith(b"\x89PNG")
    line = re.search(r"^PROPS\(19\)   (.*)$", printed, re.MULTILINE)
    assert line
    interface, _ = read_interface(Path("fit.nml"))
    assert [float(text) for text in line[1].split(",")] == pytest.approx(interface.props().tolist(), rel=1e-5)
    tests = list(slip_tests(Path("fit.nml")))
    assert [test.sigma_N for test in tests] == list(study.SIGMA_N)
    assert tests[0].slips[-1] == pytest.approx(study.TURNS[-1])
    assert main(["card", "--host", "abaqus", "fit.nml"]) == 0
    assert "*User Material" in capsys.readouterr().out
    assert main(["run", "fit.nml", "-o", "rows.csv"]) == 0


def test_case_without_a_sweep() -> None:
    """One test, cyclic, under a stiffness: no sweep, and the case says that it leaves out the spring."""
    tests = study.synthetic(0.0, 0, sigma_N=(-2.0,), turns=study.CYCLE, k_N=study.K_N)
    found = fit(tests, fixed=study.SET, start=AT_TRUTH, starts=1)
    text = case_text(found)
    assert "&sweep" not in text and "this case holds the normal traction of its start" in text
    assert "&step t_N = -2.0," in text and "slip = 0.5, -0.5, 0.5," in text
    assert "1 turning point" not in report(found) and "2 turning points" in report(found)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--set", "eta"], "--set eta: expected NAME=VALUE"),
        (["--bounds", "mu=0.1"], "--bounds mu=0.1: expected NAME=LOW,HIGH"),
        (["--plot", "fit.jpg"], "--plot fit.jpg: expected a name that ends in .png or .pdf"),
        (["--units", "mm"], "--units mm: expected LENGTH,STRESS"),
        (["--k-N", "-1"], "k_N = -1: expected a finite stiffness >= 0"),
        (["--compression-positive"], "line 2, column sigma_N: -1 is tension: expected compression"),
    ],
)
def test_bad_options(
    options: list[str], message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Told on standard error, exit code 1."""
    assert main(["fit", str(write(tmp_path, HEADER + ROWS)), *options]) == 1
    assert message in capsys.readouterr().err


def test_without_scipy(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The message names what to install."""
    load = builtins.__import__

    def missing(name: str, *rest: Any) -> Any:
        if name.startswith("scipy"):
            raise ImportError(name)
        return load(name, *rest)

    monkeypatch.setattr(builtins, "__import__", missing)
    assert main(["fit", str(write(tmp_path, HEADER + ROWS))]) == 1
    assert "fit needs scipy" in capsys.readouterr().err
