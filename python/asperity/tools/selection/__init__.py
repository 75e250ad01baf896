"""The pattern that a load case needs, `asperity select`."""
