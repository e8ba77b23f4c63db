#include "server/import/import.h"

#include <string.h>
#include <strings.h>
#include <unistd.h>

#include "server/import/fence/files.h"
#include "server/import/fused.h"
#include "server/import/gltf/gltf.h"
#include "server/import/image/environment_import.h"
#include "server/import/obj/obj.h"
#include "server/import/rgbd/rgbd_import.h"
#include "server/import/scene/blob_writer.h"
#include "server/import/scene/cameras.h"
#include "server/import/scene/emitters.h"
#include "server/import/scene/moves.h"
#include "server/import/scene/roles.h"
#include "server/import/sequence.h"

enum format { FORMAT_GLTF, FORMAT_OBJ, FORMAT_OTHER };

/* Returns the format, by the extension or else by the first bytes. */
static enum format format_of(const char *name, const struct file_view *main)
{
    const char *slash = strrchr(name, '/');
    const char *dot = strrchr(slash != NULL ? slash : name, '.');
    if (dot != NULL && (strcasecmp(dot, ".glb") == 0 || strcasecmp(dot, ".gltf") == 0))
        return FORMAT_GLTF;
    if (dot != NULL && strcasecmp(dot, ".obj") == 0) return FORMAT_OBJ;
    if (dot != NULL) return FORMAT_OTHER;
    if (main->size_bytes >= 4 && memcmp(main->data, "glTF", 4) == 0) return FORMAT_GLTF;
    size_t i = gltf_text_start(main);
    return i < main->size_bytes && main->data[i] == '{' ? FORMAT_GLTF : FORMAT_OBJ;
}

int scene_read(struct files *files, const char *name, const struct scene_choice *choice,
               const struct file_view *main, struct builder *b, struct fault *fault)
{
    int rc;
    switch (format_of(name, main)) {
    case FORMAT_GLTF:
        return gltf_import(files, name, choice, main, b, fault);
    case FORMAT_OBJ:
        if (choice->variant != NULL || choice->animation != NULL)
            return fault_set(fault, ERR_NOT_FOUND, name, "an OBJ has no variants or animations");
        rc = obj_import(files, name, main, b, fault);
        return rc == 0 ? moves_apply(b, choice->moves, fault) : rc;
    default:
        return fault_set(fault, ERR_UNSUPPORTED, name,
                         "scenes are .glb, .gltf or .obj files, environment maps .hdr or .exr");
    }
}

int scene_finish(struct builder *b, const struct scene_choice *choice, struct fault *fault)
{
    int rc = roles_apply(b, choice, true, fault);
    if (rc == 0) rc = emitters_find(b, fault);
    if (rc == 0 && builder_count(b, SCENE_CAMERAS) == 0) rc = camera_append_default(b, fault);
    if (rc == 0) rc = builder_finish(b, fault);
    return rc == 0 ? roles_add_ground(b, choice, fault) : rc;
}

/* Checks that workers would accept what was written. */
static int verify(const char *out, struct import_stats *stats, struct fault *fault)
{
    struct scene scene;
    int rc = scene_map(out, &scene, fault);
    if (rc != 0) {
        unlink(out);
        return rc;
    }
    stats->triangles = scene.count[SCENE_TRIANGLES];
    stats->placed_triangles = scene.info->placed_triangles;
    scene_unmap(&scene);
    return 0;
}

static int import_still(struct files *files, const char *name, const struct scene_choice *choice,
                        const struct file_view *main, const char *out, struct builder *b,
                        struct import_stats *stats, struct fault *fault)
{
    struct scene_choice at = *choice;
    if (choice->time_count > 0) at.time_s = choice->times[0];
    int rc = scene_read(files, name, &at, main, b, fault);
    if (rc == 0 && choice->rgbd != NULL) rc = rgbd_import(files, &at, b, fault);
    if (rc == 0) rc = scene_finish(b, choice, fault);
    if (rc == 0) rc = blob_write(b, out, fault);
    return rc == 0 ? verify(out, stats, fault) : rc;
}

static int import_geometry(struct files *files, const char *name, const struct scene_choice *choice,
                           const struct file_view *main, const char *out, struct warnings *warnings,
                           struct import_stats *stats, struct fault *fault)
{
    struct builder b;
    int rc = builder_init(&b, fault);
    if (rc == 0 && choice->time_count > 0 && choice->rgbd == NULL &&
        format_of(name, main) == FORMAT_GLTF)
        rc = sequence_import(files, name, choice, main, out, &b, stats, fault);
    else if (rc == 0 && choice->time_count > 0 && choice->is_fused && choice->rgbd != NULL)
        rc = fused_import(files, name, choice, main, out, &b, stats, fault);
    else if (rc == 0)
        rc = import_still(files, name, choice, main, out, &b, stats, fault);
    *warnings = b.warnings;
    builder_fini(&b);
    return rc;
}

int import_scene(const char *root, const char *name, const struct scene_choice *choice,
                 const char *out, struct warnings *warnings, struct import_stats *stats,
                 struct fault *fault)
{
    struct files files;
    struct file_view main;
    memset(warnings, 0, sizeof *warnings);
    *stats = (struct import_stats){0};
    int rc = files_open(&files, root, fault);
    if (rc != 0) return rc;
    rc = files_map(&files, name, name, &main, fault);
    if (rc == 0) {
        rc = environment_is_known(&main)
                 ? environment_import(&main, name, out, warnings, stats, fault)
                 : import_geometry(&files, name, choice, &main, out, warnings, stats, fault);
        files_unmap(&main);
    }
    files_close(&files);
    return rc;
}
