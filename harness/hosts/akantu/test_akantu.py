"""Akantu's cohesive elements with the law: run by `make hosts`, which installs its packages first."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("akantu", reason="akantu is not installed")

import akantu as aka
import exported
import meshio
import peel
from asperity import Interface, Material, Pattern
from asperity.mesh import paraview
from asperity_akantu import Joint, register
from exported import PLANE, SOLID
from structured import grid, simplices

CELL = {2: aka._cohesive_2d_4, 3: aka._cohesive_3d_8}
CUBE = {2: aka._quadrangle_4, 3: aka._hexahedron_8}
"""Types of the elements of the joint and of the cubes, by dimension."""

ROUGH_BALANCE = 5.0e-3
"""Difference of work and energies over the work: the forces are those at the ends of the steps."""


LAW = {2: PLANE, 3: SOLID}


def cubes(
    folder: Path, dimension: int, method: object = aka._static, **options: object
) -> tuple[aka.Mesh, aka.SolidMechanicsModelCohesive, Joint, np.ndarray]:
    """Two soft cubes, 1 mm, with a joint: mesh, which must live on, model, joint, nodes of the upper cube."""
    unsplit, soft = grid(*[range(2)] * (dimension - 1), range(3), sides=()), (1e-9, 1e-9, 0.2)
    model, mesh, joint = peel.start(folder, unsplit, LAW[dimension], 1.0, soft, False, method, **options)
    x, cells = np.array(mesh.getNodes()), np.array(mesh.getConnectivity(CUBE[dimension]))
    upper = np.unique(cells[x[cells][:, :, -1].mean(axis=1) > 1.0])
    return mesh, model, joint, upper


def follow(folder: Path, dimension: int, of_card: bool = False) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Separation and traction (T, points, 3) on a path, and the forces of the upper cube (T, dimension)."""
    _mesh, model, joint, upper = cubes(folder, dimension, of_card=of_card)
    rows = []
    for n, x, y in exported.path(dimension == 2).tolist():
        model.getDisplacement()[upper] = [x, n] if dimension == 2 else [x, y, n]
        model.assembleInternalForces()
        joint.commit()
        points = joint.points(CELL[dimension])
        force = -np.array(model.getInternalForce())[upper].sum(axis=0)
        rows.append((points.separation, points.traction, force))
    return tuple(np.array(column) for column in zip(*rows, strict=True))


@pytest.mark.parametrize("dimension", [2, 3])
def test_element_has_the_law(dimension: int, tmp_path: Path) -> None:
    """Every point has the law on its own history; the forces are the tractions times the area, 1 mm2."""
    separation, traction, force = follow(tmp_path, dimension)
    interface, axes, path = LAW[dimension], [*range(dimension)], exported.path(dimension == 2)
    # which side is the first one is Akantu's choice, and the sense of a slip with it
    assert np.abs(separation[:, 0, axes]) == pytest.approx(np.abs(path[:, axes]), abs=1e-14)
    exported.assert_law(interface, 1e-12, separation, traction)
    # the soft cubes carry 1e-9 MPa
    expected = np.abs(traction.mean(axis=1)[:, axes])
    assert np.abs(np.roll(force, 1, axis=1)) == pytest.approx(expected, abs=1e-8)


@pytest.mark.parametrize(("dimension", "about"), [(2, 0), (3, 0), (3, 1)])
def test_sheared_joint_that_turns(dimension: int, about: int, tmp_path: Path) -> None:
    """A sheared joint that is turned rigidly by 90 and 120 degrees keeps its tractions, in axes that turn."""
    mesh, model, joint, upper = cubes(tmp_path, dimension, aka._explicit_lumped_mass)
    model.getBlockedDOFs()[:] = True
    model.setTimeStep(1e-9)
    x = np.array(mesh.getNodes())
    sheared = [0.08, 0.03, -0.01]
    rows = []
    for jump, angle in (
        ([0.0, 0.0, -0.01], 0),
        *((sheared, angle) for angle in (0, 45, 90, 120)),
        ([0.02, 0.0, -0.01], 120),
    ):
        c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
        turn = np.roll(np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]]), about, (0, 1))
        turn = turn[-dimension:, -dimension:]
        moved = x.copy()
        moved[upper] += jump if dimension == 3 else jump[::2]
        model.getDisplacement()[:] = moved @ turn.T - x
        model.solveStep("explicit_lumped")
        joint.commit()
        force = -np.array(model.getInternalForce())[upper].sum(axis=0) @ turn
        points = joint.points(CELL[dimension])
        rows.append((points.separation[0], points.traction[0], force))
    separation, traction, force = (np.array(column) for column in zip(*rows, strict=True))
    expected = LAW[dimension].replay(separation[[0, 1, 5]]).traction
    assert separation[1:5] == pytest.approx(np.tile(separation[1], (4, 1)), abs=1e-14)
    assert traction[[0, 1, 3, 4, 5]] == pytest.approx(expected[[0, 1, 1, 1, 2]], abs=1e-10)
    assert abs(traction[5, 1]) < 0.5 * abs(traction[4, 1])  # the damage of the turned joint is that of before
    assert np.linalg.norm(force, axis=1) == pytest.approx(np.linalg.norm(traction, axis=1), rel=1e-9)
    assert force[1:5] == pytest.approx(np.tile(force[1], (4, 1)), abs=1e-9)


def test_exported_element(tmp_path: Path) -> None:
    """The script of `asperity export akantu` shows the rows of the README."""
    exported.assert_script("akantu", tmp_path)


def test_symmetric_storage(tmp_path: Path) -> None:
    """Akantu keeps one triangle of the stiffness, which friction makes unsymmetric."""
    mesh, model, joint, upper = cubes(tmp_path, 2)
    for slip in (0.0, 0.1, 0.2, 0.25):
        joint.commit()
        model.getDisplacement()[upper] = [slip, -0.01]
        model.assembleInternalForces()
    model.assembleStiffnessMatrix()
    stored = aka.AkantuSparseMatrix(model.getDOFManager().getMatrix("K")).toarray()
    tangent = joint.points(CELL[2]).tangent.mean(axis=0)[:2, :2]
    assert len(mesh.getNodes()) == 8 and abs(tangent[0, 1] - tangent[1, 0]) > 0.1 * tangent.max()
    assert np.array_equal(stored, stored.T) and np.abs(stored).max() > 0.1 * tangent.max()


def in_process(code: str) -> str:
    """Standard error of a script that must fail: an error in a material ends the process."""
    command = [sys.executable, "-c", f"import peel, test_akantu, pathlib\n{code}"]
    done = subprocess.run(command, cwd=Path(__file__).parent, capture_output=True, text=True, check=False)
    assert done.returncode != 0
    return done.stderr


def test_direction_along_the_normal(tmp_path: Path) -> None:
    """Tx has no direction where it is along the normal: the message has both."""
    errors = in_process(
        f"mesh, model, *others = test_akantu.cubes(pathlib.Path({str(tmp_path)!r}), 3, "
        "tx=(0.0, 0.0, 1.0))\nmodel.assembleInternalForces()"
    )
    assert "tx = [0.0, 0.0, 1.0]: expected a direction across the normal" in errors


def test_card(tmp_path: Path) -> None:
    """With the constants of `asperity card` in the input file the run is the same to the last bit."""
    runs = [follow(tmp_path, 2, of_card) for of_card in (False, True)]
    assert all(np.array_equal(*pair) for pair in zip(*runs, strict=True))


def test_card_without_a_constant(tmp_path: Path) -> None:
    """A constant that has no default and is not in the input file is named."""
    errors = in_process(
        "from asperity import Interface; old = Interface.card\n"
        "Interface.card = lambda *a, **k: old(*a, **k).replace('Gc = 0.3', '')\n"
        f"test_akantu.follow(pathlib.Path({str(tmp_path)!r}), 2, True)"
    )
    assert "Gc: expected in the material section of the input file" in errors


def test_elements_inserted_during_the_run(tmp_path: Path) -> None:
    """Explicit dynamics: elements begin with the stress of their facets, and the energies balance."""
    result = peel.run(tmp_path)
    first, last = result.elements[0], result.elements[-1]
    print(f"{first} to {last} elements of the joint; energies differ by {result.unbalanced:.1e} of the work")
    assert 0 < first < last <= round(peel.LENGTH / peel.SIZE)
    assert result.unbalanced <= ROUGH_BALANCE
    # fracture and friction dissipate at least Gc over the part of the joint that is broken
    broken = peel.AREA * float((result.steps[-1].state[..., peel.DAMAGE] > 1.0 - 1e-9).sum())
    assert broken > 5.0 * peel.SIZE
    assert result.joint[-1] >= 0.97 * peel.JOINT.material.Gc * broken  # 2.5 % came with the initial stress
    paraview.write(tmp_path / "peel.pvd", result.steps)
    drawn = meshio.read(max((tmp_path / "peel").glob("joints_*.vtu")))
    damage = result.steps[-1].state[..., peel.DAMAGE].mean(axis=1)
    assert np.array_equal(drawn.cell_data["damage"][0], damage)


def test_insertion_is_a_part_of_the_strength() -> None:
    """A limit of the stress that the law could not start from is refused."""
    with pytest.raises(ValueError, match=r"insertion = 1.5: expected a part of the strength"):
        register(SOLID, "refused", insertion=1.5)


def test_insertion_in_space(tmp_path: Path) -> None:
    """Elements between tetrahedra: the forces of the top are the tractions of the points."""
    cubes = grid(range(2), range(2), range(3), sides=())
    unsplit = meshio.Mesh(cubes.points, [("tetra", simplices(cubes.points, cubes.cells[0].data))])
    model, mesh, joint = peel.start(tmp_path, unsplit, peel.JOINT, 1.0, (1e-9, 30000.0, 0.0))
    model.setTimeStep(0.3 * model.getStableTimeStep())
    height = np.array(mesh.getNodes())[:, 2]
    top, bottom = np.flatnonzero(height > 1.9), np.flatnonzero(height < 0.1)
    model.getBlockedDOFs()[np.concatenate([top, bottom])] = True
    rows = []
    for k in range(600):
        model.checkCohesiveStress()
        model.getDisplacement()[top] = np.array([3e-7, 5e-7, 1e-6]) * k
        model.solveStep("explicit_lumped")
        joint.commit()
        if joint.types():
            traction = joint.points(aka._cohesive_3d_6).traction
            force = -np.array(model.getInternalForce())[top].sum(axis=0)
            rows.append(np.append(force[[2, 0, 1]], traction.mean(axis=0)))
    force, traction = np.array(rows)[:, :3], np.array(rows)[:, 3:]
    assert len(joint.points(aka._cohesive_3d_6).state) == 6  # two triangles
    worst = np.abs(np.abs(force) - np.abs(traction)).max() / traction.max()
    print(f"forces differ from tractions by {worst:.1e} of the largest, {traction.max():.2f} MPa")
    assert worst <= 0.15  # waves


def test_insertion_between_hexahedra_is_refused(tmp_path: Path) -> None:
    """Stresses of Akantu on facets of hexahedra are wrong by orders of magnitude."""
    errors = in_process(
        "import numpy as np\n"
        "cubes = test_akantu.grid(*[np.linspace(0, 1, 3)] * 2, np.linspace(0, 2, 3), sides=())\n"
        f"folder, solid = pathlib.Path({str(tmp_path)!r}), (1e-9, 1.0, 0.0)\n"
        "model, *others = peel.start(folder, cubes, test_akantu.SOLID, 1.0, solid)\n"
        "model.assembleInternalForces()\n"
        "model.checkCohesiveStress()\n"
    )
    assert "facets are quadrilaterals: expected triangles" in errors


def test_damping_of_the_solids(tmp_path: Path) -> None:
    """Forces -beta K v by the stiffness of the solids alone damp vibration and brake no rigid motion."""
    length, rho, E, beta, n = 10.0, 2.5e-9, 3e4, 2e-8, 1500
    free = Interface(Material.from_joint(kn=1e-6, ks=1e-6, mu=0.5), Pattern.regular(0, 0.0))
    bars = grid(np.linspace(0.0, length, 21), range(3), sides=())
    model, mesh, joint = peel.start(tmp_path, bars, free, 1.0, (rho, E, 0.0), False)
    x, cells = np.array(mesh.getNodes()), np.array(mesh.getConnectivity(CUBE[2]))
    upper = np.unique(cells[x[cells][:, :, 1].mean(axis=1) > 1.0])
    dt = 0.3 * model.getStableTimeStep()
    model.setTimeStep(dt)
    # as fe-programs.md has it
    model.assembleInternalForces()
    for kind in joint.types():
        joint.points(kind).tangent[:] = 0.0
    model.assembleStiffnessMatrix()
    K = aka.AkantuSparseMatrix(model.getDOFManager().getMatrix("K"))
    model.getBlockedDOFs()[:, 1] = True
    shape, rows = np.cos(np.pi * x[upper, 0] / length), []
    model.getVelocity()[upper, 0] = 1.0
    model.getDisplacement()[upper, 0] = 1e-5 * shape
    for _ in range(n):
        v = np.array(model.getVelocity())
        model.getExternalForce()[:] = -beta * (K @ v.ravel()).reshape(v.shape)
        model.solveStep("explicit_lumped")
        joint.commit()
        rows.append(np.array(model.getDisplacement())[upper, 0] @ shape)
    a = np.array(rows)
    tops = 1 + np.flatnonzero((a[1:-1] > a[:-2]) & (a[1:-1] >= a[2:]))
    rate = -np.polyfit(dt * tops, np.log(a[tops]), 1)[0]
    assert len(tops) > 8
    assert rate == pytest.approx(0.5 * beta * (np.pi / length) ** 2 * E / rho, rel=0.01)
    assert np.array(model.getVelocity())[upper, 0].mean() == pytest.approx(1.0, rel=1e-9)


@pytest.mark.parametrize("xi", [0.1, 0.3, 0.7])
def test_impact(xi: float, tmp_path: Path) -> None:
    """A stiff block that falls on a joint with a dashpot keeps the velocity of the closed form."""
    kn, rho, speed = 200.0, 2.5e-9, 100.0
    law = Interface(
        Material.from_joint(kn, 80.0, 0.5, c=2.0 * xi * np.sqrt(kn * rho)), Pattern.regular(0, 0.0)
    )
    model, mesh, joint = peel.start(
        tmp_path, grid(range(2), range(3), sides=()), law, 1.0, (rho, 3e4, 0.0), False
    )
    x, cells = np.array(mesh.getNodes()), np.array(mesh.getConnectivity(CUBE[2]))
    upper = np.unique(cells[x[cells][:, :, 1].mean(axis=1) > 1.0])
    model.getBlockedDOFs()[:] = True
    model.getBlockedDOFs()[upper, 1] = False
    joint.dt = 0.1 * model.getStableTimeStep()
    model.setTimeStep(joint.dt)
    model.getVelocity()[upper, 1] = -speed
    # half a period of contact, and some flight
    for _ in range(int(1.5 * np.pi * np.sqrt(rho / kn) / joint.dt)):
        model.solveStep("explicit_lumped")
        joint.commit()
    after = np.array(model.getVelocity())[upper, 1].mean()
    e = np.exp(-xi * (np.pi - 2.0 * np.arcsin(xi)) / np.sqrt(1.0 - xi**2))
    # vibration of the block takes a part of the energy
    assert after / speed == pytest.approx(e, abs=0.01)
