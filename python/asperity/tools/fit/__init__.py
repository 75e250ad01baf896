"""Constants of the law from shear-box tests, `asperity fit`."""

from .fitting import fit as fit
from .records import ShearTest as ShearTest
from .records import read_tests as read_tests
from .result import Fit as Fit
