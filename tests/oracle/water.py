"""Water pressure in a joint, beside the law of reference.py, which knows none."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray


def total(traction: ArrayLike, p: ArrayLike) -> NDArray[np.floating]:
    """Total traction (..., 3) of one (..., 3) that the law carries, under a pressure p (...,).

    The water pushes the sides apart: t_N is less by p. It carries no shear.
    """
    return np.asarray(traction, float) - np.multiply.outer(p, [1.0, 0.0, 0.0])
