/* Patches: exactly the arrays that a plan has, apart from each other, aligned. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <string.h>

#include "server/reconstruct/patch/patch.h"
#include "tests/unit/server/reconstruct/synthetic_paths.h"

/* Fills an array with a byte of its own; remembers it. */
struct arrays {
    uint8_t *at[64];
    size_t size_bytes[64];
    int count;
};

static void add(struct arrays *a, void *array, size_t size_bytes)
{
    assert_non_null(array);
    assert_int_equal((uintptr_t)array % 64, 0);
    a->at[a->count] = array;
    a->size_bytes[a->count] = size_bytes;
    memset(array, a->count + 1, size_bytes);
    a->count++;
}

static void add_rgb(struct arrays *a, float *const rgb[3], size_t size_bytes)
{
    for (int c = 0; c < 3; c++) add(a, rgb[c], size_bytes);
}

static void arrays_do_not_overlap(void **state)
{
    (void)state;
    struct plan plan;
    struct patch *p;
    struct arrays a = {.count = 0};
    synthetic_plan(&plan, 64, 64, 32);
    plan.planes |= PLANE_BIT(INDIRECT_HALVES) | PLANE_BIT(REFLECTOR) | PLANE_BIT(INDIRECT_STRATA) |
                   PLANE_BIT(OPEN);
    assert_int_equal(patch_create(&plan, (struct rect){3, 4, 10, 9}, &p), 0);
    size_t area = 35, bytes = area * 4;
    add(&a, p->depth, bytes);
    add(&a, p->id, bytes);
    add_rgb(&a, p->normal, bytes);
    add_rgb(&a, p->albedo, bytes);
    for (int k = 0; k < 3; k++) {
        add(&a, p->sub_depth[k], bytes);
        add(&a, p->sub_id[k], bytes);
        add_rgb(&a, p->sub_normal[k], bytes);
        add_rgb(&a, p->sub_albedo[k], bytes);
    }
    add_rgb(&a, p->emission, bytes);
    add_rgb(&a, p->indirect, bytes);
    add_rgb(&a, p->indirect_even, bytes);
    add_rgb(&a, p->indirect_odd, bytes);
    add(&a, p->reflector, bytes);
    add(&a, p->indirect_strata, bytes * 9 * 4);
    add(&a, p->open, bytes);
    add(&a, p->lights[0].irradiance, bytes);
    add(&a, p->lights[0].visibility, area * 2);
    add(&a, p->lights[0].slope_min, bytes);
    add(&a, p->lights[0].slope_max, bytes);
    for (int i = 0; i < a.count; i++) {
        for (size_t b = 0; b < a.size_bytes[i]; b++) assert_int_equal(a.at[i][b], i + 1);
    }
    patch_destroy(&p);
    assert_null(p);
    patch_destroy(&p);
}

static void paths_do_not_overlap(void **state)
{
    (void)state;
    struct plan plan;
    struct patch *p;
    struct arrays a = {.count = 0};
    synthetic_paths_plan(&plan, 64, 64, 32, 16);
    assert_int_equal(patch_create(&plan, (struct rect){3, 4, 10, 9}, &p), 0);
    const size_t bytes = 35 * sizeof(float);
    add(&a, p->depth, bytes);
    add(&a, p->paths.spp, bytes);
    add_rgb(&a, p->paths.radiance, bytes);
    add_rgb(&a, p->paths.spread, bytes);
    add_rgb(&a, p->paths.emission, bytes);
    add_rgb(&a, p->paths.direct, bytes);
    add_rgb(&a, p->paths.indirect, bytes);
    add_rgb(&a, p->paths.diffuse_direct, bytes);
    add_rgb(&a, p->paths.diffuse_indirect, bytes);
    add_rgb(&a, p->paths.albedo, bytes);
    add(&a, p->paths.coverage, bytes);
    add(&a, p->paths.open, bytes);
    for (int i = 0; i < a.count; i++)
        for (size_t b = 0; b < a.size_bytes[i]; b++) assert_int_equal(a.at[i][b], i + 1);
    patch_destroy(&p);
    plan.planes &= ~(PLANE_BIT(PATH_SPREAD) | PLANE_BIT(PATH_COVERAGE));
    assert_int_equal(patch_create(&plan, (struct rect){0, 0, 1, 1}, &p), 0);
    assert_non_null(p->paths.radiance[0]);
    assert_null(p->paths.spread[0]);
    assert_null(p->paths.coverage);
    patch_destroy(&p);
}

static void absent_planes_are_null(void **state)
{
    (void)state;
    struct plan plan;
    struct patch *p;
    synthetic_plan(&plan, 64, 64, 32);
    plan.planes = PLANE_BIT(DEPTH);
    plan.light_planes = 1u << LIGHT_PLANE_IRRADIANCE;
    plan.light_count = 2;
    plan.lights[1] = (struct plan_light){.type = LIGHT_POINT, .strata_per_axis = 1, .power = 1};
    assert_int_equal(patch_create(&plan, (struct rect){0, 0, 1, 1}, &p), 0);
    assert_non_null(p->depth);
    assert_null(p->normal[0]);
    assert_null(p->sub_depth[0]);
    assert_null(p->indirect[0]);
    assert_null(p->indirect_strata);
    assert_non_null(p->lights[0].irradiance);
    assert_null(p->lights[0].visibility);
    assert_non_null(p->lights[1].irradiance);
    assert_null(p->lights[1].slope_min);
    assert_null(p->lights[2].irradiance);
    assert_null(p->paths.spp);
    patch_destroy(&p);
}

static void an_empty_rect_is_refused(void **state)
{
    (void)state;
    struct plan plan;
    struct patch *p;
    synthetic_plan(&plan, 64, 64, 32);
    assert_int_equal(patch_create(&plan, (struct rect){5, 5, 5, 9}, &p), ERR_RANGE);
    assert_null(p);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(arrays_do_not_overlap),
        cmocka_unit_test(paths_do_not_overlap),
        cmocka_unit_test(absent_planes_are_null),
        cmocka_unit_test(an_empty_rect_is_refused),
    };
    return cmocka_run_group_tests_name("patch", tests, NULL, NULL);
}
