#include "worker/scene/emitter_groups.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

/* The weight of a group's normals beside its radius, both squared: normals in all directions count
 * as half of the whole extent does. */
#define FACING 0.25

/* Ten digits of each of six coordinates. */
enum { DIGITS = 10, COORDINATES = 6 };

struct keyed {
    uint64_t key;
    uint32_t shape;
};

struct finder {
    const struct emitter_shape *shapes;
    struct keyed *keys; /* in the order of keys */
    double radius;      /* of all */
    struct emitter_groups *groups;
    double cost[EMITTER_GROUPS];
};

static double dot(const float a[3], const float b[3])
{
    return (double)a[0] * (double)b[0] + (double)a[1] * (double)b[1] + (double)a[2] * (double)b[2];
}

/* ---- order ---- */

struct box {
    float low[3], high[3];
};

static void box_add(struct box *b, const float p[3])
{
    for (int k = 0; k < 3; k++) {
        b->low[k] = fminf(b->low[k], p[k]);
        b->high[k] = fmaxf(b->high[k], p[k]);
    }
}

static struct box box_of(const struct finder *f, uint32_t first, uint32_t end)
{
    struct box b = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    for (uint32_t i = first; i < end; i++)
        for (int c = 0; c < 3; c++) box_add(&b, f->shapes[f->keys[i].shape].corner[c]);
    return b;
}

static uint64_t digits_of(double part)
{
    const double most = (1 << DIGITS) - 1, scaled = part * (double)(1 << DIGITS);
    return scaled > 0.0 ? (uint64_t)(scaled < most ? scaled : most) : 0;
}

/* Interleaves the digits of place and normal (Morton's order in six dimensions), so that triangles
 * that lie and face alike follow each other. */
static uint64_t key_of(const struct emitter_shape *s, const struct box *all, double extent)
{
    uint64_t part[COORDINATES], key = 0;
    for (int k = 0; k < 3; k++) {
        const double middle =
            ((double)s->corner[0][k] + (double)s->corner[1][k] + (double)s->corner[2][k]) / 3.0;
        part[k] = digits_of(extent > 0.0 ? (middle - (double)all->low[k]) / extent : 0.0);
        part[k + 3] = digits_of(0.5 + 0.5 * (double)s->normal[k]);
    }
    for (int digit = DIGITS - 1; digit >= 0; digit--)
        for (int k = 0; k < COORDINATES; k++) key = key << 1 | (part[k] >> digit & 1u);
    return key;
}

static int by_key(const void *a, const void *b)
{
    const struct keyed *x = a, *y = b;
    if (x->key != y->key) return x->key < y->key ? -1 : 1;
    return x->shape < y->shape ? -1 : 1;
}

static void sort(struct finder *f, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) f->keys[i].shape = i;
    const struct box all = box_of(f, 0, count);
    double extent = 0.0, squares = 0.0;
    for (int k = 0; k < 3; k++) {
        const double side = (double)all.high[k] - (double)all.low[k];
        extent = side > extent ? side : extent;
        squares += side * side;
    }
    f->radius = 0.5 * sqrt(squares);
    for (uint32_t i = 0; i < count; i++) f->keys[i].key = key_of(&f->shapes[i], &all, extent);
    qsort(f->keys, count, sizeof *f->keys, by_key);
}

/* ---- bounds ---- */

static void set_sphere(struct finder *f, uint32_t g)
{
    struct emitter_groups *o = f->groups;
    const struct box b = box_of(f, o->first[g], o->first[g + 1]);
    const float centre[3] = {0.5f * (b.low[0] + b.high[0]), 0.5f * (b.low[1] + b.high[1]),
                             0.5f * (b.low[2] + b.high[2])};
    double most = 0.0;
    for (uint32_t i = o->first[g]; i < o->first[g + 1]; i++)
        for (int c = 0; c < 3; c++) {
            const float *p = f->shapes[f->keys[i].shape].corner[c];
            const float way[3] = {p[0] - centre[0], p[1] - centre[1], p[2] - centre[2]};
            most = fmax(most, dot(way, way));
        }
    o->x[g] = centre[0];
    o->y[g] = centre[1];
    o->z[g] = centre[2];
    o->radius[g] = (float)(sqrt(most) * (1.0 + 1e-6));
}

static void set_cone(struct finder *f, uint32_t g)
{
    struct emitter_groups *o = f->groups;
    double sum[3] = {0}, power = 0.0, least = 1.0;
    bool both = false;
    for (uint32_t i = o->first[g]; i < o->first[g + 1]; i++) {
        const struct emitter_shape *s = &f->shapes[f->keys[i].shape];
        for (int k = 0; k < 3; k++) sum[k] += s->power * (double)s->normal[k];
        power += s->power;
        both |= s->both_sides != 0;
    }
    const double length = sqrt(sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2]);
    const double scale = length > 0.0 ? 1.0 / length : 0.0;
    const float axis[3] = {(float)(sum[0] * scale), (float)(sum[1] * scale),
                           (float)(sum[2] * scale)};
    for (uint32_t i = o->first[g]; i < o->first[g + 1]; i++)
        least = fmin(least, dot(axis, f->shapes[f->keys[i].shape].normal));
    if (both || !(length > 1e-3 * power) || least < -1.0) least = -1.0;
    o->sum[g] = power;
    o->power[g] = (float)power;
    o->axis_x[g] = axis[0];
    o->axis_y[g] = axis[1];
    o->axis_z[g] = axis[2];
    o->cosine[g] = (float)fmax(least - 1e-6, -1.0);
    o->sine[g] = least > -1.0 ? sqrtf(fmaxf(1.0f - o->cosine[g] * o->cosine[g], 0.0f)) : 0.0f;
}

/* Bounds a group and computes how much a split of it would gain. */
static void bound(struct finder *f, uint32_t g)
{
    struct emitter_groups *o = f->groups;
    set_sphere(f, g);
    set_cone(f, g);
    const uint32_t first = o->first[g], last = o->first[g + 1] - 1;
    const double apart = f->radius > 0.0 ? (double)o->radius[g] / f->radius : 0.0;
    f->cost[g] =
        (double)o->power[g] * (apart * apart + FACING * (0.5 - 0.5 * (double)o->cosine[g]));
    if (f->keys[first].key == f->keys[last].key) f->cost[g] = 0.0; /* no key tells them apart */
}

/* ---- splits ---- */

/* Returns the first item of a group at which the highest digit that differs in its keys is one. */
static uint32_t find_split(const struct finder *f, uint32_t first, uint32_t end)
{
    const uint64_t differ = f->keys[first].key ^ f->keys[end - 1].key;
    const uint64_t digit = UINT64_C(1) << (63 - __builtin_clzll(differ));
    uint32_t low = first, high = end - 1; /* the digit is zero at low, one at high */
    while (high - low > 1) {
        const uint32_t middle = low + (high - low) / 2;
        if (f->keys[middle].key & digit)
            high = middle;
        else
            low = middle;
    }
    return high;
}

static void split(struct finder *f, uint32_t g)
{
    struct emitter_groups *o = f->groups;
    const uint32_t at = find_split(f, o->first[g], o->first[g + 1]);
    const uint32_t after = o->count - g;
    memmove(&o->first[g + 2], &o->first[g + 1], after * sizeof *o->first);
    o->first[g + 1] = at;
    o->count++;
    for (uint32_t k = o->count - 1; k > g; k--) f->cost[k] = f->cost[k - 1];
}

/* Splits the group that gains most until there are enough. Groups keep the order of keys, so the
 * values of those behind move with them. Bounds are set once, at the end. */
static void split_all(struct finder *f)
{
    struct emitter_groups *o = f->groups;
    bound(f, 0);
    while (o->count < EMITTER_GROUPS) {
        uint32_t dearest = 0;
        for (uint32_t g = 1; g < o->count; g++)
            if (f->cost[g] > f->cost[dearest]) dearest = g;
        if (!(f->cost[dearest] > 0.0)) break;
        split(f, dearest);
        bound(f, dearest);
        bound(f, dearest + 1);
    }
    for (uint32_t g = 0; g < o->count; g++) bound(f, g);
}

int emitter_groups_find(const struct emitter_shape *shapes, uint32_t count, uint32_t *order,
                        struct emitter_groups *out)
{
    struct finder f = {.shapes = shapes, .groups = out};
    f.keys = malloc(count * sizeof *f.keys);
    if (!f.keys) return ERR_MEMORY;
    memset(out, 0, sizeof *out);
    out->count = 1;
    out->first[1] = count;
    sort(&f, count);
    split_all(&f);
    for (uint32_t i = 0; i < count; i++) order[i] = f.keys[i].shape;
    free(f.keys);
    return 0;
}
