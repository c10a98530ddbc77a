# Everything a contributor or CI runs. `make` lists it.
SHELL := /bin/bash
.DEFAULT_GOAL := help
.PHONY: help deps build extension demo video test lint test-cpp test-python test-blender test-sanitized hard-cases bench bench-physics bench-connections bench-paper bench-effects accuracy sanitize format clean

PY := .venv/bin/python
CMAKE_DIR := build/cmake
CXX_SOURCES = $(shell find cpp tests/cpp benchmarks -name '*.cpp' -o -name '*.hpp')
PY_SOURCES := python addon tests examples benchmarks docs scripts
TEST_PARTS := lint test-cpp test-python test-blender test-sanitized

help:  ## list the targets
	@awk -F ':|## ' '/^[a-z-]+:.*## / { printf "  make %-17s %s\n", $$1, $$NF }' $(MAKEFILE_LIST)

deps:  ## install what is missing, by apt and into .venv
	@scripts/install.sh build

# One CMake tree serves the Python module and the C++ tests. The module lands beside the Python
# sources, where the editable install in .venv (and any other Python 3.11 with python/ on its path)
# finds it.
build: deps  ## build .venv/bin/ifa, the Python package and the C++ tests
	@if [ ! -e $(CMAKE_DIR)/configured ] || [ Makefile -nt $(CMAKE_DIR)/configured ] || \
	    [ .venv/installed -nt $(CMAKE_DIR)/configured ]; then \
	  cmake -S . -B $(CMAKE_DIR) -G Ninja -DCMAKE_BUILD_TYPE=Release \
	    -DIFA_BUILD_TESTS=ON -DIFA_BUILD_PYTHON=ON -DIFA_WARNINGS_AS_ERRORS=ON \
	    -DCMAKE_LIBRARY_OUTPUT_DIRECTORY="$(CURDIR)/python/ifa" \
	    -DPython_EXECUTABLE="$(CURDIR)/$(PY)" -Dpybind11_DIR="$$($(PY) -m pybind11 --cmakedir)" && \
	  touch $(CMAKE_DIR)/configured; \
	fi
	@cmake --build $(CMAKE_DIR)

demo: build  ## make a recording, solve it, write the motion and pictures to build/demo
	@$(PY) examples/first_light.py build/demo

video: demo  ## render the demo's roll with its sound to build/demo/roll.mp4
	@scripts/install.sh blender
	@PATH=/usr/bin:$$PATH IFA_PYTHONPATH=$(CURDIR)/python blender -b build/demo/first_light.blend \
	  --python-exit-code 1 --python examples/render_video.py -- build/demo/roll.mp4 > build/demo/render.log
	@tail -3 build/demo/render.log

# All parts run even if one fails, so that one run shows everything that is wrong.
test:  ## run all tests, the fast ones first
	@scripts/install.sh build blender
	@$(MAKE) --no-print-directory build
	@failed=; for part in $(TEST_PARTS); do \
	  echo "== make $$part"; $(MAKE) --no-print-directory $$part || failed="$$failed $$part"; \
	done; \
	if [ -n "$$failed" ]; then echo "make test: failed:$$failed" >&2; exit 1; fi

lint: deps  ## check style and types
	@failed=0; \
	.venv/bin/ruff check --quiet $(PY_SOURCES) || failed=1; \
	.venv/bin/ruff format --quiet --check $(PY_SOURCES) || failed=1; \
	.venv/bin/clang-format --dry-run -Werror --ferror-limit=1 $(CXX_SOURCES) || failed=1; \
	.venv/bin/mypy || failed=1; \
	exit $$failed

test-cpp: build  ## run the C++ tests
	@ctest --test-dir $(CMAKE_DIR) --output-on-failure --no-tests=error -j $$(nproc) --progress

test-python: build  ## run the Python tests
	@$(PY) -m pytest

# The module that both zips carry links the C++ libraries of build/cmake, which test-cpp tests.
extension: build  ## build the add-on's zips with the core inside, in build/extension
	@scripts/install.sh extension
	@$(PY) -m scripts.extension

# Debian's Blender 3.4, then Blender 4.5 and 5.2 as modules of the Python that each needs, where that is here.
test-blender: extension  ## run the add-on's tests inside Blender, also in a real window, and install its zips
	@scripts/install.sh blender bpy311 bpy313
	@$(PY) tests/blender/run.py --window --pictures build/blender --zips build/extension \
	  --python build/bpy311/bin/python --python build/bpy313/bin/python

# All random trials, where the other targets run a share of them. The table is that of docs/hard_cases.md.
hard-cases: build  ## run the hard cases in full, about an hour, and print what each held
	@IFA_HARD_CASES_SHARE=1 ctest --test-dir $(CMAKE_DIR) --no-tests=error -j $$(nproc) -V --timeout 7200 \
	  -R '^(hard_cases|base.RotationLog)' | $(PY) tests/cpp/hard_cases/table.py

bench: build  ## solve recorded and simulated signatures, verify, judge (ARGS="--quick" for a short run)
	@$(PY) -m benchmarks.solve $(ARGS)

# A tree of its own: the peers are no part of the project, and Bullet is needed by nothing else.
BENCH_DIR := build/bench
bench-physics: build  ## compare the engines with Bullet and MuJoCo (ARGS="--quick" for a short run)
	@scripts/install.sh build bench
	@cmake -S . -B $(BENCH_DIR) -G Ninja -DCMAKE_BUILD_TYPE=Release -DIFA_BUILD_PYTHON=OFF \
	  -DIFA_BUILD_BENCHMARKS=ON -DIFA_WARNINGS_AS_ERRORS=ON >/dev/null
	@cmake --build $(BENCH_DIR) --target physics_peers
	@$(BENCH_DIR)/benchmarks/physics/flight_cost | tee $(BENCH_DIR)/flight_cost.csv
	@$(PY) -m benchmarks.physics $(ARGS)

bench-connections: deps  ## compare motion connections with the paper's scheme, in minutes
	@cmake -S . -B $(BENCH_DIR) -G Ninja -DCMAKE_BUILD_TYPE=Release -DIFA_BUILD_PYTHON=OFF \
	  -DIFA_BUILD_CONNECTIONS=ON -DIFA_WARNINGS_AS_ERRORS=ON >/dev/null
	@cmake --build $(BENCH_DIR) --target connections
	@$(BENCH_DIR)/benchmarks/connections/connections $(BENCH_DIR)/connections.csv

bench-paper: build  ## make the paper's tables again (ARGS="table1 --full"; table2, figure16; --small takes seconds)
	@$(PY) -m benchmarks.paper $(or $(ARGS),table1)

bench-effects: build  ## time each effect with and without it, where a scene needs it (ARGS="--quick")
	@$(PY) -m benchmarks.effects $(ARGS)

accuracy: build  ## measure accuracy against time for docs/accuracy.md, in eight minutes with nothing else running
	@$(PY) docs/draw_accuracy.py $(ARGS)

# The part of `make sanitize` that CI has time for: the engines, under the address and undefined-behaviour sanitizers.
test-sanitized: deps  ## run the C++ tests of the engines under two sanitizers
	@cmake -S . -B build/sanitize-address -G Ninja -DCMAKE_BUILD_TYPE=None -DCMAKE_CXX_FLAGS="-O1 -g1" \
	  -DIFA_BUILD_PYTHON=OFF -DIFA_SANITIZE=address,undefined >/dev/null
	@cmake --build build/sanitize-address --target test_base test_rigid test_hard_cases
	@IFA_HARD_CASES_SHARE=0.0005 ctest --test-dir build/sanitize-address --output-on-failure --no-tests=error \
	  -j $$(nproc) --progress -R '^(base|rigid|hard_cases)\.'

# Without NDEBUG, so that Eigen checks its indices too. setarch -R: ThreadSanitizer cannot place its
# shadow memory where the kernel randomises addresses widely.
sanitize: deps  ## run the C++ tests under the address, undefined-behaviour and thread sanitizers
	@set -e; for checks in address,undefined thread; do dir=build/sanitize-$${checks%%,*}; \
	  cmake -S . -B $$dir -G Ninja -DCMAKE_BUILD_TYPE=None -DCMAKE_CXX_FLAGS="-O1 -g1" -DIFA_BUILD_PYTHON=OFF \
	    -DIFA_SANITIZE=$$checks >/dev/null; \
	  setarch -R cmake --build $$dir; \
	  IFA_HARD_CASES_SHARE=0.0005 setarch -R ctest --test-dir $$dir --output-on-failure --no-tests=error -j $$(nproc); \
	done

format: deps  ## format all sources
	@.venv/bin/ruff check --quiet --fix-only $(PY_SOURCES)
	@.venv/bin/ruff format --quiet $(PY_SOURCES)
	@.venv/bin/clang-format -i $(CXX_SOURCES)

clean:  ## remove what was built, but not .venv
	@rm -rf build python/ifa/_core*.so
