"""Initial states in Kratos' interface elements: values in the UMAT, a block in equilibrium."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from asperity import Interface, Material, Pattern

pytest.importorskip("KratosMultiphysics.GeoMechanicsApplication", reason="asperity[kratos] is not installed")

import KratosMultiphysics as Kratos
import KratosMultiphysics.GeoMechanicsApplication as Geo
from kratos_model import Floats, Structure

EXACT = 1.0e-10
"""Largest error of a returned initial traction over the strength, as the contract promises."""

INTERFACE = Interface(Material(sigma0=3.0, Gc=0.3, eta=0.9, mu=0.5, kc=3.0), Pattern.regular(4, theta=30.0))
INITIAL = np.array([-1.0, 0.3, -0.2])
SQUARE = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]])


def one_element(**other: object) -> tuple[Structure, Floats]:
    """One interface element with fixed nodes, and its upper nodes."""
    s = Structure(3)
    lower, upper = s.add_nodes(SQUARE), s.add_nodes(SQUARE)
    s.add_interface(lower, upper, s.umat(INTERFACE, **other))
    s.fix([*lower, *upper], 0, 1, 2)
    return s, upper


@pytest.mark.parametrize("damage", [0.0, 0.5, 1.0])
def test_state_variables_carry_a_traction(damage: float) -> None:
    """A point with a state of Interface.initial as STATE_VARIABLES has its traction, then follows the law."""
    state = INTERFACE.initial(INITIAL, damage)
    s, upper = one_element(STATE_VARIABLES=state.tolist())
    s.step(0.0)
    assert s.points()[1] == pytest.approx(np.tile(INITIAL, (4, 1)), abs=EXACT * INTERFACE.material.sigma0)
    rest = INTERFACE.update([[0.0, 0.0, 0.0]], state[None])
    s.move(upper, 0, 0.03)
    s.step(0.0)
    moved = INTERFACE.update([[0.0, 0.03, 0.0]], rest.state, [[0.0, 0.0, 0.0]])
    assert s.points()[1][0] == pytest.approx(moved.traction[0], abs=EXACT * INTERFACE.material.sigma0)


def _process(s: Structure) -> None:
    Kratos.SetInitialStateProcess3D(
        s.part, _vector(np.zeros(3)), _vector(INITIAL), Kratos.Matrix(3, 3)
    ).ExecuteInitializeSolutionStep()


def _variable(s: Structure) -> None:
    s.interfaces[0].SetValue(Kratos.INITIAL_STRESS_VECTOR, _vector(INITIAL))
    s.interfaces[0].Properties.SetValue(Kratos.INITIAL_STRESS_VECTOR, _vector(INITIAL))


def _uniform(s: Structure) -> None:
    values = ", ".join(map(str, INITIAL.tolist()))
    settings = Kratos.Parameters(f'{{"model_part_name": "Main", "value": [{values}]}}')
    Geo.ApplyInitialUniformStressField(s.part, settings).ExecuteInitialize()


def _points(s: Structure) -> None:
    stresses = [_vector(INITIAL)] * 4
    element = s.interfaces[0]
    element.SetValuesOnIntegrationPoints(Kratos.CAUCHY_STRESS_VECTOR, stresses, 3, s.part.ProcessInfo)


def _vector(values: Floats) -> Kratos.Vector:
    return Kratos.Vector(values.tolist())


@pytest.mark.parametrize("give", [_process, _variable, _uniform, _points])
def test_initial_stress_does_not_reach_the_umat(give: Callable[[Structure], None]) -> None:
    """Smallest cases that show that Kratos ignores the initial stress of an interface, without a message."""
    s, _ = one_element()
    s.initialise()
    give(s)
    s.step(0.0)
    assert not s.points()[1].any()


REST = 1.0e-9
"""Displacement of a block in equilibrium, relative to that without initial stress; see EXACT."""


@pytest.mark.parametrize("damage", [0.0, 0.5, 1.0])
def test_prestressed_block_rests(damage: float) -> None:
    """Under the load of its initial stress a block on a joint does not move, if both have this stress."""
    moved = []
    for stressed in (True, False):
        s = Structure(3)
        base, bottom = s.add_nodes(SQUARE), s.add_nodes(SQUARE)
        top = s.add_nodes(SQUARE - [0.0, 0.0, -1.0])
        state = INTERFACE.initial([-1.0, 0.0, 0.0], damage) if stressed else np.zeros(INTERFACE.nstatv)
        s.add_solid([*bottom, *top], s.elastic(3000.0, 0.2))
        s.add_interface(base, bottom, s.umat(INTERFACE, STATE_VARIABLES=state.tolist()))
        s.fix(base, 0, 1, 2)
        s.load({node: (0.0, 0.0, -0.25) for node in top})
        if stressed:
            s.stress_solids([0.0, 0.0, -1.0, 0.0, 0.0, 0.0])
        s.step(1e-10)
        moved.append(np.abs(s.displacements()).max())
        assert s.points()[1][:, 0] == pytest.approx(-1.0, abs=1e-9)
    print(f"displacements {moved[0]:.1e} mm, without initial stress {moved[1]:.1e} mm")
    assert moved[0] <= REST * moved[1]


def test_analyses_of_one_step() -> None:
    """Analyses with rising step numbers at the same addresses are distinguished by their initial state."""
    for damage in (0.0, 1.0, 0.5):
        traction = (1.0 + damage) * INITIAL
        s, _ = one_element(STATE_VARIABLES=INTERFACE.initial(traction, damage).tolist())
        s.step(0.0)
        assert s.points()[1][0] == pytest.approx(traction, abs=EXACT * INTERFACE.material.sigma0)


def test_next_stage_keeps_the_history() -> None:
    """Elements that are initialised again, as in the next stage of an analysis, keep their history."""
    s, upper = one_element()
    path = np.array([[0.05, 0.0, 0.0], [0.1, 0.0, 0.0], [0.02, 0.0, 0.0], [0.03, 0.0, 0.0]])
    expected = INTERFACE.replay(path).traction
    assert np.abs(INTERFACE.update(path[2:]).traction - expected[2:]).max() > INTERFACE.material.sigma0 / 3.0
    for k, (row, traction) in enumerate(zip(path, expected, strict=True)):
        if k == 2:
            s.interfaces[0].Initialize(s.part.ProcessInfo)
        s.move(upper, 2, row[0])
        s.step(0.0)
        assert s.points()[1][0] == pytest.approx(traction, abs=EXACT * INTERFACE.material.sigma0)
