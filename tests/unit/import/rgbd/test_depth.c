/* Depth of a frame: how it becomes better, and the mesh of it. */
#include <math.h>
#include <stdlib.h>

#include "server/import/rgbd/depth_map.h"
#include "server/import/rgbd/depth_mesh.h"
#include "tests/random.h"
#include "tests/unit/unit.h"

#define WIDTH  40
#define HEIGHT 30
#define STEP   20 /* the column where depth jumps */

static const struct rgbd_document lens = {
    .fx = 40, .fy = 40, .cx = 19.5, .cy = 14.5, .near_m = 0.1, .far_m = 30};

/* Two walls that lean back, a metre apart, one red and the other blue. */
static float true_z(int x, int y)
{
    return (x < STEP ? 1.5f : 2.5f) + 0.01f * (float)y;
}

static void make_map(struct depth_map *m, float noise, uint64_t seed)
{
    struct random random = {seed};
    *m = (struct depth_map){.width = WIDTH, .height = HEIGHT};
    m->z = calloc(WIDTH * HEIGHT, sizeof *m->z);
    m->sure = calloc(WIDTH * HEIGHT, sizeof *m->sure);
    m->color = calloc(WIDTH * HEIGHT, 3 * sizeof *m->color);
    assert_true(m->z && m->sure && m->color);
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        const float z = true_z(i % WIDTH, i / WIDTH);
        float sum = 0; /* of variance 1 */
        for (int k = 0; k < 12; k++) sum += random_unit(&random);
        m->z[i] = z + noise * (sum - 6) * depth_noise_m(z);
        m->sure[i] = 1;
        m->color[3 * i + (i % WIDTH < STEP ? 0 : 2)] = 0.5f;
    }
}

static double error_of(const struct depth_map *m)
{
    double sum = 0;
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        const double off = (double)(m->z[i] - true_z(i % WIDTH, i / WIDTH));
        sum += off * off;
    }
    return sqrt(sum / (WIDTH * HEIGHT));
}

TEST(filtering_takes_noise_away_and_keeps_edges)
{
    struct depth_map m;
    make_map(&m, 1, 7);
    const double before = error_of(&m);
    for (int y = 10; y < 14; y++) /* a hole */
        for (int x = 24; x < 29; x++) m.z[y * WIDTH + x] = m.sure[y * WIDTH + x] = 0;
    m.z[5 * WIDTH + STEP] = 2.0f; /* between both walls */
    depth_map_drop_strays(&m);
    assert_true(m.z[5 * WIDTH + STEP] == 0);
    assert_int_equal(depth_map_smooth(&m, &(struct fault){0}), 0);
    assert_true(error_of(&m) < 0.6 * before);
    for (int y = 0; y < HEIGHT; y++) {
        assert_true(fabsf(m.z[y * WIDTH + STEP - 1] - true_z(STEP - 1, y)) < 0.05f);
        assert_true(fabsf(m.z[y * WIDTH + STEP] - true_z(STEP, y)) < 0.05f);
    }
    depth_map_destroy(&m);
}

/* What is farther than 32 pixels from all that was measured stays unknown. */
TEST(wide_holes_are_filled_at_their_edges)
{
    struct depth_map m;
    make_map(&m, 0, 7);
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        m.color[3 * i] = m.color[3 * i + 2] = 0.5f;
        if (i % WIDTH < WIDTH - 1) m.z[i] = m.sure[i] = 0;
    }
    assert_int_equal(depth_map_smooth(&m, &(struct fault){0}), 0);
    for (int y = 0; y < HEIGHT; y++) {
        assert_true(m.z[y * WIDTH + WIDTH - 10] > 0 && m.sure[y * WIDTH + WIDTH - 10] < 1);
        assert_true(m.z[y * WIDTH] == 0);
    }
    depth_map_destroy(&m);
}

TEST(frames_make_each_other_better)
{
    struct depth_map m, other;
    const struct affine same = affine_identity();
    make_map(&m, 1, 7);
    const double before = error_of(&m);
    for (uint64_t k = 0; k < 3; k++) {
        make_map(&other, 1, 100 + k);
        assert_int_equal(depth_map_fuse(&m, &other, &lens, &same, &same, &(struct fault){0}), 0);
        depth_map_destroy(&other);
    }
    assert_true(error_of(&m) < 0.65 * before); /* half, but where gates cut */
    m.z[3] = m.sure[3] = 0;
    make_map(&other, 0, 1);
    assert_int_equal(depth_map_fuse(&m, &other, &lens, &same, &same, &(struct fault){0}), 0);
    assert_true(m.z[3] == other.z[3] && m.sure[3] < 1);
    depth_map_destroy(&other);
    depth_map_destroy(&m);
}

/* ---- the mesh ---- */

TEST(meshes_break_at_jumps_and_face_the_camera)
{
    static const float white[3] = {0.5f, 0.5f, 0.5f};
    struct depth_map m;
    struct mesh mesh;
    uint32_t first_shining;
    make_map(&m, 0, 1);
    m.color[0] = 8; /* a lamp */
    assert_int_equal(depth_mesh_make(&m, &lens, white, &mesh, &first_shining, &(struct fault){0}),
                     0);
    assert_int_equal(mesh.triangle_count, 2 * WIDTH * HEIGHT);
    assert_int_equal(first_shining, mesh.triangle_count - 2);
    /* The corners of the jump are there twice. */
    assert_int_equal(mesh.vertex_count, (WIDTH + 2) * (HEIGHT + 1));
    for (uint32_t t = 0; t < mesh.triangle_count; t++) {
        double n[3];
        float low = INFINITY, high = 0;
        mesh_triangle_normal(mesh.positions, mesh.triangles + 3 * t, n);
        assert_true(n[2] < 0);
        for (int k = 0; k < 3; k++) {
            const float *p = mesh.positions + 3 * mesh.triangles[3 * t + (uint32_t)k];
            low = fminf(low, p[2]);
            high = fmaxf(high, p[2]);
        }
        assert_true(high - low < 0.1f);
    }
    mesh_fini(&mesh);
    depth_map_destroy(&m);
}
