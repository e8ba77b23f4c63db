/* The table of heavy functions: blobs are told apart by their first bytes, loaded, traced with, and
 * wholly freed. */
#include <math.h>
#include <stdio.h>
#include <unistd.h>

#include "tests/unit/proto/scene/scene_case.h"
#include "tests/unit/unit.h"
#include "tests/unit/worker/scene/environment_fixture.h"
#include "tests/unit/worker/scene_fixture.h"
#include "worker/session/tracing.h"

static const struct tracing *const t = &tracing_embree;

static void write_blob(char path[40], const void *data, size_t size_bytes)
{
    strcpy(path, "/tmp/shearwater-test-tracing-XXXXXX");
    const int fd = mkstemp(path);
    assert_true(fd >= 0);
    assert_int_equal(write(fd, data, size_bytes), size_bytes);
    close(fd);
}

/* Loads what `data` holds. */
static int load(const void *data, size_t size_bytes, void **loaded, enum tracing_kind *kind,
                uint64_t *bytes, struct fault *fault)
{
    char path[40];
    struct tracing_cost cost = {0};
    _Atomic uint64_t steps = 0;
    *loaded = NULL;
    write_blob(path, data, size_bytes);
    const int error = t->load(t->ctx, path, NULL, 1, &steps, loaded, kind, &cost, fault);
    *bytes = cost.bytes;
    unlink(path);
    assert_int_equal(error == 0, *loaded != NULL);
    if (!error && *kind == TRACING_SCENE)
        assert_true(steps > 2 + 3); /* the device, three instances: the others are Embree's */
    return error;
}

static void load_scene(void **scene)
{
    static struct scene_case c;
    static _Alignas(64) uint8_t blob[SCENE_CASE_BYTES];
    enum tracing_kind kind;
    uint64_t bytes = 0;
    struct fault fault = {0};
    scene_case_init(&c);
    const size_t size_bytes = scene_case_lay_out(&c, blob);
    if (load(blob, size_bytes, scene, &kind, &bytes, &fault)) fail_msg("%s", fault.detail);
    assert_int_equal(kind, TRACING_SCENE);
    assert_true(bytes > size_bytes);
}

static void load_map(void **map, float radiance)
{
    float texels[3 * 8 * 4];
    struct environment_fixture f;
    enum tracing_kind kind;
    uint64_t bytes = 0;
    struct fault fault = {0};
    for (int i = 0; i < 96; i++) texels[i] = radiance;
    environment_fixture_open(&f, 8, 4, texels);
    if (load(f.blob.blob, f.blob.blob_bytes, map, &kind, &bytes, &fault))
        fail_msg("%s", fault.detail);
    assert_int_equal(kind, TRACING_ENVIRONMENT);
    assert_int_equal(bytes, f.blob.blob_bytes + environment_bytes(f.map));
    environment_fixture_close(&f);
}

/* Far from all things: every path leaves at once. */
static struct plan empty_view(void)
{
    struct plan p = fixture_plan(8, 8, (const float[3]){1e6f, 1e6f, 1e6f}, 0.1f);
    p.planes = PLANE_BIT(PATH_RADIANCE);
    p.light_planes = 0;
    p.paths.spp = 40;
    p.environment = (struct plan_environment){
        .kind = ENVIRONMENT_MAP, .radiance = {1.0f, 1.0f, 1.0f}, .power = 1.0f};
    return p;
}

static int trace(const void *scene, const void *environment, const struct plan *plan,
                 uint32_t number, struct bytes_writer *packed)
{
    const struct plan_pass pass = plan_scheduled_pass(plan, number);
    const struct rect all = {0, 0, plan->width_px, plan->height_px};
    _Atomic uint64_t progress = 0;
    _Atomic bool stop = false;
    struct counters counters = {0};
    const struct tracing_job job = {.scene = scene,
                                    .environment = environment,
                                    .plan = plan,
                                    .pass = &pass,
                                    .rect = all,
                                    .progress = &progress,
                                    .stop = &stop,
                                    .packing = PACKING_SMALL,
                                    .counters = &counters};
    void *tracer = NULL;
    assert_int_equal(t->tracer_create(t->ctx, &tracer), 0);
    const int error = t->trace(t->ctx, tracer, &job, packed);
    t->tracer_destroy(t->ctx, &tracer);
    assert_null(tracer);
    return error;
}

TEST(maps_shine_on_what_is_traced)
{
    const struct plan plan = empty_view();
    void *scene, *map;
    load_scene(&scene);
    load_map(&map, 0.75f);
    for (uint32_t pass = 0; pass < plan_pass_count(&plan); pass++) {
        struct bytes_writer packed;
        struct samples *samples = NULL;
        uint32_t first, count;
        bytes_writer_init(&packed);
        plan_pass_range(&plan, pass, &first, &count);
        assert_int_equal(trace(scene, map, &plan, pass, &packed), 0);
        struct fault fault = {0};
        if (samples_unpack(packed.data, packed.size_bytes, &plan, pass, 8, 8, &samples, &fault))
            fail_msg("%s: %s", fault.pointer, fault.detail);
        for (uint32_t c = 0; c < 3; c++) {
            const float *sums = samples_f32(samples, PLANE_PATH_RADIANCE, c);
            for (int i = 0; i < 8 * 8; i++)
                assert_true(fabsf(sums[i] - 0.75f * (float)count) < 1e-4f * (float)count);
        }
        samples_destroy(&samples);
        bytes_writer_fini(&packed);
    }
    t->unload(t->ctx, &map);
    t->unload(t->ctx, &scene);
    assert_null(map);
    assert_null(scene);
    t->unload(t->ctx, &scene);
}

/* They are refused as light, and seen as pictures. */
TEST(photographs_have_no_tables)
{
    float texels[3 * 8 * 4] = {0};
    const struct plan plan = empty_view();
    struct environment_fixture f;
    struct bytes_writer packed;
    enum tracing_kind kind;
    uint64_t bytes;
    struct fault fault = {0};
    void *scene, *plate;
    environment_fixture_open(&f, 8, 4, texels);
    ((struct environment_header *)f.blob.header)->flags = ENVIRONMENT_IS_PHOTOGRAPH;
    assert_int_equal(load(f.blob.blob, f.blob.blob_bytes, &plate, &kind, &bytes, &fault), 0);
    assert_int_equal(kind, TRACING_ENVIRONMENT);
    assert_int_equal(bytes, f.blob.blob_bytes);
    load_scene(&scene);
    bytes_writer_init(&packed);
    assert_int_equal(trace(scene, plate, &plan, 0, &packed), ERR_MAGIC);
    bytes_writer_fini(&packed);
    t->unload(t->ctx, &plate);
    t->unload(t->ctx, &scene);
    environment_fixture_close(&f);
}

TEST(kinds_are_not_mixed_up)
{
    const struct plan plan = empty_view();
    struct bytes_writer packed;
    void *scene, *map;
    load_scene(&scene);
    load_map(&map, 1.0f);
    bytes_writer_init(&packed);
    assert_int_equal(trace(map, scene, &plan, 0, &packed), ERR_MAGIC);
    assert_int_equal(trace(map, map, &plan, 0, &packed), ERR_MAGIC);
    assert_int_equal(trace(scene, scene, &plan, 0, &packed), ERR_MAGIC);
    assert_int_equal(trace(map, NULL, &plan, 0, &packed), ERR_MAGIC);
    bytes_writer_fini(&packed);
    t->unload(t->ctx, &map);
    t->unload(t->ctx, &scene);
}

TEST(what_is_no_blob_is_a_fault)
{
    enum tracing_kind kind;
    struct tracing_cost cost = {0};
    uint64_t bytes = 0;
    _Atomic uint64_t steps = 0;
    void *loaded = NULL;
    struct fault fault = {0};
    char cut[70] = ENVIRONMENT_MAGIC;
    assert_int_equal(load("", 0, &loaded, &kind, &bytes, &fault), ERR_TRUNCATED);
    assert_int_equal(load("abcd", 4, &loaded, &kind, &bytes, &fault), ERR_TRUNCATED);
    cut[8] = ENVIRONMENT_VERSION;
    assert_int_equal(load(cut, sizeof cut, &loaded, &kind, &bytes, &fault), ERR_LIMIT);
    assert_int_equal(t->load(t->ctx, "/tmp/shearwater-test-is-not-there", NULL, 1, &steps, &loaded,
                             &kind, &cost, &fault),
                     ERR_IO);
    assert_true(fault.detail[0] != '\0');
}
