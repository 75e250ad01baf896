"""Check of a deck for Abaqus: `model(text)` raises DeckError for the first mistake, with its line.

It knows the keywords of the decks of `asperity export abaqus` only, and not their options. Constants and
state variables of a joint are compared with the contract of asperity. What Abaqus itself would say about a
deck is not known.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from asperity import contract

ELEMENTS = {
    "CPE3": (2, 3, 4),
    "CPS3": (2, 3, 3),
    "CPE4": (2, 4, 4),
    "CPE4I": (2, 4, 4),
    "CPS4": (2, 4, 3),
    "C3D4": (3, 4, 6),
    "C3D6": (3, 6, 6),
    "C3D8": (3, 8, 6),
    "COH2D4": (2, 4, 2),
    "COH3D6": (3, 6, 3),
    "COH3D8": (3, 8, 3),
}
"""Dimension, number of nodes and number of stress components of the element types."""

SIDES = {"CPE3": 3, "CPS3": 3, "CPE4": 4, "CPS4": 4, "C3D4": 4, "C3D6": 5, "C3D8": 6}
"""Number of faces of the solids."""

KEYWORDS = (
    "heading node nset elset surface element material elastic density user_material depvar cohesive_section "
    "solid_section initial_conditions equation amplitude boundary step static dynamic controls cload dload "
    "output node_output element_output node_print el_print end_step"
)
"""Their names, with _ for a blank."""


class DeckError(ValueError):
    """A mistake in a deck."""


@dataclass
class Keyword:
    """Keyword line with its data lines; names are in lower case, values as written."""

    name: str
    line: int
    options: dict[str, str]
    data: list[list[str]] = field(default_factory=list)

    def error(self, text: str) -> DeckError:
        """Error at this keyword."""
        return DeckError(f"line {self.line}: *{self.name}: {text}")

    def number(self, text: str) -> float:
        """A number of Abaqus, whose exponent may be D."""
        try:
            return float(text.lower().replace("d", "e"))
        except ValueError:
            raise self.error(f"{text!r}: expected a number") from None

    def integer(self, text: str) -> int:
        """A whole number."""
        self.check(text.isdigit(), f"{text!r}: expected a whole number")
        return int(text)

    def check(self, right: bool, text: str) -> None:
        """Raise DeckError if something is not right."""
        if not right:
            raise self.error(text)


class Model:
    """What a deck describes; elements and nodes by number, sets as lists of numbers."""

    def __init__(self, keywords: list[Keyword]) -> None:
        """Read the keywords in their order."""
        self.keywords = keywords
        self.explicit = any(keyword.name == "dynamic" for keyword in keywords)
        self.nodes: dict[int, list[float]] = {}
        self.elements: dict[int, tuple[str, list[int]]] = {}
        self.sets: dict[str, dict[str, list[int]]] = {"nset": {}, "elset": {}}
        self.materials: dict[str, dict[str, Keyword]] = {}
        self.sections: dict[int, dict[str, Keyword]] = {}
        self.amplitudes: set[str] = set()
        self.beside: dict[int, list[list[int]]] = {}
        for keyword in keywords:
            self._check_names(keyword)
            if keyword.name in ("elastic", "density", "user material", "amplitude"):
                props_of(keyword)
            reader = getattr(self, "_" + keyword.name.replace(" ", "_"), None)
            if reader is not None:
                reader(keyword)
        if not any(keyword.name == "step" for keyword in keywords):
            raise DeckError("no *Step")
        for number, (kind, _) in self.elements.items():
            if number not in self.sections:
                raise DeckError(f"element {number} of the type {kind} has no section")

    def of(self, keyword: Keyword, kind: str, name: str) -> list[int]:
        """Numbers of a set of nodes or elements (kind: nset or elset), or of one of them."""
        if name in self.sets[kind]:
            return self.sets[kind][name]
        known = self.nodes if kind == "nset" else self.elements
        keyword.check(name.isdigit() and int(name) in known, f"{kind} = {name}: does not exist")
        return [int(name)]

    def _check_names(self, keyword: Keyword) -> None:
        """Sets, materials and amplitudes that a keyword names exist, and degrees of freedom."""
        for option, value in keyword.options.items():
            if option in self.sets and keyword.name not in (option, "element"):
                self.of(keyword, option, value)
            known = {"material": self.materials, "amplitude": self.amplitudes}.get(option)
            keyword.check(known is None or value in known, f"{option} = {value}: does not exist")
        if keyword.name == "dload":
            for name, *_ in keyword.data:
                self.of(keyword, "elset", name)
        if keyword.name in ("boundary", "cload", "equation"):
            terms = keyword.data
            if keyword.name == "equation":
                terms = [terms[1][i : i + 2] for i in range(0, len(terms[1]), 3)]
            for name, *freedoms in terms:
                node = self.of(keyword, "nset", name)[0]
                for freedom in freedoms[: 2 if keyword.name == "boundary" else 1]:
                    most = len(self.nodes[node])
                    right = 1 <= keyword.integer(freedom) <= most
                    keyword.check(right, f"degree of freedom {freedom}: expected 1 to {most}")

    def _node(self, keyword: Keyword) -> None:
        for name, *point in keyword.data:
            number = keyword.integer(name)
            keyword.check(number not in self.nodes, f"node {number} is given twice")
            self.nodes[number] = [keyword.number(value) for value in point]
        sizes = {len(point) for point in self.nodes.values()}
        keyword.check(sizes in ({2}, {3}), f"{sizes} coordinates: expected 2 or 3 for all nodes")

    def _element(self, keyword: Keyword) -> None:
        kind = keyword.options["type"].upper()
        keyword.check(kind in ELEMENTS, f"type = {kind}: expected one of {', '.join(ELEMENTS)}")
        dimension, count, _ = ELEMENTS[kind]
        for row in keyword.data:
            number, *nodes = map(keyword.integer, row)
            at = f"element {number}"
            keyword.check(len(nodes) == count, f"{at} has {len(nodes)} nodes: expected {count}")
            for node in nodes:
                keyword.check(node in self.nodes, f"{at}: node {node} does not exist")
            points = np.array([self.nodes[node] for node in nodes])
            keyword.check(points.shape[1] == dimension, f"{at}: expected nodes with {dimension} coordinates")
            if kind.startswith("COH"):
                half = count // 2
                lower, upper = points[:half], points[half:] if dimension == 3 else points[:1:-1]
                keyword.check(np.abs(upper - lower).max() < 1.0e-9, f"{at}: its faces do not coincide")
                self._beside(keyword, f"{at}: its nodes are not in the order of {kind}", nodes[:half], lower)
            else:
                beside = [1, 2, 3] if kind in ("CPE3", "CPS3", "C3D4", "C3D6") else [1, 3, 4]  # node 0
                volume = np.linalg.det(points[beside[:dimension]] - points[0])
                keyword.check(volume > 0.0, f"{at}: its nodes are not in the order of {kind}")
            keyword.check(number not in self.elements, f"{at} is given twice")
            self.elements[number] = (kind, nodes)
            self.sets["elset"].setdefault(keyword.options["elset"], []).append(number)

    def _beside(self, keyword: Keyword, text: str, lower: list[int], x: np.ndarray) -> None:
        """The solid below a joint is behind its lower face, whose right-hand normal is N."""
        if x.shape[1] == 2:
            normal = np.array([x[0, 1] - x[1, 1], x[1, 0] - x[0, 0]])
        else:
            normal = np.cross(x[1] - x[0], x[2] - x[0])
        if not self.beside:
            for kind, nodes in self.elements.values():
                for node in nodes if not kind.startswith("COH") else ():
                    self.beside.setdefault(node, []).append(nodes)
        for nodes in self.beside.get(lower[0], []):
            if set(lower) <= set(nodes):
                middle = np.mean([self.nodes[node] for node in nodes], axis=0)
                keyword.check((middle - x[0]) @ normal < 0.0, text)

    def _nset(self, keyword: Keyword) -> None:
        numbers = [value for row in keyword.data for value in row]
        for number in numbers:
            self.of(keyword, keyword.name, number)
        self.sets[keyword.name][keyword.options[keyword.name]] = [int(number) for number in numbers]

    _elset = _nset

    def _surface(self, keyword: Keyword) -> None:
        for name, side in keyword.data:
            for number in self.of(keyword, "elset", name):
                kind = self.elements[number][0]
                most = SIDES[kind.removesuffix("I")]
                right = side in [f"S{k + 1}" for k in range(most)]
                keyword.check(right, f"{side}: expected S1 to S{most} of {kind}")

    def _material(self, keyword: Keyword) -> None:
        self.materials[keyword.options["name"]] = {}

    def _property(self, keyword: Keyword) -> dict[str, Keyword]:
        keyword.check(bool(self.materials), "expected after *Material")
        material = list(self.materials.values())[-1]
        material[keyword.name] = keyword
        return material

    _elastic = _density = _property

    def _user_material(self, keyword: Keyword) -> None:
        self._property(keyword)
        wanted, props = keyword.options["constants"], props_of(keyword)
        keyword.check(wanted == str(len(props)), f"{len(props)} values: expected constants = {wanted}")
        full = all(len(row) == 8 for row in keyword.data[:-1]) and len(keyword.data[-1]) <= 8
        keyword.check(full, "expected eight constants on a line")
        try:
            contract.check(props)
        except ValueError as error:
            raise keyword.error(str(error)) from None
        symmetric = self.explicit or props[contract.index("implex")] > 0.0
        keyword.check(symmetric or "unsymm" in keyword.options, "unsymm is missing, which friction needs")

    def _depvar(self, keyword: Keyword) -> None:
        material = self._property(keyword)
        keyword.check("user material" in material, "expected after *User Material")
        props = props_of(material["user material"])
        names = contract.umat_names(*contract.check(props), props[contract.index("implex")])
        names = [name.replace("offset", "separation") if self.explicit else name for name in names]
        rows = [[str(len(names))], *([str(i), name, name] for i, name in enumerate(names, 1))]
        keyword.check(keyword.data == rows, f"expected {len(names)}: {', '.join(names)}")

    def _solid_section(self, keyword: Keyword) -> None:
        material, cohesive = self.materials[keyword.options["material"]], keyword.name == "cohesive section"
        for name in ["depvar" if cohesive else "elastic", *(["density"] if self.explicit else [])]:
            keyword.check(name in material, f"{keyword.options['material']} has no *{name.title()}")
        for number in self.of(keyword, "elset", keyword.options["elset"]):
            kind = self.elements[number][0]
            keyword.check(kind.startswith("COH") == cohesive, f"element {number} is of the type {kind}")
            self.sections[number] = material

    def _cohesive_section(self, keyword: Keyword) -> None:
        self._solid_section(keyword)
        for option, wanted in (("response", "TRACTION SEPARATION"), ("thickness", "SPECIFIED")):
            keyword.check(keyword.options[option].upper() == wanted, f"{option}: expected {wanted}")
        material = self.materials[keyword.options["material"]]
        thickness = props_of(material["user material"])[contract.index("h")]
        keyword.check(keyword.number(keyword.data[0][0]) == thickness, f"expected PROPS 9, {thickness:g}")

    def _initial_conditions(self, keyword: Keyword) -> None:
        stress, rows = keyword.options["type"].upper() == "STRESS", []
        for row in keyword.data:
            keyword.check(len(row) <= 8, f"{len(row)} values: expected at most 8 on a line")
            if stress or not rows or row[0] in self.sets["elset"]:
                rows.append(list(row))
            else:
                rows[-1] += row
        for name, *values in rows:
            for number in self.of(keyword, "elset", name):
                keyword.check(number in self.sections, f"element {number}: expected its section before")
                depvar = self.sections[number].get("depvar", keyword)
                wanted = ELEMENTS[self.elements[number][0]][2] if stress else len(depvar.data) - 1
                keyword.check(len(values) == wanted, f"{name}: {len(values)} values: expected {wanted}")

    def _amplitude(self, keyword: Keyword) -> None:
        self.amplitudes.add(keyword.options["name"])

    def _step(self, keyword: Keyword) -> None:
        procedure = self.keywords[self.keywords.index(keyword) + 1].name
        wanted = "dynamic" if self.explicit else "static"
        keyword.check(procedure == wanted, f"expected *{wanted.title()} right after it")
        unsymmetric = self.explicit or keyword.options.get("unsymm", "").upper() == "YES"
        keyword.check(unsymmetric, "unsymm=YES is missing, which friction needs")


def model(text: str) -> Model:
    """Model of a deck; raises DeckError."""
    keywords: list[Keyword] = []
    for number, line in enumerate(text.splitlines(), 1):
        if not line.strip() or len(line) > 256:
            raise DeckError(f"line {number}: expected data or a keyword in at most 256 characters")
        if line.startswith("*") and not line.startswith("**"):
            keywords.append(_keyword(line, number))
        elif not line.startswith("*"):
            if not keywords:
                raise DeckError(f"line {number}: data before the first keyword")
            row = [part.strip() for part in line.split(",")]
            keywords[-1].data.append(row[:-1] if len(row) > 1 and row[-1] == "" else row)
    return Model(keywords)


def props_of(keyword: Keyword) -> np.ndarray:
    """All values of the data lines as numbers."""
    return np.array([keyword.number(value) for row in keyword.data for value in row])


def _keyword(line: str, number: int) -> Keyword:
    """Name and options of a keyword line."""
    name, *parts = [part.strip() for part in line[1:].split(",")]
    keyword = Keyword(name.lower(), number, {})
    keyword.check(keyword.name.replace(" ", "_") in KEYWORDS.split(), "unknown keyword")
    for part in parts:
        option, _, value = (text.strip() for text in part.partition("="))
        keyword.options[option.lower()] = value
    return keyword
