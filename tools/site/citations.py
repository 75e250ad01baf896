"""A page in the form of JOSS: its title, and its citations (`@key`, `[@key; @key]`) as links."""

from __future__ import annotations

import re

ENTRY = re.compile(r"^@\w+\{(\w+),\n(.*?)^\}$", re.MULTILINE | re.DOTALL)
FIELD = re.compile(r"^  (\w+) = \{(.*?)\},?$", re.MULTILINE)


def entries(bibliography: str) -> dict[str, dict[str, str]]:
    """Entries of a bibliography: fields by their names, braces and commands of TeX removed."""
    found = {}
    for key, body in ENTRY.findall(bibliography):
        fields = {name: re.sub(r"[{}]", "", value).replace("--", "–") for name, value in FIELD.findall(body)}
        fields["author"] = fields["author"].replace(" and ", "; ")
        found[key] = fields
    return found


def short(fields: dict[str, str]) -> str:
    """Names as they are cited: two at most."""
    names = [author.split(",")[0] for author in fields["author"].split("; ")]
    return " and ".join(names) if len(names) < 3 else f"{names[0]} et al."


def reference(key: str, fields: dict[str, str]) -> str:
    """Line of the list of references."""
    where = [f"*{fields['journal']}*"] if "journal" in fields else []
    where += [f"{fields['volume']}, {fields['pages']}"] if "volume" in fields else []
    where += [f"doi {fields['doi']}"] if "doi" in fields else []
    text = f"{fields['author']} ({fields['year']}). {fields['title']}. {' '.join(where)}".strip()
    return f'- <span id="{key}"></span>{text}'


def with_references(text: str, bibliography: str) -> str:
    """Page with its title, citations as links, and its references at the end."""
    known = entries(bibliography)
    title = re.findall(r'^title: "(.*)"$', text, re.MULTILINE)[0]
    body = text.split("---\n", 2)[2]
    text = f"# {title}\n" + re.sub(r"^#", "##", body, flags=re.MULTILINE)

    def group(m: re.Match[str]) -> str:
        keys = re.findall(r"@(\w+)", m[0])
        links = (f"[{short(known[key])}, {known[key]['year']}](#{key})" for key in keys)
        return f"({'; '.join(links)})"

    def single(m: re.Match[str]) -> str:
        fields = known[m[1]]
        return f"[{short(fields)} ({fields['year']})](#{m[1]})"

    text = re.sub(r"\[@\w+(?:; @\w+)*\]", group, text)
    text = re.sub(r"(?<!\w)@(\w+)", single, text)
    return text.rstrip() + "\n\n" + "\n".join(reference(key, known[key]) for key in sorted(known)) + "\n"
