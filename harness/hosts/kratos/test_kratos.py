"""Kratos' interface elements with libasperity: run by `make hosts`, which installs asperity[kratos] first."""

from __future__ import annotations

import ctypes
import subprocess
import sys
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from asperity import History, Interface, Material, Pattern, library
from asperity.installed import driver, kratos_adapter

pytest.importorskip("KratosMultiphysics.GeoMechanicsApplication", reason="asperity[kratos] is not installed")

sys.path.insert(0, str(Path(__file__).parent.parent))
import blocks
import exported
import KratosMultiphysics
import paraview_check
import triplet
from kratos_model import Floats, Structure

ROUNDING = 1.0e-12
"""Tolerance of tractions, relative to K times the largest separation so far."""

CASE = """&case title = 'one element' /
&material sigma0 = 3.0, Gc = 0.3, eta = 0.9, mu = 0.5, kc = 3.0 /
&pattern sides = {sides}, theta = 30.0 /
&step s_N = -0.01, increments = 4 /
&step s_Tx = 0.08, s_Ty = {s_Ty}, s_N = -0.005, increments = 16 /
&step s_Tx = -0.1, increments = 30 /
&step s_Tx = 0.05, s_N = 0.06, increments = 20 /
&step s_N = 0.002, increments = 10 /
&step s_N = 0.3, s_Tx = 0.3, increments = 20 /
&step s_N = -0.02, s_Tx = -0.1, increments = 30 /
"""
"""Pressing, sliding with a reversal, opening, unloading, complete rupture, closing."""

MATERIAL = Material(sigma0=3.0, Gc=0.3, eta=0.9, mu=0.5, kc=3.0)
STIFFNESS = MATERIAL.kc * MATERIAL.K

CORNERS = np.array([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 3.0, 0.0], [0.0, 3.0, 0.0]])
"""Nodes of one element of 2 x 3; the first two are those of a plane element."""


def one_element(interface: Interface, path: Floats, plane: bool, **umat: object) -> tuple[Floats, Floats]:
    """Tractions (T, 3) of the element and reactions over its area, along prescribed separations (T, 3)."""
    s = Structure(2 if plane else 3)
    corners = CORNERS[:2, :2] if plane else CORNERS
    area = 2.0 if plane else 6.0
    lower, upper = s.add_nodes(corners), s.add_nodes(corners)
    s.add_interface(lower, upper, s.umat(interface, **umat))
    axes = (1, 0) if plane else (2, 0, 1)  # order N, Tx, Ty
    s.fix([*lower, *upper], *axes)
    tractions, reactions = [], []
    for row in path:
        for axis, value in zip(axes, row.tolist(), strict=False):
            s.move(upper, axis, value)
        s.step(0.0)
        separation, traction = s.points()
        assert np.allclose(separation, row, rtol=0, atol=1e-15)
        assert np.array_equal(traction, np.broadcast_to(traction[0], traction.shape))
        tractions.append(traction[0])
        reactions.append(s.reaction(upper)[list(axes)] / area)
    return np.array(tractions), np.array(reactions)


@pytest.fixture(params=[2, 4], ids=["2D RT", "3D RP-4"])
def driven(request: pytest.FixtureRequest, tmp_path: Path) -> tuple[Interface, Floats, Floats, bool]:
    """An interface, the driver's separations and tractions on the case, and whether the element is plane."""
    case = tmp_path / "case.nml"
    plane = request.param == 2
    case.write_text(CASE.format(sides=request.param, s_Ty=0.0 if plane else 0.05))
    subprocess.run([driver(), case, "-o", tmp_path / "out.csv", "--quiet"], check=True)
    rows = History.from_csv(tmp_path / "out.csv")
    assert rows.damage[-1] == 1.0
    return Interface(MATERIAL, Pattern.regular(request.param, 30.0)), rows.separation, rows.traction, plane


def scale(path: Floats) -> Floats:
    """K times the largest separation so far, (T, 1)."""
    return STIFFNESS * np.maximum.accumulate(np.linalg.norm(path, axis=1))[:, None]


def test_one_element_is_the_driver(driven: tuple[Interface, Floats, Floats, bool]) -> None:
    """Tractions and reactions of an element equal the driver's in loading, unloading and cycles."""
    interface, path, expected, plane = driven
    traction, reaction = one_element(interface, path, plane)
    worst = float((np.abs(traction - expected) / scale(path)).max())
    print(f"{len(path)} steps, difference of tractions {worst:.1e} K |s|")
    assert worst <= ROUNDING
    # the reactions are sums over nodes
    assert np.all(np.abs(reaction - expected[:, : reaction.shape[1]]) <= 10 * ROUNDING * scale(path))


def test_exported_element(tmp_path: Path) -> None:
    """The script of `asperity export kratos` shows the rows of the README."""
    exported.element("kratos", tmp_path / "kit")
    script = [sys.executable, tmp_path / "kit" / "single.py"]
    done = subprocess.run(script, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert len(done.stdout.split("expected\n")[-1].splitlines()) == 5


def test_without_the_adapter_damage_heals(driven: tuple[Interface, Floats, Floats, bool]) -> None:
    """Smallest case of an error of Kratos: every step starts from the virgin state.

    The tractions are those of a virgin point at the separation of the step; earlier steps have no effect.
    """
    interface, path, expected, plane = driven
    traction, _ = one_element(interface, path, plane, UDSM_NAME=str(library()))
    virgin = interface.update(path).traction
    assert np.all(np.abs(traction - virgin) <= ROUNDING * scale(path))
    worst = float(np.abs(traction - expected).max())
    print(f"without the adapter tractions are wrong by up to {worst:.2f}, sigma0 is {MATERIAL.sigma0:g}")
    assert worst > MATERIAL.sigma0


def test_another_law_swaps_normal_and_shear() -> None:
    """Smallest case of a wrong pair: a new element with the law of the older ones gives a wrong result.

    The traction of an opening is that of a slip along t.
    """
    s = Structure(3)
    lower, upper = s.add_nodes(CORNERS), s.add_nodes(CORNERS)
    interface = Interface(MATERIAL, Pattern.regular(4, 30.0))
    s.add_interface(lower, upper, s.umat(interface, law="SmallStrainUMAT3DInterfaceLaw"))
    s.fix([*lower, *upper], 0, 1, 2)
    s.move(upper, 2, 0.05)
    s.step(0.0)
    separation, traction = s.points()
    right, shear = interface.update([separation[0], [0.0, 0.0, 0.05]]).traction
    assert separation[0] == pytest.approx([0.05, 0.0, 0.0], abs=1e-15)
    print(f"opening 0.05: t_N = {traction[0, 0]:.3f}, expected {right[0]:.3f}, slip 0.05: {shear[2]:.3f}")
    assert traction[0] == pytest.approx(shear[[2, 1, 0]], abs=1e-12)
    assert abs(traction[0, 0] - right[0]) > 0.1 * MATERIAL.sigma0


def test_the_axes_do_not_turn() -> None:
    """A sheared joint that is turned by 90 degrees opens for Kratos, even where the mesh moves."""
    s = Structure(2)
    lower, upper = s.add_nodes(CORNERS[:2, :2]), s.add_nodes(CORNERS[:2, :2])
    s.add_interface(lower, upper, s.umat(Interface(MATERIAL, Pattern.regular(2, 30.0))))
    s.fix([*lower, *upper], 0, 1)
    s.solver().SetMoveMeshFlag(True)
    slip = np.array([0.08, 0.0])
    for turn in (np.eye(2), np.array([[0.0, -1.0], [1.0, 0.0]])):
        for nodes, jump in ((lower, 0.0 * slip), (upper, slip)):
            for node, place in zip(nodes, CORNERS[:2, :2], strict=True):
                for axis, value in enumerate((turn @ (place + jump) - place).tolist()):
                    s.move([node], axis, value)
        s.step(0.0)
        # N is y and Tx is x, before and after
        assert s.points()[0] == pytest.approx(np.tile([*(turn @ slip)[::-1], 0.0], (2, 1)), abs=1e-12)


@pytest.mark.parametrize("drainage", ["drained", "undrained", "fully_coupled", "constant_pw_field"])
def test_rows_of_the_water_pressure(drainage: str) -> None:
    """Only a constant water pressure, which the card sets, leaves no 0/0 in the rows of the water pressure.

    With a Biot coefficient of 0, which it has too, Kratos would write over them.
    """
    s = Structure(3)
    lower, upper = s.add_nodes(CORNERS), s.add_nodes(CORNERS)
    interface = Interface(MATERIAL, Pattern.regular(4, 30.0))
    rough = s.umat(interface, GEO_DRAINAGE_TYPE=drainage, BIOT_COEFFICIENT=None)
    s.add_interface(lower, upper, rough)
    s.fix([*lower, *upper], 0, 1, 2)
    s.step(0.0)
    assert np.isnan(s.matrix_values()).any() == (drainage != "constant_pw_field")


def test_properties_are_written_while_elements_start() -> None:
    """Kratos replaces IGNORE_UNDRAINED in properties that all elements share, in a loop over threads.

    A second thread may read the value meanwhile, and then some runs are fully coupled. With the card there is
    nothing to replace.
    """
    interface = Interface(MATERIAL, Pattern.regular(2, 30.0))
    written = []
    for given in ({"IGNORE_UNDRAINED": True, "GEO_DRAINAGE_TYPE": None}, {}):
        s = Structure(2)
        lower, upper = s.add_nodes(CORNERS[:2, :2]), s.add_nodes(CORNERS[:2, :2])
        properties = s.umat(interface, **given)
        s.add_interface(lower, upper, properties)
        s.fix([*lower, *upper], 0, 1)
        before = str(properties)
        s.step(0.0)
        written.append(str(properties) != before)
    assert written == [True, False]


@pytest.mark.parametrize("biot", [1.0, 0.0])
def test_a_held_node_under_an_open_joint(biot: float) -> None:
    """If a block is torn off fixed nodes that only an interface has, Kratos leaves a column without entries.

    It sets the diagonal of rows without entries, and then drops the coupling with the fixed water pressure,
    the only entry there. The coupling is the Biot coefficient: 1 where none is set; the card has 0.
    """
    s = Structure(2)
    base, bottom, top = (s.add_nodes(np.array([[0.0, y], [1.0, y]])) for y in (0.0, 0.0, 1.0))
    rough = s.umat(Interface(MATERIAL, Pattern.regular(2, 30.0)), BIOT_COEFFICIENT=biot)
    s.add_solid([*bottom, *top[::-1]], s.elastic(3000.0, 0.2))
    s.add_interface(base, bottom, rough)
    s.fix([*base, *top], 0, 1)
    s.move(top, 1, 1.0)
    if biot == 1.0:
        with pytest.raises(RuntimeError, match="STRUCTURALLY SINGULAR"):
            s.step(1e-10)
        return
    s.step(1e-10)
    # the residual is 1e-10 N, as a root mean square over four free components
    assert s.reaction(top) == pytest.approx([0.0, 0.0], abs=1e-9)
    assert s.points()[0] == pytest.approx(np.array([[1.0, 0.0, 0.0]] * 2), abs=1e-9)


def test_analyses_in_one_process() -> None:
    """Analyses one after the other are independent, although addresses are used again."""
    path = np.array([[0.0, 0.05, 0.0], [0.1, 0.0, 0.0], [0.01, 0.01, 0.0]])
    for sides in (4, 64, 2, 4):
        interface = Interface(MATERIAL, Pattern.regular(sides, 30.0))
        expected = interface.replay(path).traction
        traction, _ = one_element(interface, path, False)
        assert np.all(np.abs(traction - expected) <= ROUNDING * scale(path))


def test_a_step_solved_again_starts_from_the_same_state() -> None:
    """A step that is too large and is repeated with a smaller one, as after a cut, has no effect."""
    s = Structure(3)
    lower, upper = s.add_nodes(CORNERS), s.add_nodes(CORNERS)
    interface = Interface(MATERIAL, Pattern.regular(4, 30.0))
    s.add_interface(lower, upper, s.umat(interface))
    s.fix([*lower, *upper], 0, 1, 2)
    tried = [(0.04, False), (0.2, False), (0.06, True), (0.01, False)]
    for opening, again in tried:
        s.move(upper, 2, opening)
        s.step(0.0, again)
    path = np.array([[0.04, 0.0, 0.0], [0.06, 0.0, 0.0], [0.01, 0.0, 0.0]])
    expected = interface.replay(path).traction[-1]
    assert s.points()[1][0] == pytest.approx(expected, abs=ROUNDING * STIFFNESS * 0.06)


def assert_law_is_kept(interface: Interface, separation: Floats, traction: Floats, tolerance: float) -> None:
    """Every interface point has the tractions of the library on the history of its own separations."""
    for path, found in zip(separation.transpose(1, 0, 2), traction.transpose(1, 0, 2), strict=True):
        expected = interface.replay(path).traction
        assert np.abs(found - expected).max() <= tolerance


def test_blocks_converge_quadratically() -> None:
    """Two blocks in shear under compression: convergence of Newton, and cost of a symmetrised tangent."""
    norms, separation, traction = blocks.run()
    assert_law_is_kept(blocks.ROUGH, separation, traction, 1e-12)
    assert np.ptp(separation[-1, :, 0]) > 0.01  # the structure differs from a material point
    quadratic = 0
    for step, found in enumerate(norms):
        ratios = [b / a**2 for a, b in pairwise(found)]
        print(
            f"step {step + 1}:", *(f"{norm:.1e}" for norm in found), " ratios", *(f"{r:.1e}" for r in ratios)
        )
        # the last residual is a rounding error of reactions of some N
        quadratic += sum(ratio < 100.0 for ratio, norm in zip(ratios, found[1:], strict=True) if norm > 1e-15)
    assert quadratic >= 10
    assert max(map(len, norms)) <= 6

    adapter = ctypes.CDLL(str(kratos_adapter()))
    assert adapter.asperity_kratos_symmetrise(1) == 0
    try:
        slow, same, _ = blocks.run()
    finally:
        adapter.asperity_kratos_symmetrise(0)
    counts = [sum(map(len, n)) for n in (norms, slow)]
    print(f"iterations: {counts[0]} with the consistent tangent, {counts[1]} with its symmetric part")
    assert np.allclose(same, separation, rtol=0, atol=1e-8)  # slower, with the same result
    assert counts[1] > 2 * counts[0]


def test_two_threads() -> None:
    """The adapter separates its points if two threads of Kratos call it; `kratos_model` sets one thread."""
    utilities = KratosMultiphysics.ParallelUtilities
    assert utilities.GetNumThreads() == 1
    _, expected, _ = blocks.run(2)
    utilities.SetNumThreads(2)
    try:
        assert utilities.GetNumThreads() == 2
        _, separation, traction = blocks.run(2)
    finally:
        utilities.SetNumThreads(1)
    assert_law_is_kept(blocks.ROUGH, separation, traction, 1e-12)
    # The sums of a node have another order, and Newton's iterations end at a residual of 1e-10 N.
    assert np.allclose(separation, expected, rtol=0, atol=1e-10)


def test_triplet(tmp_path: Path) -> None:
    """In the cyclic shear of a triplet every point follows the law; strength and dilation are predicted.

    The files for ParaView have the tractions of Kratos and the damage and energies of the law.
    """
    result = triplet.run([0.3, -0.3, 0.3], 0.01, nx=12, ny=3)
    assert_law_is_kept(triplet.JOINT, result.separation, result.traction, 1e-11)
    assert max(map(len, result.norms)) <= 10
    theta, sliding = np.radians(10.0), 2.0 * triplet.LENGTH * triplet.PRESSURE
    up = sliding * triplet.JOINT.material.residual_strength(10.0)
    print(f"residual force {result.force[-1]:.3f} N, closed form of a facing plane {up:.3f} N")
    assert result.force[-1] == pytest.approx(up, rel=1e-3)
    rise = result.rise[-1] - result.rise[triplet.PRELOAD_STEPS - 1]
    slope = (result.rise[-1] - result.rise[-6]) / (result.slip[-1] - result.slip[-6])
    print(f"rise {rise:.4f} mm, its slope {slope:.4f}, of two facing planes {2.0 * np.tan(theta):.4f}")
    assert slope == pytest.approx(2.0 * np.tan(theta), rel=2e-2)
    # The joint does not break everywhere at once, so its peak is below that of one material point.
    force, _ = triplet.prediction(result.slip[triplet.PRELOAD_STEPS :])
    assert 0.8 * force.max() < result.force.max() < 0.99 * force.max()

    triplet.write_paraview(tmp_path / "triplet.pvd", result)
    found = paraview_check.against_the_law(tmp_path / "triplet.pvd", triplet.JOINT, ROUNDING)
    assert np.array_equal(found["separation"], result.separation)
    assert np.array_equal(found["traction"], result.traction)
    paraview_check.places(tmp_path / "triplet.pvd", 2, up=1, away=0.25 + 1e-9)  # points at the nodes
