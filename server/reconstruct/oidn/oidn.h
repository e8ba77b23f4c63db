#pragma once
/* Filters what paths bring by Open Image Denoise: a network that sees all of a frame, with albedo
 * and normals as guides. It is no part of what equal bytes are promised of: they differ from
 * version to version and from CPU to CPU. docs/reconstruction.md, Open Image Denoise. */
#include "proto/plane.h"
#include "server/reconstruct/oidn/oidn_library.h"
#include "server/reconstruct/patch/patch.h"

/* What it is given of a frame, row by row, R, G and B of a pixel side by side. */
struct oidn_picture {
    int32_t width_px, height_px;
    float *light;  /* owned; mean of what paths bring */
    float *albedo; /* owned; mean diffuse albedo, also of what mirrors and clear glass show */
    float *normal; /* owned; mean over the samples */
};

/* Creates a black picture. ERR_MEMORY. */
int oidn_picture_create(int32_t width_px, int32_t height_px, struct oidn_picture *out);
void oidn_picture_fini(struct oidn_picture *picture);

/* Takes a block's pixels. Blocks may be put by different threads. */
void oidn_picture_put(const struct patch *patch, struct rect block, struct oidn_picture *picture);

/* A call of the filter. It ends early once `go_on` returns false. */
struct oidn_call {
    const struct oidn_library *library;
    bool (*go_on)(void *ctx, double share);
    void *ctx;
};

/* Filters the picture and puts it in the place of what paths have brought to `shown`, planes of R,
 * G and B that are only read: what else is in there stays. The result, not negative, is in
 * `albedo`, plane by plane. ERR_MEMORY; ERR_NOT_FINITE for numbers that are none; ERR_UNSUPPORTED
 * for all else that the library tells of. */
int oidn_filter(const struct oidn_call *call, struct oidn_picture *picture,
                const struct plane *const shown[3], struct fault *fault);
