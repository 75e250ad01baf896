"""Where methods fail: the catalogue of failures and the maps, `asperity stability`."""

from .catalogue import EDGES, find, shown, table
from .edges import Edge, Trial

__all__ = ["EDGES", "Edge", "Trial", "find", "shown", "table"]
