"""Tests of asperity.export."""
