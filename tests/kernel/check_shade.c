/* make check-shade: each BSDF's sampling against its density, its reciprocity, and what a white
 * surface loses in a white room. One line a surface and direction; the last line counts.
 *
 *   check_shade [--quick] [CASE]     some of the surfaces; those whose names contain CASE
 *
 * Columns: p of a chi-square test of samples against the density, integrated over the cells of
 * shade_grid.h; that density's integral; the share of light reflected, and passed on, by
 * quadrature; the same by sampling, with its distance in standard errors; the greatest relative
 * difference of f(wo, wi) and f(wi, wo); the greatest of a sample's weight times density and f
 * |cos|. */
#include <stdio.h>
#include <time.h>

#include "tests/kernel/shade_statistics.h"
#include "tests/random.h"

#include "tests/kernel/shade_cases.h"
#include "tests/kernel/shade_grid.h"
#include "worker/shade/film.h"

#define SAMPLES         100000
#define EXPECTED_MIN    10.0 /* samples in a cell of the chi-square test */
#define ALL_BY_CHANCE   0.01 /* probability that a correct program fails one of its p-values */
#define SIGMAS_MAX      4.5
#define QUADRATURE_SLIP 5e-4
#define RECIPROCITY     1e-4
/* Through a volume: near total reflection the two directions round their cosines differently. */
#define RECIPROCITY_BENT 2e-3
#define CONSISTENCY      1e-5
#define TURN_OF_WO       0.11 /* azimuth: off all symmetries */

static const double angles_deg[] = {0.0, 35.0, 65.0, 85.0};
#define ANGLE_COUNT 4

struct tally {
    double least_energy, most_energy;
    int passed, failed;
};

/* What sampling one surface from one direction gave. */
struct outcome {
    int cells[GRID_CELLS];
    int lost; /* absorbed, or of a Dirac lobe */
    int smooth;
    double sum, sum2, dirac_sum; /* of weights: other lobes, Dirac lobes */
    double inconsistency;
};

static double weight_of(const struct bsdf *b, const struct bsdf_sample *s)
{
    const struct bsdf_value v = {s->diffuse, {s->specular[0], s->specular[1], s->specular[2]}, 0};
    return grid_value(b, &v);
}

static double relative_difference(double a, double b)
{
    const double most = fmax(fabs(a), fabs(b));
    return most > 1e-12 ? fabs(a - b) / most : 0.0;
}

/* A sample's weight and density against bsdf_evaluate's. */
static double inconsistency(const struct bsdf *b, const float wo[3], const struct bsdf_sample *s)
{
    struct bsdf_value v;
    bsdf_evaluate(b, wo, s->wi, &v);
    const double f = grid_value(b, &v) * fabs((double)s->wi[2]);
    const double length =
        sqrt((double)s->wi[0] * (double)s->wi[0] + (double)s->wi[1] * (double)s->wi[1] +
             (double)s->wi[2] * (double)s->wi[2]);
    double worst = relative_difference(weight_of(b, s) * (double)s->pdf, f);
    worst = fmax(worst, v.pdf == s->pdf ? 0.0 : 1.0);
    worst = fmax(worst, (s->wi[2] < 0.0f) == s->transmitted ? 0.0 : 1.0);
    return fmax(worst, fabs(length - 1.0) < 2e-6 ? 0.0 : fabs(length - 1.0));
}

static void draw(const struct shade_grid *g, struct random *r, int count, struct outcome *o)
{
    memset(o, 0, sizeof *o);
    for (int i = 0; i < count; i++) {
        const float choice = random_unit(r), u[2] = {random_unit(r), random_unit(r)};
        struct bsdf_sample s;
        if (!bsdf_sample(g->bsdf, g->wo, choice, u, &s)) {
            o->lost++;
            continue;
        }
        const double weight = weight_of(g->bsdf, &s);
        if (s.dirac) {
            o->lost++, o->smooth++;
            o->dirac_sum += weight;
            continue;
        }
        o->cells[grid_cell_of(g, s.wi)]++;
        o->sum += weight;
        o->sum2 += weight * weight;
        o->inconsistency = fmax(o->inconsistency, inconsistency(g->bsdf, g->wo, &s));
    }
}

struct cell_count {
    double expected, got;
};

static int by_expectation(const void *a, const void *b)
{
    const double x = ((const struct cell_count *)a)->expected;
    const double y = ((const struct cell_count *)b)->expected;
    return (x > y) - (x < y);
}

/* Cells of small expectation are pooled, in order of it; what was lost is one cell more. */
static double chi_square_p(const struct shade_grid *g, const struct outcome *o, int count)
{
    struct cell_count c[GRID_CELLS + 1], pool = {0};
    for (int i = 0; i < GRID_CELLS; i++) c[i] = (struct cell_count){g->pdf[i] * count, o->cells[i]};
    c[GRID_CELLS] = (struct cell_count){(1.0 - g->pdf_sum) * count, o->lost};
    qsort(c, GRID_CELLS + 1, sizeof *c, by_expectation);
    double chi_square = 0.0;
    int degrees = -1;
    for (int i = 0; i <= GRID_CELLS; i++) {
        pool.expected += c[i].expected;
        pool.got += c[i].got;
        if (pool.expected < EXPECTED_MIN && i < GRID_CELLS) continue;
        const double d = pool.got - pool.expected;
        if (pool.expected > 1.0) chi_square += d * d / pool.expected, degrees++;
        pool = (struct cell_count){0};
    }
    return chi_square_tail(chi_square, degrees);
}

/* A coat's own light the other way round, by the rule of coat.h. */
static double turned_coat(const struct bsdf *b, const float wo[3], const float wi[3], double all)
{
    struct bsdf coat = *b;
    struct bsdf_value v;
    double in = 0.0, out = 0.0;
    for (int k = 0; k < 3; k++) {
        coat.albedo[k] = coat.base_color[k] = 0.0f;
        in += (double)(wi[k] * b->coat_normal[k]);
        out += (double)(wo[k] * b->coat_normal[k]);
    }
    coat.specular = coat.metallic = 0.0f;
    bsdf_evaluate(&coat, wi, wo, &v);
    const double own = grid_value(&coat, &v);
    if (!(own > 0.0)) return all;
    return all - own + own * (in / (double)wi[2]) / (out / (double)wo[2]);
}

/* The same pair the other way round; through a volume, seen from the other side and by the rule of
 * gltf.h. */
static double turned(const struct bsdf *b, const float wo[3], const float wi[3])
{
    struct bsdf_value v;
    if (wi[2] > 0.0f) {
        bsdf_evaluate(b, wi, wo, &v);
        return b->coat_bent ? turned_coat(b, wo, wi, grid_value(b, &v)) : grid_value(b, &v);
    }
    struct bsdf back = *b;
    const bool bent = !b->thin && b->ior > 0.0f;
    const float from[3] = {wi[0], wi[1], -wi[2]}, to[3] = {wo[0], wo[1], -wo[2]};
    back.ior = b->ior > 0.0f ? 1.0f / b->ior : 0.0f;
    back.inside = !b->inside;
    for (int k = 0; b->dispersed && k < 3; k++) back.iors[k] = 1.0f / b->iors[k];
    bsdf_evaluate(&back, from, to, &v);
    return grid_value(&back, &v) * (bent ? (double)(b->ior * b->ior) : 1.0);
}

static double irreciprocity(const struct bsdf *b, const float wo[3], struct random *r)
{
    double worst = 0.0;
    for (int i = 0; i < 2000; i++) {
        const float choice = random_unit(r), u[2] = {random_unit(r), random_unit(r)};
        struct bsdf_sample s;
        struct bsdf_value v;
        if (!bsdf_sample(b, wo, choice, u, &s) || s.dirac || fabsf(s.wi[2]) < 1e-3f) continue;
        bsdf_evaluate(b, wo, s.wi, &v);
        worst = fmax(worst, relative_difference(grid_value(b, &v), turned(b, wo, s.wi)));
    }
    return worst;
}

static void judge(bool good, const char *what, struct tally *t)
{
    if (good) {
        t->passed++;
        return;
    }
    t->failed++;
    printf("    FAILED: %s\n", what);
}

static void check_direction(const struct shade_case *c, int angle, int count, double p_min,
                            struct tally *t)
{
    static struct shade_grid g;
    static struct outcome o;
    struct random r = {(uint64_t)(c - shade_cases) * 64 + (uint64_t)angle};
    const double theta = angles_deg[angle] * M_PI / 180.0, phi = TURN_OF_WO * 2.0 * M_PI;
    const float wo[3] = {(float)(sin(theta) * cos(phi)), (float)(sin(theta) * sin(phi)),
                         (float)cos(theta)};
    grid_init(&g, &c->bsdf, wo, c->narrowing, count);
    draw(&g, &r, count, &o);
    const double p = chi_square_p(&g, &o, count);
    const double mean = o.sum / count, by_quadrature = g.reflected + g.passed;
    const double error = sqrt(fmax(o.sum2 / count - mean * mean, 0.0) / count);
    const double away = fmax(fabs(mean - by_quadrature) - QUADRATURE_SLIP, 0.0);
    const double sigmas = away > 0.0 ? away / fmax(error, 1e-9) : 0.0;
    const double found = 1.0 - (double)o.lost / count, share = fmin(fmax(g.pdf_sum, 0.0), 1.0);
    const double found_error = sqrt(share * (1.0 - share) / count);
    const double turned_max = irreciprocity(&c->bsdf, wo, &r);
    const double energy = by_quadrature + o.dirac_sum / count;
    t->least_energy = fmin(t->least_energy, energy);
    t->most_energy = fmax(t->most_energy, energy);
    printf("  %2.0f deg  p %8.2g  density %.5f  reflected %.4f  passed %.4f  smooth %.4f  "
           "sampled %.4f %4.1f sigma  reciprocal %.0e  consistent %.0e\n",
           angles_deg[angle], p, g.pdf_sum, g.reflected, g.passed, o.dirac_sum / count, mean,
           sigmas, turned_max, o.inconsistency);
    judge(p >= p_min, "samples do not follow the density", t);
    judge(g.pdf_sum <= 1.0 + QUADRATURE_SLIP &&
              fabs(found - g.pdf_sum) <= SIGMAS_MAX * found_error + QUADRATURE_SLIP,
          "the density's integral is not the share of samples", t);
    judge(sigmas <= SIGMAS_MAX, "sampling and quadrature of the reflected light differ", t);
    judge(turned_max <= (g.passed > 0.0 ? RECIPROCITY_BENT : RECIPROCITY), "not reciprocal", t);
    judge(o.inconsistency <= CONSISTENCY, "weight times density is not f |cos|", t);
}

/* Nanoseconds of one bsdf_sample and one bsdf_evaluate, as a path's vertex needs them. */
static double cost_ns(const struct bsdf *b)
{
    enum { ROUNDS = 200000 };
    struct random r = {1};
    struct timespec start, end;
    const float wo[3] = {0.48f, 0.36f, 0.8f}, wl[3] = {-0.6f, 0.0f, 0.8f};
    volatile float sink = 0.0f;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &start);
    for (int i = 0; i < ROUNDS; i++) {
        const float choice = random_unit(&r), u[2] = {random_unit(&r), random_unit(&r)};
        struct bsdf_sample s;
        struct bsdf_value v;
        bsdf_evaluate(b, wo, wl, &v);
        if (bsdf_sample(b, wo, choice, u, &s)) sink = s.wi[2] + v.pdf;
    }
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &end);
    (void)sink;
    return ((double)(end.tv_sec - start.tv_sec) * 1e9 + (double)(end.tv_nsec - start.tv_nsec)) /
           ROUNDS;
}

static void check_case(const struct shade_case *c, int count, double p_min, struct tally *total)
{
    struct tally t = {.least_energy = 1e9};
    printf("%s\n", c->name);
    for (int angle = 0; angle < ANGLE_COUNT; angle++) check_direction(c, angle, count, p_min, &t);
    if (c->loss_max >= 0.0) {
        const double loss = 1.0 - t.least_energy, gain = t.most_energy - 1.0;
        printf("  furnace: loses up to %.4f (bound %.4g), gains %.4f (bound %.4g)", fmax(loss, 0.0),
               c->loss_max, fmax(gain, 0.0), c->gain_max);
        printf("; %.0f ns\n", cost_ns(&c->bsdf));
        judge(loss <= c->loss_max + QUADRATURE_SLIP, "a white surface loses more than is known",
              &t);
        judge(gain <= c->gain_max + QUADRATURE_SLIP, "more light leaves than comes in", &t);
    } else {
        printf("  %.0f ns\n", cost_ns(&c->bsdf));
    }
    total->passed += t.passed;
    total->failed += t.failed;
}

/* Returns the number of models that no case is of. */
static int count_untested(void)
{
    int of[BSDF_MODEL_COUNT] = {[BSDF_BLACK] = 1}, untested = 0;
    for (int i = 0; i < SHADE_CASE_COUNT; i++) of[shade_cases[i].bsdf.model]++;
    for (int model = 0; model < BSDF_MODEL_COUNT; model++) {
        if (of[model] > 0) continue;
        printf("FAILED: model %d has no case in shade_cases.h\n", model);
        untested++;
    }
    return untested;
}

int main(int argc, char **argv)
{
    const bool quick = argc > 1 && strcmp(argv[1], "--quick") == 0;
    const char *wanted = argc > 1 + quick ? argv[1 + quick] : "";
    const double p_min = sidak(ALL_BY_CHANCE, SHADE_CASE_COUNT * ANGLE_COUNT);
    struct tally total = {0};
    for (int i = 0; i < SHADE_CASE_COUNT; i++) film_prepare(&shade_cases[i].bsdf);
    printf("chi-square: %d surfaces in %d directions, p at least %.2g\n", SHADE_CASE_COUNT,
           ANGLE_COUNT, p_min);
    for (int i = 0; i < SHADE_CASE_COUNT; i++) {
        const struct shade_case *c = &shade_cases[i];
        if ((quick && !c->quick) || !strstr(c->name, wanted)) continue;
        check_case(c, SAMPLES, p_min, &total);
    }
    total.failed += count_untested();
    printf("%d passed, %d failed\n", total.passed, total.failed);
    return total.failed > 0;
}
