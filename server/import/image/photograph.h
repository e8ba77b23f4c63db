#pragma once
/* A photograph that pictures are composed with, as PNG, JPEG or WebP: linear light of its sRGB
 * samples. */
#include "server/import/image/panorama.h"

bool photograph_is_known(const struct file_view *file);

/* Reads one, with sides as a map may have. Alpha is ignored, and 16 bits are rounded to 8. The
 * caller owns the result. ERR_CORRUPT, ERR_LIMIT, ERR_MEMORY. */
int photograph_read(const struct file_view *file, const char *name, struct panorama *out,
                    struct warnings *warnings, struct fault *fault);
