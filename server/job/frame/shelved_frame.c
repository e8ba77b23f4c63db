#include "server/job/frame/shelved_frame.h"

#include <stdlib.h>

struct shelved_frame *shelved_frame_create(const struct frame *work, struct shelved_frame *before)
{
    const uint32_t count = frame_tile_count(work);
    struct shelved_frame *p = calloc(1, sizeof *p + count * sizeof *p->passes);
    if (!p) return NULL;
    p->statistics = *frame_statistics(work);
    statistics_forget_picture(&p->statistics);
    for (uint32_t i = 0; i < count; i++) {
        const uint32_t landed = frame_tile_passes(work, i);
        const uint32_t known = before ? before->passes[i] : 0;
        p->passes[i] = landed > known ? landed : known;
    }
    if (before) statistics_add(&p->statistics, &before->statistics);
    free(before);
    return p;
}
