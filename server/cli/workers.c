/* shearwater workers: the roster of a coordinator as a table, or an array of workers for Slurm. */
#include <errno.h>
#include <gnutls/gnutls.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "proto/limits.h"
#include "proto/link/link_key.h"
#include "server/cli/cli.h"
#include "server/cli/client/client_target.h"
#include "server/cli/directories.h"
#include "server/cli/job_file.h"
#include "server/cli/option.h"
#include "server/cli/slurm_array.h"

static const char *text_of(const json_t *worker, const char *member)
{
    const char *text = json_string_value(json_object_get(worker, member));
    return text ? text : "-";
}

static long long number_of(const json_t *worker, const char *member)
{
    return (long long)json_integer_value(json_object_get(worker, member));
}

static void print_roster(const json_t *workers)
{
    size_t i;
    json_t *w;
    printf("%-16s %-28s %-10s %7s %-8s %8s %10s %s\n", "ID", "NAME", "STATE", "THREADS", "ISA",
           "IN HAND", "TILES DONE", "BUILD");
    json_array_foreach (workers, i, w)
        printf("%-16lld %-28.28s %-10s %7lld %-8s %8lld %10lld %s\n", number_of(w, "id"),
               text_of(w, "name"), text_of(w, "state"), number_of(w, "threads"), text_of(w, "isa"),
               number_of(w, "tiles_in_hand"), number_of(w, "tiles_done"), text_of(w, "build"));
}

static int list(const struct client_target *target, bool as_json)
{
    struct fault fault = {0};
    struct client *client = NULL;
    json_t *answer = NULL;
    int error = client_target_open(target, &client, &fault);
    if (!error) error = client_json(client, "GET", "/v1/workers", NULL, &answer, &fault);
    if (!error && as_json) {
        json_dumpf(answer, stdout, JSON_INDENT(2));
        putchar('\n');
    } else if (!error) {
        print_roster(json_object_get(answer, "workers"));
    }
    client_destroy(&client);
    json_decref(answer);
    return error ? job_file_complain("workers", &fault) : 0;
}

/* ---- launch ---- */

struct launch {
    struct slurm_array array;
    const char *time;
    bool print;
};

/* Checks the key now: a worker could say what is wrong with it in its log only. */
static int find_key(struct slurm_array *array, char path[PATH_MAX], struct fault *fault)
{
    struct link_key key;
    if (!realpath(array->key, path))
        return fault_set(fault, ERR_NOT_FOUND, array->key, "%s", strerror(errno));
    array->key = path;
    const int error = link_key_read(path, &key, fault);
    gnutls_memset(&key, 0, sizeof key);
    return error;
}

static int check_launch(struct launch *l, struct fault *fault)
{
    if (!l->array.connect)
        return fault_set(fault, ERR_MISSING, "--connect", "give the coordinator's HOST:PORT");
    if (!l->array.key)
        return fault_set(fault, ERR_MISSING, "--key", "give the file of the coordinator's key");
    const int error = slurm_array_read_time(l->time, &l->array.time_s, fault);
    return error ? error : slurm_array_check(&l->array, fault);
}

/* Makes the paths those that nodes see, and checks them as they then are. */
static int find_paths(struct slurm_array *array, char key[PATH_MAX],
                      char program[DIRECTORIES_PATH_BYTES], struct fault *fault)
{
    int error = find_key(array, key, fault);
    if (!error && !array->program) {
        error = directories_find_worker(program, fault);
        array->program = program;
    }
    return error ? error : slurm_array_check(array, fault);
}

static int launch(struct launch *l)
{
    char key[PATH_MAX], program[DIRECTORIES_PATH_BYTES];
    struct fault fault = {0};
    if (check_launch(l, &fault) != 0) {
        job_file_complain("workers", &fault);
        return 2;
    }
    struct slurm_array array = l->array;
    array.isa = getenv("SHEARWATER_ISA");
    int error = find_paths(&array, key, program, &fault);
    if (!error && l->print && slurm_array_write(&array, stdout) != 0)
        error = fault_set(&fault, ERR_IO, "standard output", "%s", strerror(errno));
    if (!error && !l->print) error = slurm_array_submit(&array, &fault);
    return error ? job_file_complain("workers", &fault) : 0;
}

/* Returns whether the arguments are "launch slurm"; -1: they are something else. */
static int wants_launch(int count, char **arguments)
{
    if (count == 0) return 0;
    if (count == 2 && strcmp(arguments[0], "launch") == 0 && strcmp(arguments[1], "slurm") == 0)
        return 1;
    fprintf(stderr, "shearwater workers: \"%.64s\" is not \"launch slurm\"\n", arguments[0]);
    return -1;
}

int cli_workers(int argc, char **argv)
{
    struct client_target target = {0};
    struct launch l = {.array = {.jobs = 1, .cpus = 1, .idle_exit_s = 300, .connect_within_s = 120},
                       .time = "60"};
    bool as_json = false;
    const struct option_line lines[] = {
        CLIENT_TARGET_OPTIONS(&target),
        {"json", 0, OPTION_FLAG, NULL, "print the server's answer as JSON", 0, 0, &as_json},
        {"connect", 0, OPTION_TEXT, "HOST:PORT", "launch: where nodes reach the coordinator", 0, 0,
         &l.array.connect},
        {"key", 0, OPTION_TEXT, "FILE",
         "launch: the coordinator's key, at a path that nodes have, too", 0, 0, &l.array.key},
        {"jobs", 0, OPTION_NUMBER, "N", "launch: workers, each a task of one array (default: 1)", 1,
         LIMIT_WORKERS, &l.array.jobs},
        {"cpus", 0, OPTION_NUMBER, "C", "launch: threads of each (default: 1)", 1, LIMIT_THREADS,
         &l.array.cpus},
        {"time", 0, OPTION_TEXT, "T",
         "launch: time limit of each, as Slurm writes it: MINUTES, H:M:S, D-H:M:S (default: 60)", 0,
         0, &l.time},
        {"idle-exit", 0, OPTION_NUMBER, "SECONDS",
         "launch: a worker without a tile leaves after this time (default: 300)", 1, 86400,
         &l.array.idle_exit_s},
        {"connect-within", 0, OPTION_NUMBER, "SECONDS",
         "launch: a worker fails when the coordinator has not answered by then (default: 120)", 1,
         86400, &l.array.connect_within_s},
        {"program", 0, OPTION_TEXT, "FILE",
         "launch: shearwater-worker on the nodes (default: the one beside this program)", 0, 0,
         &l.array.program},
        {"print", 0, OPTION_FLAG, NULL, "launch: print the script instead of submitting it", 0, 0,
         &l.print},
    };
    const struct option_table table = {
        .usage = "shearwater workers [launch slurm] [options]",
        .summary = "Lists the workers of a coordinator. `launch slurm` submits an array of workers "
                   "to Slurm, and prints the job's number; sbatch reads its own defaults, such as "
                   "$SBATCH_PARTITION and $SBATCH_ACCOUNT.",
        .lines = lines,
        .line_count = sizeof lines / sizeof *lines,
        .least_arguments = 0,
        .most_arguments = 2,
    };
    int arguments, status = option_parse(&table, argc, argv, &arguments);
    if (status != OPTION_GO_ON) return status;
    switch (wants_launch(arguments, argv + 1)) {
    case 0:
        return list(&target, as_json);
    case 1:
        return launch(&l);
    default:
        return 2;
    }
}
