"""Tests of asperity.tools.surface."""
