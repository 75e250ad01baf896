"""Model of a deck: nodes, elements, sections, materials and steps by name, and the readers of its keywords.

A reader raises DeckError for the first mistake. The constants of the joint are compared with the contract.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from asperity import contract
from deck import Keyword

SOLIDS = {"CPE4": 2, "CPE4I": 2, "CPS4": 2, "C3D8": 3}
COHESIVE = {"COH2D4": 2, "COH3D8": 3}
"""Element types that the decks use, with their dimension."""

STRESSES = {"CPE4": 4, "CPE4I": 4, "CPS4": 3, "C3D8": 6, "COH2D4": 2, "COH3D8": 3}
"""Number of stress components, as *Initial Conditions, type=STRESS expects them."""

FACES = {"CPE4": 4, "CPE4I": 4, "CPS4": 4, "C3D8": 6}
"""Number of faces, P1 and so on, that a pressure may act on."""


@dataclass
class Material:
    """Elastic material (elastic: E, nu), or user material with constants and state variables."""

    name: str
    density: float | None = None
    elastic: tuple[float, float] | None = None
    props: list[float] | None = None
    unsymmetric: bool = False
    statev: list[str] = field(default_factory=list)


@dataclass
class Step:
    """One step with its keywords."""

    name: str
    explicit: bool
    keywords: list[Keyword]


@dataclass
class Model:
    """What a deck describes; elements by number, sets as lists of numbers."""

    nodes: dict[int, tuple[float, ...]] = field(default_factory=dict)
    elements: dict[int, tuple[str, tuple[int, ...]]] = field(default_factory=dict)
    nsets: dict[str, list[int]] = field(default_factory=dict)
    elsets: dict[str, list[int]] = field(default_factory=dict)
    materials: dict[str, Material] = field(default_factory=dict)
    sections: dict[int, tuple[str, float]] = field(default_factory=dict)
    amplitudes: dict[str, tuple[list[tuple[float, float]], bool]] = field(default_factory=dict)
    stress: dict[int, list[float]] = field(default_factory=dict)
    solution: dict[int, list[float]] = field(default_factory=dict)
    equations: list[list[tuple[str, int, float]]] = field(default_factory=list)
    boundary: list[Keyword] = field(default_factory=list)
    steps: list[Step] = field(default_factory=list)

    @property
    def dimension(self) -> int:
        """Two or three."""
        return len(next(iter(self.nodes.values())))

    def nodes_of(self, keyword: Keyword, text: str) -> list[int]:
        """Nodes of a set or of a number."""
        return _numbers(keyword, text, self.nsets, self.nodes, "node")

    def elements_of(self, keyword: Keyword, text: str) -> list[int]:
        """Elements of a set or of a number."""
        return _numbers(keyword, text, self.elsets, self.elements, "element")


def _numbers(keyword: Keyword, text: str, sets: dict[str, list[int]], known: dict, what: str) -> list[int]:
    if text in sets:
        return sets[text]
    if text.isdigit() and int(text) in known:
        return [int(text)]
    raise keyword.error(
        f"{text!r}: expected a {what} set, or the number of a{'n' if what == 'element' else ''} {what}"
    )


def _nodes(found: Model, keyword: Keyword) -> None:
    for row in keyword.data:
        number = keyword.integer(row[0])
        point = tuple(keyword.number(value) for value in row[1:])
        if number in found.nodes:
            raise keyword.error(f"node {number} is given twice")
        if len(point) not in (2, 3) or (found.nodes and len(point) != found.dimension):
            raise keyword.error(
                f"node {number} has {len(point)} coordinates: expected as many as the others, 2 or 3"
            )
        found.nodes[number] = point


def _elements(found: Model, keyword: Keyword) -> None:
    kind = keyword.options["type"].upper()
    known = SOLIDS | COHESIVE
    if kind not in known:
        raise keyword.error(f"type = {kind}: expected one of {', '.join(known)}")
    if known[kind] != found.dimension:
        raise keyword.error(
            f"type = {kind}: expected an element for nodes with {found.dimension} coordinates"
        )
    numbers = found.elsets.setdefault(keyword.options["elset"], [])
    for row in keyword.data:
        number, *nodes = (keyword.integer(value) for value in row)
        if len(nodes) != 4 * (known[kind] - 1):
            raise keyword.error(f"element {number} has {len(nodes)} nodes: expected {4 * (known[kind] - 1)}")
        unknown = [node for node in nodes if node not in found.nodes]
        if unknown:
            raise keyword.error(f"element {number}: node {unknown[0]} does not exist")
        if number in found.elements:
            raise keyword.error(f"element {number} is given twice")
        found.elements[number] = (kind, tuple(nodes))
        numbers.append(number)


def _sets(found: Model, keyword: Keyword) -> None:
    sets, known = (found.nsets, found.nodes) if keyword.name == "nset" else (found.elsets, found.elements)
    name = keyword.options[keyword.name]
    if name in sets:
        raise keyword.error(f"{name} is given twice")
    sets[name] = [keyword.integer(value) for row in keyword.data for value in row]
    for number in sets[name]:
        if number not in known:
            raise keyword.error(f"{name}: {number} does not exist")
    if any(len(row) > 16 for row in keyword.data):
        raise keyword.error(f"{name}: expected at most 16 numbers on a line")


def _material(found: Model, keyword: Keyword) -> None:
    name = keyword.options["name"]
    if name in found.materials:
        raise keyword.error(f"{name} is given twice")
    found.materials[name] = Material(name)


def _property(found: Model, keyword: Keyword) -> None:
    material = list(found.materials.values())[-1]
    if keyword.name == "density":
        material.density = keyword.numbers()[0]
        if material.density <= 0.0:
            raise keyword.error(f"{material.density:g}: expected > 0")
    elif keyword.name == "elastic":
        values = keyword.numbers()
        if len(values) != 2 or values[0] <= 0.0 or not -1.0 < values[1] < 0.5:
            raise keyword.error(f"{values}: expected E > 0 and -1 < nu < 0.5")
        material.elastic = (values[0], values[1])
    elif keyword.name == "user material":
        _user_material(material, keyword)
    else:
        _depvar(material, keyword)


def _user_material(material: Material, keyword: Keyword) -> None:
    """Constants, compared with the contract of asperity."""
    material.props = [keyword.number(value) for row in keyword.data for value in row]
    material.unsymmetric = "unsymm" in keyword.options
    wanted = keyword.integer(keyword.options["constants"])
    if len(material.props) != wanted:
        raise keyword.error(f"{len(material.props)} values: expected constants = {wanted}")
    if any(len(row) != 8 for row in keyword.data[:-1]) or len(keyword.data[-1]) > 8:
        raise keyword.error("expected eight constants on a line")
    sides = material.props[contract.index("m")] if wanted > contract.index("m") else 0.0
    expected = contract.N_FIXED_PROPS + contract.N_LISTED_VALUES * max(0, round(-sides))
    if wanted != expected:
        raise keyword.error(f"constants = {wanted}: expected {expected}, as the contract has them")
    try:
        contract.check(np.array(material.props))
    except ValueError as error:
        raise keyword.error(str(error)) from None


def _depvar(material: Material, keyword: Keyword) -> None:
    """State variables: their number, and a name for each of them."""
    count = keyword.integer(keyword.data[0][0])
    material.statev = [row[1] if len(row) == 3 else "" for row in keyword.data[1:]]
    if len(material.statev) != count:
        raise keyword.error(f"{len(material.statev)} names: expected {count}")
    for i, row in enumerate(keyword.data[1:], 1):
        if len(row) != 3 or row[0] != str(i):
            raise keyword.error(f"{', '.join(row)}: expected number {i}, name and text")


def _section(found: Model, keyword: Keyword) -> None:
    name = keyword.options["material"]
    if name not in found.materials:
        raise keyword.error(f"material = {name}: does not exist")
    cohesive = keyword.name == "cohesive section"
    if keyword.options["elset"] not in found.elsets:
        raise keyword.error(f"elset = {keyword.options['elset']}: does not exist")
    thickness = keyword.numbers()[0] if keyword.data else 1.0
    if cohesive:
        if keyword.options["response"].upper() != "TRACTION SEPARATION":
            raise keyword.error(f"response = {keyword.options['response']}: expected TRACTION SEPARATION")
        if keyword.options["thickness"].upper() != "SPECIFIED":
            raise keyword.error(f"thickness = {keyword.options['thickness']}: expected SPECIFIED")
    for number in found.elsets[keyword.options["elset"]]:
        kind = found.elements[number][0]
        if (kind in COHESIVE) != cohesive:
            raise keyword.error(f"element {number} is of the type {kind}")
        if number in found.sections:
            raise keyword.error(f"element {number} has two sections")
        found.sections[number] = (name, thickness)


def _initial(found: Model, keyword: Keyword) -> None:
    """Initial stress or state variables of sets; those of a set may go over several lines."""
    kind = keyword.options["type"].upper()
    if kind not in ("STRESS", "SOLUTION"):
        raise keyword.error(f"type = {kind}: expected STRESS or SOLUTION")
    rows: list[tuple[str, list[float]]] = []
    for row in keyword.data:
        if row[0] in found.elsets or row[0] in map(str, found.elements):
            rows.append((row[0], [keyword.number(value) for value in row[1:]]))
            most = 7
        elif not rows or kind == "STRESS":
            raise keyword.error(f"{row[0]!r}: expected an element set, or the number of an element")
        else:
            rows[-1][1].extend(keyword.number(value) for value in row)
            most = 8
        if kind == "SOLUTION" and len(row) > 8:
            raise keyword.error(f"{len(row)} values: expected at most {most} on this line")
    for name, values in rows:
        for number in found.elements_of(keyword, name):
            element = found.elements[number][0]
            if kind == "STRESS" and len(values) != STRESSES[element]:
                raise keyword.error(
                    f"{name}: {len(values)} stresses: expected {STRESSES[element]} for {element}"
                )
            (found.stress if kind == "STRESS" else found.solution)[number] = values


def _amplitude(found: Model, keyword: Keyword) -> None:
    values = keyword.numbers()
    smooth = keyword.options.get("definition", "TABULAR").upper()
    if smooth not in ("TABULAR", "SMOOTH STEP"):
        raise keyword.error(f"definition = {smooth}: expected SMOOTH STEP or none")
    pairs = list(zip(values[::2], values[1::2], strict=False))
    times = [time for time, _ in pairs]
    if len(values) % 2 or len(pairs) < 2 or times != sorted(set(times)):
        raise keyword.error("expected pairs of time and value, with growing times")
    found.amplitudes[keyword.options["name"]] = (pairs, smooth == "SMOOTH STEP")


def _equation(found: Model, keyword: Keyword) -> None:
    count, terms = keyword.integer(keyword.data[0][0]), keyword.data[1]
    if len(terms) != 3 * count:
        raise keyword.error(f"{len(terms)} values: expected three for each of {count} terms")
    equation = []
    for i in range(0, len(terms), 3):
        nodes = found.nodes_of(keyword, terms[i])
        if i > 0 and len(nodes) != 1:
            raise keyword.error(f"{terms[i]}: expected one node after the first term")
        equation.append((terms[i], _freedom(found, keyword, terms[i + 1]), keyword.number(terms[i + 2])))
    first = set(found.nodes_of(keyword, equation[0][0]))
    for name, freedom, _ in equation[1:]:
        if freedom == equation[0][1] and first & set(found.nodes_of(keyword, name)):
            raise keyword.error(f"{name}: expected a node that is not in the first term, which is eliminated")
    found.equations.append(equation)


def _freedom(found: Model, keyword: Keyword, text: str) -> int:
    freedom = keyword.integer(text)
    if not 1 <= freedom <= found.dimension:
        raise keyword.error(f"degree of freedom {freedom}: expected 1 to {found.dimension}")
    return freedom


def rows_of_boundary(found: Model, keyword: Keyword) -> Iterator[tuple[list[int], list[int], float]]:
    """Nodes, degrees of freedom and value of each line of *Boundary."""
    for row in keyword.data:
        if not 2 <= len(row) <= 4:
            raise keyword.error(
                f"{', '.join(row)}: expected node or set, first and last degree of freedom, value"
            )
        first = _freedom(found, keyword, row[1])
        last = _freedom(found, keyword, row[2]) if len(row) > 2 else first
        value = keyword.number(row[3]) if len(row) > 3 else 0.0
        yield found.nodes_of(keyword, row[0]), list(range(first, last + 1)), value


def rows_of_cload(found: Model, keyword: Keyword) -> Iterator[tuple[list[int], int, float]]:
    """Nodes, degree of freedom and force of each line of *Cload."""
    for row in keyword.data:
        if len(row) != 3:
            raise keyword.error(f"{', '.join(row)}: expected node or set, degree of freedom, force")
        yield found.nodes_of(keyword, row[0]), _freedom(found, keyword, row[1]), keyword.number(row[2])


def rows_of_dload(found: Model, keyword: Keyword) -> Iterator[tuple[list[int], int, float]]:
    """Elements, face and pressure of each line of *Dload."""
    for row in keyword.data:
        if len(row) != 3 or not row[1].startswith("P") or not row[1][1:].isdigit():
            raise keyword.error(f"{', '.join(row)}: expected element or set, face (as P3), pressure")
        elements, face = found.elements_of(keyword, row[0]), int(row[1][1:])
        for number in elements:
            kind = found.elements[number][0]
            if not 1 <= face <= FACES.get(kind, 0):
                raise keyword.error(f"{row[1]}: {kind} has no such face")
        yield elements, face, keyword.number(row[2])


READERS = {
    "node": _nodes,
    "element": _elements,
    "nset": _sets,
    "elset": _sets,
    "material": _material,
    "density": _property,
    "elastic": _property,
    "user material": _property,
    "depvar": _property,
    "cohesive section": _section,
    "solid section": _section,
    "initial conditions": _initial,
    "amplitude": _amplitude,
    "equation": _equation,
}
