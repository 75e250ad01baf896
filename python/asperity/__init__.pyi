"""Public names; each is imported when it is first used."""

from . import barton as barton
from . import contract as contract
from . import fit as fit
from . import surface as surface
from . import uncertainty as uncertainty
from .case_files import read_case as read_case
from .errors import EquilibriumLost as EquilibriumLost
from .foreign import ForeignUmat as ForeignUmat
from .history import History as History
from .history import Snap as Snap
from .history import Update as Update
from .installed import library as library
from .interface import Interface as Interface
from .material import Material as Material
from .material import ModelWarning as ModelWarning
from .pattern import Pattern as Pattern
from .plots import plot as plot
from .selection.search import LoadCase as LoadCase
from .selection.search import NoPatternError as NoPatternError
from .selection.search import Selection as Selection
from .selection.search import select as select
from .steps import Point as Point
from .steps import Step as Step

__version__: str
