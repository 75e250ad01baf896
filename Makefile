# make demo    the paper's Figure 5(b), computed by the driver and drawn
# make check   lint, all builds and suites, coverage: what must pass
# Each installs what is missing first (cmake/install-dependencies.sh, pyproject.toml). Other targets: build (library and
# driver), the parts of check by name, bench, clean (build/), distclean (and .venv/).
# Variables: PYTHON, FLANG, PFUNIT_DIR (the folder of PFUNITConfig.cmake), JOBS.

JOBS ?= 2
export JOBS

venv := .venv/bin
step := cmake/step.sh
log = build/logs/$@.log
package_sources := pyproject.toml CMakeLists.txt $(wildcard cmake/*.cmake*) $(shell find src harness python -type f \
  -not -path '*/.*' -not -path '*/__pycache__/*')

# build, run and count all suites: $(call suites,CMake options)
suites = PYTHON=$(venv)/python cmake/build-and-test.sh build/$@ -DASPERITY_WERROR=ON \
  -DPython3_EXECUTABLE=$(CURDIR)/$(venv)/python $(1)
ifdef PFUNIT_DIR
export PFUNIT_DIR
pfunit := -DPFUNIT_DIR=$(PFUNIT_DIR)
endif

.NOTPARALLEL:
.PHONY: build demo check lint test debug sanitize flang coverage pytest bench dependencies clean distclean

build: dependencies
	@$(step) "Release build" $(log) sh -ec 'cmake -S . -B build/release -G Ninja -DASPERITY_TESTS=OFF; \
	  cmake --build build/release --parallel $(JOBS); echo build/release'

demo: build .venv/installed
	@mkdir -p build/demo
	@$(step) "Figure 5(b): sigma_N = -10 MPa, 30 degrees" $(log) env ASPERITY_DRIVER=build/release/harness/rie_driver \
	  $(venv)/asperity run harness/cases/figure05b.nml -o build/demo/figure05b.csv --plot build/demo/figure05b.png
	@$(venv)/python cmake/demo_numbers.py build/demo/figure05b.csv

check: lint test debug sanitize flang coverage pytest
	@echo "make check: everything passed"

lint: .venv/installed
	@$(step) "Lint: Fortran" build/logs/lint-fortran.log $(venv)/fortitude check src harness tests
	@$(step) "Lint: Python" build/logs/lint-python.log $(venv)/ruff check .

test: .venv/installed
	@$(step) "Release: suites" $(log) env $(call suites,$(pfunit) -DCMAKE_BUILD_TYPE=Release)

debug: .venv/installed
	@$(step) "Debug, bounds, FPE traps, sNaN: suites" $(log) env $(call suites,$(pfunit) -DCMAKE_BUILD_TYPE=Debug)

sanitize: .venv/installed
	@$(step) "Address and undefined sanitizer: suites" $(log) env $(call suites,$(pfunit) -DCMAKE_BUILD_TYPE=Debug \
	  -DASPERITY_SANITIZE=address$(,)undefined)

flang: .venv/installed
	@flang="$$(cmake/flang.sh)"; \
	if [ -z "$$flang" ]; then echo "flang: not installed, left out"; else \
	  $(step) "flang: suites" $(log) env $(call suites,$$flang -DCMAKE_DISABLE_FIND_PACKAGE_PFUNIT=ON); fi

coverage: .venv/installed
	@$(step) "Coverage of src/" $(log) sh -ec 'find build/$@ -name "*.gcda" -delete 2>/dev/null || true; \
	  $(call suites,$(pfunit) -DCMAKE_BUILD_TYPE=Debug -DASPERITY_COVERAGE=ON); $(venv)/python cmake/coverage.py build/$@'

pytest: .venv/installed
	@$(step) "Python tests" $(log) env ASPERITY_DRIVER="$$($(venv)/python -c 'from asperity.installed import driver; print(driver())')" \
	  $(venv)/python -m pytest --numprocesses $(JOBS) --junitxml=build/pytest/junit.xml

dependencies:
	@$(step) "System packages" $(log) cmake/install-dependencies.sh

.venv/bin/python: | dependencies
	@$(step) "Python environment" build/logs/venv.log sh -ec '"$$(cmake/python.sh)" -m venv .venv; $@ --version'

# the package and its tools, installed anew when a source has changed
.venv/installed: .venv/bin/python $(package_sources) | dependencies
	@$(step) "Python package and tools" build/logs/install.log \
	  sh -ec '$(venv)/pip install --config-settings=build-dir=build/python ".[dev]"; touch $@; echo .venv'

clean:
	rm -rf build

distclean: clean
	rm -rf .venv

, := ,
