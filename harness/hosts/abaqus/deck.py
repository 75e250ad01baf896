"""Reader of input files for Abaqus: keywords, options, data lines and their order.

It knows the keywords that the decks of `asperity export abaqus` use, and no others.
"""

from __future__ import annotations

from dataclasses import dataclass, field


class DeckError(ValueError):
    """What is wrong with a deck, with the number of the line."""


@dataclass
class Keyword:
    """One keyword line with its data lines."""

    name: str
    line: int
    options: dict[str, str]
    data: list[list[str]] = field(default_factory=list)

    def numbers(self) -> list[float]:
        """All values of the data lines as numbers; empty fields are left out."""
        return [self.number(text) for row in self.data for text in row if text]

    def number(self, text: str) -> float:
        """A number of Abaqus, whose exponent may be D."""
        try:
            return float(text.lower().replace("d", "e"))
        except ValueError:
            raise self.error(f"{text!r}: expected a number") from None

    def integer(self, text: str) -> int:
        """A whole number."""
        if not text.isdigit():
            raise self.error(f"{text!r}: expected a whole number")
        return int(text)

    def error(self, text: str) -> DeckError:
        """Error at this keyword."""
        return DeckError(f"line {self.line}: *{self.name}: {text}")


@dataclass(frozen=True)
class Rule:
    """Options of a keyword (star: required; bars if one has a blank), place, least and most data lines."""

    options: str
    place: str
    lines: tuple[int, int]


MANY = 10**9
RULES = {
    "heading": Rule("", "model", (1, MANY)),
    "node": Rule("", "model", (1, MANY)),
    "nset": Rule("nset*", "model", (1, MANY)),
    "elset": Rule("elset*", "model", (1, MANY)),
    "element": Rule("type* elset*", "model", (1, MANY)),
    "material": Rule("name*", "model", (0, 0)),
    "elastic": Rule("", "material", (1, 1)),
    "density": Rule("", "material", (1, 1)),
    "user material": Rule("constants* unsymm", "material", (1, MANY)),
    "depvar": Rule("", "material", (1, MANY)),
    "cohesive section": Rule("elset* material* response* thickness*", "model", (1, 1)),
    "solid section": Rule("elset* material*", "model", (0, 1)),
    "initial conditions": Rule("type*", "model", (1, MANY)),
    "equation": Rule("", "model", (2, 2)),
    "amplitude": Rule("name* definition", "model", (1, MANY)),
    "boundary": Rule("amplitude", "both", (1, MANY)),
    "step": Rule("name* nlgeom unsymm inc", "step", (0, 0)),
    "static": Rule("direct", "step", (1, 1)),
    "dynamic": Rule("explicit*", "step", (1, 1)),
    "controls": Rule("parameters* field", "step", (1, 2)),
    "cload": Rule("amplitude", "step", (1, MANY)),
    "dload": Rule("amplitude", "step", (1, MANY)),
    "output": Rule("field|history|time interval", "step", (0, 0)),
    "node output": Rule("nset", "step", (1, 1)),
    "element output": Rule("elset", "step", (1, 1)),
    "node print": Rule("nset frequency totals", "step", (1, 1)),
    "el print": Rule("elset frequency", "step", (1, 1)),
    "end step": Rule("", "step", (0, 0)),
}
LONGEST_LINE = 256


def read(text: str) -> list[Keyword]:
    """Keywords of a deck in their order; raises DeckError for the first one that Abaqus would not read."""
    found: list[Keyword] = []
    in_step = in_material = False
    for number, line in enumerate(text.splitlines(), 1):
        if len(line) > LONGEST_LINE:
            raise DeckError(f"line {number}: {len(line)} characters: expected at most {LONGEST_LINE}")
        if not line.strip():
            raise DeckError(f"line {number}: empty: expected data or a keyword")
        if line.startswith("**"):
            continue
        if not line.startswith("*"):
            if not found:
                raise DeckError(f"line {number}: data before the first keyword")
            row = [part.strip() for part in line.split(",")]
            found[-1].data.append(row[:-1] if len(row) > 1 and row[-1] == "" else row)
            continue
        keyword = _keyword(line, number)
        rule = RULES[keyword.name]
        if keyword.name == "material":
            in_material = True
        elif rule.place != "material":
            in_material = False
        elif not in_material:
            raise keyword.error("expected after *Material")
        if keyword.name == "step":
            if in_step:
                raise keyword.error("expected *End Step before")
            in_step = True
        elif rule.place == "step" and not in_step:
            raise keyword.error("expected in a step")
        elif rule.place in ("model", "material") and in_step:
            raise keyword.error("expected before the first step")
        if keyword.name == "end step":
            in_step = False
        found.append(keyword)
    if not found or found[0].name != "heading":
        raise DeckError("line 1: expected *Heading")
    if in_step:
        raise found[-1].error("expected *End Step")
    for keyword in found:
        least, most = RULES[keyword.name].lines
        if not least <= len(keyword.data) <= most:
            wanted = (
                str(least) if least == most else f"{least} or more" if most == MANY else f"{least} to {most}"
            )
            raise keyword.error(f"{len(keyword.data)} data lines: expected {wanted}")
    return found


def _keyword(line: str, number: int) -> Keyword:
    """Name and options of a keyword line, which are in lower case; values stay."""
    name, *parts = [part.strip() for part in line[1:].split(",")]
    keyword = Keyword(" ".join(name.lower().split()), number, {})
    if keyword.name not in RULES:
        raise DeckError(f"line {number}: *{name}: unknown keyword")
    for part in parts:
        option, _, value = part.partition("=")
        option = " ".join(option.lower().split())
        if option in keyword.options:
            raise keyword.error(f"{option} is given twice")
        keyword.options[option] = value.strip()
    text = RULES[keyword.name].options
    known = text.split("|") if "|" in text else text.split()
    for option in keyword.options:
        if option not in [one.rstrip("*") for one in known]:
            raise keyword.error(
                f"{option or 'an empty option'}: expected one of {', '.join(known) or 'no options'}"
            )
    for one in known:
        if one.endswith("*") and one[:-1] not in keyword.options:
            raise keyword.error(f"{one[:-1]} is missing")
    return keyword
