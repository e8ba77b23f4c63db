/* Shining meshes: which triangles are chosen and how densely, where points lie, what leaves them.
 */
#include <stdlib.h>
#include <string.h>

#include "tests/random.h"
#include "tests/unit/unit.h"
#include "tests/unit/worker/scene_fixture.h"
#include "worker/scene/emitters.h"
#include "worker/scene/render_scene.h"

#define SAMPLES 200000

struct lit {
    struct scene_fixture *f;
    struct render_scene *scene;
    const struct emitters *emitters;
};

static struct scene_fixture *new_fixture(void)
{
    struct scene_fixture *f = calloc(1, sizeof *f);
    assert_non_null(f);
    return f;
}

static struct lit light_up(struct scene_fixture *f)
{
    struct lit lit = {.f = f};
    struct fault fault = {0};
    assert_int_equal(render_scene_create(fixture_scene(f), 1, NULL, &lit.scene, &fault), 0);
    lit.emitters = lit.scene->emitters;
    return lit;
}

static void put_out(struct lit *lit)
{
    render_scene_destroy(&lit->scene);
    free(lit->f);
}

static uint32_t shining(struct scene_fixture *f, float r, float g, float b)
{
    uint32_t m = fixture_material(f, 0.5f, 0.5f, 0.5f);
    f->materials[m].emission[0] = r;
    f->materials[m].emission[1] = g;
    f->materials[m].emission[2] = b;
    return m;
}

static double share_of(const struct emitters *e, uint32_t leaf)
{
    const struct emitter_tree *t = emitters_tree(e);
    double sum = 0.0;
    for (uint32_t k = 0; k < t->leaf_count; k++) sum += t->leaves[k].power;
    return t->leaves[leaf].power / sum;
}

/* Density of a point where leaves are chosen by their power. */
static float density(const struct emitters *e, uint32_t instance, uint32_t triangle)
{
    uint32_t leaf;
    if (!emitters_find(e, instance, triangle, &leaf)) return 0.0f;
    return (float)share_of(e, leaf) * emitters_density(e, instance, leaf);
}

/* Uniform numbers; a sequence of its own for each test. Leaves are chosen by their power. */
static void draw(const struct emitters *e, struct random *r, struct emitter_point *out)
{
    const uint32_t count = emitters_tree(e)->leaf_count;
    double at = (double)random_unit(r);
    uint32_t leaf = 0;
    while (leaf + 1 < count && at >= share_of(e, leaf)) at -= share_of(e, leaf++);
    float choice = random_unit(r);
    float u[2];
    u[0] = random_unit(r);
    u[1] = random_unit(r);
    emitters_sample(e, leaf, emitters_choose(e, leaf, choice, u), u, out);
    out->pdf_area *= (float)share_of(e, leaf);
}

/* Chi-square against expected counts; beyond these `sigmas` a sound sampler comes once in a
 * million. */
static void expect_counts(const double *seen, const double *expected, int cells)
{
    double chi = 0.0;
    for (int i = 0; i < cells; i++)
        chi += (seen[i] - expected[i]) * (seen[i] - expected[i]) / expected[i];
    int degrees = cells - 1;
    assert_true(chi < degrees + 5.0 * sqrt(2.0 * degrees) + 10.0);
}

TEST(nothing_shines_in_the_dark)
{
    const float origin[3] = {0}, x[3] = {1, 0, 0}, z[3] = {0, 0, -1};
    struct scene_fixture *f = new_fixture();
    fixture_panel(f, fixture_material(f, 1, 1, 1), origin, x, z);
    uint32_t listed = fixture_panel(f, shining(f, 1, 1, 1), origin, x, z);
    f->meshes[f->instances[listed].mesh].flags |= MESH_IS_LIGHT;
    uint32_t unlit = shining(f, 1, 1, 1);
    f->materials[unlit].flags |= MATERIAL_UNLIT;
    fixture_panel(f, unlit, origin, x, z);
    const float none[3] = {0};
    fixture_panel(f, shining(f, 1, 1, 1), origin, x, none); /* without area */
    struct lit lit = light_up(f);
    assert_null(lit.emitters);
    assert_true(density(lit.emitters, listed, 0) == 0.0f);
    put_out(&lit);
}

/* Two panels, one placed twice with a scale: sizes 4, 16 and 32 (unevenly scaled), luminances 1 and
 * 3. */
static struct lit make_three(void)
{
    const float origin[3] = {0}, x[3] = {1, 0, 0}, z[3] = {0, 0, -1}, far[3] = {0, 0, 9};
    const float doubled[12] = {2, 0, 0, 5, 0, 2, 0, 0, 0, 0, 2, 0};
    const float stretched[12] = {4, 0, 0, -9, 0, 1, 0, 3, 0, 0, 2, 0};
    struct scene_fixture *f = new_fixture();
    fixture_panel(f, shining(f, 1, 1, 1), far, x, z);
    uint32_t mesh = fixture_mesh(f, shining(f, 3, 3, 3), 0);
    fixture_quad(f, origin, x, z);
    fixture_place_at(f, mesh, doubled);
    fixture_place_at(f, mesh, stretched);
    fixture_panel(f, fixture_material(f, 1, 1, 1), origin, x, z); /* dark */
    return light_up(f);
}

TEST(densities_integrate_to_one)
{
    struct lit lit = make_three();
    const double areas[3] = {4, 16, 32}, luminance[3] = {1, 3, 3};
    double total = 0.0, power = 4 * 1 + 16 * 3 + 32 * 3;
    for (uint32_t i = 0; i < 3; i++) {
        const double of = (double)density(lit.emitters, i, 1);
        assert_true(fabs(of - luminance[i] / power) < 1e-6);
        total += of * areas[i];
    }
    assert_true(fabs(total - 1.0) < 1e-6);
    assert_true(density(lit.emitters, 3, 0) == 0.0f);
    put_out(&lit);
}

/* Which panel a point lies on, and which of 8 x 8 cells of it. */
static int cell_of(const float p[3], int *panel)
{
    const float centre[3][3] = {{0, 0, 9}, {5, 0, 0}, {-9, 3, 0}};
    const float half_x[3] = {1, 2, 4}, half_z[3] = {1, 2, 2};
    for (*panel = 0; *panel < 3; (*panel)++) {
        float u = 0.5f + 0.5f * (p[0] - centre[*panel][0]) / half_x[*panel];
        float v = 0.5f + 0.5f * (p[2] - centre[*panel][2]) / half_z[*panel];
        if (fabsf(p[1] - centre[*panel][1]) > 1e-5f || fabsf(u - 0.5f) > 0.5001f ||
            fabsf(v - 0.5f) > 0.5001f)
            continue;
        int a = (int)(u * 8.0f), b = (int)(v * 8.0f);
        return (a > 7 ? 7 : a < 0 ? 0 : a) + 8 * (b > 7 ? 7 : b < 0 ? 0 : b);
    }
    fail_msg("(%g, %g, %g) is on no panel", (double)p[0], (double)p[1], (double)p[2]);
    return 0;
}

TEST(points_are_uniform_by_power)
{
    static double seen[3 * 64], expected[3 * 64];
    const double share[3] = {4.0 / 148, 48.0 / 148, 96.0 / 148};
    struct lit lit = make_three();
    struct random r = {1};
    memset(seen, 0, sizeof seen);
    for (int i = 0; i < SAMPLES; i++) {
        struct emitter_point point;
        int panel;
        draw(lit.emitters, &r, &point);
        int cell = cell_of(point.position, &panel);
        seen[64 * panel + cell] += 1.0;
        const float of = density(lit.emitters, (uint32_t)panel, 0);
        assert_true(fabsf(point.pdf_area - of) <= 1e-6f * of);
        assert_true(point.radiance[0] == (panel == 0 ? 1.0f : 3.0f));
        assert_true(fabsf(point.normal[1] - 1.0f) < 1e-6f);
        assert_true(point.offset > 0.0f && point.offset < 1e-4f);
        assert_false(point.double_sided);
    }
    for (int i = 0; i < 3 * 64; i++) expected[i] = SAMPLES * share[i / 64] / 64;
    expect_counts(seen, expected, 3 * 64);
    put_out(&lit);
}

/* The light that a small patch receives, estimated from points, is that of the closed form. */
TEST(estimates_meet_the_closed_form)
{
    const float top[3] = {0, 1, 0}, x[3] = {1, 0, 0}, z[3] = {0, 0, 1};
    struct scene_fixture *f = new_fixture();
    fixture_panel(f, shining(f, 2, 2, 2), top, x, z); /* x cross z: faces down */
    struct lit lit = light_up(f);
    struct random r = {2};
    double sum = 0.0;
    for (int i = 0; i < SAMPLES; i++) {
        struct emitter_point p;
        draw(lit.emitters, &r, &p);
        double d2 = 0.0, facing = 0.0;
        for (int k = 0; k < 3; k++) {
            d2 += (double)p.position[k] * (double)p.position[k];
            facing -= (double)p.position[k] * (double)p.normal[k];
        }
        assert_true(facing > 0.0);
        sum +=
            (double)p.radiance[0] * (double)p.position[1] * facing / (d2 * d2) / (double)p.pdf_area;
    }
    /* four quarters, a = b = 1 seen from distance 1: L/2 * 2 * (a/sqrt(1+a2) atan(b/sqrt(1+a2))) */
    double exact = 4 * 2.0 / 2 * 2 * (1 / sqrt(2) * atan(1 / sqrt(2)));
    assert_true(fabs(sum / SAMPLES - exact) < 0.01 * exact);
    put_out(&lit);
}

/* A texture weighs with its mean, and a point emits what its texel says. */
TEST(textures_weigh_by_their_mean)
{
    static const uint8_t halves[8] = {255, 255, 255, 255, 0, 0, 0, 255};
    const float origin[3] = {0}, x[3] = {1, 0, 0}, z[3] = {0, 0, -1}, far[3] = {9, 0, 0};
    struct scene_fixture *f = new_fixture();
    uint32_t texture = fixture_texture(f, 2, 1, halves, 0);
    uint32_t m = shining(f, 4, 4, 4);
    f->textures[texture].filter = FILTER_NEAREST;
    f->materials[m].emission_texture.texture = texture;
    fixture_panel(f, m, origin, x, z);
    fixture_panel(f, shining(f, 2, 2, 2), far, x, z);
    struct lit lit = light_up(f);
    assert_true(fabsf(density(lit.emitters, 0, 0) - 0.125f) < 1e-6f);
    assert_true(fabsf(density(lit.emitters, 1, 1) - 0.125f) < 1e-6f);
    struct random r = {3};
    for (int i = 0; i < 1000; i++) {
        struct emitter_point p;
        draw(lit.emitters, &r, &p);
        float expected = p.position[0] > 2.0f ? 2.0f : p.position[0] < 0.0f ? 4.0f : 0.0f;
        assert_true(p.radiance[1] == expected);
    }
    put_out(&lit);
}

/* Mirrored placements keep their front; masks and blends weaken what leaves. */
TEST(fronts_and_opacities_count)
{
    const float origin[3] = {0}, x[3] = {1, 0, 0}, z[3] = {0, 0, -1};
    const float mirrored[12] = {-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    struct scene_fixture *f = new_fixture();
    uint32_t m = shining(f, 8, 8, 8);
    f->materials[m].alpha_mode = ALPHA_BLEND;
    f->materials[m].base_color[3] = 0.25f;
    f->materials[m].flags = MATERIAL_DOUBLE_SIDED;
    uint32_t mesh = fixture_mesh(f, m, 0);
    fixture_quad(f, origin, x, z);
    fixture_place_at(f, mesh, mirrored);
    struct lit lit = light_up(f);
    struct random r = {4};
    struct emitter_point p;
    draw(lit.emitters, &r, &p);
    assert_true(p.normal[1] == 1.0f && p.double_sided);
    assert_true(p.radiance[0] == 2.0f);
    put_out(&lit);
}

/* Sizes and luminances at the ends of what a scene may hold. */
TEST(extremes_stay_finite)
{
    const float scales[] = {1e-14f, 1e-5f, 1.0f, 1e12f};
    const float strengths[] = {1e-20f, 1.0f, 1e12f};
    for (int i = 0; i < 4; i++)
        for (int k = 0; k < 3; k++) {
            const float x[3] = {scales[i], 0, 0}, z[3] = {0, 0, -scales[i]}, origin[3] = {0};
            struct scene_fixture *f = new_fixture();
            fixture_panel(f, shining(f, strengths[k], strengths[k], strengths[k]), origin, x, z);
            struct lit lit = light_up(f);
            struct random r = {5};
            struct emitter_point p;
            draw(lit.emitters, &r, &p);
            assert_true(isfinite(p.pdf_area) && p.pdf_area > 0.0f);
            assert_true(isfinite(p.position[0]) && p.normal[1] == 1.0f && p.offset > 0.0f);
            put_out(&lit);
        }
}
