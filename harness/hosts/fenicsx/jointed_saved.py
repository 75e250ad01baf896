"""Files from which a run goes on, FILE.RANK.npz: displacements, joints and numbers of the run."""

from __future__ import annotations

import zipfile
import zlib
from pathlib import Path

from jointed_model import Model  # isort: skip  # loads MPI
import numpy as np
from asperity.contract import Floats
from jointed_mesh import COMM
from mpi4py import MPI
from numpy.typing import ArrayLike


def write(
    file: str | Path, m: Model, joints: dict[str, list[Floats]] | None = None, **numbers: ArrayLike
) -> None:
    """Write a model after its last step, lists of the points of its joints and numbers of the run."""
    parts = {"s": m.s, "state": m.state} | (joints or {})
    rows = {f"{name}{k}": array for name, arrays in parts.items() for k, array in enumerate(arrays)}
    new = Path(file).with_suffix(f".{COMM.rank}.new.npz")
    np.savez(
        new,
        u=m.u,
        p=m.water.p,
        ranks=COMM.size,
        **rows,
        **{name: np.asarray(number) for name, number in numbers.items()},
    )
    new.replace(Path(file).with_suffix(f".{COMM.rank}.npz"))  # whole even if the run is ended here


def read(
    file: str | Path, m: Model, joints: tuple[str, ...] = (), **numbers: tuple[int, ...]
) -> dict[str, Floats]:
    """Take a model on from a file, and return all of it; ValueError if it is of another run or version.

    joints: names of the lists that `write` got; numbers: shapes of the numbers.
    """
    path, saved = Path(file).with_suffix(f".{COMM.rank}.npz"), {}
    try:
        with np.load(path) as data:
            saved = dict(data)
    except (OSError, EOFError, ValueError, TypeError, AttributeError, zipfile.BadZipFile, zlib.error):
        saved = {}  # all ranks refuse it below
    shapes = {"u": m.u.shape, "p": m.water.p.shape, "ranks": (), **numbers}
    for names, points in ((("s", *joints), m.s), (("state",), m.state)):
        shapes |= {f"{name}{k}": separation.shape for name in names for k, separation in enumerate(points)}
    same = all(name in saved and saved[name].shape == shape for name, shape in shapes.items())
    if not COMM.allreduce(bool(same and saved["ranks"] == COMM.size), MPI.LAND):
        raise ValueError(f"{file}: expected the files of a run with the same mesh, laws and ranks")
    m.u, m.water.p = saved["u"], saved["p"]
    m.s, m.state = ([saved[f"{name}{k}"] for k in range(len(m.laws))] for name in ("s", "state"))
    return saved
