"""install_extra.py EXTRA MODULE...: install what an extra of the package asks for, if a module is missing.

The exit status is 77 where it cannot be installed.
"""

import re
import subprocess
import sys
from importlib.metadata import requires


def missing(modules: list[str]) -> bool:
    """Whether one of the modules cannot be imported."""
    command = "; ".join(f"import {module}" for module in modules)
    return subprocess.run([sys.executable, "-c", command], check=False).returncode != 0


name, *modules = sys.argv[1:]
extra = re.compile(rf"extra == ['\"]{re.escape(name)}['\"]")
wanted = [line.split(";")[0].strip() for line in requires("asperity") or [] if extra.search(line)]
if not wanted:
    sys.exit(f"asperity[{name}]: expected an extra of the package")
pip = [sys.executable, "-m", "pip", "install"]
if missing(modules) and subprocess.run([*pip, *wanted], check=False).returncode != 0:
    print("no wheels here, left out")
    sys.exit(77)
print("there")
