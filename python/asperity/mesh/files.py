"""Mesh files by meshio."""

from __future__ import annotations

from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np

from ..installed import needed


def read_mesh(path: Path, expected: str, extra: str) -> Any:
    """Mesh of a file by meshio; raises ValueError with the name of the file, why, and what was expected.

    extra: of the package, which brings meshio; ModuleNotFoundError names it.
    """
    needed(extra, "meshio")
    import meshio

    said = StringIO()
    try:
        with redirect_stdout(said), redirect_stderr(said), np.errstate(over="ignore"):
            return meshio.read(path)
    except (Exception, SystemExit) as error:  # meshio prints and exits where it cannot read
        text = (" ".join(said.getvalue().split()) or str(error)).rstrip(".")
        raise ValueError(f"{path}: {text}: expected {expected}") from None
