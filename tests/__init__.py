"""Tests: Fortran suites, Python tests, and the independent versions of the law that these compare with."""
