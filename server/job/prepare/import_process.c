#include "server/job/prepare/import_process.h"

#include <assert.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "proto/json.h"
#include "server/job/prepare/import_answer.h"
#include "server/job/prepare/import_folder.h"

#define ANSWER_BYTES 65536 /* of the importer's one line of JSON */

/* Runs of one import whose process was killed from outside (SIGKILL: a person, or the kernel short
 * of memory). What it dies of by itself it would die of again. */
#define RUNS_MAX 5

/* Phases follow each other: files on the pool, the child on the loop, the blob on the pool. */
struct import_process {
    struct pool_task task; /* first: files or blob, one at a time */
    struct import_options options;
    struct digest scene;
    char variant[LIMIT_NAME_BYTES], animation[LIMIT_NAME_BYTES]; /* "": none */
    bool is_sequence;
    struct job_composite composite; /* owned */
    char ground[32];                /* its height */
    char *moves;                    /* owned; their text; NULL: none */
    char times[32 * IMPORT_TIMES];  /* seconds */
    char shutter[32];               /* the same; "": none */
    struct job_file *files;         /* owned, with their paths */
    uint32_t file_count;
    import_process_done done;
    void *ctx;
    atomic_bool cancelled; /* the pool looks, too */

    struct import_folder folder;
    struct fault fault;        /* code 0: none so far */
    struct import_blobs blobs; /* stored, and held */
    uint32_t frames;           /* files beside the base, as the child says */
    uint64_t cpu_us;

    uv_process_t child;
    uv_pipe_t out;
    uv_timer_t limit;
    unsigned handles; /* not yet closed */
    bool exited, silent, late;
    unsigned runs;
    int64_t status;
    int signal;
    char answer[ANSWER_BYTES];
    size_t answer_bytes;
};

static void destroy(struct import_process *p)
{
    for (uint32_t i = 0; i < p->file_count; i++) free(p->files[i].path);
    free(p->files);
    job_composite_fini(&p->composite);
    free(p->moves);
    free(p);
}

/* What passes is tried again; a program that is not there, or cannot be run, is not. */
static int error_of_spawn(int error)
{
    if (error == UV_ENOMEM) return ERR_MEMORY;
    return error == UV_EAGAIN || error == UV_EMFILE || error == UV_ENFILE ? ERR_IO
                                                                          : ERR_UNSUPPORTED;
}

static void start_child(struct import_process *p);

static bool was_killed(const struct import_process *p)
{
    return p->signal == SIGKILL && !p->late && !p->cancelled;
}

/* Runs the importer again. Its earlier output is overwritten. */
static void run_again(struct import_process *p)
{
    p->exited = p->silent = false;
    p->status = 0;
    p->signal = 0;
    p->answer_bytes = 0;
    start_child(p);
}

static int keep_frames(struct import_process *p)
{
    const struct objects *objects = p->options.objects;
    struct import_blobs *blobs = &p->blobs;
    int error = objects_adopt(objects, p->folder.blob, &blobs->base);
    while (!error && blobs->count < p->frames) {
        char path[sizeof p->folder.blob + 16];
        snprintf(path, sizeof path, "%s.%u", p->folder.blob, blobs->count);
        error = objects_adopt(objects, path, &blobs->list[blobs->count]);
        if (!error) blobs->count++;
    }
    return error;
}

static int keep_blob(struct import_process *p)
{
    int error = objects_adopt(p->options.objects, p->folder.blob, &p->blobs.list[0]);
    if (!error) p->blobs.count = 1;
    return error;
}

static void release(struct import_process *p)
{
    for (uint32_t i = 0; i < p->blobs.count; i++)
        objects_release(p->options.objects, &p->blobs.list[i]);
    if (!digest_is_zero(&p->blobs.base)) objects_release(p->options.objects, &p->blobs.base);
    p->blobs = (struct import_blobs){0};
}

/* The last phase: keep the blobs, if there are any, and clear up. */
static void finish_run(struct pool_task *task)
{
    struct import_process *p = (struct import_process *)task;
    if (!p->fault.code && !p->cancelled) {
        int error = p->frames > 0 ? keep_frames(p) : keep_blob(p);
        if (error) {
            fault_set(&p->fault, error, "", "the importer's blob could not be stored");
            release(p);
        }
    }
    import_folder_remove(&p->folder);
}

static void finish_done(struct pool_task *task)
{
    struct import_process *p = (struct import_process *)task;
    if (!p->cancelled)
        p->done(p->ctx, p->fault.code ? &p->fault : NULL, &p->blobs, p->cpu_us);
    else
        release(p);
    destroy(p);
}

/* A cancelled run gives the pool no more work: the pool may be about to end. */
static void finish(struct import_process *p)
{
    if (p->cancelled) {
        import_folder_remove(&p->folder);
        destroy(p);
        return;
    }
    p->task = (struct pool_task){.run = finish_run, .done = finish_done};
    thread_pool_submit(p->options.pool, &p->task);
}

static void read_answer(struct import_process *p)
{
    json_t *answer = NULL;
    struct fault ignored;
    const char *end = memchr(p->answer, '\n', p->answer_bytes);
    const size_t size_bytes = end ? (size_t)(end - p->answer) : p->answer_bytes;
    const int error = json_read(p->answer, size_bytes, ANSWER_BYTES, &answer, &ignored);
    double cpu_s = json_number_value(json_object_get(answer, "cpu_s"));
    if (cpu_s > 0 && cpu_s < 1e6) p->cpu_us = (uint64_t)(cpu_s * 1e6);
    const json_int_t frames = json_integer_value(json_object_get(answer, "frames"));
    if (p->is_sequence && frames > 0 && frames <= IMPORT_TIMES) p->frames = (uint32_t)frames;
    if (p->late)
        fault_set(&p->fault, ERR_TIMEOUT, "/scene/asset", "the import took longer than %llu s",
                  (unsigned long long)p->options.limit_ms / 1000);
    else if (p->signal)
        fault_set(&p->fault, ERR_KILLED, "/scene/asset",
                  "the importer was ended by signal %d (%s): the file is too large or damaged",
                  p->signal, strsignal(p->signal));
    else if (p->status != 0 && error == ERR_MEMORY)
        fault_set(&p->fault, error, "", "no memory to read the importer's answer");
    else if (p->status != 0)
        import_answer_refusal(answer, &p->fault);
    json_decref(answer);
}

static void closed(uv_handle_t *handle)
{
    struct import_process *p = handle->data;
    if (--p->handles > 0) return;
    if (was_killed(p) && p->runs < RUNS_MAX) {
        run_again(p);
        return;
    }
    if (!p->fault.code) read_answer(p);
    finish(p);
}

static void close_handle(uv_handle_t *handle)
{
    if (!uv_is_closing(handle)) uv_close(handle, closed);
}

/* Over when the child has gone and its output has ended. */
static void check_over(struct import_process *p)
{
    if (!p->exited || !p->silent) return;
    close_handle((uv_handle_t *)&p->child);
    close_handle((uv_handle_t *)&p->out);
    close_handle((uv_handle_t *)&p->limit);
}

static void on_exit_of_child(uv_process_t *child, int64_t status, int signal)
{
    struct import_process *p = child->data;
    p->exited = true;
    p->status = status;
    p->signal = signal;
    check_over(p);
}

static void on_limit(uv_timer_t *timer)
{
    struct import_process *p = timer->data;
    p->late = true;
    p->silent = true; /* a grandchild may hold the pipe */
    if (!p->exited) uv_process_kill(&p->child, SIGKILL);
    check_over(p);
}

static void on_space(uv_handle_t *handle, size_t suggested, uv_buf_t *buf)
{
    struct import_process *p = handle->data;
    (void)suggested;
    *buf = uv_buf_init(p->answer + p->answer_bytes, (unsigned)(ANSWER_BYTES - p->answer_bytes));
}

/* A child that says more than fits is cut off here and finds its pipe closed (EPIPE). */
static void on_output(uv_stream_t *out, ssize_t n, const uv_buf_t *buf)
{
    struct import_process *p = out->data;
    (void)buf;
    if (n > 0) p->answer_bytes += (size_t)n;
    if (n < 0) {
        p->silent = true;
        uv_read_stop(out);
        check_over(p);
    }
}

static void init_handles(struct import_process *p)
{
    p->child.data = p->out.data = p->limit.data = p;
    p->handles = 3;
    int error = uv_pipe_init(p->options.loop, &p->out, 0);
    assert(error == 0); /* neither allocates nor asks the kernel */
    error = uv_timer_init(p->options.loop, &p->limit);
    assert(error == 0);
}

/* What tells the importer of a composite. */
static size_t add_roles(struct import_process *p, char **args, size_t count)
{
    static char none[] = "[]", fused[] = "fused", always[] = "estimate", unless_lit[] = "auto";
    const struct job_composite *c = &p->composite;
    if (!c->on) return count;
    args[count++] = "--catchers", args[count++] = c->catchers ? c->catchers : none;
    if (c->holdouts) args[count++] = "--holdouts", args[count++] = c->holdouts;
    snprintf(p->ground, sizeof p->ground, "%.9g", (double)c->ground_height);
    if (c->has_ground) args[count++] = "--ground", args[count++] = p->ground;
    if (c->rgbd) args[count++] = "--rgbd", args[count++] = c->rgbd;
    if (c->rgbd && c->surfaces == RGBD_FUSED) args[count++] = "--surfaces", args[count++] = fused;
    if (c->estimate != RGBD_ESTIMATE_NONE)
        args[count++] = "--light",
        args[count++] = c->estimate == RGBD_ESTIMATE_ALWAYS ? always : unless_lit;
    return count;
}

static int spawn(struct import_process *p)
{
    char *args[32] = {(char *)p->options.program,
                      "--root",
                      p->folder.root,
                      "--in",
                      p->folder.main_name,
                      "--out",
                      p->folder.blob,
                      p->is_sequence ? "--times" : "--time",
                      p->times};
    size_t count = 9;
    if (p->variant[0]) args[count++] = "--variant", args[count++] = p->variant;
    if (p->shutter[0]) args[count++] = "--shutter", args[count++] = p->shutter;
    if (p->animation[0]) args[count++] = "--animation", args[count++] = p->animation;
    if (p->moves) args[count++] = "--moves", args[count++] = p->moves;
    count = add_roles(p, args, count);
    assert(count < sizeof args / sizeof *args); /* NULL ends them */
    uv_stdio_container_t stdio[3] = {
        {.flags = UV_IGNORE},
        {.flags = (uv_stdio_flags)(UV_CREATE_PIPE | UV_WRITABLE_PIPE),
         .data.stream = (uv_stream_t *)&p->out},
        {.flags = UV_INHERIT_FD, .data.fd = 2},
    };
    uv_process_options_t options = {.file = p->options.program,
                                    .args = args,
                                    .cwd = p->folder.root,
                                    .exit_cb = on_exit_of_child,
                                    .stdio = stdio,
                                    .stdio_count = 3};
    return uv_spawn(p->options.loop, &p->child, &options);
}

static void start_child(struct import_process *p)
{
    p->runs++;
    init_handles(p);
    int error = spawn(p);
    if (error) {
        fault_set(&p->fault, error_of_spawn(error), "", "%s: %s", p->options.program,
                  uv_strerror(error));
        p->exited = p->silent = true;
        check_over(p);
        return;
    }
    uv_read_start((uv_stream_t *)&p->out, on_space, on_output);
    uv_timer_start(&p->limit, on_limit, p->options.limit_ms, 0);
}

static void files_run(struct pool_task *task)
{
    struct import_process *p = (struct import_process *)task;
    if (!p->cancelled)
        import_folder_make(p->options.objects, &p->scene, p->files, p->file_count, &p->folder,
                           &p->fault);
}

static void files_done(struct pool_task *task)
{
    struct import_process *p = (struct import_process *)task;
    if (p->cancelled || p->fault.code)
        finish(p);
    else
        start_child(p);
}

static int copy_files(struct import_process *p, const struct job *scene)
{
    if (scene->file_count == 0) return 0;
    p->files = calloc(scene->file_count, sizeof *p->files);
    if (!p->files) return ERR_MEMORY;
    for (uint32_t i = 0; i < scene->file_count; i++) {
        p->files[i].asset = scene->files[i].asset;
        p->files[i].path = strdup(scene->files[i].path);
        if (!p->files[i].path) return ERR_MEMORY;
        p->file_count++;
    }
    return 0;
}

static void write_times(struct import_process *p, const struct job *scene,
                        const struct import_times *times)
{
    size_t used = 0;
    const double shutter_s = job_shutter_s(scene);
    p->is_sequence = times->count > 0;
    if (p->is_sequence && shutter_s > 0)
        snprintf(p->shutter, sizeof p->shutter, "%.17g", shutter_s);
    if (!p->is_sequence) snprintf(p->times, sizeof p->times, "%.17g", scene->time_s);
    for (uint32_t i = 0; i < times->count; i++)
        used += (size_t)snprintf(p->times + used, sizeof p->times - used, "%s%.17g",
                                 i > 0 ? "," : "", times->list[i]);
}

int import_process_start(const struct import_options *options, const struct job *scene,
                         const struct import_times *times, import_process_done done, void *ctx,
                         struct import_process **out)
{
    struct import_process *p = calloc(1, sizeof *p);
    if (!p) return ERR_MEMORY;
    p->options = *options;
    p->scene = scene->scene;
    memcpy(p->variant, scene->variant, sizeof p->variant);
    memcpy(p->animation, scene->animation, sizeof p->animation);
    write_times(p, scene, times);
    p->done = done;
    p->ctx = ctx;
    if (copy_files(p, scene) != 0 || job_moves_text(&scene->moves, &p->moves) != 0 ||
        job_composite_copy(&scene->composite, &p->composite) != 0) {
        destroy(p);
        return ERR_MEMORY;
    }
    p->task = (struct pool_task){.run = files_run, .done = files_done};
    thread_pool_submit(options->pool, &p->task);
    *out = p;
    return 0;
}

void import_process_cancel(struct import_process **process)
{
    struct import_process *p = *process;
    *process = NULL;
    if (!p) return;
    p->cancelled = true;
    if (p->handles > 0 && !p->exited) uv_process_kill(&p->child, SIGKILL);
}
