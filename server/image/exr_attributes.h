#pragma once
/* The attributes of an EXR file that are not its pixels. The standard ones (OpenEXR, "Standard
 * Attributes"): chromaticities of Rec. 709, software, framesPerSecond of a sequence, and where the
 * camera is known worldToCamera, worldToNDC and screenWindowWidth. The camera looks along -z, x is
 * to the right and y up, as in glTF; NDC has x and y from -1 to 1, and z from -1, a hundredth of a
 * unit before the camera, to 1 at infinity (orthographic: 1 at 1e6). Points are rows, to the left
 * of the matrix. There are no times and no paths: equal jobs give equal bytes. */
#include <OpenEXR/openexr.h>

#include "server/image/exr.h"

/* Adds them to the file's only part, which has its size already. */
exr_result_t exr_attributes_add(exr_context_t context, const struct exr_metadata *metadata);
