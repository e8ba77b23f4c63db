/* shearwater-worker: dials a coordinator and traces tiles for it; or replays a sample. */
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include "proto/runtime/build.h"
#include "worker/process/malloc_tuning.h"
#include "worker/process/options.h"
#include "worker/process/worker_name.h"
#include "worker/replay/replay.h"
#include "worker/session/session.h"

#define STATUS_USAGE 2

/* Embree is asked for a device before the loop runs: where that hangs SIGALRM ends the process. */
#define BEGINNING_S 120u

struct program {
    uv_loop_t *loop;
    struct session *session;
    const struct options *options;
    struct worker_log worker_log;
    uv_signal_t term, interrupt;
    enum session_end end;
};

static void on_closed(void *ctx)
{
    struct program *p = ctx;
    uv_close((uv_handle_t *)&p->term, NULL);
    uv_close((uv_handle_t *)&p->interrupt, NULL);
}

static void on_ended(void *ctx, enum session_end end, const char *text)
{
    struct program *p = ctx;
    p->end = end;
    const struct log_field field = {"detail", text, 0};
    if (text[0])
        worker_log_write(&p->worker_log, LOG_ERROR,
                         end == SESSION_END_REFUSED ? "refused by the coordinator" : "ended",
                         &field, 1);
    session_close(p->session, on_closed, p);
    p->session = NULL;
}

/* Loading a scene cannot be stopped and is not waited for: the process may end during it. */
static void on_flushed(void *ctx, bool is_loading)
{
    struct program *p = ctx;
    if (!is_loading) return;
    log_end(&p->worker_log.log);
    _exit((int)p->end);
}

static void on_signal(uv_signal_t *signal, int number)
{
    (void)number;
    struct program *p = signal->data;
    if (p->session) session_stop(p->session);
}

/* Ignores a terminal's Ctrl-C, which reaches the coordinator's children, too. The coordinator
 * decides for them. */
static void on_ignored(uv_signal_t *signal, int number)
{
    (void)signal;
    (void)number;
}

static void watch_signals(struct program *p)
{
    uv_signal_init(p->loop, &p->term);
    uv_signal_init(p->loop, &p->interrupt);
    p->term.data = p->interrupt.data = p;
    uv_signal_start(&p->term, on_signal, SIGTERM);
    uv_signal_start(&p->interrupt, p->options->exit_with_parent ? on_ignored : on_signal, SIGINT);
    signal(SIGPIPE, SIG_IGN);
}

/* The parent may be gone before the kernel knows that we want to hear of it. Had it gone even
 * earlier, its socket does not answer, and the session ends by that. */
static bool tie_to_parent(void)
{
    pid_t parent = getppid();
    return prctl(PR_SET_PDEATHSIG, SIGKILL) == 0 && getppid() == parent;
}

/* Replays a sample. Returns 0, or 1 when it cannot. */
static int replay(const struct options *options)
{
    struct fault fault = {0};
    if (replay_print(options, stdout, &fault) == 0 && fflush(stdout) == 0) return 0;
    fprintf(stderr, "shearwater-worker: %s%s%s\n", fault.pointer, fault.pointer[0] ? ": " : "",
            fault.detail[0] ? fault.detail : "standard output cannot be written");
    return SESSION_END_FAILED;
}

static int run(const struct options *options)
{
    uv_loop_t loop;
    struct fault fault = {0};
    struct program p = {.loop = &loop, .options = options};
    const struct session_client client = {&p, &p.worker_log, on_ended, on_flushed};
    p.worker_log = (struct worker_log){.log = {.fd = STDERR_FILENO}, .worker = options->name};
    (void)log_format_from_name(options->log_format, &p.worker_log.log.format);
    if (options->quiet) p.worker_log.log.least = LOG_ERROR;
    log_begin(&p.worker_log.log);
    uv_loop_init(&loop);
    alarm(BEGINNING_S);
    int e = session_create(&loop, options, &tracing_embree, &client, &p.session, &fault);
    alarm(0);
    if (e) {
        const struct log_field fields[] = {{"place", fault.pointer, 0},
                                           {"detail", fault.detail, 0}};
        worker_log_write(&p.worker_log, LOG_ERROR, "cannot work", fields, 2);
        p.end = SESSION_END_FAILED;
    } else {
        watch_signals(&p);
        session_start(p.session);
    }
    uv_run(&loop, UV_RUN_DEFAULT);
    uv_loop_close(&loop);
    log_end(&p.worker_log.log);
    return (int)p.end;
}

int main(int argc, char **argv)
{
    static char cache_dir[4096], name[LIMIT_NAME_BYTES];
    struct options options;
    struct fault fault = {0};
    if (options_read(argc, argv, &options, &fault) != 0) {
        fprintf(stderr, "shearwater-worker: %s: %s\n", fault.pointer, fault.detail);
        return STATUS_USAGE;
    }
    if (options.help || options.version || options.dump) {
        if (options.help)
            options_print_help(stdout);
        else if (options.dump)
            options_dump(stdout);
        else
            printf("shearwater-worker %s\n", build_id());
        return 0;
    }
    malloc_tuning_apply();
    if (options.nice > 0) setpriority(PRIO_PROCESS, 0, (int)options.nice); /* before any thread */
    if (!options.cache_dir && options_default_cache(cache_dir, sizeof cache_dir) == 0)
        options.cache_dir = cache_dir;
    if (!options.name && worker_name_default(name, sizeof name) == 0) options.name = name;
    if (options.replay) return replay(&options);
    if (options.exit_with_parent && !tie_to_parent()) return SESSION_END_FAILED;
    return run(&options);
}
