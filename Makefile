# make help    this text
# make demo    the paper's Figure 5(b), computed by the driver and drawn
# make test    Release suites and the fast Python tests: a minute, for those who are editing
# make check   lint, all builds and suites, coverage, all Python tests: what must pass
# make hosts   the library inside Kratos, OpenGeoSys, OOFEM, Akantu, FEniCSx, scikit-fem, CalculiX, MTest: tests
# Each installs what is missing first (tools/install-dependencies.sh, pyproject.toml). Other targets: build (library and
# driver), windows (the same for Windows, tried under wine), the parts of check by name, bench, soak (long runs), mutants
# (which changes of the library do the tests notice?), wheel (sdist and wheel, tried in a bare Debian root), release
# (these and the sources for Abaqus, from a clean clone), site (the pages as a web site) and site-test (its tests in
# Chromium), clean (build/), distclean (and .venv/). What has passed runs again when a file has changed. Variables:
# PYTHON, FLANG, JOBS, PFUNIT_DIR (of PFUNITConfig.cmake), ADDRESS (of the repository, for release). CMakePresets.json
# names the builds; what a step printed is in build/logs.
ifneq ($(words $(CURDIR)),1)
$(error $(CURDIR): expected a path without spaces (make splits it))
endif
export JOBS ?= 2

# two steps at a time: each has parts in which it keeps one core busy at most
side_by_side = $(MAKE) --no-print-directory --jobs=2 --output-sync=target

builds := suites debug flang
parts := pytest lint $(builds) coverage
passed := build/passed
venv := .venv/bin
step := tools/step.sh
log = build/logs/$(@F).log
done = @mkdir -p $(@D) && touch $@

# what the builds depend on, what the Python package holds, and everything
files = $(shell find $(1) -type f -not -path '*/.*' -not -name '*.pyc')
native := CMakeLists.txt cmake src $(filter-out %/studies,$(wildcard harness/*))
code := $(call files,$(native) CMakePresets.json Makefile tools \
  $(filter-out %/python %/oracle,$(wildcard tests/*)))
package := $(call files,$(native) pyproject.toml python)
c_files = $(filter %.c %.h %.cpp,$(call files,src harness tests))
tree := $(wildcard .ci/* .github/* .github/*/*) $(call files,$(filter-out build%,$(wildcard *)))

.DELETE_ON_ERROR:
.PHONY: build help demo test check $(parts) bench soak mutants hosts windows site site-test wheel release dependencies clean distclean force

build: dependencies
	@$(step) "Release build" $(log) sh -ec 'cmake --preset release; cmake --build build/release --parallel $(JOBS); \
	  echo build/release'
help:
	@sed '/^[^#]/Q; s/^# //' Makefile
demo: .venv/installed
	@mkdir -p build/demo
	@$(venv)/asperity run harness/cases/figure05b.nml -o build/demo/figure05b.csv --force --plot build/demo/figure05b.png
test:
	@$(side_by_side) $(passed)/suites $(passed)/fast
check:
	@$(side_by_side) $(parts)
	@echo "make check: everything passed"

$(parts): %: $(passed)/%
$(passed)/lint: $(tree) | .venv/installed
	@$(step) "Lint: Fortran" build/logs/lint-fortran.log $(venv)/fortitude check src harness tests
	@$(step) "Lint: Python" build/logs/lint-python.log sh -ec '$(venv)/ruff check .; $(venv)/ruff format --check .'
	@$(step) "Lint: C" build/logs/lint-c.log sh -ec '$(venv)/clang-format --dry-run --Werror $(c_files)'
	@$(step) "Types: Python" build/logs/types.log $(venv)/mypy
	@$(step) "Lint: layers of the package" build/logs/lint-imports.log env PYTHONPATH=python $(venv)/lint-imports --no-cache
	@$(step) "Lint: YAML" build/logs/lint-yaml.log $(venv)/yamllint --strict .
	$(done)
$(builds:%=$(passed)/%): $(passed)/%: $(code) build/options | .venv/installed
	@$(step) "$$(cmake --list-presets | sed -n 's/.*"$*" *- //p')" $(log) tools/build-and-test.sh $*
	$(done)
$(passed)/coverage: $(passed)/debug | .venv/installed
	@$(step) "Coverage of src/ by these suites" $(log) $(venv)/python tools/coverage.py build/debug
	$(done)
$(passed)/pytest: selection := -m "not long" --junitxml=build/pytest/junit.xml
$(passed)/fast: selection := -m "not slow and not long"
$(passed)/pytest $(passed)/fast: $(tree) build/options .venv/installed
	@$(step) "Python tests" $(log) env PYTHONDONTWRITEBYTECODE= $(venv)/python -m pytest --numprocesses $(JOBS) --dist worksteal $(selection)
	$(done)
build/options: force
	@mkdir -p build; echo "$(FLANG) $(PFUNIT_DIR)" >$@.new; cmp -s $@.new $@ && rm $@.new || mv $@.new $@

bench: build
	@build/release/bin/bench
soak: build .venv/installed
	@tools/soak.sh
mutants: .venv/installed
	@$(venv)/python tools/mutants.py
hosts: .venv/installed
	@tools/hosts.sh
windows: .venv/installed
	@$(step) "Windows by MinGW-w64, under wine" $(log) tools/windows.sh
	@$(step) "Wheel for Windows, under wine" build/logs/windows-wheel.log tools/windows_wheel.sh

wheel: .venv/installed
	@$(step) "sdist and wheel" $(log) tools/wheel.sh
	@$(step) "Wheel in a bare Debian root" build/logs/wheel-test.log tools/wheel_test.sh
release: .venv/installed
	@$(step) "Release from a clean clone" $(log) tools/release.sh
	@$(step) "sdist in a bare Debian root" build/logs/release-test.log tools/release_test.sh

site:
	@$(step) "System packages" build/logs/site-packages.log tools/install-dependencies.sh site
	@$(step) "Site" $(log) tools/site/build.sh
	@echo "to read it: python3 -m http.server --directory build/site"
site-test: site
	@$(step) "Tests of the site" build/logs/site-tests.log build/site-tools/site/bin/python -m pytest -q \
	  --junitxml=build/site-tools/junit.xml tests/site

dependencies:
	@$(step) "System packages" $(log) tools/install-dependencies.sh
.venv/installed: $(package) | dependencies
	@$(step) "Python package and tools" build/logs/install.log tools/install-package.sh
clean:
	rm -rf build
distclean: clean
	rm -rf .venv
