/* Where samples of the lens lie is what points of the pattern say of many pixels. */
#include <math.h>

#include "server/reconstruct/lens/lens_span.h"
#include "tests/unit/unit.h"

#define STEPS  4096 /* jitters across, both ends among them */
#define BEYOND 0.003f
#define NEARBY 0.1f /* so near to a span's end some point comes */
#define L_MAX  5
#define TURNS  7

/* Spans that this jitter across makes of one line of the lens: points on it go straight from one
 * end of their stratum to the other. */
static void widen(const struct lens_aperture *a, uint32_t l, uint32_t i, float across,
                  struct lens_span *spans)
{
    float height, left, length;
    lens_aperture_lines(a, l, i, 1, &across, &height, &left, &length);
    for (uint32_t k = 0; k < l; k++) {
        struct lens_span *s = &spans[i * l + k];
        s->low[1] = fminf(s->low[1], height);
        s->high[1] = fmaxf(s->high[1], height);
        s->low[0] = fminf(s->low[0], left + length * ((float)k / (float)l));
        s->high[0] = fmaxf(s->high[0], left + length * ((float)(k + 1) / (float)l));
    }
}

static void check_axis(float low, float high, float met_low, float met_high)
{
    if (met_low < low - BEYOND || met_high > high + BEYOND)
        fail_msg("%g .. %g is not within %g .. %g", (double)met_low, (double)met_high, (double)low,
                 (double)high);
    if (met_low > low + NEARBY || met_high < high - NEARBY)
        fail_msg("%g .. %g is far within %g .. %g", (double)met_low, (double)met_high, (double)low,
                 (double)high);
}

static void check(const struct plan_camera *camera, uint32_t l)
{
    struct lens_span spans[L_MAX * L_MAX], met[L_MAX * L_MAX];
    struct lens_aperture aperture;
    lens_aperture_init(camera, &aperture);
    lens_spans(&aperture, l, spans);
    for (uint32_t j = 0; j < l * l; j++)
        met[j] = (struct lens_span){{INFINITY, INFINITY}, {-INFINITY, -INFINITY}};
    for (uint32_t i = 0; i < l; i++)
        for (int step = 0; step < STEPS; step++)
            widen(&aperture, l, i, (float)step / (STEPS - 1), met);
    for (uint32_t j = 0; j < l * l; j++)
        for (int axis = 0; axis < 2; axis++)
            check_axis(spans[j].low[axis], spans[j].high[axis], met[j].low[axis],
                       met[j].high[axis]);
}

TEST(spans_hold_all_points)
{
    static const uint32_t blades[] = {0, 3, 4, 5, 6, 9, LIMIT_LENS_BLADES};
    for (size_t b = 0; b < sizeof blades / sizeof *blades; b++)
        for (int turn = 0; turn < TURNS; turn++)
            for (uint32_t l = 1; l <= L_MAX; l++)
                check(&(struct plan_camera){.blade_count = blades[b],
                                            .blade_rotation_rad = 0.3f * (float)turn},
                      l);
}
