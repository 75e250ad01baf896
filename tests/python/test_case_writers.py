"""What a command writes as a case, the driver, `asperity card` and `asperity export` take."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from asperity import Interface, Material, Pattern, contract, read_case
from asperity.case_writer import entries_of, props_line
from asperity.cli import main

BOND = "kn=82 ks=36 ft=.25 GfI=.018 c=.35 GfII=.125"
DAM = "kn=2e4 ks=1e4 ft=.3 GfI=.1 c=.9 GfII=.5"
ENVELOPE = "barton --jrc 10 --sigma-n 2,.5"
"""Values are doubted before the stresses are refused, whose order is wrong; a fit would take seconds."""
BARTON = "--jrc 10 --jcs 80 --phi-r 28 --length 0.1"
CASE = """&material sigma0 = 3.0, Gc = 0.3, eta = 0.9, mu = 0.5, kc = 20.0 /
&pattern sides = 4, theta = 10.0 /
&step t_N = -1.0, increments = 10 /
&step slip = 0.2, increments = 20 /
"""

WRITERS = {
    "new": "new -o case.nml",
    "new, no friction": "new mu=0 sides=0 -o case.nml",
    "new, no bond": "new kn=50 ks=20 mu=0.6 closure=0.1 -o case.nml",
    "new, all of it": "new height=0.1 W0=2 crush=0.3 theta=20 sides=6 turn=5 -o case.nml",
    "joint": f"joint {BOND} tan_phi=.75 -o case.nml",
    "joint, no friction": f"joint {BOND} tan_phi=0 -o case.nml",
    "joint, all friction by dilatancy": f"joint {BOND} tan_phi=.2 tan_psi=.2 delta=5 -o case.nml",
    "joint, angles, no pressure": f"joint {DAM} phi=45 psi=5 --sigma-N 0 -o case.nml",
    "joint, no friction, pressure": f"joint {BOND} tan_phi=0 --sigma-N=-0.3 -o case.nml",
    "barton": f"barton {BARTON} --sigma-n 0.5,2 -o case.nml",
    "select": "select old.nml --tolerance 0.5 -o case.nml",
    "surface": "surface scan.csv --spacing 1 --case old.nml -o case",
    "fit, strengths": "fit peaks.csv -o case.nml",
    "fit, strengths, no friction": "fit peaks.csv --set mu=0 -o case.nml",
    "fit, rock": "fit rock.csv -o case.nml",
    "fit, mortar": "fit mortar.csv -o case.nml",
    "fit, no friction": "fit rock.csv --set mu=0 -o case.nml",
}
"""Commands that write case.nml."""


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Current folder with the files that the commands read."""
    monkeypatch.chdir(tmp_path)
    Path("old.nml").write_text(CASE, encoding="utf-8")
    x, y = np.meshgrid(np.arange(12), np.arange(12))
    np.savetxt("scan.csv", 0.05 * np.sin(x * 0.9) * np.cos(y * 0.7), delimiter=",")
    Path("peaks.csv").write_text(
        "sigma_N,peak,residual,slip\n0.5,0.62,0.36,5\n1,1.14,0.73,5\n2,1.97,1.4,5\n3,2.6,2.11,5\n"
    )
    Path("rock.csv").write_text(shear_rows(bond=0.0))
    Path("mortar.csv").write_text(shear_rows(bond=0.8))
    return tmp_path


def shear_rows(bond: float) -> str:
    """Two shear tests: friction and a bond that softens along a straight line, behind a spring."""
    rng, rows = np.random.default_rng(3), ["test,slip,tau,sigma_N"]
    for pressure in (0.5, 1.5):
        for slip in np.linspace(0.02, 1.0, 50):
            strength = 0.7 * pressure + bond * max(0.0, 1.0 - slip / 0.3)
            tau = min(40.0 * slip, strength) + rng.normal(0.0, 0.01)
            rows.append(f"{pressure},{slip:.4g},{tau:.5g},{pressure}")
    return "\n".join(rows) + "\n"


@pytest.mark.slow
@pytest.mark.parametrize("name", WRITERS)
def test_cases_are_taken(name: str, said: Callable, monkeypatch: pytest.MonkeyPatch) -> None:
    """Run, card and export take the case; it has friction, and a sweep value for each of its tractions."""
    # the picture beside the case of a scan takes a second and is looked at elsewhere
    monkeypatch.setattr("asperity.tools.surface.picture.draw", lambda *_: None)
    said(WRITERS[name])
    assert main(["run", "case.nml", "--quiet", "-o", "rows.csv"]) == 0
    assert main(["card", "abaqus", "case.nml"]) == 0
    for run in read_case("case.nml").runs:
        value = [] if run.value is None else [f"--value={run.value:.10g}"]
        folder = f"kit{0.0 if run.value is None else run.value:g}"
        assert main(["export", "abaqus", folder, "--case", "case.nml", *value]) == 0


def test_case_of_a_normal_stiffness(said: Callable) -> None:
    """A case under a constant normal stiffness runs; what needs a constant traction names k_N."""
    said("fit rock.csv --k-N 3 -o case.nml")
    assert main(["run", "case.nml", "--quiet", "-o", "rows.csv"]) == 0
    assert main(["card", "abaqus", "case.nml"]) == 0
    for command in ("export abaqus kit --value=-0.5 --case", "select"):
        assert "k_N = 3, a constant normal stiffness" in said(f"{command} case.nml", 1)[1]


def test_names_of_cases(said: Callable) -> None:
    """The cases of the package have their names in all commands; a case is no value of a new one."""
    assert "*Depvar" in said("card abaqus rough_joint")[0]
    with pytest.raises(SystemExit, match="2"):
        main(["card", "abaqus", "rough_jiont"])
    assert "case.nml: expected NAME=VALUE, or -o case.nml" in said("new case.nml", 1)[1]


@pytest.mark.parametrize(
    ("command", "message"),
    [
        (f"joint {BOND} tan_phi=36.9", "tan_phi = 36.9: expected a tangent; that of 36.9 degrees is 0.751"),
        (f"joint {BOND} phi=.64", "phi = 0.64: expected degrees; 0.64 radians are 36.7 degrees"),
        (f"joint {BOND.replace('.018', '18')} tan_phi=.75", "GfI = 18: the bond breaks at a separation"),
        (f"{ENVELOPE} --jcs 80 --phi-r .52 --length .1", "phi_r = 0.52: expected degrees; 0.52 radians"),
        (f"{ENVELOPE} --jcs 50000 --phi-r 28 --length .1", "JCS = 50000: expected MPa; 50000 kPa are 50"),
        (f"{ENVELOPE} --jcs 80 --phi-r 28 --length 100", "length = 100: expected m; 100 mm are 0.1 m"),
        ("new mu=27 sides=0", "mu = 27: expected a tangent; that of 27 degrees is 0.51"),
    ],
)
def test_doubtful_values(command: str, message: str, capfd: pytest.CaptureFixture[str]) -> None:
    """A value that is probably in another unit gives a warning that names the unit meant."""
    code = main(command.split())
    assert code in (0, 1) and message in capfd.readouterr().err


def test_angles(said: Callable) -> None:
    """Angles in degrees stand for their tangents; both at once, and no angle, are refused."""
    by_angle, by_tangent = (said(f"joint {BOND} {option}")[0] for option in ("phi=45", "tan_phi=1"))
    assert by_angle == by_tangent
    assert "phi = 45: expected without tan_phi" in said(f"joint {BOND} phi=45 tan_phi=1", 1)[1]
    assert "phi = 90: expected degrees, >= 0 and < 90" in said(f"joint {BOND} phi=90", 1)[1]


@pytest.mark.parametrize("adhesion", [0.5, 1.0e-3])
def test_cohesion_that_never_softens(adhesion: float, said: Callable, folder: Path) -> None:
    """Under pressure the shear traction is K_T s0 + mu p (1 - s0/s) at any slip s, in opening adhesion/mu."""
    K_N, K_T, mu, pressure = 300.0, 120.0, 0.6, 0.8
    words = f"joint K_N={K_N} K_T={K_T} mu={mu} adhesion={adhesion} --sigma-N -{pressure} -o case.nml"
    out, _ = said(words)
    joint = read_case(folder / "case.nml").runs[0].interface
    s0 = adhesion / K_T
    slips = s0 * np.linspace(0.0, 1000.0, 20001)
    # the bond loses 1e-6 of its strength until then, and friction sticks within mu p/K_T
    history = joint.confined_slip(0.0, slips, sigma_N=-pressure)
    late = slips > mu * pressure / K_T + s0
    expected = adhesion + mu * pressure * (1.0 - s0 / slips[late])
    assert history.traction[late, 1] == pytest.approx(expected, rel=1e-5)
    opening = adhesion / mu / K_N * np.array([0.0, 0.5, 1.0, 3.0, 100.0])
    pulled = joint.replay(opening[:, None] * [1.0, 0.0, 0.0]).traction[:, 0]
    assert pulled == pytest.approx(adhesion / mu * np.array([0.0, 0.5, 1.0, 1.0, 1.0]), rel=1e-6)
    assert f"{adhesion + mu * pressure:.5g}" in out.splitlines()[-3]
    for bad, message in (
        ("K_N=1 mu=1 adhesion=1", "K_T is missing"),
        ("K_N=1 K_T=1 mu=0 adhesion=1", "mu = 0"),
    ):
        assert message in said(f"joint {bad}", 1)[1]
    assert (
        "ft = 1: expected one of K_N, K_T, mu, adhesion"
        in said("joint K_N=1 K_T=1 mu=1 adhesion=1 ft=1", 1)[1]
    )


@pytest.mark.parametrize("lost", [2.34e-9, 1.0e-3, 0.3])
def test_digits_of_eta(lost: float) -> None:
    """The stiffness of a joint that is written is that of the joint: 1 - eta keeps its digits."""
    material = Material(3.0, 0.3, 1.0 - lost, 0.5)
    written = entries_of(material.values())
    assert Material(**written).K == pytest.approx(material.K, rel=1e-6)
    eta = contract.index("eta")
    line = props_line(Interface(material, Pattern.regular(0, 0.0)).props())
    assert 1.0 - float(line.split("   ")[1].split(", ")[eta]) == pytest.approx(lost, rel=1e-4)
