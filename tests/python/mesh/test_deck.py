"""Lines of a deck as editors write them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from asperity.mesh import split

from mesh import drawn_meshes
from mesh.support_meshes import placed
from mesh.test_files import read, same_counts
from mesh.test_sides import DRAWN


def test_indented_keywords(tmp_path: Path) -> None:
    """The first sign of a line that is no blank makes it a keyword or a comment."""
    for seed in range(DRAWN):
        drawn = drawn_meshes.deck(seed)
        draw = np.random.default_rng([seed, 3])
        indented = {
            name: "".join(f"{' ' * int(draw.integers(4))}{line}\n" for line in text.splitlines())
            for name, text in drawn.files.items()
        }
        same_counts(split(placed(tmp_path, indented)), read("deck", drawn.files))
