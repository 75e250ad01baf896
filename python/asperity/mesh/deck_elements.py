"""Cohesive elements of an Abaqus deck: sections, places of nodes, solids beside them, widths and ties."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cached_property

import numpy as np

from ..contract import Floats
from .deck import Block
from .deck_connections import Link, links_of, nodes_named, nodes_unread, ties_of
from .deck_layers import layers_of
from .deck_model import Model, Section, sides_of
from .shapes import (
    FACES,
    STITCHED,
    Integers,
    area,
    corner_sizes,
    corners,
    dimension,
    place,
    stitches,
)

ROUNDING = 1.0e-6
"""Relative difference of two lengths of nodes and sections that are the same but for their digits."""

SHIFT = 0.5
"""Largest distance along the joint between nodes above each other, over the shortest edge."""

REACH = 0.1
"""Distance that a tie without a position tolerance reaches at most, over the size of a face."""

SOLIDS = "CPE", "CPS", "CAX", "C3D"
"""Beginnings of the types of solids."""

HOLD = (
    "EQUATION", "MPC", "COUPLING", "KINEMATIC COUPLING", "DISTRIBUTING COUPLING", "RIGID BODY", "BOUNDARY",
    "EMBEDDED ELEMENT", "CONTACT PAIR",
)  # fmt: skip
"""Keywords, beside *Tie, that may connect nodes of a joint which no solid has."""


def element_problems(model: Model, thickness: Mapping[int, float]) -> list[str]:
    """What is wrong with the cohesive elements of a deck, with file and line and what was expected.

    thickness: of the constants of joints (PROPS 9), by the id of their section.
    """
    checks = Checks(model, thickness)
    texts = [*checks.sections(), *checks.elements(), *checks.stitches(), *checks.ties(), *checks.links()]
    return list(dict.fromkeys(texts))


class Checks:
    """Checks of the cohesive elements of a deck."""

    def __init__(self, model: Model, thickness: Mapping[int, float]) -> None:
        """Find the section of each element."""
        self.model, self.thickness, self.all_ties = model, thickness, ties_of(model)
        layers = {id(s.block) for s in model.sections if s.block.keyword == "SOLID SECTION"} & {*thickness}
        self.layers = list(layers_of(model, layers))
        self.entries = [*model.cohesive, *self.layers]
        self.is_layer = np.zeros(int(model.first[-1]), bool)
        self.is_layer[np.concatenate([np.zeros(0, np.int64), *(at.places for at in self.layers)])] = True
        count = max((int(entry.places.max()) for entry in self.entries), default=-1) + 1
        self.section = np.full(count, -1)
        self.times = np.zeros(count, np.int64)
        for k, section in enumerate(model.sections):
            at = section.elements[section.elements < count]
            self.section[at] = k
            self.times[at] += 1

    def sections(self) -> Iterator[str]:
        """Elements in no section or in two, twice there, and sections without elements."""
        yield from self._solids_of_the_deck()
        seen: set[tuple[int, ...]] = set()
        for entry in self.entries:
            kind = entry.block.name("TYPE").upper()
            if lost := int((self.times[entry.places] == 0).sum()):
                text = f"{lost} elements of type {kind} are in no section: expected a *Cohesive Section"
                yield f"{entry.block.head()}: {text}"
            if lost := int((self.times[entry.places] > 1).sum()):
                text = f"{lost} elements of type {kind} are in two sections: expected one"
                yield f"{entry.block.head()}: {text}"
            alike = [tuple(row) for row in np.sort(entry.nodes, axis=1).tolist()]
            if again := len(alike) - len(set(alike) - seen):
                text = f"{again} elements have the nodes of others, so that the joint counts twice"
                yield f"{entry.block.head()}: {text}: expected each element once"
            seen |= set(alike)
        for section in self.model.sections:
            block = section.block
            if block.keyword in ("SOLID SECTION", "COHESIVE SECTION") and not len(section.elements):
                if id(block) not in self.thickness:
                    yield f"{block.head()}: elset={block.name('ELSET')}: no element is in it: expected some"

    def _solids_of_the_deck(self) -> Iterator[str]:
        """Solids inside out, and those in no section where others are in one."""
        model = self.model
        covered = np.zeros(int(model.first[-1]), bool)
        for section in model.sections:
            covered[section.elements[section.elements < len(covered)]] = True
        for scope in model.scopes:
            for block, kind, numbers, rows in scope.elements:
                name, d = block.name("TYPE").upper(), dimension(kind)
                if not len(numbers) or not name.startswith(SOLIDS):
                    continue
                x = model.points[model.nodes[id(scope)](block, rows)][:, :, :d]
                back = np.flatnonzero(corner_sizes(kind, x).mean(1) < 0.0)
                bare = np.flatnonzero(~covered[model.elements[id(scope)](block, numbers)])
                for found, text in (
                    (back, "are inside out: expected an area or volume above 0"),
                    (bare[: len(bare) * covered.any()], "are in no section: expected a *Solid Section"),
                ):
                    if len(found):
                        where = f"as at {place(x[found[0]].mean(0))}"
                        yield f"{block.head()}: {len(found)} elements of type {name} {text}, {where}"

    def elements(self) -> Iterator[str]:
        """Order of the nodes, thickness, solids on both sides, and width."""
        for entry in self.entries:
            sections = self.section[entry.places]
            for k in np.unique(sections[sections >= 0]).tolist():
                section = self.model.sections[k]
                is_layer = any(entry is layer for layer in self.layers)
                if section.block.keyword != "COHESIVE SECTION" and not is_layer:
                    continue
                rows = np.flatnonzero(sections == k)
                way = section.block.parameters.get("STACK DIRECTION")
                nodes = entry.nodes[rows]
                head, d = entry.block.head(), 2 if nodes.shape[1] == 4 else 3
                wrong = [] if is_layer else list(self._shapes(nodes, way, entry.block, d))
                yield from (f"{head}: {text}" for text in wrong)
                if wrong:
                    continue
                lower, upper = sides_of(nodes, way, entry.block)
                yield from self._thickness(section, lower, upper)
                solids, texts = self._beside(lower, upper, d)
                yield from (f"{head}: {text}" for text in texts)
                turned = "AX" in entry.block.name("TYPE").upper()
                yield from (f"{head}: {text}" for text in self._revolution(solids, turned, d))
                if d == 2 and not turned:
                    yield from self._width(section, solids)

    def _shapes(self, nodes: Integers, way: str | None, block: Block, d: int) -> Iterator[str]:
        """Stack direction and order of the nodes."""
        points = self.model.points
        lower, upper = sides_of(nodes, way, block)
        x, y = points[lower][:, :, :d], points[upper][:, :, :d]
        stack = np.linalg.norm(y - x, axis=2).max(1)
        edges, above = np.roll(x, -1, axis=1) - x, np.roll(y, -1, axis=1) - y
        if d == 2:
            edges, above = edges[:, :1], above[:, :1]
        length = np.minimum(np.linalg.norm(edges, axis=2).min(1), np.linalg.norm(above, axis=2).min(1))
        crossed = (np.einsum("fkd,fkd->fk", edges, above) <= 0.0).any(1)
        if d == 3:
            turns = np.cross(edges, np.roll(edges, -1, axis=1))
            turned = np.einsum("fkd,fd->fk", turns, turns[:, 0])
            crossed |= (turned < -ROUNDING * turned[:, :1]).any(1)
        crossed &= length > 0.0
        normal, across = area(x)[0], y - x
        along = across - np.einsum("fkd,fd->fk", across, normal)[:, :, None] * normal[:, None]
        shifted = np.linalg.norm(along, axis=2).max(1) > SHIFT * length
        where = "their nodes" if way is None else f"their nodes, by stack direction={way},"
        if (bad := np.flatnonzero((stack > length * (1.0 + ROUNDING)) & ~crossed)).size:
            yield self._named(bad, x, f"{where} are farther apart across the joint than along it", len(x)) + (
                ": expected the nodes of the lower side first, then those above them"
            )
        if (bad := np.flatnonzero(shifted & (stack <= length * (1.0 + ROUNDING)) & ~crossed)).size:
            text = f"{where} are shifted along the joint"
            yield (self._named(bad, x, text, len(x)) + ": expected upper nodes above the lower ones")
        if (bad := np.flatnonzero(crossed)).size:
            around = "the nodes around each side, the upper side in the order of the lower one"
            order = "1, 2 below and 4, 3 above them" if d == 2 else around
            yield self._named(bad, x, f"{where} make edges that cross", len(x)) + f": expected {order}"
        same = (lower == upper).all(1)
        if same.any():
            text = "have the same nodes on both sides, and cannot open"
            yield self._named(np.flatnonzero(same), x, text, len(x)) + ": expected nodes for each side"

    def stitches(self) -> Iterator[str]:
        """Nodes within a joint that both sides have."""
        nodes = stitches(self._sides)
        for entry in self.entries:
            if len(here := np.intersect1d(nodes, entry.nodes)):
                where = f"as at {place(self.model.points[here[0]])}"
                yield f"{entry.block.head()}: {len(here)} nodes within the joint, {where}, {STITCHED}"

    def _named(self, rows: Integers, x: Floats, text: str, total: int) -> str:
        return f"{len(rows)} of {total} elements, as at {place(x[rows[0]].mean(0))}: {text}"

    def _thickness(self, section: Section, lower: Integers, upper: Integers) -> Iterator[str]:
        """Distance of the sides where the section takes its thickness from it."""
        block = section.block
        if (block.parameters.get("THICKNESS") or "").upper() != "GEOMETRY":
            return
        h = self.thickness.get(id(block))
        if h is None:
            return
        t = np.linalg.norm(self.model.points[upper] - self.model.points[lower], axis=2).mean(1)
        if (bad := np.abs(t - h) > ROUNDING * h).any():
            text = f"thickness=GEOMETRY: {bad.sum()} of {len(t)} elements are {t[bad][0]:g} thick"
            yield f"{block.head()}: {text}: expected {h:g} (PROPS 9), or thickness=SPECIFIED"

    def _beside(self, lower: Integers, upper: Integers, d: int) -> tuple[Integers, list[str]]:
        """Solids on both sides, and what is wrong with their nodes and places."""
        points, n, texts = self.model.points[:, :d], len(lower), list[str]()

        def wrong(rows: Integers, text: str, expected: str) -> None:
            if len(rows):
                texts.append(f"{self._named(rows, x, text, n)}: expected {expected}")

        x = points[lower]
        normal, _ = area(x)
        solids = []
        for side, name in ((lower, "lower"), (upper, "upper")):
            solid, quadratic, bypassed = self._solids(side, d)
            held, beyond, gap = self._held(side, d)
            text = f"two solids have the nodes of the {name} side, and bypass the joint"
            wrong(np.flatnonzero(bypassed), text, "nodes of its own for each side")
            far = np.flatnonzero(gap > 0.0)
            most = gap[far].max(initial=0.0)
            text = f"the {name} side is {most:.3g} from the surface to which *Tie connects it"
            wrong(far, text, "surfaces at one place, or a position tolerance")
            text = f"the nodes of the {name} side are those of no solid, and no *Tie has them all"
            wrong(np.flatnonzero((solid < 0) & ~held), text, "common nodes or a *Tie")
            text = f"the {name} side has common nodes with a solid, to which a *Tie connects it again"
            wrong(np.flatnonzero((solid >= 0) & self._tied_to(side, solid)), text, "one of both")
            text = f"solids with nodes in the middle of their edges are at the {name} side, which has none"
            wrong(np.flatnonzero(quadratic), text, "linear solids")
            solids.append(np.where(bypassed, -1, np.where(solid >= 0, solid, beyond)))
        behind = np.zeros(n, bool)
        for solid, sign in zip(solids, (-1.0, 1.0), strict=True):
            at = np.flatnonzero(solid >= 0)
            away = np.einsum("fd,fd->f", self.centres[solid[at], :d] - x[at].mean(1), normal[at])
            behind[at[sign * away < 0.0]] = True
        text = "inside out: a solid lies on the other side of the element"
        wrong(np.flatnonzero(behind), text, "the nodes in the opposite sense")
        flat = np.einsum("fd,fd->f", points[upper].mean(1) - x.mean(1), normal)
        size = np.sqrt(((x - x.mean(1, keepdims=True)) ** 2).sum((1, 2)))
        text = "inside out: the upper side lies below the lower one"
        wrong(np.flatnonzero((flat < -ROUNDING * size) & ~behind), text, "an area or volume above 0")
        return np.concatenate(solids), texts

    def _revolution(self, solids: Integers, turned: bool, d: int) -> Iterator[str]:
        """Plane joints beside solids of revolution, and joints of revolution beside plane solids."""
        types = np.concatenate([np.zeros(0, "<U1"), *self.model.types])
        beside = types[solids[(solids >= 0) & (solids < len(types))]]
        other = np.unique(beside[np.char.startswith(beside, "CAX") != turned]).tolist()
        if d == 2 and other:
            wanted = "COH2D4" if turned else "COHAX4"
            yield f"beside solids of type {', '.join(other)}: expected {wanted}"

    def _width(self, section: Section, solids: Integers) -> Iterator[str]:
        """Out-of-plane width of the section, beside that of the solids."""
        rows = list(section.block.rows())
        words = rows[0][1] if rows else []
        values = section.block.numbers(words[:2], rows[0][0]) if rows else []
        width = values[1] if len(values) > 1 and values[1] else 1.0
        wide = {float(value) for value in np.unique(self.widths[solids[solids >= 0]]) if value > 0.0}
        for value in sorted(wide):
            if abs(value - width) > ROUNDING * value:
                text = f"out-of-plane width {width:g}, the second number, beside solids of {value:g}"
                yield f"{section.block.head()}: {text}: expected {value:g}"

    @cached_property
    def centres(self) -> Floats:
        """Centres of all cells of the deck, in the order of their places."""
        points = self.model.points
        return np.concatenate([np.zeros((0, 3)), *(points[rows].mean(1) for _, rows in self.model.cells)])

    @cached_property
    def widths(self) -> Floats:
        """Thickness of the sections of plane solids, by place; 1 without a number, 0 without a section."""
        width = np.zeros(int(self.model.first[-1]))
        for section in self.model.sections:
            if section.block.keyword == "SOLID SECTION":
                rows = list(section.block.rows())
                value = section.block.numbers(rows[0][1][:1], rows[0][0])[0] if rows else 0.0
                width[section.elements[section.elements < len(width)]] = value or 1.0
        return width

    @cached_property
    def _faces(self) -> dict[tuple[int, ...], list[tuple[int, bool]]]:
        """Cells, and whether they are quadratic, by the corners of faces that cohesive sides may have.

        Solids come before shells and beams, which are such faces themselves.
        """
        wanted = np.zeros(len(self.model.points), bool)
        for entry in self.entries:
            wanted[entry.nodes] = True
        faces: dict[tuple[int, ...], list[tuple[int, bool]]] = {}
        arrays = list(zip(self.model.first.tolist(), self.model.cells, strict=False))
        for first, (kind, cells) in sorted(arrays, key=lambda entry: -dimension(entry[1][0])):
            d = dimension(kind)
            sides = [(local, corners(d, len(local))) for local in FACES.get(kind, ())]
            if d < 3:
                count = cells.shape[1]
                sides.append((tuple(range(count)), 2 if d == 1 else 3 if kind.startswith("tri") else 4))
            for local, c in sides:
                nodes = cells[:, local[:c]]
                at = np.flatnonzero(wanted[nodes].all(1))
                at = at[~self.is_layer[first + at]]
                for row, key in zip(at.tolist(), np.sort(nodes[at], axis=1).tolist(), strict=True):
                    faces.setdefault(tuple(key), []).append((first + row, len(local) > c))
        return faces

    def _solids(self, side: Integers, d: int) -> tuple[Integers, np.ndarray, np.ndarray]:
        """Solid that has the nodes of a side as a face, or -1; whether it is quadratic, and one of two."""
        found = [self._faces.get(tuple(row), [(-1, False)]) for row in np.sort(side, axis=1).tolist()]
        solid, quadratic = map(np.array, zip(*(entries[0] for entries in found), strict=True))
        kinds = [dimension(kind) == d for kind, _ in self.model.cells]
        solid_cells = np.repeat(kinds, np.diff(self.model.first))
        return (
            solid,
            quadratic,
            np.array([sum(solid_cells[k] for k, _ in entries if k >= 0) > 1 for entries in found]),
        )

    @cached_property
    def nodes_held(self) -> Integers:
        """Nodes that keywords may hold, or that elements have which are not read."""
        return np.union1d(nodes_named(self.model, HOLD), nodes_unread(self.model))

    def _held(self, side: Integers, d: int) -> tuple[np.ndarray, Integers, Floats]:
        """Whether the nodes of a side are tied or held, the nearest solid to which it is tied, or -1, and the
        distance to the tied surface where that is beyond the tolerance of the tie, or 0.
        """
        from scipy.spatial import KDTree

        held = np.asarray(np.isin(side, self.nodes_held).all(1))
        beyond, gap = np.full(len(side), -1), np.zeros(len(side))
        points = self.model.points[:, :d]
        normal, size = area(points[side])
        for tie in self.all_ties:
            for mine, other in ((0, 1), (1, 0)):
                here = np.isin(side, tie.nodes[mine]).all(1)
                held |= here
                solids = tie.elements[other][tie.elements[other] < self.model.first[-1]]
                if not len(tie.elements[other]):
                    solids = self._solids_with(tie.nodes[other])
                if not here.any() or not len(tie.nodes[other]):
                    continue
                middle = points[side[here]].mean(1)
                if len(solids):
                    beyond[here] = solids[KDTree(self.centres[solids, :d]).query(middle)[1]]
                near = points[tie.nodes[other]][KDTree(points[tie.nodes[other]]).query(middle)[1]]
                distance = np.abs(np.einsum("fd,fd->f", near - middle, normal[here]))
                tolerance = tie.block.parameters.get("POSITION TOLERANCE")
                reach = REACH * size[here] ** (1.0 / (d - 1))
                if tolerance:
                    reach = np.full(len(reach), tie.block.numbers([tolerance], 0)[0])
                gap[here] = np.where(distance > reach, distance, 0.0)
        return held, beyond, gap

    def _solids_with(self, nodes: Integers) -> Integers:
        """Solids that have a face of these nodes."""
        found = [np.zeros(0, np.int64)]
        for first, (kind, cells) in zip(self.model.first, self.model.cells, strict=False):
            count = np.isin(cells, nodes).sum(1)
            found.append(first + np.flatnonzero(count >= max(dimension(kind), 2)))
        return np.concatenate(found)

    def _tied_to(self, side: Integers, solid: Integers) -> np.ndarray:
        """Whether a tie connects a side to the solid with which it shares its nodes."""
        twice = np.zeros(len(side), bool)
        for tie in self.all_ties:
            for mine, other in ((0, 1), (1, 0)):
                here = np.isin(side, tie.nodes[mine]).all(1)
                cells = tie.elements[mine][tie.elements[mine] < self.model.first[-1]]
                cohesive = len(cells) < len(tie.elements[mine]) or self.is_layer[cells].any()
                twice |= (
                    here
                    & np.isin(solid, tie.elements[other])
                    & (cohesive | ~np.isin(solid, tie.elements[mine]))
                )
        return twice

    def ties(self) -> Iterator[str]:
        """Ties and contact pairs past a joint, and nodes that two ties have."""
        pairs = [*self.all_ties, *ties_of(self.model, "CONTACT PAIR")]
        for lower, upper in self._sides:
            beside = [self._beside_ties(side) for side in (lower, upper)]
            for k, tie in enumerate(pairs):
                a, b = (
                    np.stack([side, *(nodes for other, nodes in at if other != k)])
                    for side, at in zip((lower, upper), beside, strict=True)
                )
                glued = np.zeros(len(lower), bool)
                for low, up in (tie.nodes, tie.nodes[::-1]):
                    on_low, on_up = np.any(np.isin(a, low), axis=0), np.any(np.isin(b, up), axis=0)
                    glued |= on_low.all(1) & on_up.all(1)
                if glued.any():
                    where = place(self.model.points[lower[glued][0]].mean(0))
                    text = f"it connects both sides of {glued.sum()} elements of a joint, as at {where}"
                    past = "past the joint" if k < len(self.all_ties) else "whose law has their contact"
                    name = tie.block.keyword.title()
                    yield f"{tie.block.head()}: {text}, {past}: expected no *{name} there"
        for k, tie in enumerate(self.all_ties):
            for other in self.all_ties[:k]:
                both = np.intersect1d(tie.nodes[0], other.nodes[0])
                again = np.array_equal(tie.nodes[0], other.nodes[1]) and np.array_equal(
                    tie.nodes[1], other.nodes[0]
                )
                both = tie.nodes[0] if again else both
                if len(both) == len(tie.nodes[0]) and len(both):
                    text = f"its {len(both)} nodes are tied before by {other.block.where()}"
                    yield f"{tie.block.head()}: {text}: expected one *Tie for each surface"

    def links(self) -> Iterator[str]:
        """Lines of *MPC and *Equation that hold both sides of a joint together, one for each keyword."""
        nodes = [np.zeros((2, 0), np.int64), *(np.stack([a.ravel(), b.ravel()]) for a, b in self._sides)]
        lower, upper = np.concatenate(nodes, axis=1)
        lower, upper = lower[lower != upper], upper[lower != upper]
        beside = [np.stack([side, *(at for _, at in self._beside_ties(side))]) for side in (lower, upper)]
        found: dict[int, tuple[Link, set[int]]] = {}
        at_joint = np.zeros(len(self.model.points) + 1, bool)  # the last one is no node
        at_joint[np.concatenate([side.ravel() for side in beside])] = True
        at_joint[-1] = False
        for link in links_of(self.model):
            if not (at_joint[link.first].any() and at_joint[link.second].any()):
                continue
            held = np.zeros(len(lower), bool)
            for a, b in (beside, beside[::-1]):
                on_a, on_b = np.isin(a, link.first), np.isin(b, link.second)
                if link.pairs:
                    held |= on_a.any(0) & on_b.any(0)
                elif np.isin(link.first, a).all() and np.isin(link.second, b).all():
                    held |= on_a.any(0)
            if held.any():
                found.setdefault(id(link.block), (link, set()))[1].update(lower[held].tolist())
        for link, at in found.values():
            where = place(self.model.points[min(at)])
            name = f"*{link.block.keyword.title()}" if link.block.keyword != "MPC" else "*MPC"
            text = f"it holds both sides of a joint together at {len(at)} nodes, as at {where}"
            yield f"{link.block.where(link.row)}: {name}: {text}, past the joint: expected no {name} there"

    def _beside_ties(self, side: Integers) -> list[tuple[int, Integers]]:
        """Ties of nodes of a side, by number, with the nearest nodes of the others; -1 for no tie."""
        from scipy.spatial import KDTree

        nearest = []
        points = self.model.points
        for k, tie in enumerate(self.all_ties):
            for mine, other in (tie.nodes, tie.nodes[::-1]):
                here = np.isin(side, mine)
                if here.any() and len(other):
                    at = other[KDTree(points[other]).query(points[side])[1]]
                    nearest.append((k, np.where(here, at, -1)))
        return nearest

    @cached_property
    def _sides(self) -> list[tuple[Integers, Integers]]:
        """Nodes of the lower and the upper side of the cohesive elements with a section."""
        pairs = []
        for entry in self.entries:
            sections = self.section[entry.places]
            for k in np.unique(sections[sections >= 0]).tolist():
                way = self.model.sections[k].block.parameters.get("STACK DIRECTION")
                pairs.append(sides_of(entry.nodes[sections == k], way, entry.block))
        return pairs
