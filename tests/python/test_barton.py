"""Joints of Barton: closed forms, mobilised curves, the closest RIE, rejected input."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import numpy as np
import pytest
from asperity.barton.command import compare, curves
from asperity.barton.joint import MOBILISED, Joint
from asperity.case_files import read_case, slip_tests
from asperity.cli import main
from asperity.fit.fitting import fit

SAMPLE = Joint(jrc=10.0, jcs=100.0, phi_r=30.0, length=0.1)
"""Joint as long as the sample.  At sigma_n = 1 MPa, log10(JCS/sigma_n) = 2: roughness adds 20 degrees."""

ARGUMENTS = {"--jrc": "10", "--jcs": "50", "--phi-r": "30", "--length": "0.1", "--sigma-n": "1"}


def command(*more: str, **changed: str) -> list[str]:
    """Arguments of the subcommand, some of them changed."""
    values = ARGUMENTS | {f"--{name.replace('_', '-')}": value for name, value in changed.items()}
    return ["barton", *(f"{name}={value}" for name, value in values.items()), *more]


# --- the joint ----------------------------------------------------------------------------------------------


def test_peak_in_closed_form() -> None:
    """Strength, dilation angle and slip at the peak where the logarithm is a whole number."""
    assert SAMPLE.peak_strength(1.0) == pytest.approx(np.tan(np.radians(50.0)), rel=1e-14)
    assert SAMPLE.peak_strength(10.0) == pytest.approx(10.0 * np.tan(np.radians(40.0)), rel=1e-14)
    assert SAMPLE.damage_coefficient(1.0) == pytest.approx(10.0 / 24.0 + 0.7, rel=1e-14)
    assert SAMPLE.peak_dilation_angle(1.0) == pytest.approx(20.0 / (10.0 / 24.0 + 0.7), rel=1e-14)
    assert SAMPLE.peak_slip == pytest.approx(1000.0 * 0.1 / 500.0 * 100.0**0.33, rel=1e-14)


def test_longer_joints_are_smoother_and_weaker() -> None:
    """Ten times the length: JRC falls by 10^(-0.02 JRC), JCS by 10^(-0.03 JRC), the peak comes later."""
    block = Joint(jrc=10.0, jcs=100.0, phi_r=30.0, length=1.0)
    assert block.jrc_n == pytest.approx(10.0**0.8, rel=1e-14)
    assert block.jcs_n == pytest.approx(10.0**1.7, rel=1e-14)
    assert block.peak_slip == pytest.approx(2.0 * (10.0**0.8) ** 0.33, rel=1e-14)
    assert (SAMPLE.jrc_n, SAMPLE.jcs_n) == (10.0, 100.0)
    measured = Joint(jrc=10.0, jcs=100.0, phi_r=30.0, length=1.0, sample=1.0)
    assert (measured.jrc_n, measured.jcs_n) == (10.0, 100.0)
    for sigma_n in (0.5, 5.0):
        assert block.peak_strength(sigma_n) < SAMPLE.peak_strength(sigma_n)


def test_mobilised_strength_passes_the_table() -> None:
    """tau is zero without slip and sigma_n tan(phi_r + 20 share) at the slips of the table; beyond, phi_r."""
    ratio, share = np.array(MOBILISED).T
    slip = np.concatenate([[0.0], ratio, [500.0]]) * SAMPLE.peak_slip
    angles = np.concatenate([[0.0], 30.0 + 20.0 * share, [30.0]])
    # rounding of an angle of 50 degrees
    assert SAMPLE.shear(slip, 1.0) == pytest.approx(np.tan(np.radians(angles)), abs=1e-14)
    fine = np.linspace(0.0, 200.0, 20001)
    assert fine[np.argmax(SAMPLE.shear(fine * SAMPLE.peak_slip, 1.0))] == pytest.approx(1.0)


def test_dilation_has_the_mobilised_slope() -> None:
    """The slope is tan(angle/M), 0 up to 0.3 of the slip at the peak, largest at the peak, 0 beyond 100."""
    peak = SAMPLE.peak_slip
    slip = np.linspace(0.0, 120.0 * peak, 400001)
    s_N = SAMPLE.dilation(slip, 1.0)
    slope = np.gradient(s_N, slip)
    steepest = np.tan(np.radians(SAMPLE.peak_dilation_angle(1.0)))
    assert np.all(s_N[slip <= 0.3 * peak] == 0.0)
    assert s_N[slip >= 101.0 * peak] == pytest.approx(s_N[-1])
    # the slope has a kink at the peak and the grid of the integral does not have this point
    assert slope.max() == pytest.approx(steepest, rel=1e-2)
    assert slope[np.searchsorted(slip, 4.0 * peak)] == pytest.approx(
        np.tan(np.radians(0.7 * SAMPLE.peak_dilation_angle(1.0))), rel=1e-2
    )


# --- the closest RIE ----------------------------------------------------------------------------------------


@pytest.mark.filterwarnings("ignore::asperity.ModelWarning")
def test_nearly_smooth_joint_is_coulomb_friction() -> None:
    """For JRC near 0 the closest flat plane has the mu of linear least squares on the rows."""
    tests = curves(Joint(jrc=0.01, jcs=100.0, phi_r=30.0, length=0.1), (0.5, 2.0))
    # there is no bond, and the contact slides before the first row
    found = fit(tests, free=("mu",), fixed={"ks": 1e4}, start={"mu": 0.3}, starts=1, sides=0)
    weights = [-test.sigma_N / np.ptp(test.tau) for test in tests]
    rows = [test.tau / np.ptp(test.tau) for test in tests]
    products = [weight * row.sum() for weight, row in zip(weights, rows, strict=True)]
    closest = sum(products) / sum(weight**2 * tests[0].slip.size for weight in weights)
    assert found.values["mu"] == pytest.approx(closest, rel=1e-6)
    assert closest == pytest.approx(np.tan(np.radians(30.0)), rel=0.03)


@pytest.mark.filterwarnings("ignore::asperity.ModelWarning")
def test_rows_are_those_of_the_interface() -> None:
    """Peak, opening and misfit of the RIE are those of its own slip test."""
    joint = Joint(jrc=10.0, jcs=50.0, phi_r=30.0, length=0.1)
    tests = curves(joint, (1.0,), reach=3.0)
    found = fit(
        tests,
        free=("mu", "theta"),
        fixed={"ks": 5.0, "kc": 20.0},
        start={"mu": 0.6, "theta": 10.0},
        starts=1,
    )
    [row] = compare(joint, found)
    slips = found.problem.paths[0].slips
    path = found.interface.confined_slip(0.0, slips, -1.0, 50 * found.problem.refinement)
    s_N = path.separation[:, 0] - path.separation[0, 0]
    assert row.sigma_n == 1.0
    assert row.tau == pytest.approx((joint.peak_strength(1.0), path.traction[:, 1].max()), rel=1e-9)
    assert row.s_N == pytest.approx((tests[0].s_N[-1], s_N[-1]), rel=1e-9)
    off = path.traction[found.problem.paths[0].rows, 1] - tests[0].tau
    assert row.misfit[0] == pytest.approx(np.sqrt(np.mean(off**2)) / np.ptp(tests[0].tau), rel=1e-9)
    # one plane that slides up cannot dilate by more than its slope
    assert row.angle[1] <= found.values["theta"] * (1.0 + 1e-6)


@pytest.mark.slow
def test_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The command prints both laws, PROPS and the card; the case has the constants."""
    case, plot = tmp_path / "joint.nml", tmp_path / "barton.png"
    more = (f"--plot={plot}", f"--output={case}", "--card=abaqus", "--starts=1")
    assert main(command(*more)) == 0
    text = capsys.readouterr().out
    assert re.findall(r"^ +(1) +\d", text, re.MULTILINE) == ["1"]
    assert "joint of Barton has no bond" in text
    assert "PROPS(" in text and "*User Material" in text
    assert plot.stat().st_size > 10000
    props = [float(value) for value in re.search(r"PROPS\(\d+\) +(.*)", text)[1].split(",")]
    written = read_case(case)
    assert [test.sigma_N for test in slip_tests(written)] == [-1.0]
    assert written.runs[0].props == pytest.approx(props, rel=1e-5)
    assert written.runs[0].material.damage0 == 1.0
    # curves without scatter have no covariance
    assert "\nks " in text and "sigma0 is not determined" not in text and not list(tmp_path.glob("*.json"))
    assert main(["uncertainty", str(case)]) == 1
    assert "joint.fit.json: expected" in capsys.readouterr().err


NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e[+-]?\d+)?%?")

DIGITS = 5.0e-3
"""Relative difference of a fit on another processor."""


@pytest.mark.long
def test_page(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """The example of docs/how-to/barton.md prints the tables that the page shows."""
    monkeypatch.chdir(tmp_path)
    page = (Path(__file__).parents[2] / "docs" / "how-to" / "barton.md").read_text(encoding="utf-8")
    [(line, shown)] = re.findall(
        r"^```console\n([^\n]*)\n```[^`]*^```text\n(.*?)^```$", page, re.MULTILINE | re.DOTALL
    )
    assert main(shlex.split(line)[1:]) == 0
    printed = capsys.readouterr().out
    assert (tmp_path / "barton.png").exists()
    lines = [text for text in shown.splitlines() if text.strip()]
    found = [text for text in printed.splitlines() if text.strip()][: len(lines)]
    assert [NUMBER.sub("#", text).split() for text in lines] == [
        NUMBER.sub("#", text).split() for text in found
    ]
    for one, other in zip(*(NUMBER.findall(" ".join(texts)) for texts in (lines, found)), strict=True):
        if one.endswith("%"):
            assert float(other[:-1]) == pytest.approx(float(one[:-1]), abs=0.11)  # a unit of the last digit
        else:
            assert float(other) == pytest.approx(float(one), rel=DIGITS)


@pytest.mark.slow
def test_envelope(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A range gives one set with mu = tan(phi_r) and crush, whose strengths are within 5 % of Barton's."""
    case, plot = tmp_path / "joint.nml", tmp_path / "barton.png"
    assert main(command(f"--plot={plot}", f"--output={case}", "--card=abaqus", sigma_n="0.5,5")) == 0
    text = capsys.readouterr().out
    rows = [line.split() for line in text.splitlines() if line.endswith(tuple("0123456789")) and "%" in line]
    assert len(rows) == 5 and max(abs(float(row[3][:-1])) for row in rows) < 5.0
    assert "*User Material" in text and plot.stat().st_size > 10000
    one = read_case(case)
    material = one.runs[0].material
    assert material.mu == pytest.approx(np.tan(np.radians(30.0)), rel=1e-5) and material.crush > 0.0
    assert len(one.runs) == 5
    peaks = [run.history().traction[:, 1].max() for run in one.runs]
    # the case slips in other increments
    assert peaks == pytest.approx([float(row[2]) for row in rows], rel=0.02)


# --- rejected input -----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"jrc": "0"}, "JRC = 0: expected > 0 and <= 20"),
        ({"jrc": "21"}, "JRC = 21: expected > 0 and <= 20"),
        ({"jrc": "nan"}, "JRC = nan: expected > 0 and <= 20"),
        ({"jcs": "-5"}, "JCS = -5: expected a strength in MPa, > 0"),
        ({"phi_r": "90"}, "phi_r = 90: expected degrees, > 0 and < 70"),
        ({"length": "0.05"}, "length = 0.05: expected m, >= sample = 0.1"),
        ({"sample": "0"}, "sample = 0: expected a length in m, > 0"),
        ({"sigma_n": "1,60"}, "sigma_n = 60: expected compression > 0 and < 50 MPa, JCS of the length"),
        ({"sigma_n": "-1"}, "sigma_n = -1: expected compression > 0 and < 50 MPa, JCS of the length"),
        ({"sigma_n": "1,x"}, "--sigma-n = 'x': expected a finite number"),
        ({"sigma_n": "1,1"}, "sigma_n = 1, 1: expected the lower normal stress first"),
        ({"sigma_n": "1,2,3"}, "--sigma-n 1,2,3: expected one normal stress, or LOW,HIGH"),
        ({"sigma_n": "1,2", "free": "mu"}, "--free: expected with one normal stress"),
        ({"sigma_n": "0.001"}, "JRC log10(JCS/sigma_n) is 76.99 degrees: expected at most 70"),
        ({"reach": "1"}, "reach = 1: expected slips at the peak, > 1 and <= 100"),
        ({"free": "ks,nonsense"}, "--free: nonsense is unknown: expected of"),
        ({"free": "mu,sigma0"}, "--free mu,sigma0: sigma0: expected ks, as a joint of Barton has no bond"),
        ({"jrc": "0", "jcs": "-5"}, "JRC = 0: expected > 0 and <= 20\nJCS = -5: expected"),
        ({"plot": "picture.txt"}, "expected a name that ends in .png or .pdf"),
    ],
)  # fmt: skip
def test_refused(changed: dict[str, str], message: str, capsys: pytest.CaptureFixture[str]) -> None:
    """Wrong input ends with exit code 1 and a message that has the value and what was expected."""
    assert main(command(**changed)) == 1
    assert message in capsys.readouterr().err


def test_stress_close_to_the_strength_of_the_wall() -> None:
    """Just below JCS the joint is all but smooth, and curves and slips are still finite."""
    joint = Joint(jrc=20.0, jcs=50.0, phi_r=25.0, length=0.1)
    [test] = curves(joint, (49.9,))
    assert np.all(np.isfinite(test.tau)) and np.all(np.isfinite(test.s_N))
