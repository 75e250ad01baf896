"""Traction of the NumPy reference with the damage, friction bound and facets of another separation, the aim.

What is frozen makes the law a sum of quadratic, one-sided and Huber terms.  The traction is the gradient of
this energy, by an imaginary part of the separation (reference.py); no stress is written down here.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from . import plane, reference

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
    at_aim = reference.update(parameters, pattern, aim, state, s_old, dt, tangent=False).state
    alpha, _ = reference._histories(parameters, at_aim, len(weights))
    omega, _ = reference._wear_histories(at_aim, len(weights))
    _, slip = reference._histories(parameters, state, len(weights))
    straight, contact, facet = plane.kinematics(parameters, frame, aim + offset, omega)
    gradient = np.broadcast_to(frame, (*straight.shape, 3)) if facet is None else facet.gradient
    begin = reference._start(parameters, pattern, s_old, state)
    p, pull, rate = plane.pressure(parameters, contact), np.zeros_like(slip), 0.0
    if parameters.c > 0.0 and dt > 0.0:
        p, pull, rate = reference._viscous(parameters, begin, contact, dt)
    stiff, was_closed = parameters.Kt + rate, plane.closure(parameters, begin.contact)[0]
    # slip at which the friction reaches its bound
    most = parameters.mu * p / stiff

    def energy(s: Floats) -> Floats:
        """Energy (n,) at a complex separation."""
        bond = np.einsum("kab,nb->nka", frame, s + offset)
        touch = contact + np.einsum("nkab,nb->nka", gradient, s - aim)
        shear = ((touch[..., 1:] - slip - pull / stiff) ** 2).sum(-1)
        slides = (shear.real > most**2) | (parameters.mu == 0.0)
        size = np.sqrt(np.where(slides, shear, 1.0))
        rubbed = np.where(slides, most * size - 0.5 * most**2, 0.5 * shear)
        opened = np.where(bond[..., 0].real > 0.0, bond[..., 0], 0.0)
        bonded = 0.5 * parameters.Kn * opened**2 + plane.closing(parameters, bond)
        bonded = bonded + 0.5 * parameters.Kt * (bond[..., 1:] ** 2).sum(-1)
        pressed = plane.closing(parameters, touch)
        if rate > 0.0:
            # the pressure is that of a spring and a dashpot, or zero
            closing = plane.closure(parameters, touch)[0] - was_closed
            pushes = plane.pressure(parameters, touch) + parameters.c / dt * closing
            pressed = np.where(pushes.real > 0.0, pressed + 0.5 * parameters.c / dt * closing**2, 0.0)
            pressed = np.where(touch[..., 0].real <= 0.0, pressed, 0.0)
        damaged = pressed + stiff * rubbed
        return ((1.0 - alpha) * bonded + alpha * damaged) @ weights

    def traction(s: Floats) -> Floats:
        """Gradient (n, 3) of the energy."""
        step = plane.IMAGINARY * parameters.s0
        return np.stack([energy(s + 1j * step * axis).imag / step for axis in np.eye(3)], axis=-1)

    return traction
