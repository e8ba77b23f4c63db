#include "server/reconstruct/lens/lens_span.h"

#define EDGES (LIMIT_LENS_BLADES + 3)

/* Heights between which nothing bends: of a disc its middle, of blades their corners. */
static uint32_t find_heights(const struct lens_aperture *a, float low, float high, float out[EDGES])
{
    uint32_t n = 0;
    out[n++] = low;
    out[n++] = high;
    if (a->bands == 0 && low < 0.0f && high > 0.0f) out[n++] = 0.0f;
    for (uint32_t b = 0; a->bands > 0 && b <= a->bands; b++)
        if (a->height[b] > low && a->height[b] < high) out[n++] = a->height[b];
    return n;
}

static void widen(struct lens_span *span, float u)
{
    span->low[0] = u < span->low[0] ? u : span->low[0];
    span->high[0] = u > span->high[0] ? u : span->high[0];
}

/* Points are farthest to a side where a stratum and a stretch between two heights end: between them
 * the chord's ends are straight, or as a disc's move both to one side. */
void lens_spans(const struct lens_aperture *a, uint32_t l, struct lens_span *spans)
{
    for (uint32_t j = 0; j < l * l; j++) {
        const uint32_t from_top = j / l;
        const float row = (float)from_top, column = (float)(j % l), inverse = 1.0f / (float)l;
        const float low = lens_aperture_height(a, row * inverse);
        const float high = lens_aperture_height(a, (row + 1.0f) * inverse);
        float heights[EDGES];
        const uint32_t n = find_heights(a, low, high, heights);
        spans[j] = (struct lens_span){{2.0f, low}, {-2.0f, high}}; /* wider than any lens */
        for (uint32_t k = 0; k < n; k++) {
            float left, right;
            lens_aperture_chord(a, heights[k], &left, &right);
            widen(&spans[j], left + (right - left) * column * inverse);
            widen(&spans[j], left + (right - left) * (column + 1.0f) * inverse);
        }
    }
}
