"""Connection elements of OpenRadioss, /PROP/TYPE43: axes, rates and forces as its public sources have them.

The moments of the forces about the middle of an element are not balanced here.
"""

from __future__ import annotations

import numpy as np
from asperity.contract import Floats

from harness.hosts.radioss.calls import DENSITY, Points

CORNERS = np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])
SHARES = np.array([(1 + p * CORNERS / np.sqrt(3.0)).prod(axis=1) / 4 for p in CORNERS])
"""Shares of the four corners in the separation of each of the four points of an element."""


def axes_of(x: Floats) -> tuple[Floats, Floats]:
    """Axes (n, 3, 3) ZX, YZ, ZZ and areas (n,) of elements with nodes at x (n, 8, 3)."""
    middle = 0.5 * (x[:, :4] + x[:, 4:])
    r, s = (np.einsum("c,ncd->nd", CORNERS[:, k], middle) for k in (0, 1))
    normal = np.cross(r, s)
    area = 0.25 * np.linalg.norm(normal, axis=1)
    normal /= 4.0 * area[:, None]
    first = r / np.linalg.norm(r, axis=1)[:, None]
    first += np.cross(s, normal) / np.linalg.norm(s, axis=1)[:, None]
    first /= np.linalg.norm(first, axis=1)[:, None]
    return np.stack([first, np.cross(normal, first), normal], axis=1), area


class Elements:
    """Connection elements of one law, whose axes turn with their nodes."""

    def __init__(self, props: Floats, x: Floats) -> None:
        """Begin with virgin elements at x (n, 8, 3); stiffness (n,) is that of a node for the time step."""
        self.axes, self.area = axes_of(x)
        self.points, zero = [Points(props, len(x)) for _ in range(4)], np.zeros((len(x), 3))
        for p in self.points:
            p.step(zero, zero, 0.0)
        self.stiffness = self.points[3].soundsp ** 2 * DENSITY * self.area / 4.0
        self.traction = np.zeros((len(x), 4, 3))

    def step(self, x: Floats, v: Floats, dt: float) -> Floats:
        """Forces (n, 8, 3) on nodes that are at x now and moved there with the velocities v."""
        old, (self.axes, _) = self.axes, axes_of(x)
        m = np.einsum("nid,njd->nij", self.axes, old)
        skew = 0.5 * np.stack([m[:, 1, 2] - m[:, 2, 1], m[:, 2, 0] - m[:, 0, 2], m[:, 0, 1] - m[:, 1, 0]], 1)
        angle = np.arccos(np.clip(0.5 * (np.trace(m, axis1=1, axis2=2) - 1.0), -1.0, 1.0))
        turn = skew / np.sinc(angle / np.pi)[:, None]
        place, rate = (np.einsum("nid,ncd->nci", self.axes, a - a.mean(1)[:, None]) for a in (x, v))
        rate -= np.cross(turn[:, None], place) / dt
        jump = dt * np.einsum("pc,nci->npi", SHARES, rate[:, 4:] - rate[:, :4])[..., [2, 0, 1]]
        steps = [p.step(np.zeros_like(jump[:, k]), jump[:, k], dt) for k, p in enumerate(self.points)]
        self.traction = np.stack(steps, axis=1)
        local = np.einsum("pc,npi,n->nci", SHARES, self.traction[..., [1, 2, 0]], self.area / 4.0)
        force = np.einsum("nci,nid->ncd", local, self.axes)
        return np.concatenate([force, -force], axis=1)

    @property
    def energies(self) -> Floats:
        """Stored energy, rupture and friction of all elements by the state of the law."""
        return sum(self.area / 4.0 @ p.state[:, 1:4] for p in self.points)
