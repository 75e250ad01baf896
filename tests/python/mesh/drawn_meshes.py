"""Drawn decks of Abaqus and files of gmsh with plane meshes, and mutations of their texts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass
class Drawn:
    """Files by name; cells of each block, area, and length of the joints between blocks."""

    files: dict[str, str]
    blocks: dict[str, int]
    area: float
    length: float


def _styled(draw: np.random.Generator, word: str) -> str:
    return str(draw.choice([word, word.lower(), word.upper()]))


def _grid(draw: np.random.Generator) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
    """Nodes, triangles or quadrilaterals, and the layer of each in a grid; length between layers."""
    n, layers = int(draw.integers(1, 4)), int(draw.integers(2, 4))
    x = np.cumsum([0.0, *draw.uniform(0.5, 2.0, n)])
    y = np.cumsum([0.0, *draw.uniform(0.5, 2.0, layers)])
    points = np.array([[a, b] for b in y for a in x]).round(6)
    quads = [[j * (n + 1) + i + k for k in (0, 1, n + 2, n + 1)] for j in range(layers) for i in range(n)]
    cells, layer = np.array(quads), np.repeat(np.arange(layers), n)
    if draw.random() < 0.5:
        cells = np.concatenate([cells[:, [0, 1, 2]], cells[:, [0, 2, 3]]])
        layer = np.tile(layer, 2)
    return points, cells, layer, (layers - 1) * float(np.ptp(points[:, 0]))


def _rows(draw: np.random.Generator, rows: list[list[object]], split: bool = False) -> list[str]:
    lines = []
    for row in rows:
        words = [str(word) for word in row]
        if split and draw.random() < 0.2:
            at = int(draw.integers(1, len(words)))
            lines += [", ".join(words[:at]) + ",", ", ".join(words[at:])]
        else:
            lines.append(", ".join(words) + ("," if draw.random() < 0.1 else ""))
        if draw.random() < 0.05:
            lines.append("** a comment, with 1, 2, 3")
    return lines


def deck(seed: int) -> Drawn:
    """A deck of parts with numbers of their own, instances moved and turned, sets and an included file."""
    draw = np.random.default_rng(seed)
    files: dict[str, str] = {}
    lines = ["*Heading", " drawn"]
    blocks: dict[str, int] = {}
    area = length = shift = 0.0
    flat = draw.random() < 0.3
    parts = 1 if flat else int(draw.integers(1, 4))
    placed = []
    for p in range(parts):
        points, cells, layer, between = _grid(draw)
        node, element = int(draw.integers(1, 50)), int(draw.integers(1, 50))
        body = [_styled(draw, "*Node")]
        cut = int(draw.integers(1, len(points)))
        rows = [[node + k, *x] for k, x in enumerate(points.tolist())]
        body += _rows(draw, rows[:cut])
        body += [_styled(draw, "*Node"), *_rows(draw, rows[cut:])]
        kind = f"{draw.choice(['CPS', 'CPE'])}{cells.shape[1]}"
        kind += str(draw.choice(["", "R"])) if cells.shape[1] == 4 else ""
        names = [f"L{p}_{k}" for k in range(layer.max() + 1)]
        order = np.argsort(layer, kind="stable")
        cells, layer = cells[order], layer[order]
        numbers = element + np.arange(len(cells))
        of_element = draw.random() < 0.5
        for k, name in enumerate(names):
            at = layer == k
            option = f", elset={name}" if of_element else ""
            body.append(f"{_styled(draw, '*Element')}, type={_styled(draw, kind)}{option}")
            data = np.column_stack([numbers[at], node + cells[at]]).tolist()
            body += _rows(draw, data, split=True)
            if not of_element and draw.random() < 0.5:
                body += [
                    f"{_styled(draw, '*Elset')}, elset={name}, generate",
                    f"{numbers[at][0]}, {numbers[at][-1]}, 1",
                ]
            elif not of_element:
                body += [
                    f"*Elset, elset={name}",
                    *_rows(draw, [numbers[at].tolist()[i : i + 3] for i in range(0, at.sum(), 3)]),
                ]
        body += [f"*Nset, nset=base{p}", f"{node}, {node + 1}"]
        if draw.random() < 0.3:
            files[f"part{p}.txt"] = "\n".join(body) + "\n"
            body = [f"*Include, input=part{p}.txt"]
        x = points[cells]
        y = np.roll(x, -1, axis=1)
        size = 0.5 * float((x[..., 0] * y[..., 1] - x[..., 1] * y[..., 0]).sum())
        uses = 1 if flat else int(draw.integers(1, 3))
        for u in range(uses):
            placed.append((f"I{p}-{u}", f"P{p}", 20.0 * len(placed), float(draw.choice([0.0, 90.0, 30.0]))))
            for k, name in enumerate(names):
                blocks[name if uses == 1 else f"I{p}-{u}_{name}"] = int((layer == k).sum())
        area, length, shift = area + uses * size, length + uses * between, shift + 20.0
        lines += body if flat else [f"{_styled(draw, '*Part')}, name=P{p}", *body, _styled(draw, "*End Part")]
    if not flat:
        lines.append("*Assembly, name=A")
        for name, part, x, angle in placed:
            lines += [f"*Instance, name={name}, part={part}", f"{x}, {draw.integers(0, 5)}., 0."]
            if angle:
                lines.append(f"{x}, 0., 0., {x}, 0., 1., {angle}")
            lines.append("*End Instance")
        lines.append("*End Assembly")
    lines += ["*Material, name=ROCK", "*Elastic", "30000., 0.2"]
    files["deck.inp"] = "\n".join(lines) + "\n"
    return Drawn(files, blocks, area, length)


def gmsh(seed: int) -> Drawn:
    """A file of gmsh, format 2.2 or 4.1, whose layers are groups, and all of them another one."""
    draw = np.random.default_rng(seed)
    points, cells, layer, length = _grid(draw)
    node, layers, kind = int(draw.integers(1, 30)), int(layer.max()) + 1, {3: 2, 4: 3}[cells.shape[1]]
    order = np.argsort(layer, kind="stable")
    cells, layer = cells[order] + node, layer[order]
    of_all = [9] if draw.random() < 0.5 else []
    names = [f'2 {k + 1} "L{k}"' for k in range(layers)] + [f'2 {tag} "all"' for tag in of_all]
    text = ["$PhysicalNames", str(len(names)), *names, "$EndPhysicalNames"]
    if draw.random() < 0.5:
        rows = []
        for cell, k in zip(cells.tolist(), layer.tolist(), strict=True):
            for tag in [k + 1, *of_all]:
                rows.append(f"{len(rows) + 1} {kind} 2 {tag} {k + 1} {' '.join(map(str, cell))}")
        nodes = [f"{node + k} {x} {y} 0" for k, (x, y) in enumerate(points.tolist())]
        text = [
            "$MeshFormat",
            "2.2 0 8",
            "$EndMeshFormat",
            *text,
            "$Nodes",
            str(len(nodes)),
            *nodes,
            "$EndNodes",
        ]
        text += ["$Elements", str(len(rows)), *rows, "$EndElements"]
    else:
        text = ["$MeshFormat", "4.1 0 8", "$EndMeshFormat", *text, "$Entities", f"0 0 {layers} 0"]
        tags = [" ".join(map(str, [1 + len(of_all), k + 1, *of_all])) for k in range(layers)]
        text += [f"{k + 1} 0 0 0 9 9 0 {tags[k]} 0" for k in range(layers)]
        text += [
            "$EndEntities",
            "$Nodes",
            f"1 {len(points)} {node} {node + len(points) - 1}",
            f"2 1 0 {len(points)}",
        ]
        text += [str(node + k) for k in range(len(points))] + [f"{x} {y} 0" for x, y in points.tolist()]
        text += ["$EndNodes", "$Elements", f"{layers} {len(cells)} 1 {len(cells)}"]
        number = 0
        for k in range(layers):
            text.append(f"2 {k + 1} {kind} {(layer == k).sum()}")
            for cell in cells[layer == k].tolist():
                number += 1
                text.append(f"{number} {' '.join(map(str, cell))}")
        text.append("$EndElements")
    x = points[cells - node]
    y = np.roll(x, -1, axis=1)
    area = 0.5 * float((x[..., 0] * y[..., 1] - x[..., 1] * y[..., 0]).sum())
    blocks = {f"L{k}": int((layer == k).sum()) for k in range(layers)}
    return Drawn({"mesh.msh": "\n".join(text) + "\n"}, blocks, area, length)


def mutated(text: str, draw: np.random.Generator) -> str:
    """A text with a few characters, words or lines changed, lost, doubled or moved, or cut off."""
    for _ in range(int(draw.integers(1, 4))):
        lines = text.split("\n")
        k = int(draw.integers(len(lines)))
        how = int(draw.integers(8))
        if how == 0:
            del lines[k]
        elif how == 1:
            lines.insert(k, lines[int(draw.integers(len(lines)))])
        elif how == 2:
            lines = lines[: max(k, 1)]
        elif how == 3:
            i = int(draw.integers(len(lines)))
            lines[k], lines[i] = lines[i], lines[k]
        elif lines[k]:
            words = lines[k].split(" ")
            i, c = int(draw.integers(len(words))), int(draw.integers(len(lines[k])))
            sign = str(draw.choice(list("0123456789.,-*$ =aexn")))
            if how == 4:
                lines[k] = lines[k][:c] + sign + lines[k][c + 1 :]
            elif how == 5:
                lines[k] = lines[k][:c] + lines[k][c + 1 :]
            elif how == 6:
                lines[k] = " ".join(words[:i] + words[i + 1 :])
            else:
                words[i] = str(draw.choice(["0", "-1", "1e30", "nan", "99999", "abc", "", "2.5"]))
                lines[k] = " ".join(words)
        text = "\n".join(lines)
    return text
