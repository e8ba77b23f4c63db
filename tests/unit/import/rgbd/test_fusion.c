/* One model of several frames: where its surface is, where it breaks, and what has no room. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "server/import/rgbd/fusion.h"
#include "server/import/rgbd/fusion_mesh.h"
#include "tests/random.h"
#include "tests/unit/unit.h"

enum { WIDTH = 80, HEIGHT = 60 };

static const struct rgbd_document lens = {
    .fx = 80, .fy = 80, .cx = 39.5, .cy = 29.5, .near_m = 0.1, .far_m = 30};
static const float white[3] = {0.5f, 0.5f, 0.5f};

/* What a camera sees by its columns and rows: z, or 0. */
typedef double (*place_fn)(double across, double down);

static double wall(double across, double down)
{
    (void)across, (void)down;
    return 2;
}

/* A floor half a metre below the camera, and a wall behind it. */
static double room(double across, double down)
{
    (void)across;
    return down > 0.125 ? 0.5 / down : 4;
}

static double two_walls(double across, double down)
{
    (void)down;
    return across < 0 ? 1 : 3;
}

static void see(place_fn place, float noise, uint64_t seed, struct depth_map *m)
{
    struct random random = {seed};
    const size_t count = (size_t)WIDTH * HEIGHT;
    *m = (struct depth_map){.width = WIDTH, .height = HEIGHT};
    m->z = calloc(count, sizeof *m->z);
    m->sure = calloc(count, sizeof *m->sure);
    m->color = calloc(count, 3 * sizeof *m->color);
    assert_true(m->z && m->sure && m->color);
    for (size_t i = 0; i < count; i++) {
        const double x = (double)(i % WIDTH), y = (double)(i / WIDTH);
        float sum = 0; /* of variance 1 */
        for (int k = 0; k < 12; k++) sum += random_unit(&random);
        m->z[i] = (float)place((x - lens.cx) / lens.fx, (y - lens.cy) / lens.fy);
        m->z[i] += noise * (sum - 6) * depth_noise_m(m->z[i]);
        m->sure[i] = 1;
        for (size_t c = 0; c < 3; c++) m->color[3 * i + c] = c == 1 ? 0.25f : 0.0f;
    }
}

/* Fuses frames of one place by a camera that moves to the right by `step` metres; the place is as
 * the first one sees it, so that only walls may be seen from elsewhere. */
static void fuse(place_fn place, double voxel_m, int frames, double step, float noise,
                 struct fusion *f)
{
    static const double origin[3] = {0, 0, 0};
    assert_int_equal(fusion_create(voxel_m, origin, f), 0);
    for (int k = 0; k < frames; k++) {
        struct depth_map m;
        const struct affine pose = affine_translation((double[3]){step * k, 0, 0});
        see(place, noise, 100 + (uint64_t)k, &m);
        assert_int_equal(fusion_add(f, &m, &lens, &pose, white), 0);
        depth_map_destroy(&m);
    }
}

static void mesh_of(const struct fusion *f, struct mesh *out, uint32_t *first_shining)
{
    assert_int_equal(fusion_mesh_make(f, out, first_shining, &(struct fault){0}), 0);
    assert_true(out->triangle_count > 0);
}

static double area_of(const struct mesh *m)
{
    double sum = 0;
    for (uint32_t t = 0; t < m->triangle_count; t++) {
        double n[3];
        mesh_triangle_normal(m->positions, m->triangles + 3 * (size_t)t, n);
        sum += 0.5 * sqrt(dot3(n, n));
    }
    return sum;
}

TEST(a_wall_is_where_two_cameras_saw_it)
{
    struct fusion f;
    struct mesh m;
    uint32_t first_shining;
    fuse(wall, 0.03, 2, 0.5, 0, &f);
    mesh_of(&f, &m, &first_shining);
    assert_int_equal(first_shining, m.triangle_count);
    for (uint32_t v = 0; v < m.vertex_count; v++) {
        assert_true(fabsf(m.positions[3 * v + 2] - 2) < 1e-3f);
        assert_true(m.normals[3 * v + 2] < -0.999f);
        assert_true(fabsf(m.colors[4 * v + 1] - 0.4f) < 1e-3f && m.colors[4 * v] == 0);
    }
    for (uint32_t t = 0; t < m.triangle_count; t++) {
        double n[3];
        mesh_triangle_normal(m.positions, m.triangles + 3 * (size_t)t, n);
        assert_true(n[2] < 0);
    }
    /* 2 x 1.5 m of each, half a metre apart, and a strip of two voxels at most. */
    const double area = area_of(&m);
    assert_true(area > 2.5 * 1.5 - 0.1 && area < 2.62 * 1.62 + 0.1);
    mesh_fini(&m);
    fusion_destroy(&f);
}

/* From low above it pixels of a floor are far apart, which are no jumps. */
TEST(floors_have_no_holes)
{
    struct fusion f;
    struct mesh m;
    uint32_t first_shining;
    double floor_area = 0;
    fuse(room, 0.03, 1, 0, 0, &f);
    mesh_of(&f, &m, &first_shining);
    for (uint32_t t = 0; t < m.triangle_count; t++) {
        double n[3];
        const uint32_t *v = m.triangles + 3 * (size_t)t;
        mesh_triangle_normal(m.positions, v, n);
        const float *p = m.positions + 3 * (size_t)v[0];
        if (fabsf(p[1] - 0.5f) < 0.02f && p[2] < 3.3f) floor_area += 0.5 * fabs(n[1]);
    }
    /* From 1.37 m on it is as wide as z, whose integral this is. */
    assert_true(floor_area > 0.98 * (3.3 * 3.3 - 1.37 * 1.37) / 2);
    assert_true(floor_area < 1.1 * (3.3 * 3.3 - 1.37 * 1.37) / 2);
    mesh_fini(&m);
    fusion_destroy(&f);
}

TEST(nothing_spans_a_jump)
{
    struct fusion f;
    struct mesh m;
    uint32_t first_shining, near = 0, far = 0;
    fuse(two_walls, 0.03, 1, 0, 0, &f);
    mesh_of(&f, &m, &first_shining);
    for (uint32_t v = 0; v < m.vertex_count; v++) {
        const float z = m.positions[3 * v + 2];
        assert_true(z < 1.1f || z > 2.9f);
        near += z < 1.1f;
        far += z > 2.9f;
    }
    assert_true(near > 350 && far > 350);
    mesh_fini(&m);
    fusion_destroy(&f);
}

static double error_of(int frames)
{
    struct fusion f;
    struct mesh m;
    uint32_t first_shining;
    double sum = 0;
    fuse(wall, 0.02, frames, 0, 1, &f);
    mesh_of(&f, &m, &first_shining);
    for (uint32_t v = 0; v < m.vertex_count; v++) {
        const double off = (double)m.positions[3 * v + 2] - 2;
        sum += off * off / m.vertex_count;
    }
    mesh_fini(&m);
    fusion_destroy(&f);
    return sqrt(sum);
}

TEST(frames_take_each_others_noise_away)
{
    const double one = error_of(1), many = error_of(9);
    assert_true(one < 0.01 && many < 0.5 * one);
}

TEST(what_shines_comes_last)
{
    static const double origin[3] = {0, 0, 0};
    struct fusion f;
    struct mesh m;
    struct depth_map map;
    uint32_t first_shining;
    const struct affine pose = affine_identity();
    see(wall, 0, 1, &map);
    for (size_t i = 0; i < (size_t)WIDTH * HEIGHT; i++)
        if (i % WIDTH < WIDTH / 2) map.color[3 * i] = map.color[3 * i + 1] = 8;
    assert_int_equal(fusion_create(0.03, origin, &f), 0);
    assert_int_equal(fusion_add(&f, &map, &lens, &pose, white), 0);
    mesh_of(&f, &m, &first_shining);
    assert_true(first_shining > m.triangle_count / 3 && first_shining < 2 * m.triangle_count / 3);
    for (uint32_t t = 0; t < m.triangle_count; t++) {
        const float x = m.positions[3 * m.triangles[3 * (size_t)t]];
        assert_true(t < first_shining ? x > -0.05f : x < 0.1f);
    }
    depth_map_destroy(&map);
    mesh_fini(&m);
    fusion_destroy(&f);
}

TEST(volumes_have_a_limit)
{
    static const double origin[3] = {0, 0, 0};
    struct fusion f;
    struct depth_map m;
    struct affine pose = affine_identity();
    see(wall, 0, 1, &m);
    assert_int_equal(fusion_create(0.004, origin, &f), 0);
    assert_int_equal(fusion_add(&f, &m, &lens, &pose, white), 0);
    for (int k = 1; k < 40; k++) { /* each sees another part of the wall */
        pose.m[3] = 3.0 * k;
        const int rc = fusion_add(&f, &m, &lens, &pose, white);
        assert_true(rc == 0 || rc == ERR_LIMIT);
        if (rc != 0) break;
        assert_true(k < 39);
    }
    assert_true(f.count == LIMIT_FUSION_BLOCKS);
    fusion_destroy(&f);
    assert_int_equal(fusion_create(0.03, origin, &f), 0);
    pose.m[3] = 1e12;
    assert_int_equal(fusion_add(&f, &m, &lens, &pose, white), ERR_LIMIT);
    assert_int_equal(f.count, 0);
    fusion_destroy(&f);
    depth_map_destroy(&m);
}
