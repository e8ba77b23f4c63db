#include "server/job/prepare/matte_manifest.h"

#include <stdio.h>

#include "proto/json.h"

/* Returns false for a name that has no place left. jansson refuses a name that is no UTF-8; that
 * there was no memory is told by json_text. */
static bool add_name(json_t *names, const char *name)
{
    char id[9];
    if (json_object_get(names, name)) return true;
    if (json_object_size(names) == MATTE_MANIFEST_NAMES) return false;
    snprintf(id, sizeof id, "%08x", matte_id(name));
    json_object_set_new(names, name, json_string(id));
    return true;
}

static void warn(enum matte_kind kind, struct plan_report *report)
{
    char text[128];
    const int length = snprintf(text, sizeof text, "the manifest of %s has the first %u names only",
                                kind == MATTE_OBJECT ? MATTE_OBJECT_LAYER : MATTE_MATERIAL_LAYER,
                                MATTE_MANIFEST_NAMES);
    plan_copy_warnings(text, (size_t)length + 1, report);
}

/* Returns the manifest, which the caller frees; NULL: memory is exhausted. */
static char *text_of(const struct scene *scene, enum matte_kind kind, struct plan_report *report)
{
    json_t *names = json_object();
    const uint64_t count = scene->count[SCENE_INSTANCES];
    char room[32];
    uint64_t i = 0;
    while (i < count && add_name(names, matte_name(scene, kind, (uint32_t)i, room))) i++;
    if (i < count) warn(kind, report);
    char *text = json_text(names, JSON_COMPACT | JSON_SORT_KEYS);
    json_decref(names);
    return text;
}

int matte_manifest_make(const struct job *job, const struct scene *scene,
                        struct plan_report *report, struct exr_mattes **out)
{
    static const uint32_t layers[MATTE_KINDS] = {
        [MATTE_OBJECT] = LAYER_CRYPTO_OBJECT, [MATTE_MATERIAL] = LAYER_CRYPTO_MATERIAL};
    char *manifests[MATTE_KINDS] = {NULL};
    bool lacks = false;
    *out = NULL;
    if (!(job->layers & LAYERS_CRYPTO)) return 0;
    json_begin();
    for (int k = 0; k < MATTE_KINDS; k++) {
        if (!(job->layers & layers[k])) continue;
        manifests[k] = text_of(scene, (enum matte_kind)k, report);
        lacks |= !manifests[k];
    }
    const int error = exr_mattes_create(manifests, out);
    if (!error && lacks) exr_mattes_drop(out);
    return error ? error : lacks ? ERR_MEMORY : 0;
}
