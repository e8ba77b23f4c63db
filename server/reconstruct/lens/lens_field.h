#pragma once
/* The state of the sheared filter of lens samples: where samples lie, and what each filtered pixel
 * has gathered from the layers so far. */
#include "server/reconstruct/lens/lens_layer.h"
#include "server/reconstruct/lens/lens_shape.h"
#include "server/reconstruct/lens/lens_span.h"
#include "server/reconstruct/patch/patch.h"

#define LENS_SEGMENT 32 /* pixels of a row that are looked through together */

struct lens_field {
    const struct plan *plan;
    const struct patch *patch;
    const struct lens_kernels *kernels;
    struct lens_pattern pattern;
    struct lens_shape shape;
    uint32_t l;
    struct rect wide; /* filtered */
    struct rect seen; /* whose samples are read, which slopes tell */

    /* For `seen`: the jitter along lines, and the height, left end and length of each of l lines.
     */
    float *along, *height, *left, *chord;
    struct lens_span *spans; /* of each sample: where all pixels' lie on the lens */
    struct rect known;       /* whose layers are known: `seen` and more */
    uint32_t *present;       /* bits of layers; of each row, sample and segment of `known` */
    uint32_t *any;           /* of each row and segment: those of all samples */
    uint32_t segments;       /* of a row: LENS_SEGMENT pixels each */
    uint32_t all;            /* bits of the layers of `seen` */
    /* For the current layer: sums of pixels' slopes in it, their number, and the slope by which
     * others pass. They cover a row, or `seen`. */
    float *slopes, *count, *pass;
    uint32_t *row; /* numbers of a row of `seen` */

    /* For `wide`: what the layers so far have brought (enum lens_view). */
    union {
        float *view[LENS_VIEWS];
        struct {
            float *through[LENS_GROUPS], *light[LENS_LIGHTS], *share, *spread;
        };
    };
    void *memory;
};

/* Return the index of an image pixel in arrays of `seen` and of `wide`. */
static inline size_t lens_seen(const struct lens_field *f, int32_t x, int32_t y)
{
    return (size_t)(y - f->seen.y0) * (size_t)rect_width(f->seen) + (size_t)(x - f->seen.x0);
}
static inline size_t lens_wide(const struct lens_field *f, int32_t x, int32_t y)
{
    return (size_t)(y - f->wide.y0) * (size_t)rect_width(f->wide) + (size_t)(x - f->wide.x0);
}

/* Return the segment that column x lies in, and the first column of a segment. */
static inline uint32_t lens_segment(const struct lens_field *f, int32_t x)
{
    return (uint32_t)(x - f->known.x0) / LENS_SEGMENT;
}
static inline int32_t lens_segment_x(const struct lens_field *f, uint32_t segment)
{
    return f->known.x0 + (int32_t)segment * LENS_SEGMENT;
}

/* Return the layers of a sample in the segments of row y, and those of all samples. */
static inline const uint32_t *lens_present(const struct lens_field *f, uint32_t sample, int32_t y)
{
    const uint32_t row = (uint32_t)(y - f->known.y0);
    return f->present + (size_t)(row * f->l * f->l + sample) * f->segments;
}
static inline const uint32_t *lens_any(const struct lens_field *f, int32_t y)
{
    return f->any + (size_t)(y - f->known.y0) * f->segments;
}

/* Return samples of a row of the patch from column x on. */
static inline const float *lens_slopes(const struct lens_field *f, uint32_t sample, int32_t x,
                                       int32_t y)
{
    const size_t area = (size_t)rect_area(f->patch->rect);
    return f->patch->lens_slope + sample * area + patch_pixel(f->patch, x, y);
}
static inline const float *lens_sample_light(const struct lens_field *f, uint32_t sample,
                                             uint32_t channel, int32_t x, int32_t y)
{
    const size_t area = (size_t)rect_area(f->patch->rect);
    return f->patch->lens_radiance + (sample * 3 + channel) * area + patch_pixel(f->patch, x, y);
}

/* Creates the field. `seen` is an upper bound. ERR_MEMORY; fini must be called even then. */
int lens_field_create(const struct plan *plan, const struct patch *patch, struct rect wide,
                      struct rect seen, struct lens_field *out);
void lens_field_fini(struct lens_field *f);

/* Returns log2 of a cell's side in pixels, in a layer of slopes up to `most`. At few samples the
 * side is a fourth to an eighth of the slope; it is half a pixel at least. */
int32_t lens_cell_level(float most, uint32_t l);

/* Returns the slopes of a layer: from `low`, below `high`. */
void lens_layer_slopes(uint32_t layer, float *low, float *high);
