"""One joint element in Kratos: pressed, then slid along Tx; its rows beside those of the material point."""

import json
from pathlib import Path

import numpy as np
from asperity.export.element import Element
from kratos_model import Structure

HERE = Path(__file__).parent
CORNERS = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]])
value = json.loads((HERE / "model.json").read_text(encoding="utf-8"))["value"]
element = Element.of_case(HERE / "joint.nml", value)
tolerance = 1.0e-10 * element.interface.material.sigma0

s = Structure(3)
lower, upper = s.add_nodes(CORNERS), s.add_nodes(CORNERS)
s.add_interface(lower, upper, s.umat(element.interface))
s.fix(lower, 0, 1, 2)
s.fix(upper, 0, 1)
s.load({number: (0.0, 0.0, 0.0) for number in upper})
for k in range(1, element.press + 1):
    for number in upper:
        s.set_load(number, (0.0, 0.0, 0.25 * element.sigma_N * k / element.press))
    s.step(tolerance)
found = []
for k in range(1, element.slide + 1):
    s.move(upper, 0, element.slip * k / element.slide)
    s.step(tolerance)
    if k % element.every == 0:
        slip, _, opening = s.displacements()[upper - 1].mean(axis=0)
        found.append((slip, opening, s.reaction(upper)[0]))
element.compare(found)
