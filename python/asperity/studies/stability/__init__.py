"""Catalogue of failure modes and maps of convergence, `asperity stability`."""

from .catalogue import EDGES, find, shown, table
from .edges import Edge, Trial

__all__ = ["EDGES", "Edge", "Trial", "find", "shown", "table"]
