# make run      sets up .venv, simulates the shipped Porter governor, checks it against the closed form, films it
# make test     sets up .venv and passes the tests of every day
# make test-all passes all tests: also every scene in every engine, hard cases, long runs, commands of the documentation
# make test-docs runs every command of the README and the documentation as it stands there (minutes)
# make kernels  builds the library of compiled kernels again, if one was changed (two minutes); run, test and docs do it too
# make kernel-comparison compares that library with numba, bit by bit
# make docs     builds the documentation into docs/_build/html
# make test-pages drives the interactive pages in Chromium
# make test-browser drives the interactive pages and the documentation in Chromium
# make package builds wheel and sdist and tries them in fresh environments of every Python found
# make wheels  builds the wheels of all platforms into dist/; those of other platforms are not tried
# make lock     writes constraints.txt, the versions that `make run` and `make test` install
# make gallery-page writes the interactive pages of all shipped scenes, with an index, into renders/pages/
# make gallery  makes films and figures of every shipped scene and study into renders/gallery/, which is not tracked (many minutes)
# make pictures brings what README and documentation show from there into renders/, small enough to be tracked
# make contact-sheet shows all films and figures of renders/gallery/ at once, in contact_sheet_*.png there
# make errata   writes the page of the papers' errata and its pictures, docs/errata/, from what the package recomputes
# make certificates compares the error estimates of every engine with true errors over 10,000 runs, and states the result (40 minutes)
# make kernel-coverage runs the kernels without a compiler: short runs and tests must reach all their lines and branches (minutes)
# make test-indices runs the tests with a library of kernels that ends the process at a negative index (minutes)
# make mutants  counts how many small faults in the program the tests notice (hours)
# make benchmark measures speed and accuracy, as ratios within one run, and writes the tables of benchmarks/RESULTS.md

VENV := .venv
BIN := $(VENV)/bin
CANDIDATES := python3 python3.14 python3.13 python3.12 python3.11

unexport PYTHONDONTWRITEBYTECODE # tests start many processes, each of which would translate all sources again

INSTALL = $(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt --editable
PLATFORMS := linux-x86_64 linux-aarch64 darwin-x86_64 darwin-arm64 win32-amd64
LIBRARY := src/governor_mechanism/_kernels/index.json
KERNEL_SOURCES := $(shell find src/governor_mechanism -name '*.py') $(wildcard kernel_build/*.[pch]*)

ANNOUNCE = test -f $(LIBRARY) || echo "installing; the compiled kernels are built once, which takes a minute or two"
EXPLAIN = echo "the installation failed; it needs the package index once, also for the packages that build the compiled kernels" \
  "(numba; and ziglang where there is no C compiler: cc, gcc or clang)" >&2

.NOTPARALLEL:
.PHONY: run kernels kernel-comparison test test-all test-docs docs test-pages test-browser check package wheels lock gallery gallery-page pictures contact-sheet errata certificates kernel-coverage test-indices mutants benchmark clean

run: $(VENV)/installed $(LIBRARY)
	$(BIN)/governor-mechanism run porter --out renders/latest
	@echo
	$(BIN)/governor-mechanism crosscheck porter

kernels: $(VENV)/installed $(LIBRARY)

kernel-comparison: $(VENV)/installed-test $(LIBRARY)
	$(BIN)/python kernel_build/comparison.py

test: $(VENV)/installed-test $(LIBRARY)
	$(BIN)/python -m pytest -n auto --dist worksteal -m "not long" --hypothesis-profile=quick

test-all: $(VENV)/installed-test $(LIBRARY)
	$(BIN)/python -m pytest -n auto --dist worksteal

test-docs: $(VENV)/installed-test $(LIBRARY)
	$(BIN)/python -m pytest -n 2 tests/docs/check_commands.py

docs: $(VENV)/installed-docs $(LIBRARY)
	$(BIN)/python -m sphinx -W --keep-going -n -q -b html docs docs/_build/html

test-pages: $(VENV)/installed-test $(LIBRARY)
	$(BIN)/python -m pytest tests/browser/check_page.py tests/browser/check_live.py

test-browser: $(VENV)/installed-test docs
	$(BIN)/python tests/support/chromium.py
	$(BIN)/python -m pytest tests/browser/check_page.py tests/browser/check_live.py tests/browser/check_docs.py

check: $(VENV)/installed-test
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/pydoclint src
	$(BIN)/codespell
	$(BIN)/mypy

package: $(VENV)/installed-test $(LIBRARY)
	$(BIN)/python .ci/check_package.py

wheels: $(VENV)/installed-test
	$(BIN)/python -m pip install --quiet --disable-pip-version-check 'ziglang>=0.13'
	$(BIN)/python kernel_build/build.py $(PLATFORMS)
	for platform in $(PLATFORMS); do GOVERNOR_MECHANISM_PLATFORM=$$platform \
	  $(BIN)/python -m build --wheel --no-isolation --outdir dist . || exit 1; done

lock: $(VENV)/installed-test
	$(BIN)/python -m pip install --quiet --disable-pip-version-check 'uv>=0.5'
	$(BIN)/uv pip compile pyproject.toml --extra all --extra test --extra docs --universal --python-version 3.11 --upgrade \
	  --no-header --no-annotate --no-emit-index-url --output-file constraints.txt

gallery: $(VENV)/installed $(LIBRARY) gallery-page
	$(BIN)/python docs/pictures/gallery.py

gallery-page: $(VENV)/installed $(LIBRARY)
	$(BIN)/python docs/pictures/gallery_page.py

pictures: $(VENV)/installed $(LIBRARY)
	$(BIN)/python docs/pictures/shown.py

contact-sheet: $(VENV)/installed
	$(BIN)/python docs/pictures/contact_sheet.py

errata: $(VENV)/installed $(LIBRARY)
	$(BIN)/python docs/errata/generate.py

certificates: $(VENV)/installed-test $(LIBRARY)
	$(BIN)/python benchmarks/certificates.py --state

kernel-coverage: $(VENV)/installed-test
	$(BIN)/python benchmarks/kernel_coverage.py

test-indices: $(VENV)/installed-test
	$(BIN)/python kernel_build/build.py --checked
	$(BIN)/python -m pytest -n auto --dist worksteal -m "not long" --hypothesis-profile=quick; status=$$?; $(BIN)/python kernel_build/build.py --again; exit $$status

mutants: $(VENV)/installed-test
	$(BIN)/python benchmarks/mutants.py

benchmark: $(VENV)/installed-test $(LIBRARY)
	$(BIN)/python benchmarks/write_results.py

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

$(VENV)/installed: $(VENV)/python pyproject.toml constraints.txt
	@$(ANNOUNCE)
	@$(INSTALL) . || { $(EXPLAIN); exit 1; }
	@touch $@

$(VENV)/installed-test: $(VENV)/python pyproject.toml constraints.txt
	@$(ANNOUNCE)
	@$(INSTALL) '.[test]' || { $(EXPLAIN); exit 1; }
	@touch $@ $(VENV)/installed

$(VENV)/installed-docs: $(VENV)/python pyproject.toml constraints.txt
	@$(ANNOUNCE)
	@$(INSTALL) '.[docs]' || { $(EXPLAIN); exit 1; }
	@touch $@ $(VENV)/installed

# after a change of sources: builds it if they change a kernel; to install the package builds it too
$(LIBRARY): $(KERNEL_SOURCES) | $(VENV)/installed
	@if $(BIN)/python -c 'import numba' 2>/dev/null; then $(BIN)/python kernel_build/build.py; else $(INSTALL) . --no-deps; fi
	@touch $@

clean:
	rm -rf $(VENV) renders/latest renders/gallery renders/pages docs/_build docs/_generated src/governor_mechanism/_kernels kernel_build/built
