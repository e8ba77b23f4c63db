#include "server/job/prepare/imports.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "proto/scene/scene.h"

/* Children at a time: an import may take gigabytes. */
#define RUNNING_MAX 2

struct import_request {
    struct import *import;
    struct import_request *next;
    import_done done;
    void *ctx;
};

/* One scene on its way; in the list until it is told of. */
struct import {
    struct imports *imports;
    struct import *next;
    struct digest source;
    struct job scene; /* only what tells it from other imports is set; owned */
    struct import_times times;
    struct import_request *requests;
    struct import_process *process;
    bool looking;   /* the store is being asked */
    bool beginning; /* ... for the first time: no request waits yet */
    bool waiting;   /* for a process */
};

struct imports {
    struct import_options options;
    struct job_store *store;
    struct import *list; /* oldest first */
    unsigned running;
    bool stopped;
};

int imports_create(const struct import_options *options, struct job_store *store,
                   struct imports **out)
{
    struct imports *s = calloc(1, sizeof *s);
    if (!s) return ERR_MEMORY;
    s->options = *options;
    s->store = store;
    *out = s;
    return 0;
}

static void unlink_import(struct import *import)
{
    struct import **at = &import->imports->list;
    while (*at && *at != import) at = &(*at)->next;
    if (*at) *at = import->next;
}

static void destroy(struct import *import)
{
    unlink_import(import);
    job_fini(&import->scene);
    free(import);
}

/* Answers all waiting requests, which may begin the next at once. */
static void tell(struct import *import, const struct fault *fault, const struct digest *blob,
                 uint64_t cpu_us)
{
    struct import_request *request;
    unlink_import(import);
    import->looking = true; /* held: a callback may forget another request */
    while ((request = import->requests)) {
        import->requests = request->next;
        request->done(request->ctx, fault, blob, cpu_us);
        free(request);
        cpu_us = 0;
    }
    destroy(import);
}

static void start_waiting(struct imports *s);

/* A blob that is held until the store has it on record. */
struct remembering {
    const struct objects *objects;
    struct digest blob;
};

static void on_remembered(void *ctx, int error)
{
    struct remembering *one = ctx;
    (void)error; /* a memory only */
    objects_release(one->objects, &one->blob);
    free(one);
}

/* Without memory the import runs again another time. */
static void remember(const struct import *import, const struct digest *source,
                     const struct digest *blob)
{
    const struct imports *s = import->imports;
    const struct job *scene = &import->scene;
    struct remembering *one = malloc(sizeof *one);
    struct digest *assets = calloc((size_t)scene->file_count + 1, sizeof *assets);
    if (one && assets) {
        *one = (struct remembering){.objects = s->options.objects, .blob = *blob};
        assets[0] = scene->scene;
        for (uint32_t i = 0; i < scene->file_count; i++) assets[i + 1] = scene->files[i].asset;
        job_store_remember_blob(s->store, source, blob, assets, (size_t)scene->file_count + 1,
                                on_remembered, one);
    } else {
        objects_release(s->options.objects, blob);
        free(one);
    }
    free(assets);
}

/* Nothing is looked up under it: a base is on record so that it goes with its assets. */
static void source_of_base(const struct digest *source, struct digest *out)
{
    uint8_t bytes[DIGEST_BYTES + 1] = "b";
    memcpy(bytes + 1, source, DIGEST_BYTES);
    digest_of(bytes, sizeof bytes, out);
}

static void remember_all(struct import *import, const struct import_blobs *blobs)
{
    struct digest source;
    const double first_s = import->scene.time_s;
    if (!digest_is_zero(&blobs->base)) {
        source_of_base(&import->source, &source);
        remember(import, &source, &blobs->base);
    }
    remember(import, &import->source, &blobs->list[0]);
    for (uint32_t i = 1; i < blobs->count; i++) {
        import->scene.time_s = import->times.list[i];
        if (imports_source(&import->scene, &source) == 0)
            remember(import, &source, &blobs->list[i]);
        else
            objects_release(import->imports->options.objects, &blobs->list[i]);
    }
    import->scene.time_s = first_s;
}

static void on_imported(void *ctx, const struct fault *fault, const struct import_blobs *blobs,
                        uint64_t cpu_us)
{
    struct import *import = ctx;
    struct imports *s = import->imports;
    import->process = NULL;
    s->running--;
    if (!fault) remember_all(import, blobs);
    tell(import, fault, &blobs->list[0], cpu_us);
    start_waiting(s);
}

static void start(struct import *import)
{
    struct fault fault;
    struct imports *s = import->imports;
    import->waiting = false;
    int error = import_process_start(&s->options, &import->scene, &import->times, on_imported,
                                     import, &import->process);
    if (error) {
        fault_set(&fault, error, "", "no memory to import the scene");
        tell(import, &fault, NULL, 0);
        return;
    }
    s->running++;
}

static struct import *first_waiting(const struct imports *s)
{
    struct import *import = s->list;
    while (import && !import->waiting) import = import->next;
    return import;
}

static void start_waiting(struct imports *s)
{
    struct import *import;
    while (!s->stopped && s->running < RUNNING_MAX && (import = first_waiting(s))) start(import);
}

/* Returns whether a blob is there, with what it stands on. */
static bool is_whole(const struct objects *objects, const struct digest *blob)
{
    char path[OBJECTS_PATH_BYTES];
    struct digest base;
    if (!objects_have(objects, blob, NULL)) return false;
    objects_path(objects, blob, path);
    if (scene_find_base(path, &base) != 0) return false;
    return digest_is_zero(&base) || objects_have(objects, &base, NULL);
}

static void on_found(void *ctx, int error, const struct digest *blob)
{
    struct import *import = ctx;
    struct imports *s = import->imports;
    import->looking = false;
    if (import->beginning) return; /* the store had no memory to ask */
    if (s->stopped || !import->requests) {
        destroy(import);
        return;
    }
    if (!error && blob && is_whole(s->options.objects, blob)) {
        tell(import, NULL, blob, 0);
        return;
    }
    import->waiting = true;
    start_waiting(s);
}

static int copy_scene(const struct job *scene, struct job *out)
{
    out->scene = scene->scene;
    memcpy(out->variant, scene->variant, sizeof out->variant);
    memcpy(out->animation, scene->animation, sizeof out->animation);
    out->moves = scene->moves;
    out->stands = scene->stands;
    out->time_s = scene->time_s;
    out->fps = scene->fps;
    out->shutter_fraction = scene->shutter_fraction;
    out->files = calloc(scene->file_count + 1, sizeof *out->files);
    if (!out->files || job_composite_copy(&scene->composite, &out->composite) != 0)
        return ERR_MEMORY;
    for (uint32_t i = 0; i < scene->file_count; i++) {
        out->files[i].asset = scene->files[i].asset;
        out->files[i].path = strdup(scene->files[i].path);
        if (!out->files[i].path) return ERR_MEMORY;
        out->file_count++;
    }
    return 0;
}

static int begin(struct imports *s, const struct job *scene, const struct import_times *times,
                 const struct digest *source, struct import **out)
{
    struct import *import = calloc(1, sizeof *import);
    if (!import) return ERR_MEMORY;
    import->imports = s;
    import->source = *source;
    import->times = *times;
    if (copy_scene(scene, &import->scene) != 0) {
        job_fini(&import->scene);
        free(import);
        return ERR_MEMORY;
    }
    struct import **end = &s->list;
    while (*end) end = &(*end)->next;
    *end = import;
    import->looking = import->beginning = true;
    job_store_find_blob(s->store, source, on_found, import);
    import->beginning = false;
    if (!import->looking) {
        destroy(import);
        return ERR_MEMORY;
    }
    *out = import;
    return 0;
}

static struct import *find(struct imports *s, const struct digest *source)
{
    struct import *import = s->list;
    while (import && !digest_equal(&import->source, source)) import = import->next;
    return import;
}

int imports_request(struct imports *s, const struct job *scene, const struct import_times *times,
                    import_done done, void *ctx, struct import_request **out)
{
    struct digest source;
    int error = imports_source(scene, &source);
    struct import_request *request = calloc(1, sizeof *request);
    if (error || !request) goto fail;
    struct import *import = find(s, &source);
    if (!import && begin(s, scene, times, &source, &import) != 0) goto fail;
    *request = (struct import_request){.import = import, .done = done, .ctx = ctx};
    struct import_request **end = &import->requests;
    while (*end) end = &(*end)->next;
    *end = request;
    *out = request;
    return 0;
fail:
    free(request);
    return ERR_MEMORY;
}

/* Ends an import without requests, unless the store still holds on to it. */
static void abandon(struct import *import)
{
    struct imports *s = import->imports;
    if (import->process) {
        import_process_cancel(&import->process);
        s->running--;
    }
    if (!import->looking) destroy(import);
    start_waiting(s);
}

void imports_forget(struct import_request **request)
{
    struct import_request *r = *request;
    *request = NULL;
    if (!r) return;
    struct import *import = r->import;
    struct import_request **at = &import->requests;
    while (*at && *at != r) at = &(*at)->next;
    if (*at) *at = r->next;
    free(r);
    if (!import->requests) abandon(import);
}

void imports_stop(struct imports *s)
{
    struct import *next;
    s->stopped = true;
    for (struct import *import = s->list; import; import = next) {
        next = import->next;
        while (import->requests) {
            struct import_request *request = import->requests;
            import->requests = request->next;
            free(request);
        }
        import->waiting = false;
        abandon(import);
    }
}

void imports_destroy(struct imports **imports)
{
    if (*imports) assert(!(*imports)->list);
    free(*imports);
    *imports = NULL;
}
