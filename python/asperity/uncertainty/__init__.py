"""Monte Carlo of uncertain constants through a load case."""
