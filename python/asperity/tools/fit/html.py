"""Report of a fit as one HTML file with its picture, for a reader who does not run the program."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from datetime import date
from html import escape
from importlib.metadata import version
from pathlib import Path

from ...case_writer import props_line
from ...contract import props_table
from .kinds import kind_of
from .report import AnyFit, coverage
from .thresholds import CONFIDENCE

START = "<!-- asperity fit -->"
"""Start of the file."""

STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; color: #222; max-width: 68em; margin: 2em auto; padding: 0 1em }
h1 { font-size: 1.5em } h2 { font-size: 1.15em; margin-top: 2em }
img { max-width: min(100%, 50em); max-height: 26em }
pre { background: #f5f5f5; padding: .8em; overflow-x: auto }
.grade { font-weight: bold; padding: .1em .6em; border-radius: .3em; color: #fff }
.good { background: #2a7d46 } .fair { background: #b7791f } .poor { background: #b23a3a }
"""
"""Style of the page."""

MEANINGS = {row.name: row.meaning.partition(";")[0] for row in props_table()} | {
    "ks": "shear stiffness of the joint",
    "kT": "stiffness in series: specimen, box, fit of the faces",
    "kn": "normal stiffness without pressure",
}
"""What the constants are."""

MEANING = f"""
<p>The intervals ({CONFIDENCE:g}) contain the noise of the tests, the misfit of the law and other
assumptions. A <em>blind</em> number was predicted by the other tests alone. The constants hold for the
pressures and slips of the tests.</p>
"""
"""What the numbers mean."""


def page(fit: AnyFit, units: tuple[str, str], command: str, warned: Sequence[str] = ()) -> str:
    """Text of the page; warned: what was doubted in the files of the tests."""
    kind = kind_of(fit.tests)
    verdict = f"The constants must not be used: {'; '.join(fit.reasons)}"
    if fit.is_result:
        verdict = f"The constants may be used for {_range(fit, units)}"
    title = f"Joint constants from {len(fit.tests)} test{'' if len(fit.tests) == 1 else 's'}"
    parts = [
        START,
        "<!DOCTYPE html>\n<html lang='en'><head><meta charset='utf-8'>"
        f"<title>{title}</title><style>{STYLE}</style></head><body><h1>{title}</h1>",
        f"<p><span class='grade {fit.grade}'>{fit.grade}</span> {escape(verdict)}.</p>",
        *(f"<p>Warning about the tests: {escape(text)}.</p>" for text in warned),
        _image(fit, units),
        f"<h2>Report</h2><pre>{escape(kind.report(fit, units, True))}</pre>{MEANING}<ul>",
        *(f"<li>{name}: {escape(MEANINGS[name])}</li>" for name in fit.estimates),
        f"</ul><h2>Case</h2><p>Units: {units[0]}, {units[1]}.</p><pre>{escape(kind.case(fit))}</pre>",
        f"<pre>{escape(props_line(kind.interface(fit).props()))}</pre>",
        f"<h2>How this was made</h2><pre>{escape(command)}</pre>",
        f"<p>asperity {version('asperity')}, {date.today().isoformat()}. Tests:</p><ul>",
        *(f"<li>{escape(name)}</li>" for name in _files(fit)),
        "</ul></body></html>\n",
    ]
    return "\n".join(parts)


def _files(fit: AnyFit) -> list[str]:
    """Files of the tests, without their folders, and the number of tests in each."""
    files = [Path(test.name.split(": ")[0]).name for test in fit.tests]
    counts = {file: files.count(file) for file in files}
    return [file if count == 1 else f"{file}, {count} tests" for file, count in counts.items()]


def _image(fit: AnyFit, units: tuple[str, str]) -> str:
    from ..style import encoded, printed

    with printed():
        data = base64.b64encode(encoded(kind_of(fit.tests).figure(fit, units, ""), ".png")).decode()
    return f"<img alt='measured and fitted curves' src='data:image/png;base64,{data}'>"


def _range(fit: AnyFit, units: tuple[str, str]) -> str:
    """Pressures, and slips of curves, that the tests cover."""
    low, high, slip = coverage(fit.tests)
    ends = [f"{pressure:.4g}" for pressure in (low, high)]
    text = f"pressures of {ends[0]} to {ends[1]}" if ends[0] != ends[1] else f"a pressure of {ends[0]}"
    return f"{text} {units[1]}" + (f" and slips up to {slip:.3g} {units[0]}" if slip else "")
