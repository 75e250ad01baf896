"""The user library of OpenRadioss by a program that makes the engine's calls.

tests/python/test_doors.py has the path decks by these calls, docs/how-to/radioss.md the runs in the engine.
"""

from __future__ import annotations

import itertools
import re
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import meshio
import numpy as np
import pytest
from asperity import Interface, Material, Pattern
from asperity.contract import Floats
from asperity.export.element import Element
from asperity.export.kits import files
from asperity.mesh.hosts import write
from asperity.mesh.split import split

from harness.hosts.exported import PLANE, SOLID, path
from harness.hosts.radioss.calls import DENSITY, Points, read_card
from harness.hosts.radioss.element import CORNERS, SHARES, Elements
from harness.hosts.structured import grid

ROUNDING = 1e-11  # of tractions over K times the largest separation so far


def card_lines(card: str) -> str:
    """Lines of a card behind that of the density, without comments, as the starter copies them."""
    lines = [line for line in card.splitlines() if not line.startswith("#")]
    begin = next(i for i, line in enumerate(lines) if line.startswith("/MAT/USER01/")) + 3
    end = next(i for i, line in enumerate(lines) if line.startswith("/PROP"))
    return "\n".join(lines[begin:end]) + "\n"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty current folder, as that of a run."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize(
    "joint", [SOLID, Interface(SOLID.material, Pattern.planes([(1.0, 0.0, 0.0)], [1.0]))]
)
def test_card_of_the_starter(folder: Path, joint: Interface) -> None:
    """The starter gets the constants to the bit and the state variables of the law; the lines are short."""
    card = joint.card("radioss", name="BED", density=2.0e-9)
    uparam, nuvar = read_card("wall", card_lines(card))
    np.testing.assert_array_equal(uparam, joint.props())
    assert nuvar == joint.nstatv
    assert max(map(len, card.splitlines())) <= 100
    assert "\n/MAT/USER01/1\nBED\n" in card and f"{2e-9!r:>20}\n" in card


REFUSED = {
    "1.0, 2.0": "expected blanks between numbers behind constant 1",
    "3.0 0.3 9D-1 0.5": "expected blanks between numbers behind constant 3",
    "3.0 0.3 0.9": "3",
    "3.0 0.3 0.9 -0.5": "mu = -0.5",
    "3.0 0.3 0.9 0.5 " + 16 * "0 " + "0.5": "closure (constant 21)",
    "3.0 0.3 0.9 0.5 " + 19 * "0 " + "0.5": "c (24)",
}
"""Cards that end the starter, and what its message names."""

CHILD = """
import sys
import numpy as np
from harness.hosts.radioss import calls
"""


def ended(text: str, folder: Path) -> str:
    """Message of a run that ends with code 2; text: lines of its program."""
    root = Path(__file__).parents[3]
    command = [sys.executable, "-c", f"import sys; sys.path.insert(0, {str(root)!r})\n{CHILD}{text}"]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=folder)
    assert done.returncode == 2, done.stdout + done.stderr
    return done.stderr


@pytest.mark.parametrize("line", REFUSED)
def test_cards_that_are_refused(folder: Path, line: str) -> None:
    """A card that is not read to its end, or is not admissible, ends the starter with a message."""
    message = ended(f"calls.read_card('wall', {line + chr(10)!r})", folder)
    assert message.startswith("asperity radioss: /MAT/USER01: ") and REFUSED[line] in message


PROPS = f"np.array({SOLID.props().tolist()})"


def test_runs_that_are_refused(folder: Path) -> None:
    """NaN as a separation, a density of zero and elements with stresses in their plane end the engine."""
    begin = f"p = calls.Points({PROPS}, 3)\nz = np.zeros((3, 3))\n"
    message = ended(begin + "p.step(z, np.full((3, 3), np.nan), 1e-6)", folder)
    assert "strainInc(1) = NaN" in message and "elements 1 to 3" in message
    message = ended(begin.replace(", 3)\n", ", 3, density=0.0)\n", 1) + "p.step(z, z, 0.0)", folder)
    assert "element 1: density 0: expected > 0" in message
    solids = "arrays = [calls._at(np.zeros(k)) for k in range(1, 47)]\n"
    message = ended(f"{solids}calls.LIBRARY.eng_get_law_user_var_(*arrays)", folder)
    assert "expected elements of /PROP/TYPE43" in message
    assert "one digit" in ended("calls.LIBRARY.eng_sigeps_()", folder)


def test_first_cycle_and_initial_stress() -> None:
    """The first cycle has no duration; an initial stress is the traction at separation zero."""
    viscous = Interface(Material(sigma0=3.0, Gc=0.3, eta=0.9, mu=0.5, tau_v=1e-3), SOLID.pattern)
    points, zero = Points(viscous.props(), 2), np.zeros((2, 3))
    np.testing.assert_array_equal(points.step(zero, zero, 0.0), zero)
    initial = np.array([(-1.0, 0.2, -0.1), (-0.5, 0.0, 0.3)])
    points = Points(SOLID.props(), 2)
    points.stress = initial[:, [0, 2, 1]].T.copy()
    traction = points.step(zero, zero, 0.0)
    np.testing.assert_allclose(traction, initial, rtol=0.0, atol=ROUNDING * 3.0)
    end = np.array([(-0.01, 0.08, 0.05)] * 2)
    begun = SOLID.initial(initial)
    expected = SOLID.update(end, begun, zero)
    np.testing.assert_allclose(
        points.step(zero, end, 1e-6), expected.traction, rtol=0.0, atol=ROUNDING * 10.0
    )


def elements(joint: Interface, count: int, seed: int) -> tuple[list[Points], Floats]:
    """The four points of a block of elements, and drawn paths of their corners, (T, count, 4, 3)."""
    rng = np.random.default_rng(seed)
    shares = 1.0 + 0.5 * rng.uniform(-1.0, 1.0, (count, 4, 1))
    corners = path()[:, None, None, :] * shares
    return [Points(joint.props(), count) for _ in range(4)], corners


def run(points: list[Points], corners: Floats) -> Floats:
    """Tractions (T, count, 4, 3) of the points of a block on the paths of its corners."""
    at = np.einsum("pc,tncd->tnpd", SHARES, corners)
    start, rows = np.zeros_like(at[0]), []
    for end in at:
        rows.append(np.stack([p.step(start[:, k], end[:, k], 1e-6) for k, p in enumerate(points)], 1))
        start = end
    return np.array(rows)


def test_threads() -> None:
    """Blocks of elements on one, two and four threads have the same bits, those of the material points."""
    blocks = [elements(joint, 5, seed) for seed, joint in enumerate((SOLID, PLANE) * 4)]
    known = [run(*elements(joint, 5, seed)) for seed, joint in enumerate((SOLID, PLANE) * 4)]
    expected = SOLID.replay(np.einsum("c,tcd->td", SHARES[1], blocks[0][1][:, 2])).traction
    size = 1e3 * ROUNDING * SOLID.material.K
    np.testing.assert_allclose(known[0][:, 2, 1], expected, rtol=0.0, atol=size)
    for threads in (1, 2, 4):
        again = [elements(joint, 5, seed) for seed, joint in enumerate((SOLID, PLANE) * 4)]
        with ThreadPoolExecutor(threads) as pool:
            found = list(pool.map(lambda block: run(*block), again))
        for ours, theirs in zip(found, known, strict=True):
            np.testing.assert_array_equal(ours, theirs)


def turned(degrees: float) -> Floats:
    """Matrix of a turn about an axis that is none of the element's."""
    x, y, z = np.array([1.0, 2.0, 3.0]) / np.sqrt(14.0)
    a = np.radians(degrees)
    cross = np.array([(0.0, -z, y), (z, 0.0, -x), (-y, x, 0.0)])
    return np.eye(3) + np.sin(a) * cross + (1.0 - np.cos(a)) * cross @ cross


def moved(cycles: int, begin: float, turn: float) -> float:
    """Largest error of the tractions of an element over the largest traction, whose sides go along a path.

    It begins turned by an angle and turns on while it moves; cycles: of each increment of the path.
    """
    rows = np.concatenate([np.zeros((1, 3)), path()])
    at = np.arange(cycles * (len(rows) - 1) + 1) / cycles
    s = np.stack([np.interp(at, np.arange(len(rows)), column) for column in rows.T], axis=1)
    corners = np.column_stack([CORNERS, np.zeros(4)])
    sides = 0.5 * s[:, None, [1, 2, 0]] * np.repeat([-1.0, 1.0], 4)[:, None] + np.tile(corners, (2, 1))
    x = np.array([side @ turned(begin + turn * k / len(at)).T for k, side in enumerate(sides)])
    element, dt, found = Elements(SOLID.props(), x[:1]), 1e-6, []
    for old, new in itertools.pairwise(x):
        element.step(new[None], (new - old)[None] / dt, dt)
        found.append(element.traction[0])
    expected = SOLID.replay(s[1:]).traction[:, None]
    return float(np.abs(np.array(found) - expected).max() / np.abs(expected).max())


def test_turned_element() -> None:
    """An element has the tractions of the material point in its axes, also of axes turned by 90 degrees."""
    assert max(moved(1, 0.0, 0.0), moved(1, 90.0, 0.0)) < ROUNDING


def test_turning_element() -> None:
    """The axes at the end of a cycle resolve its velocities: the error is of first order in the cycles."""
    errors = [moved(cycles, 0.0, 90.0) for cycles in (1, 3, 9)]
    # 130, 390 and 1170 cycles
    assert errors[1] == pytest.approx(errors[0] / 3.0, rel=0.1) and errors[1] < 0.03
    assert errors[2] == pytest.approx(errors[1] / 3.0, rel=0.1)


class Free:
    """An element between two sides of four free nodes of the same mass, by central differences."""

    AREA, MASS = 2.0, 1.0e-6

    def __init__(self, joint: Interface, share: float, pressure: float = 0.0) -> None:
        """Begin at rest under a dead pressure; share: of the step that the engine takes from the library."""
        self.points, self.dead = [Points(joint.props(), 1) for _ in range(4)], np.zeros((4, 3))
        self.dead[:, 0] = pressure * self.AREA / 4.0
        self.force, self.at, self.v = np.zeros((4, 3)), np.zeros((4, 3)), np.zeros((2, 4, 3))
        self.traction(self.at, 0.0)
        stiffness = float(self.points[3].soundsp[0] ** 2 * DENSITY * self.AREA / 4.0)
        self.dt = share * np.sqrt(2.0 * self.MASS / stiffness)
        closed = np.zeros((4, 3))
        closed[:, 0] = -pressure / (joint.material.kc * joint.material.K)
        self.force, self.at = self.traction(closed, self.dt), closed

    def traction(self, end: Floats, dt: float) -> Floats:
        """Forces on the corners below, less the dead load."""
        rows = [p.step(self.at[k : k + 1], end[k : k + 1], dt)[0] for k, p in enumerate(self.points)]
        return SHARES.T @ rows * self.AREA / 4.0 + self.dead

    def step(self) -> float:
        """Energy of a step, and the step: kinetic, that of the law and of the dead load."""
        change = self.dt * np.stack([self.force, -self.force]) / self.MASS
        # central differences keep the product of the velocities before and after
        kinetic = 0.5 * self.MASS * (self.v * (self.v + change)).sum()
        law = sum(float(p.state[0, 1:4].sum()) for p in self.points) * self.AREA / 4.0
        energy = kinetic + law + float((SHARES @ self.dead * self.at).sum())
        self.v += change
        end = self.at + self.dt * SHARES @ (self.v[1] - self.v[0])
        self.force, self.at = self.traction(end, self.dt), end
        return float(energy)


def drift(share: float, steps: int = 300) -> float:
    """Largest change of the energy of an element that vibrates closed and elastic, over its vibration."""
    joint, pressure = SOLID, 0.5 * SOLID.material.sigma0
    free = Free(joint, share, pressure)
    deep = pressure / (joint.material.kc * joint.material.K)
    free.v = np.random.default_rng(70).uniform(-1.0, 1.0, (2, 4, 3)) * 0.01 * deep / free.dt
    vibration = 0.5 * free.MASS * float((free.v**2).sum())
    energies = np.array([free.step() for _ in range(steps)])
    return float(np.abs(energies - energies[0]).max() / vibration)


def test_time_step_of_a_closed_element() -> None:
    """A closed element keeps its energy at 0.9 of the step; the limit is sqrt(4.8) times the step."""
    assert drift(0.9) < 1e-9 and drift(0.99 * np.sqrt(4.8)) < 1e-6 and drift(1.01 * np.sqrt(4.8)) > 10.0


@pytest.mark.parametrize("share", [0.9, 0.3, 0.09])
def test_impact(share: float) -> None:
    """An element that closes, slides and breaks in part keeps its energy as its steps get short.

    Central differences err where the stiffness of opening becomes that of closure within a step, by the
    square of the step; 30 % at 0.9 is a bound by experience, not by theory.
    """
    joint = SOLID
    free = Free(joint, share)
    speed = 0.02 * joint.material.s_f * np.sqrt(joint.material.kc * joint.material.K * free.AREA / free.MASS)
    free.v[1] = speed * np.array([-1.0, 1.5, 0.5]) * np.array([1.0, 0.9, 0.8, 1.1])[:, None]
    start = 0.5 * free.MASS * (free.v**2).sum()
    ratio = np.array([free.step() for _ in range(2000)]) / start
    assert sum(float(p.state[0, 2]) for p in free.points) > 0.0  # it broke in part
    assert np.abs(ratio - 1.0).max() <= 0.3 * (share / 0.9) ** 2


def test_exported_element(folder: Path) -> None:
    """The deck of the kit moves the upper nodes so that their forces are the rows of the README."""
    element = Element.of_case()
    kit = files("radioss", element)
    deck, engine = str(kit["single_0000.rad"]), str(kit["single_0001.rad"])
    assert "$" not in deck + engine + str(kit["README.md"])
    uparam, _ = read_card("single", card_lines(deck))
    tables = [
        np.array([line.split() for line in body.splitlines()], float)
        for body in re.findall(r"^/FUNCT/\d\n\w+\n((?:[ \d.e+-]+\n)+)", deck, re.MULTILINE)
    ]
    opening, sliding = tables
    np.testing.assert_array_equal(opening[:, 0], sliding[:, 0])
    separations = np.stack([opening[1:, 1], sliding[1:, 1], 0.0 * opening[1:, 1]], axis=1)
    point, start, rows = Points(uparam, 1), np.zeros((1, 3)), []
    for end in separations:
        traction = point.step(start, end[None], 1e-6)[0]
        rows.append([end[1], end[0], traction[1], point.pla[0]])
        start = end[None]
    shown = [rows[element.press + k * element.every - 1] for k in range(1, 6)]
    np.testing.assert_allclose(shown, element.rows, rtol=0.0, atol=1e-8)


def values(deck: str, keyword: str) -> np.ndarray:
    """Numbers of all data lines of a keyword with a number, in fields of ten characters."""
    bodies = re.findall(rf"^/{keyword}/\d+\n((?:[ \d]+\n)+)", deck, re.MULTILINE)
    return np.array([line.split() for body in bodies for line in body.splitlines()], int)


def test_mesh(folder: Path) -> None:
    """A deck has a part for each block and joint, node on node, opening and Tx as the joint has them."""
    mesh = grid([0.0, 2.0, 3.0], [0.0, 1.0], [0.0, 1.0, 1.5], block=np.array([[[0, 1]], [[0, 2]]]) + 1,
                names={"base": 1, "left": 2, "right": 3}, sides=())  # fmt: skip
    jointed = split(mesh, {"bed": ("base", "*")})
    [deck_file] = write("wall_0000.rad", jointed, laws={"bed": SOLID})
    deck = deck_file.read_text(encoding="ascii")
    assert deck.splitlines()[1] == "#RADIOSS STARTER" and "/BEGIN\nwall\n" in deck and deck.endswith("/END\n")
    nodes = {
        int(line[:10]): [float(line[k : k + 20]) for k in (10, 30, 50)]
        for line in deck.split("/NODE\n")[1].split("/BRICK")[0].splitlines()
    }
    assert sorted(nodes) == list(range(1, len(jointed.points) + 1))
    bricks = values(deck, "BRICK")
    assert bricks[:, 0].tolist() == list(range(1, 7))
    x = np.array([[nodes[node] for node in row] for row in bricks[:, 1:].tolist()])
    volume = [abs(np.linalg.det(np.stack([e[1] - e[0], e[3] - e[0], e[4] - e[0]]))) for e in x]
    assert sorted(volume) == [0.0, 0.0, 0.5, 1.0, 1.0, 2.0]
    for e in x[-2:]:
        N = np.cross(e[1] - e[0], e[3] - e[0])
        assert N[2] > 0.0 and np.abs(N[:2]).max() == 0.0 and e[1, 0] > e[0, 0] and e[1, 1] == e[0, 1]
    assert {*bricks[-2:, 1:].ravel().tolist()} <= {*bricks[:-2, 1:].ravel().tolist()}
    assert re.findall(r"^/PART/(\d)\n(\w+)\n +(\d) +(\d) +0$", deck, re.MULTILINE) == [
        (str(k), name, str(k), str(k)) for k, name in enumerate(("base", "left", "right", "bed"), 1)
    ]
    assert "/MAT/USER01/4\nbed\n" in deck and "/PROP/TYPE43/4\nbed\n" in deck
    surfaces = re.findall(r"^/SURF/SEG/\d+\n(\w+)$", deck, re.MULTILINE)
    assert surfaces == ["bed_minus", "bed_plus"]


def test_meshes_that_are_refused(folder: Path) -> None:
    """Plane meshes, and joints between triangles, have no connection elements."""
    plane = split(grid([0.0, 1.0], [0.0, 1.0, 2.0], block=np.array([[0, 1]]) + 1, sides=()))
    with pytest.raises(ValueError, match="a plane mesh: expected solids for radioss"):
        write("wall_0000.rad", plane)
    tetra = np.array([[0, 1, 2, 3], [1, 2, 3, 4]])
    points = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 1)], float)
    solid = meshio.Mesh(points, {"tetra": tetra}, cell_data={"gmsh:physical": [np.array([1, 2])]})
    with pytest.raises(ValueError, match="joint joint: faces of 3 nodes: expected 4 for radioss"):
        write("wall_0000.rad", split(solid))
