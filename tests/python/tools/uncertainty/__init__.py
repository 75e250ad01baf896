"""Tests of asperity.tools.uncertainty."""
