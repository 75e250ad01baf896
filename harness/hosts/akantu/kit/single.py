"""One cohesive element in Akantu: pressed, then slid along Tx; its rows beside those of the material point.

The blocks beside it move as rigid bodies, so that the opening is the only unknown.
"""

import json
import os
from pathlib import Path

import akantu as aka
import numpy as np
from asperity.export.element import Element
from asperity_akantu import register

HERE = Path(__file__).parent
MOST_ITERATIONS = 100
value = json.loads((HERE / "model.json").read_text(encoding="utf-8"))["value"]
element = Element.of_case(HERE / "joint.nml", value)
tolerance = 1.0e-10 * element.interface.material.sigma0

made = register()
os.chdir(HERE)
aka.parseInput("material.dat")
mesh = aka.Mesh(3)
mesh.read("single.msh")
model = aka.SolidMechanicsModelCohesive(mesh)
model.initFull(_analysis_method=aka._static, _is_extrinsic=False)
[joint] = made
# the joint has nodes of its own on either side, of which the upper ones belong to the upper block
solids = np.array(mesh.getConnectivity(aka._hexahedron_8))
heights = np.array(mesh.getNodes())[solids, 2].mean(axis=1)
upper = solids[heights.argmax()]
displacement = model.getDisplacement()


def step(slip: float, sigma_N: float, opening: float) -> tuple[float, np.ndarray]:
    """Find the opening at which the joint carries sigma_N; returns it and the traction (N, Tx, Ty)."""
    for _ in range(MOST_ITERATIONS):
        displacement[upper, 0], displacement[upper, 2] = slip, opening
        model.assembleInternalForces()
        [kind] = joint.types()
        points = joint.points(kind)
        left = points.traction[:, 0].mean() - sigma_N
        if abs(left) <= tolerance:
            joint.commit()
            return opening, points.traction.mean(axis=0)
        opening -= left / points.tangent[:, 0, 0].mean()
    raise SystemExit(f"slip {slip:g}: no opening carries {sigma_N:g}")


opening, found = 0.0, []
for k in range(1, element.press + 1):
    opening, traction = step(0.0, element.sigma_N * k / element.press, opening)
for k in range(1, element.slide + 1):
    slip = element.slip * k / element.slide
    opening, traction = step(slip, element.sigma_N, opening)
    if k % element.every == 0:
        force = -np.array(model.getInternalForce())[upper, 0].sum()
        found.append((slip, opening, force))
element.compare(found)
