"""The kit for Abaqus: sources, decks, environment file, and a README with what a first run must show."""

from __future__ import annotations

import os
import shutil
import tempfile
from pathlib import Path

from .. import contract, installed
from ..case_files import read_case
from .decks import CASE, DECKS, ROWS, SLIP, SLIP_INCREMENTS
from .environment import ENVIRONMENT

README = """# asperity {version} for Abaqus

**Abaqus was not run.** asperity was written without a copy of Abaqus. Its tests read the decks by a syntax
check of their own, call the routines as the manuals say, and run the two decks of one element as material
points. So look at the first run.

## First run: a minute

    abaqus job=single_standard user=asperity_abaqus.f90

One element of 1 mm2 is pressed by 1 MPa and slides by {slip} mm. `single_standard.dat` must show these five
rows: U1 and U3 of the nodes TOP, the total of RF1, and SDV1 of the element.

{rows}

asperity has computed the rows for `joint.nml`, in the same increments. Abaqus should agree to five digits
or better. If it does not, look at these:

- A message that begins with `asperity umat:` names the constant or state variable that was not accepted.
- Signs and order: N is positive in tension; Tx is the first shear direction of the element.
- RF1 is wrong by a factor from the first row on: the thickness of the section is not that of PROPS 9.

`single_explicit.inp` is the same joint for Abaqus/Explicit. RF1 and U3 over U1 follow the rows, with
oscillations:

    abaqus job=single_explicit user=asperity_abaqus.f90 double=both

## Files

| file | what it is |
|---|---|
| `asperity_abaqus.f90` | UMAT and VUMAT in double precision |
| `asperity_abaqus_standard.f90` | UMAT only (on Windows the linker needs one solver's routines only) |
| `asperity_abaqus_explicit.f90` | VUMAT in double precision only |
| `asperity_abaqus_single.f90` | VUMAT in single precision: Abaqus/Explicit without `double=both` |
| `abaqus_v6.env` | the compiler: set `asperity_compiler` in it to "ifort", "ifx" or "gfortran" |
{decks}
| `joint.nml` | the single element as a case of the driver: `asperity run joint.nml --plot` |

Each deck says at its top how to run it and what must come out. Units are mm, N, MPa. For your own material
use `asperity card --host abaqus CASE.nml`.
"""


def files() -> dict[str, bytes]:
    """Contents of the kit by file name."""
    decks = {name: write() for name, write in DECKS.items()}
    listed = "\n".join(f"| `{name}` | {_heading(text)} |" for name, text in decks.items())
    readme = README.format(version=contract.library_version(), slip=SLIP, rows=rows(), decks=listed)
    texts = {"README.md": readme, "abaqus_v6.env": ENVIRONMENT, "joint.nml": CASE, **decks}
    sources = {path.name: path.read_bytes() for path in sorted(installed.abaqus().glob("*.f90"))}
    return {name: text.encode("ascii") for name, text in texts.items()} | sources


def rows() -> str:
    """The five rows of the single element, as a table."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "joint.nml")
        path.write_text(CASE, encoding="ascii")
        run = read_case(path).runs[0]
    found, _ = run.interface.rows(run.steps)
    lines = ["| U1, mm | U3, mm | RF1, N | SDV1 |", "|---|---|---|---|"]
    for k in range(1, ROWS + 1):
        # the last rows are those of the slip, the first of them after one increment
        i = len(found) - 1 - SLIP_INCREMENTS + k * (SLIP_INCREMENTS // ROWS)
        separation, traction = found.separation[i], found.traction[i]
        lines.append(
            f"| {separation[1]:.2f} | {separation[0]:.7f} | {traction[1]:.7f} | {found.damage[i]:.7f} |"
        )
    return "\n".join(lines)


def _heading(text: str) -> str:
    """Heading of a deck, the second line."""
    return text.splitlines()[1]


def write(folder: Path, contents: dict[str, bytes], force: bool = False) -> None:
    """Write files into a folder that does not exist or is empty; with `force` they replace others.

    All files are written beside the folder first and then take their places. Raises ValueError if the folder
    has contents (without `force`), or is not a folder.
    """
    folder = folder.resolve()
    if folder.exists() and not folder.is_dir():
        raise ValueError(f"{folder}: expected a folder, or a name that is not taken")
    if not folder.parent.is_dir():
        raise ValueError(f"{folder.parent}: expected a folder that exists")
    if folder.exists() and any(folder.iterdir()):
        if not force:
            raise ValueError(
                f"{folder}: expected an empty folder or a new one; --force replaces the files of the kit"
            )
        taken = [name for name in contents if (folder / name).is_dir()]
        if taken:
            raise ValueError(f"{folder / taken[0]}: expected a file, or a name that is not taken")
    made = Path(tempfile.mkdtemp(prefix=f".{folder.name}-", dir=folder.parent))
    try:
        for name, text in contents.items():
            (made / name).write_bytes(text)
        folder.mkdir(exist_ok=True)
        for name in contents:
            os.replace(made / name, folder / name)
    finally:
        shutil.rmtree(made)
