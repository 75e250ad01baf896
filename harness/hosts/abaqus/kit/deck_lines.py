"""Parts of the decks that several of them have, as lines of an input file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from asperity import Interface, contract
from numpy.typing import NDArray

JOINT_DENSITY = 1.0e-8
"""Mass per area of a joint, t/mm^2, for Abaqus/Explicit."""


@dataclass
class Mesh:
    """Nodes (n, 2 or 3), cells by the name of their set with their type, and other sets; numbers from 1."""

    nodes: NDArray[np.float64]
    cells: dict[str, tuple[str, NDArray[np.int_]]]
    node_sets: dict[str, Sequence[int]]
    element_sets: dict[str, Sequence[int]] = field(default_factory=dict)

    def lines(self) -> list[str]:
        """Nodes, elements and sets as lines of an input file."""
        points = (self.nodes.round(9) + 0.0).tolist()
        text = ["*Node", *(", ".join(map(str, (i, *point))) for i, point in enumerate(points, 1))]
        first = 1
        for name, (kind, cells) in self.cells.items():
            if kind.startswith("COH"):
                text.append(
                    "** A joint: its lower face, then the upper face above it. N points from lower to upper."
                )
            text.append(f"*Element, type={kind}, elset={name}")
            text += [", ".join(map(str, (i, *cell))) for i, cell in enumerate(cells.tolist(), first)]
            first += len(cells)
        for keyword, sets in (("Nset, nset", self.node_sets), ("Elset, elset", self.element_sets)):
            for name, numbers in sets.items():
                text.append(f"*{keyword}={name}")
                text += [", ".join(map(str, numbers[i : i + 16])) for i in range(0, len(numbers), 16)]
        return text


def single() -> Mesh:
    """One element of 1 mm^2."""
    corners = np.array([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 1.0, 0.0), (0.0, 1.0, 0.0)] * 2)
    cells = {"JOINT": ("COH3D8", np.arange(1, 9)[None])}
    return Mesh(corners, cells, {"BOTTOM": [1, 2, 3, 4], "TOP": [5, 6, 7, 8]})


def wall(x: Sequence[float], courses: int, height: float, rows: int) -> Mesh:
    """Courses of plane elements with joints BED_i between them; x: of their nodes.

    Sets: JOINT and UNITS, all elements of each; nodes COURSE_i_BOTTOM, COURSE_i_TOP; elements COURSE_i_ROOF.
    """
    up = np.concatenate([np.linspace(k * height, (k + 1) * height, rows + 1) for k in range(courses)])
    nodes = np.stack(np.meshgrid(x, up), axis=-1).reshape(-1, 2)
    number = 1 + np.arange(len(nodes)).reshape(courses, rows + 1, len(x))

    def between(low: NDArray[np.int_], high: NDArray[np.int_]) -> NDArray[np.int_]:
        corners = low[..., :-1], low[..., 1:], high[..., 1:], high[..., :-1]
        return np.stack(corners, axis=-1).reshape(-1, 4)

    n, cells, sets, roofs = len(x) - 1, {}, {}, {}
    for k, one in enumerate(number):
        name = f"COURSE_{k + 1}"
        cells[name] = "CPS4", between(one[:-1], one[1:])
        sets |= {f"{name}_BOTTOM": one[0].tolist(), f"{name}_TOP": one[-1].tolist()}
        roofs[f"{name}_ROOF"] = [*range((rows * (k + 1) - 1) * n + 1, rows * (k + 1) * n + 1)]
    for k in range(1, courses):
        cells[f"BED_{k}"] = "COH2D4", between(number[k - 1, -1], number[k, 0])
    units = rows * n * courses
    roofs |= {"JOINT": [*range(units + 1, units + (courses - 1) * n + 1)], "UNITS": [*range(1, units + 1)]}
    return Mesh(nodes, cells, sets, roofs)


def deck(
    heading: str, comments: Sequence[str], name: str, mesh: Mesh, card: Sequence[str], *lines: str
) -> str:
    """Text of an input file."""
    explicit = any(line.startswith("*Dynamic, Explicit") for line in lines)
    run = f"abaqus job={name} user=asperity_abaqus.f90{' double=both' if explicit else ''}"
    head = ["*Heading", heading, f"** {run}"]
    if explicit:
        head.append(f"** in single precision: abaqus job={name} user=asperity_abaqus_single.f90")
    head.append("** Abaqus was not available when this deck was written.")
    return "\n".join([*head, *(f"** {line}" for line in comments), *mesh.lines(), *card, *lines]) + "\n"


def card(joint: Interface, explicit: bool = False, **options: Any) -> list[str]:
    """Material and section of a joint, with what the two constants of finite asperities would do.

    options: those of `Interface.card`.
    """
    density = JOINT_DENSITY if explicit else None
    text = joint.card("abaqus", name="JOINT", explicit=explicit, density=density, **options)
    height, wear = (contract.index(prop) + 1 for prop in ("height", "W0"))
    worn = contract.n_statev(joint.n_planes, True)
    return [
        f"** Finite asperities: PROPS {height} (height, mm) is the rise at which the dilation ends, and",
        f"** PROPS {wear} (W0, N/mm) the work of friction per area that wears 63 % of them off. Both are 0",
        "** here: no end and no wear. With W0 > 0",
        f"** *Depvar needs {worn} variables instead of {contract.n_statev(joint.n_planes)}.",
        *text.splitlines(),
    ]


def solution(name: str, values: Sequence[float]) -> list[str]:
    """Lines of initial state variables."""
    texts = [f"{value:g}." for value in values]
    return [
        f"{name}, {', '.join(texts[:7])}",
        *(", ".join(texts[i : i + 8]) for i in range(7, len(texts), 8)),
    ]


def static(name: str, increments: str, direct: bool = False) -> list[str]:
    """Start of a static step with the unsymmetric solver."""
    return [
        "** unsymm=YES, because the tangent of a sliding joint is unsymmetric.",
        f"*Step, name={name}, nlgeom=NO, unsymm=YES, inc=1000",
        f"*Static{', direct' if direct else ''}",
        increments,
    ]


def dynamic(name: str, duration: float) -> list[str]:
    """Start of an explicit step."""
    return [f"*Step, name={name}, nlgeom=NO", "*Dynamic, Explicit", f", {duration}"]


def smooth(name: str, duration: float) -> list[str]:
    """Amplitude that starts and ends without acceleration."""
    return [f"*Amplitude, name={name}, definition=SMOOTH STEP", f"0., 0., {duration}, 1."]


def output(nodes: str = "TOP") -> list[str]:
    """Output of a static step, and its end."""
    history = ["*Output, history", f"*Node Output, nset={nodes}", "U, RF", "*End Step"]
    return ["*Output, field", "*Node Output", "U, RF", "*Element Output, elset=JOINT", "S, E, SDV", *history]
