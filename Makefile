# All set-up lives in .venv/; every target makes what it needs.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.installed
NEIGHBOURS := $(VENV)/.bench
SIMULATORS := $(VENV)/interop
EMULATOR := $(VENV)/emulator

INSTRUMENTS := $(VENV)/instruments
PACKAGERS := $(VENV)/packagers

.PHONY: demo test slow long browser bench bench-checks interop electronics firmware firmware-checks docs pictures lint mutants sanitize coverage \
  alarms fuzz campaigns versions windows dist lock clean
.DELETE_ON_ERROR:

demo: $(STAMP)
	$(BIN)/layerjam demo --out out/demo

# a later process reads what an earlier one has compiled
unexport PYTHONDONTWRITEBYTECODE
TEST = $(BIN)/python -m pytest -q -n 2 --dist worksteal

test: $(STAMP)
	$(TEST) -m "not slow" tests

# In two parts, of which each prints its time and that of each folder.
slow: long browser

long: $(STAMP)
	$(TEST) -m "slow and not browser and not campaign" tests

browser: $(STAMP)
	$(TEST) -m "slow and browser and not campaign" tests

# The long tests with all their random cases, of which `make slow` takes a share, and those marked
# `campaign`: hours.
campaigns: $(STAMP)
	LAYERJAM_FULL=1 $(TEST) -m slow tests

bench: $(NEIGHBOURS)
	$(BIN)/python -m benchmarks.run

docs: $(STAMP)
	NO_MKDOCS_2_WARNING=1 $(BIN)/python -m mkdocs build --strict --site-dir out/site

# Every picture of README, docs and notebooks. Those simulated in MuJoCo are drawn if `make interop`
# has installed it, the photograph of the workbench if Chromium is installed.
pictures: $(STAMP)
	$(BIN)/python docs/images/make.py
	$(BIN)/python docs/notebooks.py

lint: $(STAMP)
	$(BIN)/ruff check src tests benchmarks docs examples hatch_build.py
	$(BIN)/ruff format --check src tests benchmarks examples hatch_build.py
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/codespell src tests docs benchmarks examples README.md CHANGELOG.md CONTRIBUTING.md AGENTS.md docs/llms.txt

# The share of 200 random changes of the code that the quick tests notice: `make mutants SEED=101`.
mutants: $(STAMP)
	$(BIN)/python tests/mutants.py --sample 200 $(if $(SEED),--seed $(SEED))

# The C kernel, compiled with checks of addresses and of undefined behaviour, under its tests.
CHECKED = -g -fsanitize=address,undefined -fno-sanitize-recover=all
sanitize: $(STAMP)
	CC="gcc $(CHECKED)" ASAN_OPTIONS=detect_leaks=0 XDG_CACHE_HOME=$(CURDIR)/out/sanitize \
	  LD_PRELOAD="$$(gcc -print-file-name=libasan.so) $$(gcc -print-file-name=libubsan.so)" \
	  $(BIN)/python -m pytest -q tests/brake/kernel tests/bench/control/test_closed_loop.py \
	  tests/bench/control/test_c_program.py tests/workshop/figures tests/brake/simulate/test_stack.py

# The share of virtual campaigns whose 95 % intervals hold the truth, into docs/coverage.md.
coverage: $(STAMP)
	$(BIN)/python tests/interval_coverage.py --campaigns 1000 --seed 2018 --write
	$(BIN)/python tests/friction_faults.py --campaigns 500 --seed 2018 --write
	$(BIN)/python tests/prediction_coverage.py --campaigns 300 --seed 2018 --write
	$(BIN)/python tests/blind_predictions.py --write

# How often healthy hours end in a false alarm, and faults are missed, into docs/control.md.
alarms: $(STAMP)
	$(BIN)/python tests/false_alarms.py --write

fuzz: $(STAMP)
	LAYERJAM_FUZZ=100000 $(BIN)/python -m pytest -q -n 2 -m slow tests/laboratory/measure/test_fuzz.py

# The demo and the quick tests of the core with the lowest versions that pyproject.toml allows, then
# with the newest, by this Python and by each of the others on PATH, each in a fresh environment:
# a quarter of an hour each.
versions: $(PACKAGERS)/.installed
	$(PACKAGERS)/bin/python tests/install/versions.py lowest $(VENV)/lowest
	$(PACKAGERS)/bin/python tests/install/versions.py newest $(VENV)/newest
	for python in 3.12 3.13 3.14; do \
	  $(PACKAGERS)/bin/python tests/install/versions.py newest $(VENV)/python$$python $$python || exit 1; done

# The demo and quick tests with CPython for Windows under Wine, in a folder of 3 GB that is filled
# once: root only; what is missing is said, and nothing is tried.
windows: $(PACKAGERS)/.installed
	$(PACKAGERS)/bin/python tests/windows/wine.py $(VENV)/windows $(TESTS)

# Wheel and source archive into out/dist, built twice with the same bytes.
dist: $(PACKAGERS)/.installed
	$(PACKAGERS)/bin/python tests/install/dist.py out/dist

# The brake in simulators that are too heavy for `make test`, in an environment of their own, and the
# C kernel on other processors. Debian's cross compilers and emulators are installed where that is
# possible; tests whose tools are missing say so.
CROSS = gcc gcc-arm-none-eabi libnewlib-arm-none-eabi qemu-system-arm qemu-user \
  gcc-aarch64-linux-gnu libc6-dev-arm64-cross libtbb12 wine

interop: $(SIMULATORS)/.installed
	@( for tool in qemu-system-arm arm-none-eabi-gcc aarch64-linux-gnu-gcc qemu-aarch64 wine; do \
	  command -v $$tool >/dev/null || exit 1; done ) || \
	  { apt-get update -qq && apt-get install -y -qq --no-install-recommends $(CROSS); } || \
	  echo "not installed: $(CROSS); what needs them is skipped"
	$(SIMULATORS)/bin/python -m pytest -q -rs tests/interop tests/brake/kernel
	PYTHONPATH=$(CURDIR)/examples $(SIMULATORS)/bin/python tests/docs/examples.py docs/interop.md docs/simulators.md docs/gallery.md docs/questions.md
	$(BIN)/python -m benchmarks.kernel

# The bench's circuit in ngspice, installed from Debian's packages where that is possible.
electronics: $(STAMP)
	@command -v ngspice >/dev/null || \
	  { apt-get update -qq && apt-get install -y -qq --no-install-recommends ngspice; } || \
	  echo "not installed: ngspice; what needs it is skipped"
	$(BIN)/python -m pytest -q -rs tests/bench/electronics

# The image for a board, from Debian's packages, into out/firmware.
COMPILER = build-essential cmake dpkg-dev debian-archive-keyring gcc-arm-none-eabi \
  libnewlib-arm-none-eabi

firmware: $(STAMP)
	@( for tool in cmake dpkg-source gcc arm-none-eabi-gcc; do command -v $$tool >/dev/null || exit 1; done; \
	  test -e "$$(arm-none-eabi-gcc -print-file-name=nosys.specs)" ) || \
	  { apt-get update -qq && apt-get install -y -qq --no-install-recommends $(COMPILER); }
	$(BIN)/python src/layerjam/bench/rig/firmware/image/build.py --out out/firmware $(ONLY)

# That image on an emulated board: minutes. The emulator is installed beside, not among, our packages.
firmware-checks: $(EMULATOR)/.installed
	@$(MAKE) --no-print-directory firmware ONLY=--if-changed
	PYTHONPATH=$(EMULATOR) nice -n 10 $(BIN)/python -m pytest -q -rs tests/bench/rig/emulated

$(EMULATOR)/.installed: tests/bench/rig/emulated/requirements.lock $(STAMP)
	@echo "installing the emulator into $(EMULATOR) (once)"
	@$(BIN)/python -m pip install -qq --disable-pip-version-check --require-hashes --target $(EMULATOR) \
	  -r tests/bench/rig/emulated/requirements.lock
	@touch $@

# The instrument as tools see it that nobody here wrote, in an environment of their own: Debian's
# programs are installed where that is possible; checks whose tools are missing say so.
TALKERS = lxi-tools netcat-openbsd socat sqlite3 strace

bench-checks: $(INSTRUMENTS)/.installed
	@( for tool in lxi nc socat sqlite3 strace; do command -v $$tool >/dev/null || exit 1; done ) || \
	  { apt-get update -qq && apt-get install -y -qq --no-install-recommends $(TALKERS); } || \
	  echo "not installed: $(TALKERS); what needs them is skipped"
	$(INSTRUMENTS)/bin/python -m pytest -q -rs --confcutdir=tests/bench/rig/checks tests/bench/rig/checks

# Installs exactly what requirements.lock names, hashes checked, then this package.
# Debian ships python3 without ensurepip: the venv package is fetched once where that is so.
$(STAMP): requirements.lock pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
	  { echo "layerjam needs Python 3.11 or newer; name one with: make PYTHON=python3.12"; exit 1; }
	@$(PYTHON) -m venv $(VENV) >/dev/null 2>&1 || { \
	  echo "python3 has no venv module here: installing Debian's python3-venv"; rm -rf $(VENV); \
	  { apt-get update -qq && apt-get install -y -qq python3-venv; } && $(PYTHON) -m venv $(VENV) || \
	  { echo "please install python3-venv (apt-get install python3-venv) and run make again"; exit 1; }; }
	@echo "installing into $(VENV) (once, some minutes on a slow line)"
	@$(BIN)/python -m pip install -qq --disable-pip-version-check --require-hashes -r requirements.lock
	@$(BIN)/python -m pip install -qq --disable-pip-version-check --no-deps --no-build-isolation --no-index --editable .
	@touch $(STAMP)

# What `make bench` compares with; nothing else needs it.
$(NEIGHBOURS): benchmarks/requirements.lock $(STAMP)
	@echo "installing the benchmark's neighbours into $(VENV) (once)"
	@$(BIN)/python -m pip install -qq --disable-pip-version-check --require-hashes -r benchmarks/requirements.lock
	@touch $(NEIGHBOURS)

$(SIMULATORS)/.installed: tests/interop/requirements.lock $(STAMP)
	@echo "installing the simulators into $(SIMULATORS) (once)"
	@$(PYTHON) -m venv $(SIMULATORS)
	@$(SIMULATORS)/bin/python -m pip install -qq --disable-pip-version-check --require-hashes -r tests/interop/requirements.lock
	@$(SIMULATORS)/bin/python -m pip install -qq --disable-pip-version-check --no-deps --no-build-isolation --no-index --editable .
	@touch $@

$(INSTRUMENTS)/.installed: tests/bench/rig/checks/requirements.lock $(STAMP)
	@echo "installing PyVISA, PyMeasure, QCoDeS and others into $(INSTRUMENTS) (once)"
	@$(PYTHON) -m venv $(INSTRUMENTS)
	@$(INSTRUMENTS)/bin/python -m pip install -qq --disable-pip-version-check --require-hashes -r tests/bench/rig/checks/requirements.lock
	@touch $@

$(PACKAGERS)/.installed: tests/install/requirements.lock $(STAMP)
	@echo "installing uv and twine into $(PACKAGERS) (once)"
	@$(PYTHON) -m venv $(PACKAGERS)
	@$(PACKAGERS)/bin/python -m pip install -qq --disable-pip-version-check --require-hashes -r tests/install/requirements.lock
	@touch $@

# uv writes no registry host with these options; a test greps for one.
lock:
	printf 'hatchling>=1.27\neditables\n' > build.in
	uv pip compile --universal --generate-hashes --no-header --no-annotate \
	  --no-emit-index-url --no-emit-find-links --python-version 3.11 \
	  --extra all --extra docs --extra test pyproject.toml build.in --output-file requirements.lock
	rm build.in
	uv pip compile --universal --generate-hashes --no-header --no-annotate \
	  --no-emit-index-url --no-emit-find-links --python-version 3.11 -c requirements.lock \
	  benchmarks/requirements.in --output-file benchmarks/requirements.lock
	uv pip compile --universal --generate-hashes --no-header --no-annotate \
	  --no-emit-index-url --no-emit-find-links --python-version 3.11 -c requirements.lock \
	  --extra mjx --extra figures pyproject.toml tests/interop/requirements.in \
	  --output-file tests/interop/requirements.lock
	uv pip compile --universal --generate-hashes --no-header --no-annotate \
	  --no-emit-index-url --no-emit-find-links --python-version 3.11 -c requirements.lock \
	  tests/bench/rig/emulated/requirements.in --output-file tests/bench/rig/emulated/requirements.lock
	uv pip compile --universal --generate-hashes --no-header --no-annotate \
	  --no-emit-index-url --no-emit-find-links --python-version 3.11 \
	  tests/bench/rig/checks/requirements.in --output-file tests/bench/rig/checks/requirements.lock
	uv pip compile --universal --generate-hashes --no-header --no-annotate \
	  --no-emit-index-url --no-emit-find-links --python-version 3.11 -c requirements.lock \
	  tests/install/requirements.in --output-file tests/install/requirements.lock

clean:
	rm -rf $(VENV) out
