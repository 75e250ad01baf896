"""Pictures of structures with joints, from the files for ParaView that the hosts write."""

from .results import Results, read_results

__all__ = ["Results", "read_results"]
