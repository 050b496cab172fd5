# The scene to light, where the results go, and further arguments of `klieg design`.
SCENE ?= scenes/elephant.glb
OUT ?= out
ARGS ?=

# Where distributions put the description of lavapipe, Mesa's software Vulkan device; some name it
# after the architecture.
LAVAPIPE = $(firstword $(wildcard $(addprefix /usr/share/vulkan/icd.d/, \
	lvp_icd.$(shell uname -m).json lvp_icd.json)))

# Where `make install` puts the program and the C library, below DESTDIR where that is given, how they are built, and
# a program to take instead of building one.
PREFIX ?= /usr/local
LIBDIR ?= $(PREFIX)/lib
DATADIR ?= $(PREFIX)/share
PROFILE ?= release
PROGRAM ?=
TARGET = $(or $(CARGO_TARGET_DIR),target)/$(patsubst dev,debug,$(PROFILE))

# The version, and the part of it that names the binary interface: all before 1.0 may change with a
# minor version.
VERSION = $(shell sed -n 's/^version = "\(.*\)"/\1/p' Cargo.toml)
ABI = $(shell echo $(VERSION) | sed 's/^\(0\.[0-9]*\|[1-9][0-9]*\)\..*/\1/')
# What the static library needs besides, by `rustc --print native-static-libs`.
PRIVATE = -lgcc_s -lutil -lrt -lpthread -lm -ldl -lc

# What `make judge` judges (a scene, a folder of scenes or a list of them), where the results go, further
# arguments of tools/judge/judge.py, and klieg's program, which is built where none is given.
JUDGE_SCENES ?= scenes
JUDGE_OUT ?= out/judge
JUDGE_ARGS ?=
JUDGE_KLIEG ?=
# Blender's Python package is made for one version of Python alone.
JUDGE_PYTHON ?= python3.11
JUDGE_ENV = $(or $(CARGO_TARGET_DIR),target)/judge

BUILDS = $(or $(CARGO_TARGET_DIR),target)
# The Python that the package is tested with, and where its tools and its wheels go.
PYTHON ?= python3
PYTHON_ENV = $(BUILDS)/python
WHEELS = $(BUILDS)/wheels

.PHONY: help setup design spirv test test-rust test-python check check-python program library install install-program \
	install-library judge intent studio-speed gpu-kit drivers fuzz soak bits mutants coverage deny msrv package wheel \
	python-module test-blender test-ray blender-addon

help:
	@echo 'make design [SCENE=FILE] [OUT=FOLDER] [ARGS=...]  light a glTF scene, on Vulkan'
	@echo 'make test   run every test, on lavapipe with the Vulkan validation layers'
	@echo 'make check  look for badly formatted code and for lints'
	@echo 'make spirv  compile the shaders for builds without a shader compiler: after each change of a shader'
	@echo 'make judge [JUDGE_SCENES=FOLDER] [JUDGE_OUT=FOLDER]   judge designs in Blender, beside the usual rigs'
	@echo 'make intent  make the pictures of docs/INTENT.md anew'
	@echo 'make studio-speed [SCENE=FILE]  measure how soon the page of klieg studio answers'
	@echo 'make gpu-kit  build a folder that tests and times klieg on another machine with a GPU'
	@echo 'make drivers  try klieg on newer Mesa and on the drivers of GPUs that are not there (root, debootstrap)'
	@echo 'make install [PREFIX=FOLDER] [DESTDIR=FOLDER]     build and install the program,'
	@echo '            its manual page, its completions and the C library'
	@echo 'make fuzz [FUZZ_SECONDS=N] [FUZZ_TARGETS=...]  look for files that break the readers (nightly Rust, cargo-fuzz)'
	@echo 'make soak [SOAK_DESIGNS=N]  make many designs in one process, which must not grow'
	@echo 'make bits   compare the results of a debug and of a release build, byte for byte'
	@echo 'make mutants [MUTANTS=...]  change code here and there and see whether the tests notice (cargo-mutants)'
	@echo 'make coverage [COVERAGE=...]  count which lines the tests run (cargo-llvm-cov)'
	@echo 'make deny   check licences, sources and advisories of the dependencies (cargo-deny)'
	@echo 'make msrv   check with the oldest Rust that klieg promises to build with'
	@echo 'make wheel  build the Python package, and try it in a virtual environment of its own'
	@echo 'make blender-addon  build the extension for Blender 4.2 and later: target/klieg-blender-VERSION.zip'
	@echo 'make test-blender   test it with the package of Blender, 300 MB'
	@echo 'make test-ray   test klieg.ray on a local cluster'
	@echo 'make test-python [PYTHON=PROGRAM]  the tests of the Python package alone'
	@echo 'make package  pack the crate, and build and test what is in the archive'
	@echo 'make setup  only install what the others need, where it is missing'

setup:
	@.ci/setup

design: setup
	cargo run --release -- design "$(SCENE)" --out "$(OUT)" --device vulkan $(ARGS)

# The checked-in SPIR-V, so that no shader compiler is needed.
library:
	cargo rustc --profile $(PROFILE) --lib --no-default-features --features c \
		--crate-type cdylib,staticlib -- -C link-arg=-Wl,-soname,libklieg.so.$(ABI)

# With the checked-in SPIR-V too.
program:
	$(if $(PROGRAM),,cargo build --profile $(PROFILE) --bin klieg --no-default-features --features cli)

install: install-program install-library

# The manual page and the completions are what the program itself prints.
install-program: program
	install -D -m 755 "$(or $(PROGRAM),$(TARGET)/klieg)" "$(DESTDIR)$(PREFIX)/bin/klieg"
	install -d "$(DESTDIR)$(DATADIR)/man/man1" "$(DESTDIR)$(DATADIR)/bash-completion/completions" \
		"$(DESTDIR)$(DATADIR)/zsh/site-functions" "$(DESTDIR)$(DATADIR)/fish/vendor_completions.d"
	"$(DESTDIR)$(PREFIX)/bin/klieg" man --out "$(DESTDIR)$(DATADIR)/man/man1"
	for file in bash:bash-completion/completions/klieg zsh:zsh/site-functions/_klieg \
		fish:fish/vendor_completions.d/klieg.fish; do \
		"$(DESTDIR)$(PREFIX)/bin/klieg" completions $${file%%:*} >"$(DESTDIR)$(DATADIR)/$${file#*:}" || exit 1; \
	done

install-library: library
	install -d "$(DESTDIR)$(PREFIX)/include" "$(DESTDIR)$(LIBDIR)/pkgconfig" "$(DESTDIR)$(LIBDIR)/cmake/klieg"
	install -m 644 include/klieg.h "$(DESTDIR)$(PREFIX)/include"
	install -m 644 $(TARGET)/libklieg.a "$(DESTDIR)$(LIBDIR)"
	install -m 755 $(TARGET)/libklieg.so "$(DESTDIR)$(LIBDIR)/libklieg.so.$(VERSION)"
	ln -sf libklieg.so.$(VERSION) "$(DESTDIR)$(LIBDIR)/libklieg.so.$(ABI)"
	ln -sf libklieg.so.$(ABI) "$(DESTDIR)$(LIBDIR)/libklieg.so"
	for file in pkgconfig/klieg.pc cmake/klieg/kliegConfig.cmake cmake/klieg/kliegConfigVersion.cmake; do \
		sed -e 's|@PREFIX@|$(PREFIX)|; s|@LIBDIR@|$(LIBDIR)|; s|@VERSION@|$(VERSION)|; s|@ABI@|$(ABI)|' \
			-e 's|@PRIVATE@|$(PRIVATE)|' \
			-e "s|@INCLUDE_FROM_LIBDIR@|$$(realpath -m --relative-to '$(LIBDIR)' '$(PREFIX)/include')|" \
			src/c/package/$${file##*/}.in >"$(DESTDIR)$(LIBDIR)/$$file" || exit 1; \
	done

spirv: setup
	KLIEG_WRITE_SPIRV=1 cargo test --test spirv

ON_LAVAPIPE = $(if $(LAVAPIPE),VK_DRIVER_FILES=$(LAVAPIPE) VK_ICD_FILENAMES=$(LAVAPIPE))
# klieg and its Python module in one selection of packages, so that cargo builds klieg for both with the same features.
BOTH = -p klieg -p klieg-python --features klieg-python/shaderc

test: test-rust test-python

test-rust:
	@.ci/setup test
	$(ON_LAVAPIPE) cargo test $(BOTH)

$(PYTHON_ENV)/installed: python/requirements.txt
	$(PYTHON) -m venv --clear "$(PYTHON_ENV)"
	"$(PYTHON_ENV)/bin/pip" install --quiet --disable-pip-version-check -r python/requirements.txt
	touch "$@"

# A test among the targets makes cargo select features as for all tests: what `test-rust` has built stays as it is.
python-module: $(PYTHON_ENV)/installed
	cargo build --lib --bins --test architecture $(BOTH)
	python/install "$$("$(PYTHON_ENV)/bin/python" -c 'import sysconfig; print(sysconfig.get_path("platlib"))')" "$(BUILDS)/debug"

test-python:
	@.ci/setup test
	$(MAKE) python-module check-python
	cd python && KLIEG="$(abspath $(BUILDS))/debug/klieg" $(ON_LAVAPIPE) "$(abspath $(PYTHON_ENV))/bin/pytest"

check-python:
	cd python && "$(abspath $(PYTHON_ENV))/bin/ruff" check . && "$(abspath $(PYTHON_ENV))/bin/ruff" format --check .
	cd python && "$(abspath $(PYTHON_ENV))/bin/mypy"
	cd python && "$(abspath $(PYTHON_ENV))/bin/stubtest" klieg._klieg --mypy-config-file pyproject.toml
	cd benches/peers && "$(abspath $(PYTHON_ENV))/bin/ruff" check --config ../../python/pyproject.toml . && \
		"$(abspath $(PYTHON_ENV))/bin/ruff" format --config ../../python/pyproject.toml --check . && \
		"$(abspath $(PYTHON_ENV))/bin/mypy" --config-file ../../python/pyproject.toml .

# On a cluster of two workers on this machine; Ray is 300 MB with what it needs.
test-ray: python-module
	"$(PYTHON_ENV)/bin/pip" install --quiet --disable-pip-version-check -r python/requirements-ray.txt
	"$(PYTHON_ENV)/bin/pytest" -c python/pyproject.toml --rootdir python python/tests/test_ray.py

# In the Python of Blender's package, which `make judge` has too.
test-blender: python-module $(JUDGE_ENV)/installed
	python/install "$(BUILDS)/blender" "$(BUILDS)/debug"
	rm -rf "$(BUILDS)/blender/klieg_addon" && cp -R python/blender "$(BUILDS)/blender/klieg_addon"
	cd python/tests_blender && PYTHONPATH="$(abspath $(BUILDS))/blender" "$(abspath $(JUDGE_ENV))/bin/python" -m unittest -v

# The extension for Blender 4.2 and later, with the wheel in it.
ADDON = $(BUILDS)/addon
blender-addon: wheel
	rm -rf "$(ADDON)" && mkdir -p "$(ADDON)/wheels"
	cp python/blender/__init__.py "$(ADDON)" && cp "$(WHEELS)"/*.whl "$(ADDON)/wheels"
	sed -e 's|@VERSION@|$(VERSION)|' -e "s|@WHEEL@|$$(basename "$(WHEELS)"/*.whl)|" \
		python/blender/blender_manifest.toml.in >"$(ADDON)/blender_manifest.toml"
	cd "$(ADDON)" && $(PYTHON) -m zipfile -c "../klieg-blender-$(VERSION).zip" __init__.py blender_manifest.toml wheels

# With the checked-in SPIR-V: the wheel needs no shader compiler, and at run time no Vulkan loader where there is none.
wheel: $(PYTHON_ENV)/installed
	rm -rf "$(WHEELS)"
	"$(PYTHON_ENV)/bin/maturin" build --release --locked --manifest-path python/Cargo.toml --out "$(WHEELS)"
	$(PYTHON) -m venv --clear "$(BUILDS)/wheel-smoke"
	"$(BUILDS)/wheel-smoke/bin/pip" install --quiet --disable-pip-version-check "$(WHEELS)"/*.whl
	"$(BUILDS)/wheel-smoke/bin/python" -I python/tests/smoke.py scenes/elephant.glb

check: setup
	cargo fmt --all --check
	cargo clippy --all-targets $(BOTH) -- -D warnings
	cargo clippy --no-default-features --lib -- -D warnings
	cargo clippy --no-default-features --features c --lib -- -D warnings
	RUSTDOCFLAGS='-D warnings' cargo doc --no-deps --features c

$(JUDGE_ENV)/installed: tools/judge/requirements.txt
	@$(JUDGE_PYTHON) -c 'import sys, venv; sys.exit(sys.version_info[:2] != (3, 11))' 2>/dev/null || \
		{ echo 'judge: $(JUDGE_PYTHON) is no Python 3.11 with venv, which Blender needs: install it, or set JUDGE_PYTHON' >&2; exit 1; }
	$(JUDGE_PYTHON) -m venv --clear "$(JUDGE_ENV)"
	"$(JUDGE_ENV)/bin/pip" install --quiet --disable-pip-version-check -r tools/judge/requirements.txt
	touch "$@"

judge: $(if $(JUDGE_KLIEG),,setup) $(JUDGE_ENV)/installed
	"$(JUDGE_ENV)/bin/python" -m unittest discover -q -s tools/judge
	$(if $(JUDGE_KLIEG),,cargo build --release)
	"$(JUDGE_ENV)/bin/python" tools/judge/judge.py "$(JUDGE_SCENES)" --out "$(JUDGE_OUT)" \
		--klieg "$(or $(JUDGE_KLIEG),$(or $(CARGO_TARGET_DIR),target)/release/klieg)" $(JUDGE_ARGS)

# How soon the page of klieg studio answers; needs Node.js and Chromium.
studio-speed: setup
	@.ci/setup test
	cargo build --release
	cd studio && npm ci --silent --no-audit --no-fund
	node studio/tests/speed.mjs "$${CHROMIUM:-$$(command -v chromium chromium-browser google-chrome | head -1)}" "$(or $(CARGO_TARGET_DIR),target)/release/klieg" "$(SCENE)"

# The rows of pictures in docs/INTENT.md; needs Python with Pillow.
intent: setup
	cargo build --release
	python3 tools/intent/rows.py "$(or $(CARGO_TARGET_DIR),target)/release/klieg"

gpu-kit: setup
	@.ci/setup test
	tools/gpu-kit/build

# Needs root, debootstrap and the network: systems with the drivers are made below target/drivers.
drivers: gpu-kit
	tools/drivers/run "$(BUILDS)/drivers"

# Seconds of each target, and which.
FUZZ_SECONDS ?= 600
FUZZ_TARGETS ?= scene glb picture model settings list rig

# What libFuzzer finds beyond the seeds goes to fuzz/corpus, which is not kept.
fuzz: setup
	@cargo +nightly fuzz --version >/dev/null || \
		{ echo 'fuzz: needs nightly Rust and cargo-fuzz: rustup toolchain install nightly; cargo install cargo-fuzz' >&2; exit 1; }
	for target in $(FUZZ_TARGETS); do \
		mkdir -p fuzz/corpus/$$target && cargo +nightly fuzz run --release $$target fuzz/corpus/$$target fuzz/seeds/$$target -- \
			-max_total_time=$(FUZZ_SECONDS) -timeout=20 -rss_limit_mb=4096 -max_len=8192 -print_final_stats=1 || exit 1; \
	done

SOAK_DESIGNS ?= 10000

soak: setup
	KLIEG_SOAK=$(SOAK_DESIGNS) cargo test --release --test soak -- --nocapture --test-threads 1

bits: setup
	cargo build
	cargo build --release
	set -e; for device in cpu vulkan; do \
		for build in debug release; do \
			$(if $(LAVAPIPE),VK_DRIVER_FILES=$(LAVAPIPE) VK_ICD_FILENAMES=$(LAVAPIPE)) "$(BUILDS)/$$build/klieg" design \
				"$(SCENE)" --out "$(BUILDS)/bits/$$build" --device $$device --generations 10 --size 256x256 --coarse 64 >/dev/null; \
		done; \
		for file in best.png headlight.png lit.glb convergence.csv convergence.svg; do \
			cmp "$(BUILDS)/bits/debug/$$file" "$(BUILDS)/bits/release/$$file"; \
		done; \
		echo "$$device: the same bytes"; \
	done

# Which of them, as arguments of cargo mutants: a twenty-fourth takes a quarter of an hour.
MUTANTS ?= --sharding round-robin --shard 0/24

mutants:
	@cargo mutants --version >/dev/null || { echo 'mutants: needs cargo-mutants: cargo install cargo-mutants' >&2; exit 1; }
	tools/mutants/run "$(BUILDS)/mutants" $(MUTANTS)

# Which tests, as arguments of cargo test.
COVERAGE ?= --lib --bins --tests

coverage: setup
	@cargo llvm-cov --version >/dev/null || { echo 'coverage: needs cargo-llvm-cov: cargo install cargo-llvm-cov' >&2; exit 1; }
	cargo llvm-cov --no-fail-fast --ignore-filename-regex '/(tests|examples|python)/' $(COVERAGE)

deny:
	@cargo deny --version >/dev/null || { echo 'deny: needs cargo-deny: cargo install cargo-deny' >&2; exit 1; }
	cargo deny --locked --workspace check licenses bans sources
	cargo deny --locked --workspace check advisories

msrv: setup
	cargo +$(shell sed -n 's/^rust-version = "\(.*\)"/\1/p' Cargo.toml) check --locked --all-targets

PACKAGE = $(or $(CARGO_TARGET_DIR),$(CURDIR)/target)/package

package: setup
	cargo package --locked --no-verify
	tar -xzf "$(PACKAGE)/klieg-$(VERSION).crate" -C "$(PACKAGE)"
	if [ -e .cargo/config.toml ]; then mkdir -p "$(PACKAGE)/klieg-$(VERSION)/.cargo" && \
		cp .cargo/config.toml "$(PACKAGE)/klieg-$(VERSION)/.cargo"; fi
	cd "$(PACKAGE)/klieg-$(VERSION)" && cargo build --locked && cargo test --locked --lib
