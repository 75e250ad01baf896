"""Fill the tables of PROPS, STATEV and sizes into pages, between markers such as <!-- props -->."""

from __future__ import annotations

import argparse
import re
import sys
from collections import Counter
from collections.abc import Callable, Mapping
from pathlib import Path

from asperity import contract
from asperity.tools.tables import markdown

from .program import DIFFERS, program

ROOT = Path(__file__).parents[2]
SIZES_PAGE = "docs/architecture.md"

PARTS = "src", "python/asperity", "harness", "tests", "tools"
"""Folders whose rooms, the folders in them, have a size."""

CODE = {".f90", ".pf", ".inc", ".c", ".h", ".cpp", ".py", ".pyi", ".sh"}
"""Endings of files whose lines are counted."""

ROW_OF_SIZES = re.compile(r"^\| `([\w/]+)` \| \d+ \| (.*) \|$", re.MULTILINE)
"""Part and rooms of a row of the table of sizes."""

TOP = "itself"
"""Room of the files that lie in a part, and in no folder of it."""

FARTHEST, FEWEST = 0.2, 200
"""Relative and absolute difference of lines up to which the number of the page stays."""


def props() -> str:
    """Table of PROPS."""
    constants = contract.props_table()
    rows: list[list[str]] = []
    for row in constants:
        if row.owner != "reserved":
            default = "required" if row.default is None else f"{row.default:.4g}"
            # the page says once what every constant must fulfil
            admissible = re.sub(r" \((0, or 1e-50 to|1e-50 to|at most) 1e50\)", "", row.admissible)
            rows.append([str(row.index), row.name, row.meaning, row.unit, admissible, default])
    listed = "normal (N, Tx, Ty) of any length and weight gamma of each listed plane"
    rows.append([f"{len(constants) + 1}..", "planes", listed, "-", "n_N > 0, gamma > 0, sum of gamma 1", "-"])
    return markdown(["#", "name", "meaning", "unit", "admissible", "default"], rows)


def statev() -> str:
    """Table of STATEV."""
    rows = []
    for row in contract.statev_table():
        place, beyond = str(row.index), row.index - contract.N_POINT_STATEV
        facets = beyond - contract.N_PLANE_STATEV
        if facets > contract.N_FACET_STATEV:
            place = f"last {len(contract.statev_table()) - row.index + 1}"
            place = place.removesuffix(" 1")
        elif beyond > contract.N_PLANE_STATEV:
            first = f"{contract.N_POINT_STATEV} + {contract.N_PLANE_STATEV} Np"
            place = f"{first} + {contract.N_FACET_STATEV} (k - 1) + {facets}"
        elif beyond > 0:
            place = f"{contract.N_POINT_STATEV} + {contract.N_PLANE_STATEV} (k - 1) + {beyond}"
        rows.append([place, row.name, row.meaning, row.unit])
    return markdown(["#", "name", "meaning", "unit"], rows)


def implex() -> str:
    """Table of the state variables of IMPL-EX."""
    rows = contract.implex_table()
    first = len(rows) - 3
    places = [f"n + {row.index}" for row in rows[:first]]
    places += [f"n + {first} + k", *(f"n + {first} + Np + {k}" for k in (1, 2))]
    body = [[place, row.name, row.meaning, row.unit] for place, row in zip(places, rows, strict=True)]
    return markdown(["#", "name", "meaning", "unit"], body)


def sizes(root: Path = ROOT, page: str = SIZES_PAGE) -> str:
    """Table of the lines of each room; a number of the page stays as long as it is near enough."""
    table = ROW_OF_SIZES.findall((root / page).read_text(encoding="utf-8"))
    shown = {
        f"{part}/{room}": int(lines)
        for part, rooms in table
        for room, lines in re.findall(r"(\S+) (\d+)", rooms)
    }
    rows = []
    for part in PARTS:
        counts: Counter[str] = Counter()
        for path in (root / part).rglob("*"):
            if path.suffix in CODE and path.is_file():
                inside = path.relative_to(root / part).parts
                counts[inside[0] if len(inside) > 1 else TOP] += len(path.read_bytes().splitlines())
        lines = {room: _near(count, shown.get(f"{part}/{room}")) for room, count in counts.items()}
        ordered = sorted(lines, key=lambda room: (room == TOP, room))
        rows.append(
            [f"`{part}`", str(sum(lines.values())), ", ".join(f"{room} {lines[room]}" for room in ordered)]
        )
    return markdown(["part", "lines", "of which"], rows)


def _near(count: int, shown: int | None) -> int:
    """Number of lines that is shown for a count: the one before, or two digits of the count."""
    if shown is not None and abs(shown - count) <= max(FARTHEST * count, FEWEST):
        return shown
    return int(float(f"{count:.1e}"))


TABLES: dict[str, Callable[[], str]] = {"props": props, "statev": statev, "implex": implex, "sizes": sizes}
"""Tables by the name of their marker."""


def fill(text: str, contents: Mapping[str, str]) -> str:
    """Put contents between the markers <!-- name --> ... <!-- /name --> of a text."""
    for name, content in contents.items():
        begin, end = f"<!-- {name} -->", f"<!-- /{name} -->"
        block = f"{begin}\n{content}\n{end}".replace("\\", r"\\")  # escaped for re.sub
        text = re.sub(f"{re.escape(begin)}.*?{re.escape(end)}", block, text, flags=re.DOTALL)
    return text


def refresh(path: Path, check: bool, contents: Mapping[str, str | Callable[[], str]] = TABLES) -> bool:
    """Fill the tables of a file and return whether they were up to date; with `check` do not write.

    Raises ValueError for a file without markers.
    """
    text = path.read_text(encoding="utf-8")
    if not any(f"<!-- {name} -->" in text and f"<!-- /{name} -->" in text for name in contents):
        names = " or ".join(f"<!-- {name} --> ... <!-- /{name} -->" for name in contents)
        raise ValueError(f"{path}: expected markers {names}")
    shown = {name: content for name, content in contents.items() if f"<!-- {name} -->" in text}
    filled = fill(
        text, {name: content if isinstance(content, str) else content() for name, content in shown.items()}
    )
    if not check and filled != text:
        path.write_text(filled, encoding="utf-8")
    return filled == text


def refreshed(page: Path, check: bool, contents: Mapping[str, Callable[[], str]]) -> int:
    """Fill the tables of a page or check them, say which, and return the exit code."""
    same = refresh(page, check, contents)
    print(f"{page}: {'up to date' if same else 'not up to date' if check else 'written'}")
    return DIFFERS if check and not same else 0


def _tables(options: argparse.Namespace) -> int:
    """Print the tables, fill them into files, or check the files."""
    if not options.files:
        if options.check:
            raise ValueError("--check: expected files to check")
        print("\n\n".join(table() for table in TABLES.values()))
        return 0
    stale = [path for path in options.files if not refresh(path, options.check)]
    for path in stale:
        print(f"{path}: {'tables are not up to date' if options.check else 'tables filled'}")
    return DIFFERS if options.check and stale else 0


main = program(
    _tables,
    ("files FILE.md", "pages (none: print)", Path, {"nargs": "*"}),
    ("--check", "change nothing; exit with 1 if a file is not up to date"),
)

if __name__ == "__main__":
    sys.exit(main())
