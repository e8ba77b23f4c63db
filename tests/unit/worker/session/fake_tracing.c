#include "tests/unit/worker/session/fake_tracing.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

_Atomic bool hold, load_hangs, load_spins, traced_map;
_Atomic unsigned tracing, loads, unloads;
_Atomic int load_error;
_Atomic bool load_error_of_base;
_Atomic uint32_t traced_pass, traced_strata, traced_lobes, load_steps;

static const char *embree_version(void *ctx)
{
    (void)ctx;
    return "3.13.5";
}

static int find_base(void *ctx, const char *path, struct digest *base)
{
    (void)ctx;
    char magic[8] = "";
    FILE *file = fopen(path, "rb");
    *base = (struct digest){0};
    if (!file) return ERR_IO;
    if (fread(magic, 1, sizeof magic, file) == sizeof magic && memcmp(magic, FAKE_FRAME, 8) == 0)
        assert_int_equal(fread(base, 1, sizeof *base, file), sizeof *base);
    fclose(file);
    return 0;
}

static bool is_base_file(const char *path)
{
    char magic[8] = "";
    FILE *file = fopen(path, "rb");
    if (!file) return false;
    const bool is = fread(magic, 1, 8, file) == 8 && memcmp(magic, FAKE_BASE, 8) == 0;
    fclose(file);
    return is;
}

/* What is loaded is its kind; it is told by its first bytes. */
static int load(void *ctx, const char *path, const void *base, unsigned threads,
                _Atomic uint64_t *steps, void **loaded, enum tracing_kind *kind,
                struct tracing_cost *cost, struct fault *fault)
{
    (void)ctx;
    (void)threads;
    for (uint32_t i = 0; i < load_steps || load_hangs; i++) {
        if (!load_spins) usleep(1000 * LOAD_STEP_MS);
        if (!load_hangs) (*steps)++;
    }
    if (load_error && !base && (!load_error_of_base || is_base_file(path)))
        return fault_set(fault, load_error, "scene", "the fake gives it up");
    struct stat st;
    char magic[8] = "";
    if (stat(path, &st) != 0) return fault_set(fault, ERR_IO, path, "is not there");
    FILE *file = fopen(path, "rb");
    if (!file || fread(magic, 1, sizeof magic, file) != sizeof magic) abort();
    fclose(file);
    *kind = memcmp(magic, ENVIRONMENT_MAGIC, 8) == 0 ? TRACING_ENVIRONMENT
            : memcmp(magic, FAKE_BASE, 8) == 0       ? TRACING_BASE
                                                     : TRACING_SCENE;
    assert_int_equal(base != NULL, memcmp(magic, FAKE_FRAME, 8) == 0);
    if (base) assert_int_equal(*(const enum tracing_kind *)base, TRACING_BASE);
    *loaded = malloc(sizeof *kind);
    memcpy(*loaded, kind, sizeof *kind);
    *cost = (struct tracing_cost){
        .bytes = (uint64_t)st.st_size, .cpu_us = 1000, .reused_triangles = base ? 70 : 0};
    loads++;
    return 0;
}

static void unload(void *ctx, void **scene)
{
    (void)ctx;
    free(*scene);
    *scene = NULL;
    unloads++;
}

static int tracer_create(void *ctx, void **tracer)
{
    (void)ctx;
    *tracer = malloc(1);
    return 0;
}

static void tracer_destroy(void *ctx, void **tracer)
{
    (void)ctx;
    free(*tracer);
    *tracer = NULL;
}

static int trace(void *ctx, void *tracer, const struct tracing_job *job,
                 struct bytes_writer *packed)
{
    (void)ctx;
    const void *environment = job->environment;
    const struct plan_pass *pass = job->pass;
    const struct rect rect = job->rect;
    assert_true(tracer && job->scene && job->plan->width_px == 720);
    assert_int_equal(*(const enum tracing_kind *)job->scene, TRACING_SCENE);
    assert_int_equal(environment != NULL, job->plan->environment.kind == ENVIRONMENT_MAP);
    if (environment) assert_int_equal(*(const enum tracing_kind *)environment, TRACING_ENVIRONMENT);
    traced_pass = pass->number;
    uint32_t strata = 0;
    for (int64_t i = 0; pass->strata_map && i < rect_area(rect); i++) strata += pass->strata_map[i];
    traced_strata = strata;
    strata = 0;
    for (int64_t i = 0; pass->lobes && i < rect_area(rect); i++) strata += pass->lobes[i];
    traced_lobes = strata;
    traced_map = environment != NULL;
    tracing++;
    while (hold && !*job->stop) usleep(1000);
    *job->progress += (uint64_t)rect_height(rect);
    job->counters->value[COUNTER_RAYS_PRIMARY] = (uint64_t)rect_area(rect);
    bytes_write_u32(packed, (uint32_t)rect.x0);
    return *job->stop ? ERR_STATE : 0;
}

const struct tracing fake_tracing = {.capabilities = CAPABILITY_DIRECT,
                                     .embree_version = embree_version,
                                     .find_base = find_base,
                                     .load = load,
                                     .unload = unload,
                                     .tracer_create = tracer_create,
                                     .tracer_destroy = tracer_destroy,
                                     .trace = trace};
