PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
PYTEST = $(BIN)/python -m pytest -q -n 2
OLDEST := $(VENV)-oldest
WHEEL := $(VENV)-wheel
# tests of rooms that have kernels; the others would run the same Python twice
KERNELS := $(addprefix tests/, analyses elements equations jit language solvers)
# rooms whose packages the others meet too, which show what is too old
ALIKE := $(addprefix --ignore=tests/, analyses catalogue description durability elements equations exchange foreign heat \
	language pages sketch solvers strength studio) \
	$(addprefix --ignore=tests/test_, docs.py examples.py examples_of_machines.py messages.py pages.py \
	random_mechanisms.py words.py wrong_arguments.py) --ignore=tests/results/test_breaks.py \
	$(patsubst %,--ignore=tests/studies/test_%_side_by_side.py, contacts rubbing switches)
SPHINX = $(BIN)/python -m sphinx -q -W --keep-going -b html -d build/doctrees docs build/docs

# tests start Python hundreds of times: what it has compiled is kept
unexport PYTHONDONTWRITEBYTECODE

.DEFAULT_GOAL := help
.NOTPARALLEL:
.PHONY: help demo test check proofs wheel engine signatures long times docs coverage bench clean

help: ## this list
	@sed -n 's/^\([a-z]*\):.*## \(.*\)/  make \1\t\2/p' Makefile | expand -t 18

demo: $(VENV)/.ready-data ## install into .venv, run `rattle demo`
	$(BIN)/rattle demo

test: $(VENV)/.ready-dev check ## install into .venv, run all checks that are quick (under 5 minutes)

check: ## the same without the set-up
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/lint-imports --no-logo
	RATTLE_JIT=python $(BIN)/python -m pytest -q tests/elements -k contracts
	$(PYTEST) --part quick

proofs: $(VENV)/.ready-dev ## all other tests: slow ones, browsers, plain Python, documentation, oldest packages
	$(SPHINX) & documented=$$!; $(MAKE) $(VENV)/.ready-oldest wheel && wait $$documented
	RATTLE_JIT=python $(PYTEST) $(KERNELS) -k "not contracts"
	RATTLE_BOUNDSCHECK=1 $(PYTEST) tests/jit/test_every_loop.py tests/jit/test_bounds.py
	$(OLDEST)/bin/python -m pytest -q -n 2 --part quick $(ALIKE)
	$(PYTEST) --part rest

engine: $(VENV)/.ready-dev ## build the kernels for pages: src/rattle/pages/*.wasm.gz
	$(BIN)/python -m rattle.pages.engine src/rattle/pages

signatures: $(VENV)/.ready-dev ## write the methods that questions add for editors and mypy: src/rattle/asked.pyi
	$(BIN)/python -m rattle.signatures
	$(BIN)/ruff check --quiet --fix --select I src/rattle/asked.pyi && $(BIN)/ruff format --quiet src/rattle/asked.pyi

wheel: engine ## build wheel and sdist, install each into an empty environment and run it
	rm -rf build/dist build/installed
	$(BIN)/python -m hatchling build -d build/dist
	$(PYTHON) -m venv --clear $(WHEEL)
	$(WHEEL)/bin/pip install --quiet --disable-pip-version-check build/dist/*.whl
	$(WHEEL)/bin/rattle -q demo -o build/installed
	$(WHEEL)/bin/rattle -q page slider_crank -o build/installed/page.html
	$(WHEEL)/bin/rattle -q ensemble slider_crank -n 64 --vary "rod_length=0.1 mm" --of "max(slider.ax)" --analysis kinematics
	$(WHEEL)/bin/pip install --quiet --disable-pip-version-check --force-reinstall --no-deps build/dist/*.tar.gz
	$(WHEEL)/bin/rattle -q demo --paper -o build/installed

long: $(VENV)/.ready-dev ## proofs that take a minute or more each
	$(BIN)/python -m pytest -q -m long -o faulthandler_timeout=3600

times: $(VENV)/.ready-dev ## measure which tests are quick: tests/measured.txt
	$(PYTEST) -m "not long" --measure

docs: $(VENV)/.ready-docs ## the documentation as web pages: build/docs/index.html
	$(SPHINX)

coverage: $(VENV)/.ready-dev ## lines of the package that the tests reach, machine code off
	RATTLE_JIT=python $(BIN)/coverage run -m pytest -q
	$(BIN)/coverage report

bench: $(VENV)/.ready-bench ## speed, as ratios to yardsticks measured in the same run
	OPENBLAS_NUM_THREADS=1 $(BIN)/python benchmarks/run.py --keep docs/making/scoreboard.toml

clean: ## remove .venv and everything made here
	rm -rf $(VENV) $(OLDEST) $(WHEEL) build dist docs/generated .*_cache .benchmarks .coverage .hypothesis rattle-demo
	find . -name __pycache__ -type d -prune -exec rm -rf {} +

# one stamp per set of extras; a change of pyproject.toml installs anew
extras-data := data
extras-dev := dev,data
extras-docs := docs,data
extras-bench := bench,data
$(VENV)/.ready-%: pyproject.toml
	@$(PYTHON) -c 'import sys; sys.version_info >= (3, 11) or sys.exit("rattle needs Python 3.11 or newer, this is " + sys.version.split()[0] + "; name another one: make PYTHON=python3.12 ...")'
	@test -x $(BIN)/pip || $(PYTHON) -m venv --clear $(VENV)
	$(BIN)/pip install --quiet --disable-pip-version-check --editable '.[$(extras-$*)]'
	@touch $@

# the oldest version of everything that the package may be installed with
$(VENV)/.ready-oldest: pyproject.toml tests/oldest.txt
	@$(PYTHON) -m venv --clear $(OLDEST)
	$(OLDEST)/bin/pip install --quiet --disable-pip-version-check --constraint tests/oldest.txt --editable '.[data,test]'
	@touch $@
