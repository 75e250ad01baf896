"""Words of a command line, by which a program prints some of its numbers alone."""

from __future__ import annotations

import argparse


def words_of(description: str | None, admissible: str | None = None) -> list[str]:
    """Return the words of the command line, an empty list where it has none.

    description: of the program; admissible: the words that it knows, for its help.
    """
    parser = argparse.ArgumentParser(
        description=description, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("words", nargs="*", help=admissible)
    words: list[str] = parser.parse_args().words
    return words
