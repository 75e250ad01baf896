#!/usr/bin/env python3
"""Translate genuine pFUnit files (.pf) into Fortran that calls the stand-in module funit, or only check them.

Whatever is not understood is an error with file, line and text; nothing is skipped.
"""

from __future__ import annotations

import argparse
import re
import sys
from dataclasses import dataclass, field
from pathlib import Path

MAX_COLUMNS = 120
# Names that are declared by the suite function that pFUnit generates.
RESERVED = ("t", "suite", "test")
ORDERS = "LessThan LessThanOrEqual GreaterThan GreaterThanOrEqual"
# Assertions by their name in lower case: name of the assertion, number of operands, and accepted options.
ASSERTIONS = {
    name.lower(): (name, operands, options)
    for names, operands, options in (
        ("True False IsNaN IsFinite", 1, {"message"}),
        (f"Equal NotEqual {ORDERS} RelativelyEqual", 2, {"tolerance", "message"}),
        ("ExceptionRaised", 0, set()),
    )
    for name in names.split()
}


class PfError(Exception):
    """A line that is outside the subset of pFUnit that both frameworks treat alike."""


@dataclass
class Suite:
    """One .pf file: its module, its test, before and after procedures, and the translated lines."""

    path: Path
    module: str = ""
    uses_funit: bool = False
    procedures: dict[str, list[str]] = field(default_factory=lambda: {"test": [], "before": [], "after": []})
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
            return [] if parts == [""] else parts
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
    if op == "ExceptionRaised":
        if len(operands) > 1:
            raise PfError("@assertExceptionRaised takes at most the text thrown")
        return [f"call pf_assert_raised('{file}', {line}&", *(f"&, {text}&" for text in operands), "&)"]
    if len(operands) != count:
        raise PfError(f"@assert{op} takes {count} operand(s), then tolerance= and message= by name")
    if op == "RelativelyEqual" and "tolerance" not in options:
        raise PfError("@assertRelativelyEqual needs tolerance=")
    lines = [f"call pf_assert('{op}', '{file}', {line}, actual=&", f"&pf_value({operands[-1]})&"]
    if count == 2:
        lines.append(f"&, expected=pf_value({operands[0]})&")
    if "tolerance" in options:
        lines.append(f"&, tolerance=pf_value({options['tolerance']})&")
    if "message" in options:
        lines.append(f"&, message={options['message']}&")
    return [*lines, "&)"]


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


def add_procedure(suite: Suite, role: str, raw: str) -> None:
    """Register the subroutine that follows @test, @before or @after."""
    header = re.fullmatch(r"\s*subroutine\s+(\w+)\s*\(\s*\)\s*", raw, re.IGNORECASE)
    if not header:
        raise PfError(f"the line after @{role} must be: subroutine name()")
    name = header[1].lower()
    if name in RESERVED or any(name in names for names in suite.procedures.values()):
        raise PfError(f"{name} is reserved or already used")
    if role != "test" and suite.procedures[role]:
        raise PfError(f"second @{role}")
    suite.procedures[role].append(name)


def read(path: Path) -> Suite:
    """Read and translate one .pf file; its errors are collected in the result."""
    suite = Suite(path)
    role, continued, number, raw = "", False, 0, ""
    for number, raw in enumerate(path.read_text(encoding="utf-8").splitlines(), start=1):
        code = code_of(raw)
        try:
            check_line(raw, code)
            directive = re.match(r"\s*@(\w*)\s*(.*)", raw)
            if role:
                awaited, role = role, ""
                add_procedure(suite, awaited, raw)
            if module := re.fullmatch(r"\s*module\s+(\w+)\s*", raw, re.IGNORECASE):
                if suite.module or module[1].lower() != path.stem.lower():
                    raise PfError(f"the file must hold one module, {path.stem}")
                suite.module = module[1]
            suite.uses_funit |= bool(re.fullmatch(r"\s*use\s+funit\s*", raw, re.IGNORECASE))
            if not directive:
                suite.lines.append(raw)
            elif continued:
                raise PfError("a directive cannot continue a line")
            elif directive[1].lower() in suite.procedures:
                if directive[2]:
                    raise PfError("text after the directive")
                role = directive[1].lower()
                suite.lines.append("")
            elif directive[1].lower().startswith("assert"):
                suite.lines += assertion(directive[1][6:], directive[2], path.name, number)
                suite.lines += ["if (pf_raised()) return", f'#line {number + 1} "{path}"']
            else:
                raise PfError(f"unknown directive @{directive[1]}")
        except PfError as error:
            suite.errors.append(f"{path}:{number}: {error}: {raw.strip()}")
        if code.strip():
            continued = code.rstrip().endswith("&")
    for fault, missing in (
        (role, f"nothing after @{role}"),
        (not suite.module, f"no line 'module {path.stem}'"),
        (not suite.uses_funit, "no line 'use funit'"),
        (not suite.procedures["test"], "no @test"),
    ):
        if fault:
            suite.errors.append(f"{path}:{number}: {missing}: {raw.strip()}")
    return suite


def fortran_of(suites: list[Suite]) -> str:
    """Return one source: every suite's module, a module that runs its tests, and the main program."""
    # Only a preprocessor makes Fortran of RUN_SUITE: pFUnit's main program needs one, too.
    text = ["#define RUN_SUITE(name) call name()"]
    for suite in suites:
        tests, before, after = (suite.procedures[role] for role in ("test", "before", "after"))
        fixture = "".join(f", {role}={n[0]}" for role, n in (("before", before), ("after", after)) if n)
        text += [f'#line 1 "{suite.path}"', *suite.lines, ""]
        text += [f"module {suite.module}_suite", "use funit, only: pf_run"]
        text += [f"use {suite.module}, only: {name}" for name in tests + before + after]
        text += ["implicit none", "private", "public :: run_suite", "contains", "subroutine run_suite()"]
        text += [f"call pf_run('{suite.module}', '{name}', &\n{name}{fixture})" for name in tests]
        text += ["end subroutine run_suite", f"end module {suite.module}_suite", ""]
    text += ["program pf_main", "use funit, only: pf_finish"]
    text += [f"use {suite.module}_suite, only: run_{i} => run_suite" for i, suite in enumerate(suites)]
    text += ["implicit none", *(f"RUN_SUITE(run_{i})" for i in range(len(suites)))]
    text += ["call pf_finish()", "end program pf_main"]
    return "\n".join(text) + "\n"


def main() -> int:
    """Run the command; exit status 1 if a file is refused."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("files", nargs="+", type=Path, help=".pf files of one executable")
    parser.add_argument("-o", "--output", type=Path, help="Fortran source to write; without it, only check")
    options = parser.parse_args()
    suites = [read(path) for path in options.files]
    errors = [error for suite in suites for error in suite.errors]
    for error in errors:
        print(error, file=sys.stderr)
    if not errors and options.output:
        options.output.write_text(fortran_of(suites), encoding="utf-8")
    return 1 if errors else 0


if __name__ == "__main__":
    sys.exit(main())
