"""The bilinear bond of docs/how-to/cohesive-friction.md: QUADS, linear softening, power law."""

from __future__ import annotations

import numpy as np
import pytest
from asperity import Interface, Material, Pattern

K_NN, T_N, G_N, T_S, G_S = 150.0, 3.0, 0.3, 4.0, 0.8
"""Normal stiffness, strengths and energies of the two modes (MPa/mm, MPa, N/mm)."""


@pytest.mark.parametrize("degrees", [0.0, 30.0, 45.0, 60.0, 90.0])
def test_bilinear_bond_of_abaqus(degrees: float) -> None:
    """With the constants of the page the tractions are those of the formulas of Abaqus' manuals."""
    eta = 1.0 - T_N**2 / (2.0 * K_NN * G_N)
    k_ss = T_S**2 / (2.0 * G_S * (1.0 - eta))
    bond = Material(sigma0=T_N, Gc=G_N, eta=eta, mu=0.5, kc=20.0, sigma02=T_S, Gc2=G_S)
    joint = Interface(bond, Pattern.regular(0, 0.0))
    normal, shear = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    path = np.linspace(0.0, 0.6, 601)[:, None] * [normal, shear, 0.0]
    length = np.linalg.norm(path, axis=1)
    onset = 1.0 / np.hypot(normal * K_NN / T_N, shear * k_ss / T_S)
    stiffness = np.array([K_NN * normal**2, k_ss * shear**2])
    energy = stiffness.sum() / (stiffness @ [1.0 / G_N, 1.0 / G_S])
    end = 2.0 * energy / (onset * stiffness.sum())
    damage = np.clip(end * (length - onset) / (np.maximum(length, onset) * (end - onset)), 0.0, 1.0)
    expected = (1.0 - damage)[:, None] * path * [K_NN, k_ss, k_ss]
    assert np.abs(expected).max() > 2.0
    # Rounding of tractions of a few MPa.
    assert joint.replay(path).traction == pytest.approx(expected, abs=1.0e-12)
