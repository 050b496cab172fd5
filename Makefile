# The scene to light, where the results go, and further arguments of `klieg design`.
SCENE ?= scenes/elephant.glb
OUT ?= out
ARGS ?=

# Where distributions put the description of lavapipe, Mesa's software Vulkan device; some name it
# after the architecture.
LAVAPIPE = $(firstword $(wildcard $(addprefix /usr/share/vulkan/icd.d/, \
	lvp_icd.$(shell uname -m).json lvp_icd.json)))

# Where `make install` puts the C library, below DESTDIR where that is given, and how it is built.
PREFIX ?= /usr/local
LIBDIR ?= $(PREFIX)/lib
PROFILE ?= release
TARGET = $(or $(CARGO_TARGET_DIR),target)/$(patsubst dev,debug,$(PROFILE))

# The version, and the part of it that names the binary interface: all before 1.0 may change with a
# minor version.
VERSION = $(shell sed -n 's/^version = "\(.*\)"/\1/p' Cargo.toml)
ABI = $(shell echo $(VERSION) | sed 's/^\(0\.[0-9]*\|[1-9][0-9]*\)\..*/\1/')
# What the static library needs besides, by `rustc --print native-static-libs`.
PRIVATE = -lgcc_s -lutil -lrt -lpthread -lm -ldl -lc

.PHONY: help setup design spirv test check library install

help:
	@echo 'make design [SCENE=FILE] [OUT=FOLDER] [ARGS=...]  light a glTF scene, on Vulkan'
	@echo 'make test   run every test, on lavapipe with the Vulkan validation layers'
	@echo 'make check  look for badly formatted code and for lints'
	@echo 'make spirv  compile the shaders for builds without a shader compiler: after each change of a shader'
	@echo 'make install [PREFIX=FOLDER] [DESTDIR=FOLDER]     build and install the C library'
	@echo 'make setup  only install what the others need, where it is missing'

setup:
	@.ci/setup

design: setup
	cargo run --release -- design "$(SCENE)" --out "$(OUT)" --device vulkan $(ARGS)

# The checked-in SPIR-V, so that no shader compiler is needed.
library:
	cargo rustc --profile $(PROFILE) --lib --no-default-features --features c \
		--crate-type cdylib,staticlib -- -C link-arg=-Wl,-soname,libklieg.so.$(ABI)

install: library
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

test:
	@.ci/setup test
	$(if $(LAVAPIPE),VK_DRIVER_FILES=$(LAVAPIPE) VK_ICD_FILENAMES=$(LAVAPIPE)) cargo test

check: setup
	cargo fmt --all --check
	cargo clippy --all-targets -- -D warnings
	cargo clippy --no-default-features --lib -- -D warnings
	cargo clippy --no-default-features --features c --lib -- -D warnings
