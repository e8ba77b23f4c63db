/* Rounds of samples: on errors that fall as they are expected to, the target is reached with the
 * least cost; caps hold; passes are what the wire can carry. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "server/job/frame/rounds.h"
#include "tests/unit/server/reconstruct/synthetic_paths.h"
#include "tests/unit/unit.h"

#define TILES 64 /* of a picture of 256 x 256 in tiles of 32 */

/* A picture whose tiles err differently: squared errors of one sample, a pixel. */
struct world {
    struct plan plan;
    struct rounds *rounds;
    double paths[TILES], bounces[TILES]; /* of one sample */
    double fixed;
    double power; /* of samples, with which squared errors truly fall; 0: as rounds expect it */
    double luminance;
    uint32_t n[TILES][2]; /* paths and bounce rays so far */
    uint32_t passes[TILES], more[TILES];
    struct rounds_error errors[TILES];
};

static void begin(struct world *w, float target, uint32_t most)
{
    *w = (struct world){.luminance = 0.5};
    synthetic_target_plan(&w->plan, 256, 256, 32, target);
    w->plan.spp_max = most;
    assert_int_equal(rounds_create(&w->plan, &w->rounds), 0);
    for (uint32_t t = 0; t < TILES; t++) {
        w->n[t][0] = w->n[t][1] = 9;
        w->passes[t] = plan_pass_count(&w->plan);
        w->paths[t] = 0.001 * pow(1.17, t % 30);
        w->bounces[t] = t % 4 == 0 ? 0.002 : 0.00001;
    }
}

static void measure(struct world *w)
{
    for (uint32_t t = 0; t < TILES; t++) {
        const bool filtered = w->plan.residual_filter != RESIDUAL_FILTER_NONE;
        const double power = w->power > 0 ? w->power : filtered ? 2.0 / 3 : 1.0;
        w->errors[t].variance[ERROR_SOURCE_PATHS] = 1024 * w->paths[t] / pow(w->n[t][0], power);
        /* what bounce rays lower, of diffuse surfaces and of glossy lobes */
        const double square = 1024 * w->bounces[t] / pow(w->n[t][1], 2.0 / 3);
        w->errors[t].variance[ERROR_SOURCE_BOUNCES] = (t % 3) * 0.5 * square;
        w->errors[t].variance[ERROR_SOURCE_LOBES] = (1 - (t % 3) * 0.5) * square;
        w->errors[t].variance[ERROR_SOURCE_CENTRES] = 1024 * w->fixed;
        w->errors[t].luminance = 1024 * w->luminance;
    }
}

static double error_of(const struct world *w)
{
    double sum = 0;
    for (uint32_t t = 0; t < TILES; t++)
        for (int s = 0; s < ERROR_SOURCE_COUNT; s++) sum += w->errors[t].variance[s];
    return sqrt(sum / 65536) / w->luminance;
}

/* Traces what a round asks for, and checks that it can. */
static void trace(struct world *w)
{
    for (uint32_t t = 0; t < TILES; t++) {
        uint32_t paths = 0, bounces = 0;
        for (uint32_t p = 0; p < w->more[t]; p++) {
            const struct plan_pass pass = rounds_pass(w->rounds, t, w->passes[t] + p);
            assert_int_equal(pass.number, w->passes[t] + p);
            assert_int_equal(plan_pass_check(&w->plan, &pass), 0);
            if (pass.count > 0) assert_int_equal(pass.first, w->n[t][0] + paths);
            paths += pass.count;
            bounces += pass.strata * pass.strata;
        }
        assert_true(paths <= 3 * w->n[t][0] + w->n[t][0] / 4 + 4);
        assert_true(bounces <= 3 * w->n[t][1] + 64);
        w->n[t][0] += paths;
        w->n[t][1] += bounces;
        w->passes[t] += w->more[t];
        assert_true(w->n[t][0] <= w->plan.spp_max && w->n[t][1] <= w->plan.spp_max);
    }
}

static unsigned run(struct world *w)
{
    unsigned count = 1;
    for (measure(w); rounds_decide(w->rounds, w->errors, w->more); measure(w), count++) {
        assert_true(fabs(rounds_report(w->rounds).reached - error_of(w)) < 1e-9);
        trace(w);
        assert_true(count < 40);
    }
    assert_int_equal(rounds_report(w->rounds).rounds, count);
    return count;
}

static double samples_of(const struct world *w)
{
    double sum = 0;
    for (uint32_t t = 0; t < TILES; t++) sum += 1024.0 * (w->n[t][0] + w->n[t][1]);
    return sum;
}

/* As many samples of both kinds for all tiles as reach an error. */
static double uniform_samples(const struct world *w, double error)
{
    struct world u = *w;
    for (uint32_t n = 1;; n++) {
        for (uint32_t t = 0; t < TILES; t++) u.n[t][0] = u.n[t][1] = n;
        measure(&u);
        if (error_of(&u) <= error) return 65536.0 * 2 * n;
    }
}

TEST(targets_are_reached_at_less_cost)
{
    static const float targets[] = {0.06f, 0.03f, 0.02f};
    for (size_t k = 0; k < sizeof targets / sizeof targets[0]; k++) {
        struct world w;
        begin(&w, targets[k], 4096);
        assert_true(run(&w) <= 6);
        const struct rounds_report report = rounds_report(w.rounds);
        assert_true(report.met && report.reached <= (double)targets[k]);
        assert_true(report.reached > 0.9 * (double)targets[k]);
        assert_true((double)(report.paths + report.bounces) == samples_of(&w));
        assert_true(report.threshold > 0 && report.expected >= samples_of(&w));
        assert_true(samples_of(&w) < 0.8 * uniform_samples(&w, report.reached));
        rounds_destroy(&w.rounds);
        assert_null(w.rounds);
    }
}

/* A filter of paths gets narrower as samples come, and its error falls slower. */
TEST(filtered_paths_reach_their_target)
{
    static const float targets[] = {0.06f, 0.04f};
    for (size_t k = 0; k < sizeof targets / sizeof targets[0]; k++) {
        struct world w;
        begin(&w, targets[k], 4096);
        w.plan.residual_filter = RESIDUAL_FILTER_HALVES;
        assert_true(run(&w) <= 4 + k); /* one more if it were not */
        const struct rounds_report report = rounds_report(w.rounds);
        assert_true(report.met && report.reached > 0.9 * (double)targets[k]);
        assert_true(samples_of(&w) < 0.8 * uniform_samples(&w, report.reached));
        rounds_destroy(&w.rounds);
    }
}

TEST(what_gains_most_gets_most)
{
    struct world w;
    begin(&w, 0.02f, 4096);
    run(&w);
    assert_true(w.n[29][0] > 2 * w.n[1][0]);
    assert_true(w.n[4][1] > 2 * w.n[5][1]);
    assert_int_equal(w.n[5][1], 9); /* next to nothing to gain */
    rounds_destroy(&w.rounds);
}

TEST(caps_end_it)
{
    struct world w;
    begin(&w, 0.0001f, 100);
    run(&w);
    struct rounds_report report = rounds_report(w.rounds);
    assert_false(report.met);
    for (uint32_t t = 0; t < TILES; t++) {
        assert_int_equal(w.n[t][0], 100);
        assert_true(w.n[t][1] > 96); /* squares of even numbers */
    }
    rounds_destroy(&w.rounds);
    begin(&w, 0.02f, 64);
    w.fixed = 0.0004; /* 0.04 of what no sample lowers */
    run(&w);
    report = rounds_report(w.rounds);
    assert_true(!report.met && fabs(report.fixed - 0.04) < 1e-6 && w.n[3][0] == 64);
    rounds_destroy(&w.rounds);
}

/* Once the rest is small beside what no sample lowers, more of them are in vain. */
TEST(nothing_is_sampled_in_vain)
{
    struct world w;
    begin(&w, 0.02f, 65536);
    w.fixed = 0.0025; /* 0.1 */
    run(&w);
    const struct rounds_report report = rounds_report(w.rounds);
    assert_true(!report.met && report.fixed > 0.09 && report.reached < 1.2 * report.fixed);
    for (uint32_t t = 0; t < TILES; t++) assert_true(w.n[t][0] < 65536 && w.n[t][1] < 16384);
    rounds_destroy(&w.rounds);
}

/* A target that is out of reach costs no kind of samples their share. */
TEST(kinds_share_what_is_out_of_reach)
{
    static const uint32_t caps[] = {1024, 16384, 65536};
    struct world w;
    for (size_t i = 0; i < sizeof caps / sizeof *caps; i++) {
        begin(&w, 1e-4f, caps[i]);
        run(&w);
        for (uint32_t t = 0; t < TILES; t++)
            assert_true(w.n[t][0] > caps[i] / 2 &&
                        w.n[t][1] > (caps[i] < 16384 ? caps[i] : 16384) / 2);
        rounds_destroy(&w.rounds);
    }
}

TEST(what_is_met_costs_nothing)
{
    struct world w;
    begin(&w, 0.5f, 4096);
    measure(&w);
    assert_false(rounds_decide(w.rounds, w.errors, w.more));
    struct rounds_report report = rounds_report(w.rounds);
    assert_true(report.met && report.paths == 9 * 65536 && report.bounces == 9 * 65536);
    rounds_destroy(&w.rounds);
    begin(&w, 0.01f, 4096); /* a black picture has no error over its mean */
    w.luminance = 0;
    memset(w.paths, 0, sizeof w.paths);
    memset(w.bounces, 0, sizeof w.bounces);
    measure(&w);
    assert_false(rounds_decide(w.rounds, w.errors, w.more));
    assert_true(rounds_report(w.rounds).met);
    rounds_destroy(&w.rounds);
}

/* Errors that do not fall as expected: too good to be true, hopeless, or beyond all measure. */
TEST(odd_errors_end)
{
    static const double factors[] = {0.0, 1e-30, 1.0, 1e37};
    for (size_t k = 0; k < sizeof factors / sizeof factors[0]; k++) {
        struct world w;
        unsigned count = 0;
        begin(&w, 0.01f, 4096);
        measure(&w);
        for (uint32_t t = 0; t < TILES; t++) w.errors[t].variance[ERROR_SOURCE_PATHS] *= factors[k];
        while (rounds_decide(w.rounds, w.errors, w.more)) {
            trace(&w);
            assert_true(++count < 40);
        }
        rounds_destroy(&w.rounds);
    }
}

/* Returns what the first round foretells over what there is in the end. */
static double foretold(struct world *w)
{
    double due = 0.0;
    measure(w);
    const double before = samples_of(w);
    assert_true(rounds_decide(w->rounds, w->errors, w->more));
    const double expected = rounds_report(w->rounds).expected;
    for (uint32_t t = 0; t < TILES; t++) due += rounds_due(w->rounds, t);
    assert_true(fabs(due + before - expected) < 1e-6 * expected);
    trace(w);
    for (measure(w); rounds_decide(w->rounds, w->errors, w->more); measure(w)) trace(w);
    for (uint32_t t = 0; t < TILES; t++) assert_true(rounds_due(w->rounds, t) == 0.0);
    return expected / samples_of(w);
}

TEST(samples_to_come_are_foreseen_within_a_third)
{
    static const float targets[] = {0.06f, 0.04f, 0.03f, 0.02f};
    for (size_t k = 0; k < 4; k++) {
        struct world w;
        begin(&w, targets[k], 4096);
        const double ratio = foretold(&w);
        if (fabs(ratio - 1.0) > 1.0 / 3.0)
            fail_msg("%.2f times what %g took", ratio, (double)targets[k]);
        rounds_destroy(&w.rounds);
    }
}

/* Filtered errors fall with a power of each scene's own. What is foreseen after three rounds is
 * what a power as theirs takes. */
TEST(errors_tell_how_they_fall)
{
    static const double powers[] = {0.6, 0.8, 1.0, 1.2};
    for (size_t k = 0; k < 4; k++) {
        struct world w;
        double told = 0.0;
        begin(&w, 0.006f, 65536);
        w.plan.residual_filter = RESIDUAL_FILTER_HALVES;
        w.power = powers[k];
        for (uint32_t t = 0; t < TILES; t++) w.bounces[t] = 0.0;
        measure(&w);
        for (unsigned round = 1; rounds_decide(w.rounds, w.errors, w.more); round++) {
            if (round <= 4) told = rounds_report(w.rounds).expected;
            trace(&w);
            measure(&w);
        }
        const double ratio = told / samples_of(&w);
        if (fabs(ratio - 1.0) > 1.0 / 3.0)
            fail_msg("%.2f times what power %g took", ratio, w.power);
        rounds_destroy(&w.rounds);
    }
}

/* Shows some tiles' errors, each in two parts, before the round is over. */
static void see(struct world *w, uint32_t from, uint32_t step)
{
    measure(w);
    for (uint32_t t = from; t < TILES; t += step) {
        struct rounds_error half = w->errors[t];
        for (int s = 0; s < ERROR_SOURCE_COUNT; s++) half.variance[s] *= 0.5;
        half.luminance *= 0.5;
        rounds_see(w->rounds, t, &half, 512);
        rounds_see(w->rounds, t, &half, 512);
    }
    rounds_foresee(w->rounds);
}

/* The same when the first round has brought half of the picture, which tells of the rest. */
TEST(half_a_picture_foresees)
{
    static const float targets[] = {0.06f, 0.04f, 0.03f};
    for (size_t k = 0; k < 3; k++) {
        struct world w;
        begin(&w, targets[k], 4096);
        see(&w, 0, 2);
        const double told = rounds_report(w.rounds).expected;
        while (rounds_decide(w.rounds, w.errors, w.more)) {
            trace(&w);
            measure(&w);
        }
        const double ratio = told / samples_of(&w);
        if (fabs(ratio - 1.0) > 1.0 / 3.0)
            fail_msg("%.2f times what %g took", ratio, (double)targets[k]);
        rounds_destroy(&w.rounds);
    }
}

/* Errors that the second round finds four times as high raise what is foreseen at once. */
TEST(a_round_tells_before_its_end)
{
    struct world w;
    begin(&w, 0.01f, 65536);
    measure(&w);
    assert_true(rounds_decide(w.rounds, w.errors, w.more));
    const double told = rounds_report(w.rounds).expected;
    trace(&w);
    for (uint32_t t = 0; t < TILES; t++) w.paths[t] *= 4.0;
    see(&w, 0, 2);
    const double better = rounds_report(w.rounds).expected;
    while (rounds_decide(w.rounds, w.errors, w.more)) {
        trace(&w);
        measure(&w);
    }
    assert_true(told < 0.5 * samples_of(&w));
    assert_true(fabs(better / samples_of(&w) - 1.0) < 1.0 / 3.0);
    rounds_destroy(&w.rounds);
}

/* Returns how far what is foreseen goes up when tiles are glanced at that seem to err `by` times as
 * much as they do. */
static double misled(struct world *w, double by)
{
    const double before = rounds_report(w->rounds).expected;
    for (uint32_t t = 0; t < TILES; t += 4) {
        struct rounds_error error = w->errors[t];
        for (int s = 0; s < ERROR_SOURCE_COUNT; s++) error.variance[s] *= by;
        rounds_glance(w->rounds, t, &error);
    }
    rounds_foresee(w->rounds);
    return rounds_report(w->rounds).expected / before;
}

/* Estimates that are too high mislead in one round, and no more in the next. */
TEST(estimates_are_put_right)
{
    struct world w;
    double by[2];
    begin(&w, 0.005f, 65536);
    measure(&w);
    assert_true(rounds_decide(w.rounds, w.errors, w.more));
    for (int k = 0; k < 2; k++) {
        trace(&w);
        measure(&w);
        by[k] = misled(&w, 2.0);
        assert_true(rounds_decide(w.rounds, w.errors, w.more));
    }
    if (!(by[0] > 1.3 && fabs(by[1] - 1.0) < 0.15)) fail_msg("%.2f, then %.2f", by[0], by[1]);
    rounds_destroy(&w.rounds);
}

/* A picture of many tiles, whose even columns alone are noisy: all are seen, though few play. */
TEST(no_column_is_overlooked)
{
    enum { SIDE = 64, MANY = SIDE * SIDE };
    struct plan plan;
    struct rounds *rounds = NULL;
    struct rounds_error *errors = calloc(MANY, sizeof *errors);
    uint32_t *more = calloc(MANY, sizeof *more);
    double told[2];
    for (uint32_t odd = 0; odd < 2; odd++) {
        synthetic_target_plan(&plan, SIDE * 16, SIDE * 16, 16, 0.05f);
        plan.spp_max = 4096;
        assert_int_equal(rounds_create(&plan, &rounds), 0);
        for (uint32_t t = 0; t < MANY; t++)
            errors[t] = (struct rounds_error){
                .variance[ERROR_SOURCE_PATHS] = t % 2 == odd ? 10.0 : 0.01, .luminance = 128.0};
        assert_true(rounds_decide(rounds, errors, more));
        told[odd] = rounds_report(rounds).expected;
        rounds_destroy(&rounds);
    }
    assert_true(fabs(told[0] / told[1] - 1.0) < 0.1);
    free(errors);
    free(more);
}

TEST(the_schedule_stands)
{
    struct world w;
    begin(&w, 0.02f, 4096);
    const struct plan_pass pass = rounds_pass(w.rounds, 7, 0);
    assert_int_equal(pass.count, 9);
    assert_int_equal(pass.strata, 3);
    assert_int_equal(plan_pass_check(&w.plan, &pass), 0);
    rounds_destroy(&w.rounds);
    w.plan.tile_px = 3;
    assert_int_equal(rounds_create(&w.plan, &w.rounds), ERR_RANGE);
    assert_null(w.rounds);
}
