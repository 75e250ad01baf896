"""Kratos' interface elements with libasperity: run by `make hosts`, which installs asperity[kratos] first."""

from __future__ import annotations

import subprocess
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from asperity import History, Interface, Material, Pattern, library
from asperity.installed import driver

pytest.importorskip("KratosMultiphysics.GeoMechanicsApplication", reason="asperity[kratos] is not installed")

import exported
import KratosMultiphysics
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

ROUGH = Interface(Material(sigma0=3.0, Gc=0.3, eta=0.9, mu=0.5, kc=20.0), Pattern.regular(4, theta=20.0))
"""Joint of the sheared block, in mm, N, MPa."""

NEWTON = 1.0e-10
"""Accepted residual force of the sheared block, N; the reactions are some N."""

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
    exported.assert_script("kratos", tmp_path)


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


def sheared_block(n: int = 3, threads: int = 1) -> tuple[list[list[float]], Floats, Floats]:
    """A cube of n x n x n elements is pressed on a rough base, then sheared and turned at its top.

    Returns the norms of Newton's iterations of each step, separations and tractions (steps, points, 3).
    """
    s, axis = Structure(3), np.linspace(0.0, 1.0, n + 1)
    solid, rough = s.elastic(3000.0, 0.2), s.umat(ROUGH)
    base, cube = (
        s.add_nodes(np.stack(np.meshgrid(axis, axis, z, indexing="ij"), axis=-1)) for z in (axis[:1], axis)
    )
    around = ((0, 0), (1, 0), (1, 1), (0, 1))
    for i, j in np.ndindex(n, n):
        for k in range(n):
            s.add_solid([cube[i + a, j + b, k + c] for c in (0, 1) for a, b in around], solid)
        s.add_interface(*([side[i + a, j + b, 0] for a, b in around] for side in (base, cube)), rough)
    top = cube[:, :, -1]
    s.fix(np.append(base, top), 0, 1, 2)
    norms, points = [], []
    KratosMultiphysics.ParallelUtilities.SetNumThreads(threads)
    try:
        for slip in (0.0, 0.01, 0.02, 0.04, 0.06, 0.08, 0.1, 0.12, 0.15):
            s.move(top, 0, slip)
            s.move(top, 1, slip / 3.0)
            s.move(top, 2, lambda node, slip=slip: -0.01 + 0.3 * slip * (node.X0 - 0.3))
            norms.append(s.step(NEWTON))
            points.append(s.points())
    finally:
        KratosMultiphysics.ParallelUtilities.SetNumThreads(1)
    separation, traction = (np.array(values) for values in zip(*points, strict=True))
    for path, found in zip(separation.transpose(1, 0, 2), traction.transpose(1, 0, 2), strict=True):
        assert np.abs(found - ROUGH.replay(path).traction).max() <= 1e-12
    return norms, separation, traction


def test_newton_is_quadratic() -> None:
    """Every point has the law on its own history, and the consistent tangent makes Newton quadratic."""
    norms, separation, _ = sheared_block()
    assert np.ptp(separation[-1, :, 0]) > 0.01  # the structure differs from a material point
    pairs = [(before, after) for found in norms for before, after in pairwise(found)]
    print("largest norms of the steps:", *(f"{len(found)}: {found[-1]:.1e}" for found in norms))
    # the last residual is a rounding error of reactions of some N
    assert sum(after < 100.0 * before**2 for before, after in pairs if after > 1e-15) >= 10
    assert max(map(len, norms)) <= 6


def test_two_threads() -> None:
    """The adapter separates its points if two threads of Kratos call it; `kratos_model` sets one thread."""
    assert KratosMultiphysics.ParallelUtilities.GetNumThreads() == 1
    _, expected, _ = sheared_block(2)
    _, separation, _ = sheared_block(2, threads=2)
    # The sums of a node have another order, and Newton's iterations end at a residual of 1e-10 N.
    assert np.allclose(separation, expected, rtol=0, atol=1e-10)
