"""Hand-written decks: nodes and elements that keywords make, and those of one part."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from asperity import ModelWarning
from asperity.mesh import Jointed, split

from mesh.support_meshes import placed

N_DRAWN = 30
"""Drawn decks of each kind."""

DIGITS = 1.0e-8
"""Errors of places, whose numbers have nine digits and more."""


def same(mesh: Jointed, x: np.ndarray, y: np.ndarray) -> None:
    """The mesh is a grid of columns between x and two rows between y, joined along the middle."""
    where = {tuple(np.round(point, 6).tolist()) for point in mesh.points}
    assert where == {(round(float(a), 6) + 0.0, round(float(b), 6) + 0.0) for a in x for b in y}
    assert len(mesh.points) == 4 * len(x) and sum(map(len, mesh.cells.values())) == 2 * (len(x) - 1)
    (joint,) = mesh.joints["joint"]
    assert len(joint.area) == len(x) - 1 and joint.area.sum() == pytest.approx(x[-1] - x[0])
    assert joint.axes[:, 0] == pytest.approx(np.tile([0.0, 1.0], (len(joint.area), 1)), abs=DIGITS)


def draws() -> list[tuple[np.random.Generator, int, float, np.ndarray]]:
    """Draws, numbers of columns, their width and heights of the rows."""
    made = []
    for seed in range(N_DRAWN):
        draw = np.random.default_rng([seed, 11])
        y = np.cumsum([0.0, *draw.uniform(0.5, 2.0, 2)]).round(6)
        made.append((draw, int(draw.integers(2, 7)), round(float(draw.uniform(0.5, 2.0)), 6), y))
    return made


def test_rows_of_nodes_and_elements(tmp_path: Path) -> None:
    """*Ngen makes the nodes between two, *Elgen elements like a master."""
    for draw, n, width, y in draws():
        step = int(draw.integers(1, 4))
        up = step * n + int(draw.integers(1, 9))
        ends = [f"{1 + k * up + i * n * step}, {i * n * width}, {b}" for k, b in enumerate(y) for i in (0, 1)]
        text = ["*NODE", *ends, "*NGEN, NSET=ALL"]
        text += [f"{1 + k * up}, {1 + k * up + n * step}, {step}" for k in range(3)]
        for k, name in enumerate(("LOWER", "UPPER")):
            a = 1 + k * up
            text += [
                f"*ELEMENT, TYPE=CPE4, ELSET={name}",
                f"{1 + 100 * k}, {a}, {a + step}, {a + step + up}, {a + up}",
            ]
            text += [f"*ELGEN, ELSET={name}", f"{1 + 100 * k}, {n}, {step}, 1"]
        mesh = split(placed(tmp_path, "\n".join(text) + "\n"))
        same(mesh, width * np.arange(n + 1), y)
        assert len(np.unique(mesh.origin[mesh.nodes("ALL")])) == 3 * (n + 1)


def test_columns_of_elements(tmp_path: Path) -> None:
    """*Elgen makes rows of rows, and *Elcopy the second block of the first."""
    for _, n, width, y in draws():
        nodes = [f"{1 + 20 * k + i}, {i * width}, {b}" for k, b in enumerate(y) for i in range(n + 1)]
        text = [
            "*NODE",
            *nodes,
            "*ELEMENT, TYPE=CPE4, ELSET=MASTER",
            "1, 1, 2, 22, 21",
            "*ELGEN, ELSET=LOWER",
        ]
        copied = [*text, f"1, {n}", "*ELCOPY, OLD SET=LOWER, ELEMENT SHIFT=50, SHIFT NODES=20, NEW SET=UPPER"]
        rows = [*text, f"1, {n}, 1, 1, 2, 20, 50", "*ELSET, ELSET=UPPER, GENERATE", f"51, {50 + n}"]
        for lines, blocks in ((copied, "LOWER,UPPER"), (rows, "BELOW,UPPER")):
            below = ["*ELSET, ELSET=BELOW, GENERATE", f"1, {n}"]
            mesh = split(placed(tmp_path, "\n".join([*lines, *below]) + "\n"), blocks=blocks)
            same(mesh, width * np.arange(n + 1), y)


def test_copied_nodes(tmp_path: Path) -> None:
    """*Ncopy moves the nodes of a set, also several times, and turns them about an axis."""
    for draw, n, width, y in draws():
        size = float(y[1])
        y = np.array([0.0, size, 2.0 * size])
        nodes = [f"{1 + i}, {i * width}, 0." for i in range(n + 1)]
        text = ["*NODE, NSET=ROW", *nodes]
        head = "*NCOPY, OLD SET=ROW, CHANGE NUMBER=20, SHIFT, MULTIPLE=2, NEW SET=OTHERS"
        if draw.random() < 0.5:
            text += [head, f"0., {size}", ""]
        else:  # moved to the left, and turned by half a turn about the axis along y, which changes no place
            text += [head.replace(", MULTIPLE=2", ""), f"0., {size}", "0., 0., 0., 0., 1., 0., 0."]
            text += [head.replace(", MULTIPLE=2", "").replace("=20", "=40"), f"0., {2.0 * size}"]
        for k, name in enumerate(("LOWER", "UPPER")):
            text.append(f"*ELEMENT, TYPE=CPE4, ELSET={name}")
            cells = [[1 + i + 20 * k, 2 + i + 20 * k, 22 + i + 20 * k, 21 + i + 20 * k] for i in range(n)]
            text += [f"{50 * k + i + 1}, {', '.join(map(str, cell))}" for i, cell in enumerate(cells)]
        same(split(placed(tmp_path, "\n".join(text) + "\n")), width * np.arange(n + 1), y)


def explicit(n: int, width: float, y: np.ndarray, system: bool = False) -> list[str]:
    """Lines of a deck of nodes and elements; system: in polar coordinates."""
    nodes = [f"*NODE{', SYSTEM=C' if system else ''}"]
    for k, b in enumerate(y.tolist()):
        for i in range(n + 1):
            a = i * width
            place = (np.hypot(a, b), np.degrees(np.arctan2(b, a))) if system else (a, b)
            nodes.append(f"{1 + 20 * k + i}, {place[0]:.12g}, {place[1]:.12g}")
    for k, name in enumerate(("LOWER", "UPPER")):
        nodes.append(f"*ELEMENT, TYPE=CPE4, ELSET={name}")
        cells = [[1 + i + 20 * k, 2 + i + 20 * k, 22 + i + 20 * k, 21 + i + 20 * k] for i in range(n)]
        nodes += [f"{50 * k + i + 1}, {', '.join(map(str, cell))}" for i, cell in enumerate(cells)]
    return nodes


def test_places_of_nodes(tmp_path: Path) -> None:
    """Polar coordinates in degrees; of a node that is given twice the last place counts, with a warning."""
    for _, n, width, y in draws():
        x = width * np.arange(n + 1)
        same(split(placed(tmp_path, "\n".join(explicit(n, width, y, system=True)) + "\n")), x, y)
        wrong = ["*NODE", "1, 77., 77."]
        with pytest.warns(ModelWarning, match="1 nodes are given twice: the last place counts"):
            same(split(placed(tmp_path, "\n".join([*wrong, *explicit(n, width, y)]) + "\n")), x, y)


def test_parts_and_sets_of_instances(tmp_path: Path) -> None:
    """A deck without *Assembly is its only part, with what stands behind; instances may name sets."""
    for _, n, width, y in draws():
        x = width * np.arange(n + 1)
        part = ["*PART, NAME=P", *explicit(n, width, y), "*END PART"]
        behind = ["*NSET, NSET=FIRST", "1", "*MATERIAL, NAME=STONE", "*ELASTIC", "1., .2"]
        for alone, sets in ((part, 0), ([*part, *behind], 1)):
            with pytest.warns(ModelWarning, match="no .Assembly: part P is the model, where its nodes are"):
                mesh = split(placed(tmp_path, "\n".join(alone) + "\n"))
            same(mesh, x, y)
            assert sets == ("FIRST" in mesh.groups)
        none = [*part, "*ASSEMBLY, NAME=A", "*END ASSEMBLY"]
        with pytest.raises(ValueError, match="no elements: expected"), pytest.warns(ModelWarning):
            split(placed(tmp_path, "\n".join(none) + "\n"))
        assembly = ["*ASSEMBLY, NAME=A", "*INSTANCE, NAME=I, PART=P, NSET=WHOLE, ELSET=ALL", "*END INSTANCE"]
        mesh = split(placed(tmp_path, "\n".join([*part, *assembly, "*END ASSEMBLY"]) + "\n"))
        same(mesh, x, y)
        assert len(mesh.sets["ALL"]) == 2 * n
        assert len(np.unique(mesh.origin[mesh.nodes("WHOLE")])) == 3 * (n + 1)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("*NGEN\n1, 9, 3\n", r"line 15: 1, 9, 3: expected a last number that the steps reach"),
        ("*NGEN\n1, 99, 1\n", "node 99: no such node"),
        ("*NGEN, LINE=C\n1, 8, 1\n", "parameter line: expected nset"),
        ("*ELGEN\n77, 3\n", "element 77: no such element before"),
        ("*NCOPY, OLD SET=X, CHANGE NUMBER=5, SHIFT\n1.\n", "X: expected a number or a set that is there"),
        ("*NCOPY, OLD SET=X, CHANGE NUMBER=5, REFLECT=LINE\n1.\n", "parameter reflect: expected"),
        ("*NODE, SYSTEM=Q\n99, 1., 1.\n", "system=Q: expected R, C or S"),
        ("*ELEMENT, TYPE=CPE4, OFFSET=5\n9, 1, 2\n", "offset=5: expected a number, of cohesive elements"),
    ],
)
def test_generators_that_are_refused(tmp_path: Path, text: str, words: str) -> None:
    """They name the line, the value and what was expected."""
    from mesh.support_meshes import STRIP

    with pytest.raises(ValueError, match=words):
        split(placed(tmp_path, STRIP.split("*Elset")[0] + text))
