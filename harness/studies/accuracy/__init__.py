"""Work-precision studies: error against measured cost.

The studies vary increments (step size), planes (pattern), precision (single or double) and tangents.  The
parameters are those of Table 2, in mm and MPa.
"""
