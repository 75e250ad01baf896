"""Tests of asperity.tools.barton."""
