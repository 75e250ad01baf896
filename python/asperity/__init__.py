"""Interface law asperity for rough quasi-brittle interfaces (damage, friction, interlocking).

Law of Albarella, Serpieri, Alfano and Sacco (2015), docs/theory.md.  Components are (N, Tx, Ty), tension
and opening positive, angles in degrees, units the user's consistent set.  The law, load paths and case files
need NumPy alone; the toolbox (fits, scans, pictures) is `asperity.tools` with packages of its own.
"""

from . import contract as contract
from .case_files import read_case as read_case
from .contract import library_version
from .foreign import ForeignUmat as ForeignUmat
from .history import EquilibriumLost as EquilibriumLost
from .history import History as History
from .history import Snap as Snap
from .history import Stability as Stability
from .history import Update as Update
from .installed import library as library
from .interface import Interface as Interface
from .material import Material as Material
from .material import ModelWarning as ModelWarning
from .pattern import Pattern as Pattern
from .steps import Point as Point
from .steps import Step as Step

__version__ = library_version()
__all__ = [
    "EquilibriumLost",
    "ForeignUmat",
    "History",
    "Interface",
    "Material",
    "ModelWarning",
    "Pattern",
    "Point",
    "Snap",
    "Stability",
    "Step",
    "Update",
    "contract",
    "library",
    "read_case",
]
