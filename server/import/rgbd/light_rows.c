#include "server/import/rgbd/light_rows.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "proto/scene/environment.h"
#include "server/import/rgbd/white.h"

/* Rays around a point: each stands for PER_RAY x PER_RAY texels of the sky. */
#define RAYS_U  32u
#define RAYS_V  16u
#define PER_RAY (SCENE_SKY_WIDTH_PX / RAYS_U)

#define DARK      0.02f /* of white: what is darker tells of no light */
#define CHROMAS   8     /* steps of a colour's shares of red and green; CHROMAS^2 is LIGHT_GROUPS */
#define LIT_SHARE 0.9   /* so many of a group are darker than its fully lit ones */
_Static_assert(CHROMAS *CHROMAS == LIGHT_GROUPS, "a group for each");

struct finder {
    const struct light_view *view;
    const struct light_sky *sky;
    const struct light_lamp *lamps;
    uint32_t lamp_count;
    struct light_rows *out;
    float *ratio[3]; /* owned; rows: colour over white */
};

static uint8_t group_of(const float ratio[3])
{
    const float sum = ratio[0] + ratio[1] + ratio[2];
    const int r = (int)(CHROMAS * ratio[0] / sum), g = (int)(CHROMAS * ratio[1] / sum);
    return (uint8_t)((r < CHROMAS ? r : CHROMAS - 1) * CHROMAS + (g < CHROMAS ? g : CHROMAS - 1));
}

/* Adds what comes along a ray of some solid angle, times its cosine, that met nothing in the
 * point's own view: from each of its texels what is seen there, or what its bin may shine. */
static void add_sky(const struct finder *f, uint32_t u, uint32_t v, double falls, uint32_t row)
{
    const uint32_t texels = PER_RAY * PER_RAY;
    const float part = (float)(falls / texels);
    for (uint32_t k = 0; k < texels; k++) {
        const uint32_t x = u * PER_RAY + k % PER_RAY, y = v * PER_RAY + k / PER_RAY;
        const uint32_t i = y * SCENE_SKY_WIDTH_PX + x;
        const uint32_t bin = y * LIGHT_BINS_V / SCENE_SKY_HEIGHT_PX * LIGHT_BINS_U +
                             x * LIGHT_BINS_U / SCENE_SKY_WIDTH_PX;
        if (!f->sky->seen[i])
            f->out->falls[(size_t)row * f->out->unknowns + bin] += part;
        else
            for (uint32_t c = 0; c < 3; c++)
                f->out->known[c][row] += part * f->sky->texels[3 * i + c];
    }
}

static void look_around(const struct finder *f, const double at[3], const double normal[3],
                        uint32_t row)
{
    for (uint32_t i = 0; i < RAYS_U * RAYS_V; i++) {
        const uint32_t u = i % RAYS_U, v = i / RAYS_U;
        const double angle =
            2 * M_PI / RAYS_U * (environment_edge(v + 1, RAYS_V) - environment_edge(v, RAYS_V));
        double direction[3];
        light_sky_direction(u + 0.5, v + 0.5, RAYS_U, RAYS_V, direction);
        const double cosine = dot3(direction, normal);
        if (!(cosine > 0)) continue;
        const struct light_hit hit = light_view_trace(f->view, at, direction);
        if (hit.pixel == NULL)
            add_sky(f, u, v, angle * cosine, row);
        else if (!hit.pixel->shines)
            for (int c = 0; c < 3; c++)
                f->out->known[c][row] += (float)(angle * cosine * (double)hit.pixel->color[c]);
    }
}

/* Lamps are met as others are, by what is nearer. */
static void look_at_lamps(const struct finder *f, const double at[3], const double normal[3],
                          uint32_t row)
{
    for (uint32_t k = 0; k < f->lamp_count; k++) {
        double to[3];
        for (int c = 0; c < 3; c++) to[c] = f->lamps[k].center[c] - at[c];
        const double distance = sqrt(dot3(to, to));
        if (!normalize3(to)) continue;
        const struct light_hit hit = light_view_trace(f->view, at, to);
        if (hit.pixel && !hit.pixel->shines && hit.distance < 0.9 * distance) continue;
        f->out->falls[(size_t)row * f->out->unknowns + LIGHT_BINS + k] =
            (float)light_lamp_falls(&f->lamps[k], at, normal);
    }
}

static void add_row(struct finder *f, const struct light_pixel *p)
{
    double at[3], normal[3];
    float ratio[3];
    const uint32_t row = f->out->count;
    const double off = f->view->units_per_m * (double)(3 * depth_noise_m(p->z) + 0.01f * p->z);
    for (int c = 0; c < 3; c++) ratio[c] = p->color[c] / f->view->white[c];
    if (!(p->z > 0) || p->shines || !(ratio[0] + ratio[1] + ratio[2] > 3 * DARK)) return;
    if (p->normal[0] == 0 && p->normal[1] == 0 && p->normal[2] == 0) return;
    light_view_point(f->view, p, at);
    for (int c = 0; c < 3; c++) {
        normal[c] = (double)p->normal[c];
        at[c] += off * normal[c];
        f->ratio[c][row] = ratio[c];
        f->out->seen[c][row] = p->color[c];
    }
    f->out->group[row] = group_of(ratio);
    look_around(f, at, normal, row);
    look_at_lamps(f, at, normal, row);
    f->out->count++;
}

static void add_view(struct finder *f, uint32_t most)
{
    const struct light_view *v = f->view;
    const int32_t step = (int32_t)ceil(sqrt((double)v->width * v->height / most)) + 1;
    uint32_t left = most;
    for (int32_t y = step / 2; y < v->height; y += step)
        for (int32_t x = step / 2; x < v->width && left > 0; x += step) {
            const uint32_t before = f->out->count;
            add_row(f, &v->pixels[(size_t)y * (size_t)v->width + (size_t)x]);
            left -= f->out->count - before;
        }
}

static int compare(const void *a, const void *b)
{
    const float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

/* The brightest of a group are lit as white is. */
static void guess_albedo(const struct finder *f, int c)
{
    static float list[LIGHT_ROWS];
    for (int k = 0; k < LIGHT_GROUPS; k++) {
        uint32_t count = 0;
        for (uint32_t i = 0; i < f->out->count; i++)
            if (f->out->group[i] == k) list[count++] = f->ratio[c][i];
        qsort(list, count, sizeof *list, compare);
        const float lit = count > 0 ? list[(uint32_t)(LIT_SHARE * (count - 1))] : 1;
        f->out->albedo[c][k] = (double)white_albedo(lit, 1);
    }
}

static int allocate(struct finder *f)
{
    struct light_rows *r = f->out;
    bool all = true;
    r->falls = calloc((size_t)LIGHT_ROWS * r->unknowns, sizeof *r->falls);
    r->group = calloc(LIGHT_ROWS, sizeof *r->group);
    for (int c = 0; c < 3; c++) {
        r->seen[c] = calloc(LIGHT_ROWS, sizeof(float));
        r->known[c] = calloc(LIGHT_ROWS, sizeof(float));
        f->ratio[c] = calloc(LIGHT_ROWS, sizeof(float));
        all = all && r->seen[c] && r->known[c] && f->ratio[c];
    }
    return all && r->falls && r->group ? 0 : ERR_MEMORY;
}

int light_rows_find(const struct light_views *views, const struct light_sky *sky,
                    const struct light_lamp *lamps, uint32_t lamp_count, struct light_rows *out)
{
    struct finder f = {.sky = sky, .lamps = lamps, .lamp_count = lamp_count, .out = out};
    *out = (struct light_rows){.unknowns = LIGHT_BINS + lamp_count};
    const int rc = allocate(&f);
    for (uint32_t i = 0; i < views->count && rc == 0; i++) {
        f.view = &views->list[i];
        add_view(&f, LIGHT_ROWS / views->count);
    }
    for (int c = 0; c < 3; c++) {
        if (rc == 0) guess_albedo(&f, c);
        free(f.ratio[c]);
    }
    return rc;
}

void light_rows_destroy(struct light_rows *rows)
{
    free(rows->falls);
    free(rows->group);
    for (int c = 0; c < 3; c++) {
        free(rows->seen[c]);
        free(rows->known[c]);
    }
    *rows = (struct light_rows){.count = 0};
}
