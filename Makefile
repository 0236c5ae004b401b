# Two commands do everything: `make demo` and `make test`. Both set up .venv themselves.
PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin
# What rendering needs, and the checks and tests besides.
READY  := $(VENV)/.ready
TOOLS  := $(VENV)/.tools
# What nightly tests need: an engine for clusters, a store to talk to, and what drives a browser.
FARM   := $(VENV)/.farm
# Stands while packages are being installed: one that was interrupted cannot be installed over.
UNFINISHED := $(VENV)/.unfinished
LOG    := $(VENV)/pip.log
PIP    := $(BIN)/python -m pip install --progress-bar off --no-deps
# Exactly the pinned files, and wheels alone: what a source distribution is built with is not pinned.
PINNED := --require-hashes --only-binary :all:
# Tools of maintainers, apart from what is released.
RELEASE := .release-venv
WORKERS ?= 2
export PIP_DISABLE_PIP_VERSION_CHECK := 1

.PHONY: demo test fast test-all check compiled ready-to-test goldens bench lock dist sbom clean

demo: $(READY)
	@$(BIN)/pronk render first_steps

test: ready-to-test
	$(BIN)/pytest -n $(WORKERS) --dist loadfile -m "not nightly"

fast: $(TOOLS)
	$(BIN)/pytest -n $(WORKERS) --dist loadfile -m "not slow and not nightly"

test-all: ready-to-test $(FARM)
	PRONK_FARM=1 $(BIN)/pytest -n $(WORKERS) --dist loadfile --hypothesis-profile=random

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

# pip is heard only when it fails. Of files with a wrong hash it lists every hash that would do.
FAILED = { sed -n '/DO NOT MATCH THE HASHES/,$$p' $(1) | grep -v Expected \
	&& echo 'see "Pinned packages" in CONTRIBUTING.md' || cat $(1); exit 1; }

# A stamp is written last, so that a set-up that was interrupted is done again, from the start.
$(READY): pyproject.toml requirements/runtime.txt requirements/build.txt
	@echo "setting up $(VENV), once: this downloads about 350 MB"
	@$(PYTHON) -c 'import sys; sys.exit("pronk needs Python 3.11 or newer; try: make PYTHON=python3.11" if sys.version_info < (3, 11) else 0)'
	@if [ -e $(UNFINISHED) ]; then rm -rf $(VENV); fi
	@mkdir -p $(VENV) && touch $(UNFINISHED)
	@$(PYTHON) -m venv $(VENV)
	@$(PIP) $(PINNED) -r requirements/runtime.txt -r requirements/build.txt > $(LOG) 2>&1 \
		|| $(call FAILED,$(LOG))
	@$(PIP) --no-build-isolation -e . > $(LOG) 2>&1 || $(call FAILED,$(LOG))
	@rm $(UNFINISHED) && touch $@

$(TOOLS): $(READY) requirements/dev.txt
	@echo "adding the tools of the tests to $(VENV), once"
	@touch $(UNFINISHED) && rm $(READY)
	@$(PIP) $(PINNED) -r requirements/dev.txt > $(LOG) 2>&1 || $(call FAILED,$(LOG))
	@rm $(UNFINISHED) && touch $(READY) && touch $@

$(FARM): $(TOOLS) requirements/farm.txt requirements/browser.txt
	@echo "adding what the tests of farms and of the studio's page need to $(VENV), once"
	@touch $(UNFINISHED) && rm $(READY) $(TOOLS)
	@$(PIP) $(PINNED) -r requirements/farm.txt -r requirements/browser.txt > $(LOG) 2>&1 || $(call FAILED,$(LOG))
	@rm $(UNFINISHED) && touch $(READY) && touch $(TOOLS) && touch $@

# Tools of maintainers have an environment of their own, apart from what is released.
$(RELEASE)/.ready: requirements/release.txt
	@echo "setting up $(RELEASE), once"
	@rm -rf $(RELEASE) && $(PYTHON) -m venv $(RELEASE)
	@$(RELEASE)/bin/python -m pip install --no-deps $(PINNED) -r $< > $(RELEASE)/pip.log 2>&1 \
		|| $(call FAILED,$(RELEASE)/pip.log)
	@touch $@

# Pins what pyproject.toml asks for; UPGRADE="numpy av" looks for newer versions, UPGRADE=all of all.
COMPILE = $(RELEASE)/bin/uv pip compile --quiet --universal --python-version 3.11 --no-python-downloads \
	--generate-hashes --only-binary :all: --fork-strategy fewest --annotation-style line \
	--custom-compile-command "make lock" \
	$(if $(filter all,$(UPGRADE)),--upgrade,$(addprefix --upgrade-package ,$(UPGRADE)))

lock: $(RELEASE)/.ready
	$(COMPILE) pyproject.toml -o requirements/runtime.txt
	$(COMPILE) --group build -c requirements/runtime.txt -o requirements/build.txt
	$(COMPILE) --group dev -c requirements/runtime.txt -c requirements/build.txt -o requirements/dev.txt
	$(COMPILE) --group bench -c requirements/runtime.txt -c requirements/dev.txt -o requirements/bench.txt
	$(COMPILE) --group farm -c requirements/runtime.txt -c requirements/dev.txt -o requirements/farm.txt
	$(COMPILE) --group browser -c requirements/runtime.txt -c requirements/dev.txt -c requirements/farm.txt -o requirements/browser.txt
	$(COMPILE) --group release -c requirements/build.txt -c requirements/dev.txt -c requirements/farm.txt -o requirements/release.txt

# The same sources give the same bytes; SOURCE_DATE_EPOCH, if it is set, dates the files.
dist: $(RELEASE)/.ready
	rm -rf dist
	$(RELEASE)/bin/python -m build --no-isolation

# What an installed pronk consists of, from an environment that holds nothing else; pip is needed
# when packages first start, the setuptools of older Pythons is not.
SHIPPED := $(RELEASE)/shipped
BILL    := $(RELEASE)/pronk.cdx.json

sbom: dist
	@rm -rf $(SHIPPED) && $(PYTHON) -m venv $(SHIPPED)
	@{ $(SHIPPED)/bin/python -m pip install --no-deps $(PINNED) -r requirements/runtime.txt \
		&& $(SHIPPED)/bin/python -m pip install --no-deps dist/*.whl \
		&& $(SHIPPED)/bin/python -m pip uninstall --yes setuptools; } > $(RELEASE)/pip.log 2>&1 \
		|| $(call FAILED,$(RELEASE)/pip.log)
	$(RELEASE)/bin/cyclonedx-py environment --output-reproducible --pyproject pyproject.toml \
		-o $(BILL) $(SHIPPED)/bin/python
	$(RELEASE)/bin/python requirements/bill_of_materials.py $(BILL) \
		$$($(SHIPPED)/bin/python -c 'import sysconfig; print(sysconfig.get_path("platlib"))')
	@wheel=$$(echo dist/*.whl) && mv $(BILL) $${wheel%-py3-none-any.whl}.cdx.json && rm -rf $(SHIPPED)

clean:
	rm -rf $(VENV) $(RELEASE) out dist
