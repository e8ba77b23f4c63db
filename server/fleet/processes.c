#include "server/fleet/processes.h"

#include <signal.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define REFUSED_STATUS 3 /* exit status of a worker that was refused */

struct child {
    uv_process_t process;
    uv_timer_t timer; /* restart, or the end of patience */
    struct processes *owner;
    bool running; /* `process` is an open handle of a living child */
    uint64_t started_ms;
    unsigned failures; /* short lives in a row */
    unsigned number;
};

struct processes {
    uv_loop_t *loop;
    char *program, *address, *cache_dir, *blob_dir; /* owned */
    char threads[16];
    const char *log_format; /* static */
    bool quiet;
    uint64_t *respawned;
    unsigned count;
    unsigned open_handles;
    bool closing;
    void (*stopped)(void *ctx, int64_t pid);
    void *stopped_ctx;
    void (*closed)(void *ctx);
    void *ctx;
    struct child children[];
};

static void release(struct processes *p)
{
    void (*closed)(void *ctx) = p->closed;
    void *ctx = p->ctx;
    free(p->program);
    free(p->address);
    free(p->cache_dir);
    free(p->blob_dir);
    free(p);
    if (closed) closed(ctx);
}

static void release_if_gone(struct processes *p)
{
    if (p->closing && p->open_handles == 0) release(p);
}

static void on_timer_closed(uv_handle_t *handle)
{
    struct child *c = handle->data;
    c->owner->open_handles--;
    release_if_gone(c->owner);
}

static void close_timer(struct child *c)
{
    if (!uv_is_closing((uv_handle_t *)&c->timer))
        uv_close((uv_handle_t *)&c->timer, on_timer_closed);
}

static void spawn(struct child *c);

static void on_restart(uv_timer_t *timer)
{
    struct child *c = timer->data;
    (*c->owner->respawned)++;
    spawn(c);
}

static uint64_t restart_delay_ms(const struct child *c)
{
    uint64_t delay_ms = PROCESSES_RETRY_MS;
    for (unsigned i = 1; i < c->failures && delay_ms < PROCESSES_RETRY_MAX_MS; i++) delay_ms *= 2;
    return delay_ms < PROCESSES_RETRY_MAX_MS ? delay_ms : PROCESSES_RETRY_MAX_MS;
}

static void on_process_closed(uv_handle_t *handle)
{
    struct child *c = handle->data;
    struct processes *p = c->owner;
    c->running = false;
    p->open_handles--;
    if (p->closing)
        close_timer(c);
    else if (c->failures > 0)
        uv_timer_start(&c->timer, on_restart, restart_delay_ms(c), 0);
    release_if_gone(p);
}

static bool is_from_outside(int signal)
{
    return signal == SIGKILL || signal == SIGTERM || signal == SIGINT || signal == SIGHUP ||
           signal == SIGQUIT;
}

static void on_exit_of_child(uv_process_t *process, int64_t status, int signal)
{
    struct child *c = process->data;
    if (c->owner->stopped && is_from_outside(signal))
        c->owner->stopped(c->owner->stopped_ctx, process->pid);
    bool healthy = uv_now(process->loop) - c->started_ms >= PROCESSES_HEALTHY_MS;
    if (signal == 0 && status == REFUSED_STATUS)
        c->failures = 0; /* stays down */
    else
        c->failures = healthy ? 1 : c->failures + 1;
    uv_close((uv_handle_t *)process, on_process_closed);
}

#define ARGS_MAX 20

/* The coordinator, and what shows the picture, go before tracing on the same CPUs. */
#define LOCAL_NICE "10"

static void fill_args(struct processes *p, char *name, char *args[ARGS_MAX])
{
    char *const given[ARGS_MAX] = {
        p->program, "--connect", p->address,     "--threads",
        p->threads, "--name",    name,           "--exit-with-parent",
        "--nice",   LOCAL_NICE,  "--log-format", (char *)(uintptr_t)p->log_format};
    size_t n = 0;
    while (given[n]) {
        args[n] = given[n];
        n++;
    }
    if (p->cache_dir) {
        args[n++] = "--cache";
        args[n++] = p->cache_dir;
    }
    if (p->blob_dir) {
        args[n++] = "--blobs";
        args[n++] = p->blob_dir;
    }
    if (p->quiet) args[n++] = "--quiet";
    args[n] = NULL;
}

static void spawn(struct child *c)
{
    struct processes *p = c->owner;
    char name[32];
    snprintf(name, sizeof name, "local-%u", c->number + 1);
    char *args[ARGS_MAX];
    fill_args(p, name, args);
    uv_stdio_container_t stdio[3] = {{.flags = UV_IGNORE},
                                     {.flags = UV_INHERIT_FD, .data.fd = STDERR_FILENO},
                                     {.flags = UV_INHERIT_FD, .data.fd = STDERR_FILENO}};
    uv_process_options_t options = {.file = p->program,
                                    .args = args,
                                    .exit_cb = on_exit_of_child,
                                    .stdio = stdio,
                                    .stdio_count = 3};
    c->started_ms = uv_now(p->loop);
    c->process.data = c;
    int status = uv_spawn(p->loop, &c->process, &options);
    c->running = true; /* the handle is open in any case */
    p->open_handles++;
    if (status == 0) return;
    c->failures++; /* tried again later, like a child that died at once */
    uv_close((uv_handle_t *)&c->process, on_process_closed);
}

static char *copy(const char *text)
{
    return text ? strdup(text) : NULL;
}

static struct processes *allocate(uv_loop_t *loop, const struct processes_options *o,
                                  uint64_t *respawned)
{
    struct processes *p = calloc(1, sizeof *p + o->count * sizeof p->children[0]);
    if (!p) return NULL;
    p->loop = loop;
    p->respawned = respawned;
    p->count = o->count;
    p->log_format = log_format_name(o->log ? o->log->format : LOG_TEXT);
    p->quiet = o->log && o->log->least > LOG_WARNING;
    p->stopped = o->stopped;
    p->stopped_ctx = o->ctx;
    p->program = copy(o->program);
    p->cache_dir = copy(o->cache_dir);
    p->blob_dir = copy(o->blob_dir);
    snprintf(p->threads, sizeof p->threads, "%u", o->threads);
    if (asprintf(&p->address, "unix:%s", o->socket_path) < 0) p->address = NULL;
    if (p->program && p->address && (p->cache_dir || !o->cache_dir) &&
        (p->blob_dir || !o->blob_dir))
        return p;
    release(p);
    return NULL;
}

int processes_create(uv_loop_t *loop, const struct processes_options *options, uint64_t *respawned,
                     struct processes **out, struct fault *fault)
{
    const char *program = options->program ? options->program : "";
    if (access(program, X_OK) != 0)
        return fault_set(fault, ERR_NOT_FOUND, program, "the worker program cannot be run");
    struct processes *p = allocate(loop, options, respawned);
    if (!p) return fault_set(fault, ERR_MEMORY, "workers", "%s", error_text(ERR_MEMORY));
    for (unsigned i = 0; i < p->count; i++) {
        struct child *c = &p->children[i];
        c->owner = p;
        c->number = i;
        uv_timer_init(loop, &c->timer);
        c->timer.data = c;
        p->open_handles++;
        spawn(c);
    }
    *out = p;
    return 0;
}

void processes_end(struct processes *p, int64_t pid)
{
    for (unsigned i = 0; i < p->count; i++) {
        struct child *c = &p->children[i];
        const bool lives = c->running && !uv_is_closing((uv_handle_t *)&c->process);
        if (lives && c->process.pid == pid) uv_process_kill(&c->process, SIGKILL);
    }
}

static void on_patience_ended(uv_timer_t *timer)
{
    struct child *c = timer->data;
    if (c->running) uv_process_kill(&c->process, SIGKILL);
}

void processes_close(struct processes *p, void (*closed)(void *ctx), void *ctx)
{
    p->closing = true;
    p->closed = closed;
    p->ctx = ctx;
    for (unsigned i = 0; i < p->count; i++) {
        struct child *c = &p->children[i];
        if (!c->running) {
            close_timer(c);
            continue;
        }
        if (!uv_is_closing((uv_handle_t *)&c->process)) uv_process_kill(&c->process, SIGTERM);
        uv_timer_start(&c->timer, on_patience_ended, PROCESSES_KILL_MS, 0);
    }
}
