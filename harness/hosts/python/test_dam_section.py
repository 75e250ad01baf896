"""Section of the dam that FEniCSx and OpenGeoSys share."""

from __future__ import annotations

import numpy as np
import pytest
from dam_section import BASE, CREST, HEIGHT, PARAPET, section


@pytest.mark.parametrize("parts", [1, 7, 20, 45, 50])
def test_areas_with_any_number_of_elements(parts: int) -> None:
    """The dam, which has the weight, and the parapet on it have the areas of the section."""
    mesh = section(parts)
    [cells], [block] = mesh.cells.values(), mesh.block.values()
    x, y = np.moveaxis(mesh.points[cells], 2, 0)
    areas = 0.5 * (x * np.roll(y, -1, 1) - y * np.roll(x, -1, 1)).sum(axis=1)
    of_block = dict(zip(mesh.names, np.bincount(block, areas), strict=True))
    assert of_block["dam"] == pytest.approx(HEIGHT * (BASE + CREST) / 2.0)
    assert of_block["parapet"] == pytest.approx((PARAPET - HEIGHT) * CREST)
