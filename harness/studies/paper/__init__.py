"""The figures and tables of the paper, recomputed: `python -m harness.studies.paper`."""
