/* Meshes and tangents on their way to the blob. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "server/import/scene/mesh.h"
#include "server/import/scene/tangents.h"
#include "tests/unit/unit.h"

static struct warnings warnings;

static void *copy(const void *from, size_t size_bytes)
{
    void *to = malloc(size_bytes);
    assert_non_null(to);
    return memcpy(to, from, size_bytes);
}

/* A unit square in the xy plane facing +z, as glTF textures it: v grows downwards. */
static struct mesh square(void)
{
    static const float p[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
    static const float n[] = {0, 0, 2, 0, 0, 1, 0, 0, 1, 0, 0, 1};
    static const float uv[] = {0, 1, 1, 1, 1, 0, 0, 0};
    static const uint32_t t[] = {0, 1, 2, 0, 2, 3};
    return (struct mesh){.vertex_count = 4,
                         .triangle_count = 2,
                         .positions = copy(p, sizeof p),
                         .normals = copy(n, sizeof n),
                         .uvs = {copy(uv, sizeof uv), NULL},
                         .triangles = copy(t, sizeof t)};
}

static void assert_vector(const float *v, float x, float y, float z)
{
    assert_true(fabsf(v[0] - x) < 1e-6f && fabsf(v[1] - y) < 1e-6f && fabsf(v[2] - z) < 1e-6f);
}

TEST(check_makes_unit_normals)
{
    struct mesh m = square();
    memset(&warnings, 0, sizeof warnings);
    assert_int_equal(mesh_check(&m, "m", &warnings, NULL), 0);
    assert_vector(m.normals, 0, 0, 1);
    assert_int_equal(warnings.count, 0);
    memset(m.normals, 0, 3 * sizeof(float));
    assert_int_equal(mesh_check(&m, "m", &warnings, NULL), 0);
    assert_vector(m.normals, 0, 0, 1);
    assert_int_equal(warnings.count, 1);
    mesh_fini(&m);
}

TEST(check_names_the_vertex)
{
    struct fault fault;
    struct mesh m = square();
    m.positions[7] = NAN;
    assert_int_equal(mesh_check(&m, "m", &warnings, &fault), ERR_NOT_FINITE);
    assert_string_equal(fault.pointer, "m.positions[2]");
    m.positions[7] = 1e16f;
    assert_int_equal(mesh_check(&m, "m", &warnings, &fault), ERR_LIMIT);
    m.positions[7] = 1;
    m.uvs[0][3] = -INFINITY;
    assert_int_equal(mesh_check(&m, "m", &warnings, &fault), ERR_NOT_FINITE);
    assert_string_equal(fault.pointer, "m.uvs[1]");
    m.uvs[0][3] = 1;
    m.triangles[4] = 4;
    assert_int_equal(mesh_check(&m, "m", &warnings, &fault), ERR_RANGE);
    assert_string_equal(fault.pointer, "m.indices[4]");
    mesh_fini(&m);
}

TEST(compact_keeps_order)
{
    struct mesh m = square();
    m.triangle_count = 1;
    memcpy(m.triangles, (uint32_t[3]){3, 1, 2}, 3 * sizeof(uint32_t));
    assert_int_equal(mesh_compact(&m, NULL), 0);
    assert_int_equal(m.vertex_count, 3);
    assert_int_equal(m.triangles[0], 2);
    assert_int_equal(m.triangles[1], 0);
    assert_int_equal(m.triangles[2], 1);
    assert_vector(m.positions + 6, 0, 1, 0);
    mesh_fini(&m);
}

TEST(mirroring_keeps_the_front)
{
    struct mesh m = square();
    assert_int_equal(mesh_check(&m, "m", &warnings, NULL), 0);
    assert_int_equal(mesh_make_tangents(&m, 0, "m", NULL), 0);
    const struct affine mirror = {{-2, 0, 0, 5, 0, 1, 0, 0, 0, 0, 1, 0}};
    double n[3];
    assert_int_equal(mesh_transform(&m, &mirror, "m", NULL), 0);
    mesh_triangle_normal(m.positions, m.triangles, n);
    assert_true(n[2] > 0);
    assert_vector(m.normals, 0, 0, 1);
    assert_vector(m.positions + 3, 3, 0, 0);
    assert_vector(m.tangents, -1, 0, 0);
    assert_true(m.tangents[3] < 0); /* so that the bitangent still points up */
    mesh_fini(&m);
}

TEST(transform_checks_its_result)
{
    struct fault fault;
    struct mesh m = square();
    const struct affine far = {{1, 0, 0, 2e15, 0, 1, 0, 0, 0, 0, 1, 0}};
    assert_int_equal(mesh_transform(&m, &far, "m", &fault), ERR_LIMIT);
    mesh_fini(&m);
}

TEST(flatten_gives_own_normals)
{
    struct mesh m = square();
    assert_int_equal(mesh_flatten(&m, "m", NULL), 0);
    assert_int_equal(m.vertex_count, 6);
    for (size_t v = 0; v < 6; v++) {
        assert_vector(m.normals + 3 * v, 0, 0, 1);
        assert_int_equal(m.triangles[v], v);
    }
    mesh_fini(&m);
}

TEST(tangents_follow_u)
{
    struct mesh m = square();
    assert_int_equal(mesh_check(&m, "m", &warnings, NULL), 0);
    assert_int_equal(mesh_make_tangents(&m, 0, "m", NULL), 0);
    assert_int_equal(m.vertex_count, 4);
    for (size_t v = 0; v < 4; v++) {
        assert_vector(m.tangents + 4 * v, 1, 0, 0);
        assert_true(m.tangents[4 * v + 3] == 1); /* cross(n, t) is up */
    }
    mesh_fini(&m);
}

TEST(tangents_split_mirrored_textures)
{
    struct mesh m = square();
    assert_int_equal(mesh_check(&m, "m", &warnings, NULL), 0);
    m.uvs[0][6] = 2; /* the second triangle sees its texture mirrored */
    assert_int_equal(mesh_make_tangents(&m, 0, "m", NULL), 0);
    assert_int_equal(m.vertex_count, 6);
    for (size_t t = 0; t < 2; t++) {
        float w = m.tangents[4 * (size_t)m.triangles[3 * t] + 3];
        for (size_t k = 0; k < 3; k++)
            assert_true(m.tangents[4 * (size_t)m.triangles[3 * t + k] + 3] == w);
        assert_true(w == (t == 0 ? 1 : -1));
    }
    mesh_fini(&m);
}

TEST(tangents_survive_degenerate_textures)
{
    struct mesh m = square();
    assert_int_equal(mesh_check(&m, "m", &warnings, NULL), 0);
    memset(m.uvs[0], 0, 8 * sizeof(float));
    assert_int_equal(mesh_make_tangents(&m, 0, "m", NULL), 0);
    for (size_t v = 0; v < m.vertex_count; v++) {
        const float *t = m.tangents + 4 * v;
        assert_true(fabsf(t[0] * t[0] + t[1] * t[1] + t[2] * t[2] - 1) < 1e-6f);
        assert_true(fabsf(t[2]) < 1e-6f && fabsf(t[3]) == 1);
    }
    mesh_fini(&m);
}
