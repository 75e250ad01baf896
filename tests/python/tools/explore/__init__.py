"""Tests of asperity.tools.explore."""
