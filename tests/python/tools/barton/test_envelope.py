"""Joints of Barton: closed forms, mobilised curves, the closest RIE."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from asperity.case_files import read_case, slip_tests
from asperity.cli import main
from asperity.tools.barton.envelope import STRESSES, Envelope, curves, envelope
from asperity.tools.barton.joint import MOBILISED, Joint
from asperity.tools.fit import model

SAMPLE = Joint(jrc=10.0, jcs=100.0, phi_r=30.0, length=0.1)
"""Joint as long as the sample.  At sigma_n = 1 MPa, log10(JCS/sigma_n) = 2: roughness adds 20 degrees."""


def test_peak_and_scale_in_closed_form() -> None:
    """Strength, dilation angle and slip at the peak where logarithms are whole; longer joints are weaker."""
    block = Joint(jrc=10.0, jcs=100.0, phi_r=30.0, length=1.0)
    measured = Joint(jrc=10.0, jcs=100.0, phi_r=30.0, length=1.0, sample=1.0)
    for value, expected in (
        (SAMPLE.peak_strength(1.0), np.tan(np.radians(50.0))),
        (SAMPLE.peak_strength(10.0), 10.0 * np.tan(np.radians(40.0))),
        (SAMPLE.damage_coefficient(1.0), 10.0 / 24.0 + 0.7),
        (SAMPLE.peak_slip, 1000.0 * 0.1 / 500.0 * 100.0**0.33),
        # ten times the length: JRC falls by 10^(-0.02 JRC), JCS by 10^(-0.03 JRC), the peak comes later
        (block.jrc_n, 10.0**0.8),
        (block.jcs_n, 10.0**1.7),
        (block.peak_slip, 2.0 * (10.0**0.8) ** 0.33),
        (measured.jrc_n, 10.0),
        (measured.jcs_n, 100.0),
    ):
        assert value == pytest.approx(expected, rel=1e-14)
    assert all(block.peak_strength(pressure) < SAMPLE.peak_strength(pressure) for pressure in (0.5, 5.0))


def test_mobilised_strength_and_dilation() -> None:
    """tau has the angles of the table; the dilation rises by tan(angle/M), from 0.3 to 100 peak slips."""
    peak, (ratio, share) = SAMPLE.peak_slip, np.array(MOBILISED).T
    slip = np.concatenate([[0.0], ratio, [500.0]]) * peak
    angles = np.concatenate([[0.0], 30.0 + 20.0 * share, [30.0]])
    # rounding of an angle of 50 degrees
    assert SAMPLE.shear(slip, 1.0) == pytest.approx(np.tan(np.radians(angles)), abs=1e-14)
    slip = np.linspace(0.0, 120.0 * peak, 400001)
    s_N = SAMPLE.dilation(slip, 1.0)
    slope = np.gradient(s_N, slip)
    assert np.all(s_N[slip <= 0.3 * peak] == 0.0) and s_N[slip >= 101.0 * peak] == pytest.approx(s_N[-1])
    # the slope has a kink at the peak and the grid of the integral does not have this point
    for slope_there, part in ((slope.max(), 1.0), (slope[np.searchsorted(slip, 4.0 * peak)], 0.7)):
        angle = part * 20.0 / (10.0 / 24.0 + 0.7)
        assert slope_there == pytest.approx(np.tan(np.radians(angle)), rel=1e-2)
    # just below JCS the joint is all but smooth, and the curves are still finite
    test = curves(Joint(jrc=20.0, jcs=50.0, phi_r=25.0, length=0.1), 49.9)
    assert np.all(np.isfinite(test.tau)) and np.all(np.isfinite(test.s_N))


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::asperity.ModelWarning")
def test_constants_change_smoothly() -> None:
    """The numbers of an envelope are those of the joints; the constants change with JRC as it does."""
    envelopes = [envelope(Joint(jrc, 50.0, 30.0, 0.1), 0.5, 5.0) for jrc in (9.9, 10.0, 10.1)]
    for name, most in {"ks": 0.02, "theta": 0.02, "height": 0.05, "crush": 0.2}.items():
        values = np.array([law.values[name] for law in envelopes])
        assert np.abs(np.diff(np.log(values))).max() < most, name
    # of the roughest joints
    for jrc, low, high, most in ((18.0, 0.5, 5.0, 0.11), (20.0, 0.5, 5.0, 0.16), (20.0, 3.0, 20.0, 0.14)):
        assert np.abs(envelope(Joint(jrc, 50.0, 30.0, 0.1), low, high).parted).max() < most
    middle = Envelope(SAMPLE, envelopes[1].interface, np.array([1.0]), np.linspace(0.0, 9.0, 181), {})
    path = middle.interface.confined_slip(0.0, middle.slips, -1.0)
    barton, law = middle.numbers[:, 0]
    opening = SAMPLE.dilation(middle.slips[-1:], 1.0)[0]
    assert barton == pytest.approx([SAMPLE.peak_strength(1.0), SAMPLE.peak_slip, opening], rel=1e-9)
    assert law[0] == pytest.approx(path.tau.max(), rel=1e-9)
    # the peak lies between the rows
    assert law[1] == pytest.approx(middle.slips[path.tau.argmax()], abs=middle.slips[1])
    assert law[2] == pytest.approx(path.dilation[-1] - path.dilation[0], rel=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize(("stresses", "rows"), [("1", 1), ("0.5,5", 5)])
def test_command(stresses: str, rows: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The command prints both laws, PROPS and the card; the case has the constants.

    The strengths are within 5 % of Barton's, with mu = tan(phi_r) and crush over a range.
    """
    case, plot = tmp_path / "joint.nml", tmp_path / "barton.png"
    words = f"barton --jrc 10 --jcs 50 --phi-r 30 --length 0.1 --sigma-n {stresses} --card abaqus"
    assert main([*words.split(), f"--plot={plot}", f"--output={case}"]) == 0
    text = capsys.readouterr().out
    table = [line.split() for line in text.splitlines() if re.match(r"[\d.]+ +[\d.]+ +[\d.]+ +\S+% ", line)]
    assert len(table) == rows and "*User Material" in text and plot.stat().st_size > 10000
    props = [float(value) for value in re.search(r"PROPS\(\d+\) +(.*)", text)[1].split(",")]  # type: ignore[index]
    written = read_case(case)
    material = written.runs[0].material
    assert written.runs[0].props == pytest.approx(props, rel=1e-5) and material.damage0 == 1.0
    assert [test.sigma_N for test in slip_tests(written)] == pytest.approx([-float(row[0]) for row in table])
    if rows > 1:
        assert max(abs(float(row[3][:-1])) for row in table) < 5.0
        assert material.mu == pytest.approx(np.tan(np.radians(30.0)), rel=1e-5) and material.crush > 0.0
        peaks = [run.history().traction[:, 1].max() for run in written.runs]
        # the case slips in other increments
        assert peaks == pytest.approx([float(row[2]) for row in table], rel=0.02)
    else:
        assert "joint of Barton has no bond" in text and "\nks " in text
    # curves without scatter have no covariance
    assert not list(tmp_path.glob("*.json")) and main(["uncertainty", str(case)]) == 1
    assert "joint.fit.json: expected" in capsys.readouterr().err


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::asperity.ModelWarning")
def test_trial_without_equilibrium(monkeypatch: pytest.MonkeyPatch) -> None:
    """One trial whose law has no equilibrium does not end the search, whose end is the same."""
    whole, calls = model.slip_curve, []

    def lost(*arguments: Any) -> tuple[Any, Any, int]:
        tau, s_N, done = whole(*arguments)
        calls.append(arguments)
        # the curves of the second trial
        return tau, s_N, 5 if STRESSES < len(calls) <= 2 * STRESSES else done

    smooth = envelope(SAMPLE, 0.5, 5.0)
    monkeypatch.setattr(model, "slip_curve", lost)
    rough = envelope(SAMPLE, 0.5, 5.0)
    assert len(calls) > 3 * STRESSES
    assert np.abs(rough.parted).max() == pytest.approx(np.abs(smooth.parted).max(), abs=0.01)
    calls[:] = [()] * STRESSES
    with pytest.raises(ValueError, match=r"equilibrium up to the slip .* mm, expected up to"):
        rough.curves(rough.stresses[:1])
