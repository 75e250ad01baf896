"""Constants of the walls whose toe crushes, for toe.py and its page; N, mm, MPa."""

from __future__ import annotations

MU = 0.42
"""Friction of the joint, of calcium-silicate masonry."""

CSS = 9.0
"""Weight of the shear in the compressive strength, of Lourenco (1996)."""

YIELDING, SOFTENING = 1500.0, (30.0, 15.0)
"""Energies of crushing, N/mm: of a toe that hardly softens, and of masonry."""
