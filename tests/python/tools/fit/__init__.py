"""Tests of asperity.tools.fit."""
