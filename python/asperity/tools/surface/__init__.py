"""Planes of a scanned surface, `asperity surface`."""

from .scan import Scan as Scan
from .scan_files import planes_from_scan as planes_from_scan
