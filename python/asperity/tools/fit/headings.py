"""Names of columns as laboratories write them, in six languages."""

from __future__ import annotations

import re
import unicodedata

SHEAR = r"(?=.*(shear|horiz|tangen|scher|schub|cisail|taglio|orizzontal|corte|cortant|cisalha|tranchant))"
NORMAL = r"(?=.*(normal|vert\b|vertical|vertikal|confin))"
PATH = r"(?=.*(disp|verschieb|hebung|weg\b|deplac|sposta|desplaza|desloca|slip))"
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
    "shear_force": rf"{SHEAR}{FORCE}",
    "normal_force": rf"{NORMAL}{FORCE}",
}
PER_AREA = r"(force|load|kraft|last|forza|fuerza|forca)\s*(per|/|pro|par|por)\s*(unit\s*)?(area|flache)"
"""A stress, in words."""

ANGLES = "angle|winkel|angolo|angulo"
OTHER = rf"rate|speed|veloc|geschwind|vitesse|strain|{ANGLES}|ratio|coeff|energ|normali[sz]|rms\b"
"""Quantities that are none of these columns, as the dilation angle or a normalized stress."""

RULES = {
    "peak": rf"{PEAK}{STRENGTH}{SIZE}|tau[_ ]?(p|peak|max|f)\b|(peak|max\w*)[. _]*tau\b",
    "residual": rf"{RESIDUAL}{STRENGTH}{SIZE}|tau[_ ]?(r|res|residual)\b|residual[ _]tau\b",
    "strength": rf"{SHEAR}(?=.*(strength|festig|resist))",
    "peak_slip": rf"{PEAK}{PATH}{SIZE}",
    "closure": r"((joint|fracture|normal|crack)[_ ])?closure|schliess|kluftschl|fermeture|chiusura|cierre"
    r"|fechamento",
    "slip": rf"{SHEAR}{PATH}|schlupf|glissement|{SYMBOL}(s|h|shear)$",
    "tau": rf"{SHEAR}{STRESS}|tau\b",
    "sigma_N": rf"{NORMAL}{STRESS}|sigma_?n?(_?eff)?\b",
    "dilation": rf"{NORMAL}{PATH}|s_n\b|dilat|uplift|hebung|((joint|crack) )?opening|offnung|ouverture"
    rf"|{SYMBOL}(n|v|normal)$",
    "k_N": rf"{NORMAL}(?=.*(stiff|steif|rigid))",
    "test": r"(test|specimen|sample|versuchs?|proben?|essai|prova|provino|ensayo|ensaio)\W*"
    r"(id|name|no|nr|number|nummer|n|code|label)?\W*$",
}
"""Names of the columns in English, German, French, Italian, Spanish and Portuguese.  strength: the peak,
where there is no slip and no tau.
"""


def standard(name: str) -> str:
    """Column that a name of a laboratory stands for, or the name."""
    text = name.replace("\u03c4", "tau").replace("\u03c3", "sigma").replace("\u03b4", "delta").casefold()
    text = unicodedata.normalize("NFKD", text).encode("ascii", "ignore").decode().strip()
    text = re.sub(PER_AREA, "stress", text)
    rules = {} if re.search(OTHER, text) else OF_FORCES if re.match(FORCE, text) else RULES
    return next((column for column, rule in rules.items() if re.match(rule, text)), name)
