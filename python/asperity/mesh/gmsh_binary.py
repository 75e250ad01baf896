"""Binary files of gmsh, formats 2.2 and 4.1: the numbers of their sections in the order of the text files.

meshio keeps one physical group of a cell, and none of two groups of one name or with a sign.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..contract import Floats

ORDERS = "expected cells of order 1 or 2 (Mesh.ElementOrder)"
"""What is expected in place of elements of another type."""


@dataclass
class _Bytes:
    """A file, taken one value after the other; order: < or >, of the bytes of a number."""

    path: Path
    data: bytes
    at: int = 0
    section: str = ""
    order: str = "<"

    def take(self, count: int, *kinds: str) -> Floats:
        """Rows (count, n) of the next numbers, each row of n numbers of these kinds: i4, u8, f8."""
        kind = np.dtype([(f"{k}", self.order + name) for k, name in enumerate(kinds)])
        if not 0 <= count <= (len(self.data) - self.at) // kind.itemsize:
            raise self.fail(f"expected {count} more rows of {len(kinds)} numbers")
        rows = np.frombuffer(self.data, kind, count, self.at)
        self.at += count * kind.itemsize
        return np.column_stack([rows[name].astype(float) for name in rows.dtype.names or ()])

    def line(self) -> str:
        """The next line, which is text."""
        end = self.data.find(b"\n", self.at)
        if end < 0:
            raise self.fail("expected a line")
        text, self.at = self.data[self.at : end].decode("latin-1").strip(), end + 1
        return text

    def count(self) -> int:
        """The next line, a number."""
        text = self.line()
        if not text.isdigit():
            raise self.fail(f"{text[:20]!r}: expected a number of rows")
        return int(text)

    def fail(self, text: str) -> ValueError:
        """Error that names the file and the section."""
        return ValueError(f"{self.path}, ${self.section}: {text}")


def read_sections(path: Path, sizes: dict[int, int]) -> dict[str, str | Floats]:
    """Sections by name: text, or numbers; sizes: of elements by gmsh's number of their type.

    Raises ValueError with the section for a file that is cut off, or has sections twice.
    """
    file = _Bytes(path, path.read_bytes())
    parts: dict[str, str | Floats] = {}
    while head := re.compile(rb"\s*\$(\w+)[^\S\n]*\n").match(file.data, file.at):
        file.section, file.at = head[1].decode(), head.end()
        name, version = file.section, str(parts.get("MeshFormat", ""))
        if name in parts:
            raise ValueError(f"{path}: ${name} twice: expected it once")
        if name == "MeshFormat":
            parts[name] = file.line()
            if file.take(1, "i4")[0, 0] != 1.0:
                file.order, file.at = ">", file.at - 4
                if file.take(1, "i4")[0, 0] != 1.0:
                    raise file.fail("expected the number one for the order of the bytes")
        elif reader := READERS.get((version.split(".")[0], name)):
            parts[name] = reader(file, sizes)
        else:
            end = file.data.find(f"$End{name}".encode(), file.at)
            parts[name] = file.data[file.at : max(end, file.at)].decode("utf-8", "replace")
            file.at = end if end >= 0 else len(file.data)
        end_line = re.compile(rf"\s*\$End{name}\b".encode()).match(file.data, file.at)
        if not end_line:
            raise ValueError(f"{path}: ${name} has no $End{name} after its numbers: expected a whole file")
        file.at = end_line.end()
    if file.data[file.at :].strip():
        raise ValueError(f"{path}: more bytes after ${file.section}: expected a section")
    return parts


def _entities4(file: _Bytes, sizes: dict[int, int]) -> Floats:
    counts = file.take(1, *["u8"] * 4)[0]
    numbers = [counts]
    for d, count in enumerate(counts.tolist()):
        for _ in range(int(count)):
            numbers.append(file.take(1, "i4", *["f8"] * (6 if d else 3))[0])
            for _ in range(2 if d else 1):
                numbers.append(file.take(1, "u8")[0])
                numbers.append(file.take(int(numbers[-1][0]), "i4").ravel())
    return np.concatenate(numbers)


def _nodes4(file: _Bytes, sizes: dict[int, int]) -> Floats:
    numbers = [file.take(1, *["u8"] * 4)[0]]
    for _ in range(int(numbers[0][0])):
        d, _, parametric = file.take(1, *["i4"] * 3)[0].tolist()
        count = int(file.take(1, "u8")[0, 0])
        numbers.append(np.array([d, 0.0, parametric, count]))
        numbers.append(file.take(count, "u8").ravel())
        numbers.append(file.take(count, *["f8"] * (3 + int(d if parametric else 0))).ravel())
    return np.concatenate(numbers)


def _elements4(file: _Bytes, sizes: dict[int, int]) -> Floats:
    numbers = [file.take(1, *["u8"] * 4)[0]]
    for _ in range(int(numbers[0][0])):
        head = file.take(1, "i4", "i4", "i4", "u8")[0]
        numbers += [head, file.take(int(head[3]), *["u8"] * (1 + _size(file, head[2], sizes))).ravel()]
    return np.concatenate(numbers)


def _nodes2(file: _Bytes, sizes: dict[int, int]) -> Floats:
    count = file.count()
    return np.append(float(count), file.take(count, "i4", "f8", "f8", "f8").ravel())


def _elements2(file: _Bytes, sizes: dict[int, int]) -> Floats:
    total = file.count()
    numbers, done = [np.array([float(total)])], 0
    while done < total:
        kind, count, tags = (int(value) for value in file.take(1, *["i4"] * 3)[0])
        if not 0 < count <= total - done:
            raise file.fail(f"{count} elements after {done}: expected {total}, as its first line says")
        rows = file.take(count, *["i4"] * (1 + max(tags, 0) + _size(file, kind, sizes)))
        heads = np.broadcast_to([float(kind), float(tags)], (count, 2))
        numbers.append(np.concatenate([rows[:, :1], heads, rows[:, 1:]], axis=1).ravel())
        done += count
    return np.concatenate(numbers)


def _size(file: _Bytes, kind: float, sizes: dict[int, int]) -> int:
    if int(kind) not in sizes:
        raise file.fail(f"elements of type {kind:g}: {ORDERS}")
    return sizes[int(kind)]


READERS: dict[tuple[str, str], Callable[[_Bytes, dict[int, int]], Floats]] = {
    ("4", "Entities"): _entities4, ("4", "Nodes"): _nodes4, ("4", "Elements"): _elements4,
    ("2", "Nodes"): _nodes2, ("2", "Elements"): _elements2,
}  # fmt: skip
"""Readers of the sections of numbers, by the format and the name."""
