"""Initial stress and state variables in CalculiX: values in the UMAT, and a slab in equilibrium."""

from __future__ import annotations

from pathlib import Path

import calculix_run
import geostatic
import numpy as np
import pytest
from asperity import contract
from calculix_run import DIGITS, Floats
from exported import SOLID as ROUGH
from exported import STIFFNESS, from_state
from geostatic import HEIGHT, JOINT, LENGTH, SLIDE, TRACTION, WIDTH
from test_calculix import layer

POINTS = range(1, geostatic.POINTS + 1)
STATUS = contract.statev_index("status")
OFFSET = slice(contract.statev_index("offset_N"), contract.N_POINT_STATEV)
"""Index in STATEV, from 0."""

DAMAGE = slice(contract.N_POINT_STATEV, None, contract.N_PLANE_STATEV)

REST = 1.0e-9
"""Displacement of a slab in equilibrium over that without initial stress: the initial stresses have twelve
digits, and a point returns its own to 1e-10 of the strength."""

STILL = ((1, (0.0, 0.0, 0.0)),)
"""One increment without displacement."""


BY_FILE = "*INITIAL CONDITIONS, TYPE=SOLUTION, USER\n"


def stressed(tractions: Floats) -> str:
    """Initial stresses of the points of element 1, from tractions (8, 3)."""
    rows = zip(POINTS, tractions.tolist(), strict=True)
    lines = (f"1, {point}, 0., 0., {n}, 0., {x}, {y}\n" for point, (n, x, y) in rows)
    return "*INITIAL CONDITIONS, TYPE=STRESS\n" + "".join(lines)


def test_type_stress_reaches_the_umat(ccx: Path, tmp_path: Path) -> None:
    """Every point gets its own initial stress once, with sign and order; without strain it is constant."""
    grade = np.linspace(0.1, 0.8, len(POINTS))[:, None]
    tractions = grade * [-1.0, 0.4, -0.2]
    text = layer(0.01, (*STILL, (3, (0.0, 0.01, 0.0))), ", DIRECT", stressed(tractions))
    done = calculix_run.run(ccx, tmp_path, text)
    traction, initial = done.vectors("ROUGH stresses"), ROUGH.initial(tractions)
    assert np.all(np.abs(traction[0] - tractions) <= DIGITS * np.abs(tractions).max())
    offset = initial[:, OFFSET]
    assert np.all(np.abs(done.state("ROUGH")[0, :, OFFSET] - offset) <= DIGITS * np.abs(offset).max())
    slips = np.arange(1, 4) * 0.01 / 3.0
    for k, state in enumerate(initial):
        expected = from_state(ROUGH, state, np.outer(slips, [0.0, 1.0, 0.0]))
        assert np.all(np.abs(traction[1:, k] - expected) <= DIGITS * STIFFNESS * slips[:, None])


def test_traction_that_cannot_be(ccx: Path, tmp_path: Path) -> None:
    """For tension beyond the strength the message has the largest traction; the run ends without a result."""
    text = layer(0.01, STILL, "", stressed(np.tile([6.0, 0.0, 0.0], (len(POINTS), 1))))
    done = calculix_run.run(ccx, tmp_path, text, code=calculix_run.DIVERGED)
    assert not done.iterations
    assert "asperity umat: initial t_N = 6: beyond the strength of the planes" in done.errors


def test_type_solution_by_file(ccx: Path, tmp_path: Path) -> None:
    """Every point gets its own state variables; a point without a row is virgin; empty lines are ignored."""
    states = {(1, k): ROUGH.initial([-0.1 * k, 0.0, 0.0], damage=k / 10.0) for k in POINTS if k != 3}
    calculix_run.write_states(tmp_path, states)
    file = tmp_path / calculix_run.STATES
    file.write_text("\n" + file.read_text().replace("\n", "\n\n"))
    done = calculix_run.run(ccx, tmp_path, layer(0.01, STILL, ", DIRECT", BY_FILE))
    expected = np.array([states.get((1, k), np.zeros(ROUGH.nstatv)) for k in POINTS])
    expected[:, STATUS] = 1.0
    assert np.all(np.abs(done.state("ROUGH")[0] - expected) <= DIGITS * np.abs(expected))


def test_states_of_no_point(ccx: Path, tmp_path: Path) -> None:
    """A row beyond the last point of the model is an error."""
    state = ROUGH.initial([-0.1, 0.0, 0.0], damage=0.5)
    calculix_run.write_states(tmp_path, {(1, 8): state, (2, 1): state})
    with pytest.raises(ValueError, match=r"initial_state\.txt: rows are left over"):
        calculix_run.run(ccx, tmp_path, layer(0.01, STILL, ", DIRECT", BY_FILE))


@pytest.mark.parametrize(
    ("row", "reason"),
    [
        (None, "initial_state.txt: expected a file with rows of element, point"),
        ("1 1 0.0 0.0", "too few"),
        ("1 9" + " 0" * ROUGH.nstatv, "rising order"),
        ("1 1" + " 0" * (ROUGH.nstatv + 1), "too many"),
        ("one" + " 0" * (ROUGH.nstatv + 1), "expected element and point"),
    ],
)
def test_wrong_file_of_states(ccx: Path, tmp_path: Path, row: str | None, reason: str) -> None:
    """A missing file, or a row of wrong length, without numbers or of no point, ends the run and is shown."""
    text = layer(0.01, STILL, "", BY_FILE)
    if row is not None:
        text += "*ELEMENT, TYPE=C3D8, ELSET=ROUGH\n2, 1, 2, 3, 4, 5, 6, 7, 8\n" if "9" in row else ""
        (tmp_path / calculix_run.STATES).write_text(row + "\n")
    done = calculix_run.run(ccx, tmp_path, text, code=calculix_run.DIVERGED)
    assert f"initial_state.txt: {row}: " in done.errors or row is None
    assert reason in done.errors


PARTLY = [1.0, 0.5, 0.0]


@pytest.mark.parametrize(
    ("name", "given", "damage"),
    [("virgin, TYPE=STRESS", {}, 0.0),
     ("cracked, TYPE=STRESS and SOLUTION", {"state": geostatic.crack()}, 1.0),
     ("cracked, TYPE=SOLUTION", {"state": JOINT.initial(TRACTION, 1.0), "traction": 0.0}, 1.0),
     ("partly cracked, TYPE=SOLUTION", {"state": JOINT.initial(TRACTION, PARTLY), "traction": 0.0}, PARTLY)],
)  # fmt: skip
def test_slab_starts_at_rest_and_slides(
    ccx: Path, tmp_path: Path, name: str, given: dict[str, Floats], damage: float | list[float]
) -> None:
    """Under its weight and initial stress the slab is in equilibrium; then it slides."""
    result = geostatic.run(ccx, tmp_path, SLIDE, **given)
    moved = geostatic.run(ccx, tmp_path, rock=False, traction=0.0).displacement[0]
    weight = LENGTH * WIDTH * HEIGHT * geostatic.PULL
    largest = float(np.abs(result.displacement[0]).max())
    print(f"{name}: at rest displacements up to {largest:.1e} m, {result.run.iterations[0]} iterations")
    assert largest <= REST * np.abs(moved).max()
    assert np.all(np.abs(result.traction[0] - TRACTION) <= DIGITS * np.abs(TRACTION).max())
    assert np.all(np.abs(result.reaction[0] + weight) <= len(moved) * DIGITS * np.abs(weight).max())
    assert np.all(result.state[0][:, DAMAGE] == damage)

    # the law of one point, by the library, on the separations that CalculiX found
    reach = float(np.linalg.norm(result.separation[-1, 0]))
    expected = from_state(JOINT, JOINT.initial(TRACTION, damage), result.separation[:, 0])
    k_c = JOINT.material.kc * JOINT.material.K
    assert np.all(np.abs(result.traction[:, 0] - expected) <= DIGITS * k_c * reach)

    strength = -result.traction[:, :, 1] / result.traction[:, :, 0]
    residual = geostatic.residual_strength()
    end = float(strength[-1].mean())
    print(f"  largest strength {strength.max():.4f}, at the end {end:.6f}, closed form {residual:.6f}")
    assert strength[-1] == pytest.approx(residual, rel=2.0 * DIGITS)
    if damage == 1.0:
        assert strength.max() <= residual * (1.0 + 2.0 * DIGITS)
    else:
        assert strength.max() > 1.5 * residual


def test_symmetrised_tangent_under_dead_load(ccx: Path, tmp_path: Path) -> None:
    """If the slab is moved at its top, its stiffness is in series with the joint: CalculiX diverges.

    CalculiX symmetrises the tangent; Newton's method on the tangent of the library is quadratic (Kratos).
    """
    with pytest.raises(RuntimeError, match=r"increment size smaller than minimum|too many cutbacks"):
        geostatic.run(ccx, tmp_path, SLIDE, moved="TOP")
