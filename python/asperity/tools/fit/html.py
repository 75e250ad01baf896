"""Report of a fit as one HTML file with its pictures, for a reader who does not run the program."""

from __future__ import annotations

import base64
from collections.abc import Iterable, Sequence
from datetime import date
from html import escape
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING

from ...case_writer import props_line
from .closures import ClosureFit
from .criteria import STRESSES
from .intervals import CONFIDENCE
from .outputs import case_text_of, figure_of, interface_of
from .report import COLUMNS, AnyFit, covered, loose_of, model_text, unit_of
from .result import Fit
from .strengths import StrengthFit
from .verdict import FAIR, GOOD, short

if TYPE_CHECKING:
    from matplotlib.figure import Figure

TEXTS = ("meaning", "constants", "unit", "number")
"""Columns of words."""

START = "<!-- asperity fit -->"
"""Start of the file."""

STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; color: #222; max-width: 68em; margin: 2em auto; padding: 0 1em }
h1 { font-size: 1.5em } h2 { font-size: 1.15em; margin-top: 2em }
img { max-width: min(100%, 50em); max-height: 26em }
table { border-collapse: collapse; margin: .7em 0 } th, td { padding: .2em .8em; text-align: right }
th { border-bottom: 1px solid #888 } td:first-child, th:first-child { text-align: left }
tr:nth-child(even) td, pre { background: #f5f5f5 } pre { padding: .8em; white-space: pre-wrap }
td, th { white-space: nowrap } td.text, th.text { text-align: left; white-space: normal }
div { overflow-x: auto }
.grade { font-weight: bold; padding: .1em .6em; border-radius: .3em; color: #fff }
.good { background: #2a7d46 } .fair { background: #b7791f } .poor { background: #b23a3a }
"""
"""Style of the page."""

MEANINGS = {
    "mu": "friction coefficient",
    "theta": "inclination of the asperities",
    "height": "height of the asperities, the largest dilation",
    "crush": "stress that crushes asperities",
    "W0": "energy that wears asperities",
    "sigma0": "strength of the bond",
    "Gc": "fracture energy of the bond",
    "eta": "shape of the softening of the bond",
    "ks": "shear stiffness of the joint",
    "kT": "stiffness in series: specimen, box, fit of the faces",
    "kn": "normal stiffness without pressure",
    "closure": "largest closure",
}
"""What the constants are."""

MEANING = f"""
<p>The intervals ({CONFIDENCE:g}) contain the noise of the tests, the misfit of the law and other
assumptions. A <em>blind</em> number was predicted by the other tests alone. The grade is that of the largest
error: good up to {GOOD:.0%}, fair up to {FAIR:.0%}, else poor. The constants hold for
the pressures and slips of the tests.</p>
"""
"""What the numbers mean."""


def page(fit: AnyFit, units: tuple[str, str], command: str, warned: Sequence[str] = ()) -> str:
    """Text of the page; warned: what was doubted in the files of the tests."""
    figure = figure_of(fit, units)
    kind = "closure test" if isinstance(fit, ClosureFit) else "shear test"
    rows = []
    for name, estimate in fit.estimates.items():
        text = MEANINGS.get(name, "") + (" (not determined)" if name in loose_of(fit) else "")
        rows.append((name, *(f"{value:.4g}" for value in estimate), unit_of(name, units), text))
    verdict = "The constants must not be used: "
    if fit.is_result:
        verdict = f"The constants may be used for {_range(fit, units)}"
    parts = [
        f"<!DOCTYPE html>\n<html lang='en'><head><meta charset='utf-8'>"
        f"<title>{kind.capitalize()}s: fit</title>"
        f"<style>{STYLE}</style></head><body>",
        f"<h1>Joint constants from {len(fit.tests)} {kind}{'' if len(fit.tests) == 1 else 's'}</h1>",
        (
            f"<p><span class='grade {fit.grade}'>{fit.grade}</span> "
            f"{verdict}{escape('; '.join(fit.reasons))}.</p>"
        ),
        *(f"<p>Note: {escape(text)}.</p>" for text in fit.notes),
        *(f"<p>Warning about the tests: {escape(text)}.</p>" for text in warned),
        "<h2>Tests and fit</h2>",
        _image(figure),
        _compared(fit, units),
        "<h2>Constants</h2>",
        f"<p>Model: {escape(model_text(fit))}.</p>",
        _table(("constant", "value", "low", "high", "unit", "meaning"), rows),
        MEANING,
    ]
    if isinstance(fit, Fit) and fit.assumptions:
        names = [name for name in fit.free if name != "kT"]
        head = ("assumed instead", "misfit (BIC)", *names, "")
        table = []
        for assumption in fit.assumptions:
            cells = [f"{assumption.values[name]:.4g}" if name in assumption.values else "" for name in names]
            allowed = "" if assumption.admissible else "excluded by the tests"
            table.append((assumption.name, f"{assumption.difference:+.1f}", *cells, allowed))
        parts += ["<h2>Other assumptions</h2>", _table(head, table)]
    if isinstance(fit, StrengthFit):
        table = [
            (label, f"{fitted:.1%}", f"{unseen:.1%}" if unseen == unseen else "",
             ", ".join(f"{n} {v:.3g} {_unit(n, units)}".rstrip() for n, v in values.items()))
            for label, values, fitted, unseen in fit.others
        ]  # fmt: skip
        parts += [
            "<h2>Peaks by other criteria</h2>",
            _table(("criterion", "rms", "blind rms", "constants"), table),
        ]
    case = case_text_of(fit)
    errors = [(name, f"{value:.1%}") for name, value in fit.errors.items()]
    interface = interface_of(fit)
    parts += [
        "<h2>Errors</h2>",
        _table(("of", "largest" if isinstance(fit, ClosureFit) else "rms"), errors),
        "<h2>Case</h2>",
        f"<p>Units: {units[0]}, {units[1]}.</p><pre>{escape(case)}</pre>",
        f"<pre>{escape(props_line(interface.props()))}</pre>",
        "<h2>How this was made</h2>",
        (
            f"<pre>{escape(command)}</pre><p>asperity {version('asperity')}, "
            f"{date.today().isoformat()}. Tests:</p><ul>"
        ),
        *(f"<li>{escape(name)}</li>" for name in _files(fit)),
        "</ul></body></html>\n",
    ]
    return START + "\n" + "\n".join(parts)


def _unit(name: str, units: tuple[str, str]) -> str:
    """Unit of a constant of a criterion; JRC has none."""
    return units[1] if name in STRESSES else "" if name == "JRC" else "degree"


def _files(fit: AnyFit) -> list[str]:
    """Files of the tests, without their folders, and the number of tests in each."""
    files = [Path(test.name.split(": ")[0]).name for test in fit.tests]
    counts = {file: files.count(file) for file in files}
    return [file if count == 1 else f"{file}, {count} tests" for file, count in counts.items()]


def _image(figure: Figure) -> str:
    from ..style import encoded, printed

    with printed():
        data = base64.b64encode(encoded(figure, ".png")).decode()
    return f"<img alt='measured and fitted curves' src='data:image/png;base64,{data}'>"


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    ends = [" class='text'" if name in TEXTS else "" for name in head]
    top = "".join(f"<th{end}>{escape(cell)}</th>" for end, cell in zip(ends, head, strict=True))
    body = ""
    for row in rows:
        cells = (f"<td{end}>{escape(cell)}</td>" for end, cell in zip(ends, row, strict=True))
        body += f"<tr>{''.join(cells)}</tr>"
    return f"<div><table><tr>{top}</tr>{body}</table></div>"


def _range(fit: AnyFit, units: tuple[str, str]) -> str:
    """Pressures, and slips of curves, that the tests cover."""
    low, high, slip = covered(fit.tests)
    ends = [f"{pressure:.4g}" for pressure in (low, high)]
    text = f"pressures of {ends[0]} to {ends[1]}" if ends[0] != ends[1] else f"a pressure of {ends[0]}"
    return f"{text} {units[1]}" + (f" and slips up to {slip:.3g} {units[0]}" if slip else "")


def _compared(fit: AnyFit, units: tuple[str, str]) -> str:
    """Measured, fitted and blind numbers of each test, in a row each."""
    names = [name for name in COLUMNS if any(name in row.measured for row in fit.fitted)]
    rows, end = [], isinstance(fit, ClosureFit)  # a closure is that at the largest pressure
    for i, row in enumerate(fit.fitted):
        kinds = {"measured": row.measured, "fitted": row.predicted}
        kinds |= {"blind": fit.blind[i].predicted} if fit.blind else {}
        for kind, numbers in kinds.items():
            cells = [f"{numbers[name]:.4g}" if name in row.measured else "" for name in names]
            start = (
                (short(row.test), f"{covered(fit.tests[i : i + 1])[end]:.4g}")
                if kind == "measured"
                else ("", "")
            )
            rows.append([*start, kind, *cells])
    stresses = ("peak", "residual")
    head = [f"{COLUMNS[name]} [{units[1] if name in stresses else units[0]}]" for name in names]
    return _table(["test", f"pressure [{units[1]}]", "number", *head], rows)
