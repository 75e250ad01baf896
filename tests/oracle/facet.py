"""Curved facet of an inclined plane in the NumPy reference: finite asperity height and wear.

This is an extension of the paper, whose planes have no finite height.  An inclined plane of slope
T = tan(theta) is the tangent at the foot of an unworn facet.  The profile is z = rho z0(u).  The factor
rho = 1 - omega is the share of the profile that is not worn; omega is 0 for a virgin facet.  The unworn
profile is z0 = H (1 - exp(-u T/H)) for u > 0 and z0 = u T for u <= 0; if H is not finite, z0 = u T for
every u.  The separation of the facet is taken at the point of the profile at u, along the normal there and
along the arc.  Components are (N, Tx, Ty).  Separations and omega may be complex (reference.py).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from types import EllipsisType

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.floating]
Some = NDArray[np.bool_] | EllipsisType
"""Mask of facets (..., k), or all of them."""


@dataclass(frozen=True)
class Facet:
    """Kinematics of the facets of a pattern at a separation, for every plane (..., k).

    local: gap g, climbed arc s_t and s_h (..., k, 3), length.
    gradient: G, derivatives of these (rows) with respect to the separation (columns), (..., k, 3, 3).
    height: of the profile at the point of contact, (..., k), length.
    by_omega: derivatives of (g, s_t, s_h) with respect to omega at a constant separation (..., k, 3), length.
    """

    local: Floats
    gradient: Floats
    height: Floats
    by_omega: Floats


def gaps(frame: Floats, s: Floats, height: float) -> Callable[[Floats, Some], Floats]:
    """Gap g (..., k) of the facets at the separation s (..., 3), as a function of their worn share.

    The function takes the share of some facets, and which these are.
    """
    axes, T = uphill_axes(frame)
    w, u, _ = np.moveaxis(np.einsum("kab,...b->...ka", axes, s), -1, 0)
    z0, dz0, _ = profile(u, T, height)

    def gap(omega: Floats, some: Some) -> Floats:
        rho = 1.0 - omega
        return (w[some] - rho * z0[some]) * (1.0 / np.sqrt(1.0 + (rho * dz0[some]) ** 2))

    return gap


def facets(frame: Floats, s: Floats, height: float, omega: Floats) -> Facet:
    """Facets of the planes with the frames (k, 3, 3) at the separation s (..., 3).

    height is H (a length); 0 stands for a profile of infinite height.  omega is the worn share (..., k).
    """
    axes, T = uphill_axes(frame)
    w, u, v = np.moveaxis(np.einsum("kab,...b->...ka", axes, s), -1, 0)
    rho = 1.0 - omega
    z0, dz0, d2z0 = profile(u, T, height)
    z, dz, d2z = rho * z0, rho * dz0, rho * d2z0

    # tan(phi) = z'; c = cos(phi), q = sin(phi); derivative of phi with respect to u
    c = 1.0 / np.sqrt(1.0 + dz**2)
    q = dz * c
    dphi = d2z * c**2

    g = (w - z) * c
    s_t = arc_length(u, T, height, rho) + (w - z) * q
    f = 1.0 + (w - z) * dphi
    zero, unit = np.zeros_like(u), np.ones_like(u)
    # with respect to (w, u, v)
    gradient = _matrix([[c, -q * f, zero], [q, c * f, zero], [zero, zero, unit]])

    # with dz/domega = -z0, dphi/domega = -z0' c^2
    g_omega = z0 * c + (w - z) * q * dz0 * c**2
    s_t_omega = -arc_length_by_rho(u, T, height, rho) + z0 * q - (w - z) * c * dz0 * c**2
    return Facet(
        np.stack([g, s_t, v], axis=-1),
        gradient @ axes,
        z,
        np.stack([g_omega, s_t_omega, zero], axis=-1),
    )


def uphill_axes(frame: Floats) -> tuple[Floats, Floats]:
    """Return the rows N, e, h (k, 3, 3) and the slope T = tan(theta) (k,) of planes with the rows n, t, h.

    The unit vector e lies in the average surface and points uphill, along t without its component along N.
    """
    sine, cosine = frame[:, 1, 0], frame[:, 0, 0]
    e = frame[:, 1] * [0.0, 1.0, 1.0]
    e = e / np.linalg.norm(e, axis=-1, keepdims=True)
    N = np.zeros_like(e)
    N[:, 0] = 1.0
    return np.stack([N, e, frame[:, 2]], axis=1), sine / cosine


def profile(u: Floats, T: Floats, height: float) -> tuple[Floats, Floats, Floats]:
    """Return z0 of an unworn facet and its first two derivatives with respect to u, each (..., k)."""
    zero = np.zeros_like(u)
    if height == 0.0:
        return u * T, T + zero, zero
    climbs = u.real > 0.0
    rate = T / height
    decay = np.exp(-np.where(climbs, u, 0.0) * rate)
    return (
        np.where(climbs, -height * np.expm1(-u * np.where(climbs, rate, 0.0)), u * T),
        T * decay,
        np.where(climbs, -rate * T * decay, 0.0),
    )


def arc_length(u: Floats, T: Floats, height: float, rho: Floats) -> Floats:
    """Return the arc length A, the integral of sqrt(1 + z'^2) from 0 to u.

    For u <= 0 or infinite height A is u sqrt(1 + rho^2 T^2).  For u > 0 it is (H/T) (F(rho T) - F(z')) with
    F(x) = sqrt(1 + x^2) - asinh(1/x).  Let m = u T/H and r = sqrt(1 + z'^2), r0 at 0 and r1 at u.  With
    asinh(1/x) = log((1 + r)/x) this becomes (H/T) (m + r0 - r1 - log((1 + r0)/(1 + r1))), and
    r0 - r1 = (rho T)^2 (1 - exp(-2 m))/(r0 + r1) has no cancellation.
    """
    r0 = np.sqrt(1.0 + (rho * T) ** 2)
    if height == 0.0:
        return u * r0
    foot = rho * T  # slope at u = 0
    r1, rise = _rise(u, T, height, rho)
    turn = np.log1p(foot * rise / (1.0 + r1)) / np.where(foot.real > 0.0, foot, 1.0)
    return np.where(u.real > 0.0, u + height * rho * (rise - turn), u * r0)


def arc_length_by_rho(u: Floats, T: Floats, height: float, rho: Floats) -> Floats:
    """Return the derivative of A with respect to rho at a constant u, a length.

    It is u rho T^2/sqrt(1 + rho^2 T^2) for u <= 0 or infinite height, and (H/(T rho)) (r0 - r1) for u > 0.
    """
    straight = u * rho * T**2 / np.sqrt(1.0 + (rho * T) ** 2)
    if height == 0.0:
        return straight
    return np.where(u.real > 0.0, height * _rise(u, T, height, rho)[1], straight)


def _rise(u: Floats, T: Floats, height: float, rho: Floats) -> tuple[Floats, Floats]:
    """Return r1 = sqrt(1 + z'(u)^2) and (r0 - r1)/(rho T) with r0 = sqrt(1 + (rho T)^2), for u > 0."""
    m = np.where(u.real > 0.0, u, 0.0) * T / height
    r0, r1 = np.sqrt(1.0 + (rho * T) ** 2), np.sqrt(1.0 + (rho * T * np.exp(-m)) ** 2)
    return r1, -rho * T * np.expm1(-2.0 * m) / (r0 + r1)


def _matrix(rows: list[list[Floats]]) -> Floats:
    """Return the matrix (..., 3, 3) with the fields (...) as its entries."""
    out = np.empty((*rows[0][0].shape, 3, 3), rows[0][1].dtype)
    for i, row in enumerate(rows):
        for j, entry in enumerate(row):
            out[..., i, j] = entry
    return out
