/* What rounds foretell of the samples to come, before and within a round. */
#include "tests/unit/server/job/frame/rounds_case.h"

#define ROUNDS_TOLD 32

/* Returns what the first round foretells over what there is in the end. */
static double foretold(struct world *w)
{
    double due = 0.0;
    measure(w);
    const double before = samples_of(w);
    assert_true(rounds_decide(w->rounds, w->errors, w->more));
    const double expected = rounds_report(w->rounds).expected[FORESEEN_LIKELY];
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
            if (round <= 4) told = rounds_report(w.rounds).expected[FORESEEN_LIKELY];
            trace(&w);
            measure(&w);
        }
        const double ratio = told / samples_of(&w);
        if (fabs(ratio - 1.0) > 1.0 / 3.0)
            fail_msg("%.2f times what power %g took", ratio, w.power);
        rounds_destroy(&w.rounds);
    }
}

/* Whatever power errors fall with, of those that were seen under the filter, the range has what
 * their samples come to from the first round on, and closes around it. */
TEST(the_range_has_what_comes)
{
    static const double powers[] = {0.55, 0.7, 0.9, 1.05};
    for (size_t k = 0; k < 4; k++) {
        struct world w;
        struct rounds_report told[ROUNDS_TOLD];
        unsigned count = 0;
        begin(&w, 0.006f, 65536);
        w.plan.residual_filter = RESIDUAL_FILTER_HALVES;
        w.power = powers[k];
        for (uint32_t t = 0; t < TILES; t++) w.bounces[t] = 0.0;
        for (measure(&w); rounds_decide(w.rounds, w.errors, w.more); measure(&w)) {
            if (count < ROUNDS_TOLD) told[count++] = rounds_report(w.rounds);
            trace(&w);
        }
        assert_true(count > 3);
        for (unsigned i = 0; i < count; i++) {
            const double *expected = told[i].expected, all = samples_of(&w);
            if (!(expected[FORESEEN_LEAST] <= 1.01 * all && 0.99 * all <= expected[FORESEEN_MOST]))
                fail_msg("power %g, round %u: %.2f to %.2f of what it took", w.power, i,
                         expected[FORESEEN_LEAST] / all, expected[FORESEEN_MOST] / all);
        }
        const double *first = told[0].expected, *last = told[count - 1].expected;
        assert_true(first[FORESEEN_MOST] > 2.0 * first[FORESEEN_LEAST]);
        assert_true(last[FORESEEN_MOST] < 1.3 * last[FORESEEN_LEAST]);
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
        const double told = rounds_report(w.rounds).expected[FORESEEN_LIKELY];
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

/* Blocks are drawn from the top, where errors are great here: a few glances elsewhere tell more of
 * the rest than they do. */
TEST(the_first_blocks_do_not_stand_for_all)
{
    struct world w;
    begin(&w, 0.04f, 4096);
    for (uint32_t t = 0; t < TILES / 4; t++) w.paths[t] *= 32.0;
    measure(&w);
    for (uint32_t t = 3; t < TILES; t += 7) rounds_glance(w.rounds, t, &w.errors[t]);
    for (uint32_t t = 0; t < TILES / 4; t++) rounds_see(w.rounds, t, &w.errors[t], 1024);
    rounds_foresee(w.rounds);
    const double told = rounds_report(w.rounds).expected[FORESEEN_LIKELY];
    while (rounds_decide(w.rounds, w.errors, w.more)) {
        trace(&w);
        measure(&w);
    }
    const double ratio = told / samples_of(&w);
    if (fabs(ratio - 1.0) > 1.0 / 3.0) fail_msg("%.2f times what it took", ratio);
    rounds_destroy(&w.rounds);
}

/* Errors that the second round finds four times as high raise what is foreseen at once. */
TEST(a_round_tells_before_its_end)
{
    struct world w;
    begin(&w, 0.01f, 65536);
    measure(&w);
    assert_true(rounds_decide(w.rounds, w.errors, w.more));
    const double told = rounds_report(w.rounds).expected[FORESEEN_LIKELY];
    trace(&w);
    for (uint32_t t = 0; t < TILES; t++) w.paths[t] *= 4.0;
    see(&w, 0, 2);
    const double better = rounds_report(w.rounds).expected[FORESEEN_LIKELY];
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
    const double before = rounds_report(w->rounds).expected[FORESEEN_LIKELY];
    for (uint32_t t = 0; t < TILES; t += 4) {
        struct rounds_error error = w->errors[t];
        for (int s = 0; s < ERROR_SOURCE_COUNT; s++) error.variance[s] *= by;
        rounds_glance(w->rounds, t, &error);
    }
    rounds_foresee(w->rounds);
    return rounds_report(w->rounds).expected[FORESEEN_LIKELY] / before;
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
        told[odd] = rounds_report(rounds).expected[FORESEEN_LIKELY];
        rounds_destroy(&rounds);
    }
    assert_true(fabs(told[0] / told[1] - 1.0) < 0.1);
    free(errors);
    free(more);
}
