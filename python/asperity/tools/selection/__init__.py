"""The pattern that a load case needs, `asperity select`."""

from .search import LoadCase as LoadCase
from .search import NoPatternError as NoPatternError
from .search import Selection as Selection
from .search import select as select
