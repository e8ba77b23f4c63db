#include "server/reconstruct/compose/paths.h"

#include "proto/runtime/clock.h"
#include "server/reconstruct/compose/mixed_paths.h"
#include "server/reconstruct/lighting/lighting.h"
#include "server/reconstruct/residual/residual.h"

/* Channels that are means of a sum. */
struct mean {
    const char *channel;
    const float *sum; /* NULL: not in the plan */
};

static void put_mean(const struct patch *patch, const float *sum, struct rect block,
                     const struct plane *out)
{
    if (!sum || !out) return;
    for (int32_t y = block.y0; y < block.y1; y++) {
        const size_t first = patch_pixel(patch, block.x0, y);
        const float *in = sum + first, *spp = patch->paths.spp + first;
        float *to = plane_at(out, block.x0, y);
        for (int32_t x = 0; x < rect_width(block); x++) to[x] = lighting_bounded(in[x] / spp[x]);
    }
}

/* Where lobes are divided, the list has other pixels than those at edges, and tells nothing. */
static void put_samples(const struct plan *plan, const struct patch *patch, struct rect block,
                        const struct plane *out)
{
    const uint32_t more = plan->paths.without_diffuse_direct ? 0 : plan->paths.edge_digits;
    const struct mixed_share *edges = &patch->mixed;
    if (!out) return;
    for (int32_t y = block.y0; y < block.y1; y++) {
        const size_t first = patch_pixel(patch, block.x0, y);
        float *to = plane_at(out, block.x0, y);
        for (int32_t x = 0; x < rect_width(block); x++) {
            const bool edge = more > 0 && mixed_share_find(edges, first + (size_t)x) < edges->count;
            to[x] = patch->paths.spp[first + (size_t)x] * (float)(1u << (edge ? more : 0));
        }
    }
}

static uint64_t count_background(const struct patch *patch, struct rect block)
{
    uint64_t count = 0;
    for (int32_t y = block.y0; y < block.y1 && patch->path_coverage; y++) {
        const float *in = patch->path_coverage + patch_pixel(patch, block.x0, y);
        for (int32_t x = 0; x < rect_width(block); x++) count += in[x] == 0.0f;
    }
    return count;
}

static void put_filtered(const struct residual_picture *p, const float *in, struct rect b,
                         const struct plane *out)
{
    if (!out) return;
    for (int32_t y = b.y0; y < b.y1; y++) {
        const float *from = in + residual_picture_at(p, b.x0, y);
        float *to = plane_at(out, b.x0, y);
        for (int32_t x = 0; x < rect_width(b); x++) to[x] = lighting_bounded(from[x]);
    }
}

/* Puts what the residual filter makes of the samples in place of their means. */
static int filter(const struct plan *plan, const struct patch *patch, struct rect block,
                  struct image *image, struct block_variance *variance,
                  struct block_statistics *statistics)
{
    static const char *const radiance[] = {"R", "G", "B"};
    static const char *const direct[] = {"diffuse_direct.R", "diffuse_direct.G",
                                         "diffuse_direct.B"};
    static const char *const indirect[] = {"diffuse_indirect.R", "diffuse_indirect.G",
                                           "diffuse_indirect.B"};
    struct residual_picture picture;
    const uint64_t begun_us = thread_cpu_us();
    const struct rect ring = rect_grow(block, mixed_paths_ring_px(plan));
    const struct residual_variance known = {block, variance->by_source[ERROR_SOURCE_PATHS]};
    const int error = residual_filter(patch, rect_intersect(ring, patch->core),
                                      variance->memory && plan->paths.spp > 1 ? &known : NULL,
                                      &picture, &statistics->residual);
    if (error) return error;
    statistics->pixels_mixed += mixed_paths_apply(plan, patch, block, &picture);
    for (int c = 0; c < 3; c++) {
        put_filtered(&picture, picture.radiance[c], block, image_plane(image, radiance[c]));
        put_filtered(&picture, picture.diffuse_direct[c], block, image_plane(image, direct[c]));
        put_filtered(&picture, picture.diffuse_indirect[c], block, image_plane(image, indirect[c]));
    }
    residual_picture_fini(&picture);
    statistics->residual_cpu_us += thread_cpu_us() - begun_us;
    return 0;
}

int paths_compose(const struct plan *plan, const struct patch *patch, struct rect block,
                  struct image *image, struct block_variance *variance,
                  struct block_statistics *statistics)
{
    const struct mean means[] = {
        {"R", patch->path_radiance[0]},
        {"G", patch->path_radiance[1]},
        {"B", patch->path_radiance[2]},
        {"A", patch->path_coverage},
        {"direct.R", patch->path_direct[0]},
        {"direct.G", patch->path_direct[1]},
        {"direct.B", patch->path_direct[2]},
        {"indirect.R", patch->path_indirect[0]},
        {"indirect.G", patch->path_indirect[1]},
        {"indirect.B", patch->path_indirect[2]},
        {"emission.R", patch->path_emission[0]},
        {"emission.G", patch->path_emission[1]},
        {"emission.B", patch->path_emission[2]},
        {"albedo.R", patch->path_albedo[0]},
        {"albedo.G", patch->path_albedo[1]},
        {"albedo.B", patch->path_albedo[2]},
        {"diffuse_direct.R", patch->path_diffuse_direct[0]},
        {"diffuse_direct.G", patch->path_diffuse_direct[1]},
        {"diffuse_direct.B", patch->path_diffuse_direct[2]},
        {"diffuse_indirect.R", patch->path_diffuse_indirect[0]},
        {"diffuse_indirect.G", patch->path_diffuse_indirect[1]},
        {"diffuse_indirect.B", patch->path_diffuse_indirect[2]},
        {"occlusion.O", patch->path_visibility},
    };
    for (size_t i = 0; i < sizeof means / sizeof means[0]; i++)
        put_mean(patch, means[i].sum, block, image_plane(image, means[i].channel));
    put_samples(plan, patch, block, image_plane(image, "samples.N"));
    if (!plan->paths.without_diffuse_direct) /* else light fields see the background */
        statistics->pixels_background += count_background(patch, block);
    if (plan->residual_filter != RESIDUAL_FILTER_HALVES) return 0;
    return filter(plan, patch, block, image, variance, statistics);
}
