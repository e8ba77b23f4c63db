#include "server/import/rgbd/rgbd_import.h"

#include <math.h>
#include <stdio.h>

#include "server/import/rgbd/depth_map.h"
#include "server/import/rgbd/depth_mesh.h"
#include "server/import/rgbd/rgbd_light.h"
#include "server/import/rgbd/rgbd_model.h"
#include "server/import/rgbd/rgbd_parts.h"
#include "server/import/rgbd/rgbd_place.h"
#include "server/import/rgbd/white.h"
#include "server/import/scene/mesh.h"

/* Poses are rotations: their inverse is the transpose. */
static struct affine inverse_of(const struct affine *pose)
{
    struct affine out;
    for (int i = 0; i < 3; i++) {
        double moved = 0;
        for (int j = 0; j < 3; j++) {
            out.m[4 * i + j] = pose->m[4 * j + i];
            moved -= pose->m[4 * j + i] * pose->m[4 * j + 3];
        }
        out.m[4 * i + 3] = moved;
    }
    return out;
}

static struct affine between(const struct affine *from, const struct affine *to)
{
    const struct affine back = inverse_of(to);
    return affine_multiply(&back, from);
}

static int refuse_size(uint32_t frame, const struct depth_map *map, const struct depth_map *first,
                       struct fault *fault)
{
    char place[48];
    snprintf(place, sizeof place, "/rgbd/frames/%u/depth", frame);
    return fault_set(fault, ERR_MISMATCH, place,
                     "it has %d x %d px, the frame beside it %d x %d: they have one camera",
                     map->width, map->height, first->width, first->height);
}

static int fuse_one(const struct rgbd_document *d, struct files *files, uint32_t frame,
                    uint32_t other, struct depth_map *map, struct warnings *warnings,
                    struct fault *fault)
{
    struct depth_map there;
    const struct affine *here = &d->frames[frame].pose, *pose = &d->frames[other].pose;
    const struct affine to = between(here, pose), from = between(pose, here);
    int rc = depth_map_read(d, files, other, false, &there, warnings, fault);
    if (rc != 0) return rc;
    depth_map_drop_strays(&there);
    if (there.width != map->width || there.height != map->height)
        rc = refuse_size(other, &there, map, fault);
    else
        rc = depth_map_fuse(map, &there, d, &to, &from, fault);
    depth_map_destroy(&there);
    return rc;
}

/* Reads a frame's depth and makes it as good as frames beside it allow. */
static int read_map(const struct rgbd_document *d, struct files *files, uint32_t frame,
                    struct depth_map *out, struct warnings *warnings, struct fault *fault)
{
    int rc = depth_map_read(d, files, frame, true, out, warnings, fault);
    if (rc != 0) return rc;
    depth_map_drop_strays(out);
    for (uint32_t k = 1; k <= d->fuse && rc == 0; k++) {
        if (frame >= k) rc = fuse_one(d, files, frame, frame - k, out, warnings, fault);
        if (rc == 0 && frame + k < d->frame_count)
            rc = fuse_one(d, files, frame, frame + k, out, warnings, fault);
    }
    if (rc == 0) rc = depth_map_smooth(out, fault);
    if (rc != 0) depth_map_destroy(out);
    return rc;
}

/* Appends and places a mesh of the scene's own coordinates. */
static int append_placed(const struct mesh *mesh, uint32_t first_shining, struct builder *b,
                         struct fault *fault)
{
    static const double nowhere[3];
    const uint64_t first = builder_count(b, SCENE_MESHES);
    const int rc = rgbd_append_mesh(mesh, first_shining, b, fault);
    if (rc != 0) return rc;
    return rgbd_place_parts(b, first, builder_count(b, SCENE_MESHES), first_shining == 0, nowhere,
                            fault);
}

static int append_surfaces(const struct rgbd_document *d, const struct depth_map *map,
                           const struct affine *to_scene, struct builder *b, struct fault *fault)
{
    struct mesh mesh;
    uint32_t first_shining;
    float white[3];
    white_find(map, d, white);
    int rc = depth_mesh_make(map, d, white, &mesh, &first_shining, fault);
    if (rc != 0) return rc;
    rc = mesh_transform(&mesh, to_scene, "/rgbd", fault);
    if (rc == 0) rc = append_placed(&mesh, first_shining, b, fault);
    mesh_fini(&mesh);
    return rc;
}

static int add_light(const struct rgbd_document *d, struct files *files, const struct affine *place,
                     const struct scene_choice *choice, struct builder *b, struct fault *fault)
{
    static struct rgbd_light light; /* large, and there is one */
    if (!rgbd_light_is_wanted(choice, b)) return 0;
    const int rc = rgbd_light_find(d, files, place, choice, &light, &b->warnings, fault);
    return rc == 0 ? rgbd_light_add(&light, choice, b, fault) : rc;
}

static int add_frame(const struct rgbd_document *d, struct files *files, uint32_t frame,
                     const struct scene_choice *choice, struct builder *b, struct fault *fault)
{
    struct affine place;
    struct depth_map map;
    int rc = rgbd_place_find(d, files, &place, &b->warnings, fault);
    if (rc == 0) rc = read_map(d, files, frame, &map, &b->warnings, fault);
    if (rc != 0) return rc;
    const struct affine to_scene = rgbd_camera_in(d, frame, &place, b->origin);
    rc = append_surfaces(d, &map, &to_scene, b, fault);
    if (rc == 0) rc = rgbd_append_camera(d, map.width, map.height, &to_scene, b, fault);
    if (rc == 0) rc = rgbd_set_plate(d, frame, b, fault);
    if (rc == 0) rc = add_light(d, files, &place, choice, b, fault);
    depth_map_destroy(&map);
    return rc;
}

static int add_model(struct files *files, const struct scene_choice *choice, struct builder *b,
                     struct fault *fault)
{
    struct rgbd_model model;
    int rc = rgbd_model_open(&model, files, choice, b, fault);
    if (rc == 0) rc = rgbd_model_add_frame(&model, choice, choice->time_s, b, fault);
    rgbd_model_close(&model);
    return rc;
}

int rgbd_import(struct files *files, const struct scene_choice *choice, struct builder *b,
                struct fault *fault)
{
    struct rgbd_document d;
    uint32_t frame;
    if (choice->is_fused) return add_model(files, choice, b, fault);
    int rc = rgbd_document_open(&d, files, choice->rgbd, fault);
    if (rc == 0) rc = rgbd_find_frame(&d, choice->time_s, &frame, fault);
    if (rc == 0) rc = add_frame(&d, files, frame, choice, b, fault);
    b->moves = true;
    rgbd_document_close(&d);
    return rc;
}
