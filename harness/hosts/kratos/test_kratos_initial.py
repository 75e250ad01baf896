"""Initial states in Kratos' interface elements: values in the UMAT, a prestressed joint in equilibrium."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from asperity import Interface, Material, Pattern, contract

pytest.importorskip("KratosMultiphysics.GeoMechanicsApplication", reason="asperity[kratos] is not installed")

import KratosMultiphysics as Kratos
import KratosMultiphysics.GeoMechanicsApplication as Geo
import prestressed
from kratos_model import Floats, Structure
from prestressed import TRACTION
from triplet import JOINT, LENGTH, PRESSURE

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


def _k0_procedure(s: Structure) -> None:
    for name, value in (("MAIN_DIRECTION", 2), ("VALUE_XX", 0.5), ("VALUE_YY", 0.5), ("VALUE_ZZ", 0.5)):
        variable = Kratos.KratosGlobals.GetVariable(f"K0_{name}")
        s.interfaces[0].Properties.SetValue(variable, value)
    settings = Kratos.Parameters('{"model_part_name": "Main", "use_standard_procedure": false}')
    process = Geo.ApplyK0ProcedureProcess(s.model, settings)
    process.ExecuteInitialize()
    process.ExecuteFinalizeSolutionStep()
    process.ExecuteFinalize()


def _stresses_of_the_last_stage(s: Structure) -> None:
    settings = Kratos.Parameters('{"model_part_name_list": ["Main"]}')
    process = Geo.ApplyFinalStressesOfPreviousStageToInitialState(s.model, settings)
    process.ExecuteInitialize()
    s.interfaces[0].Initialize(s.part.ProcessInfo)
    process.ExecuteBeforeSolutionLoop()


@pytest.mark.parametrize("hand_over", [_k0_procedure, _stresses_of_the_last_stage])
def test_stress_of_an_earlier_stage_does_not_reach_the_umat(hand_over: Callable[[Structure], None]) -> None:
    """After a pressure of 4 MPa and a transfer the point has no traction at separation zero: none was passed.
    """
    s, upper = one_element()
    s.move(upper, 2, -0.01)
    s.step(0.0)
    assert s.points()[1][0, 0] == pytest.approx(-4.0, abs=0.1)
    hand_over(s)
    s.move(upper, 2, 0.0)
    s.step(0.0)
    assert np.abs(s.points()[1]).max() <= EXACT * INTERFACE.material.sigma0


@pytest.mark.parametrize("elastic", [False, True])
def test_prestress_from_neighbours_does_not_reach_the_umat(elastic: bool) -> None:
    """Kratos can prestress a joint by the solid beside it: its own elastic law accepts this, a UMAT does not.
    """
    s = Structure(3)
    bottom, lower, upper = s.add_nodes(SQUARE - [0.0, 0.0, 1.0]), s.add_nodes(SQUARE), s.add_nodes(SQUARE)
    s.add_solid([*bottom, *lower], s.elastic(100.0, 0.0))
    properties = s.umat(INTERFACE)
    if elastic:
        name = "GeoIncrementalLinearElasticInterface3DSurfaceLaw"
        law = Kratos.KratosGlobals.Kernel.GetConstitutiveLaw(name)
        properties.SetValue(Kratos.CONSTITUTIVE_LAW, law.Clone())
        for name in ("INTERFACE_NORMAL_STIFFNESS", "INTERFACE_SHEAR_STIFFNESS"):
            properties.SetValue(Kratos.KratosGlobals.GetVariable(name), 10.0)
    s.add_interface(lower, upper, properties)
    s.fix([*bottom, *lower, *upper], 0, 1, 2)
    s.move([*lower, *upper], 2, -0.01)  # 1 MPa in the solid, no separation
    s.step(0.0)
    for name, elements in (("Joint", [s.interfaces[0].Id]), ("Solid", [1])):
        s.part.CreateSubModelPart(name).AddElements(elements)
    names = '"model_part_name": "Main.Joint", "model_part_name_for_neighbouring_elements": "Main.Solid"'
    Geo.FindNeighboursOfInterfacesProcess(s.model, Kratos.Parameters(f"{{{names}}}")).ExecuteInitialize()
    s.interfaces[0].Initialize(s.part.ProcessInfo)  # the next stage of an analysis does this
    expected = [-1.0, 0.0, 0.0] if elastic else [0.0, 0.0, 0.0]
    assert s.points()[1] == pytest.approx(np.tile(expected, (4, 1)), abs=1e-12)


REST = 1.0e-9
"""Displacement of bricks in equilibrium, relative to that without initial stress; see EXACT."""


@pytest.mark.parametrize(("name", "state", "direction"), prestressed.STARTS)
def test_prestressed_joint_rests_and_slides(name: str, state: Floats, direction: float) -> None:
    """Under the loads of the initial stress nothing moves; then the joint has its residual strength."""
    moved = np.abs(prestressed.run(bricks_stressed=False).displacement).max()
    result = prestressed.run(state, direction * prestressed.SLIPS)
    largest = float(np.abs(result.displacement[0]).max())
    print(f"{name}: at rest displacements up to {largest:.1e} mm, first residual {result.norms[0][0]:.1e} N")
    print(f"  without initial stress {moved:.1e} mm")
    assert largest <= REST * moved
    assert np.abs(result.traction[0] - TRACTION).max() <= EXACT * JOINT.material.sigma0
    expected = LENGTH * TRACTION[[1, 0]]
    assert -result.reaction[0] == pytest.approx(expected, abs=EXACT * JOINT.material.sigma0 * LENGTH)

    # the law in every point, by the library, from the same state
    points = np.tile(state, (result.separation.shape[1], 1))
    old = np.zeros_like(result.separation[0])
    for s, found in zip(result.separation, result.traction, strict=True):
        update = JOINT.update(s, points, old)
        points, old = update.state, s
        assert np.abs(found - update.traction).max() <= EXACT * JOINT.material.sigma0

    residual, strength = prestressed.residual_strength(direction), prestressed.strength(result)
    print(
        f"  largest strength {strength.max():.4f}, at the end {strength[-1]:.6f}, closed form {residual:.6f}"
    )
    # Newton's tolerance is 1e-11 of the forces
    assert strength[-1] == pytest.approx(residual, rel=1e-9)
    assert np.sign(result.traction[-1, :, 1]) == pytest.approx(direction)
    assert result.traction[-1, :, 0].mean() == pytest.approx(-PRESSURE, rel=1e-9)
    if np.all(state[contract.N_POINT_STATEV :: contract.N_PLANE_STATEV] == 1.0):
        assert strength.max() <= residual * (1.0 + 1e-9)
    else:
        assert strength.max() > 1.2 * residual


def test_prestressed_joint_needs_its_state() -> None:
    """If only the bricks have initial stress, the joint closes and slips by the separation of its stress."""
    offset = JOINT.initial(TRACTION)[[contract.statev_index("offset_Tx"), contract.statev_index("offset_N")]]
    top = prestressed.run().displacement[0, -prestressed.ROWS - 1 :]
    print(f"the upper brick moves by {top.mean(axis=0)} mm, the offset of the state is {offset} mm")
    # Newton's tolerance is 1e-11 of the forces
    assert np.abs(top - offset).max() <= 1e-9 * np.abs(offset).max()


def test_analyses_of_one_step() -> None:
    """Analyses with rising step numbers at the same addresses are distinguished by their initial state."""
    for damage in (0.0, 1.0, 0.5):
        traction = (1.0 + damage) * INITIAL
        s, _ = one_element(STATE_VARIABLES=INTERFACE.initial(traction, damage).tolist())
        s.step(0.0)
        assert s.points()[1][0] == pytest.approx(traction, abs=EXACT * INTERFACE.material.sigma0)


def test_next_stage_keeps_the_history() -> None:
    """Elements that are initialised again, as in the next stage of an analysis, continue with their history.
    """
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
