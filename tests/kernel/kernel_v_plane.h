#pragma once
/* Random fields for the kernels of the sheared filter of indirect light, made to meet every branch:
 * surfaces that end, bend and belong to several objects, pixels where nothing was measured, hits
 * and misses, bright and dark, walks of any slant and length. */
#include "server/reconstruct/indirect/v_plane_kernels.h"
#include "tests/kernel/kernel_field.h"

enum v_plane_kernel {
    V_PLANE_STRATA,
    V_PLANE_SLOPES,
    V_PLANE_AVERAGE,
    V_PLANE_RECORDS,
    V_PLANE_COLUMNS,
    V_PLANE_ROWS,
    V_PLANE_KERNEL_COUNT
};

static const char *const v_plane_kernel_names[V_PLANE_KERNEL_COUNT] = {
    "v-plane strata",  "v-plane slopes",  "v-plane average",
    "v-plane records", "v-plane columns", "v-plane rows"};

#define V_PLANE_CASE_MARGIN V_PLANE_REACH_PX
#define V_PLANE_CASE_ROWS   (2 * V_PLANE_CASE_MARGIN + 1) /* one of them is asked for */
#define V_PLANE_CASE_OBJECT 3

struct v_plane_case {
    struct v_plane_field field; /* everything in it owned */
    struct v_plane_slopes_field slopes;
    struct v_plane_source *sources;
    struct v_plane_walk *walks[2];
    float *ratios, *records, *nodes, *planes, *jitter[2], *normal[3], *mean, *deviation;
    int32_t *object, *x;
    uint8_t *needs;
    const float *record_rows[V_PLANE_CASE_ROWS], *node_rows[V_PLANE_CASE_ROWS];
    uint32_t width, count; /* pixels of a row between the margins; of them, those of x */
};

static inline void v_plane_case_source(struct random *r, bool wild, int32_t x, int32_t y,
                                       struct v_plane_source *s)
{
    const float bend = wild ? 0.3f : 0.02f;
    float n[3] = {field_between(r, -bend, bend), field_between(r, -bend, bend), 1.0f};
    const float length = sqrtf(n[0] * n[0] + n[1] * n[1] + 1.0f);
    const bool measured = !wild || !field_once_in(r, 9);
    const float at[3] = {0.01f * (float)x, 0.01f * (float)y,
                         field_between(r, 0.0f, wild ? 0.06f : 0.001f)};
    for (int k = 0; k < 3; k++) {
        s->point[k] = at[k];
        s->normal[k] = measured ? n[k] / length : 0.0f;
    }
    s->pixel = measured ? 0.01f : 0.0f;
    s->cell = (int32_t)(random_bits(r) % V_PLANE_CELLS);
}

static inline void v_plane_case_walk(struct random *r, bool wild, int axis, struct v_plane_walk *w)
{
    const float turn = wild ? field_between(r, -0.7f, 0.7f) : 0.0f, way = sqrtf(1.0f - turn * turn);
    const float tangent[3] = {axis == 0 ? way : turn, axis == 0 ? turn : way, 0.0f};
    memcpy(w->tangent, tangent, sizeof tangent);
    w->eta = wild ? field_between(r, 0.0f, 12.0f) : 4.0f;
    w->slant = wild ? field_between(r, -1.0f, 1.0f) : 0.0f;
    w->falloff = wild && field_once_in(r, 20) ? 1e30f : 78.0f;
    w->reach = wild ? (int32_t)(random_bits(r) % (V_PLANE_REACH_PX + 1)) : V_PLANE_REACH_PX;
    w->along_x = wild ? field_once_in(r, 2) : axis == 0;
}

/* Records as rays have them: of a direction (x, y, z), 2 y z, z^2, 1 - y^2, and radiance. */
static inline void v_plane_case_records(struct random *r, struct v_plane_case *out)
{
    const size_t lanes = out->field.lanes, size = v_plane_record_floats(&out->field);
    const size_t area = (size_t)out->field.width * V_PLANE_CASE_ROWS;
    out->records = field_memory(area * size * sizeof(float));
    for (size_t i = 0; i < area; i++) {
        float *record = out->records + i * size;
        for (size_t j = 0; j < lanes; j++) {
            const float y = field_between(r, -0.99f, 0.99f), most = sqrtf(1.0f - y * y);
            const float z = most * random_unit(r);
            record[j] = 2.0f * y * z;
            record[lanes + j] = z * z;
            record[2 * lanes + j] = 1.0f - y * y;
            for (size_t c = 3; c < V_PLANE_RECORD; c++)
                record[c * lanes + j] = field_once_in(r, 30) ? 6e4f : 2.0f * random_unit(r);
        }
    }
}

static inline void v_plane_case_samples(struct random *r, bool wild, struct v_plane_case *out)
{
    const size_t n = (size_t)out->field.strata * out->field.strata * 4, width = out->width;
    out->planes = field_memory((n * width + 1) * sizeof(float));
    for (size_t i = 1; i <= n * width; i++)
        out->planes[i] = wild && field_once_in(r, 3) ? 0.0f : field_between(r, 0.0f, 2.0f);
    for (int k = 0; k < 2; k++) out->jitter[k] = field_numbers(r, width, 0.0f, 1.0f);
    out->needs = field_memory(width);
    for (size_t i = 0; i < width; i++) out->needs[i] = (uint8_t)(random_bits(r) % 4);
}

static inline void v_plane_case_arrays(struct random *r, bool wild, struct v_plane_case *out)
{
    struct v_plane_field *f = &out->field;
    const size_t area = (size_t)f->width * (size_t)f->height;
    f->sources = out->sources = field_memory(area * sizeof *out->sources);
    for (int k = 0; k < 2; k++)
        f->walks[k] = out->walks[k] = field_memory(area * sizeof *out->walks[k]);
    for (int k = 0; k < 3; k++) out->normal[k] = field_memory(area * sizeof(float));
    out->object = field_memory(area * sizeof *out->object);
    for (int32_t i = 0; i < (int32_t)area; i++) {
        v_plane_case_source(r, wild, i % f->width, i / f->width, &out->sources[i]);
        for (int k = 0; k < 2; k++) v_plane_case_walk(r, wild, k, &out->walks[k][i]);
        for (int k = 0; k < 3; k++) out->normal[k][i] = out->sources[i].normal[k];
        out->object[i] = wild ? (i / 7) % V_PLANE_CASE_OBJECT : 0;
    }
    out->mean = field_numbers(r, area, wild ? -0.2f : 0.0f, 1.0f);
    out->deviation = field_numbers(r, area, 0.0f, 1.0f);
}

/* A row of `width` pixels at l x l strata. */
static inline void v_plane_case_init(struct v_plane_case *out, uint32_t l, int32_t width,
                                     uint64_t seed, bool wild)
{
    struct random r = {seed};
    *out = (struct v_plane_case){.width = (uint32_t)width};
    struct v_plane_field *f = &out->field;
    f->width = width + 2 * V_PLANE_CASE_MARGIN;
    f->height = V_PLANE_CASE_ROWS;
    f->strata = l;
    f->lanes = v_plane_lanes(l);
    v_plane_case_arrays(&r, wild, out);
    v_plane_case_records(&r, out);
    v_plane_case_samples(&r, wild, out);
    const size_t ratios = V_PLANE_POWERS * V_PLANE_CELLS * (size_t)l * V_PLANE_NODE_FLOATS;
    const size_t nodes = (size_t)f->width * V_PLANE_CASE_ROWS * V_PLANE_NODE_FLOATS;
    f->ratios = out->ratios = field_numbers(&r, ratios, 0.0f, 2.0f);
    out->nodes = field_numbers(&r, nodes, 0.0f, 2.0f);
    out->x = field_memory((size_t)width * sizeof *out->x);
    for (int32_t x = 0; x < width; x++)
        if (!wild || !field_once_in(&r, 6)) out->x[out->count++] = V_PLANE_CASE_MARGIN + x;
    for (size_t y = 0; y < V_PLANE_CASE_ROWS; y++) {
        const size_t at = y * (size_t)f->width;
        out->record_rows[y] = out->records + at * v_plane_record_floats(f);
        out->node_rows[y] = out->nodes + at * V_PLANE_NODE_FLOATS;
    }
    out->slopes = (struct v_plane_slopes_field){
        .width = f->width,
        .object = out->object,
        .normal = {out->normal[0], out->normal[1], out->normal[2]},
        .mean = out->mean,
        .deviation = out->deviation,
    };
}

static inline void v_plane_case_fini(struct v_plane_case *k)
{
    void *const all[] = {k->sources,   k->walks[0], k->walks[1],  k->ratios,    k->records,
                         k->nodes,     k->planes,   k->jitter[0], k->mean,      k->jitter[1],
                         k->object,    k->x,        k->needs,     k->normal[0], k->normal[1],
                         k->normal[2], k->deviation};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) free(all[i]);
}

/* Numbers that a kernel writes into. */
static inline size_t v_plane_case_output(const struct v_plane_case *k)
{
    const size_t most = v_plane_record_floats(&k->field);
    const size_t per = most > V_PLANE_NODE_FLOATS ? most : V_PLANE_NODE_FLOATS;
    return (size_t)k->field.width * V_PLANE_CASE_ROWS + (size_t)k->field.width * per;
}

/* One kernel into `out`, which is zeroed; its strata come from the same set of kernels. */
static inline void v_plane_case_run(const struct v_plane_case *k,
                                    const struct v_plane_kernels *kernels,
                                    enum v_plane_kernel kernel, float *out)
{
    const uint32_t l = k->field.strata;
    const size_t size = (size_t)l * k->width, middle = V_PLANE_CASE_MARGIN;
    const size_t first = middle * (size_t)k->field.width + middle;
    float *arrays = field_memory(3 * size * sizeof *arrays);
    const struct v_plane_strata strata = {l,      k->width,      k->width,
                                          arrays, arrays + size, arrays + 2 * size};
    const struct v_plane_planes planes = {k->planes + 1, k->width};
    if (kernel <= V_PLANE_RECORDS && kernel != V_PLANE_AVERAGE)
        kernels->strata(&strata, k->jitter[0] + 1, k->jitter[1] + 1);
    if (kernel == V_PLANE_STRATA)
        memcpy(out, arrays, 3 * size * sizeof *arrays);
    else if (kernel == V_PLANE_SLOPES)
        kernels->slopes(&strata, &planes, k->sources + first, 4.0f, out, out + k->width);
    else if (kernel == V_PLANE_AVERAGE)
        kernels->average(&k->slopes, first, k->width, out, out + k->width);
    else if (kernel == V_PLANE_RECORDS)
        kernels->records(&strata, &planes, k->field.lanes, k->needs, 2, 4.0f, out);
    else if (kernel == V_PLANE_COLUMNS)
        kernels->columns(&k->field, V_PLANE_CASE_MARGIN, k->x, k->count, k->record_rows, out);
    else
        kernels->rows(&k->field, V_PLANE_CASE_MARGIN, k->x, k->count, k->node_rows, out);
    free(arrays);
}

/* Greatest difference from the reference, over the greatest number; of the kernels that round
 * products squares of deviations, whose roots are those of differences that cancel. */
static inline float v_plane_case_compare(const struct v_plane_case *k,
                                         const struct v_plane_kernels *tested,
                                         enum v_plane_kernel kernel)
{
    const size_t size = v_plane_case_output(k);
    float *a = field_memory(size * sizeof *a), *b = field_memory(size * sizeof *b);
    v_plane_case_run(k, &v_plane_kernels_reference, kernel, a);
    v_plane_case_run(k, tested, kernel, b);
    for (size_t i = k->width; i < (size_t)2 * k->width; i++)
        if (tested == &v_plane_kernels_sse42 && kernel == V_PLANE_SLOPES)
            a[i] *= a[i], b[i] *= b[i];
    const float difference = field_difference(a, b, size);
    free(a);
    free(b);
    return difference;
}
