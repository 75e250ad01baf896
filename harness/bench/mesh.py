"""Time and memory of `asperity.mesh.split` for a million hexahedra in two blocks."""

from __future__ import annotations

import argparse
import resource
import sys
import time
from pathlib import Path

import numpy as np
from asperity.mesh import split

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
from harness.hosts import structured


def main() -> None:
    """Split a cube of n x n x n cells in the middle; print the seconds of the processor and the memory."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cells", type=int, default=100, help="along an edge (default: %(default)s)")
    n = parser.parse_args().cells
    block = np.ones((n, n, n), int)
    block[n // 2 :] = 2
    mesh = structured.grid(*[range(n + 1)] * 3, block=block, sides=())
    before = time.process_time()
    jointed = split(mesh)
    seconds = time.process_time() - before
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
    print(jointed.summary())
    print(f"{seconds:.1f} s, {memory:.1f} GB")


if __name__ == "__main__":
    main()
