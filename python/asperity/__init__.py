"""asperity: interface law for rough quasi-brittle interfaces (damage, friction, interlocking).

Law of Albarella, Serpieri, Alfano and Sacco (2015), docs/theory.md.  Components are (N, Tx, Ty), tension
and opening positive, angles in degrees, units the user's consistent set.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from . import contract as contract
    from .installed import library as library
    from .interface import EquilibriumLost as EquilibriumLost
    from .interface import History as History
    from .interface import Interface as Interface
    from .interface import Snap as Snap
    from .interface import Update as Update
    from .material import Material as Material
    from .material import ModelWarning as ModelWarning
    from .pattern import Pattern as Pattern
    from .selection.search import NoPatternError as NoPatternError
    from .selection.search import Scene as Scene
    from .selection.search import Selection as Selection
    from .selection.search import select as select

    __version__: str

_NAMES = {
    "contract": (),
    "installed": ("library",),
    "interface": ("EquilibriumLost", "History", "Interface", "Snap", "Update"),
    "material": ("Material", "ModelWarning"),
    "pattern": ("Pattern",),
    "selection.search": ("NoPatternError", "Scene", "Selection", "select"),
}
"""Public names of each module. A module is imported when one of its names is first used."""

__all__ = sorted(["contract", *(name for names in _NAMES.values() for name in names)])


def __getattr__(name: str) -> Any:
    """Import the module of a public name and return the value of the name."""
    if name == "__version__":
        found: Any = import_module(".contract", __name__).library_version()
    elif name == "contract":
        found = import_module(".contract", __name__)
    else:
        home = next((module for module, names in _NAMES.items() if name in names), None)
        if home is None:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        found = getattr(import_module(f".{home}", __name__), name)
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    """Names already imported, and the public names that are imported on first use."""
    return sorted({*globals(), *__all__, "__version__"})
