"""A fibre pulled out of a rigid block: axisymmetric elements in NumPy, a joint by asperity, closed forms.

The deck has elements CAX4 of the fibre and of the block, `split` doubles the nodes between them, and the
joint is integrated at the nodes of its faces with the weight 2 pi r.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from asperity import Interface, Material, Pattern
from asperity.mesh import split
from scipy import sparse
from scipy.sparse.linalg import spsolve

A, L, E, PARTS = 1.0, 600.0, 2.0e5, 300  # radius and length of the fibre, mm; Young's modulus, MPa; elements
BOND = Material(sigma0=2.0, Gc=0.2, eta=0.9, mu=0.0)
STEPS, LAST = 100, 1.5  # increments, and last displacement of the end over s_f
POINTS = np.array([-1.0, 1.0]) / np.sqrt(3.0)


def deck() -> str:
    """Deck of a fibre and a block around it, from z = 0 to L."""
    z = np.linspace(0.0, L, PARTS + 1)
    n = len(z)
    nodes = [
        f"{1 + k * n + i}, {r:.15g}, {z[i]:.15g}\n" for k, r in enumerate((0.0, A, 2.0 * A)) for i in range(n)
    ]
    text = "*Node\n" + "".join(nodes)
    for k, name in enumerate(("FIBRE", "BLOCK")):
        rows = [(k * n + i, (k + 1) * n + i, (k + 1) * n + i + 1, k * n + i + 1) for i in range(n - 1)]
        lines = [
            f"{1 + k * n + j}, {', '.join(str(1 + node) for node in row)}\n" for j, row in enumerate(rows)
        ]
        text += f"*Element, type=CAX4, elset={name}\n{''.join(lines)}"
    return text


def stiffness(points: np.ndarray, cells: np.ndarray) -> sparse.csr_array:
    """Stiffness of axisymmetric bilinear elements without lateral strain; unknowns u_r, u_z of each node."""
    D = E * np.diag([1.0, 1.0, 1.0, 0.5])  # strains rr, zz, circumferential, 2 rz; Poisson's ratio 0
    corner = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    K = np.zeros((len(cells), 8, 8))
    for xi in POINTS:
        for eta in POINTS:
            shape = 0.25 * (1.0 + corner[:, 0] * xi) * (1.0 + corner[:, 1] * eta)
            local = 0.25 * np.stack(
                [corner[:, 0] * (1.0 + corner[:, 1] * eta), corner[:, 1] * (1.0 + corner[:, 0] * xi)]
            )
            J = local @ points[cells]
            slope = np.linalg.solve(J, np.broadcast_to(local, (len(cells), 2, 4)))
            r = points[cells][:, :, 0] @ shape
            B = np.zeros((len(cells), 4, 8))
            B[:, 0, 0::2], B[:, 1, 1::2] = slope[:, 0], slope[:, 1]
            B[:, 2, 0::2] = shape / r[:, None]
            B[:, 3, 0::2], B[:, 3, 1::2] = slope[:, 1], slope[:, 0]
            weight = 2.0 * np.pi * r * np.linalg.det(J)
            K += np.einsum("m,mai,ab,mbj->mij", weight, B, D, B)
    at = (2 * cells[:, :, None] + [0, 1]).reshape(len(cells), 8)
    rows, columns = np.repeat(at, 8, axis=1).ravel(), np.tile(at, 8).ravel()
    return sparse.coo_array((K.ravel(), (rows, columns)), shape=(2 * len(points),) * 2).tocsr()


def pulled(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Displacement and force of the pulled end at z = L."""
    path.write_text(deck(), encoding="utf-8")
    mesh = split(path, axisymmetric=True)
    [cells], [[joint]] = mesh.cells.values(), mesh.joints.values()
    points, count = mesh.points, 2 * len(mesh.points)
    K = stiffness(points, cells)
    # separations (N, Tx) at both nodes of each face, and their weights
    ends = joint.minus.shape[1]
    pairs = np.stack([joint.minus, joint.plus], axis=2).reshape(-1, 2)
    axes = np.repeat(joint.axes, ends, axis=0)
    weight = np.repeat(joint.area / ends, ends) * 2.0 * np.pi * points[pairs[:, 0], 0]
    rows = np.repeat(np.arange(2 * len(pairs)), 2)
    jump = sparse.csr_array((2 * len(pairs), count))
    for side, sign in ((0, -1.0), (1, 1.0)):
        columns = np.tile(2 * pairs[:, side, None] + [0, 1], 2).ravel()
        jump += sparse.coo_array((sign * axes.ravel(), (rows, columns)), shape=jump.shape).tocsr()
    law = Interface(BOND, Pattern.regular(0, 0.0))
    state, s_old = np.zeros((len(pairs), law.nstatv)), np.zeros((len(pairs), 3))
    fibre = np.unique(cells[mesh.block["quad"] == mesh.names.index("FIBRE")])
    end = fibre[points[fibre, 1] > L * (1.0 - 1e-9)]
    free = np.zeros(count, bool)
    free[2 * fibre], free[2 * fibre + 1] = points[fibre, 0] > 0.0, True
    free[2 * end + 1] = False
    u, moved, forces = np.zeros(count), [0.0], [0.0]
    for target in np.linspace(0.0, LAST * BOND.s_f, STEPS + 1)[1:]:
        u[2 * end + 1] = target
        for _ in range(50):
            s = np.zeros((len(pairs), 3))
            s[:, :2] = (jump @ u).reshape(-1, 2)
            new = law.update(s, state, s_old)
            inner = K @ u + jump.T @ (weight[:, None] * new.traction[:, :2]).ravel()
            if np.abs(inner[free]).max() <= 1e-9 * np.abs(inner).max():
                break
            blocks = weight[:, None, None] * new.tangent[:, :2, :2]
            n = len(pairs)
            of_joint = sparse.bsr_array((blocks, np.arange(n), np.arange(n + 1)), shape=(2 * n, 2 * n))
            tangent = (K + jump.T @ of_joint @ jump).tocsr()
            u[free] -= spsolve(tangent[free][:, free].tocsc(), inner[free])
        else:
            raise RuntimeError(f"no equilibrium at {target:g} mm")
        state, s_old = new.state, s
        moved.append(float(target))
        forces.append(float(inner[2 * end + 1].sum()))
    return np.array(moved), np.array(forces)


def closed_forms() -> tuple[float, float]:
    """Initial stiffness of a fibre with an elastic bond, and the largest force of a long one."""
    area, around = np.pi * A**2, 2.0 * np.pi * A
    length = np.sqrt(E * area / (around * BOND.K))
    return E * area / length * np.tanh(L / length), float(np.sqrt(2.0 * E * area * around * BOND.Gc))


if __name__ == "__main__":
    displacement, force = pulled(Path(sys.argv[1] if len(sys.argv) > 1 else "pull_out.inp"))
    slope, largest = closed_forms()
    print(f"stiffness  {force[1] / displacement[1]:.1f} N/mm, closed form {slope:.1f}")
    print(f"force      {force.max():.1f} N, closed form {largest:.1f}")
