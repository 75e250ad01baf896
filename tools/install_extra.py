"""install_extra.py EXTRA: install what an extra of the installed package asks for, and nothing anew."""

import re
import subprocess
import sys
from importlib.metadata import requires

extra = re.compile(rf"extra == ['\"]{re.escape(sys.argv[1])}['\"]")
wanted = [line.split(";")[0].strip() for line in requires("asperity") or [] if extra.search(line)]
if not wanted:
    sys.exit(f"asperity[{sys.argv[1]}]: expected an extra of the package")
sys.exit(subprocess.run([sys.executable, "-m", "pip", "install", *wanted], check=False).returncode)
