"""Material, tolerances and closed forms that the tests of the NumPy reference share."""

from __future__ import annotations

import numpy as np

from tests.oracle.reference import (
    Parameters,
    SlipHistory,
    confined_slip,
    listed_pattern,
    regular_pattern,
)

TABLE_2 = Parameters(sigma0=3.0, Gc=0.3, eta=0.9, mu=0.5)
FRICTIONLESS = Parameters(sigma0=3.0, Gc=0.3, eta=0.9, mu=0.0)
THETA = 30.0
FLAT = regular_pattern(0, 0.0)
RT = regular_pattern(2, THETA)

ROUNDING = 1.0e-12
"""Relative tolerance of a few operations in double precision, and that of the equilibrium solver."""


def along(history: SlipHistory, direction_deg: float | np.ndarray) -> np.ndarray:
    """Traction along the slip, tau_L of Section 4.2."""
    angle = np.radians(direction_deg)
    return history.traction[..., 1] * np.cos(angle) + history.traction[..., 2] * np.sin(angle)


def measured_energy(pattern, parameters, direction_deg, step, end=0.24):
    """G_T of (40) at sigma_N = 0 by the trapezoid rule over all points."""
    slips = step * np.arange(round(end / step) + 1)
    history = confined_slip(parameters, pattern, direction_deg, slips, 0.0)
    assert not history.events
    assert np.abs(history.traction[-1]).max() < 1.0e-9  # fully damaged: the integral is complete
    return np.trapezoid(along(history, direction_deg), slips, axis=0)


def facing_plane(theta_deg: float):
    """Pattern of a single plane that rises against slip along +Tx."""
    theta = np.radians(theta_deg)
    return listed_pattern([[np.cos(theta), -np.sin(theta), 0.0]], [1.0])


def climbing_ratio(theta_deg: float, mu: float, phi_deg: float = 0.0) -> float:
    """|tau|/|sigma_N| of a Coulomb block that slides up a plane at the angle phi from its steepest line."""
    theta, phi = np.radians(theta_deg), np.radians(phi_deg)
    w = np.sqrt(1.0 + np.tan(theta) ** 2 * np.cos(phi) ** 2)
    return (np.sin(theta) * np.cos(phi) + mu / w) / (np.cos(theta) - mu * np.tan(theta) * np.cos(phi) / w)
