"""Columns of the files of laboratories: their names in seven languages, and the factors of their units."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ..tables import Table, size, warn_if

REQUIRED, OPTIONAL = ("slip", "tau", "sigma_N"), ("dilation", "k_N", "test")
STRENGTHS, BESIDE = ("peak", "sigma_N"), ("residual", "peak_slip", "slip")
FORCES = {
    f"{name}_force": stress
    for name, stress in zip(
        ("shear", "normal", "peak", "residual"), ("tau", "sigma_N", "peak", "residual"), strict=True
    )
}
CLOSURES = ("closure", "sigma_N")
KNOWN = (*dict.fromkeys(REQUIRED + STRENGTHS + BESIDE + OPTIONAL + CLOSURES), *FORCES)
"""Columns of a file; STRENGTHS, BESIDE: those needed and others of a table with a row for each test; FORCES:
forces and the stresses that they are over an area.
"""

MEASURES = dict.fromkeys(("slip", "peak_slip", "dilation", "closure"), "length") | {"k_N": "stiffness"}
MEASURES |= dict.fromkeys(FORCES.values(), "stress") | dict.fromkeys(FORCES, "force")
DEFAULT, NONE = ("mm", "MPa"), ("length", "stress")
"""What each column measures; units to which numbers with units are converted, and labels without units."""


def columns_of(table: Table, renamed: Mapping[str, str], optional: bool, forces: bool) -> list[str]:
    """Columns of the file, "" for those that are not used.

    A name of the user comes before one of this program, and this before one of a laboratory.  forces: an area
    is given, so that forces come before stresses.
    """
    headers, lower = table.headings, [name.lower() for name in table.names]
    there = f"{table.path}: line {table.line}: columns {', '.join(headers)}: expected"
    places_of = {name: table.places(header) for name, header in renamed.items()}
    missing = [renamed[name] for name, places in places_of.items() if not places]
    if missing:
        raise ValueError(f"{there} {', '.join(missing)}, too (--columns)")
    exact = {name.lower(): name for name in KNOWN if name not in renamed}
    taken = {*renamed, *(exact[name] for name in lower if name in exact)}
    names = [
        exact.get(low, name if standard(name) in taken else standard(name))
        for name, low in zip(table.names, lower, strict=True)
    ]
    for name, places in places_of.items():
        for place in places:
            names[place] = name
    dropped = {FORCES[name] for name in names if name in FORCES} if forces else {*FORCES}
    names = ["" if name in dropped else name for name in names]
    shown = {FORCES.get(name, name) for name in names}
    if "strength" in names and "peak" in names and "peak" not in renamed:
        both = " and ".join(headers[names.index(name)] for name in ("strength", "peak"))
        raise ValueError(f"{there} one strength, not {both} (--columns peak=HEADER for that of the peak)")
    if "strength" in shown and not {"tau", "slip", "peak"} & shown:
        # a strength without a slip is that of a test
        names, shown = ["peak" if name == "strength" else name for name in names], {*shown, "peak"}
    curved = bool({"tau", "slip"} & shown)
    closes = "closure" in shown and not curved
    table_of_strengths = {"peak", "residual"} & shown and "tau" not in shown
    required = STRENGTHS if table_of_strengths else CLOSURES if closes else REQUIRED
    missing = [name for name in required if name not in shown and not (optional and name == "sigma_N")]
    option = f"--columns {''.join(missing[:1])}=HEADER, in Python columns=, for a column with another name"
    if missing:
        ratios = [name for name in table.names if is_quotient(name)]
        more = "--sigma-N VALUE for files without sigma_N, 0 without a pressure; --area A for forces"
        if missing == ["peak"]:
            more = "residual strengths alone show the friction at large slips: --columns peak=HEADER for them"
        elif "dilation" in shown and not curved:
            more = "a closure test has no slip: --columns closure=HEADER"
        elif ratios and {"tau", "peak"} & {*missing}:
            more = f"{ratios[0]} is a ratio, and no stress"
        elif missing == ["slip"]:
            peak, name = ("peak", "tau") if "tau" in names else ("peak_force", "shear_force")
            more = f'strengths have none: --columns {peak}="{headers[names.index(name)]}" for a row per test'
        raise ValueError(f"{there} {', '.join(missing)}, too ({option}; {more})")
    twice = next((name for name in KNOWN if names.count(name) > 1), "")
    if twice:
        text = f"column {twice} is there twice: expected one, or --columns {twice}=HEADER"
        raise ValueError(f"{table.path}: line {table.line}: {text}")
    used = {*(STRENGTHS + BESIDE if table_of_strengths else REQUIRED + OPTIONAL)}
    used = {*CLOSURES, "test"} if closes else used
    used |= {name for name, stress in FORCES.items() if stress in used}
    unused = [header for header, name in zip(headers, names, strict=True) if header and name not in used]
    warn_if(unused, f"{table.path}: columns not used: {', '.join(unused)}")
    return [name if name in used else "" for name in names]


def with_names(table: Table, renamed: Mapping[str, str], decimal: str | None) -> Table:
    """Table without a header whose columns have names: their places, 1, 2, ..., as `renamed` has them.

    Without any of these, two or three columns are slip, tau, sigma_N in this order, of which the slip alone
    must grow from row to row; a ModelWarning says so.  Raises ValueError for any other table.
    """
    width = table.cells.shape[1]
    names = [str(i + 1) for i in range(width)]
    if not renamed:
        wanted = "expected a header, or --columns slip=1 --columns tau=2 and so on"
        text = f"{table.path}: {width} columns without a header: {wanted}"
        if not 1 < width <= len(REQUIRED):
            raise ValueError(text)
        numbers = table.numbers(range(width), names, names, decimal)
        grows = [bool((np.diff(column) > 0.0).all()) for column in numbers.T]
        if grows != [True, *[False] * (width - 1)]:
            raise ValueError(f"{text}; the first column alone of slip, tau, sigma_N grows from row to row")
        names = [*REQUIRED[:width]]
        warn_if(True, f"{table.path}: no header: the columns are read as {', '.join(names)}")
    return replace(table, names=names, headings=names, units=[""] * width)


def factors_of(where: str, units: Mapping[str, str], target: tuple[str, str]) -> list[float]:
    """Factor of every column from its unit to that of the target, 1 where no column has a unit."""
    length, stress = (size(kind, unit) for kind, unit in zip(NONE, target, strict=True))
    wanted = {"length": length, "stress": stress, "stiffness": stress / length, "force": stress * length**2}
    first = next((f"{name} [{unit}]" for name, unit in units.items() if unit), "")
    without = next((name for name, unit in units.items() if first and not unit), "")
    if without:
        text = f"column {without} has no unit: expected one for every column, as {first} has, or none at all"
        raise ValueError(f"{where}: {text}")
    kinds = ((MEASURES[name], unit, f"{where}: {name} ") for name, unit in units.items() if first)
    return [size(*kind) / wanted[kind[0]] for kind in kinds] or [1.0] * len(units)


ALONG = r"(?=.*(shear|horiz|tangen|scher|schub|cisail|taglio|orizzontal|corte|cortant|cisalha|tranchant))"
ACROSS = r"(?=.*(normal|vert\b|vertical|vertikal|confin))"
WAYS = r"disp|verschieb|hebung|weg\b|deplac|sposta|desplaza|desloca|slip"
PATH = rf"(?=.*({WAYS}))"
NO_WAY = rf"(?!.*({WAYS}|dilat))"
"""No displacement or dilation, such as that at the peak stress."""

STRESS = r"(?=.*(stress|spannung|contrainte|tension|sforzo|esfuerzo|tensao|traction|pressure|pression))"
STRENGTH = r"(?=.*(stress|strength|spannung|festig|contrainte|resist|tension|esfuerzo|tensao))"
SYMBOL = r"(d|delta|u|dl|du|delta_?[lu])_?"
"""Beginning of a symbol of a displacement, as dLs, du_n or delta_h."""

FORCE = r"(?=.*(force|load|kraft|last\b|charge|effort|forza|carico|fuerza|carga|forca))"
PEAK = r"(?=.*(peak|spitze|bruch|picco|pico|(?<![a-z])(pic\b|pic_|max)))"
RESIDUAL = r"(?=.*(resid|restscher|restfest))"
SIZE = r"(?!.*(normal|vert\b|vertical|vertikal))"
OF_FORCES = {
    "peak_force": rf"{PEAK}{FORCE}{SIZE}",
    "residual_force": rf"{RESIDUAL}{FORCE}{SIZE}",
    "shear_force": rf"{ALONG}{FORCE}",
    "normal_force": rf"{ACROSS}{FORCE}",
}
PER_AREA = r"(force|load|kraft|last|forza|fuerza|forca)\s*(per|/|pro|par|por)\s*(unit\s*)?(area|flache)"
"""A stress, in words."""

ANGLES = "angle|winkel|angolo|angulo"
OTHER = rf"rate|speed|veloc|geschwind|vitesse|strain|{ANGLES}|ratio|coeff|energ|normali[sz]|rms\b"
OTHER += "|axial|deviator|barton|predict|estimat|model|calculat"
"""Quantities that are none of these columns, as the dilation angle, a normalized stress, those of a triaxial
test or of a model.
"""

RULES = {
    "peak": rf"{PEAK}{STRENGTH}{NO_WAY}{SIZE}|tau[_ ]?(p|peak|max|f)\b|(peak|max\w*)[. _]*tau\b",
    "residual": rf"{RESIDUAL}{STRENGTH}{NO_WAY}{SIZE}|tau[_ ]?(r|res|residual)\b|residual[ _]tau\b",
    "strength": rf"{ALONG}(?=.*(strength|festig|resist))",
    "peak_slip": rf"{PEAK}{PATH}{SIZE}",
    "closure": r"((joint|fracture|normal|crack)[_ ])?closure|schliess|kluftschl|fermeture|chiusura|cierre"
    r"|fechamento",
    "slip": rf"{ALONG}{PATH}|schlupf|glissement|{SYMBOL}(s|h|shear)$",
    "tau": rf"{ALONG}{STRESS}{NO_WAY}|tau\b",
    "sigma_N": rf"{ACROSS}{STRESS}|sigma_?n?(_?eff)?\b",
    "dilation": rf"{ACROSS}{PATH}|s_n\b|dilat|uplift|hebung|((joint|crack) )?opening|offnung|ouverture"
    rf"|{SYMBOL}(n|v|normal)$",
    "k_N": rf"{ACROSS}(?=.*(stiff|steif|rigid))",
    "stress": r"(tau|sigma|jcs|ucs)",
    "test": r"(test|specimen|sample|versuchs?|proben?|essai|prova|provino|ensayo|ensaio)\W*"
    r"(id|name|no|nr|number|nummer|n|code|label)?\W*$",
}
"""Names of the columns in English, German, French, Italian, Spanish and Portuguese.  strength: the peak,
where there is no slip and no tau; stress: another one, as sigma_ci, which is not used.
"""

CHINESE = {
    "peak_slip": "\u5cf0\u503c.*\u4f4d\u79fb",
    "residual": "\u6b8b\u4f59.*(\u5e94\u529b|\u5f3a\u5ea6)",
    "peak": "\u5cf0\u503c.*(\u5e94\u529b|\u5f3a\u5ea6)",
    "closure": "\u95ed\u5408",
    "slip": "(\u526a|\u5207\u5411|\u6c34\u5e73).*\u4f4d\u79fb|\u6ed1\u79fb",
    "tau": "(\u526a|\u5207).*\u5e94\u529b",
    "sigma_N": "(\u6cd5\u5411|\u6b63|\u5782\u76f4).*(\u5e94\u529b|\u538b\u5f3a)",
    "dilation": "(\u6cd5\u5411|\u5782\u76f4|\u7ad6\u5411).*\u4f4d\u79fb|\u526a\u80c0",
    "shear_force": "(\u526a|\u5207\u5411|\u6c34\u5e73).*(\u529b|\u8377\u8f7d)$",
    "normal_force": "(\u6cd5\u5411|\u5782\u76f4|\u7ad6\u5411).*(\u529b|\u8377\u8f7d)$",
    "test": "(\u8bd5\u6837|\u8bd5\u4ef6)(\u7f16\u53f7|\u53f7)?$",
}
"""Names of the columns in Chinese."""


STATISTICS = re.compile(
    r"(valeur|valore?|arith\w*?|geom\w*?|gesamt|grand|total|overall)?"
    r"(means?|averages?|avg|median[aeo]?|mittel(werte?)?|mw|durchschnitt(swerte?)?|moy|moyennes?|medi[ao]"
    r"|promedio|min|minimum|minimo|max|maximum|massimo|maximo|range|sum|summe|somme|suma|soma|total|count"
    r"|anzahl|sd|sem|char(acteristic)?|cov|cv|varianz|variance"
    r"|(standard|stand|std|st)(deviation|dev|abweichung|abw|fehler|error|err)|std|stabw"
    r"|(deviazione|desviacion|desvio|dev|desv)(standard|estandar|std|st|est|tipica|tip|padrao|pad)"
    r"|(ecart|scarto)(type|tipo|quadraticomedio)|(var|variations?)[ck]oeff?(izient)?"
    r"|coeff?(icient[ea]?|iente)?(var|variation|variacion|variacao|variazione)?"
    r"|\u5e73?\u5747\u503c|\u5e73\u5747|\u6807\u51c6\u504f?\u5dee|\u53d8\u5f02\u7cfb\u6570|\u6700[\u5927\u5c0f]\u503c)+"
)
"""Words of statistics in these languages without blanks and points, also two, as in `Mean \u00b1 SD`."""

OF_WHAT = re.compile(r"[(\[:=\d]|\b(?:values?|of|for|at|von|bei|des?|di)\b")
"""What ends a word of statistics, and tells of which rows it is."""

SHORT = 3
"""Letters up to which a word with a number, as SD 1, is a name."""


def is_statistic(cell: str) -> bool:
    """Whether a cell is a word of statistics, so that its row in a table is not that of a specimen."""
    text = unicodedata.normalize("NFKD", cell.casefold())
    text = "".join(letter for letter in text if not unicodedata.combining(letter))
    word = re.sub(r"[\W_]", "", OF_WHAT.split(text)[0])
    return bool(STATISTICS.fullmatch(word)) and not (len(word) <= SHORT and re.search(r"^\W*\w+\W*\d", text))


def is_quotient(name: str) -> bool:
    """Whether a name is that of a ratio: what it is divided by is another quantity than that of the whole."""
    return not {*map(_column, name.split("/")[1:])} <= {_column(name), ""}


def standard(name: str) -> str:
    """Column that a name of a laboratory stands for, or the name."""
    return name if is_quotient(name) else _column(name) or name


def _column(name: str) -> str:
    """Column of the first rule that a name follows, or nothing."""
    chinese = next((column for column, rule in CHINESE.items() if re.match(rule, name.strip())), "")
    if chinese:
        return chinese
    text = name.replace("\u03c4", "tau").replace("\u03c3", "sigma").replace("\u03b4", "delta").casefold()
    text = unicodedata.normalize("NFKD", text).encode("ascii", "ignore").decode().strip()
    text = re.sub(PER_AREA, "stress", text)
    rules = {} if re.search(OTHER, text) else OF_FORCES if re.match(FORCE, text) else RULES
    return next((column for column, rule in rules.items() if re.match(rule, text)), "")
