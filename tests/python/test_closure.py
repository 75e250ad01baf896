"""Planes cracked from the start and hyperbolic closure: the library against the independent reference."""

from __future__ import annotations

import numpy as np
import pytest
from asperity import Interface, Material, Pattern

from tests.oracle import reference

SEED = 2025
DT = 0.1

OPTIONS = {
    "damage0": {"damage0": 0.4},
    "without bond": {"damage0": 1.0, "kc": 10.0},
    "closure": {"closure": 0.06},
    "closure and height": {"closure": 0.06, "height": 0.3},
    "closure and wear": {"closure": 0.06, "height": 0.3, "W0": 0.5},
    "closure and guard": {"closure": 0.06, "guard": True},
    "closure and viscosity": {"closure": 0.06, "tau_v": 0.3, "damage0": 0.2},
    "almost closed": {"closure": 0.02, "damage0": 0.5},
}


@pytest.mark.parametrize("option", OPTIONS)
def test_random_updates(option: str) -> None:
    """Traction, state and tangent agree for random histories of 40 points; deep closure occurs."""
    material = Material(3.0, 0.3, 0.9, 0.5, **OPTIONS[option])
    parameters = reference.Parameters(3.0, 0.3, 0.9, 0.5, **OPTIONS[option])
    rng = np.random.default_rng(SEED)
    far = 0
    for sides in (0, 2, 5):
        interface = Interface(material, Pattern.regular(sides, 30.0, 0.3, 20.0))
        planes = reference.regular_pattern(sides, 30.0, 0.3, 20.0)
        steps = rng.standard_normal((40, 40, 3)) * material.s_0
        S = np.cumsum(steps, axis=0)
        s_old, state = np.zeros((40, 3)), np.zeros((40, interface.nstatv))
        for s in S:
            ours = interface.update(s, state, s_old, dt=DT)
            theirs = reference.update(parameters, planes, s, state, s_old, DT)
            size = np.abs(theirs.traction).max(axis=1) + parameters.Kn * np.linalg.norm(s, axis=1)
            stiff = np.abs(theirs.tangent).max(axis=(1, 2)) + parameters.Kn
            energy = size * (np.linalg.norm(s, axis=1) + np.linalg.norm(s_old, axis=1))
            assert np.all(np.abs(ours.traction - theirs.traction).max(axis=1) <= 1e-11 * size)
            scale = (1.0 + energy + np.abs(theirs.state).max(axis=1))[:, None]
            assert np.all(np.abs(ours.state - theirs.state) <= 1e-11 * scale)
            off = np.abs(ours.tangent - theirs.tangent).max(axis=(1, 2)) > 1e-6 * stiff
            assert off.mean() <= 0.05  # a trial slip of almost zero
            far += int((stiff > 20.0 * parameters.Kn * parameters.kc).sum())
            state, s_old = ours.state, s
    if "closure" in OPTIONS[option]:
        assert far > 0


def test_bad_values() -> None:
    """Both are named at once, with what was expected; a reserved constant has no name in Python."""
    with pytest.raises(ValueError) as error:
        Material(3.0, 0.3, 0.9, 0.5, damage0=1.5, closure=-1.0)
    assert "damage0 = 1.5: expected 0 to 1" in str(error.value)
    assert "closure = -1: expected >= 0" in str(error.value)
    with pytest.raises(TypeError):
        Material(3.0, 0.3, 0.9, 0.5, slot22=0.0)
