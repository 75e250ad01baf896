"""Errors of the library as records: where they are, the value, and what was expected."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple


class Record(NamedTuple):
    """One error. What is empty or negative is not known.

    words: all of it in one line. file, line: of a case file. group: of the file, or the argument. step: of
    the load path, from 0. name: of the value. at: position of the bad value in a list, from 0. value: as
    given. text: what is wrong or what was expected.
    """

    words: str
    file: str = ""
    line: int = -1
    group: str = ""
    step: int = -1
    name: str = ""
    at: int = -1
    value: str = ""
    text: str = ""


class InputError(ValueError):
    """Bad input, with a record for each error (errors_json of asperity_json)."""

    def __init__(self, records: Sequence[Record]) -> None:
        """All errors of an input."""
        super().__init__("\n".join(record.words for record in records))
        self.records = tuple(records)

    def __reduce__(self) -> tuple[type[InputError], tuple[tuple[Record, ...]]]:
        """Arguments for pickle, which sends the exception between processes."""
        return type(self), (self.records,)


SLIP_NAMES = {
    (0, "t_N"): "sigma_N", (0, "increments"): "preload", (1, "slip"): "slips", (1, "k_N"): "stiffness",
}  # fmt: skip
"""Arguments of `Interface.confined_slip` by the number of the step of `steps.slip_path` and its entry."""


def slip_words(error: Record) -> str:
    """Words of an error for `Interface.confined_slip`; those of the second t_N, the same value, are empty."""
    if (error.step, error.name) == (1, "t_N"):
        return ""
    if error.step < 0 or not error.name:
        return error.text if error.step == 1 else error.words
    name = SLIP_NAMES.get((error.step, error.name), error.name)
    at = f"[{error.at}]" if error.at >= 0 else ""
    return f"{name}{at} = {error.value}: {error.text}"
