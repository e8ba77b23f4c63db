#pragma once
/* Random fields for the kernels of the shadow filters, made to meet every branch: surfaces that end
 * and bend, pixels that show nothing, have no wedge, walk nowhere, refuse or are refused. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "proto/plan.h"
#include "server/reconstruct/edge.h"
#include "server/reconstruct/shadow_kernels.h"
#include "server/reconstruct/strata.h"
#include "tests/random.h"

enum kernel {
    KERNEL_UNOCCLUDED,
    KERNEL_PLACE_RECEIVERS,
    KERNEL_SHEAR_RECEIVERS,
    KERNEL_LINE_UP,
    KERNEL_MARK_WALKS,
    KERNEL_PROJECT_COLUMNS,
    KERNEL_WALK_COLUMNS,
    KERNEL_PROJECT_ROWS,
    KERNEL_WALK_ROWS,
    KERNEL_BLUR_X,
    KERNEL_BLUR_Y,
    KERNEL_ESTIMATE,
    KERNEL_FILTER_EDGES,
    KERNEL_SUM_SLOPES,
    KERNEL_COUNT,
};

static const char *const kernel_names[KERNEL_COUNT] = {
    "unoccluded",      "place_receivers", "shear_receivers", "line_up",   "mark_walks",
    "project_columns", "walk_columns",    "project_rows",    "walk_rows", "blur x",
    "blur y",          "estimate",        "filter_edges",    "sum_slopes"};

#define FIELD_PLANES 11 /* of struct shadow_blur but its reach */
#define FIELD_ROWS   7  /* of weights */

struct kernel_field {
    struct shadow_field field;                        /* everything in it owned */
    struct shadow_source *sources, *placed, *sheared; /* the latter are written */
    struct shadow_target *targets, *placed_targets, *sheared_targets;
    float *weights;
    struct plan plan;
    struct receiver_light light;
    float *planes[FIELD_PLANES];
    float *lined[SHADOW_NUMBERS]; /* the field's planes */
    int32_t *reach;
    uint32_t *bits;
    uint32_t *pixels, count; /* those that have room to walk and are lit */
    uint32_t slots;
    /* One number too long: input starts off any alignment. */
    float *jitter[2], *cells, *a, *b, *most, *least, *sigma_px, *depth, *point[3], *normal[3];
    uint32_t *seen;
};

static inline float field_between(struct random *r, float least, float most)
{
    return least + (most - least) * random_unit(r);
}

static inline bool field_once_in(struct random *r, int n)
{
    return random_unit(r) * (float)n < 1.0f;
}

static inline void *field_memory(size_t bytes)
{
    void *memory = aligned_alloc(64, (bytes + 127) / 64 * 64);
    if (!memory) abort();
    memset(memory, 0, (bytes + 127) / 64 * 64);
    return memory;
}

static inline float *field_numbers(struct random *r, size_t count, float least, float most)
{
    float *out = field_memory((count + 1) * sizeof *out);
    for (size_t i = 0; i <= count; i++) out[i] = field_between(r, least, most);
    return out;
}

/* `wild`: as odd as it gets; else a bent floor in penumbra, as pictures have. */
static inline void field_source(struct random *r, bool wild, uint32_t phases, int32_t x, int32_t y,
                                struct shadow_source *s)
{
    const float bend = wild ? 0.5f : 0.02f;
    float n[3] = {field_between(r, -bend, bend), field_between(r, -bend, bend), 1.0f};
    const float length = sqrtf(n[0] * n[0] + n[1] * n[1] + 1.0f);
    const bool lit = !wild || !field_once_in(r, 9);
    s->point[0] = 0.01f * (float)x;
    s->point[1] = 0.01f * (float)y;
    s->point[2] = field_between(r, 0.0f, wild ? 0.03f : 0.001f);
    if (wild && field_once_in(r, 40)) s->point[2] += 1.0f;
    for (int k = 0; k < 3; k++) s->normal[k] = lit ? n[k] / length : 0.0f;
    for (int k = 0; k < 2; k++)
        s->u[k] = 0.2f * s->point[k] + (wild ? field_between(r, 0.0f, 0.01f) : 0.0f);
    const bool wedge = !wild || !field_once_in(r, 5);
    s->eta = wedge ? field_between(r, 1.0f, wild ? 9.0f : 1.2f) : 0.0f;
    s->spread = wedge ? field_between(r, 0.0f, wild ? 2.0f : 0.2f) : SHADOW_NO_SPREAD;
    s->phase = (int32_t)(random_bits(r) % phases);
}

static inline void field_walk(struct random *r, bool wild, int axis, struct shadow_walk *w)
{
    const float other = wild ? field_between(r, -1.0f, 1.0f) : 0.2f;
    const bool turned = wild ? field_once_in(r, 2) : axis == 1;
    w->step[turned ? 1 : 0] = wild && field_once_in(r, 2) ? -1.0f : 1.0f;
    w->step[turned ? 0 : 1] = wild && field_once_in(r, 5) ? 0.0f : other;
    w->reach = wild ? (int32_t)(random_bits(r) % (SHADOW_REACH_PX + 1)) : 12;
    w->falloff = wild && field_once_in(r, 20) ? 1e30f : 300.0f;
    if (w->reach == 0 && wild) w->step[0] = w->step[1] = 0.0f;
}

static inline void field_target(struct random *r, bool wild, struct shadow_target *t)
{
    t->distance = 5.0f;
    t->plane_least = 0.02f;
    t->distance_most2 = wild ? field_between(r, 0.0f, 0.06f) : 1.44f;
    for (int i = 0; i < 2; i++) {
        t->gamma[i] = field_between(r, -0.95f, 0.95f);
        t->weights[i] = (int32_t)(random_bits(r) % FIELD_ROWS);
        field_walk(r, wild, i, &t->walk[i]);
    }
}

static inline void field_tables(struct random *r, struct kernel_field *out)
{
    struct shadow_field *f = &out->field;
    const size_t nodes = shadow_nodes(f);
    out->weights = field_memory(sizeof(float) * FIELD_ROWS * (SHADOW_PHASES + 1) * f->window);
    for (size_t i = 0; i < FIELD_ROWS * (SHADOW_PHASES + 1); i++) {
        for (size_t k = 0; k < f->scale; k++)
            out->weights[i * f->window + k] = field_between(r, 0.8f, 2.0f);
    }
    f->weights = out->weights;
    f->columns = field_memory(out->slots * nodes * f->lanes * sizeof(float));
    f->rows = field_memory(out->slots * nodes * 2 * sizeof(float));
    for (size_t i = 0; i < out->slots * nodes; i++) {
        const bool last = i % nodes == nodes - 1;
        for (uint32_t b = 0; b <= f->strata; b++)
            f->columns[i * f->lanes + b] = last ? 0.0f : random_unit(r);
        for (uint32_t b = 0; b < 2; b++) f->rows[2 * i + b] = last ? 0.0f : random_unit(r);
    }
}

/* What the kernels that read planes do: the field's points and normals, other numbers at random.
 * In the left half all pixels are seen alike. */
static inline void field_planes(struct random *r, bool wild, struct kernel_field *out)
{
    const struct shadow_field *f = &out->field;
    const size_t area = (size_t)f->width * (size_t)f->height, stride = area + SHADOW_PLANE_PAD;
    for (int k = 0; k < FIELD_PLANES; k++)
        out->planes[k] = field_memory(stride * sizeof *out->planes[k]);
    out->reach = field_memory(stride * sizeof *out->reach);
    for (size_t i = 0; i < area; i++) {
        const bool left = i % (size_t)f->width < (size_t)f->width / 2;
        for (int k = 0; k < 3; k++) {
            out->planes[k][i] = out->sources[i].point[k];
            out->planes[3 + k][i] = out->sources[i].normal[k];
        }
        out->planes[6][i] = out->targets[i].plane_least;
        out->planes[7][i] = out->targets[i].distance_most2;
        out->planes[8][i] = wild && left ? 1.0f : random_unit(r);
        out->planes[9][i] = wild ? field_between(r, 0.0f, 0.02f) : 1.0f;
        out->planes[10][i] = wild && field_once_in(r, 30) ? 1e30f : 150.0f;
        if (out->sources[i].slot < 0) continue; /* no room to walk */
        out->reach[i] = wild ? (int32_t)(random_bits(r) % (SHADOW_REACH_PX + 1)) : 12;
        if (wild && field_once_in(r, 3)) out->reach[i] = 0;
    }
}

/* Strata of runs of pixels: all seen, none, or any. */
static inline void field_bits(struct random *r, bool wild, struct kernel_field *out)
{
    const size_t area = (size_t)out->field.width * (size_t)out->field.height;
    out->bits = field_memory((area + 1) * STRATA_WORDS * sizeof *out->bits);
    for (size_t i = 0; i < (area + 1) * STRATA_WORDS; i++) {
        const uint64_t run = wild ? i / 50 * UINT64_C(0x9e3779b97f4a7c15) >> 62 : 2;
        const uint32_t any = (uint32_t)random_bits(r);
        out->bits[i] = run == 0 ? 0 : run == 1 ? 0xffffffffu : any;
    }
}

/* Receivers on the light, in its plane, behind it, far off; slopes of nothing and of all. */
static inline void field_degenerate(struct random *r, struct kernel_field *out)
{
    const size_t area = (size_t)out->field.width * (size_t)out->field.height;
    const float *centre = out->light.rectangle.centre;
    for (size_t i = 0; i <= area; i++) {
        const uint64_t kind = random_bits(r) % 24;
        for (int k = 0; k < 3; k++) {
            if (kind == 0) out->normal[k][i] = 0.0f;
            if (kind == 1) out->point[k][i] = centre[k];
            if (kind == 2) out->point[k][i] *= 1e16f;
            if (kind == 3) out->point[k][i] *= 1e-20f;
            if (kind == 4 && k == 2) out->point[k][i] = centre[k];
            if (kind == 5) out->point[k][i] = centre[k] + 1e-6f * out->point[k][i];
        }
        if (kind == 6) out->depth[i] = 0.0f;
        if (kind == 7) out->depth[i] = 1e16f;
        if (kind == 8) out->a[i] = out->b[i] = 0.0f;
        if (kind == 9) out->a[i] = out->b[i] = 1e4f;
        if (kind == 10) out->a[i] = 1e37f;
        if (kind == 11) out->sigma_px[i] = 0.0f;
    }
}

/* What is written by kernels that write receivers, and 1/slope from 0 on. */
static inline void field_copies(struct kernel_field *out)
{
    const size_t area = (size_t)out->field.width * (size_t)out->field.height;
    out->placed = field_memory(area * sizeof *out->placed);
    out->sheared = field_memory(area * sizeof *out->sheared);
    out->placed_targets = field_memory(area * sizeof *out->placed_targets);
    out->sheared_targets = field_memory(area * sizeof *out->sheared_targets);
    memcpy(out->sheared, out->sources, area * sizeof *out->sheared);
    memcpy(out->sheared_targets, out->targets, area * sizeof *out->sheared_targets);
    out->most = field_memory(area * sizeof *out->most);
    out->least = field_memory(area * sizeof *out->least);
    for (size_t i = 0; i < area; i++) {
        out->least[i] = fminf(fabsf(out->a[i]), out->b[i]);
        out->most[i] = fmaxf(fabsf(out->a[i]), out->b[i]);
    }
}

static inline void field_inputs(struct random *r, bool wild, struct kernel_field *out)
{
    const struct shadow_field *f = &out->field;
    const size_t area = (size_t)f->width * (size_t)f->height, l = f->strata;
    for (int k = 0; k < 2; k++) out->jitter[k] = field_numbers(r, area, 0.0f, 0.999f);
    out->cells = field_numbers(r, out->count * (size_t)f->scale * 4, 0.0f, 3.0f);
    out->a = field_numbers(r, area, -1.0f, 3.0f);
    out->b = field_numbers(r, area, 0.0f, 3.0f);
    out->sigma_px = field_numbers(r, area, 0.2f, 1.5f);
    out->depth = field_numbers(r, area, 0.5f, 9.0f);
    for (int k = 0; k < 3; k++) {
        out->point[k] = field_numbers(r, area, -3.0f, 3.0f);
        out->normal[k] = field_numbers(r, area, -0.57f, 0.57f);
    }
    out->seen = field_memory((area * l + 1) * sizeof *out->seen);
    for (size_t i = 0; i <= area * l; i++)
        out->seen[i] = ((uint32_t)random_bits(r) & ((1u << l) - 1)) | 1u << l;
    field_planes(r, wild, out);
    field_bits(r, wild, out);
    if (wild) field_degenerate(r, out);
    field_copies(out);
}

/* A light above the field and a camera that has all of it in front. */
static inline void field_light(uint64_t seed, struct kernel_field *out)
{
    struct plan_camera *c = &out->plan.camera;
    *c = (struct plan_camera){.type = seed & 2u ? CAMERA_ORTHOGRAPHIC : CAMERA_PERSPECTIVE,
                              .right = {0.8f, 0, -0.6f},
                              .up = {0, 1, 0},
                              .forward = {0.6f, 0, 0.8f},
                              .half_width = 0.5f,
                              .half_height = 0.4f};
    out->plan.width_px = out->field.width;
    out->plan.height_px = out->field.height;
    out->plan.mu = 1.0f;
    out->light = (struct receiver_light){
        .plan = &out->plan,
        .strata = out->field.strata,
        .rectangle = {.centre = {0, 0, 3},
                      .axis = {{1, 0, 0}, {0, 1, 0}},
                      .half = {0.5f, 1.0f},
                      .normal = {0, 0, -1},
                      .area = 2,
                      .profile = seed & 1u ? PROFILE_GAUSSIAN : PROFILE_UNIFORM},
        .sigma_y = {0.3f, 0.6f}};
    surface_view_init(&out->light.view, &out->plan);
}

/* A field of width x height pixels beyond the margin. */
static inline void field_init(struct kernel_field *out, uint32_t l, int32_t width, int32_t height,
                              uint64_t seed, bool wild)
{
    struct random r = {seed};
    const int32_t margin = SHADOW_REACH_PX;
    *out = (struct kernel_field){0};
    struct shadow_field *f = &out->field;
    f->width = width + 2 * margin;
    f->height = height + 2 * margin;
    f->strata = l;
    f->scale = l > 8 ? l : 8;
    f->window = (f->scale + 7) / 8 * 8;
    f->lanes = (l + 4) / 4 * 4;
    f->phases = shadow_phases(l, f->scale);
    for (int i = 0; i < 2; i++) {
        f->nodes_per_length[i] = 0.5f * (float)f->scale;
        f->refusal[i] = 0.5f;
    }
    const size_t area = (size_t)f->width * (size_t)f->height;
    f->sources = out->sources = field_memory(area * sizeof *out->sources);
    f->targets = out->targets = field_memory(area * sizeof *out->targets);
    out->pixels = field_memory((area + 1) * sizeof *out->pixels);
    for (int32_t i = 0; i < (int32_t)area; i++) {
        const int32_t x = i % f->width, y = i / f->width;
        struct shadow_source *s = &out->sources[i];
        const bool room = x >= margin && y >= margin && x < f->width - margin &&
                          y < f->height - margin; /* nothing is shown beyond */
        s->slot = -1;
        if (!room) continue;
        field_source(&r, wild, f->phases, x, y, s);
        if (s->normal[2] > 0.0f) s->slot = (int32_t)out->slots++;
        field_target(&r, wild, &out->targets[i]);
        if (s->slot >= 0) out->pixels[1 + out->count++] = (uint32_t)i;
    }
    for (int k = 0; k < SHADOW_NUMBERS; k++)
        f->planes[k] = out->lined[k] = field_memory(area * sizeof *out->lined[k]);
    shadow_kernels_c.line_up(out->sources, area, out->lined);
    field_light(seed, out);
    field_tables(&r, out);
    field_inputs(&r, wild, out);
}

static inline void field_fini(struct kernel_field *k)
{
    void *const all[] = {k->sources,
                         k->targets,
                         k->weights,
                         k->field.columns,
                         k->field.rows,
                         k->pixels,
                         k->jitter[0],
                         k->jitter[1],
                         k->cells,
                         k->a,
                         k->b,
                         k->sigma_px,
                         k->depth,
                         k->seen,
                         k->bits,
                         k->placed,
                         k->sheared,
                         k->placed_targets,
                         k->sheared_targets,
                         k->most,
                         k->least,
                         k->reach,
                         k->point[0],
                         k->point[1],
                         k->point[2],
                         k->normal[0],
                         k->normal[1],
                         k->normal[2]};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) free(all[i]);
    for (int i = 0; i < FIELD_PLANES; i++) free(k->planes[i]);
    for (int i = 0; i < SHADOW_NUMBERS; i++) free(k->lined[i]);
}

#define FIELD_RECEIVER 27 /* numbers of a source and its target */

/* Numbers that `kernel` writes for `count` pixels, or for all slots. */
static inline size_t field_output(const struct kernel_field *k, enum kernel kernel, uint32_t count)
{
    const size_t nodes = shadow_nodes(&k->field);
    switch (kernel) {
    case KERNEL_MARK_WALKS:
        return (size_t)k->field.width * (size_t)k->field.height;
    case KERNEL_PROJECT_COLUMNS:
        return k->slots * nodes * k->field.lanes;
    case KERNEL_PROJECT_ROWS:
        return k->slots * nodes * 2;
    case KERNEL_WALK_COLUMNS:
        return (size_t)count * 4 * k->field.scale;
    case KERNEL_WALK_ROWS:
        return (size_t)count * 2;
    case KERNEL_SUM_SLOPES:
        return (size_t)count * 3;
    case KERNEL_LINE_UP:
        return (size_t)count * SHADOW_NUMBERS;
    case KERNEL_PLACE_RECEIVERS:
    case KERNEL_SHEAR_RECEIVERS:
        return (size_t)count * FIELD_RECEIVER;
    default:
        return count;
    }
}

/* Marks of both axes, as numbers. */
static inline void field_mark(const struct shadow_field *f, const struct shadow_kernels *kernels,
                              const uint32_t *pixels, uint32_t count, float *out)
{
    const size_t area = (size_t)f->width * (size_t)f->height;
    uint8_t *marks = field_memory(2 * area);
    for (uint32_t axis = 0; axis < 2; axis++)
        kernels->mark_walks(f, axis, pixels, count, marks + axis * area);
    for (size_t i = 0; i < area; i++) out[i] = (float)(marks[i] + 2 * marks[area + i]);
    free(marks);
}

static inline float *field_print(const struct shadow_source *s, const struct shadow_target *t,
                                 float *out)
{
    for (int k = 0; k < 3; k++) *out++ = s->point[k];
    for (int k = 0; k < 3; k++) *out++ = s->normal[k];
    for (int k = 0; k < 2; k++) *out++ = s->u[k];
    *out++ = s->eta;
    *out++ = s->spread;
    *out++ = (float)s->slot;
    *out++ = (float)s->phase;
    *out++ = t->distance;
    *out++ = t->plane_least;
    *out++ = t->distance_most2;
    for (int k = 0; k < 2; k++) {
        *out++ = t->gamma[k];
        *out++ = (float)t->weights[k];
        *out++ = t->walk[k].step[0];
        *out++ = t->walk[k].step[1];
        *out++ = t->walk[k].falloff;
        *out++ = (float)t->walk[k].reach;
    }
    return out;
}

/* Receivers of the inputs, from the second number on. */
static inline void field_place(const struct kernel_field *k, const struct shadow_kernels *kernels,
                               uint32_t count, float *out)
{
    const float *const point[3] = {k->point[0] + 1, k->point[1] + 1, k->point[2] + 1};
    const float *const normal[3] = {k->normal[0] + 1, k->normal[1] + 1, k->normal[2] + 1};
    kernels->place_receivers(&k->light, count, k->depth + 1, point, normal, k->placed,
                             k->placed_targets);
    for (uint32_t i = 0; i < count; i++)
        out = field_print(&k->placed[i], &k->placed_targets[i], out);
}

/* Those of the field, with 1/slope from 0 on. */
static inline void field_shear(const struct kernel_field *k, const struct shadow_kernels *kernels,
                               const uint32_t *pixels, uint32_t count, float *out)
{
    const struct wedge_shear shear = {&k->light, 1.0f, 3.5f, 0.6f};
    kernels->shear_receivers(&shear, pixels, count, k->most, k->least, k->sheared,
                             k->sheared_targets);
    for (uint32_t i = 0; i < count; i++)
        out = field_print(&k->sheared[pixels[i]], &k->sheared_targets[pixels[i]], out);
}

/* Sources from the first pixel on, as many as there are pixels; what is whole as numbers. */
static inline void field_line_up(const struct kernel_field *k, const struct shadow_kernels *kernels,
                                 const uint32_t *pixels, uint32_t count, float *out)
{
    float *planes[SHADOW_NUMBERS];
    for (size_t i = 0; i < SHADOW_NUMBERS; i++) planes[i] = out + i * count;
    if (count > 0) kernels->line_up(k->sources + pixels[0], count, planes);
    for (size_t i = SHADOW_SLOT * (size_t)count; i < SHADOW_NUMBERS * (size_t)count; i++) {
        int32_t whole;
        memcpy(&whole, out + i, sizeof whole);
        out[i] = (float)whole;
    }
}

/* Row by row, from number `first` of the listed pixels on: one run to the end of its row at most.
 */
static inline void field_blur(const struct kernel_field *k, const struct shadow_kernels *kernels,
                              int32_t step, const uint32_t *pixels, uint32_t count, float *out)
{
    float *const *p = k->planes;
    const struct shadow_blur planes = {.point = {p[0], p[1], p[2]},
                                       .normal = {p[3], p[4], p[5]},
                                       .plane_least = p[6],
                                       .distance_most2 = p[7],
                                       .seen = p[8],
                                       .refusal = p[9],
                                       .falloff = p[10],
                                       .reach = k->reach};
    const uint32_t width = (uint32_t)k->field.width;
    for (uint32_t i = 0, run; i < count; i += run) {
        for (run = 1; i + run < count && pixels[i + run] / width == pixels[i] / width; run++) {
        }
        const uint32_t span = pixels[i + run - 1] - pixels[i] + 1;
        float *row = field_memory((span + 1) * sizeof *row);
        kernels->blur(&planes, step, pixels[i], span, row);
        for (uint32_t j = 0; j < run; j++) out[i + j] = row[pixels[i + j] - pixels[i]];
        free(row);
    }
}

static inline void field_edges(const struct kernel_field *k, const struct shadow_kernels *kernels,
                               const uint32_t *pixels, uint32_t count, float *out)
{
    float *const *p = k->planes;
    const struct edge_field edges = {.light = &k->light,
                                     .width = k->field.width,
                                     .scale = 1.0f,
                                     .sources = k->sources,
                                     .targets = k->targets,
                                     .point = {p[0], p[1], p[2]},
                                     .normal = {p[3], p[4], p[5]},
                                     .seen = p[8],
                                     .jitter = {k->jitter[0], k->jitter[1]},
                                     .bits = k->bits,
                                     .stride = (size_t)k->field.width * (size_t)k->field.height};
    kernels->filter_edges(&edges, pixels, k->sigma_px + 1, count, out);
}

/* The kernel over `count` pixels from number `first` on, into `out`. */
static inline void field_run(const struct kernel_field *k, const struct shadow_kernels *kernels,
                             enum kernel kernel, uint32_t first, uint32_t count, float *out)
{
    struct shadow_field f = k->field;
    const uint32_t *pixels = k->pixels + 1 + first;
    const float *const point[3] = {k->point[0] + 1, k->point[1] + 1, k->point[2] + 1};
    const float *const normal[3] = {k->normal[0] + 1, k->normal[1] + 1, k->normal[2] + 1};
    const float *const jitter[2] = {k->jitter[0] + 1, k->jitter[1] + 1};
    switch (kernel) {
    case KERNEL_UNOCCLUDED:
        kernels->unoccluded(&k->light.rectangle, count, point, normal, out);
        break;
    case KERNEL_PLACE_RECEIVERS:
        field_place(k, kernels, count, out);
        break;
    case KERNEL_SHEAR_RECEIVERS:
        field_shear(k, kernels, pixels, count, out);
        break;
    case KERNEL_LINE_UP:
        field_line_up(k, kernels, pixels, count, out);
        break;
    case KERNEL_MARK_WALKS:
        field_mark(&f, kernels, pixels, count, out);
        break;
    case KERNEL_PROJECT_COLUMNS:
        f.columns = out;
        kernels->project_columns(&f, pixels, count, k->jitter[0] + 1, k->seen + 1);
        break;
    case KERNEL_WALK_COLUMNS:
        kernels->walk_columns(&f, pixels, count, out);
        break;
    case KERNEL_PROJECT_ROWS:
        f.rows = out;
        kernels->project_rows(&f, pixels, count, k->cells + 1);
        break;
    case KERNEL_WALK_ROWS:
        kernels->walk_rows(&f, pixels, count, out);
        break;
    case KERNEL_BLUR_X:
        field_blur(k, kernels, 1, pixels, count, out);
        break;
    case KERNEL_BLUR_Y:
        field_blur(k, kernels, f.width, pixels, count, out);
        break;
    case KERNEL_ESTIMATE:
        kernels->estimate(&k->light.rectangle, f.strata, count, point, normal, jitter, k->bits + 1,
                          (size_t)f.width * (size_t)f.height, out);
        break;
    case KERNEL_FILTER_EDGES:
        field_edges(k, kernels, pixels, count, out);
        break;
    default:
        kernels->sum_slopes(&f, pixels, count, k->a, k->b, out);
        break;
    }
}

/* Greatest difference from the reference, over the greatest number; infinite where bits differ in
 * what is not finite. */
static inline float field_difference(const float *a, const float *b, size_t count)
{
    float most = 0.0f, size = 1e-30f;
    for (size_t i = 0; i < count; i++) {
        if (memcmp(&a[i], &b[i], sizeof a[i]) == 0 && isfinite(a[i])) {
            size = fmaxf(size, fabsf(a[i]));
            continue;
        }
        if (!isfinite(a[i]) || !isfinite(b[i])) return INFINITY;
        most = fmaxf(most, fmaxf(fabsf(a[i] - b[i]), 1e-37f)); /* -0 is not 0 */
    }
    return most / size;
}

/* The same of one kernel over `count` pixels from `first` on. */
static inline float field_compare(const struct kernel_field *k, const struct shadow_kernels *tested,
                                  enum kernel kernel, uint32_t first, uint32_t count)
{
    const size_t size = field_output(k, kernel, count);
    const bool aligned = kernel == KERNEL_PROJECT_COLUMNS || kernel == KERNEL_PROJECT_ROWS;
    float *a = field_memory((size + 1) * sizeof *a), *b = field_memory((size + 1) * sizeof *b);
    const size_t start = aligned ? 0 : 1;
    field_run(k, &shadow_kernels_c, kernel, first, count, a + start);
    field_run(k, tested, kernel, first, count, b + start);
    const float difference = field_difference(a, b, size + start);
    free(a);
    free(b);
    return difference;
}
