"""One cohesive element in Akantu: pressed, then slid along Tx; its rows beside those of the material point.

The blocks beside it move as rigid bodies, so that the opening is the only unknown.
"""

import os
from pathlib import Path

import akantu as aka
import numpy as np
from asperity.export.element import Element
from asperity_akantu import register

HERE = Path(__file__).parent
MOST_ITERATIONS = 100
element = Element.of_kit(HERE)
tolerance = 1.0e-10 * element.interface.material.sigma0

joints = register()
os.chdir(HERE)
aka.parseInput("material.dat")
mesh = aka.Mesh(3)
mesh.read("single.msh")
model = aka.SolidMechanicsModelCohesive(mesh)
model.initFull(_analysis_method=aka._static, _is_extrinsic=False)
[joint] = joints
# the joint has nodes of its own on either side, of which the upper ones belong to the upper block
solids = np.array(mesh.getConnectivity(aka._hexahedron_8))
heights = np.array(mesh.getNodes())[solids, 2].mean(axis=1)
upper = solids[heights.argmax()]
displacement = model.getDisplacement()


def step(slip: float, sigma_N: float) -> tuple[float, float, float]:
    """Find the opening at which the joint carries sigma_N; returns slip, opening and force."""
    displacement[upper, 0] = slip
    for _ in range(MOST_ITERATIONS):
        model.assembleInternalForces()
        [kind] = joint.types()
        points = joint.points(kind)
        unbalanced = points.traction[:, 0].mean() - sigma_N
        if abs(unbalanced) <= tolerance:
            joint.commit()
            force = -np.array(model.getInternalForce())[upper, 0].sum()
            return slip, displacement[upper[0], 2], force
        displacement[upper, 2] -= unbalanced / points.tangent[:, 0, 0].mean()
    raise SystemExit(f"slip {slip:g}: no opening carries {sigma_N:g}")


element.follow(step)
