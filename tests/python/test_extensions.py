"""Finite asperity height and wear: the statements of docs/extensions.md, warnings, fit, cards."""

from __future__ import annotations

import re
import subprocess
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from asperity import Interface, Material, ModelWarning, Pattern, contract, read_case
from asperity.cli import main
from asperity.fit.fitting import fit
from asperity.fit.report import case_of, report
from asperity.fit.shear_test import ShearTest
from asperity.installed import driver
from asperity.remarks import doubts

from harness.studies import extensions
from harness.studies.extensions import LOCKING, PRESSURE, SLOPE, STEEP_RT, TABLE_2, path

RT = Pattern.regular(2, 30.0)
STIFF = replace(TABLE_2, kc=100.0)


# --- what the height changes --------------------------------------------------------------------------------


def test_snap_vanishes() -> None:
    """The jump of RP-16 without pressure shrinks with the height; below 2.5 s_f the branch does not end."""
    sizes = []
    for height in (0.0, 2.0, 1.0):
        [jump] = extensions.snap(height).snaps
        sizes.append(jump.after[0] - jump.before[0])
    assert np.all(np.diff(sizes) < 0.0) and sizes[-1] > 0.0
    assert extensions.snap(0.5).snaps == ()


# --- wear ---------------------------------------------------------------------------------------------------


def test_wear_goes_with_the_weight() -> None:
    """A flat share that halves the weight of the facets needs twice the W0 for the same wear."""
    found = []
    for flat, W0 in ((0.0, 4.0), (0.5, 8.0), (0.5, 4.0)):
        joint = Interface(replace(LOCKING, mu=0.5, height=0.0, W0=W0), Pattern.regular(2, 30.0, flat=flat))
        found.append(joint.confined_slip(0.0, path(0.6), -0.5).state[-1])
    names = [contract.statev_names(n, wears=True) for n in (2, 3, 3)]
    # facing plane: the first inclined one; its elastic slip, a hundredth of the path, goes with 1/gamma, too
    places = [n.index(name) for n, name in zip(names, ("worn_1", "worn_2", "worn_2"), strict=True)]
    whole, scaled, same = (state[place] for state, place in zip(found, places, strict=True))
    assert scaled == pytest.approx(whole, rel=0.03) and same > 1.5 * whole


def test_plesha_in_closed_form() -> None:
    """Without wear the rigid joint has the strengths up and down a slope, and closes where it began."""
    slips = path(0.4, -0.4, 0.0)
    tau, opening, angle = extensions.plesha(slips, 0.5, SLOPE, 0.0, 2.0)
    up, down = (0.5 + SLOPE) / (1.0 - 0.5 * SLOPE), (0.5 - SLOPE) / (1.0 + 0.5 * SLOPE)
    assert tau[1:401] == pytest.approx(2.0 * up, rel=1e-12)
    assert tau[401:801] == pytest.approx(-2.0 * down, rel=1e-12)
    assert opening.max() == pytest.approx(0.4 * SLOPE, rel=1e-12) and abs(opening[-1]) < 1e-12
    assert np.all(angle == np.arctan(SLOPE))


@pytest.mark.parametrize("pressure", extensions.PRESSURES)
def test_wear_out_is_that_of_plesha(pressure: float) -> None:
    """About half a cycle more than by Plesha's law: the first strokes break the bond and wear less."""
    slips, ours, plesha = extensions.shares(pressure)
    found, expected = (extensions.wear_out(share, slips) for share in (ours, plesha))
    assert 0.0 < found - expected < 0.6
    # worn asperities slide at mu |sigma_N|: the work of a cycle is 4 a mu |sigma_N|, half of it on each facet
    work = 2.0 * extensions.AMPLITUDE * 0.5 * -pressure / RT.weights[1]
    assert expected == pytest.approx(-np.log(extensions.ROUGH_LEFT) * extensions.SLOW / work, rel=0.2)


# --- warnings -----------------------------------------------------------------------------------------------


def test_wear_against_the_elastic_friction() -> None:
    """The share is (mu sigma_N/gamma)^2/(2 Kt W0) with Kt of mode II; above 0.01 it is a warning."""
    # mu sigma_N/gamma = 1.5, Kt = 150: 0.0075/W0
    assert not doubts(replace(STIFF, W0=0.76), RT, -1.0)
    material = replace(STIFF, W0=0.5)
    with pytest.warns(ModelWarning, match=r"stores 0.015 W0, expected at most 0.01"):
        Interface(material, RT).confined_slip(0.0, [0.001], -1.0)
    [modes, energy] = doubts(replace(material, Gc2=0.6), RT, -1.0)
    assert "rupture may exceed Gc" in modes and "stores 0.03 W0" in energy
    assert not doubts(material, Pattern.regular(0, 0.0), -1.0)


def test_driver_and_python_print_the_same_sentences(tmp_path: Path) -> None:
    """Every warning of a run has the same words and numbers in driver and Python."""
    path = tmp_path / "doubtful.nml"
    path.write_text(
        "&material sigma0 = 3.0, Gc = 0.3, eta = 0.9, mu = 0.5, Gc2 = 0.4, W0 = 0.5, height = 0.15,"
        " closure = 0.001 /\n&pattern sides = 2, theta = 1.0 /\n"
        "&step t_N = -10.0, increments = 20 /\n&step slip = 0.05, increments = 20 /\n"
    )
    done = subprocess.run([driver(), path], cwd=tmp_path, capture_output=True, text=True, check=True)
    printed = [line.partition("warning: ")[2] for line in done.stderr.splitlines() if "warning: " in line]
    with pytest.warns(ModelWarning) as caught:
        read_case(path).runs[0].history()
    assert printed == [str(one.message) for one in caught]
    assert [text for text in printed if "0.995025 of the largest closure Vm, expected at most 0.99" in text]
    assert "increment of slip in an FE code: expected at most W0/(mu z dp/dc)" in done.stderr


def test_wear_runs_away_only_beyond_the_limit() -> None:
    """Below the limit the traction has no jump; far above it a facet wears off in one."""
    for W0, jumps in ((2.0, False), (0.05, True)):
        joint = Interface(replace(STIFF, W0=W0), RT)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ModelWarning)
            tau = joint.confined_slip(0.0, path(0.4, step=0.0005), PRESSURE).traction[:, 1]
        assert (-np.diff(tau).min() > 0.1 * tau.max()) == jumps


def test_shared_pressure_wears_in_jumps() -> None:
    """Two facets that a slip climbs at once wear in jumps where a warning says so; opposite ones do not."""
    cases = ((4, 45.0, 20.0, False), (4, 45.0, 3.75, True), (2, 0.0, 0.94, False))
    for sides, direction, W0, jumps in cases:
        pattern = Pattern.regular(sides, 30.0)
        joint = Interface(replace(STIFF, height=0.5, W0=W0), pattern)
        found = doubts(joint.material, pattern, -1.0, slip=0.6)
        slips = np.linspace(0.0, 0.6, 601)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ModelWarning)
            test = joint.confined_slip(direction, slips, -1.0)
        tau = np.hypot(*test.traction[:, 1:].T)
        assert (-np.diff(tau).min() > 0.05 * tau.max()) == jumps
        assert any("share the pressure" in text for text in found) == jumps


def test_locking_with_a_height_is_no_objection() -> None:
    """A steep joint locks, with a height it does not."""
    assert "locks" in doubts(LOCKING, STEEP_RT)[0]
    assert not doubts(replace(LOCKING, height=0.2), STEEP_RT)


# --- fit ----------------------------------------------------------------------------------------------------


def slip_tests_of(material: Material, slips: np.ndarray, sides: int = 8) -> list[ShearTest]:
    """Slip tests without noise."""
    joint = Interface(material, Pattern.regular(sides, 25.0))
    found = []
    for sigma_N in (-1.0, -2.0):
        history = joint.confined_slip(0.0, slips, sigma_N, 50)
        s_N = history.separation[:, 0] - history.separation[0, 0]
        found.append(ShearTest(f"{sigma_N:g}", slips[1:], history.traction[1:, 1], s_N[1:], sigma_N))
    return found


@pytest.mark.slow
def test_fit_finds_the_height() -> None:
    """The height of tests without noise is identified with theta; report and case name it."""
    truth = {"theta": 25.0, "height": 0.4}
    tests = slip_tests_of(replace(STIFF, height=0.4), np.linspace(0.0, 0.8, 401))
    found = fit(
        tests,
        free=("theta", "height"),
        fixed={"sigma0": 3.0, "Gc": 0.3, "eta": 0.9, "mu": 0.5, "kc": 100.0},
        start={"theta": 35.0, "height": 1.0},
        starts=1,
    )
    for name, value in truth.items():
        assert found.values[name] == pytest.approx(value, rel=1e-5), name
    assert "height = 0.4" in case_of(found)
    assert "\nheight " in report(found) and "W0" not in report(found)


@pytest.mark.long
def test_fit_finds_the_wear() -> None:
    """W0 of cyclic tests of RT without noise is identified."""
    tests = slip_tests_of(replace(TABLE_2, kc=20.0, W0=4.0), path(0.3, -0.3, 0.3), sides=2)
    found = fit(
        tests,
        free=("W0",),
        fixed={"sigma0": 3.0, "Gc": 0.3, "eta": 0.9, "mu": 0.5, "kc": 20.0, "theta": 25.0},
        start={"W0": 2.0},
        starts=1,
        sides=2,
    )
    # the fit refines its increments, and wear is of first order in them
    assert found.values["W0"] == pytest.approx(4.0, rel=0.01)
    assert "W0 = " in case_of(found)


@pytest.mark.slow
def test_fit_finds_joints_without_bond(tmp_path: Path) -> None:
    """Stiffness, closure and damage from the start are identified; the case has the same constants."""
    slips = np.linspace(0.0, 0.4, 161)
    joint = Material.from_joint(kn=40.0, ks=20.0, mu=0.5, closure=0.02, height=0.3)
    found = fit(
        slip_tests_of(joint, slips),
        free=("ks", "mu", "closure"),
        fixed={"kc": 2.0, "theta": 25.0, "height": 0.3},
        start={"ks": 30.0, "mu": 0.6, "closure": 0.05},
        starts=1,
    )
    for name, value in (("ks", 20.0), ("mu", 0.5), ("closure", 0.02)):
        assert found.values[name] == pytest.approx(value, rel=1e-3), name
    path = tmp_path / "joint.nml"
    path.write_text(case_of(found))
    written = read_case(path).runs[0].material
    for name in ("K", "mu", "kc", "height", "damage0", "closure"):
        assert getattr(written, name) == pytest.approx(getattr(joint, name), rel=1e-3), name
    cracked = Material(3.0, 0.3, 0.9, 0.5, kc=20.0, damage0=0.3)
    found = fit(
        slip_tests_of(cracked, slips),
        free=("damage0",),
        fixed={"sigma0": 3.0, "Gc": 0.3, "mu": 0.5, "kc": 20.0, "theta": 25.0},
        start={"damage0": 0.6},
        starts=1,
    )
    assert found.values["damage0"] == pytest.approx(0.3, rel=1e-3)
    for free, fixed, message in (
        (("ks", "sigma0"), {}, "sigma0: expected without ks"),
        (("mu",), {"ks": 3.0, "Gc": 1.0, "damage0": 0.5, "theta": 2.0}, "Gc, damage0: expected without ks"),
        (("mu",), {"sigma0": 3.0, "Gc": 0.3, "theta": 2.0, "damage0": 1.2}, "damage0 = 1.2: expected 0 to 1"),
    ):
        with pytest.raises(ValueError, match=message):
            fit(slip_tests_of(joint, slips), free=free, fixed=fixed, starts=1)


# --- select -------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_select_with_a_height(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A ridge with a height needs the three planes; PROPS keep the height."""
    case = tmp_path / "case.nml"
    case.write_text(
        "&material sigma0 = 3.0, Gc = 0.3, eta = 0.9, mu = 0.5, kc = 50.0, height = 0.3 /\n"
        "&pattern sides = 4, theta = 30.0 /\n"
        "&step t_N = -2.0, increments = 50 /\n"
        "&step slip = 0.4, increments = 200 /\n",
        encoding="utf-8",
    )
    assert main(["select", str(case), "--planar"]) == 0
    text = capsys.readouterr().out
    assert "reference  RT, the surface itself" in text and "meets it, checked" in text
    [props] = re.findall(r"^PROPS\(\d+\) +(.*)$", text, re.MULTILINE)
    assert float(props.split(",")[contract.index("height")]) == 0.3
    case.write_text(case.read_text(encoding="utf-8").replace("height", "W0 = 4.0, height"), encoding="utf-8")
    assert main(["select", str(case)]) == 1
    assert "W0 = 4: expected 0, or a planar load case" in capsys.readouterr().err
