"""Catalogue of failure modes and maps of convergence of solution methods."""
