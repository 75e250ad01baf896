"""The toolbox: fits, scans of surfaces, patterns for load cases, uncertainty, pictures.

Each module of it is imported by its name, as in `from asperity.tools import fit`.  The law in `asperity`
imports nothing from here.
"""

from ..installed import needed

needed("tools", "matplotlib", "openpyxl", "pandas", "pint", "scipy", "tqdm")
