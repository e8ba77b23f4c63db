/* shearwater workers: the roster of a coordinator as a table. */
#include <stdio.h>

#include "server/cli/cli.h"
#include "server/cli/client/client_target.h"
#include "server/cli/job_file.h"
#include "server/cli/option.h"

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

int cli_workers(int argc, char **argv)
{
    struct client_target target = {0};
    bool as_json = false;
    const struct option_line lines[] = {
        CLIENT_TARGET_OPTIONS(&target),
        {"json", 0, OPTION_FLAG, NULL, "print the server's answer as JSON", 0, 0, &as_json},
    };
    const struct option_table table = {
        .usage = "shearwater workers [options]",
        .summary = "Lists the workers of a coordinator.",
        .lines = lines,
        .line_count = sizeof lines / sizeof *lines,
        .least_arguments = 0,
        .most_arguments = 0,
    };
    struct fault fault = {0};
    struct client *client = NULL;
    json_t *answer = NULL;
    int arguments, status = option_parse(&table, argc, argv, &arguments);
    if (status != OPTION_GO_ON) return status;
    int error = client_target_open(&target, &client, &fault);
    if (!error) error = client_json(client, "GET", "/v1/workers", NULL, &answer, &fault);
    if (!error && as_json) {
        json_dumpf(answer, stdout, JSON_INDENT(2));
        putchar('\n');
    } else if (!error) {
        print_roster(json_object_get(answer, "workers"));
    }
    status = error ? job_file_complain("workers", &fault) : 0;
    client_destroy(&client);
    json_decref(answer);
    return status;
}
