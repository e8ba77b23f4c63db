/* The instances of frames are those of their base, which stand; then placements of the base's
 * meshes, mesh by mesh; then meshes of the frame's own. What is hidden at times is missing then, so
 * the second are matched within their mesh, and the third by their names and sizes in turn. */
#include "server/job/prepare/frame_motion.h"

#include <string.h>

/* A row of instances that are to be matched: of one mesh of the base, or of meshes of a frame. */
struct row {
    uint64_t first, end;
};

static uint64_t standing(const struct scene *s)
{
    return s->base ? s->base->count[SCENE_INSTANCES] : 0;
}

static bool is_based(const struct scene *s, uint64_t i)
{
    return s->meshes[s->instances[i].mesh].flags & MESH_IN_BASE;
}

/* Returns the row that instance i begins. */
static struct row row_from(const struct scene *s, uint64_t i)
{
    struct row r = {i, i};
    const bool based = is_based(s, i);
    while (r.end < s->count[SCENE_INSTANCES] && is_based(s, r.end) == based &&
           (!based || s->instances[r.end].mesh == s->instances[i].mesh))
        r.end++;
    return r;
}

/* Returns the placements of a mesh of the base, from *next on. Frames place these meshes in their
 * order. */
static struct row row_of_mesh(const struct scene *s, uint32_t mesh, uint64_t *next)
{
    uint64_t i = *next;
    while (i < s->count[SCENE_INSTANCES] && !(is_based(s, i) && s->instances[i].mesh >= mesh)) i++;
    *next = i;
    if (i == s->count[SCENE_INSTANCES] || s->instances[i].mesh != mesh) return (struct row){i, i};
    return row_from(s, i);
}

static const char *instance_name(const struct scene *s, uint64_t i)
{
    return scene_name(s, s->instances[i].name);
}

/* Returns whether two meshes of frames are the same in two poses. */
static bool is_same_mesh(const struct scene *a, uint64_t i, const struct scene *b, uint64_t k)
{
    const struct scene_mesh *x = &a->meshes[a->instances[i].mesh];
    const struct scene_mesh *y = &b->meshes[b->instances[k].mesh];
    return x->vertex_count == y->vertex_count && x->triangle_count == y->triangle_count &&
           strcmp(instance_name(a, i), instance_name(b, k)) == 0 &&
           strcmp(scene_name(a, x->name), scene_name(b, y->name)) == 0;
}

static bool invert(const float m[12], double out[12])
{
    const double a = m[0], b = m[1], c = m[2], d = m[4], e = m[5], f = m[6], g = m[8], h = m[9],
                 k = m[10];
    const double r[9] = {e * k - f * h, c * h - b * k, b * f - c * e, f * g - d * k, a * k - c * g,
                         c * d - a * f, d * h - e * g, b * g - a * h, a * e - b * d};
    const double determinant = a * r[0] + b * r[3] + c * r[6];
    if (determinant == 0) return false;
    for (int i = 0; i < 3; i++) {
        double *row = out + 4 * i;
        for (int j = 0; j < 3; j++) row[j] = r[3 * i + j] / determinant;
        row[3] = -(row[0] * (double)m[3] + row[1] * (double)m[7] + row[2] * (double)m[11]);
    }
    return true;
}

/* Computes the motion from one transform to another, in the world. */
static bool between(const float from[12], const float to[12], double out[12])
{
    double inverse[12];
    if (!invert(from, inverse)) return false;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 4; j++) {
            double sum = j == 3 ? (double)to[4 * i + 3] : 0;
            for (int k = 0; k < 3; k++) sum += (double)to[4 * i + k] * inverse[4 * k + j];
            out[4 * i + j] = sum;
        }
    return true;
}

static bool is_same(const float *a, const float *b, size_t count)
{
    size_t i = 0;
    while (i < count && a[i] == b[i]) i++;
    return i == count;
}

/* Sets the motion of the placements of one mesh of the base. */
static void match_rigid(const struct scene *now, const struct scene *const sides[MOTION_SIDES],
                        struct row row, uint64_t next[MOTION_SIDES], struct motion *out)
{
    for (int side = 0; side < MOTION_SIDES; side++) {
        const struct row other =
            row_of_mesh(sides[side], now->instances[row.first].mesh, &next[side]);
        const bool matched = other.end - other.first == row.end - row.first;
        for (uint64_t i = row.first; i < row.end; i++) {
            struct motion_part *part = &out->parts[i];
            const float *from = now->instances[i].to_world;
            const uint64_t k = other.first + (i - row.first);
            const float *to = matched ? sides[side]->instances[k].to_world : from;
            part->moves[side] = !is_same(from, to, 12) && between(from, to, part->to[side]);
        }
    }
}

static const float *positions_of(const struct scene *s, uint64_t i)
{
    return s->positions + 3 * (size_t)s->meshes[s->instances[i].mesh].first_vertex;
}

/* Frames' own meshes are baked into the world. */
static int match_bent(const struct scene *now, const struct scene *const sides[MOTION_SIDES],
                      const uint64_t at[MOTION_SIDES], uint64_t i, struct motion_part *out)
{
    const struct scene_mesh *mesh = &now->meshes[now->instances[i].mesh];
    const float *positions[MOTION_SIDES] = {NULL, NULL};
    for (int side = 0; side < MOTION_SIDES; side++)
        if (at[side] < sides[side]->count[SCENE_INSTANCES]) {
            positions[side] = positions_of(sides[side], at[side]);
            out->moves[side] =
                !is_same(positions[side], positions_of(now, i), 3 * (size_t)mesh->vertex_count);
        }
    if (!out->moves[MOTION_BACKWARD] && !out->moves[MOTION_FORWARD]) return 0;
    return motion_mesh_create(now->triangles + 3 * (size_t)mesh->first_triangle,
                              mesh->triangle_count, mesh->vertex_count, positions_of(now, i),
                              positions, &out->mesh);
}

/* Instances that are looked at for one: what a side lacks is mostly little. */
#define LOOKED_AT_MAX 4096

/* Finds the next mesh of a side that is the one of instance i; the end: it is not there. */
static uint64_t find_next(const struct scene *now, uint64_t i, const struct scene *side,
                          uint64_t from)
{
    const uint64_t count = side->count[SCENE_INSTANCES];
    for (uint64_t k = from; k < count && k - from < LOOKED_AT_MAX; k++)
        if (!is_based(side, k) && is_same_mesh(now, i, side, k)) return k;
    return count;
}

int frame_motion_create(const struct scene *now, const struct scene *const sides[MOTION_SIDES],
                        const struct plan_camera cameras[MOTION_SIDES], struct motion **out)
{
    uint64_t next[MOTION_SIDES] = {standing(now), standing(now)}; /* of frames' own meshes */
    uint64_t placed[MOTION_SIDES] = {standing(now), standing(now)};
    const uint64_t count = now->count[SCENE_INSTANCES];
    int error = motion_create((uint32_t)count, out);
    for (int side = 0; !error && side < MOTION_SIDES; side++) (*out)->camera[side] = cameras[side];
    for (uint64_t i = standing(now); !error && i < count;) {
        if (is_based(now, i)) {
            const struct row row = row_from(now, i);
            match_rigid(now, sides, row, placed, *out);
            i = row.end;
            continue;
        }
        uint64_t at[MOTION_SIDES];
        for (int side = 0; side < MOTION_SIDES; side++) {
            at[side] = find_next(now, i, sides[side], next[side]);
            if (at[side] < sides[side]->count[SCENE_INSTANCES]) next[side] = at[side] + 1;
        }
        error = match_bent(now, sides, at, i, &(*out)->parts[i]);
        i++;
    }
    if (error) motion_drop(out);
    return error;
}
