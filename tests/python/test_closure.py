"""Planes cracked from the start and hyperbolic closure: the library against the independent reference."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from asperity import Interface, Material, Pattern, Step, read_case

from tests.oracle import reference

SEED = 2025
DT = 0.1

OPTIONS = {
    "damage0": {"damage0": 0.4},
    "without bond": {"damage0": 1.0, "kc": 10.0},
    "closure": {"closure": 0.06},
    "closure and height": {"closure": 0.06, "height": 0.3},
    "closure and wear": {"closure": 0.06, "height": 0.3, "W0": 0.5},
    "closure and guard": {"closure": 0.06, "guard": True},
    "closure and viscosity": {"closure": 0.06, "tau_v": 0.3, "damage0": 0.2},
    "almost closed": {"closure": 0.02, "damage0": 0.5},
    "crush": {"crush": 2.0, "kc": 20.0},
    "crush and height": {"crush": 1.0, "height": 0.3, "damage0": 1.0, "kc": 50.0},
    "crush and wear": {"crush": 5.0, "W0": 0.4, "damage0": 0.5},
    "crush and guard": {"crush": 2.0, "height": 0.5, "guard": True},
    "mode II": {"closure": 0.06, "damage0": 0.3, "sigma02": 4.0, "Gc2": 0.6},
    "all": {
        "closure": 0.06,
        "damage0": 0.3,
        "kc": 2.0,
        "height": 0.3,
        "W0": 0.5,
        "crush": 3.0,
        "guard": True,
        "tau_v": 0.3,
        "sigma02": 4.0,
        "Gc2": 0.6,
    },
}


@pytest.mark.parametrize("option", OPTIONS)
def test_random_updates(option: str) -> None:
    """Traction, state and tangent agree for random histories of 40 points; deep closure occurs."""
    material = Material(3.0, 0.3, 0.9, 0.5, **OPTIONS[option])
    parameters = reference.Parameters(3.0, 0.3, 0.9, 0.5, **OPTIONS[option])
    rng = np.random.default_rng(SEED)
    far = 0
    for sides in (0, 2, 5):
        interface = Interface(material, Pattern.regular(sides, 30.0, 0.3, 20.0))
        planes = reference.regular_pattern(sides, 30.0, 0.3, 20.0)
        steps = rng.standard_normal((40, 40, 3)) * material.s_0
        S = np.cumsum(steps, axis=0)
        s_old, state = np.zeros((40, 3)), np.zeros((40, interface.nstatv))
        for s in S:
            ours = interface.update(s, state, s_old, dt=DT)
            theirs = reference.update(parameters, planes, s, state, s_old, DT)
            size = np.abs(theirs.traction).max(axis=1) + parameters.Kn * np.linalg.norm(s, axis=1)
            stiff = np.abs(theirs.tangent).max(axis=(1, 2)) + parameters.Kn
            energy = size * (np.linalg.norm(s, axis=1) + np.linalg.norm(s_old, axis=1))
            assert np.all(np.abs(ours.traction - theirs.traction).max(axis=1) <= 1e-11 * size)
            scale = (1.0 + energy + np.abs(theirs.state).max(axis=1))[:, None]
            assert np.all(np.abs(ours.state - theirs.state) <= 1e-11 * scale)
            off = np.abs(ours.tangent - theirs.tangent).max(axis=(1, 2)) > 1e-6 * stiff
            assert off.mean() <= 0.05  # a trial slip of almost zero
            far += int((stiff > 20.0 * parameters.Kn * parameters.kc).sum())
            state, s_old = ours.state, s
    if "closure" in OPTIONS[option]:
        assert far > 0


UNITS = {"sigma0": (1, 0), "sigma02": (1, 0), "Gc": (1, 1), "Gc2": (1, 1), "W0": (1, 1), "height": (0, 1)}


@pytest.mark.parametrize("option", OPTIONS)
def test_units(option: str) -> None:
    """In units that are powers of two of the others the results are the same, to the last bit."""
    stress, length = 2.0**-20, 2.0**10
    constants = {"sigma0": 3.0, "Gc": 0.3, "eta": 0.9, "mu": 0.5} | OPTIONS[option]
    powers = UNITS | {"closure": (0, 1), "crush": (1, 0)}
    other = {
        name: value * stress ** powers.get(name, (0, 0))[0] * length ** powers.get(name, (0, 0))[1]
        for name, value in constants.items()
    }
    pattern = Pattern.regular(5, 30.0, 0.3, 20.0)
    first, second = (Interface(Material(**one), pattern) for one in (constants, other))
    S = np.cumsum(np.random.default_rng(SEED).standard_normal((60, 10, 3)) * first.material.s_0, axis=0)
    s_old, state, scaled = np.zeros((10, 3)), np.zeros((10, first.nstatv)), np.zeros((10, first.nstatv))
    for s in S:
        one = first.update(s, state, s_old, dt=DT)
        two = second.update(length * s, scaled, length * s_old, dt=DT)
        assert np.array_equal(stress * one.traction, two.traction)
        assert np.array_equal(stress / length * one.tangent, two.tangent)
        assert np.array_equal(stress * length * one.state[:, 1:4], two.state[:, 1:4])
        state, scaled, s_old = one.state, two.state, s


@pytest.mark.parametrize("length", ["height", "closure"])
def test_lengths_are_compared_with_those_of_the_same_case(tmp_path: Path, length: str) -> None:
    """A length far beyond that of other joints is admissible beside a rupture energy of the same size."""
    case = tmp_path / "case.nml"
    case.write_text(
        f"&material sigma0 = 3, Gc = 1e12, eta = .9, mu = .5, {length} = 3e10 /\n"
        "&pattern sides = 2, theta = 30 /\n&step t_N = -1 /\n"
    )
    assert not read_case(case).runs[0].history().lost


@pytest.mark.parametrize("option", ["damage0", "closure", "almost closed"])
@pytest.mark.parametrize("through", ["umat", "vumat"])
def test_hosts(run, tmp_path: Path, option: str, through: str) -> None:
    """The separations of a direct run through UMAT and VUMAT give its rows."""
    entries = "".join(f", {name} = {value}" for name, value in OPTIONS[option].items())
    head = f"&material sigma0 = 3.0, Gc = 0.3, eta = 0.9, mu = 0.5{entries} /\n"
    head += "&pattern sides = 4, theta = 20.0 /\n"
    steps = (
        "&step t_N = -4.0, increments = 20 /\n&step slip = 0.3, -0.1, direction = 20.0, increments = 60 /\n"
    )
    direct = run(head + steps)
    (tmp_path / "case.csv").rename(tmp_path / "record.csv")
    replay = run(head + f"&replay file = 'record.csv', through = '{through}', h = 2.0 /\n")
    for name in ("t_N", "t_Tx", "t_Ty", "damage", "stored", "rupture", "friction"):
        np.testing.assert_allclose(replay[name], direct[name], rtol=0.0, atol=1e-10, err_msg=name)


@pytest.mark.filterwarnings("ignore::asperity.ModelWarning")
def test_random_load_paths() -> None:
    """No pressed joint is lost; work and energies agree to second order; the damage is at most 1."""
    rng = np.random.default_rng(SEED)
    errors = []
    for option in list(OPTIONS) * 2:
        material = Material(3.0, 0.3, 0.9, 0.5, **OPTIONS[option])
        joint = Interface(
            material, Pattern.regular(int(rng.choice([0, 2, 4, 8])), rng.uniform(5.0, 40.0), 0.2)
        )
        pressure, direction = -(10.0 ** rng.uniform(-1.0, 1.0)), rng.uniform(0.0, 360.0)
        turns = rng.uniform(-0.3, 0.3, 2).tolist()
        for finer in (1, 4):
            steps = [Step(t_N=pressure, increments=20 * finer, time=1.0)]
            spring = {"k_N": 20.0} if pressure < -1.0 else {}
            steps += [Step(slip=turns, direction=direction, increments=60 * finer, time=1.0, **spring)]
            history = joint.run(steps)
            assert history.damage.max() <= 1.0
            off = history.work - (history.stored + history.rupture + history.friction)
            errors.append(np.abs(off).max() / (np.abs(history.work).max() + material.Gc))
    coarse, fine = np.median(errors[::2]), np.median(errors[1::2])
    assert fine < coarse / 6.0 and fine < 1e-3


@pytest.mark.parametrize("ks", [50.0, 1e5])
def test_tolerance_of_a_stiff_joint(ks: float) -> None:
    """A joint without bond has no strength: the tolerance of a load path is relative to its tractions."""
    joint = Interface(Material.from_joint(kn=10.0 * ks, ks=ks, mu=0.5, height=0.2), Pattern.regular(2, 30.0))
    path = [Step(t_N=-1.0, increments=4), Step(slip=0.4, increments=2)]
    found = joint.run(path, tolerance=1e-3)
    fine = joint.confined_slip(0.0, np.linspace(0.0, 0.4, 2001), -1.0)
    slips = np.linspace(0.02, 0.4, 200)
    tau, wanted = (np.interp(slips, one.separation[:, 1], one.traction[:, 1]) for one in (found, fine))
    # rows on which straight lines stay within the tolerance are left out
    np.testing.assert_allclose(tau, wanted, rtol=0.0, atol=2e-3 * wanted.max())


def test_damage_of_a_broken_joint_is_1() -> None:
    """The weighted sum of the damage of the planes is not above 1, whatever the weights round to."""
    for sides in range(2, 65):
        joint = Interface(Material.from_joint(kn=20.0, ks=5.0, mu=0.5), Pattern.regular(sides, 30.0))
        damage = joint.update(np.zeros((5, 3))).state[:, 0]
        assert np.all((damage > 1.0 - 1e-14) & (damage <= 1.0))
        history = joint.confined_slip(0.0, [0.01], -1.0, 1)
        assert history.damage.max() <= 1.0


def test_bad_values() -> None:
    """Both are named at once, with what was expected; a reserved constant has no name in Python."""
    with pytest.raises(ValueError) as error:
        Material(3.0, 0.3, 0.9, 0.5, damage0=1.5, closure=-1.0)
    assert "damage0 = 1.5: expected 0 to 1" in str(error.value)
    assert "closure = -1: expected >= 0" in str(error.value)
    with pytest.raises(TypeError):
        Material(3.0, 0.3, 0.9, 0.5, slot22=0.0)
