"""Doors of host programs: the path decks by the calls of a host, imitated as its documents describe them.

A host with a door has `calls.py` in its folder, whose points take separations and return tractions.
"""

from __future__ import annotations

import ctypes
import re
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
from asperity import EquilibriumLost, Interface, Material, Pattern, contract, read_case

from harness.hosts.abaqus import calls as abaqus
from harness.hosts.diana import calls as diana
from harness.hosts.exported import PLANE, SOLID, path
from harness.hosts.itasca import calls as itasca
from harness.hosts.lsdyna import calls as lsdyna

ROOT = Path(__file__).parents[2]
CALLS = [
    import_module(f"harness.hosts.{path.parent.name}.calls")
    for path in sorted((ROOT / "harness" / "hosts").glob("*/calls.py"))
]
DOORS = {
    f"{calls.__name__} {name}": getattr(calls, name)
    for calls in CALLS
    for name in ("Points", "ExplicitPoints")
    if getattr(calls, "available", lambda: True)() and hasattr(calls, name)
}
SENSITIVE = "wear_coarse"
"""A deck of long increments with wear: separations that change by 1e-15 change its tractions by 100 MPa."""

DECKS = [deck for deck in sorted((ROOT / "tests" / "decks").glob("*.nml")) if deck.stem != SENSITIVE]
ROUNDING = 1e-10
"""Relative to the largest traction and to K |s|: separations are sums of increments."""
SHARES = 1.0, 0.5
"""Points of a block: each takes this share of the separations of a deck."""

CRUSHED = Interface(
    Material.from_joint(kn=20.0, ks=10.0, mu=0.5, fc=4.0, Gfc=3.0, kp=0.1), Pattern.regular(2, 10.0)
)
"""A joint whose compressive strength is exceeded where s_N is -0.3."""

MOST = 150
"""Rows that are taken of a history without wear, which needs short increments."""

pytestmark = pytest.mark.filterwarnings("ignore::asperity.ModelWarning")


def paths(deck: Path):
    """Interface, separations and ends of the increments of each case of a deck that begins virgin and dry."""
    for run in read_case(deck).runs:
        try:
            history = run.history()
        except EquilibriumLost as lost:
            history = lost.history
        if run.state is None and len(history) > 1 and not np.any(getattr(history, "water", 0.0)):
            yield run.interface, history


@pytest.mark.slow
@pytest.mark.parametrize("deck", DECKS, ids=lambda path: path.stem)
def test_doors(deck: Path) -> None:
    """Each point of a block has the tractions, damage and energies of the driver on its own separations."""
    for interface, history in paths(deck):
        material = interface.material
        every = -(-len(history) // MOST) if material.W0 == 0.0 and material.crush == 0.0 else 1
        taken = np.arange(len(history))[every - 1 :: every]
        time = history.time[taken]
        steps, times = np.diff(time, prepend=0.0), time if material.tau_v > 0.0 or material.c > 0.0 else None
        separations = [share * history.separation[taken] for share in SHARES]
        expected = [interface.replay(s, times) for s in separations]
        divided = [{"substeps", "snap"} & {*text.split("+")} for rows in expected for _, text in rows.events]
        if any(divided):
            continue  # hosts do not divide increments
        s = np.stack(separations, axis=1)
        traction, state = np.stack([e.traction for e in expected], 1), [e.state[-1, :4] for e in expected]
        size = np.abs(traction).max() + material.K * np.abs(s).max()
        for door in DOORS:
            points = DOORS[door](interface.props(), len(SHARES))
            starts = [np.zeros((len(SHARES), 3)), *s[:-1]]
            rows = [points.step(*row) for row in zip(starts, s, steps.tolist(), strict=True)]
            np.testing.assert_allclose(rows, traction, 0.0, ROUNDING * size, err_msg=door)
            np.testing.assert_allclose(points.state[:, :4], state, 0.0, ROUNDING * (1.0 + size), err_msg=door)


def numbers(text: str) -> list[float]:
    """Numbers of a text."""
    return [float(word) for word in re.findall(r"(?<![\w.-])-?\d[\d.]*(?:e[+-]\d+)?(?![\w.])", text)]


def test_constants_of_the_cards() -> None:
    """The constants of a card are PROPS to the bit, as many state variables as the law has."""
    joint = Interface(
        Material(sigma0=1 / 3, Gc=0.02, eta=0.9, mu=0.7, W0=5.0), Pattern.regular(4, 20.0, turn=15.0)
    )
    props = joint.props().tolist()
    card = joint.card("diana")
    entries = card.split("USRIFC ASPERI\n")[1]
    values, states = entries.split("USRVAL")[1].split("USRSTA")
    assert numbers(values) == props and numbers(states.split("USRIND")[0]) == [0.0] * joint.nstatv
    assert max(map(len, entries.splitlines())) <= 80 and "USRIND 0" in states
    card = joint.card("itasca", name="bed")
    assert [float(value) for value in re.findall(r" p\d+=(\S+)", card)] == props
    card = joint.card("lsdyna", density=2.0e-9)
    lines = [line for line in card.splitlines() if not line.startswith("$")]
    fields = [[line[i : i + 20].strip() for i in range(0, len(line), 20)] for line in lines[2:]]
    assert (float(fields[0][1]), fields[0][2:5]) == (2e-9, ["41", "36", str(joint.nstatv + lsdyna.HISTORY)])
    assert [float(field) for row in fields[2:] for field in row][2:34] == props
    with pytest.raises(ValueError, match="density is missing"):
        joint.card("lsdyna")


def test_tangent_of_diana() -> None:
    """STIFF is the tangent of the library by rows and columns of TRA and U, in space and in the plane."""
    for joint, nt in ((SOLID, 3), (PLANE, 2)):
        points, state, start = diana.Points(joint.props(), 1, nt), None, np.zeros((1, 3))
        for end in path(plane=nt == 2)[:, None]:
            points.step(start, end)
            expected = joint.update(end, state, start)
            known = expected.tangent[:, :nt, :nt]
            np.testing.assert_allclose(points.stiff, known, 0.0, 1e-10 * joint.material.kc * joint.material.K)
            state, start = expected.state, end
        np.testing.assert_allclose(points.tra, expected.traction[:, :nt], 0.0, ROUNDING * joint.material.K)


@pytest.mark.parametrize("joint", [SOLID, PLANE, CRUSHED], ids=["solid", "plane", "crushed"])
def test_contact_of_abaqus(joint: Interface) -> None:
    """DDSDDR is the tangent for penetration and pressure, the energies are those of the state, per area."""
    ndir = 2 if joint is PLANE else 3
    sign, scale = abaqus.SIGN[:ndir], 1e-10 * joint.material.kc * joint.material.K
    points, state, start = abaqus.Points(joint.props(), 1, ndir), None, np.zeros((1, 3))
    for end in path(plane=ndir == 2)[:, None] - (0.3 if joint is CRUSHED else 0.0) * np.eye(3)[0]:
        points.step(start, end)
        expected = joint.update(end, state, start)
        tangent = expected.tangent[:, :ndir, :ndir] * np.outer(sign, sign)
        np.testing.assert_allclose(points.stiffness, tangent, 0.0, scale)
        state, start = expected.state, end
    stored, rupture, friction = state[0, 1:4]
    crushing = state[0, -1] if joint is CRUSHED else 0.0
    np.testing.assert_allclose(points.energies, [(stored, friction, crushing, rupture)], 0.0, 1e-10)
    assert (crushing > 0.1) == (joint is CRUSHED) and points.closed == [1]
    points.step(start, np.array([[1e3, 0.0, 0.0]]))
    assert points.closed == [0] and not points.stress.any()


@pytest.mark.parametrize("joint", [SOLID, PLANE, CRUSHED], ids=["solid", "plane", "crushed"])
def test_contact_of_abaqus_explicit(joint: Interface) -> None:
    """Energies of 70 nodes that begin at a gap of their own are those of the state, per area."""
    ndir, n = 2 if joint is PLANE else 3, 70
    gaps = 1e-3 * np.arange(n)[:, None] * np.eye(3)[0]
    points, state, start, sums = abaqus.ExplicitPoints(joint.props(), n, ndir), None, gaps, np.zeros((3, n))
    for end in path(plane=ndir == 2)[:, None] - (0.3 if joint is CRUSHED else 0.0) * np.eye(3)[0] + gaps:
        traction = points.step(start, end)
        expected = joint.update(end, state, start)
        np.testing.assert_allclose(traction, expected.traction, 0.0, ROUNDING * joint.material.K)
        state, start = expected.state, end
        sums += points.densities[:3]
    crushing = state[:, -1] if joint is CRUSHED else np.zeros(n)
    np.testing.assert_allclose(sums, [state[:, 3], state[:, 2], crushing], 0.0, ROUNDING)
    np.testing.assert_allclose(points.densities[4], state[:, 1], 0.0, ROUNDING)
    assert np.all((crushing > 0.1) == (joint is CRUSHED))


def test_rejected_contact_of_abaqus(capfd: pytest.CaptureFixture[str]) -> None:
    """Water, whose field the routine does not get, and another number of components: NaN, state as it was."""
    zero, end = np.zeros((1, 3)), np.full((1, 3), 1e-3)
    for points in (abaqus.Points(SOLID.props(water=1), 1), abaqus.Points(SOLID.props(), 1, 1)):
        assert np.isnan(points.step(zero, end)[0, : points.ndir]).all() and not points.state.any()
        assert points.cut < 1.0 and points.closed == [-1] and np.isnan(points.energies[0, 0])
    said = capfd.readouterr().err
    assert "PROPS(23) = 1" in said and "NTENS = 1" in said


def test_initial_traction_of_diana() -> None:
    """TRA of the first call of a point is its traction at the separation that it begins with."""
    points, begin = diana.Points(SOLID.props(), 1), np.array([[0.3, 0.1, -0.2]])
    points.tra[0] = (-1.0, 0.3, 0.1)
    np.testing.assert_allclose(points.step(begin, begin), [(-1.0, 0.3, 0.1)], 0.0, 1e-10)


def test_rejections(capfd: pytest.CaptureFixture[str]) -> None:
    """Constants that are not admissible are named, and the traction is NaN or the model raises them."""
    props = SOLID.props().copy()
    props[contract.index("mu")] = -0.5
    zero, end = np.zeros((1, 3)), np.full((1, 3), 1e-3)
    state = diana.Points(SOLID.props(), 1)
    state.props[:] = props
    assert np.isnan(state.step(zero, end)).all() and not state.state.any()
    assert "mu = -0.5" in capfd.readouterr().err
    if lsdyna.available():
        points = lsdyna.Points(SOLID.props(), 2)
        points.cm[2 : 2 + len(props)] = props
        assert np.isnan(points.step(np.zeros((2, 3)), np.full((2, 3), 1e-3))).all()
        assert "mu = -0.5" in capfd.readouterr().err and np.isnan(points.ek[points.here]).all()


@pytest.mark.skipif(not lsdyna.available(), reason="no gfortran")
def test_stiffness_of_lsdyna() -> None:
    """The stiffness for the time step is that of the closed contact, for the points of the call alone."""
    points = lsdyna.Points(SOLID.props(), 3)
    points.step(np.zeros((3, 3)), np.zeros((3, 3)))
    closed = SOLID.update([(-1e-4, 0.0, 0.0)]).traction[0, 0] / -1e-4
    np.testing.assert_allclose(points.ek[points.here], closed, rtol=1e-12)
    assert not np.delete(points.ek, np.arange(lsdyna.FIRST, lsdyna.FIRST + 3)).any()


@pytest.mark.skipif(not itasca.available(), reason="no g++")
@pytest.mark.parametrize("old", [False, True])
def test_contact_of_itasca(old: bool) -> None:
    """A contact goes on from a file of the program, gives energies and stiffnesses, and needs its axes."""
    rows = np.diff(path(), axis=0, prepend=0.0)
    contact, other = (itasca.Contact(SOLID.props(), itasca.TURNED, old) for _ in range(2))
    for k, increment in enumerate(rows):
        if k == 60:
            other.library.contact_restore(other.at)
        np.testing.assert_array_equal(contact.run(increment), other.run(increment))
    energies = [contact.library.contact_energy(contact.at, k) for k in (1, 2, 3)]
    expected = itasca.AREA * SOLID.replay(path()).state[-1, 1:4]
    np.testing.assert_allclose(energies, expected, 0.0, 1e-10)
    k = np.zeros(2)
    contact.library.contact_stiffness(contact.at, k.ctypes.data_as(ctypes.c_void_p))
    closed = SOLID.update([(-1e-4, 0.0, 0.0)]).traction[0, 0] / -1e-4
    tangent = SOLID.update([(-1e-4, 0.0, 0.0)]).tangent[0, 1:]
    np.testing.assert_allclose(k, [closed, np.abs(tangent).sum(axis=1).max()], rtol=1e-12)
    local = itasca.Contact(SOLID.props(), np.eye(3)[[2, 0, 1]], old)
    local.axes = itasca.TURNED
    with pytest.raises(RuntimeError, match="a shear displacement along N: expected n-x to t-z"):
        local.run(np.array([0.0, 0.0, 0.01]))
    begun = itasca.Contact(SOLID.props(), itasca.TURNED, old)
    shear = -itasca.AREA * np.array([0.3, 0.1]) @ itasca.TURNED[1:]
    begun.library.contact_force(begun.at, ctypes.c_double(itasca.AREA), shear.ctypes.data_as(ctypes.c_void_p))
    np.testing.assert_allclose(begun.run(np.zeros(3)), [-1.0, 0.3, 0.1], 0.0, 1e-10)
    begun.set(contract.index("mu") + 1, -0.5)
    with pytest.raises(RuntimeError, match=r"asperity: .*mu = -0\.5"):
        begun.run(np.zeros(3))
