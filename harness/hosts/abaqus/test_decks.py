"""The decks of `asperity export abaqus` in the stand-in, with the routines of libasperity, by `make hosts`.

Closed forms, the law on the history of every point, and balances; Abaqus itself was not run.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from asperity import Interface, Material, Pattern, contract, library
from asperity.export.deck_lines import residual
from asperity.export.decks import (
    BOX_SLIP,
    DCB_GC,
    DCB_HEIGHT,
    DCB_MODULUS,
    DCB_NU,
    DECKS,
    MU,
    SLIP,
    THETA,
    WALL_LENGTH,
    WALL_MU,
    WALL_PRESSURE,
    WALL_THETA,
)
from deck_check import model
from stand_in import StandIn

CONVERGED = 1.0e-8
"""Relative error of a force, with residuals of 1e-9."""

ROUNDING = 1.0e-12
"""Difference of the law from itself, over the strength."""


@cache
def run(name: str, single: bool = False, keep: int = 20) -> StandIn:
    """A deck, run once."""
    return StandIn(model(DECKS[name]())).run(library(), single, keep)


def energies(host: StandIn) -> np.ndarray:
    """Stored, rupture and friction energy of all joints."""
    first = contract.statev_index("stored")
    return (host.points.statev[:, first : first + 3] * host.points.area[:, None]).sum(axis=0)


@pytest.mark.parametrize(
    ("name", "nodes", "force"),
    [
        ("single_standard.inp", "TOP", residual(MU, THETA)),
        ("shear_box_2d.inp", "UPPER_TOP", 100.0 * residual(MU, THETA)),
        ("shear_box_3d.inp", "UPPER_TOP", 1600.0 * residual(MU, THETA)),
        ("wallette.inp", "COURSE_4_TOP", WALL_PRESSURE * WALL_LENGTH * residual(WALL_MU, WALL_THETA)),
    ],
)
def test_residual_force(name: str, nodes: str, force: float) -> None:
    """The force at the end is the closed form, which the comments of the deck name."""
    host = run(name)
    assert abs(host.total(host.rows[-1], nodes, 1) / force - 1.0) < CONVERGED
    assert f"{force:.6g} N." in DECKS[name]()
    # quadratic convergence: few iterations, no increment given up
    assert max(row.iterations for row in host.rows) <= 8


@pytest.mark.parametrize("name", ["shear_box_2d.inp", "shear_box_3d.inp"])
def test_shear_box_rises(name: str) -> None:
    """The platen stays level, and once the joint slides it rises by tan(theta) of the slip."""
    host = run(name)
    up = host.model.dimension
    top = host.model.nsets["UPPER_TOP"]
    last, before = host.rows[-1], host.rows[-6]
    heights = [host.displacement(last, node, up) for node in top]
    assert np.ptp(heights) < 1.0e-12
    assert abs(host.displacement(last, top[0], 1) - BOX_SLIP) < 1.0e-12
    slip = host.displacement(last, top[0], 1) - host.displacement(before, top[0], 1)
    rise = heights[0] - host.displacement(before, top[0], up)
    assert abs(rise / slip - np.tan(np.radians(THETA))) < 1.0e-6


def test_wallette_starts_at_rest() -> None:
    """Initial stress and loads balance; the cracked joint slides at once, and the others stay whole."""
    host = run("wallette.inp")
    rest = host.rows[0]
    assert rest.step == "REST" and np.abs(rest.u).max() < 1.0e-12
    assert np.abs(rest.traction - [-WALL_PRESSURE, 0.0]).max() < 1.0e-9
    damage = host.points.statev[:, contract.statev_index("damage")]
    cracked = np.isin(host.points.element, host.model.elsets["BED_2"])
    assert (np.abs(damage[cracked] - 1.0) < 1.0e-12).all() and (damage[~cracked] == 0.0).all()


def test_wallette_without_its_loads_moves() -> None:
    """The step at rest would not rest if load and initial stress differed."""
    deck = DECKS["wallette.inp"]().replace("COURSE_4_ROOF, P3, 0.5", "COURSE_4_ROOF, P3, 0.4")
    host = StandIn(model(deck)).run(library())
    # the courses alone, 200 mm with E = 5000 MPa, expand by more than this
    assert np.abs(host.rows[0].u).max() > 0.1 * 200.0 / 5000.0


def test_beam() -> None:
    """Half the increments leave a quarter of the difference of work and energies; the energy is Gc."""
    gaps = []
    finer = DECKS["dcb.inp"]().replace("0.02, 1., 1e-6, 0.02", "0.01, 1., 1e-6, 0.01")
    for host in (run("dcb.inp"), StandIn(model(finer)).run(library())):
        elastic = 0.5 * host.u @ (host.stiffness @ host.u)
        gaps.append(energies(host).sum() + elastic - host.work)
    assert 3.0 < gaps[0] / gaps[1] < 5.0
    # the crack length a that beams of this stiffness would have, and their energy release rate
    row = host.rows[-1]
    force = host.total(row, "UPPER_TIP", 2)
    rigidity = DCB_MODULUS / (1.0 - DCB_NU**2) * DCB_HEIGHT**3
    length = (2.0 * rigidity / (8.0 * force)) ** (1.0 / 3.0)
    rate = 12.0 * force**2 * length**2 / rigidity
    print(f"force {force:.6f} N, energy release rate {rate:.4f} N/mm, Gc = {DCB_GC} N/mm")
    # beam theory leaves out terms of the order of the square of height over length
    assert abs(rate / DCB_GC - 1.0) < (DCB_HEIGHT / length) ** 2


def oscillates_about(values: list[float], expected: float, share: float) -> bool:
    """Whether values oscillate about a number by a share of it at most: it is within their deviation."""
    mean, deviation = np.mean(values), np.std(values)
    return bool(abs(mean - expected) < deviation < share * abs(expected))


def test_explicit_element() -> None:
    """The element slides at the closed form and rises as the static one; single precision shows the same."""
    host, single, static = (
        run(*arguments)
        for arguments in (("single_explicit.inp",), ("single_explicit.inp", True), ("single_standard.inp",))
    )
    top = host.model.nsets["TOP"][0]
    late = host.rows[-100:]
    assert oscillates_about([host.total(row, "TOP", 1) for row in late], residual(MU, THETA), 0.01)
    assert abs(host.displacement(late[-1], top, 1) - SLIP) < ROUNDING
    slope = np.tan(np.radians(THETA))
    shift = [host.displacement(row, top, 3) - slope * host.displacement(row, top, 1) for row in late]
    end = static.rows[-1]
    expected = static.displacement(end, top, 3) - slope * static.displacement(end, top, 1)
    assert oscillates_about(shift, expected, 0.01)
    # every increment may lose half a unit in the last place of the separation
    lost = 20 * len(single.rows) * 2.0**-24 * SLIP
    assert np.abs(single.rows[-1].u - host.rows[-1].u).max() < lost


def test_explicit_shear_box() -> None:
    """The force oscillates about the closed form, and all planes are fully damaged."""
    host = run("shear_box_explicit.inp")
    late = [host.total(row, "UPPER_TOP", 1) for row in host.rows[-100:]]
    assert oscillates_about(late, 3600.0 * residual(MU, THETA), 0.1)
    damage = host.points.statev[:, contract.statev_index("damage")]
    assert np.abs(damage - 1.0).max() < ROUNDING


@pytest.mark.parametrize("name", [name for name in DECKS if "explicit" not in name])
def test_every_point_has_the_law(name: str) -> None:
    """The traction of every point is that of the Python package on the history of that point alone."""
    host = run(name)
    props = dict(zip([row.name for row in contract.props_table()], material_of(host).props, strict=True))
    constants = ("sigma0", "Gc", "eta", "mu", "sigma02", "Gc2", "tau_v", "kc", "height", "W0")
    law = Interface(
        Material(**{one: props[one] for one in constants}),
        Pattern.regular(int(props["m"]), props["theta"], props["flat"], props["turn"]),
    )
    dimension = host.model.dimension
    first = StandIn(host.model).points
    damage = contract.plane_statev(1)
    initial = [
        law.initial([*stress, 0.0][:3], damage=statev[damage]) if np.any(stress) else statev
        for stress, statev in zip(first.stress, first.statev, strict=True)
    ]
    state, old = np.array(initial), np.zeros((len(initial), 3))
    largest = 0.0
    for row in host.rows:
        separation = np.zeros_like(old)
        separation[:, :dimension] = host.points.separation(row.u)
        step = law.update(separation, state, old)
        largest = max(largest, np.abs(step.traction[:, :dimension] - row.traction).max())
        state, old = step.state, separation
    assert largest < ROUNDING * props["sigma0"]


def material_of(host: StandIn):
    """User material of a deck."""
    return host.model.materials[host.points.material]


def test_a_model_that_can_move() -> None:
    """A body without supports is found, as Abaqus would warn of numerical singularities."""
    deck = DECKS["shear_box_2d.inp"]().replace("LOWER_BOTTOM, 1, 2\n", "")
    with pytest.raises((ValueError, RuntimeError)):
        StandIn(model(deck)).run(library())
