/* Frame plans: what is encoded comes back, nothing that is unsafe to trace does, and rays go where
 * the camera looks. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>

#include "tests/unit/proto/golden.h"
#include "tests/unit/proto/plan_case.h"

static void encode(const struct plan *plan, struct bytes_writer *w)
{
    bytes_writer_init(w);
    plan_encode(w, plan);
    assert_false(w->failed);
}

/* Memory of exactly the size, so that a sanitizer sees a read beyond. */
static int decode(const uint8_t *data, size_t size_bytes, struct plan *out, struct fault *fault)
{
    uint8_t *exact = malloc(size_bytes + (size_bytes == 0));
    assert_non_null(exact);
    memcpy(exact, data, size_bytes);
    const int error = plan_decode(exact, size_bytes, out, fault);
    free(exact);
    return error;
}

static void plans_round_trip(void **state)
{
    static struct plan sent, got;
    (void)state;
    for (uint32_t lights = 0; lights <= 4; lights++) {
        struct bytes_writer w, again;
        struct fault fault = {0};
        plan_case(&sent);
        sent.light_count = lights;
        if (lights == 2) {
            sent.indirect_filter = INDIRECT_FILTER_RATE;
            sent.rate = (struct plan_rate){.mu = 2.5f, .rays_most = 4711};
            sent.planes &=
                ~(PLANE_BIT(INDIRECT_HALVES) | PLANE_BIT(INDIRECT_STRATA) | PLANE_BIT(GLOSSY_HALF));
        }
        encode(&sent, &w);
        memset(&got, 0xee, sizeof got);
        if (decode(w.data, w.size_bytes, &got, &fault))
            fail_msg("%s: %s", fault.pointer, fault.detail);
        encode(&got, &again);
        assert_int_equal(w.size_bytes, again.size_bytes);
        assert_memory_equal(w.data, again.data, w.size_bytes);
        assert_memory_equal(&sent.camera, &got.camera, sizeof sent.camera);
        assert_memory_equal(&sent.environment, &got.environment, sizeof sent.environment);
        assert_memory_equal(&sent.paths, &got.paths, sizeof sent.paths);
        assert_int_equal(sent.shadow_filter, got.shadow_filter);
        assert_true(sent.mu == got.mu);
        assert_true(sent.rate.mu == got.rate.mu && sent.rate.rays_most == got.rate.rays_most);
        assert_memory_equal(sent.lights, got.lights, lights * sizeof sent.lights[0]);
        assert_int_equal(sent.pattern.seed, got.pattern.seed);
        bytes_writer_fini(&w);
        bytes_writer_fini(&again);
    }
}

static void bytes_are_golden(void **state)
{
    static struct plan plan;
    struct bytes_writer w;
    (void)state;
    plan_case(&plan);
    encode(&plan, &w);
    golden_check("tests/golden/wire/plan.bin", w.data, w.size_bytes);
    bytes_writer_fini(&w);
}

static void cut_and_grown_plans_fail(void **state)
{
    static struct plan plan, got;
    struct bytes_writer w;
    struct fault fault;
    (void)state;
    plan_case(&plan);
    encode(&plan, &w);
    for (size_t size_bytes = 0; size_bytes < w.size_bytes; size_bytes++)
        assert_int_equal(decode(w.data, size_bytes, &got, &fault), ERR_TRUNCATED);
    bytes_write_u8(&w, 0);
    assert_int_equal(decode(w.data, w.size_bytes, &got, &fault), ERR_TRAILING);
    bytes_writer_fini(&w);
}

/* Changes one thing in the plan and expects a fault, or none for ERR_OK. */
#define EXPECT(change, expected, place)                                                            \
    do {                                                                                           \
        static struct plan plan, got;                                                              \
        struct bytes_writer w;                                                                     \
        struct fault fault = {0};                                                                  \
        plan_case(&plan);                                                                          \
        change;                                                                                    \
        encode(&plan, &w);                                                                         \
        const int error = decode(w.data, w.size_bytes, &got, &fault);                              \
        if (error != (expected) || strcmp(fault.pointer, place) != 0)                              \
            fail_msg(#change " gives %s at \"%s\": %s", error_name(error), fault.pointer,          \
                     fault.detail);                                                                \
        if (expected) assert_true(fault.code == (expected) && fault.detail[0]);                    \
        bytes_writer_fini(&w);                                                                     \
    } while (0)

static void without_lens(struct plan *plan)
{
    plan->camera.aperture_radius = 0;
    plan->planes &= ~PLANES_LENS;
    plan->lens_strata_per_axis = plan->lens_light = 0;
}

static void images_are_checked(void **state)
{
    (void)state;
    EXPECT(plan.width_px = 0, ERR_RANGE, "width_px");
    EXPECT(plan.width_px = INT32_MIN, ERR_RANGE, "width_px");
    EXPECT(plan.width_px = LIMIT_IMAGE_SIDE_PX + 1, ERR_LIMIT, "width_px");
    EXPECT(plan.height_px = -1, ERR_RANGE, "height_px");
    EXPECT(plan.height_px = INT32_MAX, ERR_LIMIT, "height_px");
    EXPECT(plan.width_px = plan.height_px = 16384, ERR_LIMIT, "height_px");
    EXPECT((plan.width_px = 16384, plan.height_px = 8192), ERR_OK, "");
    EXPECT(plan.tile_px = LIMIT_TILE_SIDE_MIN_PX - 1, ERR_RANGE, "tile_px");
    EXPECT(plan.tile_px = LIMIT_TILE_SIDE_PX + 1, ERR_LIMIT, "tile_px");
}

static void cameras_are_checked(void **state)
{
    (void)state;
    EXPECT(plan.camera.type = 2, ERR_RANGE, "camera.type");
    EXPECT(plan.camera.eye[1] = NAN, ERR_NOT_FINITE, "camera.eye");
    EXPECT(plan.camera.eye[1] = INFINITY, ERR_NOT_FINITE, "camera.eye");
    EXPECT(plan.camera.eye[2] = 2e15f, ERR_RANGE, "camera.eye");
    EXPECT(plan.camera.right[0] = 1.1f, ERR_RANGE, "camera.right");
    EXPECT(plan.camera.right[0] = 0, ERR_RANGE, "camera.right");
    EXPECT(plan.camera.up[1] = NAN, ERR_NOT_FINITE, "camera.up");
    EXPECT((plan.camera.up[0] = 0.6f, plan.camera.up[1] = 0.8f), ERR_RANGE, "camera.up");
    EXPECT(plan.camera.forward[2] = 1, ERR_RANGE, "camera.forward");
    EXPECT((plan.camera.forward[0] = 1, plan.camera.forward[2] = 0), ERR_RANGE, "camera.forward");
    EXPECT(plan.camera.half_width = 0, ERR_RANGE, "camera.half_width");
    EXPECT(plan.camera.half_width = 1e6f, ERR_RANGE, "camera.half_width");
    EXPECT(plan.camera.half_height = -1, ERR_RANGE, "camera.half_height");
    EXPECT(plan.camera.half_height = INFINITY, ERR_NOT_FINITE, "camera.half_height");
    EXPECT((plan.camera.type = CAMERA_ORTHOGRAPHIC, without_lens(&plan),
            plan.camera.half_width = 1e6f),
           ERR_OK, "");
}

static void lenses_are_checked(void **state)
{
    (void)state;
    EXPECT(plan.camera.aperture_radius = -1, ERR_RANGE, "camera.aperture_radius");
    EXPECT(plan.camera.aperture_radius = NAN, ERR_NOT_FINITE, "camera.aperture_radius");
    EXPECT(plan.camera.aperture_radius = 2e15f, ERR_RANGE, "camera.aperture_radius");
    EXPECT(plan.camera.focus_distance = 0, ERR_RANGE, "camera.focus_distance");
    EXPECT(plan.camera.focus_distance = -4, ERR_RANGE, "camera.focus_distance");
    EXPECT(plan.camera.focus_distance = INFINITY, ERR_NOT_FINITE, "camera.focus_distance");
    EXPECT((plan.camera.focus_distance = 0, without_lens(&plan)), ERR_OK, "");
    EXPECT(plan.camera.blade_count = 0, ERR_OK, "");
    EXPECT(plan.camera.blade_count = 2, ERR_RANGE, "camera.blade_count");
    EXPECT(plan.camera.blade_count = 3, ERR_OK, "");
    EXPECT(plan.camera.blade_count = LIMIT_LENS_BLADES, ERR_OK, "");
    EXPECT(plan.camera.blade_count = LIMIT_LENS_BLADES + 1, ERR_LIMIT, "camera.blade_count");
    EXPECT(plan.camera.blade_rotation_rad = NAN, ERR_NOT_FINITE, "camera.blade_rotation_rad");
    EXPECT(plan.camera.type = CAMERA_ORTHOGRAPHIC, ERR_RANGE, "camera.aperture_radius");
}

/* Samples of the lens belong to a lens and have a radiance; filters of them read slopes. */
static void lens_samples_are_checked(void **state)
{
    const uint64_t radiance = PLANE_BIT(LENS_RADIANCE), slope = PLANE_BIT(LENS_SLOPE);
    (void)state;
    EXPECT(plan.lens_strata_per_axis = 1, ERR_OK, "");
    EXPECT(plan.lens_strata_per_axis = LIMIT_PLANE_STRATA_PER_AXIS, ERR_OK, "");
    EXPECT(plan.lens_strata_per_axis = 0, ERR_RANGE, "lens_strata_per_axis");
    EXPECT(plan.lens_strata_per_axis = LIMIT_PLANE_STRATA_PER_AXIS + 1, ERR_LIMIT,
           "lens_strata_per_axis");
    EXPECT(plan.planes &= ~radiance, ERR_LIMIT, "lens_strata_per_axis");
    EXPECT((plan.planes &= ~radiance, plan.lens_strata_per_axis = 0), ERR_RANGE, "planes");
    EXPECT(plan.planes &= ~slope, ERR_RANGE, "planes");
    EXPECT((plan.planes &= ~(slope | PLANES_LENS_SURFACE), plan.lens_light = 0), ERR_OK, "");
    EXPECT((plan.planes &= ~PLANES_LENS, plan.lens_strata_per_axis = plan.lens_light = 0), ERR_OK,
           "");
    EXPECT(plan.camera.aperture_radius = 0, ERR_RANGE, "planes");
    EXPECT(plan.lens_filter = LENS_FILTER_AXIS_ALIGNED, ERR_OK, "");
    EXPECT(plan.lens_filter = LENS_FILTER_SHEARED, ERR_OK, "");
    EXPECT(plan.lens_filter = LENS_FILTER_SHEARED + 1, ERR_RANGE, "lens_filter");
    EXPECT((plan.lens_filter = LENS_FILTER_SHEARED, plan.planes &= ~slope), ERR_RANGE, "planes");
    EXPECT((plan.target_error = 1, plan.spp_most = 256,
            plan.planes &= ~(PLANE_BIT(INDIRECT_MEAN) | PLANE_BIT(INDIRECT_STRATA))),
           ERR_RANGE, "target_error");
}

#define LOBES                                                                                      \
    plan.planes |= PLANE_BIT(LENS_LOBE), plan.lens_light = LENS_LIGHT_INDIRECT,                    \
                                         plan.glossy_filter = GLOSSY_FILTER_VIRTUAL_HIT

/* Light fields that light lens samples are there, and all that these tell of their surfaces. */
static void light_of_lens_samples_is_checked(void **state)
{
    const uint64_t surface = PLANES_LENS_SURFACE;
    (void)state;
    EXPECT(plan.lens_light = LENS_LIGHT_SKY + 1, ERR_RANGE, "lens_light");
    EXPECT((plan.lens_light = LENS_LIGHT_SKY, plan.environment.kind = ENVIRONMENT_CONSTANT), ERR_OK,
           "");
    EXPECT((plan.lens_light = LENS_LIGHT_SKY,
            plan.environment = (struct plan_environment){.kind = ENVIRONMENT_NONE}),
           ERR_RANGE, "lens_light");
    EXPECT(plan.lens_light = LENS_LIGHT_INDIRECT, ERR_OK, "");
    EXPECT(plan.lens_light = LENS_LIGHT_OWN, ERR_RANGE, "planes");
    EXPECT(plan.planes &= ~surface, ERR_RANGE, "planes");
    EXPECT(plan.planes &= ~PLANE_BIT(LENS_LIGHT), ERR_RANGE, "planes");
    EXPECT((plan.lens_light = LENS_LIGHT_OWN, plan.planes &= ~surface), ERR_OK, "");
    EXPECT((LOBES), ERR_OK, "");
    EXPECT((LOBES, plan.lens_light = LENS_LIGHT_DIFFUSE), ERR_RANGE, "planes");
    EXPECT((LOBES, plan.glossy_filter = GLOSSY_FILTER_NONE), ERR_RANGE, "planes");
    EXPECT((LOBES, plan.lens_light = LENS_LIGHT_OWN, plan.planes &= ~surface), ERR_RANGE, "planes");
    EXPECT(plan.planes &= ~PLANE_BIT(NORMAL), ERR_RANGE, "planes");
    EXPECT((plan.lens_light = LENS_LIGHT_INDIRECT, plan.indirect_strata_per_axis = 0,
            plan.planes &= ~(PLANES_BOUNCE_RAYS | PLANES_GLOSSY), plan.bounces = 0,
            plan.occlusion_distance = 0, plan.planes &= ~PLANE_BIT(PATH_OCCLUSION)),
           ERR_RANGE, "planes");
}

/* Mirrors are looked through where fields light what they show; each is a scattering. */
static void mirrors_are_checked(void **state)
{
    (void)state;
    EXPECT((plan.lens_light = LENS_LIGHT_INDIRECT, plan.lens_mirrors = 1), ERR_OK, "");
    EXPECT((plan.lens_light = LENS_LIGHT_INDIRECT, plan.lens_mirrors = 2), ERR_LIMIT,
           "lens_mirrors");
    EXPECT((plan.lens_light = LENS_LIGHT_INDIRECT, plan.bounces = 9, plan.lens_mirrors = 4), ERR_OK,
           "");
    EXPECT((plan.lens_light = LENS_LIGHT_INDIRECT, plan.bounces = 9, plan.lens_mirrors = 5),
           ERR_LIMIT, "lens_mirrors");
    EXPECT(plan.lens_mirrors = 1, ERR_LIMIT, "lens_mirrors");
    EXPECT((plan.lens_light = LENS_LIGHT_INDIRECT, plan.lens_mirrors = 1,
            plan.indirect_filter = INDIRECT_FILTER_SHEARED),
           ERR_LIMIT, "lens_mirrors");
    EXPECT((LOBES, plan.lens_rest = 1), ERR_OK, "");
    EXPECT((LOBES, plan.lens_rest = 2), ERR_LIMIT, "lens_rest");
    EXPECT(plan.lens_rest = 1, ERR_LIMIT, "lens_rest");
}

static void environments_are_checked(void **state)
{
    (void)state;
    EXPECT(plan.environment.kind = 3, ERR_RANGE, "environment.kind");
    EXPECT(plan.environment.kind = ENVIRONMENT_CONSTANT, ERR_OK, "");
    EXPECT(plan.environment.radiance[1] = -1, ERR_RANGE, "environment.radiance");
    EXPECT(plan.environment.radiance[1] = 1e13f, ERR_RANGE, "environment.radiance");
    EXPECT(plan.environment.radiance[2] = NAN, ERR_NOT_FINITE, "environment.radiance");
    EXPECT(plan.environment.rotation_rad = INFINITY, ERR_NOT_FINITE, "environment.rotation_rad");
    EXPECT(plan.environment.power = 0, ERR_RANGE, "environment.power");
    EXPECT(plan.environment.power = NAN, ERR_NOT_FINITE, "environment.power");
    EXPECT((plan.environment.kind = ENVIRONMENT_NONE, plan.environment.power = 0), ERR_OK, "");
}

static void paths_are_checked(void **state)
{
    const uint64_t spread = PLANE_BIT(PATH_SPREAD), radiance = PLANE_BIT(PATH_RADIANCE),
                   open = PLANE_BIT(PATH_OCCLUSION) | PLANE_BIT(OPEN);
    (void)state;
    EXPECT(plan.paths.spp = LIMIT_SPP, ERR_OK, "");
    EXPECT(plan.paths.spp = LIMIT_SPP + 1, ERR_LIMIT, "paths.spp");
    EXPECT(plan.occlusion_distance = -1, ERR_RANGE, "occlusion_distance");
    EXPECT(plan.occlusion_distance = NAN, ERR_NOT_FINITE, "occlusion_distance");
    EXPECT(plan.paths.pixel_filter = PIXEL_FILTER_TENT + 1, ERR_LIMIT, "paths.pixel_filter");
    EXPECT(plan.paths.emitter_power = -1, ERR_RANGE, "paths.emitter_power");
    EXPECT(plan.paths.emitter_power = INFINITY, ERR_NOT_FINITE, "paths.emitter_power");
    EXPECT(plan.paths.emitter_power = 0, ERR_OK, "");
    EXPECT(plan.paths.spp = 0, ERR_RANGE, "planes");
    EXPECT((plan.paths = (struct plan_paths){0}, plan.planes &= ~PLANES_PATH), ERR_OK, "");
    EXPECT((plan.occlusion_distance = 0, plan.planes &= ~PLANES_PATH), ERR_RANGE, "planes");
    EXPECT(plan.paths.without_diffuse_indirect = 1, ERR_OK, "");
    EXPECT(plan.paths.without_diffuse_indirect = 2, ERR_LIMIT, "paths.without_diffuse_indirect");
    EXPECT((plan.paths.without_diffuse_indirect = 1, plan.planes = PLANES_PATH), ERR_RANGE,
           "planes");
    EXPECT(plan.occlusion_distance = 0, ERR_RANGE, "planes");
    EXPECT(plan.planes &= ~open, ERR_RANGE, "planes");
    EXPECT((plan.planes &= ~open, plan.occlusion_distance = 0), ERR_OK, "");
    EXPECT(plan.planes &= ~radiance, ERR_RANGE, "planes");
    EXPECT(plan.planes &= ~(radiance | spread), ERR_OK, "");
    EXPECT(plan.planes &= ~spread, ERR_OK, "");
}

/* Filters of glossy lobes need their planes; paths leave out what planes bring. */
static void glossy_filters_are_checked(void **state)
{
    const uint64_t lobe = PLANE_BIT(GLOSSY_LOBE), near = PLANE_BIT(GLOSSY_NEARNESS);
    const uint64_t light = PLANE_BIT(INDIRECT_MEAN) | PLANE_BIT(INDIRECT_HALVES) |
                           PLANE_BIT(INDIRECT_STRATA) | PLANE_BIT(REFLECTOR) | PLANE_BIT(OPEN);
    (void)state;
    EXPECT(plan.glossy_filter = GLOSSY_FILTER_VIRTUAL_HIT, ERR_OK, "");
    EXPECT(plan.glossy_filter = GLOSSY_FILTER_BANDLIMIT, ERR_OK, "");
    EXPECT(plan.glossy_filter = GLOSSY_FILTER_BANDLIMIT + 1, ERR_RANGE, "glossy_filter");
    EXPECT((plan.glossy_filter = GLOSSY_FILTER_VIRTUAL_HIT, plan.planes &= ~near), ERR_RANGE,
           "planes");
    EXPECT((plan.glossy_filter = GLOSSY_FILTER_BANDLIMIT, plan.planes &= ~PLANE_BIT(ID)), ERR_RANGE,
           "planes");
    EXPECT(plan.paths.without_glossy_indirect = 1, ERR_LIMIT, "paths.without_glossy_indirect");
    EXPECT((plan.paths.without_diffuse_indirect = plan.paths.without_glossy_indirect = 1), ERR_OK,
           "");
    EXPECT((plan.paths.without_diffuse_indirect = plan.paths.without_glossy_indirect = 1,
            plan.planes &= ~lobe),
           ERR_RANGE, "planes");
    EXPECT((plan.planes &= ~light, plan.occlusion_distance = 0,
            plan.planes &= ~PLANE_BIT(PATH_OCCLUSION)),
           ERR_OK, "");
    EXPECT((plan.planes &= ~light, plan.occlusion_distance = 0,
            plan.planes &= ~PLANE_BIT(PATH_OCCLUSION), plan.indirect_strata_per_axis = 0),
           ERR_RANGE, "indirect_strata_per_axis");
}

/* Filters of indirect light need their planes, and planes their rays. */
static void indirect_filters_are_checked(void **state)
{
    const uint64_t reflector = PLANE_BIT(REFLECTOR), strata = PLANE_BIT(INDIRECT_STRATA);
    const uint64_t light = PLANE_BIT(INDIRECT_MEAN) | PLANE_BIT(INDIRECT_HALVES) | strata;
    (void)state;
    EXPECT(plan.indirect_filter = INDIRECT_FILTER_CONSTANT, ERR_OK, "");
    EXPECT(plan.indirect_filter = INDIRECT_FILTER_SHEARED, ERR_OK, "");
    EXPECT(plan.indirect_filter = INDIRECT_FILTER_SHEARED + 1, ERR_RANGE, "indirect_filter");
    EXPECT((plan.indirect_filter = INDIRECT_FILTER_LINEAR, plan.planes &= ~reflector), ERR_RANGE,
           "planes");
    EXPECT((plan.indirect_filter = INDIRECT_FILTER_SHEARED, plan.planes &= ~strata), ERR_RANGE,
           "planes");
    EXPECT((plan.indirect_filter = INDIRECT_FILTER_SHEARED, plan.planes &= ~reflector), ERR_RANGE,
           "planes");
    EXPECT((plan.bounces = 0), ERR_RANGE, "planes");
    EXPECT((plan.bounces = 0, plan.planes &= ~(light | PLANES_GLOSSY)), ERR_OK,
           ""); /* occlusion alone */
    EXPECT((plan.bounces = 0, plan.planes &= ~light), ERR_RANGE, "planes");
}

#define RATE                                                                                       \
    (plan.indirect_filter = INDIRECT_FILTER_RATE, plan.rate.mu = 1.5f, plan.rate.rays_most = 100,  \
     plan.planes &=                                                                                \
     ~(PLANE_BIT(INDIRECT_HALVES) | PLANE_BIT(INDIRECT_STRATA) | PLANE_BIT(GLOSSY_HALF)))

/* A rate belongs to one filter, which has means and distances and no target. */
static void rates_are_checked(void **state)
{
    (void)state;
    EXPECT(RATE, ERR_OK, "");
    EXPECT((RATE, plan.indirect_filter = INDIRECT_FILTER_LINEAR), ERR_RANGE, "rate.mu");
    EXPECT((RATE, plan.rate.mu = 0), ERR_RANGE, "rate.mu");
    EXPECT((RATE, plan.rate.mu = -1), ERR_RANGE, "rate.mu");
    EXPECT((RATE, plan.rate.mu = LIMIT_FILTER_MU), ERR_OK, "");
    EXPECT((RATE, plan.rate.mu = LIMIT_FILTER_MU + 1), ERR_RANGE, "rate.mu");
    EXPECT((RATE, plan.rate.mu = NAN), ERR_NOT_FINITE, "rate.mu");
    EXPECT((RATE, plan.rate.rays_most = 0), ERR_RANGE, "rate.mu");
    EXPECT((RATE, plan.rate.rays_most = 8), ERR_RANGE, "rate.rays_most"); /* the first are nine */
    EXPECT((RATE, plan.rate.rays_most = 9), ERR_OK, "");
    EXPECT((RATE, plan.rate.rays_most = LIMIT_SPP), ERR_OK, "");
    EXPECT((RATE, plan.rate.rays_most = LIMIT_SPP + 1), ERR_LIMIT, "rate.rays_most");
    EXPECT((RATE, plan.planes &= ~PLANE_BIT(REFLECTOR_FAR)), ERR_RANGE, "planes");
    EXPECT((RATE, plan.planes &= ~PLANE_BIT(REFLECTOR)), ERR_RANGE, "planes");
    EXPECT((RATE, plan.planes |= PLANE_BIT(INDIRECT_HALVES)), ERR_RANGE, "indirect_filter");
    EXPECT((RATE, plan.planes |= PLANE_BIT(INDIRECT_STRATA)), ERR_RANGE, "indirect_filter");
    EXPECT((RATE, plan.planes |= PLANE_BIT(GLOSSY_HALF)), ERR_RANGE, "indirect_filter");
    EXPECT((RATE, plan.planes &= ~(PLANE_BIT(INDIRECT_MEAN) | PLANES_GLOSSY),
            plan.target_error = 0.1f, plan.spp_most = 200),
           ERR_RANGE, "indirect_filter");
    EXPECT((RATE, plan.planes &= ~PLANE_BIT(INDIRECT_MEAN)), ERR_OK, ""); /* occlusion alone */
    EXPECT((RATE, plan.planes &= ~PLANE_BIT(GLOSSY_NEARNESS), plan.glossy_filter = 0,
            plan.paths.without_glossy_indirect = 0),
           ERR_RANGE, "planes");
    EXPECT((RATE, plan.planes &= ~PLANE_BIT(GLOSSY_SPAN)), ERR_OK, "");
}

#define EXTRA                                                                                      \
    (plan.lens_extra = 9, plan.lens_filter = LENS_FILTER_SHEARED,                                  \
     plan.planes |= PLANE_BIT(LENS_MORE))

/* Second sets through the lens belong to its sheared filter, and have their plane. */
static void lens_extra_is_checked(void **state)
{
    (void)state;
    EXPECT(EXTRA, ERR_OK, "");
    EXPECT((EXTRA, plan.lens_extra = 36), ERR_OK, "");
    EXPECT((EXTRA, plan.lens_extra = 37), ERR_LIMIT, "lens_extra");
    EXPECT((EXTRA, plan.lens_extra = 0), ERR_RANGE, "planes");
    EXPECT((EXTRA, plan.planes &= ~PLANE_BIT(LENS_MORE)), ERR_RANGE, "planes");
    EXPECT((EXTRA, plan.lens_filter = LENS_FILTER_AXIS_ALIGNED), ERR_RANGE, "lens_extra");
    EXPECT((EXTRA, RATE), ERR_RANGE, "lens_extra");
}

static void second_sets_through_the_lens_are_checked(void **state)
{
    static struct plan plan;
    static const uint8_t sides[] = {0, 6, 0, 6};
    (void)state;
    plan_case(&plan);
    EXTRA;
    const uint32_t last = plan_pass_count(&plan);
    struct plan_pass pass = {.number = last, .strata = PLAN_LENS_SIDE, .sides = sides};
    assert_true(plan_has_rounds(&plan));
    assert_int_equal(plan_side_maps(&plan), 1); /* though it asks how far lobes see */
    assert_true(plan_pass_planes(&plan, last) == PLANES_LENS_MORE);
    assert_int_equal(plan_pass_check(&plan, &pass), 0);
    assert_int_equal(plan_sides_check(&pass, 4), 0);
    pass.lobes = sides;
    assert_int_equal(plan_pass_check(&plan, &pass), ERR_RANGE);
    pass.lobes = NULL;
    pass.strata = 5;
    assert_int_equal(plan_pass_check(&plan, &pass), ERR_RANGE);
    pass.strata = 7;
    assert_int_equal(plan_pass_check(&plan, &pass), ERR_RANGE);
    pass = (struct plan_pass){.number = last + 1, .strata = PLAN_LENS_SIDE, .sides = sides};
    assert_int_equal(plan_pass_check(&plan, &pass), ERR_RANGE);
    pass = (struct plan_pass){.number = last, .strata = PLAN_LENS_SIDE};
    assert_int_equal(plan_pass_check(&plan, &pass), ERR_RANGE);
}

/* The second set follows the schedule, once, with sides. */
static void second_sets_are_checked(void **state)
{
    static struct plan plan;
    static const uint8_t sides[] = {0, 3, 9, 1};
    (void)state;
    plan_case(&plan);
    RATE;
    plan.planes &= ~PLANE_BIT(GLOSSY_SPAN);
    const uint32_t last = plan_pass_count(&plan);
    struct plan_pass pass;
    assert_true(plan_has_rounds(&plan));
    assert_int_equal(plan_side_maps(&plan), 1);
    assert_int_equal(plan_pass_planes(&plan, last), PLANE_BIT(INDIRECT_MEAN) | PLANE_BIT(OPEN));
#define SECOND(change, code)                                                                       \
    do {                                                                                           \
        pass = (struct plan_pass){.number = last, .strata = 9, .sides = sides};                    \
        change;                                                                                    \
        assert_int_equal(plan_pass_check(&plan, &pass), code);                                     \
    } while (0)
    SECOND((void)0, 0);
    SECOND(pass.strata = 1, 0);
    SECOND(pass.strata = 0, ERR_RANGE);
    SECOND(pass.strata = 10, ERR_LIMIT); /* 9 + 100 rays are above 100 */
    SECOND(pass.number = last + 1, ERR_RANGE);
    SECOND(pass.number = last - 1, ERR_RANGE);
    SECOND(pass.number = LIMIT_PASSES, ERR_LIMIT);
    SECOND(pass.count = 1, ERR_RANGE);
    SECOND(pass.first = 1, ERR_RANGE);
    SECOND(pass.sides = NULL, ERR_RANGE);
    SECOND(pass.lobes = sides, ERR_RANGE); /* the plan does not ask how far they see */
    plan.rate.rays_most = LIMIT_SPP;
    SECOND(pass.strata = PLAN_SIDE_MOST, 0);
    SECOND(pass.strata = PLAN_SIDE_MOST + 1, ERR_LIMIT);
    SECOND(pass.strata = UINT32_MAX, ERR_LIMIT);
    SECOND((void)0, 0);
    assert_int_equal(plan_sides_check(&pass, 4), 0);
    assert_int_equal(plan_sides_check(&pass, 2), ERR_RANGE); /* none of them is the largest */
    pass.strata = 8;
    assert_int_equal(plan_sides_check(&pass, 4), ERR_RANGE); /* one of them is above it */
    struct plan_pass first = plan_scheduled_pass(&plan, 0);
    assert_int_equal(plan_pass_check(&plan, &first), 0);
    first.sides = sides;
    assert_int_equal(plan_pass_check(&plan, &first), ERR_RANGE);
    first.sides = NULL;
    first.lobes = sides;
    assert_int_equal(plan_pass_check(&plan, &first), ERR_RANGE);
    plan.indirect_filter = INDIRECT_FILTER_LINEAR;
    SECOND((void)0, ERR_RANGE);
    assert_int_equal(plan_side_maps(&plan), 0);
    assert_false(plan_has_rounds(&plan));
#undef SECOND
}

/* Where the plan asks how far glossy lobes see, they have second sets, too. */
static void second_sets_of_lobes_are_checked(void **state)
{
    static struct plan plan;
    static const uint8_t few[] = {0, 3, 1, 2}, many[] = {9, 0, 0, 1};
    (void)state;
    plan_case(&plan);
    assert_int_equal(plan_side_maps(&plan), 0);
    RATE;
    const uint32_t last = plan_pass_count(&plan);
    assert_int_equal(plan_side_maps(&plan), 2);
    assert_int_equal(plan_pass_planes(&plan, last),
                     PLANE_BIT(INDIRECT_MEAN) | PLANE_BIT(OPEN) | PLANE_BIT(GLOSSY_MEAN));
    struct plan_pass pass = {.number = last, .strata = 9, .sides = few, .lobes = many};
    assert_int_equal(plan_pass_check(&plan, &pass), 0);
    assert_int_equal(plan_sides_check(&pass, 4), 0);
    pass.sides = many;
    pass.lobes = few;
    assert_int_equal(plan_sides_check(&pass, 4), 0);
    pass.sides = few;
    assert_int_equal(plan_sides_check(&pass, 4), ERR_RANGE); /* none of them is the largest */
    pass.lobes = many;
    pass.strata = 8;
    assert_int_equal(plan_sides_check(&pass, 4), ERR_RANGE); /* one of them is above it */
    pass.lobes = NULL;
    assert_int_equal(plan_pass_check(&plan, &pass), ERR_RANGE);
}

/* Paths need nothing of the light field. */
static void paths_stand_alone(void **state)
{
    (void)state;
    EXPECT((plan.planes = PLANES_PATH, plan.light_planes = 0, plan.sub_samples = 0,
            plan.indirect_strata_per_axis = plan.lens_strata_per_axis = plan.lens_light = 0,
            plan.bounces = LIMIT_INDIRECT_BOUNCES),
           ERR_OK, "");
    EXPECT((plan.planes = PLANES_PATH,
            plan.indirect_strata_per_axis = plan.lens_strata_per_axis = plan.lens_light = 0,
            plan.bounces = 0),
           ERR_OK, "");
    EXPECT((plan.planes = PLANES_PATH, plan.light_planes = 1u << LIGHT_PLANE_SLOPES,
            plan.indirect_strata_per_axis = 1, plan.lens_strata_per_axis = plan.lens_light = 0),
           ERR_LIMIT, "indirect_strata_per_axis");
}

static void lights_are_checked(void **state)
{
    (void)state;
    EXPECT(plan.lights[0].type = 4, ERR_RANGE, "lights[0].type");
    EXPECT(plan.lights[0].profile = 2, ERR_RANGE, "lights[0].profile");
    EXPECT(plan.lights[0].position[0] = NAN, ERR_NOT_FINITE, "lights[0].position");
    EXPECT(plan.lights[0].position[0] = -1e16f, ERR_RANGE, "lights[0].position");
    EXPECT(plan.lights[0].direction[0] = NAN, ERR_NOT_FINITE, "lights[0].direction");
    EXPECT(plan.lights[0].half_u[0] = INFINITY, ERR_NOT_FINITE, "lights[0].half_u");
    EXPECT(plan.lights[0].color[2] = -1, ERR_RANGE, "lights[0].color");
    EXPECT(plan.lights[0].color[2] = 1e13f, ERR_RANGE, "lights[0].color");
    EXPECT(plan.lights[0].color[2] = 0, ERR_OK, "");
    EXPECT(plan.lights[0].range = -1, ERR_RANGE, "lights[0].range");
    EXPECT(plan.lights[0].range = NAN, ERR_NOT_FINITE, "lights[0].range");
    EXPECT(plan.lights[0].power = 0, ERR_RANGE, "lights[0].power");
    EXPECT(plan.lights[0].power = INFINITY, ERR_NOT_FINITE, "lights[0].power");
    EXPECT(plan.lights[0].strata_per_axis = 2, ERR_LIMIT, "lights[0].strata_per_axis");
    EXPECT(plan.lights[1].direction[1] = -0.5f, ERR_RANGE, "lights[1].direction");
    EXPECT(plan.lights[1].cos_inner = 0.7f, ERR_RANGE, "lights[1].cos_inner");
    EXPECT(plan.lights[1].cos_inner = 1.5f, ERR_RANGE, "lights[1].cos_inner");
    EXPECT(plan.lights[1].cos_outer = -0.1f, ERR_RANGE, "lights[1].cos_outer");
    EXPECT(plan.lights[1].cos_outer = NAN, ERR_NOT_FINITE, "lights[1].cos_outer");
    EXPECT(plan.lights[2].direction[0] = 0, ERR_RANGE, "lights[2].direction");
    EXPECT(plan.lights[3].half_u[0] = 0, ERR_RANGE, "lights[3].half_u");
    EXPECT(plan.lights[3].half_v[2] = NAN, ERR_NOT_FINITE, "lights[3].half_v");
    EXPECT((plan.lights[3].half_v[0] = 1, plan.lights[3].half_v[2] = 1e-7f), ERR_RANGE,
           "lights[3].half_v");
    EXPECT(plan.lights[3].half_u[0] = -0.5f, ERR_RANGE, "lights[3].direction");
    EXPECT(plan.lights[3].strata_per_axis = 0, ERR_RANGE, "lights[3].strata_per_axis");
    EXPECT(plan.lights[3].strata_per_axis = 17, ERR_LIMIT, "lights[3].strata_per_axis");
    EXPECT((plan.lights[3].strata_per_axis = 256, plan.light_planes = 1), ERR_OK, "");
    EXPECT((plan.lights[3].strata_per_axis = 257, plan.light_planes = 1), ERR_LIMIT,
           "lights[3].strata_per_axis");
}

static void planes_and_counts_are_checked(void **state)
{
    (void)state;
    EXPECT(plan.planes |= PLANE_BIT(ID_COUNT), ERR_RANGE, "planes");
    EXPECT(plan.light_planes |= 1u << LIGHT_PLANE_COUNT, ERR_RANGE, "light_planes");
    EXPECT(plan.capabilities = 1u << 31, ERR_RANGE, "capabilities");
    EXPECT(plan.sub_samples = 4, ERR_LIMIT, "sub_samples");
    EXPECT(plan.sub_samples = 0, ERR_RANGE, "planes");
    EXPECT(plan.planes &= ~PLANE_BIT(DEPTH), ERR_RANGE, "planes");
    EXPECT((plan.bounces = 0, plan.indirect_strata_per_axis = 0), ERR_RANGE, "planes");
    EXPECT(plan.bounces = LIMIT_INDIRECT_BOUNCES + 1, ERR_LIMIT, "bounces");
    EXPECT(plan.indirect_strata_per_axis = 0, ERR_RANGE, "indirect_strata_per_axis");
    EXPECT(plan.indirect_strata_per_axis = 17, ERR_LIMIT, "indirect_strata_per_axis");
    EXPECT((plan.indirect_strata_per_axis = 256, plan.planes &= ~PLANE_BIT(INDIRECT_STRATA)),
           ERR_OK, "");
    EXPECT((plan.bounces = 0, plan.planes = 1, plan.paths = (struct plan_paths){0},
            plan.occlusion_distance = 0, plan.lens_strata_per_axis = plan.lens_light = 0),
           ERR_LIMIT, "indirect_strata_per_axis");
    EXPECT((plan.planes = 0, plan.occlusion_distance = 0, plan.light_planes = 0,
            plan.sub_samples = 0, plan.indirect_strata_per_axis = 0,
            plan.lens_strata_per_axis = plan.lens_light = 0, plan.paths = (struct plan_paths){0}),
           ERR_OK, "");
    EXPECT(plan.radiance_scale = 0.3f, ERR_RANGE, "radiance_scale");
    EXPECT(plan.radiance_scale = 0, ERR_RANGE, "radiance_scale");
    EXPECT(plan.radiance_scale = -1, ERR_RANGE, "radiance_scale");
    EXPECT(plan.length_unit = 3, ERR_RANGE, "length_unit");
    EXPECT(plan.length_unit = NAN, ERR_NOT_FINITE, "length_unit");
}

/* A filtered plan: of light fields alone. */
static void filtered_case(struct plan *plan)
{
    plan->paths = (struct plan_paths){0};
    plan->planes &= ~PLANES_PATH;
    plan->shadow_filter = SHADOW_FILTER_SHEARED;
}

/* Lone sub-samples are for pinholes. */
static void lone_case(struct plan *plan)
{
    plan->paths = (struct plan_paths){0};
    plan->camera.aperture_radius = 0.0f;
    plan->lens_strata_per_axis = plan->lens_light = 0;
    plan->planes = (plan->planes & ~(PLANES_PATH | PLANES_LENS_ALL)) | PLANE_BIT(LONE);
    plan->occlusion_distance = 1.0f;
}

static void lone_sub_samples_are_checked(void **state)
{
    static const int compared[] = {PLANE_DEPTH,      PLANE_NORMAL,     PLANE_ID,    PLANE_SUB_DEPTH,
                                   PLANE_SUB_NORMAL, PLANE_SUB_ALBEDO, PLANE_SUB_ID};
    (void)state;
    EXPECT(lone_case(&plan), ERR_OK, "");
    for (size_t i = 0; i < sizeof compared / sizeof compared[0]; i++)
        EXPECT((lone_case(&plan), plan.planes &= ~(UINT64_C(1) << compared[i])), ERR_RANGE,
               "planes");
    EXPECT((lone_case(&plan), plan.camera.aperture_radius = 0.1f), ERR_RANGE, "planes");
    EXPECT((lone_case(&plan), plan.tile_px = 36), ERR_RANGE, "tile_px");
    EXPECT((lone_case(&plan), plan.tile_px = 40), ERR_OK, "");
    EXPECT((lone_case(&plan), plan.planes |= UINT64_C(1) << 62), ERR_RANGE, "planes");
    /* Nothing would light them. */
    EXPECT((lone_case(&plan), plan.planes &= ~(PLANES_BOUNCE_LIGHT | PLANES_GLOSSY),
            plan.light_planes = 0),
           ERR_RANGE, "planes");
    EXPECT((lone_case(&plan), plan.planes &= ~(PLANES_BOUNCE_LIGHT | PLANES_GLOSSY)), ERR_OK, "");
}

static void filters_are_checked(void **state)
{
    (void)state;
    EXPECT(filtered_case(&plan), ERR_OK, "");
    EXPECT((filtered_case(&plan), plan.shadow_filter = SHADOW_FILTER_AXIS_ALIGNED), ERR_OK, "");
    EXPECT((filtered_case(&plan), plan.shadow_filter = 3), ERR_RANGE, "shadow_filter");
    EXPECT(plan.shadow_filter = SHADOW_FILTER_SHEARED, ERR_RANGE, "shadow_filter");
    EXPECT((filtered_case(&plan), plan.planes &= ~PLANE_BIT(NORMAL)), ERR_RANGE, "planes");
    EXPECT((filtered_case(&plan), plan.planes &= ~(PLANE_BIT(SUB_DEPTH) | PLANE_BIT(DEPTH))),
           ERR_RANGE, "planes");
    EXPECT((filtered_case(&plan), plan.light_planes &= ~(1u << LIGHT_PLANE_SLOPES)), ERR_RANGE,
           "light_planes");
    EXPECT((filtered_case(&plan), plan.light_planes &= ~(1u << LIGHT_PLANE_VISIBILITY)), ERR_RANGE,
           "light_planes");
    EXPECT((filtered_case(&plan), plan.light_planes &= ~(1u << LIGHT_PLANE_IRRADIANCE)), ERR_OK,
           "");
    EXPECT((filtered_case(&plan), plan.lights[3].strata_per_axis = 17), ERR_LIMIT,
           "lights[3].strata_per_axis");
    EXPECT(plan.mu = 0, ERR_RANGE, "mu");
    EXPECT(plan.mu = -1, ERR_RANGE, "mu");
    EXPECT(plan.mu = 100, ERR_OK, "");
    EXPECT(plan.mu = 100.5f, ERR_RANGE, "mu");
    EXPECT(plan.mu = NAN, ERR_NOT_FINITE, "mu");
    EXPECT(plan.mu = INFINITY, ERR_NOT_FINITE, "mu");
}

static void light_count_is_checked(void **state)
{
    static struct plan plan, got;
    struct bytes_writer w;
    struct fault fault = {0};
    (void)state;
    plan_case(&plan);
    plan.light_count = 0;
    encode(&plan, &w);
    memset(w.data + w.size_bytes - 4, 0xff, 4); /* the count is last but the lights */
    assert_int_equal(decode(w.data, w.size_bytes, &got, &fault), ERR_LIMIT);
    assert_string_equal(fault.pointer, "light_count");
    w.data[w.size_bytes - 4] = LIMIT_LIGHTS;
    memset(w.data + w.size_bytes - 3, 0, 3);
    assert_int_equal(decode(w.data, w.size_bytes, &got, &fault), ERR_TRUNCATED);
    bytes_writer_fini(&w);
}

static void light_planes_follow_the_type(void **state)
{
    static struct plan plan;
    (void)state;
    plan_case(&plan);
    for (uint32_t filter = 0; filter <= SHADOW_FILTER_SHEARED; filter++) {
        plan.shadow_filter = filter;
        for (uint32_t k = 0; k < 3; k++)
            assert_int_equal(plan_light_planes(&plan, k), 1u << LIGHT_PLANE_IRRADIANCE);
        assert_int_equal(plan_light_planes(&plan, 3),
                         filter ? 1u << LIGHT_PLANE_VISIBILITY | 1u << LIGHT_PLANE_SLOPES
                                : PLAN_CASE_LIGHT_PLANES);
    }
    plan.light_planes = 1u << LIGHT_PLANE_SLOPES;
    assert_int_equal(plan_light_planes(&plan, 0), 0);
}

static void is_near(float got, double expected)
{
    if (!(fabs((double)got - expected) < 1e-6)) fail_msg("%g is not %g", (double)got, expected);
}

static void rays_follow_the_camera(void **state)
{
    static struct plan plan;
    float origin[3], direction[3];
    (void)state;
    plan_case(&plan);
    plan_camera_ray(&plan, 360, 240, origin, direction);
    assert_memory_equal(origin, plan.camera.eye, sizeof origin);
    assert_memory_equal(direction, plan.camera.forward, sizeof direction);
    plan_camera_ray(&plan, 0, 0, origin, direction); /* top left */
    const double length = sqrt(0.75 * 0.75 + 0.5 * 0.5 + 1);
    is_near(direction[0], -0.75 / length);
    is_near(direction[1], 0.5 / length);
    is_near(direction[2], -1 / length);
    is_near(plan_pixel_size(&plan, 10), 10 * 1.5 / 720);
    plan.camera.type = CAMERA_ORTHOGRAPHIC;
    plan_camera_ray(&plan, 720, 480, origin, direction); /* bottom right */
    is_near(origin[0], 0.75);
    is_near(origin[1], 0.5);
    is_near(origin[2], 5);
    assert_memory_equal(direction, plan.camera.forward, sizeof direction);
    is_near(plan_pixel_size(&plan, 10), 1.5 / 720);
}

static void passes_cover_all_samples_once(void **state)
{
    static const uint32_t lengths[] = {16, 16, 32};
    static struct plan plan;
    (void)state;
    plan_case(&plan);
    for (uint32_t spp = 1; spp <= LIMIT_SPP; spp += spp < 2000 ? 1 : 997) {
        uint32_t first, count, sum = 0;
        plan.paths.spp = spp;
        const uint32_t passes = plan_pass_count(&plan);
        assert_in_range(passes, 1, LIMIT_PASSES);
        for (uint32_t p = 0; p < passes; p++) {
            plan_pass_range(&plan, p, &first, &count);
            const uint32_t full = p < 3 ? lengths[p] : LIMIT_PASS_SPP;
            assert_int_equal(first, sum);
            assert_int_equal(plan_pass_spp(&plan, p), sum);
            assert_int_equal(count, p + 1 < passes || full < spp - sum ? full : spp - sum);
            sum += count;
        }
        assert_int_equal(sum, spp);
        assert_int_equal(plan_pass_spp(&plan, passes), spp);
        plan_pass_range(&plan, passes, &first, &count);
        assert_true(first == spp && count == 0);
    }
}

static void passes_are_bounded(void **state)
{
    static struct plan plan;
    uint32_t first, count;
    (void)state;
    plan_case(&plan);
    plan.paths.spp = LIMIT_SPP;
    assert_int_equal(plan_pass_count(&plan), LIMIT_PASSES);
    plan_pass_range(&plan, UINT32_MAX - 1, &first, &count);
    assert_true(first == LIMIT_SPP && count == 0);
    plan.paths.spp = 0;
    assert_int_equal(plan_pass_count(&plan), 1);
    assert_int_equal(plan_pass_spp(&plan, 1), 0);
    plan_pass_range(&plan, 0, &first, &count);
    assert_true(first == 0 && count == 0);
}

static void passes_after_the_schedule_are_checked(void **state)
{
    static struct plan plan;
    (void)state;
    plan_case(&plan);
    plan.paths.spp = 16;
    for (uint32_t p = 0; p < 2; p++) {
        const struct plan_pass pass = plan_scheduled_pass(&plan, p);
        assert_int_equal(plan_pass_check(&plan, &pass), p == 0 ? 0 : ERR_RANGE);
    }
    struct plan_pass pass = {1, 16, 48, 4, NULL, NULL};
    assert_int_equal(plan_pass_check(&plan, &pass), ERR_RANGE); /* no target */
    plan.target_error = 0.1f;
#define PASS(change, code)                                                                         \
    do {                                                                                           \
        pass = (struct plan_pass){1, 16, 48, 4, NULL, NULL};                                       \
        change;                                                                                    \
        assert_int_equal(plan_pass_check(&plan, &pass), code);                                     \
    } while (0)
    PASS((void)0, 0);
    PASS(pass.number = LIMIT_PASSES - 1, 0);
    PASS(pass.number = LIMIT_PASSES, ERR_LIMIT);
    PASS(pass.number = 0, ERR_RANGE); /* that is the schedule's */
    PASS(pass.strata = 0, 0);
    PASS(pass.strata = 3, ERR_RANGE);
    PASS(pass.strata = 8, 0);
    PASS(pass.strata = 10, ERR_LIMIT);
    PASS(pass.strata = 0x10000, ERR_LIMIT); /* whose square is 0 in 32 bits */
    PASS(pass.count = 0, 0);
    PASS((pass.count = 0, pass.strata = 0), ERR_RANGE);
    PASS(pass.count = LIMIT_PASS_SPP + 1, ERR_LIMIT);
    PASS(pass.first = LIMIT_SPP - 48, 0);
    PASS(pass.first = LIMIT_SPP - 47, ERR_LIMIT);
    PASS(pass.first = UINT32_MAX, ERR_LIMIT);
    plan.indirect_strata_per_axis = 0;
    PASS((void)0, ERR_RANGE);
    PASS(pass.strata = 0, 0);
    plan.paths.spp = 0;
    PASS(pass.strata = 0, ERR_RANGE);
#undef PASS
}

static void passes_are_split_where_the_sequence_is(void **state)
{
    static const struct {
        uint32_t first, count;
        struct plan_split split;
    } cases[] = {
        {0, 0, {0, 0, 0}},     {0, 1, {0, 0, 0}},    {3, 2, {0, 0, 0}},
        {0, 2, {0, 2, 1}},     {0, 9, {0, 8, 1}},    {16, 16, {16, 16, 1}},
        {32, 32, {32, 32, 1}}, {9, 31, {16, 16, 1}}, {16, 48, {32, 32, 1}},
        {8, 24, {16, 16, 1}},  {40, 16, {40, 8, 2}}, {65472, 64, {65472, 64, 1}},
    };
    (void)state;
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        const struct plan_pass pass = {0, cases[k].first, cases[k].count, 0, NULL, NULL};
        const struct plan_split split = plan_pass_split(&pass);
        assert_memory_equal(&split, &cases[k].split, sizeof split);
    }
}

static void targets_are_checked(void **state)
{
    const uint64_t other = PLANE_BIT(INDIRECT_MEAN) | PLANE_BIT(INDIRECT_STRATA) | PLANES_GLOSSY;
    (void)state;
#define TARGET(change, code, place)                                                                \
    EXPECT((plan.target_error = 0.02f, plan.spp_most = 256, plan.planes &= ~other,                 \
            without_lens(&plan), change),                                                          \
           code, place)
    TARGET(plan.spp_most = LIMIT_SPP, ERR_OK, "");
    TARGET(plan.spp_most = LIMIT_SPP + 1, ERR_LIMIT, "spp_most");
    TARGET(plan.spp_most = 0, ERR_RANGE, "spp_most");
    TARGET(plan.target_error = 0, ERR_RANGE, "spp_most");
    TARGET(plan.target_error = -1, ERR_RANGE, "target_error");
    TARGET(plan.target_error = NAN, ERR_NOT_FINITE, "target_error");
    TARGET(plan.planes &= ~PLANE_BIT(PATH_SPREAD), ERR_RANGE, "target_error");
    TARGET(plan.planes &= ~PLANE_BIT(PATH_SPLIT), ERR_RANGE, "target_error");
    TARGET(plan.planes |= PLANE_BIT(INDIRECT_MEAN), ERR_RANGE, "target_error");
    TARGET(plan.planes |= PLANES_GLOSSY, ERR_OK, "");
    TARGET(plan.planes |= PLANES_GLOSSY & ~PLANE_BIT(GLOSSY_HALF), ERR_RANGE, "target_error");
    TARGET(plan.planes |= PLANES_GLOSSY & ~PLANE_BIT(GLOSSY_MEAN), ERR_RANGE, "planes");
    TARGET(plan.planes &= ~PLANE_BIT(REFLECTOR), ERR_RANGE, "target_error");
#undef TARGET
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(plans_round_trip),
        cmocka_unit_test(bytes_are_golden),
        cmocka_unit_test(cut_and_grown_plans_fail),
        cmocka_unit_test(images_are_checked),
        cmocka_unit_test(cameras_are_checked),
        cmocka_unit_test(lenses_are_checked),
        cmocka_unit_test(lens_samples_are_checked),
        cmocka_unit_test(light_of_lens_samples_is_checked),
        cmocka_unit_test(mirrors_are_checked),
        cmocka_unit_test(environments_are_checked),
        cmocka_unit_test(paths_are_checked),
        cmocka_unit_test(indirect_filters_are_checked),
        cmocka_unit_test(rates_are_checked),
        cmocka_unit_test(lens_extra_is_checked),
        cmocka_unit_test(second_sets_through_the_lens_are_checked),
        cmocka_unit_test(second_sets_are_checked),
        cmocka_unit_test(second_sets_of_lobes_are_checked),
        cmocka_unit_test(glossy_filters_are_checked),
        cmocka_unit_test(paths_stand_alone),
        cmocka_unit_test(passes_cover_all_samples_once),
        cmocka_unit_test(passes_are_bounded),
        cmocka_unit_test(passes_after_the_schedule_are_checked),
        cmocka_unit_test(passes_are_split_where_the_sequence_is),
        cmocka_unit_test(targets_are_checked),
        cmocka_unit_test(lights_are_checked),
        cmocka_unit_test(planes_and_counts_are_checked),
        cmocka_unit_test(light_count_is_checked),
        cmocka_unit_test(filters_are_checked),
        cmocka_unit_test(lone_sub_samples_are_checked),
        cmocka_unit_test(light_planes_follow_the_type),
        cmocka_unit_test(rays_follow_the_camera),
    };
    return cmocka_run_group_tests_name("plan", tests, NULL, NULL);
}
