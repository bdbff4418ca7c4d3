# make run      sets up .venv, simulates the shipped Porter governor, checks it against the closed form, films it
# make test     sets up .venv and passes every test
# make test-browser drives the interactive pages in Chromium
# make gallery-page writes the interactive pages of all shipped scenes, with an index, into renders/pages/
# make gallery  renders every shipped scene into renders/ (the only target that touches tracked files)
# make certificates compares the error estimates of every engine with true errors over 300 random scenes
# make mutants  counts how many small faults in the program the tests notice (hours)
# make benchmark measures speed and accuracy, as ratios within one run

VENV := .venv
BIN := $(VENV)/bin
CANDIDATES := python3 python3.13 python3.12 python3.11

unexport PYTHONDONTWRITEBYTECODE # tests start many processes, each of which would translate all sources again

.PHONY: run test test-browser check gallery gallery-page certificates mutants benchmark clean

run: $(VENV)/installed
	$(BIN)/governor-mechanism run porter --out renders/latest
	@echo
	$(BIN)/governor-mechanism crosscheck porter

test: $(VENV)/installed-test
	$(BIN)/python -m pytest -n auto --dist worksteal

test-browser: $(VENV)/installed-test
	$(BIN)/python tests/browser/chromium.py
	$(BIN)/python -m pytest tests/browser/check_page.py

check: $(VENV)/installed-test
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/pydoclint src
	$(BIN)/mypy

gallery: $(VENV)/installed gallery-page
	$(BIN)/python renders/gallery.py

gallery-page: $(VENV)/installed
	$(BIN)/python renders/gallery_page.py

certificates: $(VENV)/installed-test
	$(BIN)/python benchmarks/certificates.py --no-figure

mutants: $(VENV)/installed-test
	$(BIN)/python benchmarks/mutants.py

benchmark: $(VENV)/installed-test
	$(BIN)/python benchmarks/impulse.py
	$(BIN)/python benchmarks/multibody.py
	$(BIN)/python benchmarks/reduced.py
	$(BIN)/python benchmarks/sweep.py
	$(BIN)/python benchmarks/statics.py
	$(BIN)/python benchmarks/effects.py
	$(BIN)/python benchmarks/film.py
	$(BIN)/python benchmarks/calls.py
	$(BIN)/python benchmarks/kinematics.py
	$(BIN)/python benchmarks/commands.py
	$(BIN)/python benchmarks/growth.py
	$(BIN)/python benchmarks/certificates.py
	$(BIN)/python benchmarks/peers.py

$(VENV)/python:
	@found=; for python in $(PYTHON) $(CANDIDATES); do \
	  if $$python -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null; then found=$$python; break; fi; \
	done; \
	if [ -z "$$found" ]; then \
	  echo "governor-mechanism needs Python 3.11 or newer; install it (for example: apt install python3)" \
	    "or name one: make run PYTHON=/path/to/python3.11" >&2; exit 1; fi; \
	if ! $$found -c 'import venv, ensurepip' 2>/dev/null; then \
	  echo "$$found has no venv module; install it (for example: apt install python3-venv)" >&2; exit 1; fi; \
	$$found -m venv $(VENV) && touch $@

$(VENV)/installed: $(VENV)/python pyproject.toml
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable .
	@touch $@

$(VENV)/installed-test: $(VENV)/python pyproject.toml
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[test]'
	@touch $@ $(VENV)/installed

clean:
	rm -rf $(VENV) renders/latest renders/pages
