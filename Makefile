# make demo    makes .venv, installs gough, runs the main example, says where the report is
# make test    the tests; make check: lint and the quick tests; make test-all: with the long campaigns
# make bench   timings beside CasADi's interpreter, written to docs/performance.md
# make docs    the documentation, every page carried out first: docs/_build/index.html
# make figures the five studies again, for their figures and rows in the documentation: results/papers, 8 minutes
# make wheel   the wheel, installed in an empty venv, and tried there
# make mutate  one planted sign error at a time: which test sees it, written to docs/mutation.md
PYTHON ?= python3
VENV   ?= .venv
BIN    := $(VENV)/bin
WORKERS ?= $(shell nproc)

PAPERS := garagic2004 honegger1998 chen2008 bouzgarrou2001 okuda2006
STUDIES := $(PAPERS:%=results/papers/%/study.json)

.PHONY: demo test check test-all bench mutate docs figures wheel lint clean

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
	$(BIN)/python -m bench.preflight

mutate: $(VENV)/developed
	$(BIN)/python tools/mutate.py --workers $(WORKERS)

# the wheel in a venv with nothing else: what it forgot to pack is missed here
wheel: $(VENV)/installed
	rm -rf build/wheel && mkdir -p build/wheel
	$(BIN)/pip wheel --quiet --no-deps -w build/wheel .
	$(PYTHON) -m venv build/wheel/venv
	build/wheel/venv/bin/pip install --quiet -c constraints.txt build/wheel/*.whl
	cd build/wheel && venv/bin/gough run ../../examples/01_circle_diamond_square.toml -o run --quiet
	cd build/wheel && venv/bin/gough export nist-octahedral --target mjcf -o machine.xml
	cd build/wheel && venv/bin/gough export nist-octahedral --target c -o c
	cd build/wheel && venv/bin/gough export nist-octahedral --target linuxcnc -o linuxcnc
	cd build/wheel && venv/bin/gough preflight ../../examples/04_pockets.ngc -m nist-octahedral

# once a copy, and again by make figures: the pages say of which source theirs are.  Status 1 is a row that is not met,
# which the page shows; without a result the second line ends it
$(STUDIES): results/papers/%/study.json: | $(VENV)/developed
	-$(BIN)/gough reproduce $* --quiet --out results/papers/$* --force
	test -f $@

figures:
	rm -f $(STUDIES)
	$(MAKE) $(STUDIES)

docs: $(VENV)/developed $(STUDIES)
	$(BIN)/python -m sphinx -q -W --keep-going -b html docs docs/_build
	@echo "docs/_build/index.html"

clean:
	rm -rf $(VENV) results docs/_build
