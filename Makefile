# make demo    the paper's Figure 5(b), computed by the driver and drawn
# make check   lint, all builds and suites, coverage: what must pass
# make hosts   the library inside Kratos, scikit-fem and CalculiX: tests and pictures; says what this machine cannot get
# Each installs what is missing first (tools/install-dependencies.sh, pyproject.toml). Other targets: build (library and
# driver), the parts of check by name, bench, soak (long runs: fuzz, threads, solver), clean (build/), distclean (and
# .venv/). What has passed runs again when a file has changed. Variables: PYTHON, FLANG, PFUNIT_DIR (the folder of
# PFUNITConfig.cmake), JOBS.

ifneq ($(words $(CURDIR)),1)
$(error $(CURDIR): expected a path without spaces (f2py splits it))
endif

JOBS ?= 2
export JOBS
ifdef PFUNIT_DIR
export PFUNIT_DIR
pfunit := -DPFUNIT_DIR=$(PFUNIT_DIR)
else
pfunit := -UPFUNIT_DIR
endif

stand_in := -UPFUNIT_DIR -DCMAKE_DISABLE_FIND_PACKAGE_PFUNIT=ON

venv := .venv/bin
step := tools/step.sh
log = build/logs/$(@F).log
done = @mkdir -p $(@D) && touch $@

# what the builds depend on, what the Python package holds, and everything
code := CMakeLists.txt Makefile $(shell find cmake tools src harness tests -type f -not -path '*/.*' \
  -not -path 'tests/python/*' -not -name '*.pyc')
package := pyproject.toml CMakeLists.txt $(wildcard cmake/*.cmake*) \
  $(shell find src harness python -type f -not -path '*/.*' -not -name '*.pyc')
tree := $(wildcard .ci/*) $(shell find . -type f -not -path './build*' -not -path '*/.*' -not -name '*.pyc')

# build, run and count all suites: $(call suites,CMake options)
suites = PYTHON=$(venv)/python tools/build-and-test.sh build/$(@F) \
  -DPython3_EXECUTABLE="$(CURDIR)/$(venv)/python" $(1)
comma := ,

parts := lint test wide debug sanitize flang coverage pytest
.NOTPARALLEL:
.DELETE_ON_ERROR:
.PHONY: build demo check $(parts) bench hosts soak dependencies clean distclean force

build: dependencies
	@$(step) "Release build" $(log) sh -ec 'cmake -S . -B build/release -G Ninja -DASPERITY_TESTS=OFF; \
	  cmake --build build/release --parallel $(JOBS); echo build/release'

demo: build .venv/installed
	@mkdir -p build/demo
	@$(step) "Figure 5(b): sigma_N = -10 MPa, 30 degrees" $(log) env ASPERITY_DRIVER=build/release/harness/rie_driver \
	  $(venv)/asperity run harness/cases/figure05b.nml -o build/demo/figure05b.csv --plot build/demo/figure05b.png
	@$(venv)/python tools/demo_numbers.py build/demo/figure05b.csv

check: $(parts)
	@echo "make check: everything passed"

$(parts): %: build/passed/%

build/passed/lint: $(tree) | .venv/installed
	@$(step) "Lint: Fortran" build/logs/lint-fortran.log $(venv)/fortitude check src harness tests
	@$(step) "Lint: Python" build/logs/lint-python.log $(venv)/ruff check .
	$(done)

build/passed/test: $(code) build/options | .venv/installed
	@$(step) "Release, no warnings: suites" $(log) env $(call suites,$(pfunit) -DCMAKE_BUILD_TYPE=Release -DASPERITY_WERROR=ON)
	$(done)

# products and sums are fused there, and the vectors are longer
build/passed/wide: $(code) build/options | .venv/installed
	@if grep -qsw avx2 /proc/cpuinfo && grep -qsw fma /proc/cpuinfo; then \
	  $(step) "x86-64-v3 (AVX2, FMA): suites of the law" $(log) env SUITES="test_same_results test_block test_points" \
	  $(call suites,$(pfunit) -DCMAKE_BUILD_TYPE=Release -DASPERITY_WERROR=ON -DASPERITY_ARCH=x86-64-v3); \
	  else echo "x86-64-v3: not this processor, left out"; fi
	$(done)

build/passed/debug: $(code) build/options | .venv/installed
	@$(step) "Debug, bounds, FPE traps, sNaN: suites" $(log) env $(call suites,$(pfunit) -DCMAKE_BUILD_TYPE=Debug \
	  -DASPERITY_WERROR=ON)
	$(done)

# on the stand-in: pFUnit's argument parser leaks, and its module files are gfortran's
build/passed/sanitize: $(code) build/options | .venv/installed
	@$(step) "Address and undefined sanitizer: suites" $(log) env $(call suites,$(stand_in) -DCMAKE_BUILD_TYPE=Debug \
	  -DASPERITY_SANITIZE=address$(comma)undefined)
	$(done)

build/passed/flang: $(code) build/options | .venv/installed
	@flang="$$(tools/flang.sh)"; if [ -z "$$flang" ]; then echo "flang: not installed, left out"; else \
	  $(step) "flang: suites" $(log) env $(call suites,$$flang $(stand_in)); fi
	$(done)

build/passed/coverage: $(code) build/options tools/coverage.py | .venv/installed
	@$(step) "Coverage of src/" $(log) sh -ec 'mkdir -p build/$(@F); find build/$(@F) -name "*.gcda" -delete; \
	  $(call suites,$(pfunit) -DCMAKE_BUILD_TYPE=Coverage -DASPERITY_COVERAGE=ON); \
	  $(venv)/python tools/coverage.py build/$(@F)'
	$(done)

build/passed/pytest: $(tree) build/options .venv/installed
	@$(step) "Python tests" $(log) sh -ec 'ASPERITY_DRIVER="$$($(venv)/python -c \
	  "from asperity.installed import driver; print(driver())")" $(venv)/python -m pytest --numprocesses $(JOBS) --junitxml=build/pytest/junit.xml'
	$(done)

build/options: force
	@mkdir -p build; echo "$(FLANG) $(PFUNIT_DIR)" >$@.new; cmp -s $@.new $@ && rm $@.new || mv $@.new $@

bench: build
	@build/release/harness/bench

# every program of harness/soak in turn, with its long run
soak: build
	@status=0; for program in build/release/harness/soak/*; do "$$program" || status=1; done; exit $$status

# Kratos and scikit-fem come as wheels, CalculiX as Debian's source package (once, build/calculix), which takes longest and
# is last. One run and one report (build/hosts/*.xml) a host; pytest ends with 5 where all tests of a host are left out.
hosts := ASPERITY_KRATOS=build/hosts/harness/hosts/libasperity_kratos.so ASPERITY_LIBRARY=build/hosts/src/libasperity.so \
  ASPERITY_CALCULIX=build/calculix
extra = $(venv)/python -c "import $(1)" || $(venv)/python tools/install_extra.py $(2) || \
	  { echo "no wheels here, left out"; exit 0; }; echo there
define host_tests
@$(step) "Tests: $(1)" build/logs/hosts-$(1)-tests.log sh -c 'env $(hosts) $(venv)/python -m pytest -rA \
	  --junitxml=build/hosts/$(1).xml harness/hosts/$(1) || [ $$? = 5 ]' || \
	  (grep "^FAILED" build/logs/hosts-$(1)-tests.log; exit 1)
@grep "^SKIPPED" build/logs/hosts-$(1)-tests.log || true
endef
hosts: .venv/installed
	@rm -f build/hosts/*.xml
	@$(step) "Library and adapter for the hosts" $(log) sh -ec 'cmake -S . -B build/hosts -G Ninja -DASPERITY_TESTS=OFF \
	  -DASPERITY_HOSTS=ON; cmake --build build/hosts --parallel $(JOBS) --target asperity_kratos_adapter; echo build/hosts'
	@$(step) "Kratos" build/logs/hosts-kratos.log sh -c '$(call extra,KratosMultiphysics.GeoMechanicsApplication,kratos)'
	$(call host_tests,kratos)
	@$(step) "scikit-fem" build/logs/hosts-python.log sh -c '$(call extra,skfem$(comma) scipy,fe)'
	$(call host_tests,python)
	@$(step) "CalculiX" build/logs/hosts-calculix.log sh -c 'harness/hosts/calculix/build.sh build/calculix; code=$$?; \
	  [ $$code = 77 ] || exit $$code'
	$(call host_tests,calculix)
	@$(step) "Pictures" build/logs/hosts-pictures.log env $(hosts) harness/hosts/pictures.sh $(venv)/python build/hosts

dependencies:
	@$(step) "System packages" $(log) tools/install-dependencies.sh

.venv/bin/python: | dependencies
	@$(step) "Python environment" build/logs/venv.log sh -ec '"$$(tools/python.sh)" -m venv .venv; $@ --version'

# the package and its tools, installed anew when a source has changed
.venv/installed: .venv/bin/python $(package) | dependencies
	@$(step) "Python package and tools" build/logs/install.log \
	  sh -ec '$(venv)/pip install --config-settings=build-dir=build/python ".[dev]"; touch $@; echo .venv'

clean:
	rm -rf build

distclean: clean
	rm -rf .venv
