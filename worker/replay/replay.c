#include "worker/replay/replay.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "proto/runtime/blob_file.h"
#include "proto/scene/environment.h"
#include "worker/replay/sample_replay.h"
#include "worker/scene/environment.h"
#include "worker/scene/light_table.h"
#include "worker/session/blob_files.h"

/* All that one replay holds. */
struct loaded {
    struct plan plan;
    struct scene base_blob, blob;
    struct render_scene *base, *scene;
    struct environment_blob map;
    struct environment *environment;
    struct path_record *record;
};

static void unload(struct loaded *l)
{
    free(l->record);
    environment_destroy(&l->environment);
    environment_unmap(&l->map);
    render_scene_destroy(&l->scene);
    render_scene_destroy(&l->base);
    scene_unmap(&l->blob);
    scene_unmap(&l->base_blob);
    free(l);
}

static int load_plan(const char *path, struct plan *out, struct fault *fault)
{
    const void *data = NULL;
    size_t size_bytes = 0;
    struct fault inner = {0};
    int e = blob_file_map(path, &data, &size_bytes, fault);
    if (e) return e;
    e = plan_decode(data, size_bytes, out, &inner);
    blob_file_unmap(data, size_bytes);
    if (!e) return 0;
    return fault_set(fault, e, path, "no plan of this version: %s%s%s", inner.pointer,
                     inner.pointer[0] ? ": " : "", inner.detail[0] ? inner.detail : error_text(e));
}

/* Finds a blob by its digest among a coordinator's objects, else in the cache. */
static int find_blob(const struct options *o, const struct digest *digest,
                     char path[BLOB_FILES_PATH_BYTES], struct fault *fault)
{
    const char *const folders[2] = {o->blob_dir, o->cache_dir};
    char hex[DIGEST_HEX_BYTES];
    digest_to_hex(digest, hex);
    for (int i = 0; i < 2; i++) {
        if (!folders[i]) continue;
        const int n = snprintf(path, BLOB_FILES_PATH_BYTES, "%s/%.2s/%s", folders[i], hex, hex + 2);
        if (n > 0 && n < BLOB_FILES_PATH_BYTES && access(path, R_OK) == 0) return 0;
    }
    return fault_set(fault, ERR_NOT_FOUND, hex,
                     "the plan's blob is neither in --blobs %s nor in "
                     "--cache %s",
                     o->blob_dir ? o->blob_dir : "(none)", o->cache_dir ? o->cache_dir : "(none)");
}

/* Loads what the scene at `path` stands on, if it does. */
static int load_base(const struct options *o, struct loaded *l, const char *path,
                     struct fault *fault)
{
    struct digest digest;
    char base[BLOB_FILES_PATH_BYTES];
    if (scene_find_base(path, &digest) != 0 || digest_is_zero(&digest)) return 0;
    int e = find_blob(o, &digest, base, fault);
    if (!e) e = scene_map(base, &l->base_blob, fault);
    return e ? e : render_scene_create(&l->base_blob, 1, NULL, &l->base, fault);
}

static int load_blobs(const struct options *o, struct loaded *l, struct fault *fault)
{
    char path[BLOB_FILES_PATH_BYTES];
    int e = find_blob(o, &l->plan.scene, path, fault);
    if (!e) e = load_base(o, l, path, fault);
    if (!e) e = scene_map_on(path, l->base ? &l->base_blob : NULL, &l->blob, fault);
    if (!e) e = render_scene_create_on(&l->blob, l->base, 1, NULL, &l->scene, fault);
    if (e || l->plan.environment.kind != ENVIRONMENT_MAP) return e;
    e = find_blob(o, &l->plan.environment.map, path, fault);
    if (!e) e = environment_map(path, &l->map, fault);
    if (!e && environment_create(&l->map, &l->environment) != 0)
        e = fault_set(fault, ERR_MEMORY, path, "%s", error_text(ERR_MEMORY));
    return e;
}

/* Digits up to `end`, at most nine. */
static bool read_count(const char **text, char end, uint32_t *out)
{
    const size_t digits = strspn(*text, "0123456789");
    if (digits < 1 || digits > 9 || (*text)[digits] != end) return false;
    *out = (uint32_t)strtoul(*text, NULL, 10);
    *text += digits + (end != '\0');
    return true;
}

static int read_arguments(const struct options *o, struct replay_sheet *sheet, struct fault *fault)
{
    const char *pixel = o->arguments[0], *sample = o->arguments[1];
    uint32_t x, y;
    if (!read_count(&pixel, ',', &x) || !read_count(&pixel, '\0', &y))
        return fault_set(fault, ERR_SYNTAX, "pixel", "\"%.64s\" is not X,Y", o->arguments[0]);
    if (!read_count(&sample, '\0', &sheet->sample))
        return fault_set(fault, ERR_SYNTAX, "sample", "\"%.64s\" is not a number", sample);
    sheet->x = (int32_t)x;
    sheet->y = (int32_t)y;
    return 0;
}

int replay_print(const struct options *options, FILE *out, struct fault *fault)
{
    struct replay_sheet sheet = {0};
    struct loaded *l = calloc(1, sizeof *l);
    if (l) l->record = malloc(sizeof *l->record);
    if (!l || !l->record) {
        free(l);
        return fault_set(fault, ERR_MEMORY, "", "%s", error_text(ERR_MEMORY));
    }
    int e = read_arguments(options, &sheet, fault);
    if (!e) e = load_plan(options->replay, &l->plan, fault);
    if (!e) e = load_blobs(options, l, fault);
    if (!e)
        e = sample_replay(l->scene, l->environment, &l->plan, sheet.x, sheet.y, sheet.sample,
                          l->record, fault);
    if (!e) {
        sheet.plan = &l->plan;
        sheet.scene = &l->blob;
        sheet.isa = l->scene->isa;
        sheet.record = l->record;
        if (options->json)
            e = replay_print_json(&sheet, out);
        else
            replay_print_text(&sheet, out);
    }
    if (!e && ferror(out)) e = fault_set(fault, ERR_IO, "", "standard output cannot be written");
    unload(l);
    return e;
}

/* ---- words ---- */

const char *replay_kind(const struct path_record *record)
{
    static const char *const kinds[] = {"path", "lens sample", "lens sample of a second set"};
    return kinds[record->kind];
}

const char *replay_model(const struct path_record_vertex *v)
{
    static const char *const names[BSDF_MODEL_COUNT] = {
        "black",
        "lambert",
#define MODEL(number, NAME, name) #name,
#include "proto/scene/model.def"
    };
    return v->lambert ? "lambert" : names[v->bsdf.model];
}

const char *replay_skip(const struct path_record_light *light)
{
    static const char *const reasons[] = {
        "",
        "below the shading normal's horizon",
        "the light faces away, or has no sample for it",
        "out of the light's range",
        "out of the light's cone",
        "not finite",
        "below the geometric normal's horizon",
    };
    if (light->traced) return "";
    return light->skip ? reasons[light->skip] : "nothing of it would be sent on";
}

const char *replay_end(const struct replay_sheet *sheet)
{
    const struct path_record *r = sheet->record;
    const struct path_record_vertex *v = &r->vertices[r->count - 1];
    const struct path_record_scatter *s = &v->scatter;
    if (!v->hit) return "nothing is hit";
    if (!v->active) return "the surface sends nothing on";
    if (v->left || s->left_out) return "light fields bring all that would come";
    if (v->thinned) return "roulette of what light fields leave";
    if (r->count - 1 > sheet->plan->bounces) return "that many bounces are asked for";
    if (!s->tried && v->last) return "its light sample stands for all direct light";
    if (!s->tried) return "nothing shines that a last ray could meet";
    if (!s->on) return "absorbed, or scattered to the wrong side of the surface";
    return "roulette";
}

struct replay_names replay_names(const struct scene *scene, uint32_t instance)
{
    if (instance == 0 || instance > scene->count[SCENE_INSTANCES])
        return (struct replay_names){"", "", ""};
    const struct scene_instance *placed = &scene->instances[instance - 1];
    const struct scene_mesh *mesh = &scene->meshes[placed->mesh];
    const uint32_t material = scene->materials[mesh->material].name;
    return (struct replay_names){scene_name(scene, placed->name), scene_name(scene, mesh->name),
                                 scene_name(scene, material)};
}

static bool is_same(const float a[3], const float b[3])
{
    return a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
}

const char *replay_light_name(const struct plan *plan, const struct scene *scene, uint32_t light)
{
    const struct plan_light *p = &plan->lights[light];
    for (uint64_t i = 0; i < scene->count[SCENE_LIGHTS]; i++) {
        const struct scene_light *s = &scene->lights[i];
        /* The plan turns a rectangle's direction into its normal, and leaves the rest alone. */
        const bool turned = p->type == LIGHT_RECTANGLE;
        if (s->type == p->type && is_same(s->position, p->position) &&
            is_same(s->half_u, p->half_u) && is_same(s->half_v, p->half_v) &&
            is_same(s->color, p->color) && (turned || is_same(s->direction, p->direction)))
            return scene_name(scene, s->name);
    }
    return "";
}

const char *replay_light(const struct plan *plan, uint32_t light)
{
    static const char *const types[] = {"point", "spot", "directional", "rectangle"};
    if (light == LIGHT_CHOICE_EMITTERS) return "surface";
    if (light == LIGHT_CHOICE_ENVIRONMENT) return "environment";
    return types[plan->lights[light].type];
}
