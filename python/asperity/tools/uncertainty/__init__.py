"""Monte Carlo of uncertain constants through a load case."""

from .spread import uncertainty as uncertainty
