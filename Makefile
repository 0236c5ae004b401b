# Two commands do everything: `make demo` and `make test`. Both set up .venv themselves.
PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin
STAMP  := $(VENV)/.ready
WORKERS ?= 2
export PIP_DISABLE_PIP_VERSION_CHECK := 1

.PHONY: demo test fast test-all check goldens bench clean

demo: $(STAMP)
	$(BIN)/pronk render first_steps

test: $(STAMP) check
	$(BIN)/pytest -n $(WORKERS) -m "not nightly"

fast: $(STAMP)
	$(BIN)/pytest -n $(WORKERS) -m "not slow and not nightly"

test-all: $(STAMP) check
	$(BIN)/pytest -n $(WORKERS) --hypothesis-profile=random

check: $(STAMP)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

# Writes the goldens of scenes that are new or move otherwise; SCENES=... for some, ALL=1 for all.
goldens: $(STAMP)
	$(BIN)/python tests/goldens/update.py $(SCENES) $(if $(ALL),--all)

bench: $(STAMP)
	for script in benchmarks/*.py; do $(BIN)/python $$script || exit 1; done

# The stamp is written last, so that a set-up that was interrupted is done again.
$(STAMP): pyproject.toml constraints.txt
	@echo "setting up $(VENV) (once)"
	@$(PYTHON) -c 'import sys; sys.exit("pronk needs Python 3.11 or newer; try: make PYTHON=python3.11" if sys.version_info < (3, 11) else 0)'
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --progress-bar off -c constraints.txt -e '.[dev]'
	# Plays SoundFonts for its tests; alone, for what it needs beside plays on loudspeakers.
	-$(BIN)/python -m pip install --progress-bar off -c constraints.txt --no-deps tinysoundfont
	@touch $@

clean:
	rm -rf $(VENV) out dist
