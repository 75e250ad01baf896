"""The material block of DIANA."""

from __future__ import annotations

from asperity.cards.blocks import Block, numeral, remarks, text_of

NUMBERS = 3
"""Numbers on a line of 80 characters."""


def block_of(block: Block) -> str:
    """Entries of a material of interface elements with USRIFC, and their linear stiffness."""
    shear, opening = block.stiffness
    run = "a user-supplied subroutine library: libasperity_diana with libasperity, or usrifc_ linked in"
    rows = (f"USRSTA {i}: {text}" for i, text in enumerate(block.statev, 1))
    return text_of(
        *remarks(block, run, *rows, mark=": "),
        "'MATERI'",
        f"   1 NAME   {block.name}",
        f"     DSTIF  {numeral(opening)} {numeral(shear)}",
        "     USRIFC ASPERI",
        *_values("USRVAL", block.props.tolist()),
        *_values("USRSTA", [0.0] * len(block.statev)),
        "     USRIND 0",
    )


def _values(name: str, values: list[float]) -> list[str]:
    """Lines of an entry with many values."""
    rows = [values[i : i + NUMBERS] for i in range(0, len(values), NUMBERS)]
    heads = [f"     {name}", *["           "] * (len(rows) - 1)]
    return [f"{head} {' '.join(map(numeral, row))}" for head, row in zip(heads, rows, strict=True)]
