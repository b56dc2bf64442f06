# SPDX-License-Identifier: GPL-3.0-or-later
#
# Every target sets up what it needs; the work is in scripts/. `make` alone lists the targets.

.DEFAULT_GOAL := help
.NOTPARALLEL:
.PHONY: help setup build render test test-long stability stress lint format asan tsan fuzz bench bench-foundation bench-features scenes bake pictures clean extension test-blender

python := .venv/bin/python

# Arguments handed on: `make test ARGS="-k homogeneous"`, `make bench ARGS=...`, `make lint FILES="a.cpp b.cpp"`,
# `make test-blender BLENDERS="trixie venv"`, `make extension KINDS=system`.
ARGS ?=
FILES ?=
# Seconds that `make fuzz` gives each target.
TIME ?= 60
BLENDERS ?=
KINDS ?=

help: ## list the targets
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "  make %-17s %s\n", $$1, $$2 }' $(MAKEFILE_LIST)

setup: ## install Debian packages and .venv, where missing
	@scripts/setup.sh

build: setup ## build the native module and install it into .venv
	@scripts/build.sh module

render: build ## render the bundled cloud into out/
	@mkdir -p out
	.venv/bin/nephele render blend_scenes/cloud/cloud.blend \
	    -o out/cloud.exr --png out/cloud.png --stats out/cloud.json

test: setup ## run every test but the long ones
	@scripts/build.sh all
	@scripts/test.sh $(ARGS)

test-long: build ## run the tests that take minutes each
	$(python) -m pytest -m long --durations=0 $(ARGS)

stability: setup ## measure the errors of the formulas, and write docs/stability.md
	@scripts/build.sh all
	$(python) tools/stability_page.py build/release/tests/native/stability

stress: build ## render the extreme cases, all of them (5 minutes)
	$(python) -m pytest tests/stress -m "" --durations=10 $(ARGS)

extension: setup ## build the zips that Blender installs, into dist/
	@scripts/setup.sh extension
	@scripts/extension.sh $(KINDS)

test-blender: build ## test the zips in five Blenders, which it makes (8 GB, root; BLENDERS="trixie" for some)
	@scripts/setup.sh extension
	@scripts/extension.sh py311 py312 system
	@scripts/test_blender.sh $(BLENDERS)

lint: ## check format and style; clang-tidy on changed files, or on FILES="..."
	@scripts/setup.sh lint
	@scripts/lint.sh $(FILES)

format: ## rewrite the sources in the project's format
	@scripts/setup.sh lint
	@scripts/format.sh

asan: setup ## run native tests, and some of Python, under the address and undefined-behaviour sanitizers
	@scripts/build.sh asan
	@scripts/asan.sh

tsan: setup ## run the native tests that use several threads under the thread sanitizer
	@scripts/build.sh tsan
	@scripts/tsan.sh

fuzz: ## feed the loaders with damaged input, each target for TIME=60 s; ARGS="vdb program" names targets
	@scripts/setup.sh fuzz
	@scripts/build.sh fuzz
	@scripts/fuzz.sh $(TIME) $(ARGS)

bench: build ## measure error against run time, beside Cycles and Mitsuba (hours; see ARGS="--help")
	@scripts/setup.sh bench
	.venv/bin/nephele bench -o out/bench $(ARGS)

bench-foundation: build ## measure speed against Cycles at equal samples, and memory
	$(python) bench/foundation.py $(ARGS)

bench-features: setup ## measure what features cost scenes that lack them, with builds that lack the features
	@scripts/setup.sh count
	$(python) bench/specialisation.py $(ARGS)

scenes: build ## make the bundled .blend files anew from their scripts
	@for script in blend_scenes/*/make.py; do echo "==> $$script"; $(python) "$$script" || exit 1; done

bake: build ## bake the smoke simulation anew (installs Debian's Blender)
	bash blend_scenes/smoke/bake.sh

pictures: build ## take the pictures of docs/user anew (root; makes the root trixie)
	@scripts/setup.sh extension
	@scripts/extension.sh system
	@scripts/blenders.sh bpy-4.5.15 trixie
	$(python) tools/user_pictures.py

clean: ## remove what was built; .venv and out/ stay
	rm -rf --one-file-system build dist *.egg-info
