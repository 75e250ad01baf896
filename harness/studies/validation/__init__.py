"""Comparisons with measurements: `python -m harness.studies.validation.NAME`, pages in docs/validation."""
