"""C reference from the comments of the header."""

from __future__ import annotations

import re

ITEM = re.compile(
    r"/\*(?P<comment>(?:(?!\*/).)*)\*/\n(?P<code>(?:enum \w+ \{.*?\};|(?:\w[^;{#]*;\n?)+))",
    re.DOTALL | re.MULTILINE,
)
NAME = re.compile(r"(\w+)(?:\(| \{)")


def plain(comment: str) -> str:
    """Text of a comment that Markdown does not change: what it would read as markup is escaped."""
    parts = re.split(r"(`[^`\n]*`)", comment)
    return "".join(p if i % 2 else re.sub(r"([\[\]*<$])", r"\\\1", p) for i, p in enumerate(parts))


def sentences(comment: str) -> str:
    """Text of a comment without its stars; indented lines describe arguments and become a list."""
    lines = [re.sub(r"^ ?\* ?", "", line).rstrip() for line in comment.splitlines()]
    out, listed = [], False
    for line in lines:
        argument = re.match(r" {2,}(\w+) +(.*)", line)
        if argument:
            out += [""] * (not listed) + [f"- `{argument[1]}`: {argument[2]}"]
        else:
            out += [""] * listed + [line.strip()]
        listed = bool(argument)
    return plain("\n".join(out).strip())


def c_page(header: str) -> str:
    """Page of a header: what its first comment says, then each declaration with its comment."""
    head = re.match(r"/\*(.*?)\*/", header, re.DOTALL)
    assert head, "the header: expected a comment at its start"
    text = ["# C", "", sentences(head[1]), ""]
    for m in ITEM.finditer(header, head.end()):
        name = NAME.search(m["code"])
        assert name, m["code"]
        text += [f"## {name[1]}", "", sentences(m["comment"]), "", "```c", m["code"].strip(), "```", ""]
    return "\n".join(text)
