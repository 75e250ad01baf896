"""Keywords of an Abaqus deck that make nodes and elements of others: *Ngen, *Ncopy, *Elgen, *Elcopy."""

from __future__ import annotations

from collections.abc import Callable
from itertools import product

import numpy as np

from ..contract import Floats
from .deck import Block
from .deck_scopes import Numbers, Scope, entity_numbers, shifted
from .shapes import Integers

Members = Callable[[Scope, Block, str, str], Integers]
"""Numbers of the members of a set: scope, the keyword that names it, NSET or ELSET, and name."""


def placed(x: Floats, block: Block) -> Floats:
    """Nodes in x, y, z, of a *Node with a system: R, or C with r, degrees, z, or S with two angles."""
    system = (block.parameters.get("SYSTEM") or "R").upper()
    if system == "R":
        return x
    a, b = np.radians(x[:, 1]), np.radians(x[:, 2])
    if system == "C":
        return np.stack([x[:, 0] * np.cos(a), x[:, 0] * np.sin(a), x[:, 2]], 1)
    if system == "S":
        r = x[:, 0] * np.cos(b)
        return np.stack([r * np.cos(a), r * np.sin(a), x[:, 0] * np.sin(b)], 1)
    raise block.fail(f"system={system}: expected R, C or S")


def ngen(here: Scope, block: Block, members: Members) -> None:
    """Nodes on the line between two, equally apart."""
    block.allow("NSET")
    numbers_of_rows = [np.zeros(0, np.int64)]
    for k, words in block.rows():
        bounds = [int(number) for number in entity_numbers(block, np.array([block.numbers(words, k)]))[0]]
        if len(bounds) not in (2, 3):
            raise block.fail(f"{', '.join(words)}: expected first, last, step: a straight line", k)
        first, last, step = [*bounds, 1][:3]
        if last <= first or (last - first) % step:
            raise block.fail(f"{', '.join(words)}: expected a last number that the steps reach", k)
        numbers = np.arange(first, last + 1, step)
        ends = _points(here, block, np.array([first, last]))
        part = ((numbers - first) / (last - first))[1:-1, None]
        here.nodes.append((block, numbers[1:-1], ends[0] + part * (ends[1] - ends[0])))
        numbers_of_rows.append(numbers)
    _name(here, block, "NSET", "NSET", np.concatenate(numbers_of_rows))


def ncopy(here: Scope, block: Block, members: Members) -> None:
    """Nodes of a set moved and turned, once or several times."""
    block.allow("OLD SET", "CHANGE NUMBER", "NEW SET", "SHIFT", "MULTIPLE")
    if "SHIFT" not in block.parameters:
        raise block.fail("expected shift")
    numbers = members(here, block, "NSET", block.name("OLD SET"))
    change, numbers_of_rows = _integer(block, "CHANGE NUMBER"), [np.zeros(0, np.int64)]
    x = _points(here, block, numbers)
    for k in range(1, (_integer(block, "MULTIPLE") if "MULTIPLE" in block.parameters else 1) + 1):
        x = shifted(x, block)
        here.nodes.append((block, numbers + k * change, x))
        numbers_of_rows.append(numbers + k * change)
    _name(here, block, "NEW SET", "NSET", np.concatenate(numbers_of_rows))


def elgen(here: Scope, block: Block, members: Members) -> None:
    """Elements in rows, columns and layers like a master element."""
    block.allow("ELSET")
    numbers_of_rows = [np.zeros(0, np.int64)]
    for k, words in block.rows():
        values = [int(value) for value in block.numbers(words, k)]
        filled = [value or 1 for value in [*values, *([1] * 9)][:10]]
        counts, nodes, steps = filled[1::3], filled[2::3], filled[3::3]
        if min(counts) < 1:
            raise block.fail(f"{', '.join(words)}: expected numbers of elements, 1, 2, ...", k)
        at = [row for row in product(*(range(count) for count in counts)) if any(row)]
        shifts = np.array(at, np.int64).reshape(-1, 3)
        master = np.array([filled[0]])
        numbers = _copied(here, block, master, shifts @ np.array(steps), shifts @ np.array(nodes))
        numbers_of_rows += [master, numbers]
    _name(here, block, "ELSET", "ELSET", np.concatenate(numbers_of_rows))


def elcopy(here: Scope, block: Block, members: Members) -> None:
    """Elements of a set with other numbers and nodes."""
    block.allow("OLD SET", "ELEMENT SHIFT", "SHIFT NODES", "NEW SET")
    numbers = members(here, block, "ELSET", block.name("OLD SET"))
    by = np.array([_integer(block, "ELEMENT SHIFT")]), np.array([_integer(block, "SHIFT NODES")])
    _name(here, block, "NEW SET", "ELSET", _copied(here, block, numbers, *by))


GENERATORS: dict[str, Callable[[Scope, Block, Members], None]] = {
    "NGEN": ngen, "NCOPY": ncopy, "ELGEN": elgen, "ELCOPY": elcopy,
}  # fmt: skip
"""What makes nodes and elements, by keyword."""


def _copied(here: Scope, block: Block, numbers: Integers, steps: Integers, nodes: Integers) -> Integers:
    """Numbers of elements made of others, which are added; steps, nodes: what is added to their numbers."""
    numbers_of_rows, missing = [np.zeros(0, np.int64)], set(numbers.tolist())

    def like(source: Block) -> Block:
        return Block("ELEMENT", {"TYPE": source.name("TYPE")}, [], [0], block.places)

    for source, kind, known, rows in list(here.elements):
        if (at := np.isin(known, numbers)).any():
            new = (known[at][:, None] + steps).ravel()
            data = (rows[at][:, None] + nodes[:, None]).reshape(-1, rows.shape[1])
            here.elements.append((like(source), kind, new, data))
            numbers_of_rows.append(new)
            missing -= set(known[at].tolist())
    for source, known, words in list(here.others):
        if (at := np.isin(known, numbers)).any():
            new = (known[at][:, None] + steps).ravel()
            texts = [
                [str(int(word) + step) if word.isdigit() else word for word in words[row]]
                for row in np.flatnonzero(at).tolist()
                for step in nodes.tolist()
            ]
            here.others.append((like(source), new, texts))
            numbers_of_rows.append(new)
            missing -= set(known[at].tolist())
    if missing:
        raise block.fail(f"element {min(missing)}: no such element before")
    return np.concatenate(numbers_of_rows)


def _points(here: Scope, block: Block, numbers: Integers) -> Floats:
    """Places of nodes that are there before."""
    x = np.concatenate([np.zeros((0, 3)), *(rows[2] for rows in here.nodes)])
    known = Numbers(here, "node", [rows[:2] for rows in here.nodes], np.arange(len(x)), quiet=True)
    return np.asarray(x[known(block, numbers)])


def _name(here: Scope, block: Block, parameter: str, kind: str, numbers: Integers) -> None:
    """Add what a keyword has made to the set that it names."""
    if name := block.parameters.get(parameter):
        here.generated_numbers[id(block)] = numbers
        here.add(kind, name, block)


def _integer(block: Block, parameter: str) -> int:
    text = block.name(parameter)
    if not text.lstrip("+-").isdigit():
        raise block.fail(f"{parameter.lower()}={text}: expected a whole number")
    return int(text)
