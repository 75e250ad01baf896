"""asperity: interface law for rough quasi-brittle interfaces (damage, friction, interlocking).

Law of Albarella, Serpieri, Alfano and Sacco (2015), docs/theory.md.  Components are (N, Tx, Ty), tension
and opening positive, angles in degrees, units the user's consistent set.
"""

from importlib import import_module
from typing import Any

_HOMES = {
    "EquilibriumLost": "interface",
    "ForeignUmat": "foreign",
    "History": "history",
    "Interface": "interface",
    "LoadCase": "selection.search",
    "Material": "material",
    "ModelWarning": "material",
    "NoPatternError": "selection.search",
    "Pattern": "pattern",
    "Point": "steps",
    "Selection": "selection.search",
    "Snap": "history",
    "Step": "steps",
    "Update": "history",
    "contract": "contract",
    "library": "installed",
    "plot": "plots",
    "read_case": "case_files",
    "select": "selection.search",
}
"""Module of each public name. A module is imported when one of its names is first used."""

__all__ = list(_HOMES)


def __getattr__(name: str) -> Any:
    """Import the module of a public name and return the value of the name."""
    home = _HOMES.get("contract" if name == "__version__" else name)
    if home is None:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    found = import_module(f".{home}", __name__)
    if name == "__version__":
        found = found.library_version()
    elif name != home:
        found = getattr(found, name)
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    """Public names."""
    return sorted([*__all__, "__version__"])
