/* bench_roofline: the filters' kernels beside what one core of this machine can do (Williams,
 * Waterman and Patterson 2009, "Roofline: an insightful visual performance model for multicore
 * architectures"), as JSON lines: the machine's limits, then each kernel of check_kernels.
 *
 *   roof = the longest of: operations / the rate of additions and multiplications,
 *          those and operations on whole numbers / the rate of additions of the latter,
 *          divisions / their rate, square roots / theirs, bytes / bandwidth,
 *          lines read from the first cache / their rate, vectors written there / theirs
 *
 * slots = of the instructions that the vector units can begin meanwhile, which part the kernel's
 *         are: what moves and picks numbers counts there, too
 *
 * Operations are those that run (roofline_probe.h). Bytes are those of the arrays that a kernel's
 * documentation names, each read or written once for an output, whatever it reads again: what must
 * come from beyond the first cache. The level is the smallest that holds all of these. Of the first
 * cache counts what runs asks of it (Ilic, Pratas and Sousa 2014, "Cache-aware roofline model"),
 * but for the stack; over_beyond is the time over the longest of the other limits. Cases are those
 * of check_kernels: 9 samples a light and a pixel, smooth surfaces in penumbra, filters at their
 * widest; times the least of some turns, call by call, in rounds that lie apart.
 *
 * check: nothing is measured; status 1 when instructions are counted wrong. */
#include <stdio.h>

#include "proto/runtime/build.h"
#include "tests/bench/roofline_machine.h"
#include "tests/bench/roofline_probe.h"
#include "tests/bench/roofline_wrap.h"

enum {
    SIDE = 96,
    ROUNDS = 3, /* over all kernels: rates of a shared machine come and go */
    TURNS = 12, /* of each round */
    CALLS_MOST = 1024,
    CHUNK_PX = 256,  /* of lists of pixels, a call */
    COUNT_PX = 48,   /* at least, of which instructions are counted */
    COUNT_FROM = 40, /* calls of rows that are passed over before that: from the middle */
    STRATA = 3,
};

struct subject {
    const char *name;
    const void *kernel;
    /* Of an output: numbers, four bytes each, that are read and written. */
    double read, written;
    /* Of one call or more: of few outputs where only these are counted. */
    void (*run)(int number, bool few);
    int number;
};

/* What was found of it. */
struct found {
    double least[CALLS_MOST]; /* ns */
    double outputs, ns;       /* of a turn; of an output */
};

/* -- around the kernel -- */

static struct {
    const void *kernel; /* that is measured */
    bool counts;        /* instructions, not time */
    int passed;         /* calls that are left to pass over */
    int call;           /* of this turn */
    double outputs, started;
    double *least;   /* ns, of each of a turn's calls: CALLS_MOST */
    double clock_ns; /* what is measured of nothing */
} around;

/* Calls are short, and of each the least of all turns counts: what else the machine does meanwhile
 * is not in it. */
static double clock_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return 1e9 * (double)t.tv_sec + (double)t.tv_nsec;
}

static bool is_asked(const void *kernel)
{
    return kernel == around.kernel &&
           (!around.counts || (around.passed <= 0 && around.outputs < COUNT_PX));
}

static void note_call(double ns)
{
    if (around.call == CALLS_MOST) abort();
    double *least = &around.least[around.call++];
    ns = fmax(ns - around.clock_ns, 0.0);
    *least = *least < ns ? *least : ns;
}

/* The least that lies between two looks at the clock. */
static double clock_itself(void)
{
    double least = 1e30;
    for (int i = 0; i < 10000; i++) {
        const double start = clock_ns();
        least = fmin(least, clock_ns() - start);
    }
    return least;
}

static void around_begin(const void *kernel)
{
    if (!is_asked(kernel)) return;
    if (around.counts)
        probe_begin();
    else
        around.started = clock_ns();
}

static void around_end(const void *kernel, double outputs)
{
    if (kernel != around.kernel) return;
    if (is_asked(kernel)) {
        if (around.counts)
            probe_end();
        else
            note_call(clock_ns() - around.started);
        around.outputs += outputs;
    }
    around.passed--;
}

/* -- the cases -- */

static struct kernel_field field;
static struct indirect_case indirect;
static struct glossy_case glossy;
static struct lens_case lens;
static struct lens_light_case lens_light;
static struct v_plane_case v_plane, v_plane_few;

static void run_field(int number, bool few)
{
    const enum kernel kernel = (enum kernel)number;
    const uint32_t end = few ? field.count / 2 + COUNT_PX : field.count;
    float *out = field_memory((field_output(&field, kernel, field.count) + 1) * sizeof *out);
    around.passed = 0;
    for (uint32_t i = few ? field.count / 2 : 0; i < end; i += CHUNK_PX) {
        const uint32_t left = end - i, count = left < CHUNK_PX ? left : CHUNK_PX;
        field_run(&field, &wrapped_shadow, kernel, i, count, out);
    }
    free(out);
}

static void run_indirect(int number, bool few)
{
    float *out = field_memory(INDIRECT_CASE_CHANNELS * indirect.area * sizeof *out);
    (void)few;
    indirect_case_run(&indirect, &wrapped_indirect, (enum indirect_kernel)number, 0, out);
    free(out);
}

static void run_glossy(int number, bool few)
{
    float *out = field_memory(GLOSSY_CASE_CHANNELS * glossy.area * sizeof *out);
    (void)few;
    glossy_case_run(&glossy, &wrapped_glossy, (enum glossy_kernel)number, 0, out);
    free(out);
}

static void run_lens(int number, bool few)
{
    float *out = field_memory(lens_case_size(&lens, (enum lens_kernel)number) * sizeof *out);
    (void)few;
    lens_case_run(&lens, &wrapped_lens, (enum lens_kernel)number, out);
    free(out);
}

static void run_lens_light(int number, bool few)
{
    float *out = field_memory(lens_light_case_size(&lens_light) * sizeof *out);
    around.passed = 0;
    lens_light_case_run(&lens_light, &wrapped_lens_light, (enum lens_light_kernel)number,
                        few ? lens_light.count - 4 * COUNT_PX : 0, out);
    free(out);
}

static void run_v_plane(int number, bool few)
{
    const struct v_plane_case *c = few ? &v_plane_few : &v_plane;
    float *out = field_memory(v_plane_case_output(c) * sizeof *out);
    around.passed = 0;
    v_plane_case_run(c, &wrapped_v_plane, (enum v_plane_kernel)number, out);
    free(out);
}

static void create_cases(void)
{
    field_init(&field, STRATA, SIDE, SIDE, 4, false);
    indirect_case_init(&indirect, SIDE, SIDE, 4, false);
    glossy_case_init(&glossy, SIDE, SIDE, 4, false);
    lens_case_init(&lens, SIDE, SIDE, 5, 0);
    lens_light_case_init(&lens_light, SIDE * SIDE, 6);
    v_plane_case_init(&v_plane, STRATA, SIDE, 4, false);
    v_plane_case_init(&v_plane_few, STRATA, 16, 4, false);
}

/* -- what is measured -- */

/* A round's turns. */
static void measure(const struct subject *s, struct found *f)
{
    int calls = 0;
    around.least = f->least;
    for (int turn = 0; turn < TURNS; turn++) {
        around.kernel = s->kernel, around.counts = false, around.outputs = 0, around.call = 0;
        s->run(s->number, false);
        f->outputs = around.outputs;
        calls = around.call;
    }
    f->ns = 0;
    for (int i = 0; i < calls; i++) f->ns += f->least[i] / f->outputs;
}

static void say(const struct subject *s, const struct found *f, const struct roof_machine *m)
{
    const double ns = f->ns, outputs = f->outputs;
    around.kernel = s->kernel;
    around.counts = true, around.outputs = 0, around.passed = COUNT_FROM;
    probe_found = (struct probe_counts){0};
    s->run(s->number, true);
    const double each = 1.0 / around.outputs;
    const double bytes = 4.0 * (s->read + s->written), all = bytes * outputs;
    const enum roof_level level = all <= (double)m->cache_bytes[ROOF_L2]   ? ROOF_L2
                                  : all <= (double)m->cache_bytes[ROOF_L3] ? ROOF_L3
                                                                           : ROOF_MEMORY;
    /* what is fused is one instruction beside those on whole numbers */
    const double apart = probe_found.operations - probe_found.fused;
    enum { BEYOND = 5, LIMITS = 7 };
    const double line_ns = probe_found.stores > 0 ? probe_found.stores / m->stores : 0.0;
    const double store_ns = line_ns + probe_found.narrow / m->narrow;
    const double limits[LIMITS] = {probe_found.operations * each / fmax(m->mul_add, m->fused),
                                   (apart + probe_found.whole) * each / m->whole,
                                   probe_found.divisions * each / m->divisions,
                                   probe_found.roots * each / m->roots,
                                   bytes / m->bandwidth[level],
                                   probe_found.loads * each / m->loads,
                                   store_ns * each};
    const char *const names[LIMITS] = {"arithmetic",   "whole numbers",         "divisions",
                                       "square roots", roof_level_names[level], "L1, loads",
                                       "L1, stores"};
    int longest = 0, beyond;
    for (int i = 1; i < BEYOND; i++) longest = limits[i] > limits[longest] ? i : longest;
    beyond = longest;
    for (int i = BEYOND; i < LIMITS; i++) longest = limits[i] > limits[longest] ? i : longest;
    printf(
        "{\"kernel\":\"%s\",\"operations\":%.1f,\"fused\":%.1f,\"whole\":%.1f,\"divisions\":%.2f,"
        "\"roots\":%.2f,\"instructions\":%.1f,\"loads\":%.2f,\"stores\":%.2f,\"bytes\":%.0f,"
        "\"intensity\":%.3g,\"ns\":%.3f,"
        "\"goperations_s\":%.3g,\"roof_ns\":%.3f,\"limit\":\"%s\",\"over_roof\":%.3g,"
        "\"over_beyond\":%.3g,\"slots\":%.3g}\n",
        s->name, probe_found.operations * each, probe_found.fused * each, probe_found.whole * each,
        probe_found.divisions * each, probe_found.roots * each, probe_found.instructions * each,
        probe_found.loads * each, (probe_found.stores + probe_found.narrow) * each, bytes,
        probe_found.operations * each / bytes, ns, probe_found.operations * each / ns,
        limits[longest], names[longest], ns / limits[longest], ns / limits[beyond],
        probe_found.slots * each / (m->slots * ns));
    fflush(stdout);
}

#define FIELD(name, kernel, number, read, written)                                                 \
    {                                                                                              \
        name, &shadow->kernel, read, written, run_field, number                                    \
    }

static void say_machine(const struct roof_machine *m)
{
    printf("{\"machine\":\"one core\",\"instructions\":\"%s\",\"goperations_s\":%.1f,"
           "\"fused_goperations_s\":%.1f,\"gwhole_s\":%.1f,\"gslots_s\":%.2f,\"gdivisions_s\":%.2f,"
           "\"groots_s\":%.2f,\"gloads_s\":%.2f,\"gstores_s\":%.2f,\"gnarrow_s\":%.2f,\"l2_gb_s\":%"
           ".1f,"
           "\"l3_gb_s\":%.1f,\"memory_gb_s\":%.1f}\n",
           build_isa(), m->mul_add, m->fused, m->whole, m->slots, m->divisions, m->roots, m->loads,
           m->stores, m->narrow, m->bandwidth[ROOF_L2], m->bandwidth[ROOF_L3],
           m->bandwidth[ROOF_MEMORY]);
}

static void measure_all(void)
{
    const struct shadow_kernels *shadow = KERNELS_BEST(shadow_kernels);
    const struct indirect_kernels *in = KERNELS_BEST(indirect_kernels);
    const struct glossy_kernels *g = KERNELS_BEST(glossy_kernels);
    const struct lens_kernels *le = KERNELS_BEST(lens_kernels);
    const struct lens_light_kernels *li = KERNELS_BEST(lens_light_kernels);
    const struct v_plane_kernels *v = KERNELS_BEST(v_plane_kernels);
    enum { LINE = 16, POINT = 3, NORMAL = 3, WALK = 4, STRATUM = STRATA * STRATA, LIGHT = 3 };
    struct roof_machine m = {0};
    create_cases();
    const double nodes = shadow_nodes(&field.field), lanes = field.field.lanes,
                 cells = 4.0 * field.field.scale,
                 record = (double)v_plane_record_floats(&v_plane.field), rows = V_PLANE_CASE_ROWS;
    /* In numbers of four bytes; a line of memory has LINE; an index: one. */
    const struct subject subjects[] = {
        FIELD("unoccluded", unoccluded, KERNEL_UNOCCLUDED, POINT + NORMAL, 1),
        FIELD("place_receivers", place_receivers, KERNEL_PLACE_RECEIVERS, 1 + POINT + NORMAL,
              NORMAL + 2 + 3 + 2),
        FIELD("shear_receivers", shear_receivers, KERNEL_SHEAR_RECEIVERS, 3 + POINT + NORMAL + 1,
              2 + 2 * WALK + 2 + 1),
        FIELD("mark_walks", mark_walks, KERNEL_MARK_WALKS, 1 + WALK - 1, 0.25),
        FIELD("project_columns", project_columns, KERNEL_PROJECT_COLUMNS, 2 + STRATA + 3,
              nodes * lanes),
        FIELD("walk_columns", walk_columns, KERNEL_WALK_COLUMNS,
              1 + POINT + NORMAL + 5 + 3 + WALK + nodes * lanes, cells),
        FIELD("project_rows", project_rows, KERNEL_PROJECT_ROWS, 1 + 3 + cells, 2 * nodes),
        FIELD("walk_rows", walk_rows, KERNEL_WALK_ROWS,
              1 + POINT + NORMAL + 4 + 3 + WALK + 2 * nodes, 2),
        FIELD("blur x", blur, KERNEL_BLUR_X, POINT + NORMAL + 2 + 4, 1),
        FIELD("blur y", blur, KERNEL_BLUR_Y, POINT + NORMAL + 2 + 4, 1),
        FIELD("estimate", estimate, KERNEL_ESTIMATE, POINT + NORMAL + 2 + 1, 1),
        FIELD("filter_edges", filter_edges, KERNEL_FILTER_EDGES,
              2 + POINT + NORMAL + 2 + 3 + 3 + 1 + 2 + 1, 1),
        FIELD("sum_slopes", sum_slopes, KERNEL_SUM_SLOPES, 1 + POINT + NORMAL + 2 + 2, 3),
        /* point, normal, falloff, off, object, channels */
        {"mean x", &in->mean, POINT + NORMAL + 3 + LIGHT, LIGHT, run_indirect, INDIRECT_MEAN_X},
        {"mean y", &in->mean, POINT + NORMAL + 3 + LIGHT, LIGHT, run_indirect, INDIRECT_MEAN_Y},
        {"line x", &in->line, POINT + NORMAL + 3 + LIGHT, LIGHT, run_indirect, INDIRECT_LINE_X},
        {"line y", &in->line, POINT + NORMAL + 3 + LIGHT, LIGHT, run_indirect, INDIRECT_LINE_Y},
        {"nearness", &in->nearness, 2, 1, run_indirect, INDIRECT_NEARNESS},
        /* five vectors, sharpness, nearness, plane, object, channels */
        {"spread x", &g->spread, 19 + 4, 4, run_glossy, GLOSSY_SPREAD_X},
        {"spread y", &g->spread, 19 + 4, 4, run_glossy, GLOSSY_SPREAD_Y},
        {"lens, look", &le->gather, LENS_CELL_PLANES, LENS_GROUPS * LENS_SUMS, run_lens,
         LENS_GATHER},
        {"lens, add", &le->add, LENS_CASE_ARRAYS + LENS_CELL_SUMS, LENS_CELL_SUMS, run_lens,
         LENS_ADD},
        {"lens, add beyond", &le->add, LENS_CASE_ARRAYS + LENS_CELL_SUMS, LENS_CELL_SUMS, run_lens,
         LENS_ADD_BEYOND},
        /* where on the lens, seeds, slope, z, half a code; a place, a point, a normal */
        {"light, place", &li->place, 4 + 3 + 2 + 0.5, 6 + POINT + NORMAL, run_lens_light,
         LIT_LENS_PLACE},
        {"light, own", &li->own, 1, LIGHT, run_lens_light, LIT_LENS_OWN},
        {"light, add", &li->add, 3, 1, run_lens_light, LIT_LENS_ADD},
        {"light, most", &li->most, 1, 0, run_lens_light, LIT_LENS_MOST},
        {"v-plane strata", &v->strata, 2, 3 * STRATA, run_v_plane, V_PLANE_STRATA},
        {"v-plane slopes", &v->slopes, 3 * STRATA + 4 * STRATUM + LINE / 2, 2, run_v_plane,
         V_PLANE_SLOPES},
        {"v-plane average", &v->average, 1 + NORMAL + 2, 2, run_v_plane, V_PLANE_AVERAGE},
        {"v-plane records", &v->records, 3 * STRATA + 4 * STRATUM + 0.25, record, run_v_plane,
         V_PLANE_RECORDS},
        /* one row of outputs reads all rows around it */
        {"v-plane columns", &v->columns, 1 + rows * (LINE / 2 + record) + LINE / 2,
         V_PLANE_NODE_FLOATS, run_v_plane, V_PLANE_COLUMNS},
        {"v-plane rows", &v->rows, 1 + LINE + V_PLANE_NODE_FLOATS, 4, run_v_plane, V_PLANE_ROWS},
    };
    enum { COUNT = sizeof subjects / sizeof *subjects };
    struct found *found = field_memory(COUNT * sizeof *found);
    for (int i = 0; i < COUNT; i++)
        for (int k = 0; k < CALLS_MOST; k++) found[i].least[k] = 1e30;
    for (int round = 0; round < ROUNDS; round++) {
        roof_measure(build_isa(), &m);
        around.clock_ns = clock_itself();
        for (int i = 0; i < COUNT; i++) measure(&subjects[i], &found[i]);
    }
    say_machine(&m);
    for (int i = 0; i < COUNT; i++) say(&subjects[i], &found[i], &m);
    free(found);
}

int main(int argc, char **argv)
{
    const bool checks = argc == 2 && !strcmp(argv[1], "check");
    if (argc > 1 && !checks) {
        fprintf(stderr, "usage: bench_roofline [check]\n");
        return 2;
    }
    if (!probe_is_right(build_isa())) {
        fprintf(stderr, "bench_roofline: instructions are not counted as they are\n");
        return 1;
    }
    if (!checks) measure_all();
    return 0;
}
