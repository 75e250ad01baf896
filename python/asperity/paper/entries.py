"""The figures and tables of the paper: case files, and the function that makes each."""

from __future__ import annotations

from .direction_figures import figure_7, figure_8, figure_9, figure_10, figure_11, figure_12, figure_13
from .isotropy_figures import figure_15, figure_16, table_5
from .outcome import Entry
from .pattern_figures import figure_1, figure_3, figure_6, figure_14
from .planar_figures import figure_2, figure_4a, figure_4b, figure_5a, figure_5b

ENTRIES = (
    Entry("1", (), figure_1),
    Entry("2", ("figure02",), figure_2),
    Entry("3", (), figure_3),
    Entry("4a", ("figure04a",), figure_4a),
    Entry("4b", ("figure04b",), figure_4b),
    Entry("5a", ("figure05a",), figure_5a),
    Entry("5b", ("figure05b",), figure_5b),
    Entry("6", (), figure_6),
    Entry("7", ("figure07a_08a_10a", "figure07b_08b_10a"), figure_7),
    Entry("8", ("figure07a_08a_10a", "figure07b_08b_10a"), figure_8),
    Entry("9", ("figure09a_10b", "figure09b_10b"), figure_9),
    Entry("10", ("figure07a_08a_10a", "figure07b_08b_10a", "figure09a_10b", "figure09b_10b"), figure_10),
    Entry("11", ("figure11",), figure_11),
    Entry("12", ("figure12",), figure_12),
    Entry("13a", ("figure13a_00", "figure13a_45"), figure_13),
    Entry("13b", ("figure13b_00", "figure13b_45"), figure_13),
    Entry("14", (), figure_14),
    Entry("15", ("figure15a", "figure15b", "figure15c"), figure_15),
    Entry("16", ("figure16a", "figure16b"), figure_16),
    Entry("Table 5", (), table_5),
)
"""Figures and tables in the order of the paper."""
