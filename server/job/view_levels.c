#include "server/job/view_levels.h"

/* A picture between the first and the last is worth its while when it is this much coarser than the
 * last. */
#define MIDDLE_SCALE 2

static int64_t pixels_at(const struct job *job, int32_t scale)
{
    const int64_t width = (job->width_px + scale - 1) / scale;
    return width * ((job->height_px + scale - 1) / scale);
}

static int32_t first_scale(const struct job *job)
{
    int32_t scale = 1;
    while (pixels_at(job, scale) > VIEW_FIRST_PIXELS) scale *= 2;
    return scale;
}

unsigned view_levels(const struct job *job)
{
    const int32_t first = first_scale(job);
    return first == 1 ? 1 : first <= 2 * MIDDLE_SCALE ? 2 : 3;
}

int32_t view_level_scale(const struct job *job, unsigned level)
{
    const unsigned last = view_levels(job) - 1;
    if (level >= last) return 1;
    return level == 0 ? first_scale(job) : MIDDLE_SCALE;
}

static uint32_t fewer(uint32_t spp)
{
    return spp < VIEW_COARSE_SPP ? spp : VIEW_COARSE_SPP;
}

void view_level_document(const struct job *job, unsigned level, struct job *out)
{
    const int32_t scale = view_level_scale(job, level);
    *out = *job;
    if (scale == 1) return;
    out->width_px = (job->width_px + scale - 1) / scale;
    out->height_px = (job->height_px + scale - 1) / scale;
    out->spp = fewer(job->spp);
    out->light_spp = fewer(job->light_spp);
    out->indirect_spp = fewer(job->indirect_spp);
    out->lens_spp = fewer(job->lens_spp);
    out->lens_extra = 0;
    if (job->indirect == INDIRECT_ADAPTIVE) out->indirect = INDIRECT_AUTO;
    if (out->tile_px > VIEW_COARSE_TILE_PX) out->tile_px = VIEW_COARSE_TILE_PX;
}
