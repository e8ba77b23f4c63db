/* Patches: exactly the arrays that a plan has, apart from each other, aligned. */
#include <string.h>

#include "server/reconstruct/patch/patch_array.h"
#include "tests/unit/server/reconstruct/synthetic.h"
#include "tests/unit/unit.h"

/* Fills an array with a byte of its own; remembers it. */
struct arrays {
    uint8_t *at[255];
    size_t size_bytes[255];
    int count;
};

static void add(struct arrays *a, void *array, size_t size_bytes)
{
    assert_non_null(array);
    assert_true((uintptr_t)array % 64 == 0 && a->count < 255);
    a->at[a->count] = array;
    a->size_bytes[a->count] = size_bytes;
    memset(array, a->count + 1, size_bytes);
    a->count++;
}

/* All of a plane's components have a place. */
static void add_plane(struct arrays *a, const struct plan *plan, const struct patch *p,
                      uint32_t slot, size_t area)
{
    uint32_t left = samples_components(plan, slot);
    assert_true(left > 0);
    for (const struct patch_array *array = patch_arrays(slot); array->pointers > 0; array++) {
        const uint32_t count = patch_array_holds(array, left), each = patch_array_each(array);
        const size_t size_bytes = area * array->element_bytes;
        if (array->stacked) add(a, patch_array_get(p, slot, array, 0), count * size_bytes);
        for (uint32_t i = 0; i < count * each && !array->stacked; i++)
            add(a, patch_array_get(p, slot, array, i), size_bytes);
        left -= count;
    }
    assert_int_equal(left, 0);
}

TEST(arrays_do_not_overlap)
{
    struct plan plan;
    struct patch *p;
    struct arrays a = {.count = 0};
    const size_t area = 35, bytes = area * sizeof(float);
    synthetic_plan(&plan, 64, 64, 32);
    plan.planes = PLANE_BIT(ID_COUNT) - 1;
    plan.lens_strata_per_axis = 2;
    plan.paths.spp = 16;
    plan.target_error = 1; /* rounds */
    plan.light_count = 2;
    plan.light_planes = (1u << LIGHT_PLANE_COUNT) - 1;
    plan.lights[1] = plan.lights[0];
    assert_int_equal(patch_create(&plan, (struct rect){3, 4, 10, 9}, &p), 0);
    for (uint32_t slot = 0; slot < samples_light_slot(2, 0); slot++)
        add_plane(&a, &plan, p, slot, area);
    float *const counts[] = {p->bounces,   p->glossy_rays,     p->lens_paths,
                             p->paths.spp, p->paths.split_spp, p->paths.split_length};
    for (size_t i = 0; i < sizeof counts / sizeof counts[0]; i++) add(&a, counts[i], bytes);
    for (int i = 0; i < a.count; i++) {
        for (size_t b = 0; b < a.size_bytes[i]; b++) assert_int_equal(a.at[i][b], i + 1);
    }
    assert_true((void *)p->depth == a.at[0] && (void *)p->normal[2] == a.at[3]);
    assert_true(p->sub_normal[2][2] && p->indirect_odd[2] && p->glossy_half_weight && p->lens_lobe);
    assert_true(p->lights[1].irradiance && p->lights[1].slope_max != p->lights[0].slope_max);
    patch_destroy(&p);
    assert_null(p);
    patch_destroy(&p);
}

TEST(absent_planes_are_null)
{
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
    assert_null(p->path_m2[0]);
    assert_non_null(p->lights[0].irradiance);
    assert_null(p->lights[0].visibility);
    assert_non_null(p->lights[1].irradiance);
    assert_null(p->lights[1].slope_min);
    assert_null(p->lights[2].irradiance);
    assert_null(p->paths.spp);
    patch_destroy(&p);
}

TEST(an_empty_rect_is_refused)
{
    struct plan plan;
    struct patch *p;
    synthetic_plan(&plan, 64, 64, 32);
    assert_int_equal(patch_create(&plan, (struct rect){5, 5, 5, 9}, &p), ERR_RANGE);
    assert_null(p);
}
