/* Cameras of scenes that have none: all of the box is in the picture, and little else. */
#include <math.h>

#include "proto/scene/camera_fit.h"
#include "tests/unit/unit.h"

static double along(const float v[3], const double d[3])
{
    return (double)v[0] * d[0] + (double)v[1] * d[1] + (double)v[2] * d[2];
}

/* The largest shares of half the picture at which corners stand, across and down. */
static void look(const struct scene_camera *c, const float box[2][3], double aspect, double most[2])
{
    const double half = tan((double)c->yfov_rad / 2);
    most[0] = most[1] = 0;
    for (int corner = 0; corner < 8; corner++) {
        double d[3];
        for (int i = 0; i < 3; i++) d[i] = (double)box[corner >> i & 1][i] - (double)c->eye[i];
        const double depth = along(c->forward, d);
        assert_true(depth > 0);
        most[0] = fmax(most[0], fabs(along(c->right, d)) / (depth * half * aspect));
        most[1] = fmax(most[1], fabs(along(c->up, d)) / (depth * half));
    }
}

TEST(boxes_fill_pictures_of_all_shapes)
{
    static const float boxes[][2][3] = {{{-1, -1, -1}, {1, 1, 1}},
                                        {{100, 0, -7}, {100.5f, 9, -6}},
                                        {{0, 0, 0}, {40, 0, 1}},
                                        {{-3, -1e-3f, 0}, {2, 0, 1e-3f}},
                                        {{1e-6f, 0, 0}, {3e-6f, 1e-6f, 1e-6f}}};
    static const double aspects[] = {1, 16.0 / 9, 0.5, 3};
    for (size_t b = 0; b < sizeof boxes / sizeof *boxes; b++)
        for (size_t a = 0; a < sizeof aspects / sizeof *aspects; a++) {
            struct scene_camera c = {0};
            double most[2];
            camera_fit(boxes[b][0], boxes[b][1], aspects[a], &c);
            look(&c, boxes[b], aspects[a], most);
            assert_true(most[0] < 0.95 && most[1] < 0.95);
            assert_true(fmax(most[0], most[1]) > 0.93);
            assert_true(c.forward[0] < -0.3f && c.forward[1] < -0.3f && c.forward[2] < -0.7f);
            assert_int_equal(c.is_default, 1);
        }
}

TEST(a_point_is_looked_at)
{
    static const float at[3] = {1, 2, 3};
    struct scene_camera c = {0};
    double most[2];
    const float box[2][3] = {{1, 2, 3}, {1, 2, 3}};
    camera_fit(at, at, 1, &c);
    look(&c, box, 1, most);
    assert_true(most[0] < 1e-6 && most[1] < 1e-6);
}
