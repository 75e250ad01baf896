"""Tables in Markdown, and pages with text between markers."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence


def markdown(head: Sequence[str], rows: Iterable[Sequence[str]], numbers: bool = False) -> str:
    """Table in Markdown; with `numbers` the columns after the first are aligned to the right."""
    lines = [head, ["---", *["--:" if numbers else "---"] * (len(head) - 1)], *rows]
    return "\n".join("| " + " | ".join(cell.replace("|", r"\|") for cell in line) + " |" for line in lines)


def fill(text: str, contents: Mapping[str, str]) -> str:
    """Put contents between the markers <!-- name --> ... <!-- /name --> of a text."""
    for name, content in contents.items():
        begin, end = f"<!-- {name} -->", f"<!-- /{name} -->"
        block = f"{begin}\n{content}\n{end}".replace("\\", r"\\")  # escaped for re.sub
        text = re.sub(f"{re.escape(begin)}.*?{re.escape(end)}", block, text, flags=re.DOTALL)
    return text
