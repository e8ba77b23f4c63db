#include "worker/scene/emitter_groups.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

/* Splits are found in so many shapes of a range, which are spread over it. */
#define LOOKED_AT 256u

/* The weight of normals beside places: normals in all directions count as half of the whole extent
 * does. */
#define FACING 1.0

/* Shapes are told apart by place and normal, six coordinates, at the edges of equal bins. */
enum { COORDINATES = 6, BINS = 16 };

struct split {
    double cost; /* of both sides; INFINITY: there is none */
    int coordinate;
    double low, scale; /* of the bins */
    int bin;           /* the first of the other side */
};

struct finder {
    struct emitter_shape *shapes;
    uint32_t *order;
    uint32_t *starts; /* of groups, and their end */
    uint32_t count;
    double whole;                    /* 1 over the squared extent of all; 0: they have none */
    double cost[EMITTER_GROUPS_MAX]; /* 0: cannot be split */
};

static double dot(const float a[3], const float b[3])
{
    return (double)a[0] * (double)b[0] + (double)a[1] * (double)b[1] + (double)a[2] * (double)b[2];
}

/* ---- cost ---- */

struct box {
    float low[3], high[3];
};

static const struct box empty = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};

static void box_add(struct box *b, const float p[3])
{
    for (int k = 0; k < 3; k++) {
        b->low[k] = p[k] < b->low[k] ? p[k] : b->low[k];
        b->high[k] = p[k] > b->high[k] ? p[k] : b->high[k];
    }
}

static struct box box_of(const struct emitter_shape *shapes, uint32_t first, uint32_t end)
{
    struct box b = empty;
    for (uint32_t i = first; i < end; i++)
        for (int c = 0; c < 3; c++) box_add(&b, shapes[i].corner[c]);
    return b;
}

/* What is known of some shapes. */
struct measure {
    struct box box;
    double power, normal[3]; /* sums; of normals by power */
};

static void measure_add(struct measure *m, const struct emitter_shape *s)
{
    for (int c = 0; c < 3; c++) box_add(&m->box, s->corner[c]);
    m->power += s->power;
    for (int k = 0; k < 3 && !s->both_sides; k++) m->normal[k] += s->power * (double)s->normal[k];
}

static void measure_join(struct measure *m, const struct measure *other)
{
    if (!(other->box.low[0] <= other->box.high[0])) return; /* nothing */
    box_add(&m->box, other->box.low);
    box_add(&m->box, other->box.high);
    m->power += other->power;
    for (int k = 0; k < 3; k++) m->normal[k] += other->normal[k];
}

/* Returns the power times how far apart shapes are, of the square that all of them take, and how
 * far their normals spread: 0 where all are alike, 1 where they are in all directions. */
static double cost_of(const struct measure *m, double whole)
{
    double squares = 0.0, alike = 0.0;
    if (!(m->power > 0.0)) return 0.0;
    for (int k = 0; k < 3; k++) {
        const double side = (double)m->box.high[k] - (double)m->box.low[k];
        const double part = m->normal[k] / m->power;
        squares += side * side;
        alike += part * part;
    }
    return m->power * (squares * whole + FACING * (1.0 - fmin(sqrt(alike), 1.0)));
}

/* ---- splits ---- */

static double coordinate_of(const struct emitter_shape *s, int k)
{
    if (k >= 3) return (double)s->normal[k - 3];
    return ((double)s->corner[0][k] + (double)s->corner[1][k] + (double)s->corner[2][k]) / 3.0;
}

static int bin_of(const struct emitter_shape *s, const struct split *at)
{
    const double bin = (coordinate_of(s, at->coordinate) - at->low) * at->scale;
    return bin < BINS - 1 ? (bin > 0.0 ? (int)bin : 0) : BINS - 1;
}

static uint32_t step_of(uint32_t first, uint32_t end)
{
    return (end - first - 1) / LOOKED_AT + 1;
}

/* Sets the bins of a coordinate. Returns false if all shapes are alike in it. */
static bool set_bins(const struct emitter_shape *shapes, uint32_t first, uint32_t end,
                     struct split *at)
{
    double low = INFINITY, high = -INFINITY;
    const uint32_t step = step_of(first, end);
    for (uint32_t i = first; i < end; i += step) {
        const double x = coordinate_of(&shapes[i], at->coordinate);
        low = x < low ? x : low;
        high = x > high ? x : high;
    }
    at->low = low;
    at->scale = BINS / (high - low);
    return high > low && at->scale < INFINITY;
}

/* Tries all edges of a coordinate's bins. */
static void try_edges(const struct emitter_shape *shapes, uint32_t first, uint32_t end,
                      double whole, struct split at, struct split *best)
{
    struct measure bins[BINS], side = {.box = empty};
    double below[BINS];
    const uint32_t step = step_of(first, end);
    for (int k = 0; k < BINS; k++) bins[k] = (struct measure){.box = empty};
    for (uint32_t i = first; i < end; i += step)
        measure_add(&bins[bin_of(&shapes[i], &at)], &shapes[i]);
    for (int k = 0; k < BINS - 1; k++) {
        measure_join(&side, &bins[k]);
        below[k + 1] = cost_of(&side, whole);
    }
    side = (struct measure){.box = empty};
    for (at.bin = BINS - 1; at.bin > 0; at.bin--) {
        measure_join(&side, &bins[at.bin]);
        at.cost = below[at.bin] + cost_of(&side, whole);
        if (at.cost < best->cost) *best = at;
    }
}

static struct split find_split(const struct emitter_shape *shapes, uint32_t first, uint32_t end,
                               double whole)
{
    struct split best = {.cost = INFINITY};
    for (int k = 0; k < COORDINATES; k++) {
        struct split at = {.coordinate = k};
        if (set_bins(shapes, first, end, &at)) try_edges(shapes, first, end, whole, at, &best);
    }
    return best;
}

/* Puts the shapes of the split's lower side first. Returns where the others begin. */
static uint32_t part(struct finder *f, uint32_t first, uint32_t end, const struct split *at)
{
    uint32_t low = first;
    for (uint32_t i = first; i < end; i++) {
        if (bin_of(&f->shapes[i], at) >= at->bin) continue;
        const struct emitter_shape shape = f->shapes[i];
        const uint32_t number = f->order[i];
        f->shapes[i] = f->shapes[low];
        f->order[i] = f->order[low];
        f->shapes[low] = shape;
        f->order[low++] = number;
    }
    return low;
}

static double cost_of_range(const struct emitter_shape *shapes, uint32_t first, uint32_t end,
                            double whole)
{
    struct measure all = {.box = empty};
    const uint32_t step = step_of(first, end);
    for (uint32_t i = first; i < end; i += step) measure_add(&all, &shapes[i]);
    return cost_of(&all, whole) * (double)step;
}

/* Splits a group in two, or notes that it cannot be. */
static void split(struct finder *f, uint32_t g)
{
    const uint32_t first = f->starts[g], end = f->starts[g + 1], after = f->count - g;
    const struct split at = find_split(f->shapes, first, end, f->whole);
    const uint32_t middle = at.cost < INFINITY ? part(f, first, end, &at) : first;
    f->cost[g] = 0.0;
    if (middle == first || middle == end) return;
    memmove(&f->starts[g + 2], &f->starts[g + 1], after * sizeof *f->starts);
    f->starts[g + 1] = middle;
    f->count++;
    for (uint32_t k = f->count - 1; k > g; k--) f->cost[k] = f->cost[k - 1];
    f->cost[g] = cost_of_range(f->shapes, first, middle, f->whole);
    f->cost[g + 1] = cost_of_range(f->shapes, middle, end, f->whole);
}

static double inverse_square(const struct emitter_shape *shapes, uint32_t first, uint32_t end)
{
    const struct box all = box_of(shapes, first, end);
    double squares = 0.0;
    for (int k = 0; k < 3; k++) {
        const double side = (double)all.high[k] - (double)all.low[k];
        squares += side * side;
    }
    return squares > 0.0 ? fmin(1.0 / squares, 1e300) : 0.0;
}

/* Splits the group of the largest cost until there are enough. */
uint32_t emitter_groups_find(struct emitter_shape *shapes, uint32_t *order, uint32_t first,
                             uint32_t end, uint32_t most, uint32_t starts[EMITTER_GROUPS_MAX + 1])
{
    struct finder f = {.shapes = shapes, .order = order, .starts = starts, .count = 1};
    starts[0] = first;
    starts[1] = end;
    f.whole = inverse_square(shapes, first, end);
    f.cost[0] = cost_of_range(shapes, first, end, f.whole);
    while (f.count < most) {
        uint32_t dearest = 0;
        for (uint32_t g = 1; g < f.count; g++)
            if (f.cost[g] > f.cost[dearest]) dearest = g;
        if (!(f.cost[dearest] > 0.0)) break;
        split(&f, dearest);
    }
    return f.count;
}

/* ---- bounds ---- */

static void set_sphere(const struct emitter_shape *shapes, uint32_t first, uint32_t end,
                       struct emitter_groups *o, uint32_t g)
{
    const struct box b = box_of(shapes, first, end);
    const float centre[3] = {0.5f * (b.low[0] + b.high[0]), 0.5f * (b.low[1] + b.high[1]),
                             0.5f * (b.low[2] + b.high[2])};
    double most = 0.0;
    for (uint32_t i = first; i < end; i++)
        for (int c = 0; c < 3; c++) {
            const float *p = shapes[i].corner[c];
            const float way[3] = {p[0] - centre[0], p[1] - centre[1], p[2] - centre[2]};
            most = fmax(most, dot(way, way));
        }
    o->x[g] = centre[0];
    o->y[g] = centre[1];
    o->z[g] = centre[2];
    o->radius[g] = (float)(sqrt(most) * (1.0 + 1e-6));
}

static void set_cone(const struct emitter_shape *shapes, uint32_t first, uint32_t end,
                     struct emitter_groups *o, uint32_t g)
{
    double sum[3] = {0}, power = 0.0, least = 1.0;
    bool both = false;
    for (uint32_t i = first; i < end; i++) {
        const struct emitter_shape *s = &shapes[i];
        for (int k = 0; k < 3; k++) sum[k] += s->power * (double)s->normal[k];
        power += s->power;
        both |= s->both_sides != 0;
    }
    const double length = sqrt(sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2]);
    const double scale = length > 0.0 ? 1.0 / length : 0.0;
    const float axis[3] = {(float)(sum[0] * scale), (float)(sum[1] * scale),
                           (float)(sum[2] * scale)};
    for (uint32_t i = first; i < end; i++) least = fmin(least, dot(axis, shapes[i].normal));
    if (both || !(length > 1e-3 * power) || least < -1.0) least = -1.0;
    o->power[g] = (float)power;
    o->axis_x[g] = axis[0];
    o->axis_y[g] = axis[1];
    o->axis_z[g] = axis[2];
    o->cosine[g] = (float)fmax(least - 1e-6, -1.0);
    o->sine[g] = least > -1.0 ? sqrtf(fmaxf(1.0f - o->cosine[g] * o->cosine[g], 0.0f)) : 0.0f;
}

void emitter_groups_bound(const struct emitter_shape *shapes, uint32_t first, uint32_t end,
                          struct emitter_groups *o, uint32_t g)
{
    set_sphere(shapes, first, end, o, g);
    set_cone(shapes, first, end, o, g);
}

double emitter_groups_power(const struct emitter_shape *shapes, uint32_t first, uint32_t end)
{
    double sum = 0.0;
    for (uint32_t i = first; i < end; i++) sum += shapes[i].power;
    return sum;
}
