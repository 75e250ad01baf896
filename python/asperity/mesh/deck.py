"""Keyword blocks of an Abaqus deck: continued lines, comments and included files."""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ..contract import Floats, plain

MOST_INCLUDES = 20  # depth at which a file that includes itself is found


WITH_INPUT = "NODE", "ELEMENT", "NSET", "ELSET", "SURFACE", "FIELD", "INITIAL CONDITIONS"
"""Keywords whose data lines may be in a file of their own."""


@dataclass
class Block:
    """A keyword, its parameters by name (upper case; None without a value) and its data lines."""

    keyword: str
    parameters: dict[str, str | None]
    lines: list[str] = field(default_factory=list)
    starts: list[int] = field(default_factory=list)
    places: list[tuple[Path, int]] = field(default_factory=list)

    def where(self, k: int = 0) -> str:
        """File and line of a data line, or of the keyword."""
        i = bisect_right(self.starts, k) - 1
        file, line = self.places[i]
        return f"{file}, line {line + k - self.starts[i]}"

    def head(self) -> str:
        """File and line of the keyword, and the keyword."""
        file, line = self.places[0]
        return f"{file}, line {line - 1}: *{self.keyword.title()}"

    def fail(self, text: str, k: int | None = None) -> ValueError:
        """Error with file and line of the data line k, or of the keyword."""
        return ValueError(f"{self.head() if k is None else self.where(k)}: {text}")

    def name(self, parameter: str) -> str:
        """Value of a parameter that must be there."""
        value = self.parameters.get(parameter)
        if not value:
            raise self.fail(f"expected {parameter.lower()}=NAME")
        return value

    def allow(self, *known: str) -> None:
        """Raise ValueError for a parameter that is not read."""
        for parameter in self.parameters:
            if parameter not in known:
                raise self.fail(f"parameter {parameter.lower()}: expected {', '.join(known).lower()}")

    def rows(self) -> Iterator[tuple[int, list[str]]]:
        """Number and words of each data line; a comma at the end of a line adds no word."""
        for k, line in enumerate(self.lines):
            text = line.strip()
            if text and not is_comment(text):
                yield k, [word.strip() for word in text.removesuffix(",").split(",")]

    def numbers(self, words: list[str], k: int) -> list[float]:
        """Numbers of a data line, an empty one is 0."""
        try:
            values = [float(plain(word).lower().replace("d", "e") or 0) for word in words]
        except ValueError:
            raise self.fail(f"{', '.join(words)}: expected numbers", k) from None
        if not np.isfinite(values).all():
            raise self.fail(f"{', '.join(words)}: expected finite numbers", k)
        return values


def blocks(path: Path) -> list[Block]:
    """Blocks of a deck in their order, included files in their places; ValueError with file and line."""
    deck: list[Block] = []
    _read(path, path.parent, deck, 0)
    for block in deck:
        source = block.parameters.get("INPUT")
        if source and block.keyword in WITH_INPUT:
            file = _other(source, path.parent, path.parent, block)
            _append(block, file, _text(file).splitlines(), 0)
    return deck


def is_comment(line: str) -> bool:
    """Whether a line is a comment, also behind blanks."""
    return line.lstrip().startswith("**")


def _is_keyword(line: str) -> bool:
    """Whether the first sign of a line that is no blank is that of a keyword, as Abaqus has it."""
    return line.lstrip().startswith("*") and not is_comment(line)


def _text(path: Path) -> str:
    data = path.read_bytes()
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("cp1252", errors="replace")


def _other(name: str, home: Path, here: Path, block: Block) -> Path:
    """File that a deck names, beside the deck or beside the file that names it."""
    for folder in (home, here):
        if (file := folder / name.strip("\"'")).is_file():
            return file
    raise block.fail(f"input={name}: no such file")


def _append(block: Block, file: Path, lines: list[str], first: int) -> None:
    if lines:
        block.starts.append(len(block.lines))
        block.places.append((file, first + 1))
        block.lines += lines


def _read(path: Path, home: Path, deck: list[Block], depth: int) -> None:
    """Append the blocks of a file; data lines at its start go on with the last block before."""
    lines = _text(path).splitlines()
    heads = [k for k, line in enumerate(lines) if _is_keyword(line)]
    first = heads[0] if heads else len(lines)
    if deck:
        _append(deck[-1], path, lines[:first], 0)
    elif any(line.strip() and not is_comment(line) for line in lines[:first]):
        raise ValueError(f"{path}: text before the first keyword: expected a deck, as *Node")
    for k, head in enumerate(heads):
        end = heads[k + 1] if k + 1 < len(heads) else len(lines)
        text, last = lines[head].strip(), head + 1
        while text.endswith(",") and last < end:  # a keyword line goes on after a comma
            text, last = text + ("" if is_comment(lines[last]) else lines[last].strip()), last + 1
        words = [" ".join(word.split()) for word in re.findall(r"""((?:"[^"]*"|'[^']*'|[^,])+)""", text[1:])]
        keyword = words[0].upper()
        parameters: dict[str, str | None] = {}
        for word in words[1:]:
            name, equals, value = word.partition("=")
            if name.strip():
                parameters[name.strip().upper()] = value.strip().strip("\"'") if equals else None
        block = Block(keyword, parameters, [], [0], [(path, last + 1)])
        if keyword == "INCLUDE":
            if depth == MOST_INCLUDES:
                raise block.fail(f"{depth} files that include each other")
            _read(_other(block.name("INPUT"), home, path.parent, block), home, deck, depth + 1)
            if deck:
                _append(deck[-1], path, lines[last:end], last)
            continue
        block.lines = lines[last:end]
        deck.append(block)


def table(block: Block, width: int, least: int) -> Floats:
    """Rows of `width` numbers, shorter ones filled with 0 but not below `least`, longer ones cut off."""
    rows = []
    for k, words in block.rows():
        if len(words) < least:
            raise block.fail(f"{', '.join(words)}: expected at least {least} numbers", k)
        rows.append(block.numbers((words + [""] * width)[:width], k))
    return np.array(rows, float).reshape(-1, width)
