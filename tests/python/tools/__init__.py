"""Tests of asperity.tools."""
