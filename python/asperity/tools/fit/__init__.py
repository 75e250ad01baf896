"""Constants of the law from shear-box tests, `asperity fit`."""

from .fitting import fit as fit
from .records import read_tests as read_tests
from .shear_test import ShearTest as ShearTest
from .verdict import Fit as Fit
