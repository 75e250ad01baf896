"""Joints in a mesh of one's own: `split` doubles the nodes along faces, `write` gives the mesh to a host."""

from .hosts import write
from .jointed import Joint, Jointed
from .split import split

__all__ = ["Joint", "Jointed", "split", "write"]
