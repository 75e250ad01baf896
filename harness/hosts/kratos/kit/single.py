"""One joint element in Kratos: pressed, then slid along Tx; its rows beside those of the material point."""

from pathlib import Path

import numpy as np
from asperity.export.element import Element
from kratos_model import Structure

CORNERS = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]])
element = Element.of_kit(Path(__file__).parent)

s = Structure(3)
lower, upper = s.add_nodes(CORNERS), s.add_nodes(CORNERS)
s.add_interface(lower, upper, s.umat(element.interface))
s.fix(lower, 0, 1, 2)
s.fix(upper, 0, 1)
s.load({number: (0.0, 0.0, 0.0) for number in upper})


def step(slip: float, sigma_N: float) -> tuple[float, float, float]:
    """Find the equilibrium at a slip under a normal traction; returns slip, opening and force."""
    for number in upper:
        s.set_load(number, (0.0, 0.0, 0.25 * sigma_N))
    s.move(upper, 0, slip)
    s.step(1.0e-10 * element.interface.material.sigma0)
    slip, _, opening = s.displacements()[upper - 1].mean(axis=0)
    return slip, opening, s.reaction(upper)[0]


element.follow(step)
