#!/bin/sh
# hosts.sh: the library inside every host program that has tests in harness/hosts. What this machine cannot get is left out.
#
# host.toml names the Python packages of a host; one with an install.sh is made by that script in build/HOST, which takes
# minutes: these come last. HOSTS='name name': only these. Every host has a run of pytest and a report (build/hosts/*.xml) of
# its own.
set -eu
cd "$(dirname "$0")/.."
python=.venv/bin/python

# step HEADLINE LOG COMMAND...
step() {
  headline=$1 log=build/logs/$2.log
  shift 2
  tools/step.sh "$headline" "$log" "$@"
}

failed=

# tests HOST; pytest ends with 5 where all tests are left out. The other hosts run after a failure, too.
tests() {
  host=$1
  # shellcheck disable=SC2016  # $? is for that shell
  step "Tests: $host" "hosts-$host-tests" sh -c '"$@" || [ $? = 5 ]' sh "$python" -m pytest -rA \
    --junitxml="build/hosts/$host.xml" "harness/hosts/$host" || {
    grep -E "^(FAILED|ERROR)" "build/logs/hosts-$host-tests.log" || true
    failed="$failed $host"
  }
  grep "^SKIPPED" "build/logs/hosts-$host-tests.log" || true
}

# a line for each host with tests: its name, the packages, the title
list() {
  "$python" - <<'END'
import os
from pathlib import Path

from asperity.hosts import read

tested = [path.parent for path in Path("harness/hosts").glob("*/host.toml") if any(path.parent.glob("test_*.py"))]
there = {folder.name: folder for folder in tested}
wanted = os.environ.get("HOSTS", "").split() or list(there)
if unknown := set(wanted) - {*there}:
    raise SystemExit(f"HOSTS: {', '.join(sorted(unknown))}: expected some of {', '.join(sorted(there))}")
folders = [there[name] for name in wanted]
for folder in sorted(folders, key=lambda one: ((one / "install.sh").exists(), one.name)):
    host = read(folder / "host.toml")
    print(folder.name, ",".join(host.packages) or "-", host.title)
END
}

mkdir -p build/hosts
rm -f build/hosts/*.xml
list >build/hosts/list
while read -r name packages title; do
  if [ -x "harness/hosts/$name/install.sh" ]; then
    step "$title" "hosts-$name" "harness/hosts/$name/install.sh" "build/$name"
  elif [ "$packages" != - ]; then
    # shellcheck disable=SC2016  # $1 is of that shell
    step "$title" "hosts-$name" sh -c 'echo "$2" | tr , "\n" | xargs "$1" -m pip install || {
      echo "no wheels here, left out" && exit 77; }; echo "there"' sh "$python" "$packages"
  fi
  tests "$name"
done <build/hosts/list
[ -z "$failed" ] || {
  echo "Failed hosts:$failed"
  exit 1
}
