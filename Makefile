# Everything runs in the private environment .venv: needs python3 >= 3.10 with venv, g++ >= 11, bash, make and git.
# `make V=1 …` shows all of the compiler's and pip's output, `make test PYTEST_ARGS="-k heavy"` passes options to pytest.

PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin
BUILD  := build/release
PIP    := $(BIN)/python -m pip --disable-pip-version-check

# What pip and Ninja print, cut down to a line for each package and each compiled file; the whole is in the log.
SHELL       := bash
.SHELLFLAGS := -o pipefail -c
PACKAGES    := $(if $(V),cat,sed -u -n -e 's/^ *Downloading \([^ ]*\.whl\)\( (.*)\)\{0,1\}$$/  download \1\2/p' \
               -e 's/^ *Using cached \([^ ]*\.whl\) .*/  cached   \1/p' -e 's/^Installing collected packages.*/  installing/p')
STEPS       := $(if $(V),cat,sed -u -n -E -e 's/^ *(\[[0-9]+\/[0-9]+\]) (Building [A-Z]+ object (CMakeFiles\/[^\/]+\.dir\/)?|Linking [A-Z]+ [a-z ]+ )/  \1 /p' \
               -e 's/^ *(\[[0-9]+\/[0-9]+\] (Packing|Writing|Bundling) .*)/  \1/p' -e 's/^ *(viewer: .*)/  \1/p')
SAVED        = 2>&1 | tee $(LOG)
OR_TELL      = || { tail -n 40 $(LOG); echo "failed; $(LOG) has all of it"; exit 1; }

# Stamps: a step runs again only when something it reads has changed.
SETUP := $(VENV)/.setup
BUILT := $(BUILD)/.installed

SOURCE_DIRS := fmu_src models modelDescription tools
BUILD_FILES := CMakeLists.txt cmake pyproject.toml README.md LICENSE tests/references docs/mechanisms.md docs/fmi.md docs/method.md
SOURCES := $(shell find $(BUILD_FILES) $(SOURCE_DIRS) -name __pycache__ -prune -o -print 2>/dev/null)
CPP      = $(shell find $(SOURCE_DIRS) tests -name '*.h' -o -name '*.cpp' -o -name '*.c')

# CMake presets find the tools, Eigen and the FMI headers of the private environment.
IN_VENV := VIRTUAL_ENV="$(CURDIR)/$(VENV)" PATH="$(CURDIR)/$(BIN):$$PATH"
TSAN     = $(shell $(CXX) -print-file-name=libtsan.so)
ASAN     = $(shell $(CXX) -print-file-name=libasan.so) $(shell $(CXX) -print-file-name=libubsan.so)

.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
.PHONY: help setup build demo test test-masters release test-release test-asan test-tsan lint tidy format clean
.PHONY: bench docs measure study references wheel release-check

help: ## print the targets
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "  make %-12s %s\n", $$1, $$2 }' $(MAKEFILE_LIST)

setup: $(SETUP) ## make the private environment .venv
build: $(BUILT) ## build the FMUs into build/release/fmus and install the Python package into .venv

$(SETUP): LOG := build/setup.log
$(SETUP): pyproject.toml tools/requirements.py
	@echo "setup: private environment $(VENV) (packages from PyPI, 1.4 GB)"
	@mkdir -p build
	@test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	@$(PIP) install -q --upgrade pip
	@$(BIN)/python tools/requirements.py > $(VENV)/requirements.txt
	@$(PIP) install -r $(VENV)/requirements.txt $(SAVED) | $(PACKAGES) $(OR_TELL)
	@echo "$(CURDIR)/tools" > "$$($(BIN)/python -c 'import sysconfig; print(sysconfig.get_path("purelib"))')/research.pth"
	@touch $@

$(BUILT): LOG := build/build.log
$(BUILT): $(SETUP) $(SOURCES)
	@echo "build: FMUs -> $(BUILD)/fmus, Python package -> $(VENV) (minutes the first time)"
	@$(IN_VENV) $(PIP) install -v --no-build-isolation --no-deps --config-settings=build-dir=$(BUILD) \
	  --config-settings=cmake.define.SIGMAFMU_WERROR=$(if $(CI),ON,OFF) . $(SAVED) | $(STEPS) $(OR_TELL)
	@for model in $$(ls $(BUILD)/fmu); do \
	  sed -n "s|.*<DegreesOfFreedom value=\"\(.*\)\"/>|build: $$model: degrees of freedom: \1|p" $(BUILD)/fmu/$$model/tree/modelDescription.xml; done
	@touch $@

demo: build ## run HeavyTop and SliderCrank, compare with the reference, draw plots into demo/
	@echo "demo: HeavyTop and SliderCrank through FMPy"
	@$(BIN)/sigmafmu demo --output demo

test: build ## run every test
	@echo "test: pytest"
	@$(BIN)/python -m pytest -n auto $(PYTEST_ARGS)

test-masters: build ## run the FMUs in the tools that need Java (skipped where it is missing)
	@echo "test-masters: Maestro, VDMCheck2"
	@SIGMAFMU_TOOLS="$(CURDIR)/build/tools" $(BIN)/python -m pytest -m heavy tests/masters $(PYTEST_ARGS)

release: build ## compile the FMUs' sources for old Linux distributions and for Windows -> dist
	@echo "release: FMUs with binaries for linux64 (glibc 2.17) and win64 -> dist"
	@$(PIP) install -q --group release
	@$(IN_VENV) $(BIN)/python tools/release.py $(BUILD) dist

RELEASE_QUICK := tests/fmu/test_accuracy.py tests/fmu/test_state.py tests/fmu/test_steps.py

test-release: release ## run the tests of the released FMUs; QUICK=1: some
	@echo "test-release: pytest on the FMUs in dist"
	@$(BIN)/python -m pytest -n auto -m "release$(if $(QUICK), and not slow)" $(PYTEST_ARGS)
	@SIGMAFMU_FMUS="$(CURDIR)/dist" $(BIN)/python -m pytest -n auto $(if $(QUICK),$(RELEASE_QUICK),tests/fmu) $(PYTEST_ARGS)

wheel: build ## make the wheel for all platforms -> dist; half an hour on one core the first time
	@echo "wheel: linux64, aarch64-linux, win64 and darwin64 -> dist"
	@$(PIP) install -q --group release
	@$(IN_VENV) $(BIN)/python tools/release.py $(BUILD) build/universal --wheel
	@rm -f dist/*.whl
	@SIGMAFMU_ALL_PLATFORMS=1 $(IN_VENV) $(BIN)/python -m build --wheel --no-isolation --outdir dist . > build/wheel.log \
	  || { tail -n 40 build/wheel.log; exit 1; }
	@ls -sh dist/*-py3-none-any.whl

release-check: wheel ## everything for a release but the upload: wheel, source distribution, metadata, tests of both
	@echo "release-check: source distribution, metadata, tests of the wheel"
	@rm -f dist/*.tar.gz
	@$(IN_VENV) $(BIN)/python -m build --sdist --no-isolation --outdir dist . > build/sdist.log \
	  || { tail -n 40 build/sdist.log; exit 1; }
	@$(BIN)/python -m twine check --strict dist/*.whl dist/*.tar.gz
	@$(BIN)/python -m pytest -m distribution tests/release $(PYTEST_ARGS)

test-tsan: build ## run FMU instances in threads under the thread sanitizer
	@echo "test-tsan: FMUs with the thread sanitizer -> build/tsan/fmus"
	@$(IN_VENV) cmake --preset tsan
	@$(IN_VENV) cmake --build --preset tsan
	@SIGMAFMU_FMUS="$(CURDIR)/build/tsan/fmus" LD_PRELOAD="$(TSAN)" TSAN_OPTIONS=halt_on_error=1 \
	 setarch -R $(BIN)/python -m pytest tests/fmu/test_instances.py -k thread $(PYTEST_ARGS)

# The whole Python package with what is compiled under sanitizers: PYTHONPATH puts it before the installed one.
ASAN_PACKAGE := build/asan/python
ASAN_QUICK   := tests/fmu/test_flexible.py tests/fmu/test_steps.py \
                tests/core/test_system.py tests/core/test_joints.py tests/core/test_flexible.py tests/core/test_runs.py \
                tests/core/test_mechanism_fuzz.py

test-asan: build ## run FMU and core tests under the address and undefined-behaviour sanitizers; QUICK=1: some
	@echo "test-asan: FMUs and Python package with sanitizers and assertions -> $(ASAN_PACKAGE)"
	@$(IN_VENV) cmake --preset asan
	@$(IN_VENV) cmake --build --preset asan
	@rm -rf $(ASAN_PACKAGE) && mkdir -p $(ASAN_PACKAGE) && cp -r tools/sigmafmu $(ASAN_PACKAGE)
	@cp -r models/resources $(ASAN_PACKAGE)/sigmafmu
	@mkdir $(ASAN_PACKAGE)/sigmafmu/texts
	@cp --parents LICENSE docs/fmi.md docs/mechanisms.md docs/method.md $(ASAN_PACKAGE)/sigmafmu/texts
	@$(IN_VENV) cmake --install build/asan --prefix $(ASAN_PACKAGE) > /dev/null
	@PYTHONPATH="$(CURDIR)/$(ASAN_PACKAGE)" LD_PRELOAD="$(ASAN)" PYTHONMALLOC=malloc \
	 ASAN_OPTIONS=detect_leaks=0 UBSAN_OPTIONS=halt_on_error=1:print_stacktrace=1 \
	 $(BIN)/python -m pytest -n auto $(if $(QUICK),-m "not slow and not heavy and not release" $(ASAN_QUICK),tests/fmu tests/core) \
	 $(PYTEST_ARGS)

lint: $(SETUP) ## check style and types: ruff, clang-format, biome and mypy
	@echo "lint: ruff, clang-format, biome, mypy"
	@$(BIN)/ruff check --quiet
	@$(BIN)/ruff format --quiet --check
	@$(if $(CPP),$(BIN)/clang-format --dry-run --Werror $(CPP))
	@$(BIN)/python tools/viewer/build.py check
	@$(BIN)/mypy --no-error-summary

TIDY := build/tidy/clang_tidy/data/bin/clang-tidy

tidy: build $(TIDY) ## look for mistakes in the C++ sources: clang-tidy, minutes
	@echo "tidy: clang-tidy on every C++ file of the build"
	@find $(SOURCE_DIRS) -name '*.cpp' -print0 | xargs -0 -n 1 -P $$(nproc) $(TIDY) --quiet -p $(BUILD)

$(TIDY): pyproject.toml | $(SETUP)
	@$(PIP) install -q --upgrade --target build/tidy --group tidy
	@touch $@

format: $(SETUP) ## bring all sources into that style
	@echo "format: ruff, clang-format, biome"
	@$(BIN)/ruff check --quiet --fix
	@$(BIN)/ruff format --quiet
	@$(if $(CPP),$(BIN)/clang-format -i $(CPP))
	@$(BIN)/python tools/viewer/build.py format

# tools/research, which setup has put on the path of the private environment
RESEARCH := $(BIN)/python -m research

bench: build ## time steps beside Exudyn, MuJoCo, Pinocchio, sparse solvers -> docs/speed.md; QUICK=1: a minute, into build/bench
	@echo "bench: what steps cost (the first time 0.3 GB of packages, 1 GB in $(VENV))"
	@$(PIP) install -q --group bench
	@$(IN_VENV) cmake --build $(BUILD) --target eigen_sparse_lu > build/bench.log || { cat build/bench.log; exit 1; }
	@$(RESEARCH) bench $(if $(QUICK),--quick --output build/bench/speed.md)

measure: build ## measure orders, errors and energies -> docs/accuracy.md
	@echo "measure: orders, errors, energies"
	@$(RESEARCH) measure --output docs/accuracy.md

study: build ## the σ study: every method beside the paper and Exudyn -> build/study; QUICK=1: small
	@echo "study: methods beside the paper and Exudyn"
	@$(RESEARCH) study all $(if $(QUICK),--quick --output build/study-quick,--output build/study)
	@$(if $(QUICK),,cp $(patsubst docs/%,build/%,$(wildcard docs/study/*)) docs/study) # those that pages show

references: build ## make tests/references again, with Exudyn and in minimal coordinates
	@echo "references: Exudyn, minimal coordinates"
	@$(RESEARCH) references

# tools/docs_site.py takes only links that lead to files; zensical warns of pages and headings that are not there.
docs: $(SETUP) ## make the documentation site -> build/site, with strict links
	@echo "docs: README.md and docs -> build/site (the first time 0.1 GB of packages in $(VENV))"
	@$(PIP) install -q --group docs
	@$(BIN)/python tools/docs_site.py build/pages
	@$(BIN)/zensical build --clean --strict

clean: ## remove what the other targets made
	@echo "clean: $(VENV), build, demo and caches"
	@rm -rf $(VENV) build demo dist .cache .pytest_cache .ruff_cache .hypothesis
	@find $(SOURCE_DIRS) tests -name __pycache__ -prune -exec rm -rf {} + 2>/dev/null || true
