#pragma once
/* What the residual filter reads and writes: features and light of a block's surroundings as padded
 * planes, so that no tap needs to ask where the picture ends. */
#include "server/reconstruct/patch/patch.h"

/* Columns and rows that a kernel works on at a time. */
#define RESIDUAL_TILE_X 64
#define RESIDUAL_TILE_Y 32

/* Around the pixels: the farthest tap and its patch. Borders repeat there. */
#define RESIDUAL_PAD_PX 24

/* Components of light, filtered apart: they have different features and different noise. */
enum residual_component {
    RESIDUAL_DIRECT = 0,   /* direct light of the diffuse lobe, before albedo */
    RESIDUAL_INDIRECT = 1, /* indirect light of that lobe, before albedo */
    RESIDUAL_REST = 2,     /* all that was scattered less albedo times the two; signed */
    RESIDUAL_COMPONENTS = 3
};

/* Light above counts as much to guides: squares of differences stay finite. */
#define RESIDUAL_GUIDE_MAX 1e15f

/* Channels of a guide have weights of their own, or pure colours of one brightness would be alike.
 */
#define RESIDUAL_GUIDE_RED   0.8f
#define RESIDUAL_GUIDE_GREEN 1.3f
#define RESIDUAL_GUIDE_BLUE  0.9f

/* Returns what weights look at of a colour. */
static inline float residual_guide(float red, float green, float blue)
{
    const float sum =
        RESIDUAL_GUIDE_RED * red + RESIDUAL_GUIDE_GREEN * green + RESIDUAL_GUIDE_BLUE * blue;
    return sum < RESIDUAL_GUIDE_MAX ? (sum > -RESIDUAL_GUIDE_MAX ? sum : -RESIDUAL_GUIDE_MAX)
                                    : RESIDUAL_GUIDE_MAX;
}

/* Planes of `plane` floats each, `stride` floats a row. Pixel (0, 0) of the patch is at `origin`.
 */
struct residual_shape {
    int32_t width, height; /* of the patch */
    size_t stride, plane, origin;
};

/* Means over the pixel's samples. */
struct residual_features {
    struct residual_shape shape;
    float pixel_rad;          /* the patch's */
    float *normal;            /* 3 planes */
    float *nearness;          /* residual_nearness of what is seen; 0: no surface */
    float *slope_x, *slope_y; /* of nearness, per pixel: the smaller of both sides' */
    float *albedo;            /* 3 planes */
    float *barred;            /* 0, or more than any weight survives: no surface */
    float *tint;              /* 3 planes: what the rest is divided by */
    float *alpha;             /* roughness of lobes */
    float *gloss;             /* root of how much more normals count for the rest */
    float *share;             /* of the pixel's samples that are in half a */
};

/* Returns what of a distance is linear over planes, or nearly, in the picture: 1 / distance, or the
 * distance itself if the camera is orthographic. It is its own inverse. */
static inline float residual_nearness(const struct residual_features *f, float distance)
{
    return f->pixel_rad > 0.0f ? 1.0f / distance : distance;
}

/* Probes that go through the passes beside the light (residual_probe.h): those with signs of their
 * own, and one that joins them in the last pass. */
#define RESIDUAL_SIGNED 4
#define RESIDUAL_PROBES (RESIDUAL_SIGNED + 1)

struct residual_light {
    float *half[2]; /* 3 planes each: what half a and half b of the samples bring, in the mean */
    float *filtered[2]; /* the same of a pass's output */
    float *guide[2];    /* weighted sum over rgb of what the weights look at; twice the same but in
                           pass 1 */
    float *variance;    /* of a guide */
    float *knee;        /* above it guides grow more slowly than light; NULL: nowhere */
    float *probe[2];    /* RESIDUAL_PROBES planes each: what half a and half b have in the mean's
                           error; after the first pass [0] has all. NULL: not wanted */
    float *probed[2];   /* the same of a pass's output */
};

struct residual_field {
    struct residual_features features;
    struct residual_light light[RESIDUAL_COMPONENTS];
    /* Of fields with samples of other frames (residual_window.h), else NULL: */
    float *joined;  /* 3 planes: what is scattered in the mean of all samples */
    float *own;     /* the part that the frame's samples have in that mean, 0 .. 1 */
    float *spread;  /* what deviations of joined halves are multiplied by for those of pixels that
                       know nothing of each other: neighbours share what lies between them */
    uint8_t *still; /* of the patch's pixels, frame by frame: whether nothing has moved there */
    void *joining;  /* owned; their memory */
    struct scratch *scratch; /* borrowed */
    void *memory;            /* owned; taken from there */
};

/* Reads the patch, whose plan has the planes of the residual filter, with the samples of its
 * window. ERR_MEMORY; the field must be freed then, too. */
int residual_field_create(const struct patch *patch, struct residual_field *out);

/* Reads what each pixel says for itself: features that are not smoothed, without slopes, and light,
 * of which the rest is all that is scattered. Nothing is set around the pixels. ERR_MEMORY, the
 * same. */
int residual_field_read(const struct patch *patch, struct residual_field *out);

void residual_field_fini(struct residual_field *field);

/* Returns where pixel (x, y) of the patch is, also for pixels in the padding. */
static inline size_t residual_at(const struct residual_shape *s, int32_t x, int32_t y)
{
    return (size_t)((ptrdiff_t)s->origin + (ptrdiff_t)y * (ptrdiff_t)s->stride + x);
}

/* Returns whether a pixel is filtered. Pixels without a surface, and those of a single sample
 * beside which none shows, keep the plain mean. */
static inline bool residual_is_filtered(const struct residual_features *f, size_t at)
{
    return !(f->barred[at] > 0.0f) && f->share[at] > 0.0f;
}

/* Repeats the border of `count` planes around the pixels. */
void residual_pad(const struct residual_shape *s, float *planes, int count);
