"""`python -m asperity` is the command `asperity`."""

import sys

from .cli import main

sys.exit(main())
