"""Tests of asperity.tools.selection."""
