# The scene to light, where the results go, and further arguments of `klieg design`.
SCENE ?= scenes/elephant.glb
OUT ?= out
ARGS ?=

# Where distributions put the description of lavapipe, Mesa's software Vulkan device; some name it
# after the architecture.
LAVAPIPE = $(firstword $(wildcard $(addprefix /usr/share/vulkan/icd.d/, \
	lvp_icd.$(shell uname -m).json lvp_icd.json)))

.PHONY: help setup design test check

help:
	@echo 'make design [SCENE=FILE] [OUT=FOLDER] [ARGS=...]  light a glTF scene, on Vulkan'
	@echo 'make test   run every test, on lavapipe with the Vulkan validation layers'
	@echo 'make check  look for badly formatted code and for lints'
	@echo 'make setup  only install what the others need, where it is missing'

setup:
	@.ci/setup

design: setup
	cargo run --release -- design "$(SCENE)" --out "$(OUT)" --device vulkan $(ARGS)

test:
	@.ci/setup test
	$(if $(LAVAPIPE),VK_DRIVER_FILES=$(LAVAPIPE) VK_ICD_FILENAMES=$(LAVAPIPE)) cargo test

check: setup
	cargo fmt --check
	cargo clippy --all-targets -- -D warnings
	cargo clippy --no-default-features --lib -- -D warnings
