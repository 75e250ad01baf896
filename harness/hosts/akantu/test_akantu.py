"""Akantu's cohesive elements with the law: run by `make hosts`, which installs asperity[akantu] first."""

from __future__ import annotations

import subprocess
import sys
from itertools import permutations
from pathlib import Path

import numpy as np
import pytest
from asperity import Interface, Material, Pattern

pytest.importorskip("akantu", reason="asperity[akantu] is not installed")

sys.path.insert(0, str(Path(__file__).parent.parent))
import akantu as aka
import exported
import joint_picture
import paraview_check
import paraview_files as paraview
import peel
import two_blocks
from two_blocks import PRELOAD_STEPS, PRESSURE

LAST = 1.0e-7
"""Error of the force at the end: Newton's method is linear here and ends at 1e-9 N."""


ROUGH_BALANCE = 5.0e-3
"""Difference of work and energies over the work: the forces are those at the ends of the steps."""


@pytest.mark.parametrize("dimension", [2, 3])
def test_two_blocks(dimension: int, tmp_path: Path) -> None:
    """Every point has the law on its own history; the force ends at that of the closed form."""
    joint = Interface(two_blocks.JOINT.material, Pattern.regular(2 * (dimension - 1), theta=30.0))
    result = two_blocks.run(tmp_path, dimension, joint)
    counts = result.iterations
    print(f"{dimension}D: {len(counts)} steps, {sum(counts)} iterations, at most {max(counts)}")
    for k in range(result.separation.shape[1]):
        expected = joint.replay(result.separation[:, k])
        assert np.abs(result.traction[:, k] - expected.traction).max() <= 1e-12 * joint.material.sigma0
    residual = joint.material.residual_strength(30.0) * PRESSURE
    print(f"force at the end {result.force[-1, 0]:.9f} N, closed form {residual:.9f} N")
    assert result.force[-1, 0] == pytest.approx(residual, rel=LAST)
    rise = np.diff(result.rise[-5:]) / np.diff(result.slip[-5:])
    assert rise == pytest.approx(np.tan(np.radians(30.0)), rel=1e-6)
    assert np.ptp(result.separation[PRELOAD_STEPS:, :, 0], axis=1).max() > 0.0
    two_blocks.write_paraview(tmp_path / "blocks.pvd", result)
    paraview_check.against_the_law(tmp_path / "blocks.pvd", joint, 1e-12)
    paraview_check.places(tmp_path / "blocks.pvd", 2 ** (dimension - 1), up=dimension - 1)


@pytest.mark.parametrize(("dimension", "about"), [(2, 0), (3, 0), (3, 1)])
def test_sheared_joint_that_turns(dimension: int, about: int, tmp_path: Path) -> None:
    """A sheared joint that is turned rigidly by 90 and 120 degrees keeps its tractions, in axes that turn."""
    joint = Interface(two_blocks.JOINT.material, Pattern.regular(2 * (dimension - 1), theta=30.0))
    mesh, model, made = two_blocks.build(tmp_path, dimension, joint, 1, aka._explicit_lumped_mass, young=1e-9)
    model.getBlockedDOFs()[:] = True
    model.setTimeStep(1e-9)
    x = np.array(mesh.getNodes())
    cells = np.array(mesh.getConnectivity(two_blocks.SOLID[dimension]))
    upper = np.unique(cells[x[cells][:, :, -1].mean(axis=1) > 1.0])
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
        made[0].commit()
        force = -np.array(model.getInternalForce())[upper].sum(axis=0) @ turn
        points = made[0].points(two_blocks.CELL[dimension])
        rows.append((points.separation[0], points.traction[0], force))
    separation, traction, force = (np.array(column) for column in zip(*rows, strict=True))
    expected = joint.replay(separation[[0, 1, 5]]).traction
    assert separation[1:5] == pytest.approx(np.tile(separation[1], (4, 1)), abs=1e-14)
    assert traction[[0, 1, 3, 4, 5]] == pytest.approx(expected[[0, 1, 1, 1, 2]], abs=1e-10)
    assert abs(traction[5, 1]) < 0.5 * abs(traction[4, 1])  # the damage of the turned joint is that of before
    assert np.linalg.norm(force, axis=1) == pytest.approx(np.linalg.norm(traction, axis=1), rel=1e-9)
    assert force[1:5] == pytest.approx(np.tile(force[1], (4, 1)), abs=1e-9)


def test_exported_element(tmp_path: Path) -> None:
    """The script of `asperity export akantu` shows the rows of the README."""
    exported.element("akantu", tmp_path / "kit")
    script = [sys.executable, tmp_path / "kit" / "single.py"]
    done = subprocess.run(script, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert len(done.stdout.split("expected\n")[-1].splitlines()) == 5


def test_symmetric_storage(tmp_path: Path) -> None:
    """Without friction the tangent is symmetric, and Newton's method needs fewer iterations."""
    smooth = Interface(Material(sigma0=3.0, Gc=0.3, eta=0.9, mu=0.0, kc=4.0), Pattern.regular(2, theta=30.0))
    counts = [sum(two_blocks.run(tmp_path, 2, one).iterations) for one in (two_blocks.JOINT, smooth)]
    print(f"iterations: {counts[0]} with friction, {counts[1]} without")
    assert counts[0] > 1.5 * counts[1]


def test_direction_along_the_normal(tmp_path: Path) -> None:
    """Tx has no direction where it is along the normal: the message has both."""
    code = (
        "import two_blocks, pathlib; old = two_blocks.register; "
        "two_blocks.register = lambda joint, name: old(joint, name, tx=[0.0, 0.0, 1.0]); "
        f"two_blocks.run(pathlib.Path({str(tmp_path)!r}), 3)"
    )
    here = Path(__file__).parent
    done = subprocess.run([sys.executable, "-c", code], cwd=here, capture_output=True, text=True, check=False)
    assert done.returncode != 0
    assert "tx = [0.0, 0.0, 1.0]: expected a direction across the normal" in done.stderr


def test_card(tmp_path: Path) -> None:
    """With the constants of `asperity card` in the input file the run is the same to the last bit."""
    runs = []
    for of_card in (False, True):
        (folder := tmp_path / str(of_card)).mkdir()
        runs.append(two_blocks.run(folder, 2, two_blocks.JOINT, 1, of_card))
    assert np.array_equal(runs[0].force, runs[1].force) and np.array_equal(runs[0].state, runs[1].state)


def test_card_without_a_constant(tmp_path: Path) -> None:
    """A constant that has no default and is not in the input file is named."""
    code = (
        "import two_blocks, pathlib; from asperity import Interface; old = Interface.card; "
        "Interface.card = lambda *a, **k: old(*a, **k).replace('Gc = 0.3', ''); "
        f"two_blocks.run(pathlib.Path({str(tmp_path)!r}), 2, of_card=True)"
    )
    here = Path(__file__).parent
    done = subprocess.run([sys.executable, "-c", code], cwd=here, capture_output=True, text=True, check=False)
    assert done.returncode != 0
    assert "Gc: expected in the material section of the input file" in done.stderr


def test_elements_inserted_during_the_run(tmp_path: Path) -> None:
    """Explicit dynamics: elements begin with the stress of their facets, and the energies balance."""
    result = peel.run(tmp_path)
    first, last = result.elements[0], result.elements[-1]
    print(f"{first} to {last} elements of the joint; energies differ by {result.unbalanced:.1e} of the work")
    assert 0 < first < last <= round(peel.LENGTH / peel.SIZE)
    assert result.unbalanced <= ROUGH_BALANCE
    # fracture and friction dissipate at least Gc over the part of the joint that is broken
    broken = peel.AREA * float((result.steps[-1].state[:, peel.DAMAGE] > 1.0 - 1e-9).sum())
    assert broken > 5.0 * peel.SIZE
    assert result.joint[-1] >= 0.97 * peel.JOINT.material.Gc * broken  # 2.5 % came with the initial stress
    paraview.write(tmp_path / "peel.pvd", result.steps[-1].structure, result.steps)
    joints = joint_picture.read(tmp_path / "peel.pvd")[-1][2]
    assert np.array_equal(joints.cell_data["damage"][0], result.steps[-1].state[:, peel.DAMAGE])


def test_elements_there_from_the_start(tmp_path: Path) -> None:
    """The largest force differs from that with inserted elements by their compliance only."""
    forces = []
    for extrinsic in (False, True):
        (folder := tmp_path / str(extrinsic)).mkdir()
        result = peel.run(folder, extrinsic, opening=0.04)
        assert result.unbalanced <= ROUGH_BALANCE
        forces.append(result.force.max())
    print(f"largest force {forces[0]:.4f} N with all elements, {forces[1]:.4f} N with inserted ones")
    assert forces[1] == pytest.approx(forces[0], rel=0.05)


def test_insertion_is_a_part_of_the_strength() -> None:
    """A limit of the stress that the law could not start from is refused."""
    with pytest.raises(ValueError, match=r"insertion = 1.5: expected a part of the strength"):
        two_blocks.register(two_blocks.JOINT, "refused", insertion=1.5)


def test_insertion_in_space(tmp_path: Path) -> None:
    """Elements between tetrahedra: the forces of the top are the tractions of the points."""
    interface = Interface(peel.JOINT.material, Pattern.regular(4, theta=30.0))
    made = two_blocks.register(interface, "asperity_tetrahedra")
    text = two_blocks.INPUT.format(
        box="[-1, 2], [-1, 2], [0.9, 1.1]", young=30000.0, poisson=0.0, law="asperity_tetrahedra"
    )
    (tmp_path / "blocks.dat").write_text(text, encoding="utf-8")
    write_tetrahedra(tmp_path / "blocks.msh")
    aka.parseInput(str(tmp_path / "blocks.dat"))
    mesh = aka.Mesh(3)
    mesh.read(str(tmp_path / "blocks.msh"))
    model = aka.SolidMechanicsModelCohesive(mesh)
    model.initFull(_analysis_method=aka._explicit_lumped_mass, _is_extrinsic=True)
    model.updateAutomaticInsertion()
    model.setTimeStep(0.3 * model.getStableTimeStep())
    height = np.array(mesh.getNodes())[:, 2]
    top, bottom = np.flatnonzero(height > 1.9), np.flatnonzero(height < 0.1)
    model.getBlockedDOFs()[np.concatenate([top, bottom])] = True
    rows = []
    for k in range(600):
        model.checkCohesiveStress()
        model.getDisplacement()[top] = np.array([3e-7, 5e-7, 1e-6]) * k
        model.solveStep("explicit_lumped")
        made[0].commit()
        if made[0].types():
            traction = made[0].points(aka._cohesive_3d_6).traction
            force = -np.array(model.getInternalForce())[top].sum(axis=0)
            rows.append(np.append(force[[2, 0, 1]], traction.mean(axis=0)))
    force, traction = np.array(rows)[:, :3], np.array(rows)[:, 3:]
    assert len(made[0].points(aka._cohesive_3d_6).state) == 6  # two triangles
    worst = np.abs(np.abs(force) - np.abs(traction)).max() / traction.max()
    print(f"forces differ from tractions by {worst:.1e} of the largest, {traction.max():.2f} MPa")
    assert worst <= 0.15  # waves


def write_tetrahedra(path: Path) -> None:
    """Write two cubes of six tetrahedra each, one above the other."""
    axes = ([0.0, 1.0], [0.0, 1.0], [0.0, 1.0, 2.0])
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    number = np.arange(1, 13).reshape(2, 2, 3)
    cells = []
    for k in (0, 1):
        for order in permutations(range(3)):
            at, cell = np.array([0, 0, k]), [number[0, 0, k]]
            for axis in order:
                at[axis] += 1
                cell.append(number[tuple(at)])
            edges = points[np.array(cell[1:]) - 1] - points[cell[0] - 1]
            cells.append(cell if np.linalg.det(edges) > 0.0 else [cell[1], cell[0], *cell[2:]])
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", "1", '3 1 "blocks"']
    lines += ["$EndPhysicalNames", "$Nodes", str(len(points))]
    lines += [f"{i} {x!r} {y!r} {z!r}" for i, (x, y, z) in enumerate(points.tolist(), 1)]
    lines += ["$EndNodes", "$Elements", str(len(cells))]
    lines += [f"{i} 4 2 1 1 " + " ".join(map(str, cell)) for i, cell in enumerate(cells, 1)]
    path.write_text("\n".join([*lines, "$EndElements"]) + "\n", encoding="utf-8")


def test_insertion_between_hexahedra_is_refused(tmp_path: Path) -> None:
    """Smallest case of an error of Akantu: its stresses on facets of hexahedra are wrong."""
    code = (
        "import akantu as aka, numpy as np, pathlib, two_blocks\n"
        f"folder = pathlib.Path({str(tmp_path)!r})\n"
        "two_blocks.register(two_blocks.JOINT, 'joints')\n"
        "box = '[-1, 2], [-1, 2], [0.9, 1.1]'\n"
        "text = two_blocks.INPUT.format(box=box, young=1.0, poisson=0.0, law='joints')\n"
        "(folder / 'blocks.dat').write_text(text)\n"
        "two_blocks.write_mesh(folder / 'blocks.msh', [np.linspace(0, 1, 3)] * 2 + [np.linspace(0, 2, 3)])\n"
        "aka.parseInput(str(folder / 'blocks.dat'))\n"
        "mesh = aka.Mesh(3)\n"
        "mesh.read(str(folder / 'blocks.msh'))\n"
        "model = aka.SolidMechanicsModelCohesive(mesh)\n"
        "model.initFull(_analysis_method=aka._explicit_lumped_mass, _is_extrinsic=True)\n"
        "model.updateAutomaticInsertion()\n"
        "model.getDisplacement()[:, 2] = np.array(mesh.getNodes())[:, 2]\n"
        "model.assembleInternalForces()\n"
        "stress = np.array(model.getMaterial(0).getStress(aka._hexahedron_8))[:, 8]\n"
        "try:\n    model.checkCohesiveStress()\n"
        "finally:\n    print(stress.min(), stress.max(),\n"
        "        np.array(model.getStressOnFacets(aka._quadrangle_4)).max())\n"
    )
    here = Path(__file__).parent
    done = subprocess.run([sys.executable, "-c", code], cwd=here, capture_output=True, text=True, check=False)
    assert done.returncode != 0 and "facets are quadrilaterals: expected triangles" in done.stderr
    smallest, largest, on_facets = map(float, done.stdout.split())
    print(f"stress of the elements {smallest:g} to {largest:g}, on facets up to {on_facets:g}")
    assert smallest == pytest.approx(1.0) and largest == pytest.approx(1.0)
    assert on_facets > 2.0
