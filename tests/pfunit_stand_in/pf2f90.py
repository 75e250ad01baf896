#!/usr/bin/env python3
"""Translate a genuine pFUnit file (.pf) into Fortran that calls the stand-in module funit, or only check it.

Whatever is not understood is an error with file, line and text; nothing is skipped.
"""

from __future__ import annotations

import argparse
import re
import sys
from dataclasses import dataclass, field
from pathlib import Path

MAX_COLUMNS = 120
# of a line of Fortran
FORTRAN_COLUMNS = 132
# Names that are declared by the suite function that pFUnit generates.
RESERVED = ("t", "suite", "test")
# Assertions by their name in lower case: name of the assertion, number of operands, and accepted options.
ASSERTIONS = {
    name.lower(): (name, operands, {"message", *options})
    for names, operands, options in (
        ("True False IsFinite", 1, ()),
        ("LessThan LessThanOrEqual GreaterThan GreaterThanOrEqual", 2, ()),
        ("Equal", 2, ("tolerance",)),
    )
    for name in names.split()
}


class PfError(Exception):
    """A line that is outside the subset of pFUnit that both frameworks treat alike."""


@dataclass
class Suite:
    """One .pf file: its module, its tests, and the translated lines."""

    path: Path
    module: str = ""
    tests: list[str] = field(default_factory=list)
    lines: list[str] = field(default_factory=list)
    errors: list[str] = field(default_factory=list)


def code_of(line: str) -> str:
    """Return the line with its comment cut off and the characters of its texts replaced by blanks."""
    code, quote = "", ""
    for char in line:
        if quote:
            quote = "" if char == quote else quote
            char = " "
        elif char == "!":
            break
        elif char in "'\"":
            quote, char = char, " "
        code += char
    return code


def arguments_of(text: str) -> list[str]:
    """Split "(a, b(1, 2), c)" at the commas of its outermost level; nothing may follow its end."""
    if not text.startswith("("):
        raise PfError("no argument list")
    code = code_of(text).ljust(len(text))
    depth, start, parts = 0, 1, []
    for i, char in enumerate(code):
        depth += (char in "([") - (char in ")]")
        if depth == 0 or (depth == 1 and char == ","):
            parts.append(text[start:i].strip())
            start = i + 1
        if depth == 0:
            if text[i + 1 :].strip():
                raise PfError("text after the closing parenthesis")
            return parts
    raise PfError("no closing parenthesis on the same line")


def assertion(name: str, text: str, file: str, line: int) -> list[str]:
    """Return the Fortran lines for one @assert directive."""
    if name.lower() not in ASSERTIONS:
        raise PfError(f"unknown assertion @assert{name}")
    op, count, known_options = ASSERTIONS[name.lower()]
    operands: list[str] = []
    options: dict[str, str] = {}
    for argument in arguments_of(text):
        keyword = re.match(r"(\w+)\s*=(?!=)\s*(.*)", argument)
        if not keyword:
            if options or not argument:
                raise PfError("an operand is empty or stands after an option")
            operands.append(argument)
            continue
        option, value = keyword[1].lower(), keyword[2]
        if option in options or option not in known_options or not value:
            raise PfError(f"@assert{op} takes no {option}= here")
        options[option] = value
    if len(operands) != count:
        raise PfError(f"@assert{op} takes {count} operand(s), then options by name")
    if op in {"True", "False"}:
        operands = [f"merge(1, 0, {operands[0]})"]
    arguments = [f"pf_value({operands[-1]})"]
    if count == 2:
        arguments.append(f", expected=pf_value({operands[0]})")
    if "tolerance" in options:
        arguments.append(f", tolerance=pf_value({options['tolerance']})")
    if "message" in options:
        arguments.append(f", message={options['message']}")
    # one line where it is as long as a compiler takes
    whole = "".join(arguments)
    lines = [whole] if len(whole) <= FORTRAN_COLUMNS - len("&&") else arguments
    return [f"call pf_assert('{op}', '{file}', {line}, actual=&", *(f"&{part}&" for part in lines), "&)"]


def check_line(raw: str, code: str) -> None:
    """Refuse what pFUnit or its C preprocessor would read differently."""
    if len(raw) > MAX_COLUMNS:
        raise PfError(f"{len(raw)} columns, at most {MAX_COLUMNS}")
    if raw.lstrip().startswith("#") or "/*" in raw or raw.endswith("\\"):
        raise PfError("means something to the C preprocessor, which pFUnit runs")
    if "@" in code.lstrip()[1:]:
        raise PfError("a directive must stand alone on its line")
    public = re.match(r"\s*public\s*::\s*(.*)", code, re.IGNORECASE)
    if public and set(RESERVED) & set(re.split(r"[\s,]+", public[1].lower())):
        raise PfError(f"no public entity may be named {', '.join(RESERVED)}")


def add_test(suite: Suite, raw: str) -> None:
    """Register the subroutine that follows @test."""
    header = re.fullmatch(r"\s*subroutine\s+(\w+)\s*\(\s*\)\s*", raw, re.IGNORECASE)
    if not header:
        raise PfError("the line after @test must be: subroutine name()")
    name = header[1].lower()
    if name in RESERVED or name in suite.tests:
        raise PfError(f"{name} is reserved or already used")
    suite.tests.append(name)


def read(path: Path) -> Suite:
    """Read and translate one .pf file; its errors are collected in the result."""
    suite = Suite(path)
    awaits_test, continued, number, raw = False, False, 0, ""
    for number, raw in enumerate(path.read_text(encoding="utf-8").splitlines(), start=1):
        code = code_of(raw)
        try:
            check_line(raw, code)
            directive = re.match(r"\s*@(\w*)\s*(.*)", raw)
            if awaits_test:
                awaits_test = False
                add_test(suite, raw)
            if module := re.fullmatch(r"\s*module\s+(\w+)\s*", raw, re.IGNORECASE):
                if suite.module or module[1].lower() != path.stem.lower():
                    raise PfError(f"the file must hold one module, {path.stem}")
                suite.module = module[1]
            if not directive:
                suite.lines.append(raw)
            elif continued:
                raise PfError("a directive cannot continue a line")
            elif directive[1].lower() == "test":
                if directive[2]:
                    raise PfError("text after the directive")
                awaits_test = True
                suite.lines.append("")
            elif directive[1].lower().startswith("assert"):
                # the operands are the second line, on which a compiler reports an error
                suite.lines.append(f'#line {number - 1} "{path}"')
                suite.lines += assertion(directive[1][6:], directive[2], path.name, number)
                suite.lines += ["if (pf_failed) return", f'#line {number + 1} "{path}"']
            else:
                raise PfError(f"unknown directive @{directive[1]}")
        except PfError as error:
            suite.errors.append(f"{path}:{number}: {error}: {raw.strip()}")
        if code.strip():
            continued = code.rstrip().endswith("&")
    for fault, missing in (
        (awaits_test, "nothing after @test"),
        (not suite.module, f"no line 'module {path.stem}'"),
        (not suite.tests, "no @test"),
    ):
        if fault:
            suite.errors.append(f"{path}:{number}: {missing}: {raw.strip()}")
    return suite


def fortran_of(suite: Suite) -> str:
    """Return the module of the suite and a program that runs its tests."""
    text = [f'#line 1 "{suite.path}"', *suite.lines, ""]
    text += ["program pf_main", "use funit, only: pf_finish, pf_run"]
    text += [f"use {suite.module}, only: test_{i} => {name}" for i, name in enumerate(suite.tests)]
    text += ["implicit none"]
    text += [f"call pf_run('{suite.module}', '{name}', test_{i})" for i, name in enumerate(suite.tests)]
    text += ["call pf_finish()", "end program pf_main"]
    return "\n".join(text) + "\n"


def main() -> int:
    """Run the command; exit status 1 if the file is refused."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("file", type=Path, help=".pf file")
    parser.add_argument("-o", "--output", type=Path, help="Fortran source to write; without it, only check")
    options = parser.parse_args()
    suite = read(options.file)
    for error in suite.errors:
        print(error, file=sys.stderr)
    if not suite.errors and options.output:
        options.output.write_text(fortran_of(suite), encoding="utf-8")
    return 1 if suite.errors else 0


if __name__ == "__main__":
    sys.exit(main())
