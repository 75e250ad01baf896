"""Parameters of the law from shear-box records, `asperity fit`."""

from .fitting import fit as fit
from .records import read_records as read_records
from .shear_test import ShearTest as ShearTest
