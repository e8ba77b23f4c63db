#include "tests/kernel/kernel_field.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

const char *const kernel_names[KERNEL_COUNT] = {
    "unoccluded",   "place_receivers", "shear_receivers", "mark_walks", "project_columns",
    "walk_columns", "project_rows",    "walk_rows",       "blur x",     "blur y",
    "estimate",     "filter_edges",    "sum_slopes"};

#define FIELD_ROWS 7 /* of weights */

void *field_memory(size_t bytes)
{
    void *memory = aligned_alloc(64, (bytes + 127) / 64 * 64);
    if (!memory) abort();
    memset(memory, 0, (bytes + 127) / 64 * 64);
    return memory;
}

float *field_numbers(struct random *r, size_t count, float least, float most)
{
    float *out = field_memory((count + 1) * sizeof *out);
    for (size_t i = 0; i <= count; i++) out[i] = field_between(r, least, most);
    return out;
}

void field_pixels(struct shadow_pixels *p, size_t stride)
{
    float *memory = field_memory(FIELD_PIXEL * stride * sizeof *memory);
    struct shadow_walk *a = &p->walk[0], *b = &p->walk[1];
    float **const floats[FIELD_FLOATS] = {
        &p->point[0],       &p->point[1], &p->point[2], &p->normal[0], &p->normal[1], &p->normal[2],
        &p->u[0],           &p->u[1],     &p->eta,      &p->spread,    &p->distance,  &p->plane_min,
        &p->distance_most2, &p->gamma[0], &p->gamma[1], &a->step[0],   &a->step[1],   &a->falloff,
        &b->step[0],        &b->step[1],  &b->falloff,  &p->width_px};
    int32_t **const whole[FIELD_PIXEL - FIELD_FLOATS] = {&p->slot,       &p->phase, &p->weights[0],
                                                         &p->weights[1], &a->reach, &b->reach};
    for (int k = 0; k < FIELD_FLOATS; k++, memory += stride) *floats[k] = memory;
    for (int k = 0; k < FIELD_PIXEL - FIELD_FLOATS; k++, memory += stride)
        *whole[k] = (int32_t *)(void *)memory;
}

/* What a pixel shows. `wild`: as odd as it gets; else a bent floor in penumbra, as pictures have.
 */
static void field_source(struct random *r, bool wild, uint32_t phases, int32_t x, int32_t y,
                         struct shadow_pixels *p, size_t i)
{
    const float bend = wild ? 0.5f : 0.02f;
    float n[3] = {field_between(r, -bend, bend), field_between(r, -bend, bend), 1.0f};
    const float length = sqrtf(n[0] * n[0] + n[1] * n[1] + 1.0f);
    const bool lit = !wild || !field_once_in(r, 9);
    p->point[0][i] = 0.01f * (float)x;
    p->point[1][i] = 0.01f * (float)y;
    p->point[2][i] = field_between(r, 0.0f, wild ? 0.03f : 0.001f);
    if (wild && field_once_in(r, 40)) p->point[2][i] += 1.0f;
    for (int k = 0; k < 3; k++) p->normal[k][i] = lit ? n[k] / length : 0.0f;
    for (int k = 0; k < 2; k++)
        p->u[k][i] = 0.2f * p->point[k][i] + (wild ? field_between(r, 0.0f, 0.01f) : 0.0f);
    const bool wedge = !wild || !field_once_in(r, 5);
    p->eta[i] = wedge ? field_between(r, 1.0f, wild ? 9.0f : 1.2f) : 0.0f;
    p->spread[i] = wedge ? field_between(r, 0.0f, wild ? 2.0f : 0.2f) : SHADOW_NO_SPREAD;
    p->phase[i] = (int32_t)(random_bits(r) % phases);
}

static void field_walk(struct random *r, bool wild, int axis, const struct shadow_walk *w, size_t i)
{
    const float other = wild ? field_between(r, -1.0f, 1.0f) : 0.2f;
    const bool turned = wild ? field_once_in(r, 2) : axis == 1;
    w->step[turned ? 1 : 0][i] = wild && field_once_in(r, 2) ? -1.0f : 1.0f;
    w->step[turned ? 0 : 1][i] = wild && field_once_in(r, 5) ? 0.0f : other;
    w->reach[i] = wild ? (int32_t)(random_bits(r) % (SHADOW_REACH_PX + 1)) : 12;
    w->falloff[i] = wild && field_once_in(r, 20) ? 1e30f : 300.0f;
    if (w->reach[i] == 0 && wild) w->step[0][i] = w->step[1][i] = 0.0f;
}

/* What it gathers with. */
static void field_target(struct random *r, bool wild, const struct shadow_pixels *p, size_t i)
{
    p->distance[i] = 5.0f;
    p->plane_min[i] = 0.02f;
    p->distance_most2[i] = wild ? field_between(r, 0.0f, 0.06f) : 1.44f;
    for (int k = 0; k < 2; k++) {
        p->gamma[k][i] = field_between(r, -0.95f, 0.95f);
        p->weights[k][i] = (int32_t)(random_bits(r) % FIELD_ROWS);
        field_walk(r, wild, k, &p->walk[k], i);
    }
}

static void field_tables(struct random *r, struct kernel_field *out)
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

/* What the blur reads beside pixels, at random. In the left half all pixels are seen alike. */
static void field_planes(struct random *r, bool wild, struct kernel_field *out)
{
    const struct shadow_field *f = &out->field;
    const size_t area = (size_t)f->width * (size_t)f->height, stride = area + SHADOW_PLANE_PAD;
    for (int k = 0; k < FIELD_PLANES; k++)
        out->planes[k] = field_memory(stride * sizeof *out->planes[k]);
    out->reach = field_memory(stride * sizeof *out->reach);
    for (size_t i = 0; i < area; i++) {
        const bool left = i % (size_t)f->width < (size_t)f->width / 2;
        out->planes[0][i] = wild && left ? 1.0f : random_unit(r);
        out->planes[1][i] = wild ? field_between(r, 0.0f, 0.04f) : 1.0f;
        out->planes[2][i] = wild ? field_between(r, 20.0f, 800.0f) : 150.0f;
        if (wild && field_once_in(r, 30)) out->planes[2][i] = 1e30f;
        if (out->shown.slot[i] < 0) continue; /* no room to walk */
        out->reach[i] = wild ? (int32_t)(random_bits(r) % (SHADOW_REACH_PX + 1)) : 12;
        if (wild && field_once_in(r, 3)) out->reach[i] = 0;
    }
}

/* Strata of runs of pixels: all seen, none, or any. */
static void field_bits(struct random *r, bool wild, struct kernel_field *out)
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
static void field_degenerate(struct random *r, struct kernel_field *out)
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

/* Two chunks of unoccluded_lanes.h under the light, which is above the horizon of all: their own
 * path, which chunks with others among them do not take. */
static void field_facing(struct random *r, struct kernel_field *out)
{
    const size_t area = (size_t)out->field.width * (size_t)out->field.height;
    for (size_t i = 65; i < 129 && i <= area; i++) {
        const float x = field_between(r, -0.3f, 0.3f), y = field_between(r, -0.3f, 0.3f);
        const float length = sqrtf(x * x + y * y + 1.0f);
        const float normal[3] = {x / length, y / length, 1.0f / length};
        for (int k = 0; k < 3; k++) {
            out->normal[k][i] = normal[k];
            out->point[k][i] = field_between(r, -1.0f, 1.0f);
        }
    }
}

/* What is written by kernels that write receivers, and 1/slope from 0 on. */
static void field_copies(struct kernel_field *out)
{
    const size_t area = (size_t)out->field.width * (size_t)out->field.height;
    const size_t stride = area + SHADOW_PLANE_PAD;
    field_pixels(&out->placed, stride);
    field_pixels(&out->sheared, stride);
    memcpy(out->sheared.point[0], out->shown.point[0],
           FIELD_PIXEL * stride * sizeof *out->shown.point[0]);
    out->most = field_memory(area * sizeof *out->most);
    out->least = field_memory(area * sizeof *out->least);
    for (size_t i = 0; i < area; i++) {
        out->least[i] = fminf(fabsf(out->a[i]), out->b[i]);
        out->most[i] = fmaxf(fabsf(out->a[i]), out->b[i]);
    }
}

static void field_inputs(struct random *r, bool wild, struct kernel_field *out)
{
    const struct shadow_field *f = &out->field;
    const size_t area = (size_t)f->width * (size_t)f->height, l = f->strata;
    for (int k = 0; k < 2; k++) out->jitter[k] = field_numbers(r, area, 0.0f, 0.999f);
    out->cells = field_numbers(r, out->count * (size_t)f->scale * 4, 0.0f, 3.0f);
    out->a = field_numbers(r, area + SHADOW_PLANE_PAD, -1.0f, 3.0f);
    out->b = field_numbers(r, area + SHADOW_PLANE_PAD, 0.0f, 3.0f);
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
    field_facing(r, out);
    field_copies(out);
}

/* A light above the field and a camera that has all of it in front. */
static void field_light(uint64_t seed, struct kernel_field *out)
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

void field_init(struct kernel_field *out, uint32_t l, int32_t width, int32_t height, uint64_t seed,
                bool wild)
{
    struct random r = {seed};
    const int32_t margin = SHADOW_REACH_PX;
    *out = (struct kernel_field){0};
    struct shadow_field *f = &out->field;
    f->width = width + 2 * margin;
    f->height = height + 2 * margin;
    f->strata = l;
    f->scale = coverage_scale(l);
    f->window = (f->scale + 7) / 8 * 8;
    f->lanes = (l + 4) / 4 * 4;
    f->phases = shadow_phases(l, f->scale);
    for (int i = 0; i < 2; i++) {
        f->nodes_per_length[i] = 0.5f * (float)f->scale;
        f->refusal[i] = 0.5f;
    }
    const size_t area = (size_t)f->width * (size_t)f->height;
    field_pixels(&out->shown, area + SHADOW_PLANE_PAD);
    out->pixels = field_memory((area + 1) * sizeof *out->pixels);
    for (int32_t i = 0; i < (int32_t)area; i++) {
        const int32_t x = i % f->width, y = i / f->width;
        const bool room = x >= margin && y >= margin && x < f->width - margin &&
                          y < f->height - margin; /* nothing is shown beyond */
        out->shown.slot[i] = -1;
        if (!room) continue;
        field_source(&r, wild, f->phases, x, y, &out->shown, (size_t)i);
        field_target(&r, wild, &out->shown, (size_t)i);
        if (!(out->shown.normal[2][i] > 0.0f)) continue;
        out->shown.slot[i] = (int32_t)out->slots++;
        out->pixels[1 + out->count++] = (uint32_t)i;
    }
    field_light(seed, out);
    field_tables(&r, out);
    field_inputs(&r, wild, out);
}

void field_fini(struct kernel_field *k)
{
    void *const all[] = {k->shown.point[0],
                         k->placed.point[0],
                         k->sheared.point[0],
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
}
