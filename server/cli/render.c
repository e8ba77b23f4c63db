/* shearwater render: one job through a private coordinator, files out, nothing left behind. */
#include <errno.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "proto/job/job.h"
#include "proto/runtime/clock.h"
#include "server/cli/cli.h"
#include "server/cli/client/output_file.h"
#include "server/cli/embedded_server.h"
#include "server/cli/frame_files.h"
#include "server/cli/job_file.h"
#include "server/cli/job_watch.h"
#include "server/cli/option.h"

#define WORKER_TRIES 1200 /* of 25 ms: half a minute */

struct render_options {
    const char *exr, *png, *stats;
    long workers, worker_threads;
    struct job_changes changes;
    bool quiet;
};

static volatile sig_atomic_t interrupted;

/* The command then ends in order: its server stops and its files go. */
static void on_signal(int number)
{
    interrupted = number;
}

/* Lets signals interrupt calls instead of resuming them, as a pipe without a reader would block for
 * ever. */
static void catch_signals(void)
{
    const struct sigaction action = {.sa_handler = on_signal};
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
}

static int parse(int argc, char **argv, struct render_options *o)
{
    const struct option_line lines[] = {
        {"output", 'o', OPTION_TEXT, "OUT.exr", "EXR file with all layers", 0, 0, &o->exr},
        {"png", 'p', OPTION_TEXT, "OUT.png", "the composite or beauty as the job's view shows it",
         0, 0, &o->png},
        {"workers", 'w', OPTION_NUMBER, "N", "worker processes (default: 1)", 1, LIMIT_WORKERS,
         &o->workers},
        {"worker-threads", 0, OPTION_NUMBER, "N",
         "threads per worker (default: the cores, divided among the workers)", 1, LIMIT_THREADS,
         &o->worker_threads},
        {"tile", 0, OPTION_NUMBER, "N", "side of a tile in pixels, instead of the job's",
         LIMIT_TILE_SIDE_MIN_PX, LIMIT_TILE_SIDE_PX, &o->changes.tile_px},
        JOB_CHANGES_OPTIONS(&o->changes),
        {"stats", 0, OPTION_TEXT, "STATS.json", "rays, skipped work, CPU seconds and memory", 0, 0,
         &o->stats},
        {"quiet", 'q', OPTION_FLAG, NULL, "no progress on standard error", 0, 0, &o->quiet},
    };
    const struct option_table table = {
        .usage = "shearwater render JOB.json|SCENE [-o OUT.exr] [--png OUT.png] [options]",
        .summary =
            "Renders one job, or a scene (.glb, .gltf, .obj) with all defaults, with a "
            "private coordinator and local workers, and leaves nothing "
            "behind but its files. The frame's number takes the place of # in a file's name, "
            "as in shot.####.exr, or goes before the ending if the job has several frames.",
        .lines = lines,
        .line_count = sizeof lines / sizeof *lines,
        .least_arguments = 1,
        .most_arguments = 1,
    };
    int arguments;
    return option_parse(&table, argc, argv, &arguments);
}

/* Checks outputs before the work, so that a missing folder is not noticed hours later. */
static int check_outputs(const struct render_options *o, struct fault *fault)
{
    int error = o->exr ? output_file_check_picture(o->exr, "exr", fault) : 0;
    if (!error && o->png) error = output_file_check_picture(o->png, "png", fault);
    if (!error && o->stats) error = output_file_check(o->stats, fault);
    const char *const all[] = {o->exr, o->png, o->stats};
    return error ? error : output_files_check_apart(all, sizeof all / sizeof *all, fault);
}

/* Checks the names of several frames likewise. The last one's is the longest. */
static int check_frames(const struct render_options *o, const json_t *document, struct fault *fault)
{
    struct job job;
    const char *const outputs[] = {o->exr, o->png}, *const endings[] = {"exr", "png"};
    int error = 0;
    json_t *asked = o->changes.frames ? json_pack("{s:s}", "frames", o->changes.frames) : NULL;
    const bool wrong = job_frames_of(asked ? asked : document, &job) != 0;
    json_decref(asked);
    if (wrong) return 0; /* the server says why */
    const uint32_t count = job_frame_count(&job);
    for (int k = 0; k < 2 && !error; k++) {
        char path[4096];
        if (!outputs[k]) continue;
        frame_files_path(outputs[k], job_frame_number(&job, count - 1), count > 1, path,
                         sizeof path);
        error = output_file_check_picture(path, endings[k], fault);
    }
    return error;
}

/* A worker that cannot run, or is of another build and refused, says so itself; but the job would
 * wait for it for ever. */
static int await_worker(struct client *c, struct fault *fault)
{
    for (int i = 0; i < WORKER_TRIES && !interrupted; i++) {
        json_t *roster = NULL;
        int error = client_json(c, "GET", "/v1/workers", NULL, &roster, fault);
        bool there = json_array_size(json_object_get(roster, "workers")) > 0;
        json_decref(roster);
        if (error || there) return error;
        nanosleep(&(struct timespec){.tv_nsec = 25000000}, NULL);
    }
    return fault_set(fault, ERR_KILLED, "",
                     interrupted ? "interrupted"
                                 : "no worker has come up: shearwater-worker does not start");
}

static double seconds(struct timeval t)
{
    return (double)t.tv_sec + (double)t.tv_usec * 1e-6;
}

/* The job's statistics, with what only this side can know: the wall time that the user waited, and
 * the CPU time of all processes, asked of the operating system once they have ended. */
static int save_statistics(const json_t *job, const char *path, double wall_s,
                           const struct rusage *usage, struct fault *fault)
{
    json_t *statistics = json_deep_copy(json_object_get(job, "statistics"));
    if (!statistics) statistics = json_object();
    json_t *cpu = json_object_get(statistics, "cpu_s");
    if (cpu)
        json_object_set_new(cpu, "total",
                            json_real(seconds(usage->ru_utime) + seconds(usage->ru_stime)));
    json_object_set_new(statistics, "wall_s", json_real(wall_s));
    int failed = json_dump_file(statistics, path, JSON_INDENT(2));
    json_decref(statistics);
    return failed ? fault_set(fault, ERR_IO, "", "%s: %s", path, strerror(errno)) : 0;
}

static void say_done(struct progress *progress, const struct render_options *o, double wall_s)
{
    char line[512];
    const bool none = !o->exr && !o->png;
    snprintf(line, sizeof line, "finished in %.2f s%s%s%s%s%s", wall_s, o->exr ? ", wrote " : "",
             o->exr ? o->exr : "", o->png ? (o->exr ? " and " : ", wrote ") : "",
             o->png ? o->png : "", none ? "; -o OUT.exr or -p OUT.png would keep the picture" : "");
    progress_end(progress, line);
}

static void show_warnings(const json_t *job)
{
    size_t i;
    json_t *text;
    json_array_foreach (json_object_get(job, "warnings"), i, text)
        fprintf(stderr, "warning: %s\n", json_string_value(text) ? json_string_value(text) : "");
}

/* Submits, watches, saves. *job (new reference) stays for the statistics. */
static int render(struct client *c, const char *path, json_t *document,
                  const struct render_options *o, struct progress *progress, json_t **job,
                  struct fault *fault)
{
    char id[64];
    json_t *accepted = NULL;
    int error = job_file_submit(c, path, &o->changes, document, &accepted, fault);
    if (error) return error;
    snprintf(id, sizeof id, "%s", json_string_value(json_object_get(accepted, "id")));
    json_decref(accepted);
    error = await_worker(c, fault);
    if (!error) error = job_watch(c, id, progress, job, fault);
    if (!error) error = frame_files_save(c, *job, o->exr, o->png, fault);
    return error;
}

static double now_s(void)
{
    return (double)clock_us(CLOCK_MONOTONIC) * 1e-6;
}

int cli_render(int argc, char **argv)
{
    struct render_options o = {.changes = JOB_CHANGES_NONE};
    struct fault fault = {0};
    struct embedded_server server = {0};
    struct progress progress;
    struct client *client = NULL;
    struct rusage usage = {0};
    json_t *document = NULL, *job = NULL;
    int status = parse(argc, argv, &o);
    if (status != OPTION_GO_ON) return status;
    double start_s = now_s();
    progress_begin(&progress, o.quiet);
    /* Before there is anything to clear up. */
    catch_signals();
    int error = check_outputs(&o, &fault);
    if (!error) error = job_file_read(argv[1], &document, &fault);
    if (!error) error = check_frames(&o, document, &fault);
    if (!error)
        error =
            embedded_server_start(&server, (unsigned)o.workers, (unsigned)o.worker_threads, &fault);
    if (!error) error = client_create(server.base_url, &client);
    if (!error) client_stop_on(client, &interrupted);
    if (!error) error = render(client, argv[1], document, &o, &progress, &job, &fault);
    double wall_s = now_s() - start_s;
    client_destroy(&client); /* a server without connections ends at once */
    embedded_server_stop(&server, &usage);
    if (!error && o.stats) error = save_statistics(job, o.stats, wall_s, &usage, &fault);
    if (error) {
        if (!fault.code) fault_set(&fault, error, "", "%s", error_text(error));
        progress_end(&progress, NULL);
        status = job_file_complain("render", &fault);
        if (interrupted) status = 128 + (int)interrupted;
    } else {
        if (!o.quiet) show_warnings(job);
        say_done(&progress, &o, wall_s);
        status = 0;
    }
    json_decref(document);
    json_decref(job);
    return status;
}
