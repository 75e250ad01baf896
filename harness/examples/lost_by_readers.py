"""What libraries lose of small Abaqus decks: `lost_by_readers.py [LIBRARY ...]`, by default meshio.

Each deck is written to the current folder, so that it can go with a report.
"""

from __future__ import annotations

import contextlib
import io
import sys
from importlib import import_module
from pathlib import Path

SQUARE = "1, 0., 0.\n2, 1., 0.\n3, 1., 1.\n4, 0., 1.\n"
CELL = "*Element, type=CPS4, elset=E\n1, 1, 2, 3, 4\n"
PART = f"*Part, name=P\n*Node\n{SQUARE}*Element, type=CPS4\n1, 1, 2, 3, 4\n*End Part\n*Assembly, name=A\n"
DECKS = {
    "instances": (
        f"{PART}*Instance, name=I1, part=P\n*End Instance\n*Instance, name=I2, part=P\n5., 0., 0.\n"
        "*End Instance\n*End Assembly\n",
        "8 nodes, x 0 to 6, 2 cells",
    ),
    "turned": (
        f"{PART}*Instance, name=I1, part=P\n5., 0., 0.\n5., 0., 0., 5., 0., 1., 90.\n*End Instance\n"
        "*End Assembly\n",
        "4 nodes, x 4 to 5, 1 cells",
    ),
    "surface": (
        f"*Node\n{SQUARE}{CELL}*Surface, name=F\n1, S1\n",
        "4 nodes, x 0 to 1, 1 cells, names E F",
    ),
    "indented": (
        f"*Node\n{SQUARE} *Element, type=CPS4, elset=E\n1, 1, 2, 3, 4\n",
        "4 nodes, x 0 to 1, 1 cells, names E",
    ),
    "cohesive": (
        f"*Node\n{SQUARE}*Element, type=COH2D4, elset=J\n1, 1, 2, 3, 4\n",
        "4 nodes, x 0 to 1, 1 cells, names J",
    ),
    "twice": (
        f"*Node\n{SQUARE}*Node\n2, 9., 0.\n{CELL}",
        "4 nodes, x 0 to 9, 1 cells, names E",
    ),
    "generate": (
        f"*Node\n{SQUARE}{CELL}*Nset, nset=N, generate\n1, 4\n",
        "4 nodes, x 0 to 1, 1 cells, names E N",
    ),
    "copied": (
        f"*Node, nset=X\n{SQUARE}*Ncopy, change number=10, old set=X, shift\n5., 0., 0.\n"
        "*Element, type=CPS4, elset=E\n1, 11, 12, 13, 14\n",
        "4 nodes, x 5 to 6, 1 cells, names E X",
    ),
}
"""Decks, and what Abaqus reads of each: nodes of its cells, cells and names."""


def read(library: str, path: Path) -> str:
    """What a library reads of a file, or how it fails."""
    try:
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
            mesh = import_module(library).read(str(path))
    except SystemExit:
        return "ends the program"
    except Exception as error:  # each library has its own
        return type(error).__name__
    cells = sum(len(block.data) for block in mesh.cells)
    if not cells:
        return "no cells"
    x = [
        float(mesh.points[i][0]) for i in {int(i) for block in mesh.cells for row in block.data for i in row}
    ]
    names = " ".join(sorted({*mesh.point_sets, *mesh.cell_sets}))
    text = f"{len(x)} nodes, x {min(x):g} to {max(x):g}, {cells} cells"
    return text + (f", names {names}" if names else "")


if __name__ == "__main__":
    for name, (text, expected) in DECKS.items():
        file = Path(f"{name}.inp")
        file.write_text(text, encoding="utf-8")
        print(f"{file}: {expected}")
        for library in sys.argv[1:] or ["meshio"]:
            found = read(library, file)
            print(f"    {library}: {'right' if found == expected else found}")
