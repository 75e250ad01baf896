"""Constants of the ribbed bar in its cover, for anchored.py and its page; mm, MPa."""

from __future__ import annotations

DIAMETER, COVER, EMBEDDED = 19.05, 76.2, 95.25
"""Diameters of the bar and of the cylinder of concrete round it, and the embedded length."""

E_STEEL, E_CONCRETE, NU = 2e5, 3e4, 0.2
"""Moduli of elasticity of steel and of concrete; Poisson's ratio of both."""

TENSION = 3.0
"""Tensile strength of the concrete."""

SOFT_BOND = 100.0
"""Stiffness of a linear bond, MPa/mm."""
