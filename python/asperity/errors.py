"""Errors of the library as records: where they are, the value, and what was expected."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

_BETWEEN = "\x1f"


class Record(NamedTuple):
    """One error. What is empty or negative is not known.

    words: all of it in one line. file, line: of a case file. group: of the file, or the argument. step: of
    the load path, from 0. name: of the value. at: position of the bad value in a list, from 0. value: as
    given. text: what is wrong or what was expected.
    """

    words: str
    file: str
    line: int
    group: str
    step: int
    name: str
    at: int
    value: str
    text: str


class InputError(ValueError):
    """Bad input, with a record for each error."""

    def __init__(self, records: Sequence[Record]) -> None:
        """All errors of an input."""
        super().__init__("\n".join(record.words for record in records))
        self.records = tuple(records)

    def __reduce__(self) -> tuple[type[InputError], tuple[tuple[Record, ...]]]:
        """Arguments for pickle, which sends the exception between processes."""
        return type(self), (self.records,)


def input_error(message: bytes) -> InputError:
    """Exception of the errors that the library hands out (`put_records` of asperity_errors)."""
    records = []
    for line in message.decode("utf-8", "replace").rstrip().split("\n"):
        words, file, number, group, step, name, at, value, text = (line.split(_BETWEEN) + [""] * 8)[:9]
        records.append(
            Record(words, file, int(number or -1), group, int(step or -1), name, int(at or -1), value, text)
        )
    return InputError(records)
