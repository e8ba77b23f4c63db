#include "server/reconstruct/motion/motion.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

int motion_create(uint32_t part_count, struct motion **out)
{
    struct motion *m = calloc(1, sizeof *m);
    if (m) m->parts = calloc((size_t)part_count + 1, sizeof *m->parts);
    *out = m;
    if (!m) return ERR_MEMORY;
    m->holders = 1;
    if (m->parts) {
        m->part_count = part_count;
        return 0;
    }
    motion_drop(out);
    return ERR_MEMORY;
}

struct motion *motion_hold(struct motion *motion)
{
    if (motion) motion->holders++;
    return motion;
}

void motion_drop(struct motion **motion)
{
    struct motion *m = *motion;
    *motion = NULL;
    if (!m || --m->holders > 0) return;
    for (uint32_t i = 0; i < m->part_count; i++) motion_mesh_destroy(&m->parts[i].mesh);
    free(m->parts);
    free(m);
}

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
    *x = (a / (double)camera->half_width + (double)camera->centre_x + 1) * plan->width_px / 2;
    *y = (1 - (double)camera->centre_y - b / (double)camera->half_height) * plan->height_px / 2;
    return isfinite(*x) && isfinite(*y);
}

static bool is_same3(const float a[3], const float b[3])
{
    return a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
}

bool motion_is_same_view(const struct plan_camera *a, const struct plan_camera *b)
{
    return a->type == b->type && is_same3(a->eye, b->eye) && is_same3(a->right, b->right) &&
           is_same3(a->up, b->up) && is_same3(a->forward, b->forward) &&
           a->half_width == b->half_width && a->half_height == b->half_height &&
           a->centre_x == b->centre_x && a->centre_y == b->centre_y;
}

bool motion_keeps_view(const struct motion *motion, const struct plan_camera *now)
{
    return motion_is_same_view(now, &motion->camera[MOTION_BACKWARD]) &&
           motion_is_same_view(now, &motion->camera[MOTION_FORWARD]);
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

/* What is known to move; NULL: nothing is, or it is far. */
static const struct motion_part *part_of(const struct motion *m, const struct motion_point *p)
{
    return !p->is_far && p->id > 0 && p->id <= m->part_count ? &m->parts[p->id - 1] : NULL;
}

void motion_show(const struct plan *plan, const struct patch *patch, int32_t x, int32_t y,
                 struct motion_point *out)
{
    float origin[3], direction[3];
    const size_t i = patch_pixel(patch, x, y);
    *out = (struct motion_point){
        .x = x + 0.5, .y = y + 0.5, .is_far = !(patch->depth[i] > 0), .id = patch->id[i]};
    plan_camera_ray(plan, (float)x + 0.5f, (float)y + 0.5f, origin, direction);
    for (int c = 0; c < 3; c++)
        out->at[c] = out->is_far
                         ? (double)direction[c]
                         : (double)origin[c] + (double)patch->depth[i] * (double)direction[c];
}

bool motion_follow(const struct motion *m, const struct plan *plan, const struct plan *next,
                   enum motion_side side, struct motion_point *p)
{
    const struct motion_part *part = m ? part_of(m, p) : NULL;
    const bool moves = part && part->moves[side];
    const struct plan_camera *camera = m ? &m->camera[side] : &next->camera;
    if (!moves && motion_is_same_view(camera, &plan->camera)) return true;
    if (moves) follow(part, side, p->at);
    return project(camera, plan, p->at, p->is_far, &p->x, &p->y);
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
            for (int32_t x = block.x0; x < block.x1; x++) {
                struct motion_point p;
                motion_show(plan, patch, x, y, &p);
                const bool seen = motion_follow(m, plan, NULL, (enum motion_side)side, &p);
                *plane_at(out[0], x, y) = seen ? (float)(p.x - (x + 0.5)) : 0.0f;
                *plane_at(out[1], x, y) = seen ? (float)(p.y - (y + 0.5)) : 0.0f;
            }
        }
    }
}
