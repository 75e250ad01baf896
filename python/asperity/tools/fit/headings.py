"""Names of columns as laboratories write them, in seven languages."""

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


def standard(name: str) -> str:
    """Column that a name of a laboratory stands for, or the name."""
    chinese = next((column for column, rule in CHINESE.items() if re.match(rule, name.strip())), "")
    if chinese:
        return chinese
    text = name.replace("\u03c4", "tau").replace("\u03c3", "sigma").replace("\u03b4", "delta").casefold()
    text = unicodedata.normalize("NFKD", text).encode("ascii", "ignore").decode().strip()
    text = re.sub(PER_AREA, "stress", text)
    rules = {} if re.search(OTHER, text) else OF_FORCES if re.match(FORCE, text) else RULES
    return next((column for column, rule in rules.items() if re.match(rule, text)), name)
