#include "server/import/rgbd/rgbd_parts.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "proto/plan.h"
#include "server/import/scene/cameras.h"
#include "server/import/scene/surface.h"

#define NAME "rgbd"

/* Appends a part of a mesh: `count` of its triangles from `first` on. */
static int append_part(struct builder *b, const struct scene_mesh *whole, uint32_t first,
                       uint32_t count, struct fault *fault)
{
    struct scene_mesh part = *whole;
    part.first_triangle += first;
    part.triangle_count = count;
    return count > 0 ? builder_append_record(b, SCENE_MESHES, &part, fault) : 0;
}

int rgbd_append_material(struct builder *b, uint32_t *name, struct fault *fault)
{
    struct scene_material material;
    surface_init(&material);
    material.metallic = material.specular = 0;
    material.flags = MATERIAL_DOUBLE_SIDED | MATERIAL_COLORED;
    int rc = builder_name(b, NAME, &material.name, fault);
    *name = material.name;
    return rc == 0 ? builder_append_record(b, SCENE_MATERIALS, &material, fault) : rc;
}

int rgbd_append_mesh(const struct mesh *mesh, uint32_t first_shining, struct builder *b,
                     struct fault *fault)
{
    struct scene_mesh record;
    int rc = mesh_append(mesh, b, &record, fault);
    record.material = (uint32_t)builder_count(b, SCENE_MATERIALS);
    if (rc == 0) rc = rgbd_append_material(b, &record.name, fault);
    if (rc == 0) rc = append_part(b, &record, 0, first_shining, fault);
    return rc == 0
               ? append_part(b, &record, first_shining, mesh->triangle_count - first_shining, fault)
               : rc;
}

/* Places a mesh, moved by `by`. */
static int place_mesh(struct builder *b, uint32_t mesh, uint32_t role, const double by[3],
                      struct fault *fault)
{
    const bool still = by[0] == 0 && by[1] == 0 && by[2] == 0;
    const float x = (float)by[0], y = (float)by[1], z = (float)by[2];
    const struct scene_instance instance = {.mesh = mesh,
                                            .flags = role | (still ? INSTANCE_IDENTITY : 0),
                                            .name = builder_meshes(b)[mesh].name,
                                            .to_world = {1, 0, 0, x, 0, 1, 0, y, 0, 0, 1, z}};
    return builder_append_record(b, SCENE_INSTANCES, &instance, fault);
}

int rgbd_place_parts(struct builder *b, uint64_t first, uint64_t end, bool all_shine,
                     const double by[3], struct fault *fault)
{
    int rc = 0;
    for (uint64_t k = first; k < end && rc == 0; k++)
        rc = place_mesh(b, (uint32_t)k,
                        all_shine || k > first ? INSTANCE_HOLDOUT : INSTANCE_CATCHER, by, fault);
    return rc;
}

struct affine rgbd_camera_in(const struct rgbd_document *d, uint32_t frame,
                             const struct affine *place, const double origin[3])
{
    struct affine out = affine_multiply(place, &d->frames[frame].pose);
    for (int i = 0; i < 3; i++) out.m[4 * i + 3] -= origin[i];
    return out;
}

/* OpenCV's cameras look along z with y down, the scene's along -z with y up. */
int rgbd_append_camera(const struct rgbd_document *d, int32_t width, int32_t height,
                       const struct affine *to_scene, struct builder *b, struct fault *fault)
{
    struct affine turned = *to_scene;
    struct scene_camera camera = {
        .type = CAMERA_PERSPECTIVE,
        .yfov_rad = (float)(2 * atan((double)height / (2 * d->fy))),
        .half_width = (float)(width / (2 * d->fx)),
        .centre_x = (float)(2 * (d->cx + 0.5) / width - 1),
        .centre_y = (float)(1 - 2 * (d->cy + 0.5) / height),
    };
    for (int i = 0; i < 3; i++) {
        turned.m[4 * i + 1] = -turned.m[4 * i + 1];
        turned.m[4 * i + 2] = -turned.m[4 * i + 2];
    }
    int rc = builder_name(b, NAME, &camera.name, fault);
    if (rc == 0 && !camera_set_frame(&camera, &turned))
        rc = fault_set(fault, ERR_RANGE, "/rgbd/poses", "a camera looks nowhere");
    b->default_camera = (uint32_t)builder_count(b, SCENE_CAMERAS);
    return rc == 0 ? builder_append_record(b, SCENE_CAMERAS, &camera, fault) : rc;
}

/* A name that would be cut names no file. */
int rgbd_set_plate(const struct rgbd_document *d, uint32_t frame, struct builder *b,
                   struct fault *fault)
{
    char plate[LIMIT_PATH_BYTES], place[48];
    snprintf(place, sizeof place, "/rgbd/frames/%u/color", frame);
    int rc = files_resolve(d->name, d->frames[frame].color, false, plate, place, fault);
    if (rc == 0 && strlen(plate) >= LIMIT_NAME_BYTES)
        rc = fault_set(fault, ERR_LIMIT, place, "its path has more than %d bytes",
                       LIMIT_NAME_BYTES - 1);
    return rc == 0 ? builder_name(b, plate, &b->plate, fault) : rc;
}

int rgbd_find_frame(const struct rgbd_document *d, double time_s, uint32_t *frame,
                    struct fault *fault)
{
    const double at = round(time_s * d->fps);
    if (!(at >= 0 && at < d->frame_count))
        return fault_set(fault, ERR_NOT_FOUND, "/rgbd/frames",
                         "there is no frame at %.9g s: the last of %u is at %.9g s", time_s,
                         d->frame_count, (d->frame_count - 1) / d->fps);
    *frame = (uint32_t)at;
    return 0;
}
