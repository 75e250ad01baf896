"""Where a solver of a host may symmetrise the tangent of a joint: friction, slopes and pressure."""

from __future__ import annotations

import warnings

import numpy as np
from asperity import Interface, Material, ModelWarning, Pattern, Step
from asperity.contract import Floats
from asperity.tools.style import TWO, label_axes, new_figure, printed
from matplotlib.figure import Figure

FRICTION = np.linspace(0.05, 1.3, 26)
SLOPES = np.linspace(5.0, 50.0, 19)
PRESSURES = (0.1, 1.0, 10.0)
"""Coefficients of friction, slopes of the planes (degrees) and pressures (MPa) of the chart."""

SURROUNDINGS = 0.3
"""Stiffness of the surroundings over that of the bond."""

S_F, ROUNDING = 0.2, 1.0e-9
"""Separation at which the bond is broken, mm; imaginary parts that are rounding errors."""

LEVELS = np.array([0.0, 0.25, 0.5, 0.75, 1.0, 1e9])
"""Levels of the factor of the residual."""


DRAWN, SEED = 400, 1
"""Random joints, and the seed."""


def tangents(mu: float, theta: float, pressure: float, sides: int, *slips: Step) -> tuple[Interface, Floats]:
    """Joint, and its tangents along slips under a pressure."""
    material = Material(sigma0=3.0, Gc=0.3, eta=0.9, mu=mu, kc=10.0)
    joint = Interface(material, Pattern.regular(sides, theta))
    return joint, joint.rows((Step(t_N=-pressure, increments=10), *slips))[0].tangent


def factor(mu: float, theta: float, pressure: float) -> float:
    """Largest factor of the residual in an iteration with the symmetrised tangent, along a slip to 2 s_f."""
    slip = Step(slip=2.0 * S_F, increments=200)
    joint, tangent = tangents(mu, theta, pressure, 4, slip)
    D, around = tangent / joint.material.K, SURROUNDINGS * np.eye(3)
    symmetric = 0.5 * (D + D.transpose(0, 2, 1))
    iteration = np.eye(3) - np.linalg.solve(symmetric + around, D + around)
    return float(np.abs(np.linalg.eigvals(iteration)).max())


def chart() -> Floats:
    """Factor of the residual over pressure, friction and slope, (pressures, frictions, slopes)."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ModelWarning)
        return np.array([[[factor(mu, theta, p) for theta in SLOPES] for mu in FRICTION] for p in PRESSURES])


def fluttering() -> Floats:
    """Friction of the random joints whose tangent has complex eigenvalues in a slip and its reversal."""
    random, frictions = np.random.default_rng(SEED), []
    for _ in range(DRAWN):
        mu, theta, size = random.uniform([0.1, 5.0, -1.0], [1.3, 50.0, 1.0])
        sides, direction = int(random.integers(2, 9)), float(random.uniform(0.0, 360.0))
        slips = Step(slip=2.0 * S_F, direction=direction, increments=100), Step(slip=0.0, increments=100)
        joint, tangent = tangents(mu, theta, 10.0**size, sides, *slips)
        if joint.stability(tangent).flutter.max() > ROUNDING:
            frictions.append(mu)
    return np.array(frictions)


def draw(factors: Floats) -> Figure:
    """Factor of the residual over friction and slope, a panel for each pressure."""
    with printed():
        figure, axes = new_figure(TWO, 0.36 * TWO, ncols=len(PRESSURES), sharey=True)
        for ax, factor, pressure in zip(axes.flat, factors, PRESSURES, strict=True):
            ax.contourf(
                SLOPES,
                FRICTION,
                factor,
                LEVELS,
                colors=["#ffffff", "#dde8f2", "#b5cde4", "#7aa6cf", "#f3c9a5"],
            )
            ax.contour(SLOPES, FRICTION, factor, [1.0], colors="k", linewidths=1.2)
            locks = 1.0 / np.tan(np.radians(SLOPES))
            ax.plot(SLOPES[locks < FRICTION[-1]], locks[locks < FRICTION[-1]], "k:", linewidth=1.0)
            ax.set_title(f"{pressure:g} MPa")
            label_axes(ax, r"$\theta$ [degrees]", r"$\mu$" if ax is axes.flat[0] else "")
    return figure


def sentences(factors: Floats) -> str:
    """What chart and random joints say, in numbers."""
    good = (factors < 1.0).all(axis=2)
    most = [
        f"{FRICTION[np.argmin(row) - 1]:.2g} at {p:g} MPa" for row, p in zip(good, PRESSURES, strict=True)
    ]
    mu = fluttering()
    return (
        f"It converges with every slope up to mu = {', '.join(most)}. Of {DRAWN} random joints (2 to 8 "
        "planes of 5 to 50°, mu 0.1 to 1.3, slip and reversal in any direction under 0.1 to 10 MPa; "
        f"seed {SEED}) {len(mu)} "
        f"have a tangent with complex eigenvalues, all with mu >= {mu.min():.2f}: these can flutter."
    )
