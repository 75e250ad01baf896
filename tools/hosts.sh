#!/bin/sh
# hosts.sh: the library inside Kratos, OpenGeoSys, MTest, OOFEM, Akantu, FEniCSx, scikit-fem and CalculiX. What this
# machine cannot get is left out.
#
# CalculiX comes as Debian's source package (built once, build/calculix), which takes longest and is last; the others come
# as wheels, those of FEniCSx for a Python of 3.12 or later. Every host has a run of pytest and a report
# (build/hosts/*.xml) of its own.
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

rm -f build/hosts/*.xml
step "Kratos" hosts-kratos tools/install_extra.sh kratos
tests kratos
step "OpenGeoSys" hosts-ogs tools/install_extra.sh ogs
tests ogs
tests mtest
step "OOFEM" hosts-oofem tools/install_extra.sh oofem
tests oofem
step "Akantu" hosts-akantu tools/install_extra.sh akantu
tests akantu
step "scikit-fem" hosts-python tools/install_extra.sh fe
tests python
step "FEniCSx" hosts-fenicsx harness/hosts/fenicsx/install.sh build/fenicsx
tests fenicsx
step "CalculiX" hosts-calculix harness/hosts/calculix/build.sh build/calculix
tests calculix
[ -z "$failed" ] || {
  echo "Failed hosts:$failed"
  exit 1
}
