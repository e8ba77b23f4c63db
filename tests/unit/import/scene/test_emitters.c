/* Emissive quads as rectangle lights. */
#include <math.h>
#include <string.h>

#include "proto/plan.h"
#include "server/import/scene/emitters.h"
#include "tests/unit/unit.h"

/* A unit square in the xz plane, counter-clockwise from below: it faces -y. */
static const float square[] = {0, 0, 0, 1, 0, 0, 1, 0, 1, 0, 0, 1};
static const uint32_t facing_down[] = {0, 1, 2, 0, 2, 3};
static const uint32_t facing_up[] = {0, 2, 1, 0, 3, 2};

static void assert_near(double a, double b)
{
    assert_true(fabs(a - b) < 1e-6);
}

static double normal_y(const struct rectangle *r)
{
    return r->half_u[2] * r->half_v[0] - r->half_u[0] * r->half_v[2];
}

TEST(pairs_two_triangles)
{
    struct rectangle r[EMITTER_RECTANGLES];
    assert_int_equal(emitters_pair(square, facing_down, 2, r), 1);
    assert_near(r[0].centre[0], 0.5);
    assert_near(r[0].centre[2], 0.5);
    assert_near(normal_y(&r[0]), -0.25);
    assert_int_equal(emitters_pair(square, facing_up, 2, r), 1);
    assert_near(normal_y(&r[0]), 0.25);
}

TEST(any_first_corner_will_do)
{
    struct rectangle r[EMITTER_RECTANGLES];
    for (uint32_t turn = 0; turn < 9; turn++) {
        uint32_t t[6];
        for (uint32_t k = 0; k < 3; k++) {
            t[k] = facing_down[(k + turn) % 3];
            t[3 + k] = facing_down[3 + (k + turn / 3) % 3];
        }
        assert_int_equal(emitters_pair(square, t, 2, r), 1);
        assert_near(normal_y(&r[0]), -0.25);
    }
}

TEST(refuses_what_is_no_rectangle)
{
    struct rectangle r[EMITTER_RECTANGLES];
    const uint32_t against_each_other[] = {0, 1, 2, 0, 3, 2};
    const uint32_t twice[] = {0, 1, 2, 0, 1, 2};
    assert_int_equal(emitters_pair(square, facing_down, 1, r), 0);
    assert_int_equal(emitters_pair(square, against_each_other, 2, r), 0);
    assert_int_equal(emitters_pair(square, twice, 2, r), 0);
    float bent[12], skewed[12], flat[12] = {0};
    memcpy(bent, square, sizeof bent);
    bent[10] = 0.01f; /* the fourth corner leaves the plane */
    assert_int_equal(emitters_pair(bent, facing_down, 2, r), 0);
    memcpy(skewed, square, sizeof skewed);
    skewed[6] += 0.01f; /* a parallelogram without right angles */
    skewed[9] += 0.01f;
    assert_int_equal(emitters_pair(skewed, facing_down, 2, r), 0);
    assert_int_equal(emitters_pair(flat, facing_down, 2, r), 0);
}

TEST(tolerates_rounding)
{
    struct rectangle r[EMITTER_RECTANGLES];
    float rough[12];
    memcpy(rough, square, sizeof rough);
    rough[6] += 0.0004f;
    assert_int_equal(emitters_pair(rough, facing_down, 2, r), 1);
}

/* `count` squares side by side, as a builder with one mesh and the given instances. */
static void build(struct builder *b, uint32_t squares, const struct scene_material *material,
                  uint32_t instances)
{
    void *at;
    assert_int_equal(builder_init(b, NULL), 0);
    assert_int_equal(builder_append(b, SCENE_POSITIONS, 4 * squares, &at, NULL), 0);
    for (uint32_t i = 0; i < squares; i++) {
        memcpy((float *)at + 12 * i, square, sizeof square);
        for (uint32_t k = 0; k < 4; k++) ((float *)at)[12 * i + 3 * k] += (float)i;
    }
    assert_int_equal(builder_append(b, SCENE_TRIANGLES, 2 * squares, &at, NULL), 0);
    for (uint32_t k = 0; k < 6 * squares; k++)
        ((uint32_t *)at)[k] = facing_down[k % 6] + 4 * (k / 6);
    assert_int_equal(builder_append(b, SCENE_MATERIALS, 1, &at, NULL), 0);
    memcpy(at, material, sizeof *material);
    assert_int_equal(builder_append(b, SCENE_MESHES, 1, &at, NULL), 0);
    *(struct scene_mesh *)at =
        (struct scene_mesh){.vertex_count = 4 * squares, .triangle_count = 2 * squares};
    for (uint32_t i = 0; i < instances; i++) {
        assert_int_equal(builder_append(b, SCENE_INSTANCES, 1, &at, NULL), 0);
        *(struct scene_instance *)at =
            (struct scene_instance){.to_world = {2, 0, 0, 0, 0, 1, 0, (float)i, 0, 0, 3, 0}};
    }
}

static struct scene_material lamp(void)
{
    return (struct scene_material){.emission = {17, 12, 4},
                                   .emission_texture = {.texture = SCENE_NONE}};
}

/* Lights that a mesh of so many squares, so often placed, becomes. */
static uint64_t lights_of(uint32_t squares, const struct scene_material *m, uint32_t instances)
{
    struct builder b;
    build(&b, squares, m, instances);
    assert_int_equal(emitters_find(&b, NULL), 0);
    uint64_t count = builder_count(&b, SCENE_LIGHTS);
    bool flagged = builder_meshes(&b)[0].flags & MESH_IS_LIGHT;
    assert_int_equal(flagged, count > 0);
    bool warned = b.warnings.count > 0;
    assert_int_equal(warned, count == 0 && m->emission[0] > 0);
    builder_fini(&b);
    return count;
}

TEST(makes_lights)
{
    struct scene_material m = lamp();
    assert_int_equal(lights_of(1, &m, 1), 1);
    assert_int_equal(lights_of(8, &m, 1), 8);
    assert_int_equal(lights_of(9, &m, 1), 0);
    assert_int_equal(lights_of(1, &m, 5), 5);
    assert_int_equal(lights_of(8, &m, 8), 64);
    assert_int_equal(lights_of(8, &m, 9), 0);
    m.flags = MATERIAL_DOUBLE_SIDED;
    assert_int_equal(lights_of(2, &m, 3), 12);
    m.emission_texture.texture = 0;
    assert_int_equal(lights_of(1, &m, 1), 0);
    m = lamp();
    m.alpha_mode = ALPHA_MASK;
    assert_int_equal(lights_of(1, &m, 1), 0);
    m = lamp();
    memset(m.emission, 0, sizeof m.emission);
    assert_int_equal(lights_of(1, &m, 1), 0);
}

TEST(lights_stand_where_the_instance_stands)
{
    struct builder b;
    struct scene_material m = lamp();
    m.flags = MATERIAL_DOUBLE_SIDED;
    build(&b, 1, &m, 2);
    assert_int_equal(emitters_find(&b, NULL), 0);
    const struct scene_light *lights = builder_lights(&b);
    assert_int_equal(builder_count(&b, SCENE_LIGHTS), 4);
    for (int i = 0; i < 4; i++) {
        assert_int_equal(lights[i].type, LIGHT_RECTANGLE);
        assert_int_equal(lights[i].instance, i / 2);
        assert_near((double)lights[i].position[0], 1);
        assert_near((double)lights[i].position[1], i / 2);
        assert_near((double)lights[i].position[2], 1.5);
        assert_near((double)lights[i].direction[1], i % 2 == 0 ? -1 : 1);
        assert_near((double)lights[i].color[0], 17);
        const float *u = lights[i].half_u, *v = lights[i].half_v;
        assert_near((double)(u[2] * v[0] - u[0] * v[2]), i % 2 == 0 ? -1.5 : 1.5);
    }
    builder_fini(&b);
}
