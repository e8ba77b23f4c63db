/* Light that changes from frame to frame leaves no ghosts, and errors know of the window. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/unit/server/reconstruct/residual/residual_frames.h"

/* RMS of what differs from a number, in the red of what is filtered. */
static double rms_from(const struct residual_picture *p, double truth)
{
    double sum = 0;
    const size_t area = (size_t)rect_area(p->block);
    for (size_t i = 0; i < area; i++) sum += pow((double)p->radiance[0][i] - truth, 2);
    return sqrt(sum / (double)area);
}

/* Its edge lies at column 40 in frame 0 and goes right by 3 pixels a frame. `level` is what light
 * it leaves; between both, lamps with area are half hidden over so many pixels. */
#define EDGE  40
#define SPEED 3
static float penumbra_px;
static float lit(const struct residual_scene *s, int32_t x)
{
    const float from_edge = (float)(x - (EDGE + SPEED * s->frame)) + 0.5f;
    const float share = 0.5f + from_edge / (penumbra_px + 1e-3f);
    return s->level + (1.0f - s->level) * fminf(fmaxf(share, 0.0f), 1.0f);
}
static void show_shadow(const struct residual_scene *s, int32_t x, int32_t y, uint32_t sample,
                        struct residual_sample *out)
{
    residual_grey(lit(s, x) * (0.5f + 0.5f * window_noise(s, x, y, sample, 1)), out->direct);
}

/* The error that the picture tells, and what it is off by, in the mean of each column. */
struct columns {
    double off[WINDOW_WIDTH], error[WINDOW_WIDTH];
};

/* What a mean of four samples of red has for a variance. */
static void set_plain(const struct residual_scene *s, float *const variance[3])
{
    for (int32_t y = 0; y < WINDOW_HEIGHT; y++)
        for (int32_t x = 0; x < WINDOW_WIDTH; x++)
            for (int c = 0; c < 3; c++)
                variance[c][y * WINDOW_WIDTH + x] = powf(0.25f * lit(s, x), 2) / 4.0f;
}

static void measure_columns(struct window *w, struct columns *out)
{
    float *variance = malloc(3 * WINDOW_AREA * sizeof *variance);
    assert_non_null(variance);
    float *const planes[3] = {variance, variance + WINDOW_AREA, variance + 2 * WINDOW_AREA};
    const struct residual_variance known = {window_rect, planes};
    set_plain(&w->scene, planes);
    window_open(w);
    struct residual_picture p = window_filter(w, window_rect, &known);
    for (int32_t x = 0; x < WINDOW_WIDTH; x++) {
        out->off[x] = out->error[x] = 0;
        for (int32_t y = 0; y < WINDOW_HEIGHT; y++) {
            const size_t i = residual_picture_at(&p, x, y);
            out->off[x] += (double)(p.radiance[0][i] - 0.5f * lit(&w->scene, x)) / WINDOW_HEIGHT;
            out->error[x] += (double)variance[i] / WINDOW_HEIGHT;
        }
        out->error[x] = sqrt(out->error[x]);
    }
    residual_picture_fini(&p);
    window_close(w);
    free(variance);
}

/* In no column does the window move the picture by two of the standard errors that it tells; and
 * away from the edge it pays. */
static void check_ghost(float level)
{
    struct columns alone, joined;
    struct window w = window_of(show_shadow);
    double away[2] = {0, 0}, most = 0;
    w.scene.level = level;
    measure_columns(&w, &joined);
    w.first = w.last = 0;
    measure_columns(&w, &alone);
    for (int32_t x = 0; x < WINDOW_WIDTH; x++) {
        const double ghost = fabs(joined.off[x] - alone.off[x]);
        if (ghost > 2 * joined.error[x] + 1e-6)
            fail_msg("light %g, column %d: %g by the window, %g without it, error %g",
                     (double)level, x, joined.off[x], alone.off[x], joined.error[x]);
        if (joined.error[x] > 0 && ghost / joined.error[x] > most) most = ghost / joined.error[x];
        if (x <= EDGE + 20) continue;
        away[0] += alone.off[x] * alone.off[x], away[1] += joined.off[x] * joined.off[x];
    }
    printf("# light %g, penumbra %g px: at most %.2f errors\n", (double)level, (double)penumbra_px,
           most);
    assert_true(away[1] < away[0]);
}

/* In frame 0, 6 columns on both sides of the edge were, or will be, on its other side in another
 * frame of the window. */
TEST(no_ghost_follows_a_shadow)
{
    static const float levels[] = {0.0f, 0.3f, 0.8f, 0.95f};
    penumbra_px = 0;
    for (int k = 0; k < 4; k++) check_ghost(levels[k]);
}

TEST(no_ghost_follows_a_soft_shadow)
{
    static const float levels[] = {0.0f, 0.3f, 0.8f, 0.95f}, widths_px[] = {4, 10, 24};
    for (int k = 0; k < 12; k++) {
        penumbra_px = widths_px[k / 4];
        check_ghost(levels[k % 4]);
    }
}

/* The standard error that a picture tells is that of its window. */
TEST(errors_know_the_window)
{
    struct window w = window_of(window_show_flat);
    double told[2], true_error[2];
    for (int k = 0; k < 2; k++) {
        w.first = k ? -2 : 0, w.last = k ? 2 : 0;
        window_open(&w);
        float *variance = malloc(3 * WINDOW_AREA * sizeof *variance);
        assert_non_null(variance);
        float *const planes[3] = {variance, variance + WINDOW_AREA, variance + 2 * WINDOW_AREA};
        for (size_t i = 0; i < 3 * WINDOW_AREA; i++) variance[i] = (0.25f + 0.0625f + 0.01f) / 4.0f;
        const struct residual_variance known = {window_rect, planes};
        struct residual_picture p = window_filter(&w, window_rect, &known);
        told[k] = 0;
        for (size_t i = 0; i < WINDOW_AREA; i++) told[k] += (double)variance[i] / (WINDOW_AREA);
        told[k] = sqrt(told[k]);
        true_error[k] = rms_from(&p, 0.85);
        residual_picture_fini(&p);
        free(variance);
        window_close(&w);
    }
    printf("# alone told %.4f, true %.4f; in the window %.4f, %.4f\n", told[0], true_error[0],
           told[1], true_error[1]);
    assert_true(told[1] < 0.75 * told[0]);
    assert_true(told[1] > 0.7 * true_error[1] && told[1] < 2.5 * true_error[1]);
}
