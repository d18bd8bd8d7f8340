# `make demo` and `make test` do all the set-up themselves: Python 3.11 or later, git and make are enough.

PYTHON ?= $(shell for p in python3 python3.14 python3.13 python3.12 python3.11; do \
	$$p -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null && echo $$p && break; done)
VENV := .venv
BIN := $(VENV)/bin
PIP := $(BIN)/python -m pip --disable-pip-version-check --quiet
PLUGINS := $(patsubst %/pyproject.toml,%,$(wildcard plugins/*/pyproject.toml))
WHEELS = @$(PIP) install --no-compile -c constraints.txt setuptools && \
	{ $(BIN)/python tools/editables.py $(VENV)/wheels >$(VENV)/wheels.log 2>&1 || { cat $(VENV)/wheels.log; exit 1; }; }
RUNNABLE := $(VENV)/runnable
INSTALLED := $(VENV)/installed

# one run uses one thread; runs side by side use the cores
export OMP_NUM_THREADS ?= 1
export OPENBLAS_NUM_THREADS ?= 1
# modules are compiled when they are first imported, and kept: tests start many processes
unexport PYTHONDONTWRITEBYTECODE

.PHONY: demo slim smoke test faults fuzz mutants check-parts paper pages packages site lint bench clean

demo: $(RUNNABLE)
	@out=runs/demo; n=2; while [ -e $$out ] || [ -e $$out-accuracy ]; do out=runs/demo-$$n; n=$$((n + 1)); done; \
	$(BIN)/contactlab compare demo --out $$out-accuracy && echo && \
	$(BIN)/contactlab compare disc-on-block --set level=2 --set record.frames=44 --out $$out && echo && \
	echo "What accuracy costs: $$out-accuracy/accuracy.html" && echo "The report is $$out/report.html"

# a minute: a few tests of each area, no long run
SMOKE := tests/unit/scene tests/unit/meshing tests/unit/jobs/test_archive.py tests/unit/jobs/test_keys.py \
	tests/unit/accuracy/test_targets.py tests/architecture/test_layers.py tests/physics/test_contact_patch.py

smoke: $(INSTALLED)
	$(BIN)/python -m pytest -n 2 --dist worksteal -m "not full" $(SMOKE)

# FULL=1 adds what is marked `full`: what is long, and more variants of the same; TESTS=FOLDER chooses
test: $(INSTALLED)
	$(BIN)/python -m pytest -n auto --dist worksteal --durations=60 $(if $(FULL),,-m "not full") $(TESTS)

faults: $(INSTALLED)
	$(BIN)/python tests/abuse/faults.py $(FAULTS)

fuzz: $(INSTALLED)
	$(BIN)/python tests/abuse/fuzz.py $(FUZZ)

mutants: $(INSTALLED)
	$(BIN)/python tests/abuse/mutants.py $(MUTANTS)

check-parts: $(INSTALLED)
	$(BIN)/python tests/abuse/check_parts.py $(PARTS)

paper: $(INSTALLED)
	$(BIN)/python benchmarks/studies/paper/make.py

# pages of measured numbers into build/docs, from what is kept; CASES=FOLDER takes the rows of a matrix in it
# first, or draws the figures of `make paper`; DEMO=FOLDER those of the front page and its pictures
pages: $(INSTALLED)
	$(BIN)/python benchmarks/studies/pages.py $(CASES) $(DEMO)

# all wheels and source distributions into dist/, after they were built, looked into and run alone
packages: $(INSTALLED)
	$(PIP) install -c constraints.txt -e ".[publish]" --no-build-isolation
	CONTACTLAB_PACKAGES=full $(BIN)/python -m pytest tests/packaging
	@for p in . $(PLUGINS); do $(BIN)/python -m build --no-isolation --outdir dist $$p >/dev/null || exit 1; done; ls dist

# the site in build/site: pages of docs/, a gallery of scenes that are run for it, notebooks, the reference
site: $(INSTALLED)
	$(PIP) install -c constraints.txt -e ".[docs]" --no-build-isolation
	$(BIN)/python tools/site/make.py $(SITE)
	NO_MKDOCS_2_WARNING=1 $(BIN)/python -m mkdocs --quiet build --strict
	$(BIN)/python tools/site/links.py build/site
	@echo "The site is build/site/index.html"

lint: $(INSTALLED)
	$(PIP) install -c constraints.txt -e ".[lint]" --no-build-isolation
	$(BIN)/ruff check . && $(BIN)/ruff format --check . && $(BIN)/mypy

bench: $(INSTALLED)
	$(BIN)/python benchmarks/bench.py $(if $(QUICK),--quick)

# what runs need, and nothing for tests: `make demo` has no more. Modules are compiled when they are first imported:
# pip would compile all of them, one after the other, for longer than it takes to unpack them. Our own packages become
# editable wheels in one process (tools/editables.py), before pip has anything else to unpack; pip keeps a package
# whose version it knows, so that a second call puts entry points that changed into an environment that is there
$(RUNNABLE): constraints.txt pyproject.toml $(wildcard plugins/*/pyproject.toml)
	@test -n "$(PYTHON)" || { echo "contactlab needs Python 3.11 or later; set PYTHON=/path/to/python3"; exit 1; }
	@$(BIN)/python -m pip --version >/dev/null 2>&1 || { echo "creating $(VENV)"; $(PYTHON) -m venv --clear $(VENV); }
	@echo "installing contactlab and its plugins into $(VENV)"
	$(WHEELS)
	@$(if $(EARLY),$(PIP) install --no-compile --no-deps --no-warn-conflicts -c constraints.txt $(EARLY) & )\
	$(PIP) install --no-compile --no-warn-conflicts -c constraints.txt $(VENV)/wheels/*.whl && \
	$(PIP) install --no-compile --no-deps --no-warn-conflicts --force-reinstall $(VENV)/wheels/*.whl; done=$$?; wait; exit $$done
	@touch $@

# the program without the viewer (slim.txt), in an environment of its own
slim:
	@$(PYTHON) -m venv --clear $(VENV)
	$(WHEELS)
	@$(PIP) install --no-compile --no-deps -c constraints.txt --find-links $(VENV)/wheels -r slim.txt
	@echo "$(BIN)/contactlab runs everything but the viewer"

# what tests need is unpacked beside the rest, on the other core; the last call finds what is missing
$(INSTALLED): EARLY := distributed pandas pyvista vtk xarray
$(INSTALLED): $(RUNNABLE)
	@echo "installing what tests need"
	@$(PIP) install --no-compile -c constraints.txt --no-build-isolation -e ".[test]"
	@touch $@

clean:
	rm -rf $(VENV) build dist
