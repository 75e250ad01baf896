"""Constants as people have them: joints without bond by kn and ks, masonry joints."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from asperity import Interface, Material, Pattern, Step, read_case

CONSTANTS = dict(kn=82.0, ks=36.0, ft=0.25, GfI=0.018, c=0.35, GfII=0.125, tan_phi=0.75)
JOINT = "kn=82 ks=36 ft=.25 GfI=.018 c=.35 GfII=.125 tan_phi=.75"


@pytest.mark.filterwarnings("ignore::asperity.ModelWarning")
def test_masonry() -> None:
    """Strengths in both modes, residual strength, and with a dilatancy the same one up its slope."""
    flat = Interface(Material.from_masonry(**CONSTANTS), Pattern.regular(0, 0.0))
    opened = flat.run(Step(s_N=0.2, increments=2000))
    assert opened.traction[:, 0].max() == pytest.approx(0.25, rel=1e-3)
    assert opened.traction[0, 0] == pytest.approx(82.0 * 1e-4, rel=1e-9)
    assert opened.work[-1] == pytest.approx(0.018, rel=1e-3)
    slid = flat.confined_slip(0.0, np.linspace(0.0, 1.0, 1001)[1:], -0.3)
    assert slid.traction[:, 1].max() == pytest.approx(0.504, abs=6e-4)
    assert slid.traction[-1, 1] == pytest.approx(0.75 * 0.3, rel=1e-6)
    rough = Material.from_masonry(**CONSTANTS, tan_psi=0.2)
    assert rough.residual_strength(np.degrees(np.arctan(0.2))) == pytest.approx(0.75, rel=1e-12)


def numbers_of(out: str) -> list[list[float]]:
    """Rows of the table of peaks."""
    return [[float(x) for x in line.split()] for line in out.splitlines() if line.strip().startswith("-")]


@pytest.mark.parametrize("form", ["-0.3,-1.21", "-0.3 -1.21", "-0.3, -1.21"])
def test_dilatancy_of_masonry_decays(form: str, said: Callable) -> None:
    """The slope of the dilation is tan_psi exp(-delta slip), from the group that the command prints."""
    out, _ = said(f"joint {JOINT} tan_psi=.2 delta=5 --sigma-N {form}")
    assert [row[0] for row in numbers_of(out)] == [-0.3, -1.21]
    entries = dict(re.findall(r"(\w+) = ([\d.]+)", out.split("\n\n")[0]))
    assert float(entries["height"]) == pytest.approx(0.2 / 5.0)
    material = Material.from_masonry(**CONSTANTS, tan_psi=0.2, delta=5.0)
    assert material.mu == pytest.approx(float(entries["mu"])) and material.height == pytest.approx(0.04)
    pattern = Pattern.regular(2, float(entries["theta"]), float(entries["flat"]))
    stiff = Interface(replace(material, kc=1e4, damage0=1.0), pattern)
    slips = np.linspace(0.0, 0.4, 401)
    test = stiff.confined_slip(0.0, slips, -0.3)
    dilation = np.diff(test.separation[:, 0])[100:] / np.diff(slips)[100:]
    middle = 0.5 * (slips[1:] + slips[:-1])[100:]
    # the contact sticks over the first slips and closes by 1e-6
    np.testing.assert_allclose(dilation, 0.2 * np.exp(-5.0 * middle), rtol=0.05)


@pytest.mark.usefixtures("folder")
def test_command_masonry(said: Callable) -> None:
    """The command prints constants, stiffness, peaks and the sigma02 that meets c + mu p."""
    out, _ = said(f"joint {JOINT} --sigma-N=-0.3,-0.05,-1.21004,-2.12 -o joint.nml")
    out = out.replace(",\n ", ",")
    assert "(2 GfII (1 - eta)) = 23.1 and not ks = 36" in out
    assert (
        "sigma0 = 0.25, Gc = 0.018, eta = 0.97882" in out and "kc = 1, sigma02 = 0.35, Gc2 = 0.125 /" in out
    )
    rows = numbers_of(out)
    expected = [[-0.3, 0.504, 0.575], [-0.05, 0.362, 0.388], [-1.21, 1.117, 1.258], [-2.12, 1.760, 1.940]]
    np.testing.assert_allclose([row[:3] for row in rows], expected, rtol=0.0, atol=6e-4)
    assert rows[0][3] == pytest.approx(0.428, abs=1e-3)
    case = read_case("joint.nml")
    # K = sigma0^2/(2 Gc (1 - eta)) feels the last digits of eta
    assert case.runs[0].material.K == pytest.approx(82.0, rel=1e-7)
    assert [run.value for run in case.runs] == [-0.05, -0.3, -1.21004, -2.12]
    # the case runs, is a card and an element whose five rows lie on both sides of the peak
    said("run joint.nml --quiet")
    said("card abaqus joint.nml")
    out, _ = said("export calculix kit --case joint.nml --value=-0.3")
    shown = re.findall(r"^\| \S+ \| \S+ \| (\S+) \|", out.split("---|")[-1], re.MULTILINE)
    forces = [float(force) for force in shown]
    assert len(forces) == 5 and forces[0] < max(forces) > forces[4] > 0.225
    assert max(forces) == pytest.approx(0.504, abs=0.01)


@pytest.mark.usefixtures("folder")
def test_compressive_strength_of_masonry(said: Callable) -> None:
    """The strength of prisms comes into the case; its energy has no default, but a hint in N/mm."""
    out, _ = said(f"joint {JOINT} fm=10.5 Gfc=60 kp=.09 E=16700 h=52 -o prism.nml")
    # joint and unit in series: 1/(1/82 + 52/16700)
    assert "joint and unit in series: K = 65.32" in out and "plus n fm^2/(2 K)" in out
    material = read_case("prism.nml").runs[0].material
    assert (material.fc, material.Gfc, material.Css, material.kp) == (10.5, 60.0, 9.0, 0.09)
    # below 12 MPa 1.6 mm fm (Lourenço 1996)
    assert "with fm in MPa is 16.8 N/mm" in said(f"joint {JOINT} fm=10.5", 1)[1]
    assert "with fm in MPa is 22 N/mm" in said(f"joint {JOINT} fm=19.6", 1)[1]
    for alone in ("Gfc=60", "kp=.1", "fb=9", "fm=0 Gfc=60"):
        assert "expected fm=VALUE beside it" in said(f"joint {JOINT} {alone}", 1)[1]
    for wrong in ("-1", "nan"):
        assert f"fm = {wrong}: expected" in said(f"joint {JOINT} fm={wrong} Gfc=60", 1)[1]
    doubts = said(f"joint {JOINT} fm=10.5 Gfc=1 fb=9 E=16700 h=52")[1]
    assert "fm = 10.5: expected at most fb = 9" in doubts
    assert "Gfc = 1: expected more than fm^2/K = 1.688 of a course" in doubts


BESIDE = [None, "", "x", "1_0", "nan", [], {}, object(), 1j, float("nan"), float("inf"), -1.0, 10**400]


@pytest.mark.parametrize("value", BESIDE, ids=lambda value: repr(value)[:8])
def test_what_is_no_constant(value: object) -> None:
    """Each constant that is no number, or out of range, is named."""
    joint = dict(kn=20.0, ks=5.0, mu=0.6, height=0.2)
    masonry = CONSTANTS | dict(tan_psi=0.1, delta=1.0)
    for made, constants in ((Material.from_joint, joint), (Material.from_masonry, masonry)):
        for name in constants:
            with pytest.raises(ValueError, match=rf"(?m)^{name} = .*: expected"):
                made(**constants | {name: value})


def test_texts_of_constants() -> None:
    """The text of a number, as a table has it, is this number."""
    assert Material(*map(str, (3.0, 0.3, 0.9, 0.5))).s_f == Material(3.0, 0.3, 0.9, 0.5).s_f
    joint = dict(kn=20.0, ks=5.0, mu=0.6, height=0.2)
    masonry = CONSTANTS | dict(tan_psi=0.1, delta=1.0)
    for made, constants in ((Material.from_joint, joint), (Material.from_masonry, masonry)):
        assert made(**{name: str(value) for name, value in constants.items()}) == made(**constants)
