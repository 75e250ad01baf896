#!/bin/sh
# install_extra.sh EXTRA: installs what an extra of the installed package asks for. The exit status is 77 where it cannot be
# had. With the version pinned pip takes no package of this name from an index.
export PATH="$PWD/.venv/bin:$PATH"
version=$(python -c "import asperity; print(asperity.__version__)")
python -m pip install "asperity[$1]==$version" || {
  echo "no wheels here, left out"
  exit 77
}
echo "there"
