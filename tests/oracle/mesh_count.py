"""Counts of decks of Abaqus and text files of gmsh: cells, nodes, area and groups of plane meshes.

They know the cards of the drawn files of mesh/test_files.py alone, and nothing of asperity.
"""

from __future__ import annotations

import math

Counts = dict[str, float]
"""`cells`, `nodes`, `area`, and the cells of each group as `cells of NAME`."""


def polygon(x: list[tuple[float, float]]) -> float:
    """Area within a polygon, whatever its sense."""
    return 0.5 * abs(sum(a[0] * b[1] - b[0] * a[1] for a, b in zip(x, x[1:] + x[:1], strict=True)))


def counts(cells: list[tuple[str, list[tuple[float, float]]]], nodes: int, groups: dict[str, int]) -> Counts:
    """Counts of cells with their places."""
    counted: Counts = {"cells": len(cells), "nodes": nodes, "area": math.fsum(polygon(x) for _, x in cells)}
    return counted | {f"cells of {name}": count for name, count in groups.items()}


def deck(files: dict[str, str], name: str = "deck.inp") -> Counts:
    """Counts of a deck with parts, instances, element sets and included files."""
    lines: list[str] = []

    def include(file: str) -> None:
        for line in files[file].splitlines():
            if line.lower().replace(" ", "").startswith("*include,input="):
                include(line.split("=")[1].strip())
            elif not line.startswith("**"):
                lines.append(line)

    include(name)
    parts: dict[str, list[tuple[str, list[str]]]] = {"": []}
    instances: list[tuple[str, str, list[str]]] = []
    here = ""
    for line in lines:
        if line.startswith("*"):
            words = [word.strip().lower() for word in line[1:].split(",")]
            options = dict(word.split("=") for word in words[1:] if "=" in word)
            options = {key.strip(): value.strip() for key, value in options.items()}
            if words[0] == "part":
                here = options["name"]
                parts[here] = []
            elif words[0] in ("end part", "end instance"):
                here = ""
            elif words[0] == "instance":
                instances.append((options["name"], options["part"], []))
                here = f"instance {options['name']}"
                parts[here] = []
            else:
                parts[here].append((line, []))
        elif line.strip():
            if here.startswith("instance ") and not parts[here]:
                instances[-1][2].append(line)
            else:
                parts[here][-1][1].append(line)
    named = [name for name in parts if name]
    if len(named) == 1 and not any(line.lower().startswith("*assembly") for line in lines):
        instances = instances or [("", named[0], [])]
    placed: list[tuple[str, list[tuple[float, float]]]] = []
    groups: dict[str, set[int]] = {}
    nodes = 0
    for place, part, move in [*instances, ("", "", [])]:
        points: dict[int, tuple[float, float]] = {}
        first: dict[int, int] = {}
        used = set()
        for head, data in parts[part]:
            words = [word.strip() for word in head[1:].split(",")]
            if words[0].lower() not in ("node", "element", "elset"):
                continue
            options = {
                word.split("=")[0].strip().lower(): word.split("=")[1].strip()
                for word in words
                if "=" in word
            }
            numbers = [[float(word or 0) for word in line.rstrip().rstrip(",").split(",")] for line in data]
            if words[0].lower() == "node":
                points |= {
                    int(row[0]): _moved((row[1], row[2] if len(row) > 2 else 0.0), move) for row in numbers
                }
            elif words[0].lower() == "element":
                size = int(options["type"][3]) + 1
                flat = [int(word) for row in numbers for word in row]
                for at in range(0, len(flat), size):
                    first[flat[at]] = len(placed)
                    used |= set(flat[at + 1 : at + size])
                    placed.append((place, [points[node] for node in flat[at + 1 : at + size]]))
                    if "elset" in options:
                        groups.setdefault(options["elset"].lower(), set()).add(len(placed) - 1)
            elif words[0].lower() == "elset":
                inside = [int(word) for row in numbers for word in row]
                if "generate" in [word.lower() for word in words]:
                    inside = []
                    for row in numbers:
                        step = int(row[2]) if len(row) > 2 else 1
                        inside += [
                            number for number in range(int(row[0]), int(row[1]) + 1, step) if number in first
                        ]
                groups.setdefault(options["elset"].lower(), set()).update(first[number] for number in inside)
        nodes += len(used)
    return counts(placed, nodes, {name: len(members) for name, members in groups.items()})


def _moved(x: tuple[float, float], move: list[str]) -> tuple[float, float]:
    """A point of an instance, moved and then turned about an axis along z."""
    given = [[float(word or 0) for word in line.rstrip().rstrip(",").split(",")] for line in move]
    if given:
        x = (x[0] + given[0][0], x[1] + (given[0][1] if len(given[0]) > 1 else 0.0))
    if len(given) > 1:
        a, angle = given[1], math.radians(given[1][6]) * math.copysign(1.0, given[1][5] - given[1][2])
        u, v = x[0] - a[0], x[1] - a[1]
        x = (
            a[0] + u * math.cos(angle) - v * math.sin(angle),
            a[1] + u * math.sin(angle) + v * math.cos(angle),
        )
    return x


def gmsh(text: str) -> Counts:
    """Counts of a text file of gmsh, format 2.2 or 4.1, with triangles (2) and quadrilaterals (3)."""
    sections: dict[str, list[list[str]]] = {}
    name = ""
    for line in text.splitlines():
        if line.startswith("$"):
            name = "" if line.startswith("$End") else line[1:].strip()
        elif name and line.strip():
            sections.setdefault(name, []).append(line.split())
    names = {(int(row[0]), int(row[1])): row[2].strip('"') for row in sections.get("PhysicalNames", [])[1:]}
    points: dict[int, tuple[float, float]] = {}
    cells: dict[tuple[int, ...], set[int]] = {}
    if sections["MeshFormat"][0][0].startswith("2"):
        points = {int(row[0]): (float(row[1]), float(row[2])) for row in sections["Nodes"][1:]}
        for row in sections["Elements"][1:]:
            kind, n_tags = int(row[1]), int(row[2])
            if kind in (2, 3):
                cells.setdefault(tuple(map(int, row[3 + n_tags :])), set()).add(int(row[3]))
    else:
        tags = {}
        rows = iter(sections["Entities"])
        counted = [int(word) for word in next(rows)]
        for d, count in enumerate(counted):
            for row in [next(rows) for _ in range(count)]:
                at = 7 if d else 4
                tags[d, int(row[0])] = {int(word) for word in row[at + 1 : at + 1 + int(row[at])]}
        rows = iter(sections["Nodes"][1:])
        for row in rows:
            numbers = [int(next(rows)[0]) for _ in range(int(row[3]))]
            points |= {
                node: (float(x[0]), float(x[1])) for node, x in ((node, next(rows)) for node in numbers)
            }
        rows = iter(sections["Elements"][1:])
        for row in rows:
            for _ in range(int(row[3])):
                nodes = tuple(int(word) for word in next(rows)[1:])
                if int(row[2]) in (2, 3):
                    cells.setdefault(nodes, set()).update(tags[int(row[0]), int(row[1])])
    groups: dict[str, int] = {}
    for inside in cells.values():
        for tag in inside - {0}:
            title = names.get((2, tag), f"block_{tag}").lower()
            groups[title] = groups.get(title, 0) + 1
    placed = [("", [points[node] for node in nodes]) for nodes in cells]
    return counts(placed, len({node for nodes in cells for node in nodes}), groups)
