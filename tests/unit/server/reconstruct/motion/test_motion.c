/* Motion in pixels against closed forms: of cameras, of rigid parts, of a mesh that bends, and of
 * the background. */
#include <math.h>
#include <string.h>

#include "proto/job/job.h"
#include "server/reconstruct/motion/motion.h"
#include "tests/unit/unit.h"

#define WIDTH  8
#define HEIGHT 4

static struct plan plan;
static struct patch patch;
static float depth[WIDTH * HEIGHT];
static uint32_t id[WIDTH * HEIGHT];

/* A camera at the origin that looks along -z, in front of a wall 2 away, of instance 1. A picture
 * is 4 by 2 at distance 2, so that a unit there is 2 pixels. */
static void set_up_wall(void)
{
    plan = (struct plan){.width_px = WIDTH, .height_px = HEIGHT};
    plan.camera = (struct plan_camera){.type = CAMERA_PERSPECTIVE,
                                       .right = {1, 0, 0},
                                       .up = {0, 1, 0},
                                       .forward = {0, 0, -1},
                                       .half_width = 1,
                                       .half_height = .5f};
    const struct rect whole = {0, 0, WIDTH, HEIGHT};
    patch = (struct patch){.rect = whole, .core = whole, .depth = depth, .id = id};
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++) {
            float origin[3], direction[3];
            plan_camera_ray(&plan, (float)x + .5f, (float)y + .5f, origin, direction);
            depth[y * WIDTH + x] = -2 / direction[2];
            id[y * WIDTH + x] = 1;
        }
}

static struct motion *standing(uint32_t parts)
{
    struct motion *m;
    assert_int_equal(motion_create(parts, &m), 0);
    m->camera[MOTION_BACKWARD] = m->camera[MOTION_FORWARD] = plan.camera;
    return m;
}

/* Composes, and expects one motion of all pixels from `first` on. */
static void expect(const struct motion *m, const char *layer, int first, float x, float y)
{
    struct image *image;
    char names[2][32];
    assert_int_equal(image_create(LAYERS_MOTION, WIDTH, HEIGHT, &image), 0);
    motion_compose(m, &plan, &patch, patch.rect, image);
    snprintf(names[0], sizeof names[0], "motion.%s.X", layer);
    snprintf(names[1], sizeof names[1], "motion.%s.Y", layer);
    for (int i = first; i < WIDTH * HEIGHT; i++) {
        const float dx = *plane_at(image_plane(image, names[0]), i % WIDTH, i / WIDTH);
        const float dy = *plane_at(image_plane(image, names[1]), i % WIDTH, i / WIDTH);
        if (!(fabsf(dx - x) < 1e-5f && fabsf(dy - y) < 1e-5f))
            fail_msg("pixel %d moves by %g %g, not %g %g", i, (double)dx, (double)dy, (double)x,
                     (double)y);
    }
    image_destroy(&image);
}

TEST(what_stands_does_not_move)
{
    set_up_wall();
    struct motion *m = standing(1);
    expect(m, "backward", 0, 0, 0);
    expect(NULL, "forward", 0, 0, 0);
    motion_drop(&m);
}

/* The camera goes 0.5 to the right: what stands goes a pixel to the left. */
TEST(cameras_move_what_stands)
{
    set_up_wall();
    struct motion *m = standing(1);
    m->camera[MOTION_FORWARD].eye[0] = .5f;
    m->camera[MOTION_BACKWARD].eye[1] = .25f;
    expect(m, "forward", 0, -1, 0);
    expect(m, "backward", 0, 0, .5f); /* up it was: the wall was lower, and y goes down */
    motion_drop(&m);
}

TEST(rigid_parts_move_by_their_transforms)
{
    set_up_wall();
    struct motion *m = standing(1);
    m->parts[0].moves[0] = m->parts[0].moves[1] = true;
    const double right[12] = {1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0};
    const double away[12] = {2, 0, 0, 0, 0, 2,
                             0, 0, 0, 0, 1, -2}; /* twice as large, twice as far */
    memcpy(m->parts[0].to[MOTION_FORWARD], right, sizeof right);
    memcpy(m->parts[0].to[MOTION_BACKWARD], away, sizeof away);
    expect(m, "forward", 0, 2, 0);
    expect(m, "backward", 0, 0, 0);
    id[0] = 2; /* no part of this motion: it stands */
    expect(m, "forward", 1, 2, 0);
    motion_drop(&m);
}

/* A wall of two triangles goes up by 0.25, and its right side by 0.75: in the middle by 0.5, in
 * proportion between. */
TEST(bent_meshes_are_followed_by_their_triangles)
{
    static const uint32_t triangles[] = {0, 1, 2, 0, 2, 3};
    static const float now[] = {-2, -1, -2, 2, -1, -2, 2, 1, -2, -2, 1, -2};
    static const float then[] = {-2, -.75f, -2, 2, -.25f, -2, 2, 1.75f, -2, -2, 1.25f, -2};
    const float *const sides[MOTION_SIDES] = {now, then};
    set_up_wall();
    struct motion *m = standing(1);
    struct image *image;
    m->parts[0].moves[0] = m->parts[0].moves[1] = true;
    assert_int_equal(motion_mesh_create(triangles, 2, 4, now, sides, &m->parts[0].mesh), 0);
    expect(m, "backward", 0, 0, 0);
    assert_int_equal(image_create(LAYERS_MOTION, WIDTH, HEIGHT, &image), 0);
    motion_compose(m, &plan, &patch, patch.rect, image);
    for (int x = 0; x < WIDTH; x++)
        for (int y = 0; y < HEIGHT; y++) {
            const float share = ((float)x + .5f) / WIDTH, up = .25f + .5f * share;
            assert_true(fabsf(*plane_at(image_plane(image, "motion.forward.X"), x, y)) < 1e-5f);
            assert_true(fabsf(*plane_at(image_plane(image, "motion.forward.Y"), x, y) + 2 * up) <
                        1e-5f);
        }
    image_destroy(&image);
    motion_drop(&m);
}

/* Many triangles of many sizes are all found: each point goes where its triangle goes. */
TEST(triangles_are_found_in_a_crowd)
{
    enum { SIDE = 40, COUNT = SIDE * SIDE };
    static float now[9 * COUNT], then[9 * COUNT];
    static uint32_t triangles[3 * COUNT];
    const float *const sides[MOTION_SIDES] = {NULL, then};
    struct motion_mesh *mesh;
    for (uint32_t t = 0; t < COUNT; t++)
        for (uint32_t k = 0; k < 3; k++) {
            const float size = t % 7 == 0 ? 9.f : .5f;
            float *p = now + 9 * t + 3 * k;
            p[0] = (float)(t % SIDE) + (k == 1 ? size : 0);
            p[1] = (float)(t / SIDE) + (k == 2 ? size : 0);
            p[2] = .01f * (float)((t * 37) % COUNT); /* those that overlap are apart */
            memcpy(then + 9 * t + 3 * k, p, 3 * sizeof *p);
            then[9 * t + 3 * k + 2] += (float)t;
            triangles[3 * t + k] = 3 * t + k;
        }
    assert_int_equal(motion_mesh_create(triangles, COUNT, 3 * COUNT, now, sides, &mesh), 0);
    for (uint32_t t = 0; t < COUNT; t++) {
        const float *a = now + 9 * t, *b = a + 3, *c = a + 6;
        double at[3], there[3];
        for (int i = 0; i < 3; i++)
            at[i] = there[i] = .6 * (double)a[i] + .25 * (double)b[i] + .15 * (double)c[i];
        motion_mesh_follow(mesh, MOTION_BACKWARD, there);
        assert_memory_equal(at, there, sizeof at); /* it is not known */
        motion_mesh_follow(mesh, MOTION_FORWARD, there);
        assert_true(fabs(there[0] - at[0]) < 1e-4 && fabs(there[1] - at[1]) < 1e-4);
        assert_true(fabs(there[2] - at[2] - t) < 1e-3);
    }
    motion_mesh_destroy(&mesh);
}

/* Triangles that all are as large as their mesh need no more memory than others. */
TEST(triangle_soup_has_a_grid)
{
    enum { COUNT = 20000 };
    static float now[9 * COUNT];
    static uint32_t triangles[3 * COUNT];
    const float *const sides[MOTION_SIDES] = {now, now};
    struct motion_mesh *mesh;
    double at[3] = {.25, .25, .5};
    for (uint32_t t = 0; t < COUNT; t++)
        for (uint32_t k = 0; k < 3; k++) {
            now[9 * t + 3 * k + k] = 1;
            now[9 * t + 3 * k + 2] += (float)t / COUNT;
            triangles[3 * t + k] = 3 * t + k;
        }
    assert_int_equal(motion_mesh_create(triangles, COUNT, 3 * COUNT, now, sides, &mesh), 0);
    motion_mesh_follow(mesh, MOTION_FORWARD, at);
    assert_true(isfinite(at[0]) && isfinite(at[1]) && isfinite(at[2]));
    motion_mesh_destroy(&mesh);
}

/* A camera that turns by a quarter of its view moves what is far by half the picture. */
TEST(the_background_turns_with_the_camera)
{
    set_up_wall();
    memset(depth, 0, sizeof depth);
    struct motion *m = standing(1);
    struct plan_camera *camera = &m->camera[MOTION_FORWARD];
    const float half = sqrtf(.5f);
    camera->forward[0] = half, camera->forward[2] = -half;
    camera->right[0] = half, camera->right[2] = half;
    struct image *image;
    assert_int_equal(image_create(LAYERS_MOTION, WIDTH, HEIGHT, &image), 0);
    motion_compose(m, &plan, &patch, patch.rect, image);
    for (int x = 0; x < WIDTH; x++) {
        const double a = (x + .5) / 4 - 1; /* tangents: those of angles 45 degrees less */
        const double turned = (a - 1) / (1 + a), seen = 4 * (turned + 1) - (x + .5);
        const double dx = (double)*plane_at(image_plane(image, "motion.forward.X"), x, 1);
        assert_true(fabs(dx - seen) < 1e-4);
    }
    image_destroy(&image);
    camera->forward[2] = half; /* behind it */
    camera->forward[0] = 0, camera->forward[2] = 1;
    expect(m, "forward", 0, 0, 0);
    motion_drop(&m);
}
