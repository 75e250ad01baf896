"""Drawn decks of Abaqus with cohesive elements along a starter crack, right ones and ones with a mistake."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from asperity import Interface, Material, Pattern

FACES = {
    3: ((0, 1), (1, 2), (2, 0)), 4: ((0, 1), (1, 2), (2, 3), (3, 0)), 6: ((0, 1, 2), (3, 4, 5)),
    8: ((0, 1, 2, 3), (4, 5, 6, 7)),
}  # fmt: skip
"""Nodes of the faces S1, S2, ... of solids, as far as they lie at the joint."""

LAW = Interface(Material(3.0, 0.3, 0.9, 0.5), Pattern.regular(2, theta=30.0))


@dataclass
class Bonded:
    """A deck and what is in it: solids, elements of the joint, their area, nodes, and N of the joint."""

    text: str
    solids: int
    faces: int
    area: float
    nodes: int
    normal: np.ndarray


def _grid(lengths: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Nodes (n, d) of a grid, and their numbers by place."""
    points = np.stack(np.meshgrid(*lengths, indexing="ij"), -1)
    return points.reshape(-1, len(lengths)), np.arange(points[..., 0].size).reshape(points.shape[:-1])


def bonded(draw: np.random.Generator, tied: bool | None = None, ways: bool = True) -> Bonded:
    """Two blocks, one above the other, bonded beyond a crack; tied: by ties of the joint's own nodes.

    ways: whether the nodes may be in the order of another stack direction, which the section has.
    """
    d = int(draw.integers(2, 4))
    columns, deep = int(draw.integers(2, 6)), int(draw.integers(1, 3))
    start = int(draw.integers(0, columns))
    x = np.cumsum([0.0, *draw.uniform(0.5, 2.0, columns)])
    z = np.cumsum([0.0, *draw.uniform(0.5, 2.0, deep)])
    low, high = (np.cumsum([0.0, *draw.uniform(0.5, 2.0, int(draw.integers(1, 3)))]) for _ in range(2))
    corners = draw.random() < 0.4  # triangles or wedges
    tied = bool(draw.random() < 0.3) if tied is None else tied
    h = float(draw.choice([1.0, 0.01]))
    geometry = bool(draw.random() < 0.3) and h == 0.01
    gap = h if geometry else 0.0
    width = float(draw.choice([1.0, 25.0, 200.0])) if d == 2 else 1.0
    points: list[np.ndarray] = []
    cells: dict[str, list[list[int]]] = {"LOWER": [], "UPPER": []}
    tops: dict[str, np.ndarray] = {}
    first = 0
    for name, heights in (("LOWER", low - low[-1]), ("UPPER", high + gap)):
        own, number = _grid([x, heights] if d == 2 else [x, z, heights])
        points.append(own)
        number = number + first
        first += len(own)
        tops[name] = number[..., -1 if name == "LOWER" else 0]
        for i in range(columns):
            for j in range(len(heights) - 1):
                if d == 2:
                    a = [number[i, j], number[i + 1, j], number[i + 1, j + 1], number[i, j + 1]]
                    cells[name] += [a[:3], [a[0], a[2], a[3]]] if corners else [a]
                    continue
                for k in range(deep):
                    base = [
                        number[i, k, j],
                        number[i + 1, k, j],
                        number[i + 1, k + 1, j],
                        number[i, k + 1, j],
                    ]
                    roof = [node + 1 for node in base]
                    if corners:
                        cells[name] += [
                            [base[n] for n in at] + [roof[n] for n in at] for at in ((0, 1, 2), (0, 2, 3))
                        ]
                    else:
                        cells[name].append(base + roof)
    lower, upper = tops["LOWER"], tops["UPPER"]
    glue_low, glue_up = lower, upper
    if tied:
        n = lower.size
        points += [points[0][lower.ravel()], points[1][upper.ravel() - len(points[0])]]
        glue_low = first + np.arange(n).reshape(lower.shape)
        glue_up = glue_low + n
    joint: list[list[int]] = []
    area = 0.0
    for i in range(start, columns):
        if d == 2:
            joint.append([glue_low[i], glue_low[i + 1], glue_up[i + 1], glue_up[i]])
            area += x[i + 1] - x[i]
            continue
        for k in range(deep):
            around = [(i, k), (i + 1, k), (i + 1, k + 1), (i, k + 1)]
            for at in ((0, 1, 2), (0, 2, 3)) if corners else ((0, 1, 2, 3),):
                joint.append([int(side[around[n]]) for side in (glue_low, glue_up) for n in at])
            area += (x[i + 1] - x[i]) * (z[k + 1] - z[k])
    downward = bool(draw.random() < 0.3)
    if downward:
        joint = [_turned(row) for row in joint]
    sideways = ways and not tied and len(joint[0]) != 6 and bool(draw.random() < 0.3)
    if sideways:
        joint = [_sideways(row) for row in joint]
    places = np.concatenate(points)
    normal = np.eye(d)[-1] * (-1.0 if downward else 1.0)
    label = draw.permutation(len(places) + 20)[: len(places)] + 1
    text = _text(draw, places, label, cells, joint, d, width, h, geometry, tied, (lower, upper))
    if sideways:
        text = re.sub(r", stack direction=\d", "", text)
        text = text.replace("TRACTION SEPARATION,", "TRACTION SEPARATION, stack direction=1,")
    used = len({node for rows in cells.values() for row in rows for node in row})
    return Bonded(text, sum(map(len, cells.values())), len(joint), area, used, normal)


def _turned(row: list[int]) -> list[int]:
    """Nodes of a cohesive element whose upper side comes first."""
    if len(row) == 4:
        return [row[2], row[3], row[0], row[1]]
    half = len(row) // 2
    return [row[half], *row[half + 1 :][::-1], row[0], *row[1:half][::-1]]


def _sideways(row: list[int]) -> list[int]:
    """Nodes of a cohesive element in the order of stack direction 1."""
    if len(row) == 4:
        a, b, above_b, above_a = row
        return [b, above_b, above_a, a]
    low, high = row[:4], row[4:]
    return [low[0], high[0], high[1], low[1], low[3], high[3], high[2], low[2]]


def _text(
    draw: np.random.Generator,
    places: np.ndarray,
    label: np.ndarray,
    cells: dict[str, list[list[int]]],
    joint: list[list[int]],
    d: int,
    width: float,
    h: float,
    geometry: bool,
    tied: bool,
    sides: tuple[np.ndarray, np.ndarray],
) -> str:
    kinds = {3: "CPE3", 4: "CPS4", 6: "C3D6", 8: "C3D8R"}
    body = ["*Node"]
    rows = zip(label.tolist(), places.tolist(), strict=True)
    body += [f"{number}, {', '.join(f'{value:.9g}' for value in x)}" for number, x in rows]
    number = start = int(draw.integers(1, 50))
    for name, data in cells.items():
        body.append(f"*Element, type={kinds[len(data[0])]}, elset={name}")
        for row in data:
            body.append(", ".join(map(str, [number, *label[row].tolist()])))
            number += 1
    kind = {4: "COH2D4", 6: "COH3D6", 8: "COH3D8"}[len(joint[0])]
    first = number
    body.append(f"*Element, type={kind}, elset=GLUE")
    for row in joint:
        body.append(", ".join(map(str, [number, *label[row].tolist()])))
        number += 1
    style = int(draw.integers(3))
    body += {
        0: ["*Elset, elset=JOINT, generate", f"{first}, {number - 1}, 1"],
        1: ["*Elset, elset=JOINT", "GLUE"],
        2: ["*Elset, elset=JOINT", *(f"{k}" for k in range(first, number))],
    }[style]
    card = LAW.card("abaqus", name="JOINT", dimension=d, h=h)
    head, _, section = card.partition("*Cohesive Section")
    section = "*Cohesive Section" + section.rstrip()
    way = str(draw.choice(["", "", f", stack direction={d}"]))
    section = section.replace("thickness=SPECIFIED", f"thickness=SPECIFIED{way}")
    if d == 2:
        section = section.rstrip(",") + (f", {width:g}" if width != 1.0 or draw.random() < 0.5 else ",")
    if geometry:
        section = section.replace("thickness=SPECIFIED", "thickness=GEOMETRY")
    solid = [f"{width:g}," if width != 1.0 else ","]
    sections = [line for name in cells for line in (f"*Solid Section, elset={name}, material=STONE", *solid)]
    sections += [section]
    for k, (name, side) in enumerate(zip(("LOW", "UP"), sides, strict=True)):
        if draw.random() < 0.3 and tied:
            body += [f"*Nset, nset=ON_{name}", *(str(label[node]) for node in side.ravel())]
            body += [f"*Surface, type=NODE, name=S_{name}", f"ON_{name}"]
        else:
            rows = [
                f"{start + n}, S{face}"
                for n, row in enumerate(row for data in cells.values() for row in data)
                for face, local in enumerate(FACES[len(row)], 1)
                if {row[node] for node in local} <= set(side.ravel().tolist())
            ]
            body += [f"*Surface, name=S_{name}", *rows]
        body += [f"*Surface, name=G_{name}", f"GLUE, S{_face(joint, k)}"] if tied else []
    ties = [f"*Tie, name=T_{name}\nG_{name}, S_{name}" for name in ("LOW", "UP")] if tied else []
    lines = ["*Heading", " drawn"]
    tail = [head.rstrip(), "*Material, name=STONE", "*Elastic", "30000., 0.2"]
    tail += ["*Step, unsymm=YES", "*Static", "*End Step"]
    if draw.random() < 0.5:
        prefixed = [re.sub(r"\n(\w+), (\w+)$", r"\nI-1.\1, I-1.\2", tie) for tie in ties]
        move = [
            "*Instance, name=I-1, part=P",
            *([] if draw.random() < 0.5 else ["5., 0., 0."]),
            "*End Instance",
        ]
        lines += ["*Part, name=P", *body, *sections, "*End Part", "*Assembly, name=A", *move, *prefixed]
        return "\n".join([*lines, "*End Assembly", *tail]) + "\n"
    return "\n".join([*lines, *body, *sections, *ties, *tail]) + "\n"


def _face(joint: list[list[int]], k: int) -> int:
    """Face of a cohesive element that is tied below (0) or above (1); the lower nodes have lower numbers."""
    first, count = 1, len(joint[0])
    last = 3 if count == 4 else 2
    low_first = joint[0][0] < joint[0][-1]
    return first if (k == 0) == low_first else last


def _backward(match: re.Match[str]) -> str:
    """The nodes of a solid in the opposite sense."""
    nodes = match[2].split(", ")
    half = len(nodes) // 2
    return match[1] + ", ".join([*nodes[half:], *nodes[:half]] if len(nodes) > 4 else nodes[::-1])


Change = Callable[[list[list[str]], int], list[list[str]]]


def _of_joint(text: str, change: Change) -> str:
    """A deck whose rows of cohesive elements are changed."""
    head, line, rest = re.split(r"(\*Element, type=COH.*\n)", text)
    data, star, tail = rest.partition("*")
    rows = [[word.strip() for word in row.split(",")] for row in data.splitlines()]
    changed = change(rows, len(rows[0]) - 1)
    return head + line + "".join(", ".join(row) + "\n" for row in changed) + star + tail


def _across(rows: list[list[str]], n: int) -> list[list[str]]:
    """The stack direction lies in the plane."""
    order = {4: [0, 3, 2, 1], 6: [0, 3, 4, 2, 5, 1], 8: [0, 1, 5, 4, 3, 2, 6, 7]}[n]
    return [[row[0], *(row[1 + k] for k in order)] for row in rows]


def _twisted(rows: list[list[str]], n: int) -> list[list[str]]:
    """The nodes of the upper side are in another order."""
    order = {4: [0, 1, 3, 2], 6: [0, 1, 2, 5, 3, 4], 8: [0, 1, 2, 3, 6, 7, 4, 5]}[n]
    return [[row[0], *(row[1 + k] for k in order)] for row in rows]


def _inside_out(rows: list[list[str]], n: int) -> list[list[str]]:
    """Both sides are in the opposite sense."""
    order = {4: [1, 0, 3, 2], 6: [0, 2, 1, 3, 5, 4], 8: [0, 3, 2, 1, 4, 7, 6, 5]}[n]
    return [[row[0], *(row[1 + k] for k in order)] for row in rows]


def _forgotten(text: str) -> str:
    """The first element is no member of the set of the joint."""
    text = re.sub(r"generate\n(\d+)", lambda match: f"generate\n{int(match[1]) + 1}", text)
    return re.sub(r"(\*Elset, elset=JOINT\n)\d+\n", r"\1", text)


def _geometry(text: str) -> str:
    """The thickness of the section is that of the nodes, which is another one."""
    if "GEOMETRY" in text:
        return text
    return re.sub(r"(thickness=)SPECIFIED(.*)\n[^,]*,", r"\1GEOMETRY\2\n,", text)


def _other(match: re.Match[str]) -> str:
    """The other side in a line of a tie."""
    return match[1] + ("UP" if match[2] == "LOW" else "LOW")


def _past(text: str) -> str:
    """A tie connects the solids on both sides of the joint."""
    at = "I-1." if "*Instance" in text else ""
    tie = f"*Tie, name=PAST\n{at}S_UP, {at}S_LOW\n"
    return (
        text.replace("*End Assembly\n", f"{tie}*End Assembly\n")
        if at
        else text.replace("*Step", f"{tie}*Step")
    )


def _past_nodes(text: str) -> str:
    """A tie past the joint, whose own ties have its nodes as surfaces, in the other order."""
    rows = re.search(r"\*Element, type=COH.*\n([^*]*)", text)
    assert rows
    elements = [row.split(", ")[1:] for row in rows[1].splitlines()]
    half = len(elements[0]) // 2

    def nodes(match: re.Match[str]) -> str:
        side = slice(half) if match[2] == "1" else slice(half, None)
        own = dict.fromkeys(node for row in elements for node in row[side])
        lines = "\n".join(own)
        return f"*Nset, nset=N_{match[1]}\n{lines}\n*Surface, type=NODE, name=G_{match[1]}\nN_{match[1]}\n"

    changed = re.sub(r"\*Surface, name=G_(\w+)\nGLUE, S(\d)\n", nodes, text)
    return re.sub(r"(\*Tie, name=PAST\n)(.*), (.*)", r"\1\3, \2", _past(changed))


def _linked(text: str, words: Callable[[str, str], str], at_solids: bool = False) -> str:
    """Deck with lines for each node of the lower side of the joint and that of the upper one.

    at_solids: nodes of the solids that ties connect with those sides.
    """
    rows = re.search(r"\*Element, type=COH.*\n([^*]*)", text)
    assert rows
    nodes = [row.split(", ")[1:] for row in rows[1].splitlines()]
    low_up = {
        (row[i], row[-1 - i] if len(row) == 4 else row[i + len(row) // 2])
        for row in nodes
        for i in range(len(row) // 2)
    }
    if at_solids:
        places = dict(re.findall(r"^(\d+), (.*)$", text.partition("*Element")[0], re.MULTILINE))
        solids = [
            {node for line in part[1].splitlines() for node in line.split(", ")[1:]}
            for part in re.finditer(r"elset=(?:LOWER|UPPER)\n([^*]*)", text)
        ]
        below = {tuple(places[node].split(", ")): node for node in sorted(solids[0])}
        above = {tuple(places[node].split(", ")): node for node in sorted(solids[1])}
        sides = [tuple(tuple(places[node].split(", ")) for node in pair) for pair in low_up]
        if sides[0][0] not in below or sides[0][1] not in above:
            sides = [pair[::-1] for pair in sides]
        low_up = {(below[low], above[up]) for low, up in sides}
    at = "I-1." if "*Instance" in text else ""
    lines = "".join(words(at + low, at + up) for low, up in sorted(low_up))
    if at:
        return text.replace("*End Assembly\n", f"{lines}*End Assembly\n")
    return text.replace("*Step", f"{lines}*Step")


def harmless(draw: np.random.Generator, text: str) -> str:
    """A right deck with equations and links that hold no side of a joint to the other one, now and then."""
    other = str(draw.choice(["PIN", "BEAM", "TIE"]))
    kind = int(draw.integers(9))
    control = "*Equation\n3\n{0}, 2, 1., {1}, 2, -1., 1000000, 2, -1.\n"
    opposite = "*Equation\n2\n{0}, 2, 1., {1}, 2, 1.\n"
    along = "*Equation\n2\n{0}, 1, 1., {0}, 2, -1.\n"
    words = [
        control, opposite, along, "", f"*MPC\n{other}, {{0}}, 1000000\n", COUPLING.format("{0}"),
        COUPLING.format("{0}, 1, 1\n{1}, 1, 1"), "*Boundary\n{0}, 1, 3\n{1}, 2\n",
        "*Boundary\n{0}, 1, 3\n{1}, 1, 1, 0.1\n{1}, 2, 3\n",
    ][kind]  # fmt: skip
    linked = _linked(text, lambda low, up: words.format(low, up)) if words else text
    if "1000000" not in linked:
        return linked
    head, star, tail = linked.partition("*End Instance\n")
    free = "*Node\n1000000, 0., 0.\n"
    return head + star + free + tail if star else linked.replace("*Node\n", free, 1)


def _unsymm(text: str) -> str:
    """The step leaves the choice of the solver to Abaqus."""
    return text.replace("*Step, unsymm=YES", "*Step")


EQUATION = "*Equation\n2\n{0}, 1, 1., {1}, 1, -1.\n"
"""Equal displacements of two nodes."""

LINEAR = "*Equation\n3\n{0}, 2, 1., {1}, 2, -0.5, {1}, 2,\n-0.5\n"
"""The same in two lines, by two terms of one node."""


COUPLING = "*Kinematic Coupling, ref node=1000000\n{}\n"
"""Nodes that move with one reference node."""


def _rigid_body(low: str, up: str) -> str:
    """Nodes of both sides in a rigid body."""
    name = f"N{low}_{up}".replace(".", "_")
    return f"*Nset, nset={name}\n{low}, {up}\n*Rigid Body, ref node=1000000, tie nset={name}\n"


def _stitched(text: str, edge: bool) -> str:
    """The elements of both sides have one node within the joint, or those of the edge of two elements."""
    part = re.search(r"\*Element, type=COH.*\n([^*]*)", text)
    assert part
    rows = [row.split(", ")[1:] for row in part[1].splitlines()]
    n = len(rows[0])
    pairs = [{(row[i], row[n - 1 - i] if n == 4 else row[i + n // 2]) for i in range(n // 2)} for row in rows]
    each = [pair for around in pairs for pair in around]
    most = max(each, key=each.count)
    edges = [a & b for k, a in enumerate(pairs) for b in pairs[:k] if len(a & b) == (1 if n == 4 else 2)]
    merged = {most} if each.count(most) >= {4: 2, 6: 6, 8: 4}[n] else set()
    for low, up in next(iter(edges), set()) if edge else merged:
        blocks = re.split(r"(\*Element, .*\n[^*]*)", text)
        blocks[1::2] = [re.sub(rf"(?<=, ){up}\b", low, block) for block in blocks[1::2]]
        text = "".join(blocks)
    return text


def _stack(text: str) -> str:
    """The stack direction of the section is another one."""
    bare = re.sub(r", stack direction=\d", "", text)
    return bare.replace("SEPARATION, thickness", "SEPARATION, stack direction=1, thickness")


MISTAKES: dict[str, Callable[[str], str]] = {
    "across": lambda text: _of_joint(text, _across),
    "twisted": lambda text: _of_joint(text, _twisted),
    "one twisted": lambda text: _of_joint(text, lambda rows, n: _twisted(rows[:1], n) + rows[1:]),
    "inside out": lambda text: _of_joint(text, _inside_out),
    "closed": lambda text: _of_joint(text, lambda rows, n: [_closed(row, n) for row in rows]),
    "stitched": lambda text: _stitched(text, edge=False),
    "stitched edge": lambda text: _stitched(text, edge=True),
    "twice": lambda text: _of_joint(text, lambda rows, n: [*rows, ["900", *rows[-1][1:]]]),
    "forgotten": _forgotten,
    "empty section": lambda text: text.replace(
        "*Cohesive Section", "*Solid Section, elset=NOTHING, material=STONE\n,\n*Cohesive Section", 1
    ),
    "geometry": _geometry,
    "stack direction": _stack,
    "no tie": lambda text: re.sub(r"\*Tie, name=T_LOW\n.*\n", "", text),
    "no ties": lambda text: re.sub(r"\*Tie, name=T_\w+\n.*\n", "", text),
    "tie twice": lambda text: re.sub(r"(\*Tie, name=)(T_LOW)(\n.*\n)", r"\1\2\3\1AGAIN\3", text),
    "ties crossed": lambda text: re.sub(r"(G_.*S_)(LOW|UP)$", _other, text, flags=re.MULTILINE),
    "tied to one side": lambda text: re.sub(r"(G_UP, .*S_)UP$", r"\1LOW", text, flags=re.MULTILINE),
    "past the joint": _past,
    "past as contact": lambda text: _past(text).replace(
        "*Tie, name=PAST", "*Contact Pair, interaction=SLIDES"
    ),
    "past nodes of the joint": _past_nodes,
    "no unsymm": _unsymm,
    "equations": lambda text: _linked(text, lambda a, b: EQUATION.format(a, b)),
    "equations of three terms": lambda text: _linked(text, lambda a, b: LINEAR.format(b, a)),
    "no material": lambda text: re.sub(r"(\*Solid Section, elset=UPPER, material=)\w+", r"\1STON", text),
    "supports": lambda text: _linked(text, lambda a, b: f"*Boundary\n{a}, 1, 3\n{b}, PINNED\n"),
    "one coupling": lambda text: _linked(text, lambda a, b: COUPLING.format(f"{a}\n{b}")),
    "rigid body": lambda text: _linked(text, _rigid_body, at_solids=True),
    "links": lambda text: _linked(text, lambda a, b: f"*MPC\nTIE, {b}, {a}\n"),
    "tie and links": lambda text: _linked(text, lambda a, b: f"*MPC\nPIN, {a}, {b}\n", at_solids=True),
    "tie and equations": lambda text: _linked(text, lambda a, b: EQUATION.format(b, a), at_solids=True),
    "width": lambda text: re.sub(r"(\*Solid Section, .*\n)[\d.]*,", r"\g<1>7.5,", text),
    "solids in no section": lambda text: re.sub(r"\*Solid Section, elset=UPPER.*\n.*\n", "", text),
    "two sections": lambda text: text.replace("Solid Section, elset=UPPER", "Solid Section, elset=JOINT"),
    "solid inside out": lambda text: re.sub(r"(elset=UPPER\n\d+, )(.*)", _backward, text),
    "section of one side": lambda text: re.sub(r"(elset=UPPER, material=STONE\n)[\d.]*,", r"\g<1>7.5,", text),
}
"""Changes of a deck that make one mistake; a change may fit some decks only."""


def _closed(row: list[str], n: int) -> list[str]:
    """An element whose upper side has the nodes of the lower one."""
    if n == 4:
        return [row[0], row[1], row[2], row[2], row[1]]
    return [row[0], *row[1 : 1 + n // 2], *row[1 : 1 + n // 2]]


def mistaken(seed: int, kind: str) -> str | None:
    """A drawn deck with a mistake of this kind; None where the deck cannot have it."""
    draw = np.random.default_rng([seed, sorted(MISTAKES).index(kind)])
    tied = (
        True
        if kind.startswith(("no tie", "tie")) or kind.startswith("past")
        else False
        if kind in ("inside out", "closed")
        else None
    )
    text = bonded(draw, tied, ways=False).text
    if kind in ("width", "section of one side") and "CPS" not in text and "CPE" not in text:
        return None
    changed = MISTAKES[kind](text)
    return changed if changed != text else None
