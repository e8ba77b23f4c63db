/* analytic [short | long] [NAME]: all analytic cases, or those whose names contain NAME, as TAP
 * with a line of figures each. */
#include "tests/golden/analytic.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "proto/half.h"
#include "worker/scene/environment.h"
#include "worker/tile/tile.h"

#define DEVIATIONS     4.0
#define FLOAT_ROUNDING 2e-5

#define PLANES_FIELD (PLANE_BIT(INDIRECT_MEAN) | PLANE_BIT(AMBIENT_VISIBILITY))

static struct {
    uint32_t spp;
    const char *only;
    int count, failed;
} run = {.spp = 128};

static void die(const char *what, const struct fault *fault)
{
    printf("Bail out! %s: %s %s\n", what, fault->pointer, fault->detail);
    exit(1);
}

static struct picture *picture_new(const struct plan *plan)
{
    struct picture *p = calloc(1, sizeof *p);
    if (!p) abort();
    size_t pixels = (size_t)plan->width_px * (size_t)plan->height_px;
    p->width = plan->width_px, p->height = plan->height_px, p->spp = plan->paths.spp;
    for (int id = 0; id < PLANE_ID_COUNT; id++) {
        bool one = id == PLANE_PATH_COVERAGE || id == PLANE_PATH_VISIBILITY ||
                   id == PLANE_AMBIENT_VISIBILITY;
        int components = one ? 1 : 3;
        if (!((PLANES_PATH | PLANES_FIELD) >> id & 1u)) continue;
        if (!(plan->planes >> id & 1u)) continue;
        if (id == PLANE_PATH_M2 || id == PLANE_PATH_HALF_DIFFERENCE2) continue;
        for (int c = 0; c < components; c++)
            if (!(p->mean[id][c] = calloc(pixels, sizeof(double)))) abort();
    }
    for (int c = 0; c < 3; c++)
        if (!(p->variance[c] = calloc(pixels, sizeof(double)))) abort();
    return p;
}

void picture_free(struct picture **p)
{
    for (int id = 0; id < PLANE_ID_COUNT; id++)
        for (int c = 0; c < 3; c++) free((*p)->mean[id][c]);
    for (int c = 0; c < 3; c++) free((*p)->variance[c]);
    free(*p);
    *p = NULL;
}

/* Adds one pass's sums: `mean` holds sums until the end, `variance` squared deviations (Chan, Golub
 * and LeVeque 1979). */
static void add_pass(struct picture *p, const struct samples *s, uint32_t before, uint32_t count)
{
    size_t pixels = (size_t)p->width * (size_t)p->height;
    for (int c = 0; c < 3; c++) {
        const float *sum = samples_f32(s, PLANE_PATH_RADIANCE, (uint32_t)c);
        const float *spread = samples_f32(s, PLANE_PATH_M2, (uint32_t)c);
        for (size_t i = 0; i < pixels; i++) {
            p->variance[c][i] += (double)spread[i];
            if (before == 0) continue;
            double apart = (double)sum[i] / count - p->mean[PLANE_PATH_RADIANCE][c][i] / before;
            p->variance[c][i] += apart * apart * before * count / (before + count);
        }
    }
    for (int id = 0; id < PLANE_ID_COUNT; id++)
        for (int c = 0; c < 3 && p->mean[id][c]; c++) {
            const float *sum = samples_f32(s, (enum plane_id)id, (uint32_t)c);
            for (size_t i = 0; i < pixels; i++) p->mean[id][c][i] += (double)sum[i];
        }
}

static void finish(struct picture *p)
{
    size_t pixels = (size_t)p->width * (size_t)p->height;
    double n = p->spp;
    for (int id = 0; id < PLANE_ID_COUNT; id++)
        for (int c = 0; c < 3 && p->mean[id][c]; c++)
            for (size_t i = 0; i < pixels; i++) p->mean[id][c][i] /= n;
    for (int c = 0; c < 3; c++)
        for (size_t i = 0; i < pixels; i++) p->variance[c][i] /= n * (n - 1);
}

/* A stage ready to trace. */
struct set {
    struct render_scene *scene;
    struct environment *environment;
    struct tile_tracer *tracer;
};

static void set_open(struct set *set, const struct stage *s)
{
    struct fault fault = {0};
    *set = (struct set){0};
    if (render_scene_create(fixture_scene(s->f), 1, NULL, &set->scene, &fault))
        die("scene", &fault);
    if (tile_tracer_create(&set->tracer)) die("tracer", &fault);
    if (s->map.blob && environment_create(&s->map, &set->environment)) die("environment", &fault);
}

static void set_close(struct set *set)
{
    tile_tracer_destroy(&set->tracer);
    environment_destroy(&set->environment);
    render_scene_destroy(&set->scene);
}

static struct samples *set_trace(const struct set *set, const struct plan *plan, uint32_t pass)
{
    struct samples *samples = NULL;
    struct counters counters = {0};
    struct fault fault = {0};
    if (tile_trace(set->tracer,
                   &(struct tile_job){.scene = set->scene,
                                      .environment = set->environment,
                                      .plan = plan,
                                      .rect = (struct rect){0, 0, plan->width_px, plan->height_px},
                                      .counters = &counters},
                   pass, &samples))
        die("tile_trace", &fault);
    return samples;
}

struct picture *stage_trace(struct stage *s)
{
    struct set set;
    struct plan *plan = &s->plan;
    plan->paths.spp = run.spp;
    plan->pattern.seed = 1;
    set_open(&set, s);
    struct picture *p = picture_new(plan);
    for (uint32_t pass = 0; pass < plan_pass_count(plan); pass++) {
        uint32_t first, count;
        plan_pass_range(plan, pass, &first, &count);
        struct samples *samples = set_trace(&set, plan, pass);
        add_pass(p, samples, first, count);
        samples_destroy(&samples);
    }
    finish(p);
    set_close(&set);
    return p;
}

struct picture *stage_trace_field(struct stage *s, bool beside_paths)
{
    struct set set;
    struct plan plan = s->plan;
    plan.paths.spp = beside_paths;
    plan.paths.without_diffuse_indirect = beside_paths;
    plan.planes = beside_paths ? plan.planes : plan.planes & ~PLANES_PATH;
    plan.planes |= PLANE_BIT(BOUNCE_DISTANCE_MIN);
    if (plan.bounces > 0) plan.planes |= PLANE_BIT(INDIRECT_MEAN);
    if (plan.occlusion_distance > 0) plan.planes |= PLANE_BIT(AMBIENT_VISIBILITY);
    plan.indirect_strata_per_axis = (uint32_t)sqrt((double)run.spp);
    plan.pattern.seed = 1;
    set_open(&set, s);
    struct samples *samples = set_trace(&set, &plan, 0);
    plan.planes &= PLANES_FIELD;
    struct picture *p = picture_new(&plan);
    p->spp = plan.indirect_strata_per_axis * plan.indirect_strata_per_axis;
    for (int id = 0; id < PLANE_ID_COUNT; id++)
        for (int c = 0; c < 3 && p->mean[id][c]; c++) {
            const uint16_t *from = samples_u16(samples, (enum plane_id)id, (uint32_t)c);
            for (size_t i = 0; i < (size_t)p->width * (size_t)p->height; i++)
                p->mean[id][c][i] = (double)half_to_float(from[i]);
        }
    samples_destroy(&samples);
    set_close(&set);
    return p;
}

struct figure {
    double value, by_spread, by_scatter; /* the mean over pixels, its standard errors */
};

static struct figure mean_of(const struct picture *p, enum plane_id plane, int c)
{
    struct figure f = {0};
    size_t pixels = (size_t)p->width * (size_t)p->height;
    double n = (double)pixels;
    for (size_t i = 0; i < pixels; i++) {
        f.value += p->mean[plane][c][i] / n;
        f.by_spread += p->variance[c][i];
    }
    for (size_t i = 0; i < pixels; i++) {
        double apart = p->mean[plane][c][i] - f.value;
        f.by_scatter += apart * apart;
    }
    f.by_spread = sqrt(f.by_spread) / n;
    f.by_scatter = sqrt(f.by_scatter / (n * (n - 1)));
    return f;
}

static void report(const char *name, bool holds)
{
    run.count++;
    run.failed += !holds;
    printf("%s %d - %s\n", holds ? "ok" : "not ok", run.count, name);
}

/* z says nothing of figures that have no noise but rounding. */
static void print_figures(const char *channel, double value, double expected, double se,
                          double allowed)
{
    char z[32] = "exact";
    double apart = fabs(value - expected), rounding = FLOAT_ROUNDING * fabs(expected);
    if (apart > rounding || DEVIATIONS * se > rounding)
        snprintf(z, sizeof z, "%.2f", se > 0 ? (value - expected) / se : (double)INFINITY);
    printf("#   %-1s %14.8g  expected %14.8g  se %9.2e  z %7s%s\n", channel, value, expected, se, z,
           apart <= allowed ? "" : "  <-- beyond");
}

static bool chosen(const char *name)
{
    return !run.only || strstr(name, run.only);
}

void picture_expect(const struct picture *p, const char *name, enum plane_id plane,
                    const double expected[3], double allowance)
{
    static const char *const channels[] = {"R", "G", "B"};
    struct figure f[3];
    double allowed[3];
    bool holds = true;
    int components = 0;
    if (!chosen(name)) return;
    for (int c = 0; c < 3 && p->mean[plane][c]; c++, components++) {
        double slack = (allowance + FLOAT_ROUNDING) * fabs(expected[c]);
        f[c] = mean_of(p, plane, c);
        double se = f[c].by_scatter;
        if (plane == PLANE_PATH_RADIANCE && f[c].by_spread < se) se = f[c].by_spread;
        allowed[c] = DEVIATIONS * se + slack;
        if (!(fabs(f[c].value - expected[c]) <= allowed[c])) holds = false;
    }
    report(name, holds && components > 0);
    for (int c = 0; c < components; c++) {
        bool same = c > 0 && f[c].value == f[0].value && expected[c] == expected[0];
        double se = plane == PLANE_PATH_RADIANCE ? f[c].by_spread : f[c].by_scatter;
        if (!same) print_figures(channels[c], f[c].value, expected[c], se, allowed[c]);
    }
}

void picture_expect_grey(const struct picture *p, const char *name, enum plane_id plane,
                         double expected, double allowance)
{
    picture_expect(p, name, plane, (double[3]){expected, expected, expected}, allowance);
}

void picture_expect_sum(const struct picture *p, const char *name, const double *weights,
                        double expected, double allowance)
{
    double value = 0, variance = 0, size = 0;
    if (!chosen(name)) return;
    for (size_t i = 0; i < (size_t)p->width * (size_t)p->height; i++) {
        double mean = p->mean[PLANE_PATH_RADIANCE][0][i];
        value += weights[i] * mean;
        size += fabs(weights[i] * mean);
        variance += weights[i] * weights[i] * p->variance[0][i];
    }
    double allowed = DEVIATIONS * sqrt(variance) + allowance + FLOAT_ROUNDING * size;
    report(name, fabs(value - expected) <= allowed);
    print_figures("", value, expected, sqrt(variance), allowed);
}

void analytic_expect(const char *name, bool holds, const char *format, ...)
{
    va_list arguments;
    if (!chosen(name)) return;
    report(name, holds);
    printf("#   ");
    va_start(arguments, format);
    vprintf(format, arguments);
    va_end(arguments);
    putchar('\n');
}

int main(int argc, char **argv)
{
    bool is_long = argc > 1 && !strcmp(argv[1], "long");
    if (argc > 3 || (argc > 1 && !is_long && strcmp(argv[1], "short") != 0)) {
        fprintf(stderr, "usage: analytic [short | long] [NAME]\n");
        return 2;
    }
    if (argc > 2) run.only = argv[2];
    run.spp = is_long ? 1024 : 128;
    setvbuf(stdout, NULL, _IOLBF, 0);
    printf("# %d samples a case, %d pixels of %u\n", STAGE_SIDE_PX * STAGE_SIDE_PX * (int)run.spp,
           STAGE_SIDE_PX * STAGE_SIDE_PX, run.spp);
    analytic_furnaces();
    analytic_lights();
    analytic_fields();
    analytic_environments();
    analytic_surfaces();
    analytic_lenses();
    analytic_scales();
    printf("1..%d\n", run.count);
    return run.failed > 0;
}
