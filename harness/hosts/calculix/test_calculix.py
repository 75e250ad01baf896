"""CalculiX with the UMAT of libasperity.  `make hosts` runs these tests; conftest.py has the requirements."""

from __future__ import annotations

import subprocess
from pathlib import Path

import calculix_run
import dcb
import exported
import numpy as np
import paraview_check
import pytest
from asperity import History, Interface, Material, Pattern, contract
from asperity.installed import driver
from calculix_run import DIGITS, TX, TY, Floats, N

MATERIAL = Material(sigma0=3.0, Gc=0.3, eta=0.9, mu=0.5, kc=3.0)
ROUGH = Interface(MATERIAL, Pattern.regular(4, theta=30.0))
STIFFNESS = MATERIAL.kc * MATERIAL.K
LEGS = (
    (4, (-0.01, 0.0, 0.0)), (16, (-0.005, 0.08, 0.05)), (30, (-0.005, -0.1, 0.05)), (20, (0.06, 0.05, 0.05)),
    (10, (0.002, 0.05, 0.05)), (20, (0.3, 0.3, 0.05)), (30, (-0.02, -0.1, 0.05)),
)  # fmt: skip
"""Increments and separation (N, Tx, Ty) at their end: pressing, sliding and its reversal, opening, unloading,
complete rupture, closing."""


def layer(card: str, h: float, legs: tuple[tuple[int, tuple[float, float, float]], ...], kind: str) -> str:
    """One element of a layer of thickness h, 1 x 1, all displacements prescribed; `kind` follows *STATIC."""
    base = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=float)
    text = calculix_run.nodes(np.concatenate([base, base + np.array([0.0, 0.0, h])]))
    text += "*NSET, NSET=BOTTOM\n1, 2, 3, 4\n*NSET, NSET=TOP\n5, 6, 7, 8\n"
    text += calculix_run.elements("C3D8", "ROUGH", 1, [range(1, 9)])
    text += card + "*BOUNDARY\nBOTTOM, 1, 3\n"
    for n, (s_n, s_x, s_y) in legs:
        text += f"*STEP, INC=1000\n*STATIC{kind}\n{1.0 / n!r}, 1., 1e-4\n*BOUNDARY\n"
        text += f"TOP, 1, 1, {s_x}\nTOP, 2, 2, {s_y}\nTOP, 3, 3, {s_n}\n"
        text += "*EL PRINT, ELSET=ROUGH\nS, SDV\n*END STEP\n"
    return text


@pytest.mark.parametrize("h", [1.0, 1e-3])
def test_layer_is_the_driver(ccx: Path, h: float, tmp_path: Path) -> None:
    """Stresses of a thin layer are the driver's tractions, its state variables those of the library."""
    case = ["&material sigma0 = 3.0, Gc = 0.3, eta = 0.9, mu = 0.5, kc = 3.0 /\n"]
    case += ["&pattern sides = 4, theta = 30.0 /\n"]
    case += [
        f"&step s_N = {n}, s_Tx = {x}, s_Ty = {y}, increments = {parts} /\n" for parts, (n, x, y) in LEGS
    ]
    (tmp_path / "case.nml").write_text("".join(case))
    subprocess.run([driver(), "case.nml", "-o", "out.csv", "--quiet"], cwd=tmp_path, check=True)
    rows = History.from_csv(tmp_path / "out.csv")

    card = ROUGH.card("calculix", h=h, name="ROUGH")
    done = calculix_run.run(ccx, tmp_path, layer(card, h, LEGS, ", DIRECT"))
    assert done.code == 0, done.output[-500:]
    _, stress = done.table("ROUGH stresses")
    _, state = done.table("ROUGH internal")
    traction = stress[:, :, 2:][..., [N, TX, TY]]
    assert len(rows) == len(traction) and rows.damage[-1] == 1.0
    reach = STIFFNESS * np.maximum.accumulate(np.linalg.norm(rows.separation, axis=1))[:, None, None]
    worst = float((np.abs(traction - rows.traction[:, None]) / reach).max())
    print(
        f"h = {h:g}: {len(rows)} increments, difference of stresses {worst:.1e} K |s|, seven digits printed"
    )
    assert worst <= DIGITS
    expected = ROUGH.replay(rows.separation).state[:, None]
    # energies and slips are small compared with the terms of their sums
    assert np.all(np.abs(state[:, :, 2:] - expected) <= DIGITS * (1.0 + np.abs(expected)))


def test_exported_element(ccx: Path, tmp_path: Path) -> None:
    """The input of `asperity export calculix` gives the rows of the README."""
    one, _ = exported.element("calculix", tmp_path / "kit")
    done = calculix_run.run(ccx, tmp_path, (tmp_path / "kit" / "single.inp").read_text())
    assert done.code == 0, done.output[-500:]
    names = "TOP disp", "TOP total", "JOINT internal"
    moved, force, state = (done.table(name)[1] for name in names)
    rows = np.column_stack([moved[:, :, [1, 3]].mean(axis=1), force[:, 0, 0], state[:, :, 2].mean(axis=1)])
    exported.assert_same(one, rows, 10 * DIGITS)


def test_energy_release_in_mode_1(ccx: Path, tmp_path: Path) -> None:
    """Under opposite end moments a joint of five planes has the resistance Gc, as in LEFM."""
    result = dcb.run(ccx, tmp_path, dcb.ROUGH, -1.0, 0.06)
    steady = result.release[result.time > 0.85]
    print(f"energy release rate {steady.min():.4f} to {steady.max():.4f} N/mm, Gc 0.3")
    assert result.damage[-1].max() == 1.0 and result.damage[-1].min() == 0.0
    assert steady == pytest.approx(dcb.ROUGH.material.Gc, rel=1e-2)
    dcb.write_paraview(tmp_path / "beam.pvd", result)
    material = dcb.ROUGH.material
    printed = DIGITS * material.K * np.abs(result.separation).max() / material.sigma0
    paraview_check.against_the_law(tmp_path / "beam.pvd", dcb.ROUGH, printed)
    paraview_check.places(tmp_path / "beam.pvd", dcb.POINTS, up=2, layers=2)


def test_mixed_mode_and_the_symmetric_solver(ccx: Path, tmp_path: Path) -> None:
    """With a moment ratio of 0.5 the resistance is Gc without friction and larger with friction."""
    smooth = Interface(Material(20.0, 0.3, 0.95, 0.0), dcb.ROUGH.pattern)
    found = {}
    for name, interface in (("mu = 0", smooth), ("mu = 0.5", dcb.ROUGH)):
        result = dcb.run(ccx, tmp_path, interface, 0.5, 0.06, increments=40)
        steady = result.release[result.time > 0.95].mean()
        iterations = result.run.iterations
        found[name] = steady
        print(f"{name}: energy release rate {steady:.4f} N/mm, {result.run.attempts} attempts")
        print(f"  {len(iterations)} increments, {sum(iterations)} iterations, at most {max(iterations)}")
    # without friction the tangent is symmetric and each plane dissipates Gc in any mode; the error of
    # increments and elements is 1 %
    assert found["mu = 0"] == pytest.approx(0.3, rel=1e-2)
    assert found["mu = 0.5"] > 1.04 * found["mu = 0"]


def bed(n: int, h: float) -> str:
    """A layer of n x n elements whose upper nodes move at random, in ten increments."""
    grid = np.stack(np.meshgrid(np.arange(n + 1.0), np.arange(n + 1.0), [0.0, h], indexing="ij"), axis=-1)
    number = np.arange(1, grid[..., 0].size + 1).reshape(grid.shape[:3])
    around = ((0, 0), (1, 0), (1, 1), (0, 1))
    text = calculix_run.nodes(grid.reshape(-1, 3))
    corners = [
        [number[i + a, j + b, k] for k in (0, 1) for a, b in around] for i in range(n) for j in range(n)
    ]
    text += calculix_run.elements("C3D8", "ROUGH", 1, corners)
    text += "*NSET, NSET=BOTTOM\n" + calculix_run.numbers(number[:, :, 0].ravel())
    text += ROUGH.card("calculix", h=h, name="ROUGH") + ""
    text += "*BOUNDARY\nBOTTOM, 1, 3\n*STEP, INC=100\n*STATIC, DIRECT\n0.1, 1.\n*BOUNDARY\n"
    moves = np.random.default_rng(7).normal(0.0, 0.05, ((n + 1) ** 2, 3))
    for node, move in zip(number[:, :, 1].ravel().tolist(), moves.tolist(), strict=True):
        text += "".join(f"{node}, {axis}, {axis}, {value:.12g}\n" for axis, value in enumerate(move, 1))
    return text + "*EL PRINT, ELSET=ROUGH\nS, SDV\n*END STEP\n"


def test_two_threads_give_the_same_bytes(ccx: Path, tmp_path: Path) -> None:
    """With the UMAT in several threads and prescribed displacements the whole output is the same."""
    runs = [calculix_run.run(ccx, tmp_path, bed(16, 0.01), threads=k) for k in (1, 2)]
    assert runs[0].code == runs[1].code == 0
    assert "Using up to 2 cpu(s) for the stress calculation" in runs[1].output
    assert len(runs[0].data) > 1_000_000 and runs[0].data == runs[1].data
    _, state = runs[0].table("ROUGH internal")
    damage, friction = (2 + contract.statev_index(name) for name in ("damage", "friction"))
    assert state[-1, :, damage].max() > 0.9 and state[-1, :, friction].max() > 0.0
    print(f"{len(runs[0].data)} bytes of stresses and state variables are the same")


def test_a_rejected_call_cuts_the_increment(ccx: Path, tmp_path: Path) -> None:
    """A constant out of range gives a message and PNEWDT < 1; the run ends without a result."""
    card = ROUGH.card("calculix", h=1.0, name="ROUGH").replace("0.5, 30.0", "-0.5, 30.0")
    done = calculix_run.run(ccx, tmp_path, layer(card, 1.0, ((4, (0.01, 0.0, 0.0)),), ""))
    assert done.code == calculix_run.DIVERGED
    assert "asperity umat: PROPS(4) mu = -0.5: expected" in done.errors
    cuts = done.output.count("the increment is reattempted")
    print(f"exit code {done.code} after {cuts} cuts")
    assert cuts >= 2 and not done.increments


def test_damage_growth_cuts_the_increment(ccx: Path, tmp_path: Path) -> None:
    """PROPS 14: an increment in which damage grows too much is repeated with a smaller one."""
    try:
        card = ROUGH.card("calculix", h=1.0, name="ROUGH", dalpha=0.1)
    except ValueError as error:
        pytest.skip(str(error))
    legs = ((10, (0.3, 0.0, 0.0)),)
    free = calculix_run.run(ccx, tmp_path, layer(ROUGH.card("calculix", h=1.0, name="ROUGH"), 1.0, legs, ""))
    cut = calculix_run.run(ccx, tmp_path, layer(card, 1.0, legs, ""))
    assert free.code == cut.code == 0
    growth = [largest_growth(run) for run in (free, cut)]
    print(f"attempts {free.attempts} and {cut.attempts}")
    print(f"largest growth of damage {growth[0]:.2f} and {growth[1]:.2f}")
    assert growth[0] > 0.1 >= growth[1]
    assert cut.attempts > len(cut.increments)


def largest_growth(run: calculix_run.Run) -> float:
    """Largest growth of the damage of a plane in one increment."""
    _, state = run.table("ROUGH internal")
    damage: Floats = state[:, 0, 2 + contract.N_POINT_STATEV :: contract.N_PLANE_STATEV]
    return float(np.diff(damage, axis=0, prepend=0.0).max())
