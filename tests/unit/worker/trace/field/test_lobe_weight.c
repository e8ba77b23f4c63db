/* The weight of a light on a diffuse lobe, of centres and of lone sub-samples. */
#include "tests/unit/worker/trace/field/lobe_division.h"

/* -- weights -- */

/* From a world whose surfaces lie in y = 0 to the frame of their shading. */
static void to_local(const double from[3], const double to[3], float out[3])
{
    double d[3], squared = 0;
    for (int c = 0; c < 3; c++) d[c] = to[c] - from[c], squared += d[c] * d[c];
    const double length = sqrt(squared);
    out[0] = (float)(d[0] / length);
    out[1] = (float)(-d[2] / length);
    out[2] = (float)(d[1] / length);
}

/* pi times the diffuse lobe over its albedo, of light from `light` that is sent to `eye`. */
static double lobe_of(const struct bsdf *white, const double at[3], const double eye[3],
                      const double light[3])
{
    float wo[3], wi[3];
    struct bsdf_value value;
    to_local(at, eye, wo);
    to_local(at, light, wi);
    bsdf_evaluate(white, wo, wi, &value);
    return PI * (double)value.diffuse;
}

static struct bsdf white_bsdf(const struct traced *t, uint32_t material)
{
    struct bsdf b;
    material_bsdf(&t->scene->materials->materials[material], NULL, false, &b);
    b.albedo[0] = b.albedo[1] = b.albedo[2] = 1.0f;
    return b;
}

/* Over a ceiling light, by a fine midpoint rule: weighed irradiance over irradiance. */
static double rectangle_weight(const struct bsdf *white, const struct plan_light *l,
                               const double at[3], const double eye[3])
{
    enum { N = 100 };
    double weighed = 0, all = 0;
    for (int i = 0; i < N * N; i++) {
        const double u = (i % N + 0.5) / N * 2 - 1, v = (i / N + 0.5) / N * 2 - 1;
        const double on[3] = {(double)l->position[0] + u * (double)l->half_u[0],
                              (double)l->position[1],
                              (double)l->position[2] + v * (double)l->half_v[2]};
        double squared = 0;
        for (int c = 0; c < 3; c++) squared += (on[c] - at[c]) * (on[c] - at[c]);
        const double up = on[1] - at[1], e = up * up / (squared * squared);
        all += e;
        weighed += e * lobe_of(white, at, eye, on);
    }
    return weighed / all;
}

/* A near and wide light, so that the weight is no number of one direction; in its shadow, too. */
TEST(a_rectangle_has_the_weight_of_its_light)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = floor_plan(f, 10.0f, 16);
    const double eye[3] = {0, 4, 0};
    f->materials[0].specular = 1.0f;
    f->materials[0].roughness = 0.6f;
    fixture_ceiling_light(&p, 2.0f, 0.7f, 0.2f, 1.5f, 8);
    fixture_panel(f, 0, (float[]){2, 0.5f, 0}, (float[]){0.4f, 0, 0}, (float[]){0, 0, -0.4f});
    divide(&p, 1);
    p.light_planes = 1u << LIGHT_PLANE_IRRADIANCE | 1u << LIGHT_PLANE_DIFFUSE_WEIGHT;
    struct traced t = trace_all(f, &p);
    const struct bsdf white = white_bsdf(&t, 0);
    double least = 2, most = 0;
    for (int32_t i = 0; i < 256; i += 3) {
        double at[3];
        floor_point(&p, i % 16, i / 16, at);
        if (fabs(at[0] - 2) < 0.6 && fabs(at[2]) < 0.6) continue; /* on the lid */
        const double expected = rectangle_weight(&white, &p.lights[0], at, eye);
        const double got = (double)half_to_float(samples_light_weight(t.samples, 0)[i]);
        if (fabs(got - expected) > 0.01 * expected)
            fail_msg("pixel %d has the weight %g of %g", i, got, expected);
        least = fmin(least, got), most = fmax(most, got);
    }
    assert_true(least < 0.93 * most && most < 1);
    traced_fini(&t);
    free(f);
}

TEST(lambert_surfaces_weigh_one)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = floor_plan(f, 10.0f, 16);
    const uint32_t other = coated(f, 0.3f, 0);
    fixture_panel(f, other, (float[]){0, 0.1f, 0}, (float[]){1, 0, 0}, (float[]){0, 0, -1});
    fixture_ceiling_light(&p, 0, 2, 0, 0.5f, 4);
    divide(&p, 1);
    p.light_planes = 1u << LIGHT_PLANE_IRRADIANCE | 1u << LIGHT_PLANE_DIFFUSE_WEIGHT;
    struct traced t = trace_all(f, &p);
    const uint16_t *weight = samples_light_weight(t.samples, 0);
    uint32_t ones = 0;
    for (int32_t i = 0; i < 256; i++) {
        const bool floor = samples_u32(t.samples, PLANE_ID, 0)[i] == 1;
        assert_true(floor == (half_to_float(weight[i]) == 1.0f));
        ones += floor;
    }
    assert_true(ones > 100 && ones < 256);
    traced_fini(&t);
    free(f);
}

/* They have no weight beside their irradiance: it is in it. */
TEST(lone_sub_samples_are_weighed)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = strips_plan(f, 0.5f);
    const double eye[3] = {0, 4, 0};
    const uint32_t strips = f->material_count - 1;
    f->materials[strips].specular = 1.0f;
    f->materials[strips].roughness = 0.6f;
    divide(&p, 1);
    struct traced t = trace_all(f, &p);
    const struct bsdf white = white_bsdf(&t, strips);
    const struct sparse_list *list = t.samples->lone;
    const double bulb[3] = {(double)p.lights[0].position[0], (double)p.lights[0].position[1],
                            (double)p.lights[0].position[2]};
    assert_non_null(list);
    for (uint32_t e = 0; e < list->count; e++) {
        const int32_t pixel = (int32_t)(list->words[e] / 3);
        float in[2];
        pattern_pixel(&p.pattern, pixel % SIDE, pixel / SIDE, list->words[e] % 3, 3, in);
        const double at[3] = {2.0 * (pixel % SIDE + (double)in[0]) / SIDE - 1.0, 2.0,
                              2.0 * (pixel / SIDE + (double)in[1]) / SIDE - 1.0};
        double squared = 0;
        for (int c = 0; c < 3; c++) squared += (bulb[c] - at[c]) * (bulb[c] - at[c]);
        const double plain =
            (bulb[1] - 2) / sqrt(squared) / squared * (double)p.lights[0].color[0] / PI;
        const double weight = lobe_of(&white, at, eye, bulb);
        const double got = (double)lone_values(list, LONE_DIRECT, 0)[e];
        assert_true(weight < 0.99);
        if (fabs(got - plain * weight) > 1e-3 * plain)
            fail_msg("place %u has %g of %g", list->words[e], got, plain * weight);
    }
    traced_fini(&t);
    free(f);
}
