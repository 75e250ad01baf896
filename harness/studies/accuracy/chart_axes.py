"""Axes, texts and target errors that the pictures and tables of the work-precision studies share."""

from __future__ import annotations

from functools import partial

from asperity.tables import markdown
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

AIMS = (1.0e-2, 1.0e-3, 1.0e-4)
"""Target errors of the tables."""


def log_axes(ax: Axes, x_label: str, y_label: str) -> None:
    """Set logarithmic axes with labels and a grid."""
    ax.set_xscale("log")
    ax.set_yscale("log")
    ax.xaxis.set_minor_formatter(NullFormatter())
    ax.set_xlabel(x_label)
    ax.set_ylabel(y_label)
    ax.grid(alpha=0.3, which="major")


def plain_labels(axis: Axis) -> None:
    """Set the labels 0.2, 0.5, 1, ... on an axis that spans little more than a decade."""
    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axis.set_major_formatter(FuncFormatter(lambda x, _: f"{x:g}"))
    axis.set_minor_formatter(NullFormatter())


def signed(value: float) -> str:
    """Text of a number, with a minus sign instead of a hyphen."""
    return f"{value:g}".replace("-", "−")


table = partial(markdown, numbers=True)
"""Table in Markdown with numbers aligned to the right."""
