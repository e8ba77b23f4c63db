/* shearwater replay: one sample of a job once more, with all that its path does.
 *
 * A private coordinator without workers imports the scene and makes the plan, as for a render; the
 * worker's program, which alone knows how samples are traced, prints the rest. */
#include <errno.h>
#include <signal.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "server/cli/cli.h"
#include "server/cli/directories.h"
#include "server/cli/embedded_server.h"
#include "server/cli/job_file.h"
#include "server/cli/option.h"

struct replay_options {
    struct job_changes changes;
    long frame;
    bool json;
};

/* What the command line says of the job, and where things are. */
struct replayed {
    struct embedded_server server;
    char worker[DIRECTORIES_PATH_BYTES];
    char plan[320], blobs[320];
};

static volatile sig_atomic_t interrupted;

static void on_signal(int number)
{
    interrupted = number;
}

static int parse(int argc, char **argv, struct replay_options *o)
{
    const struct option_line lines[] = {
        {"frame", 'f', OPTION_NUMBER, "N", "the frame (default: the job's first)", 0, INT32_MAX,
         &o->frame},
        {"json", 'j', OPTION_FLAG, NULL, "print JSON", 0, 0, &o->json},
        JOB_CHANGES_OPTIONS(&o->changes),
    };
    const struct option_table table = {
        .usage = "shearwater replay JOB.json|SCENE X,Y SAMPLE [options]",
        .summary =
            "Traces one sample of a job again and prints every step: path number SAMPLE, from "
            "0, of the pixel in column X and row Y, from the top left.",
        .lines = lines,
        .line_count = sizeof lines / sizeof *lines,
        .least_arguments = 3,
        .most_arguments = 3,
    };
    int arguments;
    return option_parse(&table, argc, argv, &arguments);
}

static int choose_frame(json_t *document, long frame, struct fault *fault)
{
    if (frame < 0) return 0;
    const json_int_t n = frame;
    if (json_object_set_new(document, "frames", json_pack("{s:I, s:I}", "first", n, "last", n)))
        return fault_set(fault, ERR_MEMORY, "", "memory is exhausted");
    return 0;
}

static int save_plan(const char *path, const struct replay_options *o, struct replayed *r,
                     struct fault *fault)
{
    json_t *document = NULL;
    struct client *client = NULL;
    int error = job_file_read(path, &document, fault);
    if (!error) error = choose_frame(document, o->frame, fault);
    if (!error) error = embedded_server_start(&r->server, EMBEDDED_SERVER_ALONE, 0, fault);
    snprintf(r->plan, sizeof r->plan, "%s/plan", r->server.data_dir);
    snprintf(r->blobs, sizeof r->blobs, "%s/objects", r->server.data_dir);
    if (!error) error = client_create(r->server.base_url, &client);
    if (!error) client_stop_on(client, &interrupted);
    if (!error) error = job_file_prepare(client, path, &o->changes, document, fault);
    if (!error)
        error = client_post_download(client, "/v1/jobs?dry_run=1", document,
                                     "application/octet-stream", r->plan, fault);
    client_destroy(&client);
    json_decref(document);
    return error;
}

/* The worker says by itself what is wrong. */
static int run_worker(struct replayed *r, char **arguments, const struct replay_options *o,
                      int *status, struct fault *fault)
{
    char *argv[] = {r->worker, "--replay", r->plan,   arguments[0],       arguments[1],
                    "--blobs", r->blobs,   "--cache", r->server.data_dir, o->json ? "--json" : NULL,
                    NULL};
    const pid_t pid = fork();
    int ended;
    if (pid == 0) {
        execv(r->worker, argv);
        _exit(127);
    }
    if (pid < 0) return fault_set(fault, ERR_IO, "", "fork: %s", strerror(errno));
    while (waitpid(pid, &ended, 0) < 0 && errno == EINTR) {
    }
    if (WIFSIGNALED(ended) && !interrupted)
        return fault_set(fault, ERR_STATE, "", "the worker was ended by signal %d (%s)",
                         WTERMSIG(ended), strsignal(WTERMSIG(ended)));
    *status = WIFEXITED(ended) ? WEXITSTATUS(ended) : 1;
    return 0;
}

int cli_replay(int argc, char **argv)
{
    struct replay_options o = {.changes = JOB_CHANGES_NONE, .frame = -1};
    struct replayed r = {0};
    struct fault fault = {0};
    int status = parse(argc, argv, &o);
    if (status != OPTION_GO_ON) return status;
    /* Before there is anything to clear up. */
    signal(SIGINT, on_signal);
    signal(SIGTERM, on_signal);
    int error = directories_find_worker(r.worker, &fault);
    if (!error) error = save_plan(argv[1], &o, &r, &fault);
    if (!error) error = run_worker(&r, argv + 2, &o, &status, &fault);
    embedded_server_stop(&r.server, NULL);
    if (!error) return status;
    if (!fault.code) fault_set(&fault, error, "", "%s", error_text(error));
    status = job_file_complain("replay", &fault);
    return interrupted ? 128 + (int)interrupted : status;
}
