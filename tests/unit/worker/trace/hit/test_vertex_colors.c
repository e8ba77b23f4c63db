/* Colours of vertices multiply base colours, opacity and what unlit surfaces shine. */
#include <stdlib.h>

#include "tests/unit/worker/trace/hit/panel_scene.h"
#include "tests/unit/worker/trace/isa_fixture.h"
#include "worker/scene/alpha.h"

enum kind { LAMBERT, GLOSSY, UNLIT, PLAIN, KINDS };

/* Panel k covers x from 2k - 1 to 2k + 1. Colours run from red at its left, with alpha 1, to green
 * at its right, with alpha a half. */
static void add_panel(int kind)
{
    const uint32_t m = fixture_material(f, 0.5f, 0.25f, 1.0f);
    struct scene_material *material = &f->materials[m];
    if (kind != PLAIN) material->flags |= MATERIAL_COLORED;
    if (kind == GLOSSY) material->specular = 1.0f;
    if (kind == UNLIT) material->flags |= MATERIAL_UNLIT;
    const uint32_t mesh = fixture_mesh(f, m, kind != PLAIN ? MESH_HAS_COLORS : 0);
    const uint32_t first = f->vertex_count;
    fixture_quad(f, (float[]){2 * (float)kind, 0, 0}, (float[]){1, 0, 0}, (float[]){0, 1, 0});
    for (uint32_t v = first; v < f->vertex_count; v++) {
        const bool right = f->positions[3 * (size_t)v] > 2 * (float)kind;
        float *c = f->colors + 4 * (size_t)v;
        c[0] = !right, c[1] = right, c[2] = 0, c[3] = right ? 0.5f : 1.0f;
    }
    fixture_place(f, mesh);
}

static int open_scene(void **state)
{
    (void)state;
    return open_panels(KINDS, add_panel);
}

ALL_TESTS(open_scene, close_panels);

static void expect_panel(const struct surface *s, int i, enum kind kind, float right)
{
    const float red = 0.5f * (1 - right), green = 0.25f * right;
    if (kind == UNLIT)
        expect_color(&s->emission, i, red, green, 0);
    else if (kind == PLAIN)
        expect_color(&s->albedo, i, 0.5f, 0.25f, 1);
    else
        expect_color(&s->albedo, i, red, green, 0);
}

/* Lane i looks at panel kind[i % 2]: lanes of one mesh go another way than those of two. */
static void look(const struct hit_kernels *kernels, enum kind a, enum kind b)
{
    static struct surface s;
    struct queries q;
    struct lanes_mask valid;
    _Alignas(LANES_ALIGN) struct RTCRayHit16 rays;
    queries_init(&q);
    q.scene = scene;
    q.kernels = kernels;
    queries_init_rays(&rays);
    for (int i = 0; i < LANES; i++) {
        valid.on[i] = -1;
        rays.ray.org_x[i] = 2 * (float)(i % 2 ? a : b) + ((float)i + 0.5f) / 8.0f - 1.0f;
        rays.ray.org_y[i] = 0.3f;
        rays.ray.org_z[i] = 3.0f;
        rays.ray.dir_z[i] = -1.0f;
        rays.ray.tfar[i] = INFINITY;
    }
    queries_closest(&q, QUERY_CAMERA, &valid, &rays);
    hit_resolve(&q, &valid, &rays, &s);
    hit_diffuse_albedo(&q, &rays, &s);
    for (int i = 0; i < LANES; i++) expect_panel(&s, i, i % 2 ? a : b, ((float)i + 0.5f) / 16.0f);
}

TEST(colours_are_interpolated_on_every_kind_of_surface)
{
    for (int k = 0; k < isa_count(); k++)
        for (int a = 0; a < KINDS; a++)
            for (int b = 0; b < KINDS; b++)
                look(KERNELS_FOR(hit_kernels, all_isas[k]), (enum kind)a, (enum kind)b);
}

TEST(paths_reflect_by_them)
{
    struct material_uv uv = {.color = {0.5f, 1, 0, 1}};
    struct bsdf bsdf;
    material_bsdf(scene->meshes[LAMBERT].material, &uv, false, &bsdf);
    assert_true(bsdf.albedo[0] == 0.25f && bsdf.albedo[1] == 0.25f && bsdf.albedo[2] == 0);
    material_bsdf(scene->meshes[GLOSSY].material, &uv, false, &bsdf);
    assert_true(bsdf.base_color[0] == 0.25f && bsdf.base_color[2] == 0);
}

TEST(alpha_is_opacity)
{
    struct material m = *scene->meshes[LAMBERT].material;
    struct material_uv uv = {.color = {1, 1, 1, 0.25f}};
    assert_true(material_opacity(&m, &uv) == 1); /* of an opaque material */
    for (uint32_t mode = ALPHA_MASK; mode <= ALPHA_BLEND; mode++) {
        struct material_table *table;
        f->materials[LAMBERT].alpha_mode = mode;
        f->materials[LAMBERT].alpha_cutoff = 0.5f;
        assert_int_equal(material_table_create(fixture_scene(f), &table), 0);
        const float expected = mode == ALPHA_MASK ? 0 : 0.25f;
        assert_true(material_opacity(&table->materials[LAMBERT], &uv) == expected);
        material_table_destroy(&table);
    }
    f->materials[LAMBERT].alpha_mode = ALPHA_OPAQUE;
}
