"""asperity: interface law for rough quasi-brittle interfaces (damage, friction, interlocking).

Law of Albarella, Serpieri, Alfano and Sacco (2015), docs/theory.md.  Components are (N, Tx, Ty), tension
and opening positive, angles in degrees, units the user's consistent set.
"""

import re
from importlib import import_module
from pathlib import Path
from typing import Any

_STUB = Path(__file__).with_suffix(".pyi").read_text(encoding="utf-8")
_LINES = re.findall(r"^from \.([\w.]*) import (\w+)", _STUB, re.MULTILINE)
_HOMES = {name: home or name for home, name in _LINES}
"""Module of each public name, from the stub. A module is imported when one of its names is first used."""

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
