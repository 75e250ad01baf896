"""Types of the elements of an Abaqus deck: those that are read, that are left out, and that are refused."""

from __future__ import annotations

import re
from dataclasses import dataclass

READ = (
    (r"(?:CPE|CPS|CPEG|CAX|S|SFM3D|M3D|R3D|STRI|DS)(3|4|6|8|9)", 2),
    (r"C3D(4|6|8|10|20)", 3),
    (r"(?:T2D|T3D|B2|B3|R2D)([123])", 1),
)
"""Types of elements, whose first group is their number of nodes, and their dimension."""

KINDS = {
    (2, 3): "triangle", (2, 4): "quad", (2, 6): "triangle6", (2, 8): "quad8", (2, 9): "quad9",
    (3, 4): "tetra", (3, 6): "wedge", (3, 8): "hexahedron", (3, 10): "tetra10", (3, 20): "hexahedron20",
    (1, 2): "line", (1, 3): "line3",
}  # fmt: skip

LEFT_OUT = (
    (r"MASS|ROTARYI|HEATCAP", "masses", 1),
    (r"SPRING1|DASHPOT1", "springs or dashpots", 1),
    (r"SPRING[2A]|DASHPOT[2A]", "springs or dashpots", 2),
    (r"CONN[23]D2|JOINTC|JOINT[23]D", "connectors", 2),
    (r"GAP(?:UNI|CYL|SPHER)T?", "gaps", 2),
    (r"DCOUP[23]D", "couplings", 1),
    (r"PIPE[23]1H?|ELBOW31[BC]?|FRAME[23]D", "pipes or frames", 2),
    (r"PIPE[23]2H?|ELBOW32", "pipes", 3),
    (r"RB[23]D2", "rigid links", 2),
    (r"CIN(?:PE|PS|3D)([0-9]+)R?", "infinite elements", 0),
    (r"AC(?:IN)?[23]D([0-9]+)R?", "acoustic elements", 0),
    (r"F[23]D([234])", "fluid elements", 0),
)
"""Types of elements that are no solids, what they are, and their number of nodes (0: the first group)."""

REFUSED = (
    (r".*AX.*", "axisymmetric: expected a plane mesh or one in space, or CAX4 without twist"),
    (r"C3D15.*|C3D18.*", "expected C3D6: convert them"),
    (r"C3D5.*|C3D13.*", "pyramids: expected tetrahedra, wedges or hexahedra: convert them"),
    (r"C3D27.*", "expected C3D20: convert them"),
    (r"(?:SC|CSS)[68].*", "solids with the behaviour of shells: expected C3D6 or C3D8: convert them"),
)
"""Types of elements that may be solids and are not read, and what to do."""

EXPECTED = (
    "expected CPE3 to CPE8, CPS3 to CPS8, CAX3 to CAX8, C3D4, C3D6, C3D8, C3D10, C3D20: convert them, or "
    "remove these lines"
)


COHESIVE = r"COH(?:2D|AX|3D)([468])P?T?"
"""Cohesive elements, whose group is the number of the nodes of their sides."""


@dataclass(frozen=True)
class Type:
    """Cells of meshio, or an empty text, and number of nodes; what is left out; why it is refused.

    sides: number of nodes of both sides of a cohesive element.
    """

    kind: str = ""
    nodes: int = 0
    left_out: str = ""
    refused: str = ""
    sides: int = 0


def type_of(name: str) -> Type:
    """What becomes of elements of a type, whose name is in upper case."""
    for pattern, d in READ:
        if match := re.fullmatch(pattern + "[A-Z]*[0-9]?[A-Z]*", name):
            count = int(match[1])
            if d == 1:
                count = {1: 2, 2: 3, 3: 2}[count] if name.startswith("B") else count
            if kind := KINDS.get((d, count), ""):
                return Type(kind, count)
    for pattern, what, count in LEFT_OUT:
        if match := re.fullmatch(pattern, name):
            return Type(nodes=count or int(match[1]), left_out=what)
    if match := re.fullmatch(COHESIVE, name):
        return Type(sides=int(match[1]))
    for pattern, text in REFUSED:
        if re.fullmatch(pattern, name):
            return Type(refused=text)
    return Type(refused=EXPECTED)


def is_shell(name: str) -> bool:
    """Whether a type is one of surfaces, whose edges have names of their own."""
    return not name.startswith(("CPE", "CPS", "CAX", "C3D"))
