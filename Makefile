# feeler: `make` builds, `make help` lists the other targets.

VERSION := 0.1.0
PREFIX ?= /usr/local
BUILD ?= build
ifeq ($(origin CC),default) # make's own
CC := gcc
endif
ifeq ($(origin CXX),default)
CXX := g++
endif
PYTHON ?= python3

# Every system package, once.
PACKAGES := gcc g++ make pkg-config ocl-icd-opencl-dev opencl-headers pocl-opencl-icd libyaml-dev libjansson-dev \
  libassimp-dev libembree-dev libopenimageio-dev python3-venv python3-dev

WARN := -Wall -Wextra -Wpedantic -Werror
LIBS := yaml-0.1 jansson assimp OpenCL
CFLAGS ?= -O2 -g
ALL_CFLAGS = -std=c11 $(WARN) -fPIC -fvisibility=hidden -ffp-contract=off -pthread -D_POSIX_C_SOURCE=200809L \
  -DFEELER_VERSION='"$(VERSION)"' -Ihost -Ikernels -I$(BUILD) $(shell pkg-config --cflags $(LIBS)) $(CFLAGS)
ALL_CXXFLAGS = -std=c++17 $(WARN) -fPIC -fvisibility=hidden -pthread -DFEELER_VERSION='"$(VERSION)"' -Ihost \
  $(shell pkg-config --cflags-only-I OpenImageIO | sed 's/-I/-isystem /g') $(CFLAGS)
# As host/tree.c includes it.
EMBREE = $(shell $(CXX) -E -x c++ -include embree4/rtcore.h /dev/null >/dev/null 2>&1 && echo embree4 || echo embree3)
LDLIBS = $(shell pkg-config --libs $(LIBS)) -l$(EMBREE) -lm -ldl

# Order matters: the kernels are one source, each file after what it uses.
KERNELS := $(addprefix kernels/,types.h features.cl lanes.cl numerics.cl ray.cl sphere.cl plane.cl disc.cl box.cl triangle.cl \
  polygon.cl cone.cl count.cl record.cl scene.cl optics.cl media.cl naive.cl instance.cl primitive.cl block.cl tree.cl traverse.cl \
  pencil.cl passage.cl margin.cl phong.cl camera.cl trace.cl pixel.cl render.cl survey.cl)

MAIN_SOURCES := host/main.c $(wildcard host/cmd_*.c) host/options.c host/progress.c
LIB_SOURCES := $(filter-out $(MAIN_SOURCES),$(wildcard host/*.c))
LIB_OBJECTS := $(LIB_SOURCES:host/%.c=$(BUILD)/%.o) $(BUILD)/kernel_source.o
MAIN_OBJECTS := $(MAIN_SOURCES:host/%.c=$(BUILD)/%.o) $(BUILD)/clock.o $(BUILD)/edits.o

.PHONY: all
all: $(BUILD)/feeler $(BUILD)/libfeeler-image.so $(BUILD)/feeler_cdef.h

# Never unloaded: the worker threads of Embree's TBB would go on in code that is no longer there.
$(BUILD)/libfeeler.so: $(LIB_OBJECTS)
	$(CC) -shared -pthread $(LDFLAGS) -Wl,-z,nodelete -o $@ $^ $(LDLIBS)

# What reads and writes pictures, with OpenImageIO, is loaded when it is needed: see host/image_plugin.c.
$(BUILD)/libfeeler-image.so: $(addprefix $(BUILD)/,image_io.o channels.o error.o)
	$(CXX) -shared -pthread $(LDFLAGS) -o $@ $^ -lOpenImageIO -lOpenImageIO_Util

# The program uses internal headers' functions never: only what the library exports.
$(BUILD)/feeler: $(MAIN_OBJECTS) $(BUILD)/libfeeler.so
	$(CC) -pthread $(LDFLAGS) -o $@ $(MAIN_OBJECTS) -L$(BUILD) -lfeeler -ljansson -Wl,-rpath,'$$ORIGIN:$$ORIGIN/../lib'

$(BUILD)/%.o: host/%.c | $(BUILD)
	$(CC) $(ALL_CFLAGS) -MMD -MP -c -o $@ $<

$(BUILD)/%.o: host/%.cpp | $(BUILD)
	$(CXX) $(ALL_CXXFLAGS) -MMD -MP -c -o $@ $<

$(BUILD)/kernel_source.o: $(BUILD)/kernel_source.c
	$(CC) $(ALL_CFLAGS) -c -o $@ $<

# The kernels as one C array, each file behind a #line so that a build error names it.
$(BUILD)/kernel_source.c: $(KERNELS) Makefile | $(BUILD)
	@{ echo 'extern const unsigned char feeler_kernel_text[];'; echo 'const unsigned char feeler_kernel_text[] = {'; \
	   for f in $(KERNELS); do echo "#line 1 \"$${f#kernels/}\""; cat $$f; done | od -An -v -tx1 | sed 's/ \(..\)/0x\1,/g'; \
	   echo '0};'; } > $@

# What OpenImageIO needs, the most basic first: see host/image_plugin.c. A name that is outdated later costs time only.
$(BUILD)/image_libraries.h: Makefile | $(BUILD)
	@ldd $$($(CC) -print-file-name=libOpenImageIO.so) | sed -n 's/^[ \t]*\([^ ]*\) => .*/"\1",/p' | tac > $@

$(BUILD)/image_plugin.o: $(BUILD)/image_libraries.h

# The public header without preprocessor lines, as cffi reads it.
$(BUILD)/feeler_cdef.h: host/feeler.h | $(BUILD)
	$(CC) -E -P -DFEELER_CDEF -D'__attribute__(x)=' $< | sed -n '/^typedef enum feeler_code/,$$p' > $@

$(BUILD):
	mkdir -p $@

-include $(wildcard $(BUILD)/*.d)

# ---- setting up

# What only the checks need, and what only the comparison with other renderers, once.
LINT_PACKAGES := clang clang-format libclang-rt-14-dev oclgrind valgrind
PEER_PACKAGES := povray libembree-dev
VENV := .venv
SUDO = $(if $(filter 0,$(shell id -u)),,sudo )

# Shell commands that install what is missing of the packages $(1); nothing is touched when nothing is missing.
install_missing = missing=; for p in $(1); do \
    dpkg-query -W -f '$${Status}' $$p 2>/dev/null | grep -q 'ok installed' || missing="$$missing $$p"; done; \
  if [ -n "$$missing" ]; then echo "installing:$$missing"; export DEBIAN_FRONTEND=noninteractive; \
    $(SUDO)apt-get update -qq && $(SUDO)apt-get install -y -qq --no-install-recommends $$missing >/dev/null; fi

.PHONY: help
help: ## this list
	@echo '`make` builds $(BUILD)/feeler and $(BUILD)/libfeeler.so. Other targets:'
	@sed -nE 's/^([a-z-]+):.*## (.*)/  \1\t\2/p' $(MAKEFILE_LIST) | expand -t 18

.PHONY: deps deps-lint
deps: ## install the system packages that are missing (Debian)
	@command -v dpkg-query >/dev/null || { echo 'not Debian: install the likes of $(PACKAGES)'; exit 1; }
	@$(call install_missing,$(PACKAGES))

deps-lint: deps ## and those of the checks
	@$(call install_missing,$(LINT_PACKAGES))

# Python with the package (editable) and everything that tests and charts need.
$(VENV)/ready: pyproject.toml setup.py
	$(PYTHON) -m venv $(VENV)
	$(VENV)/bin/pip install -q --disable-pip-version-check -e '.[test,charts,dev]'
	touch $@

# What needs the system packages is made by another make, so that `make -j` keeps the order; it takes every processor, unless
# this one was told how many.
JOBS = $(if $(filter -j%,$(MAKEFLAGS)),,-j$(shell nproc))
.PHONY: ready
ready: deps
	@$(MAKE) --no-print-directory $(JOBS) all $(VENV)/ready

# ---- using it

.PHONY: demo
demo: deps ## set up, build, and render build/demo.png
	@$(MAKE) --no-print-directory $(JOBS) all
	$(BUILD)/feeler render $(DEMO) -o $(BUILD)/demo.png
	@echo 'the picture is $(BUILD)/demo.png'

DEMO := scenes/first.yaml

# Every scene as a picture, again when the scene or the program has changed; the generated ones are made first.
GENERATED := sphereflake rings seashell
PICTURES := $(patsubst scenes/%.yaml,$(BUILD)/gallery/%.png,$(wildcard scenes/*.yaml)) $(GENERATED:%=$(BUILD)/gallery/%.png)
PROGRAM := $(BUILD)/feeler $(BUILD)/libfeeler.so
RENDER_PICTURE = $(BUILD)/feeler render $< -o $@ --size 640x480 --samples 16

.SECONDARY: $(GENERATED:%=$(BUILD)/scenes/%.yaml)
.PHONY: gallery
gallery: ready ## render every scene into build/gallery/, and the pictures of the documentation
	@$(MAKE) --no-print-directory docs/gallery.png docs/first.jpg docs/pixel.svg

docs/gallery.png: $(PICTURES) scenes/contact_sheet.py
	$(VENV)/bin/python scenes/contact_sheet.py $@ $(BUILD)/gallery

docs/first.jpg: scenes/first.yaml $(PROGRAM)
	$(BUILD)/feeler render $< -o $@ --samples 16

docs/pixel.svg: scenes/first.yaml $(PROGRAM)
	$(BUILD)/feeler pixel $< 400 300 --samples 1 --svg $@ > /dev/null

$(BUILD)/gallery/%.png: scenes/%.yaml $(PROGRAM) | $(BUILD)/gallery
	$(RENDER_PICTURE)

$(BUILD)/gallery/%.png: $(BUILD)/scenes/%.yaml $(PROGRAM) | $(BUILD)/gallery
	$(RENDER_PICTURE)

$(BUILD)/gallery/figure-16-1.png $(BUILD)/gallery/figure-16-1-shadow.png: scenes/parts/figure-16-1.yaml

$(BUILD)/scenes/seashell.yaml: scenes/generate_seashell.py | $(BUILD)/scenes
	$(PYTHON) $< $@

$(BUILD)/scenes/%.yaml: scenes/generate_%.py | $(BUILD)/scenes
	$(PYTHON) $< > $@ || { rm -f $@; exit 1; }

$(BUILD)/gallery $(BUILD)/scenes:
	mkdir -p $@

# Work groups on PoCL and on Intel's runtime, which is some 800 MB; docs/performance.md shows the charts.
INTEL := $(BUILD)/intel
CHARTED := scenes/first.yaml $(BUILD)/scenes/sphereflake.yaml

.PHONY: chart-work-groups
chart-work-groups: ready ## measure work groups on two OpenCL runtimes and draw them for docs/performance.md
	@$(MAKE) --no-print-directory $(INTEL)/ready $(CHARTED)
	$(VENV)/bin/python docs/chart_work_groups.py $(BUILD)/feeler $(BUILD)/charts $(INTEL) $(CHARTED)
	cp $(BUILD)/charts/work-groups-*.png docs

# Scenes of different nature: matte things without reflection, a smooth mesh, mirrors, nested media, many spheres, instances.
ACCURACY := scenes/figure-16-1-shadow.yaml $(BUILD)/scenes/seashell.yaml scenes/mirror-room.yaml scenes/water.yaml \
  $(BUILD)/scenes/sphereflake.yaml scenes/forest.yaml

.PHONY: chart-accuracy
chart-accuracy: ready ## measure time against error for six scenes and draw it for docs/performance.md (a quarter of an hour)
	@$(MAKE) --no-print-directory $(ACCURACY)
	mkdir -p $(BUILD)/charts
	$(BUILD)/feeler chart --size 96x72 $(ACCURACY) -o '$(BUILD)/charts/accuracy-{name}'
	$(BUILD)/feeler chart --size 96x72 --specialised $(ACCURACY) -o $(BUILD)/charts/accuracy-specialised
	cp $(BUILD)/charts/accuracy-*.png docs

$(INTEL)/ready: | $(BUILD)
	$(VENV)/bin/pip install -q --disable-pip-version-check --ignore-installed --prefix $(INTEL) intel-opencl-rt intel-cmplr-lib-rt
	touch $@

# Where ray-tracing methods fail, on the real kernels: tables, and the charts of docs/numerics.md.
STABILITY := PYTHONPATH=tests $(VENV)/bin/python -m stability

.PHONY: stability chart-stability
stability: ready | $(BUILD)/charts ## study every row of docs/numerics.md (ARGS='--row 1'); data in build/charts/stability.json
	$(STABILITY) --json $(BUILD)/charts/stability.json $(ARGS)

chart-stability: stability ## and draw the charts of docs/numerics.md
	$(VENV)/bin/python docs/chart_stability.py $(BUILD)/charts/stability.json $(BUILD)/charts
	cp $(BUILD)/charts/stability-*.svg docs

$(BUILD)/charts:
	mkdir -p $@

.PHONY: install uninstall
INTO = $(DESTDIR)$(PREFIX)
install: all ## install under PREFIX (/usr/local), below DESTDIR
	install -d $(addprefix $(INTO)/,bin include lib/pkgconfig share/feeler/kernels share/man/man1)
	install -m 755 $(BUILD)/feeler $(INTO)/bin
	install -m 755 $(BUILD)/libfeeler.so $(BUILD)/libfeeler-image.so $(INTO)/lib
	install -m 644 host/feeler.h $(INTO)/include
	install -m 644 $(KERNELS) $(INTO)/share/feeler/kernels
	install -m 644 docs/feeler.1 $(INTO)/share/man/man1
	printf '%s\n' 'prefix=$(PREFIX)' 'Name: feeler' 'Description: a Whitted ray tracer on OpenCL' \
	  'Version: $(VERSION)' 'Libs: -L$${prefix}/lib -lfeeler' 'Cflags: -I$${prefix}/include' > $(INTO)/lib/pkgconfig/feeler.pc

uninstall: ## remove what install has put there
	rm -rf $(addprefix $(INTO)/,bin/feeler lib/libfeeler.so lib/libfeeler-image.so lib/pkgconfig/feeler.pc include/feeler.h share/feeler \
	  share/man/man1/feeler.1)

# ---- checking it

.PHONY: test test-long test-peers
test: ready ## set up, build and test (ARGS= goes to pytest)
	$(VENV)/bin/pytest -q -n 2 --dist loadgroup --no-loadscope-reorder $(ARGS)

test-long: ready ## the tests that take minutes
	$(VENV)/bin/pytest -q -m slow $(ARGS)

test-peers: peers ## compare with other renderers; the difference images are in build/peers
	$(VENV)/bin/pytest -q -rs -m peers $(ARGS)

# A tracer of our own on Embree, to be measured beside us: as fast as Embree allows. Embree 4 where there is one.
PEER_CXXFLAGS := -std=c++17 -O3 -march=native -ffast-math $(WARN) -Wno-psabi
$(BUILD)/peers/embree_whitted: $(wildcard tests/peers/embree/*.[ch]pp)
	mkdir -p $(@D)
	$(CXX) $(PEER_CXXFLAGS) -o $@ $(filter %.cpp,$^) -l$(EMBREE) -lpthread

.PHONY: peers bench limit
peers: ready ## what we are compared with: installs POV-Ray, builds the tracer on Embree
	@$(call install_missing,$(PEER_PACKAGES)) || echo 'what is missing of $(PEER_PACKAGES) cannot be installed: it is left out'
	@$(MAKE) --no-print-directory $(BUILD)/peers/embree_whitted || echo 'without it'

bench: peers ## measure beside Embree, POV-Ray and itself (ARGS='--quick' or '--row NAME'; growth takes long)
	$(VENV)/bin/python tests/peers/bench.py $(ARGS)

limit: ready ## how far the traversal is from its limit: its steps counted, and each measured alone (minutes)
	$(VENV)/bin/python tests/peers/limit.py $(ARGS)

.PHONY: lint format check-exports
lint: deps-lint ready ## formatting, style, types, exported symbols, and clang's opinion
	clang-format --dry-run -Werror host/*.[ch] host/*.cpp kernels/* tests/peers/embree/*
	$(VENV)/bin/ruff check
	$(VENV)/bin/ruff format --check
	$(VENV)/bin/mypy
	@$(MAKE) --no-print-directory check-exports
	@$(MAKE) --no-print-directory BUILD=$(BUILD)/clang CC=clang CXX=clang++ CFLAGS=-O1 all

format: ## write every file as lint wants it
	clang-format -i host/*.[ch] host/*.cpp kernels/* tests/peers/embree/*
	$(VENV)/bin/ruff check --fix
	$(VENV)/bin/ruff format

# Templates of the C++ library are visible whatever the compiler is told, so the linker has a list.
$(BUILD)/libfeeler.so $(BUILD)/libfeeler-image.so: | host/feeler.map
$(BUILD)/libfeeler.so $(BUILD)/libfeeler-image.so: override LDFLAGS += -Wl,--version-script=host/feeler.map

check-exports: all
	@! nm -D --defined-only $(BUILD)/libfeeler.so $(BUILD)/libfeeler-image.so | grep " . " | grep -v ' feeler_' || { echo 'these must not leave the library'; exit 1; }

SANITIZE := -fsanitize=address,undefined -fno-sanitize-recover=undefined -fno-omit-frame-pointer
.PHONY: sanitize valgrind oclgrind
sanitize: deps ## the program over all scenes and bad inputs, with ASan, LSan and UBSan
	@$(MAKE) --no-print-directory all
	@$(MAKE) --no-print-directory BUILD=$(BUILD)/sanitize CFLAGS='-O1 -g $(SANITIZE)' LDFLAGS='$(SANITIZE)' all
	WARM=$(BUILD)/feeler tests/over_everything $(BUILD)/sanitize/feeler

valgrind: deps-lint all ## the readers over all scenes and some bad inputs, under valgrind
	tests/under_valgrind $(BUILD)/feeler

oclgrind: deps-lint all ## the kernels on a tiny picture of every scene, under oclgrind
	tests/under_oclgrind $(BUILD)/feeler

.PHONY: fuzz
FUZZ_SECONDS ?= 60
fuzz: deps-lint ## feed broken scenes to the readers under ASan (FUZZ_SECONDS=60)
	@$(MAKE) --no-print-directory BUILD=$(BUILD)/fuzz CC=clang CXX=clang++ \
	  CFLAGS='-O1 -g -fsanitize=fuzzer-no-link,address,undefined' LDFLAGS='-fsanitize=fuzzer,address,undefined' \
	  $(BUILD)/fuzz/fuzz_readers
	@mkdir -p $(BUILD)/fuzz/corpus
	@find scenes tests/invalid tests/data -name "*.yaml" -o -name "*.nff" | while read -r f; do \
	  cp "$$f" $(BUILD)/fuzz/corpus/$$(echo $$f | tr / _); done
	$(BUILD)/fuzz/fuzz_readers -max_total_time=$(FUZZ_SECONDS) -timeout=10 \
	  -rss_limit_mb=4096 -close_fd_mask=2 -artifact_prefix=$(BUILD)/fuzz/ $(BUILD)/fuzz/corpus

$(BUILD)/fuzz_readers: tests/fuzz_readers.c $(LIB_OBJECTS)
	$(CC) $(ALL_CFLAGS) -c -o $@.o $<
	$(CXX) -pthread $(LDFLAGS) -o $@ $@.o $(LIB_OBJECTS) $(LDLIBS)

# ---- cleaning up

.PHONY: clean distclean
clean: ## remove what was built
	rm -rf $(BUILD)

distclean: clean ## remove everything that git does not track and make can make again
	rm -rf $(VENV) gallery python/*.egg-info .pytest_cache .mypy_cache .ruff_cache .hypothesis
	find python tests -name __pycache__ -prune -exec rm -rf {} +
