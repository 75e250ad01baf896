"""`python -m harness.studies.paper` recomputes the figures and tables of the paper."""

import sys

from .command import main

sys.exit(main())
