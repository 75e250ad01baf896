#!/bin/sh
# release_test.sh: the sdist of the release, built and installed in a bare Debian root with compilers, and the fast tests
# of the installed package there (root, debootstrap).
set -eu
cd "$(dirname "$0")/.."
version=$(sed -n 's/.*public :: version = "\(.*\)"/\1/p' src/law/asperity_contract.f90)
out=build/release-$version
needed=$out/needed
(cd "$out" && sha256sum --check --quiet SHA256SUMS)
rm -rf "$needed"
# what building and testing need: pip reads it from the metadata of the wheel, and from [build-system]
build=$(sed -n 's/^requires = \[\(.*\)\]$/\1/p' pyproject.toml | tr -d '",')
# shellcheck disable=SC2086  # a list of words
.venv/bin/python -m pip download --quiet --only-binary :all: --dest "$needed" pip $build \
  "asperity[test] @ file://$(echo "$PWD/$out"/*.whl)"
rm "$needed"/asperity-*.whl
cp "$out/asperity-$version.tar.gz" "$needed"
tools/bare_root.sh python3,python3-dev,python3-venv,gcc,g++,gfortran,liblapack-dev,cmake,ninja-build,make "$needed" tools/release_commands.sh
rm -rf "$needed"
echo "the sdist builds in a bare root, and the tests of the installed package pass"
