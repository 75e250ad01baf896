"""Snaps of confined slips, and none where the curve of equilibria goes on; test_snap.pf has closed forms."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from asperity import Interface, Material, Pattern, Step

pytestmark = pytest.mark.filterwarnings("ignore::asperity.ModelWarning")


def joint(
    sides: int, theta: float, flat: float = 1.0 / 3.0, turn: float = 0.0, **constants: float
) -> Interface:
    """Material of Table 2 with other constants, and a regular pattern."""
    material = Material(**{"sigma0": 3.0, "Gc": 0.3, "eta": 0.9, "mu": 0.5} | constants)
    return Interface(material, Pattern.regular(sides, theta, flat, turn))


def even(last: float, n: int) -> np.ndarray:
    """Values last/n, 2 last/n, ..., last."""
    return last * np.arange(1, n + 1) / n


def test_jammed_joint_unloads() -> None:
    """A joint that jams between two planes of mu tan(theta) > 1 unloads along its elastic path."""
    ends = []
    for back in (50, 200):
        slips = np.concatenate([even(0.2, 100), 0.2 - even(0.1, back)])
        history = joint(2, 40.0, 0.0, mu=1.3, kc=100.0).confined_slip(0.0, slips, 0.0, preload=100)
        assert not history.snaps
        ends.append(history.traction[-1, 1])
    assert ends[0] > 3.0 and ends[1] == pytest.approx(ends[0], rel=0, abs=3e-9)


def test_wear_of_nothing() -> None:
    """A joint that an infinite work would wear has the rows of one that does not wear.

    Its facets are crushed on a hyperbolic closure of 9e7 MPa/mm, so that a rounding error of a separation is
    1e-9 MPa.
    """
    constants = {"eta": 0.99, "mu": 0.5718, "kc": 100.0, "height": 0.2, "closure": 0.02, "crush": 1.8838}
    path = [Step(t_N=-0.307, t_Ty=0.0, increments=20), Step(s_Tx=0.2, increments=60)]
    kept, worn = (
        joint(6, 55.676, 0.1, 184.294, **constants, W0=W0).run(path).separation for W0 in (0.0, 1e12)
    )
    np.testing.assert_allclose(worn, kept, rtol=0, atol=1e-9)


AXES = {
    "from its start": (
        joint(4, 74.1536451803456, 0.0, mu=0.7111518660691002, height=0.2, crush=9.957980127440536),
        [Step(t_N=-0.03612078757114445, increments=20), Step(s_Tx=0.2, increments=20)],
        True,
    ),
    "where facets close on the way": (
        joint(6, 75.98688976172996, 0.0, 30.0, eta=0.5, mu=0.5922788183775654, height=0.22444311630644173,
              crush=9.017179979728187),
        [Step(t_N=-6.9631485980879395, increments=20)],
        True,
    ),
    "without a snap": (
        joint(10, 30.0, turn=18.0, mu=0.5, height=0.0010853953310474673),
        [Step(t_N=-52.32100985375514, increments=10), Step(s_Tx=0.3, increments=39)],
        False,
    ),
}  # fmt: skip


@pytest.mark.parametrize("place", AXES)
def test_axis_of_symmetry_that_holds(place: str) -> None:
    """Where facets push back to the axis of symmetry, free across and held across is one, in a snap, too."""
    rough, (first, *others), snaps = AXES[place]
    free, held = (rough.run([replace(first, **across), *others]) for across in ({"t_Ty": 0.0}, {"s_Ty": 0.0}))
    assert bool(free.snaps) is snaps and len(free) == sum(map(len, [first, *others]))
    np.testing.assert_allclose(free.separation, held.separation, rtol=0, atol=1e-9)
    np.testing.assert_allclose(free.traction, held.traction, rtol=0, atol=1e-9)


@pytest.mark.parametrize("ratio", [1e-8, 1e-6, 1e6])
def test_giant_increments(ratio: float) -> None:
    """Of bonds with sigma02^2/Gc2 far from mode I only the brittle one snaps, at the start of its slip."""
    rough = joint(4, 30.0, sigma02=3.0, Gc2=0.3 / ratio)
    history = rough.confined_slip(0.0, even(0.4 * max(1.0, 1.0 / ratio), 20), -1.0, preload=1)
    assert [snap.row for snap in history.snaps] == ([0] if ratio > 1.0 else [])


def test_soft_spring_is_followed() -> None:
    """A rough joint of stiff contact on a soft spring is unloaded: its planes stay in contact, no snap."""
    rough = joint(7, 45.0, turn=-177.0, eta=0.99, mu=1.2, kc=1e4, guard=True)
    slips = [*even(0.3, 6), *(0.3 - even(0.3, 6))]
    history = rough.run([Step(t_N=0.0, increments=1), Step(slip=slips, increments=1, k_N=0.354)])
    assert len(history) == 13 and not history.snaps


@pytest.mark.parametrize("steps", [40, 100, 250, 1000])
def test_last_plane_without_pressure(steps: int) -> None:
    """The joint snaps when its last plane breaks; then s_N is the smallest opening without a contact."""
    turn, height = 348.84, 0.06
    constants = {"eta": 0.99, "mu": 0.8, "sigma02": 3.142, "Gc2": 0.3513, "kc": 100.0, "height": height}
    rough = joint(4, 34.34, turn=turn, **constants)
    history = rough.confined_slip(0.0, even(0.8, steps), 0.0, preload=1)
    intact = np.min([history.alpha(k) for k in range(1, 6)], axis=0) < 1.0
    broken = int(intact.sum())
    assert 0 < broken < steps and intact[:broken].all()
    assert [snap.row for snap in history.snaps if snap.row >= broken] == [broken]
    steepest = np.tan(np.radians(34.34)) * np.cos(np.radians(turn + 90.0 * np.arange(4))).max()
    climbed = steepest * history.separation[broken:, 1]
    opening = -height * np.expm1(-climbed / height)
    np.testing.assert_allclose(history.separation[broken:, 0], opening, rtol=0, atol=1e-10)


@pytest.mark.parametrize("kc", [1.0, 10.0, 600.0])
@pytest.mark.parametrize("remains", [0.02, 0.005, 0.001])
@pytest.mark.parametrize("pressure", [0.1, 1.0, 28.0])
def test_contact_near_its_largest_closure(kc: float, remains: float, pressure: float) -> None:
    """A contact up to 1e4 times stiffer than a slack one has an equilibrium, in which each slip ends."""
    # a flat joint closes by this largest closure but for the part that remains
    closure = pressure / (kc * 150.0) * remains / (1.0 - remains)
    history = joint(2, 30.0, kc=kc, closure=closure).confined_slip(0.0, even(0.3, 60), -pressure, preload=100)
    assert len(history) == 60


@pytest.mark.parametrize("n", [2, 3, 10])
def test_coarse_slips_break_no_bond(n: int) -> None:
    """A joint whose asperities let go in a snap stays bonded, however long the slips are that lead there."""
    constants = {"eta": 0.99, "sigma02": 7.11, "kc": 1.04, "height": 0.0104, "damage0": 0.22, "closure": 0.13}
    rough = joint(57, 46.4, 0.0, **constants)
    coarse, fine = (rough.confined_slip(95.0, even(0.15, k), 0.0, preload=10) for k in (n, 100))
    assert [snap.row for snap in coarse.snaps] == [n // 2]
    assert fine.separation[-1, 0] > 9.0 * constants["height"]
    np.testing.assert_allclose(coarse.separation[-1], fine.separation[-1], rtol=0, atol=1e-8)


def test_snap_that_turns_the_slip_back() -> None:
    """A snap across the slip is reported where the joint has moved as far ahead as the snap takes it back."""
    rough = joint(10, 30.0, turn=-318.0, height=0.04458, closure=3.6268e-5)
    springs = {"t_N": -5.3225, "k_N": 1.007431, "t_Ty": 0.0, "k_Ty": 0.577448}
    history = rough.run([Step(increments=10, **springs), Step(s_Tx=0.2045454545, increments=15, **springs)])
    assert [snap.row for snap in history.snaps] == [24]


def test_free_across_without_friction() -> None:
    """Across the slip of two broken planes without friction nothing holds the joint: it stays where it is."""
    across = joint(2, 25.16, eta=0.99, mu=0.0, kc=51.12, height=0.4747, closure=0.0435, crush=1.486)
    ends = []
    for name in ("t_Ty", "s_Ty"):
        held = {"t_N": -0.3935, name: 0.0}
        ends.append(across.run([Step(increments=20, **held), Step(s_Tx=0.4, increments=27, **held)]))
    assert not ends[0].separation[:, 2].any()
    np.testing.assert_allclose(ends[0].separation, ends[1].separation, rtol=0.0, atol=1e-9)


PLATEAUS = {
    "two facets alike": (
        joint(3, 36.6, turn=356.27, mu=0.0, kc=18.8, height=0.0099, closure=0.0053, damage0=1.0),
        -0.603,
        [0.4, 0.05],
    ),
    "a facet that pushes": (
        joint(5, 60.57, eta=0.99, mu=0.0, kc=33.2, height=0.00209, damage0=1.0),
        -0.0709,
        0.3,
    ),
    "a facet that pushes more and more": (
        joint(4, 30.0, turn=-23.0, mu=0.0, kc=0.369, height=0.00177),
        -0.315,
        [0.3, 0.05],
    ),
    "a stiff contact": (
        joint(5, 45.0, turn=-75.0, eta=0.99, mu=0.0, kc=38.3, height=0.00585),
        -0.2146,
        [0.3, 0.05],
    ),
}


@pytest.mark.parametrize("place", PLATEAUS)
def test_plateau_without_friction(place: str) -> None:
    """On facets that have been climbed the slope that is left holds nothing across, and pushes nowhere."""
    rough, pressure, slips = PLATEAUS[place]
    history = rough.run([Step(t_N=pressure, t_Ty=0.0, increments=20), Step(s_Tx=slips, increments=39)])
    assert history.separation[-1, 1] == np.atleast_1d(slips)[-1]
    np.testing.assert_allclose(history.traction[:, 2], 0.0, atol=1e-9)
    assert np.abs(history.separation[:, 2]).max() < 2.0 * np.abs(history.separation[:, 1]).max()  # no drift


@pytest.mark.parametrize("slope", [1e-12, 1e-11])
def test_soft_spring_across(slope: float) -> None:
    """A spring far softer than the bond holds a joint without friction: k s_Ty is the push of its slope."""
    planes = Pattern.planes([(1.0, 0.0, slope)], [1.0])
    smooth = Interface(Material(3.0, 0.3, 0.9, 0.0, damage0=1.0), planes)
    history = smooth.run(
        [Step(t_N=-1.0, t_Ty=0.0, k_Ty=1.5e-10, increments=10), Step(s_Tx=0.02, increments=10)]
    )
    assert len(history) == 20 and history.separation[-1, 2] == pytest.approx(slope / 1.5e-10, rel=1e-6)


@pytest.mark.parametrize("increments", [39, 100])
def test_axis_of_symmetry_that_is_weakly_unstable(increments: int) -> None:
    """A joint leaves the axis also where it is pushed off by less than a rounding error of its stiffness."""
    rough = joint(8, 16.5, eta=0.99, mu=0.0, kc=22.0, height=0.0079, damage0=1.0)
    history = rough.run([Step(t_N=-0.954, t_Ty=0.0, increments=20), Step(s_Tx=0.2, increments=increments)])
    assert history.snaps and abs(history.separation[-1, 2]) == pytest.approx(0.0543908, rel=0, abs=1e-6)
    np.testing.assert_allclose(history.traction[:, 2], 0.0, atol=1e-9)


@pytest.mark.parametrize("t_Ty", [1e-12, 3e-11])
def test_a_rounding_error_across_without_friction(t_Ty: float) -> None:
    """A traction of rounding errors across a joint that nothing holds is within the tolerance."""
    flat = Interface(Material(3.0, 0.3, 0.99, 0.0, damage0=1.0, kc=5.0), Pattern.regular(0, 0.0))
    history = flat.run([Step(t_N=-1.0, t_Ty=x, increments=4) for x in (0.0, t_Ty)])
    assert len(history) == 8 and abs(history.traction[-1, 1:]).max() < 1e-10
