# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
#
#   make demo    set up, then localise a simulated robot on a floorplan; results in out/demo
#   make test    set up, then lint, build the documentation and run the tests
#   make test-all   that, and what needs a stage of its own: wheels, browser, notebook, tutorial
#   make test-oldest   run the quick tests with the oldest libraries, those of Ubuntu 24.04
#   make setup   only make .venv and compile (see tools/setup.sh for PYTHON and TORCH_INDEX_URL)
#   make lint    ruff, mypy and codespell, which knows words of our own that the field has others for
#   make walkthrough   follow the tutorial word for word, and compare with what it promises
#   make pictures   make the pictures of the documentation by the commands of notes/images.md
#   make docs    build the documentation into build/docs, every link checked
#   make wheels   install the wheel into empty environments, for each Python at hand and each extra
#   make release VERSION=0.2.0   version, changelog, wheel, commit and tag
#   make clean   remove what was built, not .venv; make distclean removes that, too

SHELL := /bin/bash
.DEFAULT_GOAL := help
.PHONY: help setup demo test test-all test-oldest kernels lint walkthrough pictures docs wheels release clean distclean

BIN := .venv/bin
# The stamp's name holds a hash of what set-up depends on: another checkout date alone does not
# repeat it, and sourcing ROS 2 or changing a requirement does.
INPUTS := $(wildcard requirements*.txt) pyproject.toml setup.py tools/setup.sh tools/interfaces/build.sh $(wildcard interfaces/*/*/*)
STAMP := .venv/.ready-$(shell (cat $(INPUTS); echo "$(ROS_DISTRO)") | sha256sum | cut -c1-16)

# Compiled kernels stay in the environment, where its programs find them, and outlive make clean.
export NUMBA_CACHE_DIR := $(CURDIR)/.venv/numba
ifdef PYTHON
export PYTHON
endif
ifneq ($(origin TORCH_INDEX_URL),undefined)
export TORCH_INDEX_URL
endif

# Fast tests first, two at a time; those that are alone have the machine to themselves.
QUICK := $(wildcard test/unit test/property test/architecture test/adapters)
LONG := $(wildcard test/integration test/ros test/real)
APART := $(wildcard test/integration test/unit/report)
DEMO_ARGS ?=

help:
	@sed -n 's/^#   //p' Makefile

setup: $(STAMP) kernels

$(STAMP):
	@tools/setup.sh
	@rm -f .venv/.ready-*
	@touch $@

demo: $(STAMP)
	$(BIN)/fpnet demo $(DEMO_ARGS)

lint: $(STAMP)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/codespell -D- -D tools/words.txt

walkthrough: $(STAMP)
	$(BIN)/python tools/walkthrough.py

pictures: $(STAMP)
	$(BIN)/python tools/pictures.py

docs: $(STAMP)
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict --quiet

wheels: $(STAMP)
	$(BIN)/python tools/wheels.py

release: $(STAMP)
	$(BIN)/python tools/release.py $(VERSION)

# Compiled once: after set-up, so that the first command does not wait; before the tests, beside
# what needs one processor only, and not by each of their workers.
kernels: $(STAMP)
	OMP_NUM_THREADS=1 $(BIN)/python -m fpnet_core.localizer.warm_up

# The quick tests alone must reach the floor of coverage that pyproject.toml sets.
test: $(STAMP)
	$(MAKE) --no-print-directory --output-sync -j2 kernels lint docs
	OMP_NUM_THREADS=1 $(BIN)/pytest -n 2 --dist worksteal --cov --cov-report= -m 'not apart' $(QUICK)
	OMP_NUM_THREADS=1 $(BIN)/pytest -n 2 --dist loadfile --no-loadscope-reorder --durations=10 \
	  -m 'not alone and not apart' $(LONG)
	$(BIN)/pytest -m alone $(wildcard test/ros)

test-all: test
	OMP_NUM_THREADS=1 $(BIN)/pytest -n 2 --dist loadfile -m apart $(APART)

# A copy of the environment by links, with other versions in it. What the linters and the
# documentation need is of no use there, so that their complaints about versions are not heard.
OLDEST := build/oldest
test-oldest: $(STAMP)
	rm -rf $(OLDEST) && mkdir -p build && cp -al .venv/. $(OLDEST)
	$(OLDEST)/bin/python -m pip install -qq --no-input -r requirements-ubuntu-24.04.txt
	OMP_NUM_THREADS=1 NUMBA_CACHE_DIR=$(CURDIR)/$(OLDEST)/numba-oldest \
	  $(OLDEST)/bin/python -m pytest -n 2 --dist worksteal $(QUICK)

clean:
	rm -rf build install log out *.egg-info .pytest_cache .ruff_cache .mypy_cache .hypothesis .coverage*
	find . -name __pycache__ -not -path './.venv/*' -prune -exec rm -rf {} +

distclean: clean
	rm -rf .venv
