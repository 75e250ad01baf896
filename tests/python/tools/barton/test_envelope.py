"""Joints of Barton: closed forms, mobilised curves, the closest RIE."""

from __future__ import annotations

import io
import re
from contextlib import redirect_stdout
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from asperity import EquilibriumLost, Interface, contract
from asperity.case_files import read_case, slip_tests
from asperity.cli import main
from asperity.tools.barton.envelope import STRESSES, Envelope, curves, envelope
from asperity.tools.barton.joint import MOBILISED, Joint

SAMPLE = Joint(jrc=10.0, jcs=100.0, phi_r=30.0, length=0.1)
"""Joint as long as the sample.  At sigma_n = 1 MPa, log10(JCS/sigma_n) = 2: roughness adds 20 degrees."""

WEAK = Joint(jrc=10.0, jcs=50.0, phi_r=30.0, length=0.1)
"""Joint of the commands."""

ROW = r"[\d.]+ +[\d.]+ +[\d.]+ +\S+% "
"""Start of a row of the table of a command: normal stress, both peaks, and how far they are apart."""


def said(stresses: str, folder: Path) -> str:
    """What the command prints of WEAK at these normal stresses; case and picture are in the folder."""
    words = f"barton --jrc 10 --jcs 50 --phi-r 30 --length 0.1 --sigma-n {stresses} --card abaqus"
    files = [f"--plot={folder / 'barton.png'}", f"--output={folder / 'joint.nml'}"]
    with redirect_stdout(io.StringIO()) as out:
        assert main([*words.split(), *files]) == 0
    return out.getvalue()


@pytest.fixture(scope="module")
def wide(tmp_path_factory: pytest.TempPathFactory) -> tuple[str, Path]:
    """Output of the command for a range of normal stresses, 0.5 to 5 MPa, and its folder."""
    folder = tmp_path_factory.mktemp("wide")
    return said("0.5,5", folder), folder


def rows_of(text: str) -> list[list[str]]:
    """Rows of the table of a command."""
    return [line.split() for line in text.splitlines() if re.match(ROW, line)]


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
def test_constants_change_smoothly(wide: tuple[str, Path]) -> None:
    """The numbers of an envelope are those of the joints; the constants change with JRC as it does."""
    run = read_case(wide[1] / "joint.nml").runs[0]
    interface, material = run.interface, run.material
    middle = {"ks": material.K, "height": material.height, "crush": material.crush}
    middle["theta"] = run.props[contract.index("theta")]
    above = envelope(Joint(10.1, 50.0, 30.0, 0.1), 0.5, 5.0).values
    for name, most in {"ks": 0.02, "theta": 0.02, "height": 0.05, "crush": 0.2}.items():
        assert abs(np.log(above[name] / middle[name])) < most, name
    # of the roughest joints, which the law meets least
    for low, high, most in ((0.5, 5.0, 0.12), (3.0, 20.0, 0.14)):
        assert np.abs(envelope(Joint(20.0, 50.0, 30.0, 0.1), low, high).parted).max() < most
    slips = np.linspace(0.0, 9.0, 181)
    path = interface.confined_slip(0.0, slips, -1.0)
    barton, law = Envelope(SAMPLE, interface, np.array([1.0]), slips, {}).numbers[:, 0]
    opening = SAMPLE.dilation(slips[-1:], 1.0)[0]
    assert barton == pytest.approx([SAMPLE.peak_strength(1.0), SAMPLE.peak_slip, opening], rel=1e-9)
    assert law[0] == pytest.approx(path.tau.max(), rel=1e-9)
    # the peak lies between the rows
    assert law[1] == pytest.approx(slips[path.tau.argmax()], abs=slips[1])
    assert law[2] == pytest.approx(path.dilation[-1] - path.dilation[0], rel=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("rows", [1, 5])
def test_command(
    rows: int, wide: tuple[str, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The command prints both laws, PROPS and the card; the case has the constants.

    The strengths are within 5 % of Barton's, with mu = tan(phi_r) and crush over a range.
    """
    text, folder = wide if rows > 1 else (said("1", tmp_path), tmp_path)
    case, plot, table = folder / "joint.nml", folder / "barton.png", rows_of(text)
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
    assert not list(folder.glob("*.json")) and main(["uncertainty", str(case)]) == 1
    assert "joint.fit.json: expected" in capsys.readouterr().err


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::asperity.ModelWarning")
def test_trial_without_equilibrium(wide: tuple[str, Path], monkeypatch: pytest.MonkeyPatch) -> None:
    """One trial whose law has no equilibrium does not end the search, whose end is the same."""
    whole, calls = Interface.confined_slip, []

    def lost(interface: Interface, direction: float, slips: Any, *rest: Any) -> Any:
        calls.append(slips)
        # at the first normal stress of the second trial
        if len(calls) == STRESSES + 1:
            raise EquilibriumLost("lost", whole(interface, direction, slips[:5], *rest))
        return whole(interface, direction, slips, *rest)

    monkeypatch.setattr(Interface, "confined_slip", lost)
    rough = envelope(WEAK, 0.5, 5.0)
    assert len(calls) > 3 * STRESSES
    # the table has a tenth of a per cent
    most = max(abs(float(row[3][:-1])) for row in rows_of(wide[0])) / 100.0
    assert np.abs(rough.parted).max() == pytest.approx(most, abs=0.01)
    calls[:] = [()] * STRESSES
    with pytest.raises(ValueError, match=r"equilibrium up to the slip .* mm, expected up to"):
        rough.curves(rough.stresses[:1])


def test_strength_that_no_constants_meet(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Where the law misses the strength of Barton by more than a fit may, the exit code says so."""
    words = f"barton --jrc 20 --jcs 50 --phi-r 30 --length 0.1 --sigma-n .5,40 -o {tmp_path / 'joint.nml'}"
    assert main(words.split()) == 3
    said = re.search(
        r"the strength of the law differs by (\d+)%: expected at most 10% more", capsys.readouterr().err
    )
    assert said and int(said[1]) > 15
    assert (tmp_path / "joint.nml").exists()
