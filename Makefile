# feeler: `make` builds, `make help` lists the other targets.

VERSION := 0.1.0
PREFIX ?= /usr/local
BUILD ?= build
CC ?= gcc
CXX ?= g++
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
LDLIBS = $(shell pkg-config --libs $(LIBS)) -lembree3 -lm

# Order matters: the kernels are one source, each file after what it uses.
KERNELS := $(addprefix kernels/,types.h features.h lanes.cl numerics.cl ray.cl sphere.cl plane.cl disc.cl box.cl triangle.cl \
  polygon.cl cone.cl primitive.cl tree.cl optics.cl media.cl phong.cl camera.cl trace.cl render.cl)

MAIN_SOURCES := host/main.c $(wildcard host/cmd_*.c) host/options.c host/progress.c
LIB_SOURCES := $(filter-out $(MAIN_SOURCES),$(wildcard host/*.c))
LIB_OBJECTS := $(LIB_SOURCES:host/%.c=$(BUILD)/%.o) $(BUILD)/image_io.o $(BUILD)/kernel_source.o
MAIN_OBJECTS := $(MAIN_SOURCES:host/%.c=$(BUILD)/%.o)

.PHONY: all
all: $(BUILD)/feeler $(BUILD)/feeler_cdef.h

$(BUILD)/libfeeler.so: $(LIB_OBJECTS)
	$(CXX) -shared -pthread $(LDFLAGS) -o $@ $^ $(LDLIBS) -lOpenImageIO -lOpenImageIO_Util

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
	@{ echo 'extern const char feeler_kernel_text[];'; echo 'const char feeler_kernel_text[] = {'; \
	   for f in $(KERNELS); do echo "#line 1 \"$${f#kernels/}\""; cat $$f; done | od -An -v -tx1 | sed 's/ \(..\)/0x\1,/g'; \
	   echo '0};'; } > $@

# The public header without preprocessor lines, as cffi reads it.
$(BUILD)/feeler_cdef.h: host/feeler.h | $(BUILD)
	$(CC) -E -P -DFEELER_CDEF -D'__attribute__(x)=' $< | sed -n '/^typedef enum feeler_code/,$$p' > $@

$(BUILD):
	mkdir -p $@

-include $(wildcard $(BUILD)/*.d)

.PHONY: clean
clean:
	rm -rf $(BUILD)
