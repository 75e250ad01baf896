"""Connection elements of OpenRadioss beside the joints of FEniCSx, on the same solids; mm, N, s, Mg.

The elements and the engine's calls are those of harness/hosts/radioss, the time integration is that of the
engine: central differences at 0.9 of the step of the elements or of the solids.

- block: of 100 x 100 x 20 mm on a dry joint, whose base is pushed by 0.8 g for 0.1 s: slip of both, and of a
  rigid block, mm.
- cantilever: two arms that are opened by 3.2 mm: crack of both, its energy by both, steps.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable

import numpy as np
from asperity import Interface, Material, Pattern
from asperity.contract import Floats
from asperity.fenicsx import Conditions, Follow, Model, Shake, State, Terms, solve
from asperity.mesh import Jointed, split
from asperity.mesh.shapes import Integers
from asperity.mesh.writing import between

from harness.hosts.fenicsx.words import words_of
from harness.hosts.radioss.element import Elements
from harness.hosts.structured import grid

G, DENSITY, NU = 9810.0, 2.4e-9, 0.2
SHARE = 0.9
"""Of the largest time step."""


class Explicit:
    """Central differences of a model whose joint has connection elements."""

    def __init__(
        self, jointed: Jointed, law: Interface, E: float, density: float, fixed: Callable[[Model], Integers]
    ) -> None:
        """Begin at rest without displacements; fixed: components that are prescribed."""
        self.m = m = Model(jointed, {"joint": law}, E, NU)
        [joint] = jointed.joints["joint"]
        self.nodes = m.local(between(joint, 3).ravel()).reshape(-1, 8)
        self.elements = Elements(law.props(), m.x[self.nodes])
        self.mass = np.abs(m.body([density] * 3))
        self.u, self.v = np.zeros((2, m.n * 3))
        self.fixed = fixed(m)
        stiffness = np.zeros(m.n)
        np.add.at(stiffness, self.nodes, self.elements.stiffness[:, None])
        size = np.diff(np.unique(m.x[:, 2].round(9))).min()
        wave = size * np.sqrt(density * (1.0 + NU) * (1.0 - 2.0 * NU) / (E * (1.0 - NU)))
        nodal = np.sqrt(2.0 * self.mass[::3] / np.maximum(stiffness, 1e-30)).min()
        self.dt, self.taken = SHARE * min(wave, nodal), 0
        self.joint = np.zeros(m.n * 3)

    def step(self, load: Floats | float, prescribed: Floats | float, damping: float = 0.0) -> None:
        """One step under a load with velocities of the prescribed components; damping: 1/s, by mass."""
        force = load + self.joint - self.m.stiff(self.u)
        slow = 0.5 * damping * self.dt
        self.v = ((1.0 - slow) * self.v + self.dt * force / self.mass) / (1.0 + slow)
        self.v[self.fixed] = prescribed
        self.move(self.v)
        self.taken += 1

    def move(self, v: Floats) -> None:
        """Move all nodes for a step, and the joint with them."""
        self.u = self.u + self.dt * v
        x, rate = self.m.x + self.u.reshape(-1, 3), v.reshape(-1, 3)
        self.joint = np.zeros((self.m.n, 3))
        np.add.at(self.joint, self.nodes, self.elements.step(x[self.nodes], rate[self.nodes], self.dt))
        self.joint = self.joint.ravel()


def slid() -> list[float]:
    """Slip of the block by both, and of a rigid one."""
    E, kn, mu, push, end = 2e3, 1.0, 0.5, 0.8 * G, 0.17
    law = Interface(Material.from_joint(kn=kn, ks=0.4 * kn, mu=mu), Pattern.regular(0, 0.0))
    side = np.linspace(0.0, 100.0, 5)
    jointed = split(grid(side, side, [-10.0, 0.0, 10.0, 20.0], block=[0, 1, 1]))
    density, weight = DENSITY, 20.0 * DENSITY * G
    run = Explicit(jointed, law, E, density, lambda m: np.flatnonzero(m.solid("block_0")))
    m, upper = run.m, run.m.solid("block_1")
    # at rest: the pressure of the weight, without the shortening of the block
    down = np.tile([0.0, 0.0, -weight / kn], m.n) * upper
    run.move(down / run.dt)
    field = m.body([0.0, 0.0, -density * G])
    for k in range(round(end / run.dt)):
        inertia = run.mass * np.tile([-push if k * run.dt < 0.1 else 0.0, 0.0, 0.0], m.n)
        run.step(field + inertia, 0.0)
    ours = np.abs(run.u.reshape(-1, 3)[run.nodes[:, 4:], 0]).mean()

    conditions = Conditions(run.fixed, load=field)
    start = solve(m, State.virgin(m), conditions, Terms(dt=1e6, tolerance=1e-8)).taken()
    base = lambda t: [push * (t < 0.1 - 1e-9), 0.0, 0.0]  # noqa: E731
    shake = Shake(m, start, conditions, run.mass, 5e-4, ground=base)
    shaken = np.abs((shake.run(end).s - start.s)[:, 1]) @ m.area / m.area.sum()
    first = (push - mu * G) * 0.1**2 / 2.0
    return [ours, shaken, first * push / (mu * G), run.taken]


def opened() -> list[float]:
    """Crack of the cantilevers and energy of the joint by both."""
    E, opening, duration, density = 3e3, 3.2, 0.012, DENSITY
    material = Material(sigma0=2.0, Gc=0.2, eta=0.9, mu=0.5, kc=3.0)
    law, width = Interface(material, Pattern.regular(0, 0.0)), 2.0
    x, z = np.linspace(0.0, 60.0, 61), np.linspace(-2.0, 2.0, 5)
    jointed = split(grid(x, [0.0, width], z, block=(z[:-1] >= 0.0).astype(int)))

    def held(m: Model) -> Integers:
        left, right = (m.x[:, 0] < 1e-6), (m.x[:, 0] > 60.0 - 1e-6)
        return np.unique(np.r_[m.dofs(left, 2), m.dofs(right, 0, 2), m.dofs(np.ones(m.n, bool), 1)])

    run = Explicit(jointed, law, E, density, held)
    m = run.m
    way = np.zeros((m.n, 3))
    left = m.x[:, 0] < 1e-6
    way[left, 2] = np.where(m.solid("block_1").reshape(-1, 3)[left, 2] > 0.0, 0.5, -0.5) * opening
    way = way.ravel()[run.fixed]
    steps = round(duration / run.dt)
    for k in range(steps):
        # a soft begin and end
        run.step(0.0, way / (steps * run.dt) * (1.0 - np.cos(2.0 * np.pi * (k + 0.5) / steps)), 300.0)
    points = run.elements.points
    damaged = sum(run.elements.area / 4.0 @ p.state[:, 0] for p in points) / width
    energy = run.elements.energies.sum()

    follow = Follow(m, State.virgin(m), lambda t: Conditions(run.fixed, t * way), 0.02, 0.05)
    for _ in follow.to(1.0):
        pass
    state = follow.state.joints[0]
    return [damaged, state[:, 0] @ m.area / width, energy, m.area @ state[:, 1:4].sum(axis=1), run.taken]


def main() -> None:
    """Print the numbers of the words, or of all."""
    words = words_of(__doc__)
    warnings.simplefilter("ignore")
    for name, numbers in {"block": slid, "cantilever": opened}.items():
        if not words or name in words:
            print(f"{name}:", *(f"{number:.6g}" for number in numbers()), flush=True)


if __name__ == "__main__":
    main()
