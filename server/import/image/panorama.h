#pragma once
/* A latitude-longitude picture of radiance, as read from an .hdr or .exr file: rows from the top.
 */
#include "proto/scene/environment.h"
#include "server/import/fence/files.h"
#include "server/import/scene/warnings.h"

struct panorama {
    uint32_t width_px, height_px;
    float *texels; /* owned; 3 * width * height */
};

/* Checks the sides against limits.h and allocates zeroed texels. Faults call the file `name`.
 * ERR_LIMIT, ERR_MEMORY. */
int panorama_create(struct panorama *p, int64_t width_px, int64_t height_px, const char *name,
                    struct fault *fault);
void panorama_destroy(struct panorama *p);

/* Repairs texels that a blob may not hold. Each kind of repair gives one warning, with the first
 * place and how many more. NaN and negative numbers become 0. Infinity becomes 65504, the largest
 * half float, as it comes from half floats that overflowed and a sun must not go out. Numbers above
 * LIMIT_RADIANCE become that. */
void panorama_repair(struct panorama *p, struct warnings *warnings);

/* Read Radiance files ("#?RADIANCE", "#?RGBE"): run-length coded (both ways) or flat RGBE, rows
 * first. EXPOSURE is divided out. A mantissa m stands for m/256, not (m + 1/2)/256, as in most
 * readers. The caller owns the result. ERR_SYNTAX, ERR_UNSUPPORTED, ERR_TRUNCATED, ERR_CORRUPT,
 * ERR_LIMIT, ERR_MEMORY; the place names the row. */
bool panorama_is_radiance(const struct file_view *file);
int panorama_read_radiance(const struct file_view *file, const char *name, struct panorama *out,
                           struct warnings *warnings, struct fault *fault);

/* Read OpenEXR files as exr_read does: channels R, G, B, or Y alone as grey. ERR_MISSING without
 * these, ERR_UNSUPPORTED for luminance with colour differences or a cut data window. */
bool panorama_is_exr(const struct file_view *file);
int panorama_read_exr(const struct file_view *file, const char *name, struct panorama *out,
                      struct fault *fault);
