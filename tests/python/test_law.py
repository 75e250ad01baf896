"""The law with all its constants: units, closed forms, load paths, bad values.

Random updates are in test_oracle.py, load paths with known numbers, through every entry, in test_decks.py.
"""

from __future__ import annotations

import math
import warnings
from pathlib import Path

import numpy as np
import pytest
from asperity import EquilibriumLost, Interface, Material, ModelWarning, Pattern, Step, read_case
from asperity.contract import N_POINT_STATEV
from asperity.model_checks import model_warnings
from support_driver import MATERIAL
from support_driver import RP_4 as PYRAMID
from test_oracle import OPTIONS

SEED = 2025
DT = 0.1

UNITS = {"sigma0": (1, 0), "sigma02": (1, 0), "Gc": (1, 1), "Gc2": (1, 1), "W0": (1, 1), "height": (0, 1)}


@pytest.mark.parametrize("option", OPTIONS)
def test_units(option: str) -> None:
    """In units that are powers of two of the others the results are the same, to the last bit."""
    stress, length = 2.0**-20, 2.0**10
    constants = {"sigma0": 3.0, "Gc": 0.3, "eta": 0.9, "mu": 0.5} | OPTIONS[option]
    powers = UNITS | {"closure": (0, 1), "crush": (1, 0), "c": (1, -1)}
    converted = {
        name: value * stress ** powers.get(name, (0, 0))[0] * length ** powers.get(name, (0, 0))[1]
        for name, value in constants.items()
    }
    pattern = Pattern.regular(5, 30.0, 0.3, 20.0)
    first, second = (Interface(Material(**values), pattern) for values in (constants, converted))
    S = np.cumsum(np.random.default_rng(SEED).standard_normal((60, 10, 3)) * first.material.s_0, axis=0)
    s_old, state, scaled = np.zeros((10, 3)), np.zeros((10, first.nstatv)), np.zeros((10, first.nstatv))
    for s in S:
        answer = first.update(s, state, s_old, dt=DT)
        two = second.update(length * s, scaled, length * s_old, dt=DT)
        assert np.array_equal(stress * answer.traction, two.traction)
        assert np.array_equal(stress / length * answer.tangent, two.tangent)
        assert np.array_equal(stress * length * answer.state[:, 1:4], two.state[:, 1:4])
        state, scaled, s_old = answer.state, two.state, s


@pytest.mark.filterwarnings("ignore::asperity.ModelWarning")
@pytest.mark.parametrize(
    ("sides", "pressure", "spring", "height"),
    [(16, 0.0, 0.0, 0.0), (4, -5.0, 0.0, 0.0), (0, 2.0, 0.0, 0.0), (3, -1.0, 2.0, 0.2)],
)
def test_units_of_a_load_path(sides: int, pressure: float, spring: float, height: float) -> None:
    """Separations, tractions, work, snaps and losses of equilibrium scale with the units, to the last bit."""
    ends = []
    for stress, length in ((1.0, 1.0), (2.0**-20, 2.0**10)):
        constants = {"kc": 20.0, "height": height * length} if height else {}
        material = Material(3.0 * stress, 0.3 * stress * length, 0.9, 0.5, **constants)
        slips = {"slip": [0.4 * length, 0.1 * length], "direction": 7.0, "k_N": spring * stress / length}
        steps = [Step(t_N=pressure * stress, increments=5), Step(**slips, increments=30)]
        try:
            rows = Interface(material, Pattern.regular(sides, 30.0)).run(steps)
        except EquilibriumLost as lost:
            rows = lost.history
        released = [snap.released / (stress * length) for snap in rows.snaps]
        arrays = rows.separation / length, rows.traction / stress, rows.work / (stress * length)
        events = [(row, text.split(",")[0]) for row, text in rows.events]
        ends.append([*(array.tolist() for array in arrays), released, events])
    assert ends[0] == ends[1]
    assert len(released) == (sides == 16) and (len(rows) < 65) == (sides == 0)


@pytest.mark.parametrize("length", ["height", "closure"])
def test_lengths_are_compared_with_those_of_the_same_case(tmp_path: Path, length: str) -> None:
    """A length far beyond that of other joints is admissible beside a rupture energy of the same size."""
    case = tmp_path / "case.nml"
    case.write_text(
        f"&material sigma0 = 3, Gc = 1e12, eta = .9, mu = .5, {length} = 3e10 /\n"
        "&pattern sides = 2, theta = 30 /\n&step t_N = -1 /\n"
    )
    assert not read_case(case).runs[0].history().lost


def test_wear_of_a_huge_pressure_is_told() -> None:
    """A pressure whose square is beyond the range of a double gives the warning and no error of its own."""
    material = Material(3.0, 0.3, 0.9, 0.5, height=0.5, W0=1.0)
    assert any("Inf W0" in text for text in model_warnings(material, Pattern.regular(2, 30.0), -1e160))


def test_facet_beyond_its_end_is_flat() -> None:
    """Where nothing of the slope is left, the tangent is that of a flat contact, for the lowest height."""
    joint = Interface(Material(3.0, 0.3, 0.9, 0.5, height=1e-10 * 0.2), Pattern.regular(3, 89.9999, flat=0.0))
    state = np.zeros((1, joint.nstatv))
    state[0, N_POINT_STATEV::3] = 1.0
    s = np.array([[-46.0, -17.0, 1.6]])
    tangent = joint.update(s, state, s).tangent[0]
    assert np.abs(tangent).max() < 10.0 * joint.material.K


@pytest.mark.parametrize("ks", [50.0, 1e5])
def test_tolerance_of_a_stiff_joint(ks: float) -> None:
    """A joint without bond has no strength: the tolerance of a load path is relative to its tractions."""
    joint = Interface(Material.from_joint(kn=10.0 * ks, ks=ks, mu=0.5, height=0.2), Pattern.regular(2, 30.0))
    path = [Step(t_N=-1.0, increments=4), Step(slip=0.4, increments=2)]
    history = joint.run(path, tolerance=1e-3)
    fine = joint.confined_slip(0.0, np.linspace(0.0, 0.4, 2001), -1.0)
    slips = np.linspace(0.02, 0.4, 200)
    tau, wanted = (np.interp(slips, rows.separation[:, 1], rows.traction[:, 1]) for rows in (history, fine))
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


RUPTURES = [{}, {"kc": 20.0}, {"eta": 0.999}, {"sigma02": 4.0, "Gc2": 0.9}, {"guard": True}, {"c": 7.0}]


@pytest.mark.parametrize("constants", RUPTURES)
@pytest.mark.parametrize("n", [1, 2, 16])
def test_rupture_in_any_increment(constants: dict, n: int) -> None:
    """A bond that shears off without pressure has the rupture Gc, however few increments it takes."""
    joint = Interface(
        Material(**({"sigma0": 3.0, "Gc": 0.6655, "eta": 0.9, "mu": 0.5} | constants)),
        Pattern.regular(0, 0.0),
    )
    times = np.linspace(0.0, 1.0, n + 1)
    end = joint.replay(times[:, None] * [0.0, 0.6, 0.8], times).state[-1]
    assert end[2] == pytest.approx(constants.get("Gc2", 0.6655), abs=1e-9)
    assert end[0] == 1.0 and end[3] == 0.0


def test_rupture_of_a_viscous_jump() -> None:
    """Damage that follows a jump by tau_v sees the energy of later positions; slow damage that of all."""
    sigma0, Gc, eta = 3.0, 0.3, 0.9
    s_f = 2.0 * Gc / sigma0

    def grown(tau_v: float, opening: float) -> tuple[float, float]:
        """Damage and rupture after an opening from rest in the time 1."""
        material = Material(sigma0=sigma0, Gc=Gc, eta=eta, mu=0.5, tau_v=tau_v)
        new = Interface(material, Pattern.regular(0, 0.0)).update([[opening, 0.0, 0.0]], dt=1.0)
        return float(new.damage[0].sum()), float(new.rupture[0])

    # to the first order in tau_v
    more = 1e-3 * 2.0 * s_f * sigma0 * math.log(1.0 / (1.0 - eta)) / eta
    damage, rupture = grown(1e-3, 2.0 * s_f)
    assert rupture / damage - Gc == pytest.approx(more, rel=0.05)
    # damage that grows evenly along the opening: a third of the energy at the end
    damage, rupture = grown(300.0, 50.0 * s_f)
    end = 0.5 * sigma0 / ((1.0 - eta) * s_f) * (50.0 * s_f) ** 2
    assert rupture == pytest.approx(damage * end / 3.0, rel=0.03)


def test_rupture_of_a_jump_back_from_viscous_slip() -> None:
    """Damage that lags behind a slip grows at the start of an opening in which the slip goes back."""
    material = Material(sigma0=3.0, Gc=0.3, eta=0.9, mu=0.5, tau_v=0.01)
    joint = Interface(material, Pattern.regular(0, 0.0))
    slipped, opened = np.array([[-0.0023, 0.022, 0.0]]), np.array([[0.59, 0.017, 0.0]])
    state = joint.update(slipped, dt=0.1).state
    whole = joint.update(opened, state, slipped, dt=1.0).rupture[0]
    n, s = 2000, slipped
    for x in np.linspace(0.0, 1.0, n + 1)[1:, None]:
        end = slipped + x * (opened - slipped)
        state, s = joint.update(end, state, s, dt=1.0 / n).state, end
    assert whole == pytest.approx(state[0, 2], rel=0.1)


def test_rupture_of_viscous_damage_that_keeps_its_delay() -> None:
    """A finite height, whose long increments are taken in parts, books no less than straight planes do.

    Damage that follows a slip by tau_v grows as fast with the backward Euler method as in any parts.  What is
    stored and spent is the work; a trapezoid misses .5 % of it in 12 increments, whatever the height.
    """
    missing = []
    for height in (0.0, 0.1):
        material = Material(sigma0=0.25, Gc=0.018, eta=0.979, mu=0.75, tau_v=0.05, height=height)
        slip = np.linspace(0.0, 0.12, 13)
        s = np.column_stack([np.full(13, -0.003), slip, 0.0 * slip])
        history = Interface(material, Pattern.regular(4, 10.0)).replay(s, slip)
        work = 0.5 * ((history.traction[1:] + history.traction[:-1]) * np.diff(s, axis=0)).sum()
        spent = history.state[:, 1:4].sum(axis=1)
        missing.append((spent[-1] - spent[0]) / work - 1.0)
    assert max(map(abs, missing)) < 6e-3
    assert missing[1] == pytest.approx(missing[0], abs=5e-4)


def test_friction_of_a_jump() -> None:
    """A joint that opens as it slips has the friction of the straight path, in any increment."""
    mu, kn, ks, pressed, jump = 0.75, 82.0, 36.0, 10.0, 1.0
    joint = Interface(Material.from_joint(kn=kn, ks=ks, mu=mu), Pattern.regular(0, 0.0))
    closed = np.array([-pressed / kn, 0.1, 0.0])
    begin = joint.replay([[closed[0], 0.0, 0.0], closed]).state[-1:]
    # it slides from the bound of the pressure that is left to where it opens
    way = jump * np.array([(mu * pressed - ks * closed[1]) / (ks * jump + mu * kn * (jump - closed[0])), 0.0])
    way[1] = -closed[0] / (jump - closed[0]) * jump
    left = pressed - kn * (jump - closed[0]) * way / jump
    slid = (jump + mu * kn * (jump - closed[0]) / ks) * (way[1] - way[0]) / jump
    expected = mu * 0.5 * left.sum() * slid
    assert round(expected, 2) == 0.52
    for n in (1, 16, 4096):
        state, s = begin, closed
        for end in closed + np.linspace(0.0, 1.0, n + 1)[1:, None] * [jump - closed[0], jump, 0.0]:
            state, s = joint.update(end[None], state, s[None]).state, end
        assert state[0, 3] == pytest.approx(expected, rel=1e-3)


# --- viscous damage and cut requests ---

RP_4 = Interface(Material(3.0, 0.3, 0.9, 0.5, tau_v=0.4), Pattern.regular(4, 30.0))


def test_cut_requests(run, tmp_path: Path) -> None:
    """`dalpha` of &replay is PROPS 14: rows have the event `cut` where a plane's damage grew by more."""
    case, limit = MATERIAL + PYRAMID, 0.02
    run(case + "&step t_N = -5.0, increments = 20 /\n&step slip = 0.3, -0.2, increments = 40 /\n")
    (tmp_path / "case.csv").rename(tmp_path / "record.csv")
    rows = run(case + f"&replay file = 'record.csv', dalpha = {limit} /\n", "--planes")
    alpha = np.stack([rows[f"alpha_{k}"] for k in range(1, 6)], axis=1)
    growth = np.diff(alpha, axis=0, prepend=0.0).max(axis=1)
    cut = np.array(["cut" in events for events in rows.events])
    assert np.array_equal(cut, growth > limit)
    assert 0 < cut.sum() < len(cut)


# --- the bond of docs/how-to/cohesive-friction.md: QUADS, linear softening, power law ---

K_NN, T_N, G_N, T_S, G_S = 150.0, 3.0, 0.3, 4.0, 0.8
"""Normal stiffness, strengths and energies of the two modes (MPa/mm, MPa, N/mm)."""


@pytest.mark.parametrize("degrees", [0.0, 30.0, 45.0, 60.0, 90.0])
def test_bilinear_bond_of_abaqus(degrees: float) -> None:
    """With the constants of the page the tractions are those of the formulas of Abaqus' manuals."""
    eta = 1.0 - T_N**2 / (2.0 * K_NN * G_N)
    k_ss = T_S**2 / (2.0 * G_S * (1.0 - eta))
    bond = Material(sigma0=T_N, Gc=G_N, eta=eta, mu=0.5, kc=20.0, sigma02=T_S, Gc2=G_S)
    joint = Interface(bond, Pattern.regular(0, 0.0))
    normal, shear = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    path = np.linspace(0.0, 0.6, 601)[:, None] * [normal, shear, 0.0]
    length = np.linalg.norm(path, axis=1)
    onset = 1.0 / np.hypot(normal * K_NN / T_N, shear * k_ss / T_S)
    stiffness = np.array([K_NN * normal**2, k_ss * shear**2])
    energy = stiffness.sum() / (stiffness @ [1.0 / G_N, 1.0 / G_S])
    end = 2.0 * energy / (onset * stiffness.sum())
    damage = np.clip(end * (length - onset) / (np.maximum(length, onset) * (end - onset)), 0.0, 1.0)
    expected = (1.0 - damage)[:, None] * path * [K_NN, k_ss, k_ss]
    assert np.abs(expected).max() > 2.0
    # Rounding of tractions of a few MPa.
    assert joint.replay(path).traction == pytest.approx(expected, abs=1.0e-12)


def test_work_that_differs_from_energies() -> None:
    """A crack that slides in one increment has half its friction as work: a warning at the call says so."""
    crack = Interface(Material(sigma0=3.0, Gc=0.3, eta=0.9, mu=0.5, damage0=1.0), Pattern.regular(0, 0.0))
    pressed = Step(t_N=-4.0, increments=1)
    with pytest.warns(ModelWarning, match="^work and energies .* expected 2 % at most") as caught:
        crack.run([pressed, Step(slip=0.3, increments=1)])
    assert [warning.filename for warning in caught] == [__file__]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        crack.run([pressed, Step(slip=0.3, increments=100)])
        crack.run([pressed, Step(slip=0.3, increments=1)], tolerance=1e-3)
