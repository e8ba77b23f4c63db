#include "server/reconstruct/compose/motion.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

int motion_create(uint32_t part_count, struct motion **out)
{
    struct motion *m = calloc(1, sizeof *m);
    if (m) m->parts = calloc((size_t)part_count + 1, sizeof *m->parts);
    *out = m;
    if (m && m->parts) {
        m->part_count = part_count;
        return 0;
    }
    motion_destroy(out);
    return ERR_MEMORY;
}

void motion_destroy(struct motion **motion)
{
    struct motion *m = *motion;
    *motion = NULL;
    if (!m) return;
    for (uint32_t i = 0; i < m->part_count; i++) motion_mesh_destroy(&m->parts[i].mesh);
    free(m->parts);
    free(m);
}

/* A pixel's centre, and what it shows. */
struct shown {
    double x, y;  /* of the picture */
    double at[3]; /* of the world; a direction where there is no surface */
    bool is_far;
    const struct motion_part *part; /* NULL: none is known, or it is far */
};

static double along(const float axis[3], const double v[3])
{
    return (double)axis[0] * v[0] + (double)axis[1] * v[1] + (double)axis[2] * v[2];
}

/* Finds where a camera sees a point, in pixels. False: it does not. */
static bool project(const struct plan_camera *camera, const struct plan *plan, const double at[3],
                    bool is_far, double *x, double *y)
{
    double v[3];
    for (int c = 0; c < 3; c++) v[c] = is_far ? at[c] : at[c] - (double)camera->eye[c];
    const double ahead = along(camera->forward, v);
    double scale = 1;
    if (camera->type == CAMERA_PERSPECTIVE) {
        if (!(ahead > 0)) return false;
        scale = 1 / ahead;
    } else if (is_far) {
        return false; /* all of the picture looks the same way */
    }
    const double a = along(camera->right, v) * scale, b = along(camera->up, v) * scale;
    *x = (a / (double)camera->half_width + 1) * plan->width_px / 2;
    *y = (1 - b / (double)camera->half_height) * plan->height_px / 2;
    return isfinite(*x) && isfinite(*y);
}

static bool is_same3(const float a[3], const float b[3])
{
    return a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
}

static bool is_same(const struct plan_camera *a, const struct plan_camera *b)
{
    return a->type == b->type && is_same3(a->eye, b->eye) && is_same3(a->right, b->right) &&
           is_same3(a->up, b->up) && is_same3(a->forward, b->forward) &&
           a->half_width == b->half_width && a->half_height == b->half_height;
}

static void follow(const struct motion_part *part, enum motion_side side, double at[3])
{
    if (part->mesh) {
        motion_mesh_follow(part->mesh, side, at);
        return;
    }
    const double p[3] = {at[0], at[1], at[2]};
    for (int c = 0; c < 3; c++) {
        const double *row = part->to[side] + 4 * c;
        at[c] = row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + row[3];
    }
}

static void move(const struct motion *m, const struct plan *plan, enum motion_side side,
                 const struct shown *shown, float out[2])
{
    double at[3] = {shown->at[0], shown->at[1], shown->at[2]}, x, y;
    out[0] = out[1] = 0;
    const bool moves = shown->part && shown->part->moves[side];
    if (!moves && is_same(&m->camera[side], &plan->camera)) return;
    if (moves) follow(shown->part, side, at);
    if (!project(&m->camera[side], plan, at, shown->is_far, &x, &y)) return;
    out[0] = (float)(x - shown->x);
    out[1] = (float)(y - shown->y);
}

static void show(const struct motion *m, const struct plan *plan, const struct patch *patch,
                 int32_t x, int32_t y, size_t i, struct shown *out)
{
    float origin[3], direction[3];
    *out = (struct shown){.x = x + 0.5, .y = y + 0.5, .is_far = !(patch->depth[i] > 0)};
    plan_camera_ray(plan, (float)x + 0.5f, (float)y + 0.5f, origin, direction);
    for (int c = 0; c < 3; c++)
        out->at[c] = out->is_far
                         ? (double)direction[c]
                         : (double)origin[c] + (double)patch->depth[i] * (double)direction[c];
    const uint32_t id = patch->id[i]; /* 1 + the instance; 0: none */
    if (!out->is_far && id > 0 && id <= m->part_count) out->part = &m->parts[id - 1];
}

void motion_compose(const struct motion *m, const struct plan *plan, const struct patch *patch,
                    struct rect block, struct image *image)
{
    static const char *const names[MOTION_SIDES][2] = {{"motion.backward.X", "motion.backward.Y"},
                                                       {"motion.forward.X", "motion.forward.Y"}};
    if (!m || !patch->depth || !patch->id) return;
    for (int side = 0; side < MOTION_SIDES; side++) {
        const struct plane *out[2] = {image_plane(image, names[side][0]),
                                      image_plane(image, names[side][1])};
        if (!out[0] || !out[1]) continue;
        for (int32_t y = block.y0; y < block.y1; y++) {
            size_t i = patch_pixel(patch, block.x0, y);
            for (int32_t x = block.x0; x < block.x1; x++, i++) {
                struct shown shown;
                float by[2];
                show(m, plan, patch, x, y, i, &shown);
                move(m, plan, (enum motion_side)side, &shown, by);
                *plane_at(out[0], x, y) = by[0];
                *plane_at(out[1], x, y) = by[1];
            }
        }
    }
}
