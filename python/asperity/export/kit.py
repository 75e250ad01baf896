"""The kit for Abaqus: sources, decks, environment file, and a README with what a first run must show."""

from __future__ import annotations

import os
import shutil
import tempfile
from pathlib import Path

from .. import contract, installed
from ..case_files import read_case
from .decks import CASE, DECKS, ROWS, SLIP, SLIP_INCREMENTS

DATA = Path(__file__).parent / "data"
"""README, a template of str.format, and the environment file of Abaqus, which names the compiler."""


def files() -> dict[str, bytes]:
    """Contents of the kit by file name."""
    decks = {name: write() for name, write in DECKS.items()}
    listed = "\n".join(f"| `{name}` | {text.splitlines()[1]} |" for name, text in decks.items())
    readme, environment = (
        (DATA / name).read_text(encoding="ascii") for name in ("README.md", "abaqus_v6.env")
    )
    readme = readme.format(version=contract.library_version(), slip=SLIP, rows=rows(), decks=listed)
    texts = {"README.md": readme, "abaqus_v6.env": environment, "joint.nml": CASE, **decks}
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
