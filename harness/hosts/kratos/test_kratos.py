"""Kratos' interface elements with libasperity: run by `make hosts`, which installs its packages first."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from asperity import Interface, Pattern, library

pytest.importorskip("KratosMultiphysics.GeoMechanicsApplication", reason="kratos is not installed")

import exported
import KratosMultiphysics as Kratos
import meshio
from asperity.mesh import split
from exported import MATERIAL, PLANE, SOLID, STIFFNESS
from kratos_model import Floats, Structure
from structured import QUADRATIC, grid, simplices

ROUNDING = 1.0e-12
"""Tolerance of tractions, relative to K times the largest separation so far."""

EXACT = 1.0e-10 * MATERIAL.sigma0
"""Largest error of a returned initial traction, as the contract promises."""

CORNERS = np.array([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 3.0, 0.0], [0.0, 3.0, 0.0]])
"""Nodes of one element of 2 x 3; the first two are those of a plane element."""

INITIAL = np.array([-1.0, 0.3, -0.2])


def one_element(interface: Interface = SOLID, **umat: object) -> tuple[Structure, Floats]:
    """One element with prescribed displacements, and its upper nodes; umat: other variables of its card."""
    d = 2 if interface is PLANE else 3
    s = Structure(d)
    lower, upper = (s.add_nodes(CORNERS[: 2 * d - 2, :d]) for _ in range(2))
    s.add_interface(lower, upper, s.umat(interface, **umat))
    s.fix([*lower, *upper], *range(d))
    return s, upper


def follow(interface: Interface, path: Floats, **umat: object) -> tuple[Floats, Floats]:
    """Tractions (T, 3) of the element and reactions over its area, along prescribed separations (T, 3)."""
    s, upper = one_element(interface, **umat)
    plane = interface is PLANE
    area, axes = (2.0, (1, 0)) if plane else (6.0, (2, 0, 1))  # order N, Tx, Ty
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


@pytest.mark.parametrize("interface", [PLANE, SOLID], ids=["2D RT", "3D RP-4"])
def test_one_element_is_the_law(interface: Interface) -> None:
    """Tractions and reactions of an element are those of the law in loading, unloading and cycles."""
    path = exported.path(interface is PLANE)
    expected = interface.replay(path)
    assert expected.damage[-1] == 1.0
    traction, reaction = follow(interface, path)
    worst = float((np.abs(traction - expected.traction) / exported.reach(path)).max())
    print(f"{len(path)} steps, difference of tractions {worst:.1e} K |s|")
    assert worst <= ROUNDING
    # the reactions are sums over nodes
    off = np.abs(reaction - expected.traction[:, : reaction.shape[1]])
    assert np.all(off <= 10 * ROUNDING * exported.reach(path))


def test_exported_element(tmp_path: exported.Path) -> None:
    """The script of `asperity export kratos` shows the rows of the README."""
    exported.assert_script("kratos", tmp_path)


@pytest.mark.parametrize("interface", [PLANE, SOLID], ids=["2D RT", "3D RP-4"])
def test_without_the_adapter_damage_heals(interface: Interface) -> None:
    """Smallest case of an error of Kratos: every step starts from the virgin state.

    The tractions are those of a virgin point at the separation of the step; earlier steps have no effect.
    """
    path = exported.path(interface is PLANE)
    traction, _ = follow(interface, path, UDSM_NAME=str(library()))
    assert np.all(np.abs(traction - interface.update(path).traction) <= ROUNDING * exported.reach(path))
    worst = float(np.abs(traction - interface.replay(path).traction).max())
    print(f"without the adapter tractions are wrong by up to {worst:.2f}, sigma0 is {MATERIAL.sigma0:g}")
    assert worst > MATERIAL.sigma0


@pytest.mark.parametrize("drainage", ["drained", "constant_pw_field"])
def test_rows_of_the_water_pressure(drainage: str) -> None:
    """Only a constant water pressure, which the card sets, leaves no 0/0 in its rows of the matrix."""
    s, _ = one_element(GEO_DRAINAGE_TYPE=drainage, BIOT_COEFFICIENT=None)
    s.step(0.0)
    assert np.isnan(s.solver().GetSystemMatrix().value_data()).any() == (drainage == "drained")


def test_a_held_node_under_an_open_joint() -> None:
    """A block is torn off fixed nodes that only an interface has.

    Kratos sets the diagonal of rows without entries, and then drops the coupling with the fixed water
    pressure. With a Biot coefficient of 1, where none is set, a row without entries is left; the card has 0.
    """
    s = Structure(2)
    base, bottom, top = (s.add_nodes(np.array([[0.0, y], [1.0, y]])) for y in (0.0, 0.0, 1.0))
    s.add_solid([*bottom, *top[::-1]], s.elastic(3000.0, 0.2))
    s.add_interface(base, bottom, s.umat(PLANE))
    s.fix([*base, *top], 0, 1)
    s.move(top, 1, 1.0)
    s.step(1e-10)
    # the residual is 1e-10 N, as a root mean square over four free components
    assert s.reaction(top) == pytest.approx([0.0, 0.0], abs=1e-9)
    assert s.points()[0] == pytest.approx(np.array([[1.0, 0.0, 0.0]] * 2), abs=1e-9)


def test_analyses_in_one_process() -> None:
    """Analyses one after the other are independent, although addresses are used again."""
    path = np.array([[0.0, 0.05, 0.0], [0.1, 0.0, 0.0], [0.01, 0.01, 0.0]])
    for sides in (4, 64, 2, 4):
        interface = Interface(MATERIAL, Pattern.regular(sides, 30.0))
        traction, _ = follow(interface, path)
        assert np.all(np.abs(traction - interface.replay(path).traction) <= ROUNDING * exported.reach(path))


def test_a_step_solved_again_starts_from_the_same_state() -> None:
    """A step that is repeated with a smaller one, and elements that start again, keep their history."""
    s, upper = one_element()
    for opening, again in ((0.04, False), (0.2, False), (0.06, True), (0.01, False)):
        s.move(upper, 2, opening)
        s.step(0.0, again)
    s.interfaces[0].Initialize(s.part.ProcessInfo)  # as in the next stage of an analysis
    s.move(upper, 2, 0.03)
    s.step(0.0)
    expected = SOLID.replay(np.outer([0.04, 0.06, 0.01, 0.03], [1.0, 0.0, 0.0])).traction[-1]
    assert s.points()[1][0] == pytest.approx(expected, abs=ROUNDING * STIFFNESS * 0.06)


def test_newton_is_quadratic() -> None:
    """A cube is pressed on a rough joint, sheared and tilted: every point has the law on its own history."""
    s, rough = Structure(3), Interface(replace(MATERIAL, kc=20.0), Pattern.regular(4, theta=20.0))
    axis = np.linspace(0.0, 1.0, 4)
    mesh = split(grid(axis, axis, np.r_[-1.0, axis], block=[0, 1, 1, 1]))
    s.add_mesh(mesh, s.elastic(3000.0, 0.2), s.umat(rough))
    base, top = np.unique(mesh.cells["hexahedron"][mesh.block["hexahedron"] == 0]) + 1, mesh.nodes("top") + 1
    s.fix(np.append(base, top), 0, 1, 2)
    norms, points = [], []
    for slip in (0.0, 0.01, 0.02, 0.04, 0.06, 0.08, 0.1, 0.12, 0.15):
        s.move(top, 0, slip)
        s.move(top, 1, slip / 3.0)
        s.move(top, 2, lambda node, slip=slip: -0.01 + 0.3 * slip * (node.X0 - 0.3))
        norms.append(s.step(1e-10))  # N; the reactions are some N
        points.append(s.points())
    separation, traction = (np.array(values) for values in zip(*points, strict=True))
    exported.assert_law(rough, 1e-12 / MATERIAL.sigma0, separation, traction)
    assert np.ptp(separation[-1, :, 0]) > 0.01  # the structure differs from a material point
    pairs = [(before, after) for step in norms for before, after in pairwise(step)]
    print("norms of the steps:", *(" ".join(f"{norm:.1e}" for norm in step) for step in norms), sep="\n")
    # the last residual is a rounding error of reactions of some N
    assert sum(after < 100.0 * before**2 for before, after in pairs if after > 1e-15) >= 10
    assert max(map(len, norms)) <= 6


# --- meshes of asperity.mesh ------------------------------------------------


def blocks(kind: str) -> meshio.Mesh:
    """Two blocks of quadratic cells, one on the other."""
    level = [range(2)] * (2 if kind in ("tetra10", "hexahedron20") else 1)
    two_cubes = grid(*level, range(3))
    points, cells = two_cubes.points, two_cubes.cells[0].data
    cells = simplices(points, cells) if kind in ("triangle6", "tetra10") else cells
    block = (points[cells].mean(axis=1)[:, -1] > 1.0).astype(int)
    ends = np.sort(cells[:, [[int(k) for k in edge] for edge in QUADRATIC[kind].split()]], axis=2)
    edges, middle = np.unique(ends.reshape(-1, 2), axis=0, return_inverse=True)
    cells = np.concatenate([cells, len(points) + middle.reshape(len(cells), -1)], axis=1)
    points = np.concatenate([points, points[edges].mean(axis=1)])
    return meshio.Mesh(points, [(kind, cells)], cell_data={"block": [block]})


@pytest.mark.parametrize("kind", QUADRATIC)
def test_quadratic_cells(kind: str) -> None:
    """Blocks without lateral strain are pressed, then all nodes are moved by an affine field.

    In the plane all points close by the same amount. In space they do not, because the weights that Kratos
    gives to corners and middles of quadratic faces are not those of a uniform pressure.
    """
    mesh, E, closure = split(blocks(kind)), 3000.0, -0.01
    d, s = mesh.dimension, Structure(mesh.dimension)
    law, error = (PLANE, 1e-9) if d == 2 else (SOLID, 0.15)
    s.add_mesh(mesh, s.elastic(E, 0.0), s.umat(law))
    top, bottom = (np.flatnonzero(mesh.points[:, -1] == y) + 1 for y in (2.0, 0.0))
    s.fix(np.r_[top, bottom], *range(d))
    traction = law.update([[closure, 0.0, 0.0]]).traction[0, 0]
    s.move(top, d - 1, closure + 2.0 * traction / E)
    s.step(1e-9)
    assert s.points()[0][:, 0] == pytest.approx(closure, rel=error)
    assert s.reaction(top)[-1] == pytest.approx(traction, rel=0.3 * error)
    upper = np.unique(next(iter(mesh.cells.values()))[next(iter(mesh.block.values())) == 1])
    s.fix(range(1, len(mesh.points) + 1), *range(d))
    s.move(range(1, len(mesh.points) + 1), d - 1, 0.0)
    slope = np.array([0.01, 0.02, 0.0])[3 - d :]
    for node, opening in zip(upper, mesh.points[upper] @ slope, strict=True):
        s.move([node + 1], d - 1, opening)
    s.step(0.0)
    places = np.concatenate([mesh.points[joint.minus].reshape(-1, d) for joint in mesh.joints["joint"]])
    assert np.sort(s.points()[0][:, 0]) == pytest.approx(np.sort(places @ slope), abs=1e-14)


def test_joint_across_a_period() -> None:
    """A block that is pressed upright is held at its sides by itself: the next period is across a joint."""
    E, nu, pressed = 3000.0, 0.2, -0.01
    mesh = split(grid(range(4), range(3)), {"head": {"right": "left"}})
    s = Structure(2)
    s.add_mesh(mesh, s.elastic(E, nu), s.umat(PLANE))
    base, top = mesh.nodes("bottom") + 1, mesh.nodes("top") + 1
    s.fix(np.r_[base, top], 1)
    s.fix([5], 0)
    s.move(top, 1, 2.0 * pressed)
    s.step(1e-9)
    # plane strain: E/(1 - nu^2) strain x = stress x - nu/(1 - nu) stress y, and the same for y; stress x is
    # the traction of the joint, which closes by the strain x times the period
    stiffness = float(PLANE.update([[-1e-9, 0.0, 0.0]]).traction[0, 0]) / -1e-9
    plane, ratio = E / (1.0 - nu**2), nu / (1.0 - nu)
    matrix = [[1.0 + plane / (3.0 * stiffness), -ratio], [-ratio, 1.0]]
    stress = np.linalg.solve(matrix, [0.0, plane * pressed])
    assert s.points()[1][:, 0] == pytest.approx(stress[0], rel=1e-6) and stress[0] < 0.0
    assert s.reaction(top)[1] == pytest.approx(3.0 * stress[1], rel=1e-6)


# --- initial states ---------------------------------------------------------


@pytest.mark.parametrize("damage", [0.0, 0.5, 1.0])
def test_state_variables_carry_a_traction(damage: float) -> None:
    """A point with a state of Interface.initial as STATE_VARIABLES has its traction, then follows the law."""
    state = SOLID.initial(INITIAL, damage)
    s, upper = one_element(STATE_VARIABLES=state.tolist())
    s.step(0.0)
    assert s.points()[1] == pytest.approx(np.tile(INITIAL, (4, 1)), abs=EXACT)
    s.move(upper, 0, 0.03)
    s.step(0.0)
    moved = exported.from_state(SOLID, state, np.array([[0.0, 0.0, 0.0], [0.0, 0.03, 0.0]]))
    assert s.points()[1][0] == pytest.approx(moved[1], abs=EXACT)


def test_initial_stress_does_not_reach_the_umat() -> None:
    """Smallest case that shows that Kratos ignores the initial stress of an interface, without a message."""
    s, _ = one_element()
    s.solver()
    vectors = Kratos.Vector([0.0] * 3), Kratos.Vector(INITIAL.tolist()), Kratos.Matrix(3, 3)
    Kratos.SetInitialStateProcess3D(s.part, *vectors).ExecuteInitializeSolutionStep()
    s.step(0.0)
    assert not s.points()[1].any()


@pytest.mark.parametrize("damage", [0.0, 0.5, 1.0])
def test_prestressed_block_rests(damage: float) -> None:
    """Under the load of its initial stress a block on a joint does not move, if both have this stress."""
    moved, square = [], CORNERS / [2.0, 3.0, 1.0]
    for stressed in (True, False):
        s = Structure(3)
        base, bottom, top = (s.add_nodes(square + np.array([0.0, 0.0, z])) for z in (0.0, 0.0, 1.0))
        state = SOLID.initial([-1.0, 0.0, 0.0], damage) if stressed else np.zeros(SOLID.nstatv)
        s.add_solid([*bottom, *top], s.elastic(3000.0, 0.2))
        s.add_interface(base, bottom, s.umat(SOLID, STATE_VARIABLES=state.tolist()))
        s.fix(base, 0, 1, 2)
        s.load({node: (0.0, 0.0, -0.25) for node in top})
        if stressed:
            s.stress_solids([0.0, 0.0, -1.0, 0.0, 0.0, 0.0])
        s.step(1e-10)
        moved.append(np.abs(s.displacements()).max())
        assert s.points()[1][:, 0] == pytest.approx(-1.0, abs=1e-9)
    print(f"displacements {moved[0]:.1e} mm, without initial stress {moved[1]:.1e} mm")
    # a point returns its initial traction to 1e-10 of the strength
    assert moved[0] <= 1e-9 * moved[1]
