"""What an Abaqus deck numbers together: parts, instances and the model, and where its nodes are."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, field

import numpy as np

from ..contract import Floats
from ..material import ModelWarning
from .deck import Block, is_comment
from .shapes import Integers


@dataclass
class Scope:
    """What is numbered together: a part, an instance, or the model.

    elements: blocks, cells, numbers and nodes.  others: those that are no cells of a mesh, with the words of
    their nodes.  Members of sets and of sections are blocks of the deck, whose numbers and names are looked
    up when all is read.  generated_numbers: of those that keywords have made, by the id of their block.
    """

    name: str
    nodes: list[tuple[Block, Integers, Floats]] = field(default_factory=list)
    elements: list[tuple[Block, str, Integers, Integers]] = field(default_factory=list)
    others: list[tuple[Block, Integers, list[list[str]]]] = field(default_factory=list)
    sections: list[Block] = field(default_factory=list)
    sets: dict[tuple[str, str], list[Block]] = field(default_factory=dict)
    titles: dict[tuple[str, str], str] = field(default_factory=dict)
    generated_numbers: dict[int, Integers] = field(default_factory=dict)
    move: Block | None = None

    def add(self, kind: str, name: str, block: Block) -> None:
        """Add members to a set; kind: NSET, ELSET or SURFACE."""
        key = kind, name.upper()
        self.titles.setdefault(key, name)
        self.sets.setdefault(key, []).append(block)


def entity_numbers(block: Block, rows: Floats) -> Integers:
    """Numbers of nodes or elements, which are whole."""
    bad = (rows != np.round(rows)) | (rows < 1.0) | (rows > 2.0**53)
    if bad.any():
        raise block.fail(f"{rows[bad][0]:g}: expected a number of a node or element, 1, 2, ...")
    return rows.astype(np.int64)


class Numbers:
    """Places of numbers: nodes or elements of a scope."""

    def __init__(
        self,
        scope: Scope,
        kind: str,
        numbered: list[tuple[Block, Integers]],
        places: Integers,
        quiet: bool = False,
    ) -> None:
        """Sort the numbers, which have these places; of a node that is given twice the last place counts.

        Unless `quiet`, ModelWarning has their number.

        Raises ValueError for an element that is there twice.
        """
        numbers = [np.zeros(0, np.int64), *(part for _, part in numbered)]
        flat = np.concatenate(numbers)
        order = np.argsort(flat, kind="stable")
        self.flat, self.places = flat, places
        self.sorted, self.place = flat[order], places[order]
        self.kind, self.scope = kind, f" of {scope.name}" if scope.name else ""
        again = np.flatnonzero(np.diff(self.sorted) == 0)
        if len(again) and kind == "node":
            self.sorted, self.place = (np.delete(rows, again) for rows in (self.sorted, self.place))
            text = f"{len(again)} nodes{self.scope} are given twice: the last place counts, as in Abaqus"
            if not quiet:
                warnings.warn(f"{numbered[-1][0].places[0][0]}: {text}", ModelWarning, stacklevel=6)
        elif len(again):
            number = int(self.sorted[again[0]])
            block = [block for block, part in numbered if (part == number).any()][-1]
            raise block.fail(f"{kind} {number}{self.scope} is there before: expected each number once")

    def generated(self, block: Block, numbers: range) -> Integers:
        """Places of those of a range that are there; ModelWarning for others, ValueError if there is none."""
        at = np.searchsorted(self.sorted, [numbers[0], numbers[-1] + 1])
        inside = np.flatnonzero((self.sorted[at[0] : at[1]] - numbers[0]) % numbers.step == 0) + at[0]
        if not len(inside):
            raise block.fail(f"{self.kind} {numbers[0]}{self.scope}: no such {self.kind}")
        if missing := len(numbers) - len(inside):
            text = f"{missing} of {len(numbers)} numbers are no {self.kind}s{self.scope}: they are left out"
            warnings.warn(f"{block.head()}: {text}", ModelWarning, stacklevel=6)
        places: Integers = self.place[inside]
        return places

    def __call__(self, block: Block, numbers: Integers) -> Integers:
        """Places of numbers; those that are not there raise ValueError."""
        if not len(self.sorted):
            at, bad = np.zeros(numbers.shape, np.int64), np.ones(numbers.shape, bool)
        else:
            at = np.minimum(np.searchsorted(self.sorted, numbers), len(self.sorted) - 1)
            bad = self.sorted[at] != numbers
        if bad.any():
            raise block.fail(f"{self.kind} {numbers[bad][0]}{self.scope}: no such {self.kind}")
        return self.place[at]


def moved(x: Floats, block: Block | None) -> Floats:
    """Nodes of an instance, moved and turned by its lines."""
    return x if block is None else shifted(x, block)


def shifted(x: Floats, block: Block) -> Floats:
    """Nodes that are moved first, then turned about an axis through two points."""
    lines = [(k, line.strip()) for k, line in enumerate(block.lines) if not is_comment(line)]
    while lines and not lines[-1][1].strip(", "):
        lines.pop()
    if len(lines) > 2:
        raise block.fail(f"{len(lines)} lines: expected one to move the part and one to turn it")
    motion = [block.numbers(text.removesuffix(",").split(","), k) if text else [] for k, text in lines]
    if (motion and len(motion[0]) > 3) or (len(motion) == 2 and len(motion[1]) != 7):
        raise block.fail(f"{motion[-1]}: expected three components to move it, then two points and an angle")
    if motion:
        x = x + np.pad(motion[0], (0, 3 - len(motion[0])))
    if len(motion) == 2:
        a, b, angle = np.array(motion[1][:3]), np.array(motion[1][3:6]), np.radians(motion[1][6])
        length = np.linalg.norm(b - a)
        if not length > 0.0:
            raise block.fail(f"{motion[1]}: expected two points of an axis")
        axis, p = (b - a) / length, x - a
        x = (
            a
            + p * np.cos(angle)
            + np.cross(axis, p) * np.sin(angle)
            + np.outer(p @ axis, axis) * (1.0 - np.cos(angle))
        )
    return x
