/* All lights of a scene together, and odd ones. */
#include <math.h>
#include <stdlib.h>

#include "tests/unit/unit.h"
#include "tests/unit/worker/trace/path/path_fixture.h"

/* Points, spots, rectangles, a directional light and shining meshes over the room. */
static struct plan lit_room(struct scene_fixture *f, uint32_t points, uint32_t meshes[3])
{
    struct plan p = room(f);
    p.bounces = 1;
    p.paths.spp = 256;
    fixture_ceiling_light(&p, -1.5f, 0.4f, 1, 0.1f, 1)->color[1] = 9.0f;
    for (uint32_t k = 0; k < points; k++) {
        struct plan_light *l = fixture_light(&p, k % 3 ? LIGHT_POINT : LIGHT_SPOT, 1);
        const float at[3] = {0.7f * (float)(k % 4) - 1.0f, 0.2f + 0.1f * (float)k,
                             0.5f * (float)(k / 4) - 1.0f};
        memcpy(l->position, at, sizeof at);
        l->direction[0] = l->direction[2] = 0.0f, l->direction[1] = -1.0f;
        l->cos_outer = 0.3f, l->cos_inner = 0.8f;
        for (int c = 0; c < 3; c++) l->color[c] = 0.1f;
    }
    struct plan_light *sun = fixture_light(&p, LIGHT_DIRECTIONAL, 1);
    sun->direction[0] = 0.6f, sun->direction[1] = -0.8f, sun->direction[2] = 0.0f;
    for (uint32_t k = 0; k < 3; k++) {
        const float at[3] = {1.2f - 0.8f * (float)k, 0.05f + 0.3f * (float)k, -1.2f};
        meshes[k] = fixture_material(f, 0, 0, 0);
        fixture_panel(f, meshes[k], at, (float[]){0.1f, 0, 0}, (float[]){0, 0, 0.1f});
    }
    return p;
}

/* Adds what the tile's passes from `from` on hold to `sum`. */
static void add_passes(struct traced *t, const struct plan *p, uint32_t from, struct traced *sum)
{
    static const enum plane_id planes[] = {PLANE_PATH_DIRECT, PLANE_PATH_INDIRECT, PLANE_PATH_M2};
    for (uint32_t pass = from; pass < plan_pass_count(p); pass++) {
        struct samples *s = trace_pass(t, p, pass);
        for (size_t n = 0; n < 3; n++)
            for (uint32_t c = 0; c < 3; c++)
                for (int i = 0; i < SIDE_PX * SIDE_PX; i++)
                    plane(sum, planes[n], c)[i] += samples_f32(s, planes[n], c)[i];
        samples_destroy(&s);
    }
}

/* Traces all passes of a picture. */
static struct traced trace_passes(struct scene_fixture *f, const struct plan *p)
{
    struct traced t = trace_all(f, p);
    add_passes(&t, p, 1, &t);
    return t;
}

static void add_picture(struct scene_fixture *f, const struct plan *p, struct traced *sum)
{
    struct traced t = {0};
    open_traced(f, &t);
    add_passes(&t, p, 0, sum);
    traced_fini(&t);
}

/* All lights together bring what each brings alone, where there is nothing to choose: few points,
 * which all are sampled, and more. */
TEST(lights_add_up)
{
    for (uint32_t points = 2; points <= 12; points += 10) {
        struct scene_fixture *f = fixture_new();
        uint32_t meshes[3];
        struct plan p = lit_room(f, points, meshes), one = p;
        struct traced sum;
        one.light_count = 1;
        one.lights[0] = p.lights[0];
        sum = trace_passes(f, &one);
        for (uint32_t k = 1; k < p.light_count; k++) {
            one.lights[0] = p.lights[k];
            add_picture(f, &one, &sum);
        }
        one.light_count = 0;
        one.paths.emitter_power = p.paths.emitter_power = 1.0f;
        for (uint32_t k = 0; k < 3; k++) {
            f->materials[meshes[k]].emission[k] = 4.0f;
            add_picture(f, &one, &sum);
            f->materials[meshes[k]].emission[k] = 0.0f;
        }
        for (uint32_t k = 0; k < 3; k++) f->materials[meshes[k]].emission[k] = 4.0f;
        struct traced all = trace_passes(f, &p);
        expect_equal_light(&all, &sum, PLANE_PATH_DIRECT, 256);
        expect_equal_light(&all, &sum, PLANE_PATH_INDIRECT, 256);
        traced_fini(&all);
        traced_fini(&sum);
        free(f);
    }
}

/* Emitters without area, in one place with each other and with what they light, beside the camera
 * and as bright as they may be; lights on surfaces; normals of nothing. */
TEST(odd_lights_give_finite_light)
{
    struct scene_fixture *f = fixture_new();
    uint32_t meshes[3];
    struct plan p = lit_room(f, 12, meshes);
    p.paths.spp = 16;
    p.paths.emitter_power = 1.0f;
    for (uint32_t k = 0; k < 3; k++) {
        const float on[3] = {0, 0, 0}, x[3] = {0.5f, 0, 0}, z[3] = {0, 0, -0.5f}, none[3] = {0};
        f->materials[meshes[k]].emission[k] = k == 0 ? 1e12f : 1.0f;
        f->materials[meshes[k]].flags |= MATERIAL_DOUBLE_SIDED;
        fixture_panel(f, meshes[k], on, x, z);    /* in the floor's place */
        fixture_panel(f, meshes[k], on, x, none); /* without area */
        fixture_panel(f, meshes[k], (float[]){0.01f, 4.0f, 0}, (float[]){1e-3f, 0, 0},
                      (float[]){0, 0, -1e-3f}); /* beside the eye */
    }
    for (uint32_t k = 0; k < p.light_count; k++)
        if (p.lights[k].type == LIGHT_POINT) p.lights[k].position[1] = 0.0f;
    struct traced t = trace_all(f, &p);
    assert_true(mean(&t, PLANE_PATH_RADIANCE, 1, 16) > 0.0);
    for (uint32_t c = 0; c < 3; c++)
        for (int i = 0; i < SIDE_PX * SIDE_PX; i++)
            assert_true(isfinite(plane(&t, PLANE_PATH_RADIANCE, c)[i]));
    traced_fini(&t);
    free(f);
}
