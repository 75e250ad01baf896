"""Names of columns as laboratories write them, in six languages."""

from __future__ import annotations

import re
import unicodedata

SHEAR = r"(?=.*(shear|horizontal|tangen|scher|schub|cisail|taglio|orizzontal|corte|cortant|cisalha))"
NORMAL = r"(?=.*(normal|vertical|vertikal|confin))"
PATH = r"(?=.*(disp|verschieb|weg\b|deplac|sposta|desplaza|desloca|slip))"
STRESS = r"(?=.*(stress|spannung|contrainte|tension|sforzo|esfuerzo|tensao|traction|pressure|pression))"
STRENGTH = r"(?=.*(stress|strength|spannung|festig|contrainte|resist|tension|esfuerzo|tensao))"
SYMBOL = r"(d|delta|u|dl|du|delta_?[lu])_?"
"""Beginning of a symbol of a displacement, as dLs, du_n or delta_h."""

FORCE = r"(?=.*(force|load|kraft|last\b|charge|forza|carico|fuerza|carga|forca))"
PEAK = r"(?=.*(peak|spitze|bruch|picco|pico|\bpic\b))"
OF_FORCES = {
    "peak_force": rf"{PEAK}{FORCE}(?!.*normal)",
    "residual_force": rf"(?=.*resid){FORCE}",
    "shear_force": rf"{SHEAR}{FORCE}",
    "normal_force": rf"{NORMAL}{FORCE}",
}
PER_AREA = r"(force|load|kraft|last|forza|fuerza|forca)\s*(per|/|pro|par|por)\s*(unit\s*)?(area|flache)"
"""A stress, in words."""

OTHER = r"rate|speed|veloc|geschwind|vitesse|strain"
RULES = {
    "peak": rf"{PEAK}{STRENGTH}",
    "residual": rf"(?=.*resid){STRENGTH}",
    "peak_slip": rf"{PEAK}{PATH}(?!.*(normal|vertical|vertikal))",
    "closure": r"(joint |fracture )?closure|schliess|kluftschl|fermeture|chiusura|cierre|fechamento",
    "slip": rf"{SHEAR}{PATH}|schlupf|glissement|{SYMBOL}(s|h|shear)$",
    "tau": rf"{SHEAR}{STRESS}|tau\b",
    "sigma_N": rf"{NORMAL}{STRESS}|sigma_?n?(_?eff)?\b",
    "dilation": rf"{NORMAL}{PATH}|s_n\b|dilat|uplift|{SYMBOL}(n|v|normal)$",
    "k_N": rf"{NORMAL}(?=.*(stiff|steif|rigid))",
    "test": r"(test|specimen|sample|versuchs?|proben?|essai|prova|provino|ensayo|ensaio)\W*"
    r"(id|name|no|nr|number|nummer|n|code|label)?\W*$",
}
"""Names of the columns in English, German, French, Italian, Spanish and Portuguese."""


def standard(name: str) -> str:
    """Column that a name of a laboratory stands for, or the name."""
    text = name.replace("\u03c4", "tau").replace("\u03c3", "sigma").replace("\u03b4", "delta").lower()
    text = unicodedata.normalize("NFKD", text).encode("ascii", "ignore").decode().strip()
    text = re.sub(PER_AREA, "stress", text)
    rules = {} if re.search(OTHER, text) else OF_FORCES if re.match(FORCE, text) else RULES
    return next((column for column, rule in rules.items() if re.match(rule, text)), name)
