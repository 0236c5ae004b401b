# Two commands do everything: `make demo` and `make test`. Both set up .venv themselves.
PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin
# What rendering needs, and the checks and tests besides.
READY  := $(VENV)/.ready
TOOLS  := $(VENV)/.tools
# Stands while packages are being installed: one that was interrupted cannot be installed over.
UNFINISHED := $(VENV)/.unfinished
LOG    := $(VENV)/pip.log
PIP    := $(BIN)/python -m pip install --progress-bar off -c constraints.txt
WORKERS ?= 2
export PIP_DISABLE_PIP_VERSION_CHECK := 1

.PHONY: demo test fast test-all check compiled ready-to-test goldens bench clean

demo: $(READY)
	@$(BIN)/pronk render first_steps

test: ready-to-test
	$(BIN)/pytest -n $(WORKERS) -m "not nightly"

fast: $(TOOLS)
	$(BIN)/pytest -n $(WORKERS) -m "not slow and not nightly"

test-all: ready-to-test
	$(BIN)/pytest -n $(WORKERS) --hypothesis-profile=random

# Each of the two takes one processor.
ready-to-test: $(TOOLS)
	@$(MAKE) --no-print-directory -j2 check compiled

# Ahead of the tests, so that they do not all compile the same.
compiled: $(TOOLS)
	@$(BIN)/pronk compile

check: $(TOOLS)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

# Writes the goldens of scenes that are new or move otherwise; SCENES=... for some, ALL=1 for all.
goldens: $(TOOLS)
	$(BIN)/python tests/goldens/update.py $(SCENES) $(if $(ALL),--all)

bench: $(TOOLS)
	for script in benchmarks/*.py; do $(BIN)/python $$script || exit 1; done

# A stamp is written last, so that a set-up that was interrupted is done again, from the start.
$(READY): pyproject.toml constraints.txt
	@echo "setting up $(VENV), once: this downloads about 350 MB"
	@$(PYTHON) -c 'import sys; sys.exit("pronk needs Python 3.11 or newer; try: make PYTHON=python3.11" if sys.version_info < (3, 11) else 0)'
	@if [ -e $(UNFINISHED) ]; then rm -rf $(VENV); fi
	@mkdir -p $(VENV) && touch $(UNFINISHED)
	@$(PYTHON) -m venv $(VENV)
	@$(PIP) -e . > $(LOG) 2>&1 || { cat $(LOG); exit 1; }
	@rm $(UNFINISHED) && touch $@

$(TOOLS): $(READY)
	@echo "adding the tools of the tests to $(VENV), once"
	@touch $(UNFINISHED) && rm $(READY)
	@$(PIP) -e '.[dev]' > $(LOG) 2>&1 || { cat $(LOG); exit 1; }
	@# Plays SoundFonts for its tests; alone, for what it needs beside plays on loudspeakers.
	@$(PIP) --no-deps tinysoundfont > $(LOG) 2>&1 || cat $(LOG)
	@rm $(UNFINISHED) && touch $(READY) && touch $@

clean:
	rm -rf $(VENV) out dist
