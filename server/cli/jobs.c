/* shearwater jobs: a coordinator's jobs as a table, newest first. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "proto/limits.h"
#include "server/cli/cli.h"
#include "server/cli/client/client_target.h"
#include "server/cli/job_file.h"
#include "server/cli/option.h"

struct query {
    struct client_target target;
    const char *state, *name, *label;
    long limit;
    bool as_json;
};

static void print_labels(const json_t *labels)
{
    size_t i;
    json_t *label;
    json_array_foreach (labels, i, label) printf(" [%s]", json_string_value(label));
}

static void print_line(const json_t *job)
{
    const json_t *progress = json_object_get(job, "progress");
    const char *name = json_string_value(json_object_get(job, "name"));
    const char *created = json_string_value(json_object_get(job, "created"));
    const double fraction = json_number_value(json_object_get(progress, "fraction"));
    printf("%-26s %-10s %4d %%  %-20.19s %s", json_string_value(json_object_get(job, "id")),
           json_string_value(json_object_get(job, "state")), (int)(100.0 * fraction), created,
           name ? name : "-");
    print_labels(json_object_get(job, "labels"));
    putchar('\n');
}

/* Every byte that is no letter or digit as %XX. */
static void add_parameter(char *path, size_t capacity, const char *key, const char *value)
{
    size_t length = strlen(path);
    if (!value) return;
    length += (size_t)snprintf(path + length, capacity - length, "&%s=", key);
    for (const unsigned char *c = (const unsigned char *)value; *c && length + 4 < capacity; c++) {
        const bool plain =
            (*c >= '0' && *c <= '9') || (*c >= 'a' && *c <= 'z') || (*c >= 'A' && *c <= 'Z');
        length += (size_t)snprintf(path + length, capacity - length, plain ? "%c" : "%%%02X", *c);
    }
}

/* Appends the next page of at most `rows` to `all`. *cursor is the caller's, freed here and set to
 * that of the page behind; NULL: there is none. */
static int add_page(struct client *client, const struct query *q, long rows, json_t *all,
                    char **cursor, struct fault *fault)
{
    char path[LIMIT_HTTP_URL_BYTES];
    json_t *page = NULL;
    snprintf(path, sizeof path, "/v1/jobs?limit=%ld", rows);
    add_parameter(path, sizeof path, "state", q->state);
    add_parameter(path, sizeof path, "name", q->name);
    add_parameter(path, sizeof path, "label", q->label);
    add_parameter(path, sizeof path, "cursor", *cursor);
    free(*cursor);
    *cursor = NULL;
    const int error = client_json(client, "GET", path, NULL, &page, fault);
    if (error) return error;
    const char *next = json_string_value(json_object_get(page, "next"));
    *cursor = next ? strdup(next) : NULL;
    const bool failed = json_array_extend(all, json_object_get(page, "jobs")) || (next && !*cursor);
    json_decref(page);
    return failed ? fault_set(fault, ERR_MEMORY, "", "memory is exhausted") : 0;
}

static void print_jobs(const struct query *q, const json_t *all, bool more)
{
    size_t i;
    json_t *job;
    if (q->as_json) {
        json_dumpf(all, stdout, JSON_INDENT(2));
        putchar('\n');
        return;
    }
    printf("%-26s %-10s %6s  %-20s %s\n", "ID", "STATE", "DONE", "SUBMITTED (UTC)",
           "NAME [LABELS]");
    json_array_foreach (all, i, job) print_line(job);
    if (more) fprintf(stderr, "older ones follow: give a higher --limit\n");
}

static int list(const struct query *q, struct fault *fault)
{
    struct client *client = NULL;
    json_t *all = json_array();
    char *cursor = NULL;
    int error = client_target_open(&q->target, &client, fault);
    do {
        const long left = q->limit - (long)json_array_size(all);
        const long rows = left < LIMIT_LIST_ROWS ? left : LIMIT_LIST_ROWS;
        if (!error) error = add_page(client, q, rows, all, &cursor, fault);
    } while (!error && cursor && (long)json_array_size(all) < q->limit);
    if (!error) print_jobs(q, all, cursor != NULL);
    free(cursor);
    json_decref(all);
    client_destroy(&client);
    return error;
}

int cli_jobs(int argc, char **argv)
{
    struct query q = {.limit = LIMIT_LIST_ROWS / 2};
    const struct option_line lines[] = {
        CLIENT_TARGET_OPTIONS(&q.target),
        {"name", 0, OPTION_TEXT, "TEXT", "only jobs whose name has this in it", 0, 0, &q.name},
        {"label", 0, OPTION_TEXT, "LABEL", "only jobs that have this label", 0, 0, &q.label},
        {"state", 0, OPTION_TEXT, "STATE", "only jobs in this state, such as running", 0, 0,
         &q.state},
        {"limit", 0, OPTION_NUMBER, "N", "most jobs to list (default: 50)", 1, LIMIT_JOBS_WAITING,
         &q.limit},
        {"json", 0, OPTION_FLAG, NULL, "print them as a JSON array", 0, 0, &q.as_json},
    };
    const struct option_table table = {
        .usage = "shearwater jobs [options]",
        .summary = "Lists the jobs of a coordinator, newest first.",
        .lines = lines,
        .line_count = sizeof lines / sizeof *lines,
    };
    struct fault fault = {0};
    int arguments, status = option_parse(&table, argc, argv, &arguments);
    if (status != OPTION_GO_ON) return status;
    return list(&q, &fault) ? job_file_complain("jobs", &fault) : 0;
}
