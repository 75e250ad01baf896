"""asperity: interface law for rough quasi-brittle interfaces (damage, friction, interlocking).

Law of Albarella, Serpieri, Alfano and Sacco (2015), docs/theory.md.  Components are (N, Tx, Ty), tension
and opening positive, angles in degrees, units the user's consistent set.
"""

from . import contract
from .installed import library
from .interface import EquilibriumLost, History, Interface, Snap, Update
from .material import Material, ModelWarning
from .pattern import Pattern
from .selection import NoPatternError, Scene, Selection, select

__version__ = contract.library_version()

__all__ = [
    "EquilibriumLost",
    "History",
    "Interface",
    "Material",
    "ModelWarning",
    "NoPatternError",
    "Pattern",
    "Scene",
    "Selection",
    "Snap",
    "Update",
    "contract",
    "library",
    "select",
]
