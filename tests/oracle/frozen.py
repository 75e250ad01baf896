"""Traction of the NumPy reference with the damage, friction bound and facets of another separation, the aim.

What is frozen makes the law a sum of quadratic, one-sided and Huber terms.  The traction is the gradient of
this energy, by an imaginary part of the separation (reference.py); no stress is written down here.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from . import reference

Floats = NDArray[np.floating]


def law(
    parameters: reference.Parameters,
    pattern: reference.Pattern,
    aim: Floats,
    state: Floats,
    s_old: Floats,
    dt: float = 0.0,
) -> Callable[[Floats], Floats]:
    """Traction (n, 3) as a function of s (n, 3), with variables of aim (n, 3); the rest as in update."""
    normals, weights = pattern
    frame, offset = reference.frames(normals), state[:, 5:8]
    at_aim = reference.update(parameters, pattern, aim, state, s_old, dt).state
    alpha, _ = reference._histories(parameters, at_aim, len(weights))
    omega, _ = reference._wear_histories(at_aim, len(weights))
    _, slip = reference._histories(parameters, state, len(weights))
    straight, contact, facet = reference._kinematics(parameters, frame, aim + offset, omega)
    gradient = np.broadcast_to(frame, (*straight.shape, 3)) if facet is None else facet.gradient
    # slip at which the friction reaches its bound
    most = parameters.mu * reference._pressure(parameters, contact) / parameters.Kt

    def energy(s: Floats) -> Floats:
        """Energy (n,) at a complex separation."""
        bond = np.einsum("kab,nb->nka", frame, s + offset)
        touch = contact + np.einsum("nkab,nb->nka", gradient, s - aim)
        shear = ((touch[..., 1:] - slip) ** 2).sum(-1)
        slides = shear.real > most**2
        size = np.sqrt(np.where(slides, shear, 1.0))
        rubbed = np.where(slides, most * size - 0.5 * most**2, 0.5 * shear)
        opened = np.where(bond[..., 0].real > 0.0, bond[..., 0], 0.0)
        bonded = 0.5 * parameters.Kn * opened**2 + reference._closing(parameters, bond)
        bonded = bonded + 0.5 * parameters.Kt * (bond[..., 1:] ** 2).sum(-1)
        damaged = reference._closing(parameters, touch) + parameters.Kt * rubbed
        return ((1.0 - alpha) * bonded + alpha * damaged) @ weights

    def traction(s: Floats) -> Floats:
        """Gradient (n, 3) of the energy."""
        step = reference.IMAGINARY * parameters.s0
        return np.stack([energy(s + 1j * step * axis).imag / step for axis in np.eye(3)], axis=-1)

    return traction
