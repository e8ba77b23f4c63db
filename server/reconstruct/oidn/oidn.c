#include "server/reconstruct/oidn/oidn.h"

#include <math.h>
#include <stdlib.h>

#include "server/reconstruct/lighting/lighting.h"

#define FORMAT_FLOAT3 3
#define PIXEL_BYTES   (3 * sizeof(float))

/* What the network may take besides, for each frame that is filtered: it goes over larger pictures
 * piece by piece. */
#define MEMORY_MB 1024

static size_t pixels_of(const struct oidn_picture *p)
{
    return (size_t)p->width_px * (size_t)p->height_px;
}

int oidn_picture_create(int32_t width_px, int32_t height_px, struct oidn_picture *out)
{
    *out = (struct oidn_picture){.width_px = width_px, .height_px = height_px};
    const size_t pixels = pixels_of(out);
    out->light = calloc(pixels, PIXEL_BYTES);
    out->albedo = calloc(pixels, PIXEL_BYTES);
    out->normal = calloc(pixels, PIXEL_BYTES);
    if (out->light && out->albedo && out->normal) return 0;
    oidn_picture_fini(out);
    return ERR_MEMORY;
}

void oidn_picture_fini(struct oidn_picture *picture)
{
    free(picture->light);
    free(picture->albedo);
    free(picture->normal);
    *picture = (struct oidn_picture){.light = NULL};
}

void oidn_picture_put(const struct patch *patch, struct rect block, struct oidn_picture *picture)
{
    for (int32_t y = block.y0; y < block.y1; y++) {
        size_t i = patch_pixel(patch, block.x0, y);
        size_t to = 3 * ((size_t)y * (size_t)picture->width_px + (size_t)block.x0);
        for (int32_t x = block.x0; x < block.x1; x++, i++)
            for (int c = 0; c < 3; c++, to++) {
                const float spp = patch->paths.spp[i];
                picture->light[to] = lighting_bounded(patch->path_radiance[c][i] / spp);
                picture->albedo[to] = patch->path_albedo[c][i] / spp;
                picture->normal[to] = patch->path_normal[c][i] / spp;
            }
    }
}

static int run(const struct oidn_call *call, void *device, const struct oidn_picture *p,
               float *output, struct fault *fault)
{
    const struct oidn_library *l = call->library;
    const struct {
        const char *name;
        float *pixels;
    } images[] = {
        {"color", p->light}, {"albedo", p->albedo}, {"normal", p->normal}, {"output", output}};
    void *filter = l->NewFilter(device, "RT");
    if (!filter && oidn_library_check(l, device, fault) != 0) return fault->code;
    if (!filter)
        return fault_set(fault, ERR_UNSUPPORTED, "/filter/residual", "%s makes no filter",
                         l->label);
    for (size_t k = 0; k < sizeof images / sizeof *images; k++)
        l->SetSharedFilterImage(filter, images[k].name, images[k].pixels, FORMAT_FLOAT3,
                                (size_t)p->width_px, (size_t)p->height_px, 0, PIXEL_BYTES,
                                PIXEL_BYTES * (size_t)p->width_px);
    l->SetFilterBool(filter, "hdr", true);
    l->SetFilterInt(filter, "maxMemoryMB", MEMORY_MB);
    l->SetFilterProgressMonitorFunction(filter, call->go_on, call->ctx);
    l->CommitFilter(filter);
    l->ExecuteFilter(filter);
    const int error = oidn_library_check(l, device, fault);
    l->ReleaseFilter(filter);
    return error;
}

/* Puts filtered light in the place of what paths have brought. */
static int replace(const struct oidn_library *library, struct oidn_picture *p,
                   const struct plane *const shown[3], const float *filtered, struct fault *fault)
{
    const size_t pixels = pixels_of(p);
    size_t i = 0, odd = 0;
    for (int32_t y = 0; y < p->height_px; y++)
        for (int32_t x = 0; x < p->width_px; x++, i++)
            for (size_t c = 0; c < 3; c++) {
                const float else_there = *plane_at(shown[c], x, y) - p->light[3 * i + c];
                const float sum = else_there + filtered[3 * i + c];
                odd += isfinite(sum) ? 0u : 1u;
                p->albedo[c * pixels + i] = sum > 0.0f ? sum : 0.0f;
            }
    if (odd == 0) return 0;
    return fault_set(fault, ERR_NOT_FINITE, "/filter/residual",
                     "%s gave %zu numbers of %zu that are not finite", library->label, odd,
                     3 * pixels);
}

int oidn_filter(const struct oidn_call *call, struct oidn_picture *picture,
                const struct plane *const shown[3], struct fault *fault)
{
    float *output = calloc(pixels_of(picture), PIXEL_BYTES);
    if (!output) return fault_set(fault, ERR_MEMORY, "/filter/residual", "no memory for a picture");
    void *device = oidn_library_device(call->library, fault);
    int error = device ? run(call, device, picture, output, fault) : fault->code;
    if (!error) error = replace(call->library, picture, shown, output, fault);
    if (device) call->library->ReleaseDevice(device);
    free(output);
    return error;
}
