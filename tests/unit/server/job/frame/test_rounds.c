/* Rounds of samples: on errors that fall as they are expected to, the target is reached with the
 * least cost; caps hold; passes are what the wire can carry. */
#include "tests/unit/server/job/frame/rounds_case.h"

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
        assert_true(report.threshold > 0 && report.expected[FORESEEN_LIKELY] >= samples_of(&w));
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
