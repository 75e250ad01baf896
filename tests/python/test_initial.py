"""Initial states with a traction, compared with closed forms and the independent reference."""


import asperity
import numpy as np
import pytest

TABLE_2 = asperity.Material(3.0, 0.3, 0.9, 0.5)
STIFFNESS = 3.0 / (0.1 * 0.2)
# residual of the solver: 1e-13 of the terms of the traction, which may be tens of times the traction
TOLERANCE = 1e-10
STATUS = asperity.contract.statev_index("status")
OFFSET = slice(asperity.contract.statev_index("offset_N"), asperity.contract.plane_statev(1))


def interface(sides=4):
    """RP-m of 30 degrees, Table 2."""
    return asperity.Interface(TABLE_2, asperity.Pattern.regular(sides, 30.0))


def test_cracked_planes():
    """A fully damaged flat plane sticks below mu p around its slip; the error beyond has the limit."""
    flat = interface(0)
    slip = [[0.3, -0.1]]
    state = flat.initial([-10.0, 4.9, 0.0], damage=1.0, slip=slip)
    np.testing.assert_allclose(
        state[OFFSET], np.array([-10.0, 4.9, 0.0]) / STIFFNESS + [0.0, 0.3, -0.1], rtol=0, atol=TOLERANCE
    )
    np.testing.assert_array_equal(flat.initial([-10.0, 4.9, 0.0], damage=1.0, slip=slip[0]), state)
    refused = r"t_Tx, t_Ty = 7.5, 0: outside the friction.*with t_N = -10 it carries (4.99|5)"
    with pytest.raises(ValueError, match=refused):
        flat.initial([-10.0, 7.5, 0.0], damage=1.0)
    with pytest.raises(ValueError, match="tension on a crack"):
        flat.initial([0.1, 0.0, 0.0], damage=[1.0])


def test_no_points():
    """No points have no states, and planes may be damaged in them."""
    assert interface(4).initial(np.zeros((0, 3)), damage=0.5).shape == (0, interface(4).nstatv)


@pytest.mark.parametrize(
    "call",
    [
        lambda law, z: law.initial(z),
        lambda law, z: law.update(z[None]),
        lambda law, z: law.replay([z]),
        lambda law, z: law.confined_slip(0.0, z, -1.0),
        lambda law, z: law.confined_slip(0.0, z.real, -1.0, times=z),
    ],
)
def test_complex_numbers(call):
    """A complex array is refused by name; its imaginary parts are not dropped."""
    with pytest.raises(ValueError, match=r"^(traction|s|S|slips|times)(\[.*\] = .*: expected a|: complex)"):
        call(interface(4), np.array([0.1 + 0j, 0.2 + 1j, 0.3 + 0j]))


def test_partly_cracked_pattern():
    """The damage of the planes is at least the initial damage."""
    law = interface(4)
    damage = [1.0, 0.5, 0.0, 0.25, 1.0]
    state = law.initial([-5.0, 0.5, 0.0], damage=damage)
    traction = law.update(np.zeros((1, 3)), state[None]).traction
    np.testing.assert_allclose(traction, [[-5.0, 0.5, 0.0]], rtol=0, atol=TOLERANCE * 5.0)
    assert np.all(state[asperity.contract.plane_statev(1) :: 3] >= damage)


@pytest.mark.parametrize(
    ("keywords", "message"),
    [
        ({"traction": [1.0, 2.0]}, r"traction has shape"),
        ({"traction": [np.nan, 0.0, 0.0]}, "initial t_N = NaN: expected a finite traction"),
        ({"traction": [-1.0, 0.0, 0.0], "damage": [0.0, 1.0]}, r"damage has shape \(2,\)"),
        ({"traction": [-1.0, 0.0, 0.0], "damage": 1.5}, r"STATEV\(9\) alpha = 1.5"),
        ({"traction": [-1.0, 0.0, 0.0], "slip": np.zeros((2, 2))}, "slip has shape"),
        ({"traction": [[0.0, 0.0, 0.0], [7.0, 0.0, 0.0]]}, r"point 1 \(of 0 to 1\).*beyond the strength"),
    ],
)
def test_bad_input(keywords, message):
    """Errors have the value and the expectation."""
    with pytest.raises(ValueError, match=message):
        interface(4).initial(**keywords)


def test_what_the_guard_held_back():
    """Damage that the guard delays on the load path has grown at its end: the traction is returned."""
    draw = np.random.default_rng(3)
    accepted = 0
    for _ in range(150):
        eta, mu = draw.uniform(0.6, 0.98), 0.5 * draw.random()
        material = asperity.Material(3.0, 0.3, eta, mu, kc=100.0, guard=True)
        rough = asperity.Interface(material, asperity.Pattern.regular(4, theta=draw.uniform(10.0, 50.0)))
        traction = 3.0 * draw.uniform([-0.2, -0.5, -0.5], [0.5, 0.5, 0.5])
        damage, slip = draw.random(5), 0.1 * draw.uniform(-1.0, 1.0, (5, 2))
        try:
            state = rough.initial(traction, damage=damage, slip=slip)
        except ValueError:
            continue
        accepted += 1
        result = rough.update(np.zeros((1, 3)), state[None])
        np.testing.assert_allclose(result.traction[0], traction, rtol=0, atol=TOLERANCE * 3.0)
    assert accepted > 40
