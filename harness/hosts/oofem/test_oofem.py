"""OOFEM with the UMAT of libasperity: run by `make hosts`, which installs its packages first."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from asperity import Interface, Material, Pattern, hosts
from asperity.contract import Floats
from asperity.export.element import Element
from asperity.export.kits import filled

pytest.importorskip("oofem", reason="oofem is not installed")

import exported

HERE = Path(__file__).parent
MATERIAL = Material(sigma0=3.0, Gc=0.3, eta=0.9, mu=0.5)
PRESSURE, THICKNESS, PRELOAD_STEPS = 1.0, hosts.of("oofem", "kit").options["h"], 10
PATH = f"""&material sigma0 = 3.0, Gc = 0.3, eta = 0.9, mu = 0.5 /
&pattern sides = 2, theta = 30.0 /
&step t_N = {-PRESSURE}, increments = {PRELOAD_STEPS} /
&step slip = 0.6, increments = 240 /
"""
AT = [2, 4, 3]
"""Positions of N, Tx, Ty among 33, 13, 23 in OOFEM's order 11, 22, 33, 23, 13, 12."""

ROUNDING = 1.0e-13
"""Difference of the law from itself, over strength and s_f."""

CONVERGED = 1.0e-7
"""Difference from the driver, over strength and s_f, with the relative residual 1e-8 of OOFEM."""


@dataclass(frozen=True)
class Run:
    """A run: exit code, messages; separation and traction (T, points, 3), state (T, points, nstatv)."""

    code: int
    errors: str
    separation: Floats
    traction: Floats
    state: Floats


def box(folder: Path, card: str) -> Run:
    """Run the input of the kit with the material of a card."""
    (folder / "box.nml").write_text(PATH, encoding="utf-8")
    text = filled("oofem", Element.of_case(folder / "box.nml"), card)
    (folder / "box.in").write_text(text, encoding="utf-8")
    command = [sys.executable, HERE / "kit" / "oofem_run.py", "box.in", "box.npz"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    rows = np.load(folder / "box.npz")
    separation, traction = THICKNESS * rows["strain"][..., AT], rows["stress"][..., AT]
    return Run(done.returncode, done.stderr, separation, traction, rows["state"])


@pytest.mark.parametrize("sides", [0, 2, 4, 7])
def test_shear_box(sides: int, tmp_path: Path) -> None:
    """Every point has the law on its own history; the path at constant pressure is that of the driver."""
    joint = Interface(MATERIAL, Pattern.regular(sides, 30.0))
    run = box(tmp_path, joint.card("oofem", h=THICKNESS))
    print(run.errors.splitlines()[-1])
    assert run.code == 0, run.errors
    exported.assert_law(joint, ROUNDING, run.separation, run.traction, run.state)
    separation = run.separation[PRELOAD_STEPS:].mean(axis=1)
    driver = joint.confined_slip(0.0, separation[:, 1], -PRESSURE)
    rise = np.abs(separation[:, 0] - driver.separation[:, 0]).max()
    shear = np.abs(run.traction[PRELOAD_STEPS:, :, 1].mean(axis=1) - driver.traction[:, 1]).max()
    print(
        f"{len(separation)} steps: difference from the driver of rise {rise:.1e} mm, of shear {shear:.1e} MPa"
    )
    # the layer tilts a little, as its side faces are free, so that its points are not quite equal
    tilt = np.ptp(run.separation[..., 0], axis=1).max()
    assert tilt <= THICKNESS and np.abs(separation[-1, 0] - driver.separation[-1, 0]) <= 1e-5 * MATERIAL.s_f
    assert rise <= tilt + CONVERGED * MATERIAL.s_f
    assert shear <= MATERIAL.K * tilt + CONVERGED * MATERIAL.sigma0


def test_exported_element(tmp_path: Path) -> None:
    """The input of `asperity export oofem` gives the rows of the README, though a step has not converged."""
    cell, steps = exported.element("oofem", tmp_path / "kit")
    script = [sys.executable, "oofem_run.py", "single.in", "single.npz"]
    subprocess.run(script, cwd=tmp_path / "kit", capture_output=True, check=False)
    results = np.load(tmp_path / "kit" / "single.npz")
    moved = results["displacement"][steps, 4:].mean(axis=1)[:, [0, 2]]
    columns = moved, results["stress"][steps, :, 4].mean(axis=1), results["state"][steps, :, 0].mean(axis=1)
    exported.assert_same(cell, np.column_stack(columns), 1e-6)


def test_rejected_call(tmp_path: Path) -> None:
    """A rejected call: the reason on standard error, NaN, and an end with an error by oofem_run.

    OOFEM itself reports equilibrium for NaN and goes on.
    """
    card = Interface(MATERIAL, Pattern.regular(2, 30.0)).card("oofem", h=THICKNESS)
    run = box(tmp_path, card.replace("0.9 0.5 30.0", "0.9 -0.5 30.0"))
    assert "PROPS(4) mu = -0.5: expected >= 0" in run.errors
    assert np.isnan(run.traction).all()
    assert run.code == 1 and "step 1: not converged, although OOFEM reports equilibrium" in run.errors


def test_a_step_that_has_not_converged_is_accepted(tmp_path: Path) -> None:
    """Smallest case of an error of OOFEM: Newton alternates between two states, and the run goes on."""
    stiff = Material(sigma0=3.0, Gc=0.3, eta=0.9, mu=0.5, kc=20.0)
    run = box(tmp_path, Interface(stiff, Pattern.regular(2, 30.0)).card("oofem", h=THICKNESS))
    assert "Equilibrium reached" in (tmp_path / "box.log").read_text(encoding="utf-8")
    assert (
        run.code == 1
        and "not converged, although OOFEM reports equilibrium after 100 iterations" in run.errors
    )
    assert len(run.traction) == 251
