#!/bin/sh
# hosts.sh: the library inside every host program that has tests in harness/hosts. What this machine cannot get is left out.
#
# host.toml names the Python packages of a host, which come first; one with an install.sh is made by that script in
# build/HOST, which takes minutes. Then two hosts run at a time, those with an install.sh first; what a host prints comes at
# its end. HOSTS='name name': only these. Every host has a run of pytest and a report (build/hosts/*.xml) of its own; its
# tests of several ranks of MPI have another one, at the end and alone, as ranks that wait keep their cores.
#
# hosts.sh HOST TITLE: makes and tests one host. hosts.sh HOST TITLE ranks: these tests of it.
set -eu
cd "$(dirname "$0")/.."
python=.venv/bin/python

# step HEADLINE LOG COMMAND...
step() {
  headline=$1 log=build/logs/$2.log
  shift 2
  tools/step.sh "$headline" "$log" "$@"
}

# tests HOST NAME OPTION...: tests of a host, with a log and a report of this name. pytest ends with 5 where all are left out
tests() {
  host=$1 name=$2
  shift 2
  status=0
  # shellcheck disable=SC2016  # $? is for that shell
  step "Tests: $name" "hosts-$name-tests" sh -c '"$@" || [ $? = 5 ]' sh "$python" -m pytest -rA \
    "$@" --junitxml="build/hosts/$name.xml" "harness/hosts/$host" || status=1
  grep -E "^(FAILED|ERROR|SKIPPED)" "build/logs/hosts-$name-tests.log" || true
  return $status
}

one_host() {
  if [ -n "${3:-}" ]; then
    tests "$1" "$1-$3" -m "$3" --numprocesses 0
    return
  fi
  if [ -x "harness/hosts/$1/install.sh" ]; then
    step "$2" "hosts-$1" "harness/hosts/$1/install.sh" "build/$1" || return 1
  fi
  tests "$1" "$1" -m "not ranks" --numprocesses 2 --dist worksteal
}

if [ $# -ge 2 ]; then
  # a host prints its lines in one piece; logs in build/logs show how far it is
  echo "$2: begun"
  status=0
  printed=$(one_host "$@" 2>&1) || status=1
  printf '%s\n' "$printed"
  [ $status = 0 ] || echo "$1" >>build/hosts/failed
  exit $status
fi

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
for folder in sorted(folders, key=lambda one: (not (one / "install.sh").exists(), one.name)):
    host = read(folder / "host.toml")
    print(folder.name, ",".join(host.packages) or "-", host.title)
END
}

mkdir -p build/hosts
rm -f build/hosts/*.xml build/hosts/failed
list >build/hosts/list
while read -r name packages title; do
  if [ ! -x "harness/hosts/$name/install.sh" ] && [ "$packages" != - ]; then
    # shellcheck disable=SC2016  # $1 is of that shell
    step "$title" "hosts-$name" sh -c 'echo "$2" | tr , "\n" | xargs "$1" -m pip install || {
      echo "no wheels here, left out" && exit 77; }; echo "there"' sh "$python" "$packages"
  fi
done <build/hosts/list
# run PROCESSES WORD...: the hosts of the list on the input, so many at a time
run() {
  processes=$1
  shift
  sed 's/^\([^ ]*\) [^ ]* \(.*\)$/\1 "\2"'"${*:+ $*}"'/' | xargs -r -P "$processes" -n $((2 + $#)) tools/hosts.sh
}

status=0
run 2 <build/hosts/list || status=1
while read -r name rest; do
  grep -q SEVERAL_RANKS "harness/hosts/$name"/test_*.py && echo "$name $rest"
done <build/hosts/list | run 1 ranks || status=1
if [ $status != 0 ]; then
  echo "Failed hosts: $(sort -u build/hosts/failed | tr '\n' ' ')"
  exit 1
fi
