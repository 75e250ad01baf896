"""What all Python tests have in common: their order, and the threads of linear algebra."""

from __future__ import annotations

import os

import pytest

# the workers of pytest share the cores already; numpy reads this when it is imported
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """The slow tests come first, so that no worker is left alone with one at the end."""
    items.sort(key=lambda item: item.get_closest_marker("slow") is None)
