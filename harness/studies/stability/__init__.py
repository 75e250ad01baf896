"""Catalogue of failure modes and maps of convergence of solution methods."""

from .catalogue import MODES, find, shown, table
from .modes import FailureMode, Trial

__all__ = ["MODES", "FailureMode", "Trial", "find", "shown", "table"]
