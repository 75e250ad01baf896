"""Planes of a scanned surface, `asperity surface`."""
