"""Tests of asperity.mesh."""
