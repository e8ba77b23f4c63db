#include "server/reconstruct/glossy/glossy_variance.h"

#include <math.h>

#define RATIO      0.5f /* of the widths of F' to those of F */
#define WEIGHT_MIN 1e-6f
#define SQUARE_MAX 1e36f /* so that sums stay finite */

static struct glossy_pass smoothing(const struct plan *plan, const struct patch *patch)
{
    return (struct glossy_pass){.plan = plan, .patch = patch, .width = 1.0f, .smooth = true};
}

int32_t glossy_variance_reach(const struct plan *plan)
{
    const struct glossy_pass pass = smoothing(plan, NULL);
    return glossy_pass_reach(&pass);
}

/* Mean radiance of channel c of four, from light and weights. */
static float quotient(float *const *channels, uint32_t c, size_t i)
{
    const float weight = channels[3][i];
    return weight >= WEIGHT_MIN ? channels[c][i] / weight : 0.0f;
}

static float bounded(float v)
{
    return fmaxf(fminf(v, SQUARE_MAX), -SQUARE_MAX);
}

/* Noise, and what F and F' differ by beyond their noise, both squared, into `between`. */
static void square_filtered(const struct glossy_neighbourhood *p, uint32_t c, size_t i)
{
    float *const *narrow = p->channel, *const *wide = p->wide;
    const float mean = quotient(wide, c, i), narrow_mean = quotient(narrow, c, i);
    const float off = quotient(wide + GLOSSY_CHANNELS, c, i) - mean;
    const float narrow_off = quotient(narrow + GLOSSY_CHANNELS, c, i) - narrow_mean;
    const float step = mean - narrow_mean, step_noise = off - narrow_off;
    p->between[c][i] = bounded(off * off);
    p->between[3 + c][i] = bounded(step * step - step_noise * step_noise);
}

/* The plain average leaves weights aside. */
static void square_measured(const struct glossy_neighbourhood *p, uint32_t c, size_t i)
{
    const float off = p->channel[GLOSSY_CHANNELS + c][i] - p->channel[c][i];
    p->between[c][i] = bounded(off * off);
    p->between[3 + c][i] = 0.0f;
}

static void square(const struct glossy_variance *s, struct rect wide)
{
    for (int32_t y = wide.y0; y < wide.y1; y++) {
        const size_t first = glossy_neighbourhood_index(s->around, wide.x0, y);
        for (size_t i = first; i < first + (size_t)rect_width(wide); i++)
            for (uint32_t c = 0; c < 3; c++)
                if (s->filtered)
                    square_filtered(s->around, c, i);
                else
                    square_measured(s->around, c, i);
    }
}

static void store(const struct glossy_variance *s, struct rect rect, float *const variance[3])
{
    const float left = 1.0f - RATIO * RATIO, factor = 1.0f / (left * left);
    float *const *from = s->around->between;
    for (int32_t y = rect.y0; y < rect.y1; y++) {
        const size_t at = glossy_neighbourhood_index(s->around, rect.x0, y);
        const size_t to = patch_pixel(s->patch, rect.x0, y);
        for (size_t i = 0; i < (size_t)rect_width(rect); i++) {
            if (!s->around->object[at + i]) continue;
            for (uint32_t c = 0; c < 3; c++)
                variance[c][to + i] = from[c][at + i] + factor * fmaxf(from[3 + c][at + i], 0.0f);
        }
    }
}

void glossy_variance_find(const struct glossy_variance *s, struct rect wide, struct rect rect,
                          float *const variance[3])
{
    struct glossy_neighbourhood *p = s->around;
    const struct glossy_pass narrower = {.plan = s->plan, .patch = s->patch, .width = RATIO};
    const struct glossy_pass smooth = smoothing(s->plan, s->patch);
    if (s->filtered)
        glossy_pass_run(&narrower, p, wide, GLOSSY_MEASURED, p->channel, p->between, p->channel);
    square(s, wide);
    glossy_pass_run(&smooth, p, rect, 6, p->between, p->channel, p->between);
    store(s, rect, variance);
}
