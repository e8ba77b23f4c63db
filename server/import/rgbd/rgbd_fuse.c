#include "server/import/rgbd/rgbd_fuse.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "server/import/rgbd/fusion.h"
#include "server/import/rgbd/fusion_mesh.h"
#include "server/import/rgbd/white.h"

/* How often voxels are doubled before the sequence is refused. */
#define DOUBLINGS 10

static int compare(const void *a, const void *b)
{
    const float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

/* Reads a frame's depth as it is measured, without what belongs to no surface. */
static int read_frame(const struct rgbd_document *d, struct files *files, uint32_t frame,
                      struct depth_map *out, struct warnings *warnings, struct fault *fault)
{
    int rc = depth_map_read(d, files, frame, true, out, warnings, fault);
    if (rc != 0) return rc;
    depth_map_drop_strays(out);
    rc = depth_map_smooth(out, fault);
    if (rc != 0) depth_map_destroy(out);
    return rc;
}

/* Finds the size of half a pixel, or of the noise, at the median depth. */
static int find_voxel(const struct rgbd_document *d, const struct depth_map *map, double *out,
                      struct fault *fault)
{
    const size_t pixels = (size_t)map->width * (size_t)map->height;
    size_t count = 0;
    float *z = malloc(pixels * sizeof *z);
    if (z == NULL) return fault_set(fault, ERR_MEMORY, "/rgbd", "no memory for depth");
    for (size_t i = 0; i < pixels; i++)
        if (map->z[i] > 0) z[count++] = map->z[i];
    qsort(z, count, sizeof *z, compare);
    const float middle = count > 0 ? z[count / 2] : 1;
    *out = fmax(0.5 * (double)middle / d->fx, (double)depth_noise_m(middle));
    free(z);
    return 0;
}

/* What frames are added to. */
struct fusing {
    const struct rgbd_document *d;
    struct files *files;
    struct rgbd_fused *out;
    struct fusion volume;
    double voxel_m;
    bool is_full; /* the volume has no room for all */
    struct warnings *warnings;
};

static int refuse_size(const struct fusing *k, uint32_t frame, const struct depth_map *map,
                       struct fault *fault)
{
    char place[48];
    snprintf(place, sizeof place, "/rgbd/frames/%u/depth", frame);
    return fault_set(fault, ERR_MISMATCH, place,
                     "it has %d x %d px, the first frame %d x %d: they have one camera", map->width,
                     map->height, k->out->width, k->out->height);
}

static int add_frame(struct fusing *k, uint32_t frame, struct fault *fault)
{
    const struct rgbd_document *d = k->d;
    struct depth_map map;
    float white[3];
    int rc = read_frame(d, k->files, frame, &map, k->warnings, fault);
    if (rc != 0) return rc;
    if (map.width != k->out->width || map.height != k->out->height)
        rc = refuse_size(k, frame, &map, fault);
    if (rc == 0) white_find(&map, d, white);
    if (rc == 0) rc = fusion_add(&k->volume, &map, d, &d->frames[frame].pose, white);
    depth_map_destroy(&map);
    k->is_full = rc == ERR_LIMIT;
    if (k->is_full)
        fault_set(fault, rc, "/rgbd/poses/file",
                  "frame %u sees what is too far from the others for one model", frame + 1);
    return rc == ERR_MEMORY ? fault_set(fault, rc, "/rgbd", "no memory for a model") : rc;
}

/* Large frames are fewer, since the importer's time is bounded. */
static uint32_t frames_used(const struct fusing *k)
{
    const uint32_t pixels = (uint32_t)k->out->width * (uint32_t)k->out->height;
    const uint32_t most = pixels > 0 && LIMIT_FUSION_PIXELS / pixels < LIMIT_FUSION_FRAMES
                              ? LIMIT_FUSION_PIXELS / pixels
                              : LIMIT_FUSION_FRAMES;
    const uint32_t least = most > 0 ? most : 1;
    return k->d->frame_count < least ? k->d->frame_count : least;
}

static int add_frames(struct fusing *k, struct fault *fault)
{
    const uint32_t count = k->d->frame_count;
    const uint32_t used = frames_used(k);
    const struct warnings kept = *k->warnings; /* another voxel warns of the same */
    int rc = fusion_create(k->voxel_m, k->out->origin, &k->volume);
    if (rc != 0) return fault_set(fault, rc, "/rgbd", "no memory for a model");
    for (uint32_t i = 0; i < used && rc == 0; i++)
        rc = add_frame(k, (uint32_t)((uint64_t)i * count / used), fault);
    if (rc == 0) return 0;
    *k->warnings = kept;
    fusion_destroy(&k->volume);
    return rc;
}

/* The first frame tells of the voxels' size. The volume begins at its camera. */
static int begin(struct fusing *k, struct fault *fault)
{
    struct depth_map map;
    const struct warnings kept = *k->warnings; /* the frame is read again */
    for (int c = 0; c < 3; c++) k->out->origin[c] = k->d->frames[0].pose.m[4 * c + 3];
    int rc = read_frame(k->d, k->files, 0, &map, k->warnings, fault);
    *k->warnings = kept;
    if (rc != 0) return rc;
    k->out->width = map.width;
    k->out->height = map.height;
    rc = find_voxel(k->d, &map, &k->voxel_m, fault);
    depth_map_destroy(&map);
    return rc;
}

int rgbd_fuse(const struct rgbd_document *d, struct files *files, struct rgbd_fused *out,
              struct warnings *warnings, struct fault *fault)
{
    struct fusing k = {.d = d, .files = files, .out = out, .warnings = warnings};
    *out = (struct rgbd_fused){.width = 0};
    int rc = begin(&k, fault);
    if (rc == 0) rc = add_frames(&k, fault);
    for (int i = 0; i < DOUBLINGS && rc != 0 && k.is_full; i++) {
        k.voxel_m *= 2;
        rc = add_frames(&k, fault);
    }
    if (rc != 0) return rc;
    rc = fusion_mesh_make(&k.volume, &out->mesh, &out->first_shining, fault);
    fusion_destroy(&k.volume);
    if (rc != 0 || out->mesh.triangle_count > 0) return rc;
    mesh_fini(&out->mesh);
    return fault_set(fault, ERR_MISSING, "/rgbd/frames", "their depth makes no surface");
}
