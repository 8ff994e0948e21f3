# make demo    makes .venv, installs gough, runs the main example, says where the report is
# make test    the tests; make check: lint and the quick tests; make test-all: with the long campaigns
# make bench   timings beside CasADi's interpreter, written to docs/performance.md
# make docs    the documentation, every page carried out first: docs/_build/index.html
# make mutate  one planted sign error at a time: which test sees it, written to docs/mutation.md
PYTHON ?= python3
VENV   ?= .venv
BIN    := $(VENV)/bin
WORKERS ?= $(shell nproc)

.PHONY: demo test check test-all bench mutate docs lint clean

$(VENV)/installed: pyproject.toml constraints.txt
	$(PYTHON) -m venv $(VENV)
	$(BIN)/pip install --quiet --upgrade pip
	$(BIN)/pip install --quiet -c constraints.txt -e .
	touch $@

$(VENV)/developed: $(VENV)/installed
	$(BIN)/pip install --quiet -c constraints.txt -e ".[dev]"
	touch $@

demo: $(VENV)/installed
	$(BIN)/gough run examples/01_circle_diamond_square.toml

lint: $(VENV)/developed
	$(BIN)/ruff check .

check: lint
	$(BIN)/pytest -q -n $(WORKERS) -m "not slow and not full"

test: $(VENV)/developed
	$(BIN)/ruff check .
	$(BIN)/pytest -q -n $(WORKERS) -m "not slow"

test-all: $(VENV)/developed
	$(BIN)/pytest -q -n $(WORKERS)

bench: $(VENV)/developed
	$(BIN)/python -m bench
	$(BIN)/python -m bench.programs

mutate: $(VENV)/developed
	$(BIN)/python tools/mutate.py --workers $(WORKERS)

docs: $(VENV)/developed
	$(BIN)/python -m sphinx -q -W --keep-going -b html docs docs/_build
	@echo "docs/_build/index.html"

clean:
	rm -rf $(VENV) results docs/_build
