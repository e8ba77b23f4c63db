/* shearwater steer: pauses and resumes a job, and changes what is rendered first. */
#include <limits.h>
#include <stdio.h>
#include <string.h>

#include "proto/limits.h"
#include "server/cli/cli.h"
#include "server/cli/client/client_target.h"
#include "server/cli/job_file.h"
#include "server/cli/job_patch.h"
#include "server/cli/option.h"

/* What the options ask for; NULL and NOT_GIVEN: nothing. */
#define NOT_GIVEN LONG_MIN

struct wanted {
    bool pause, resume;
    long priority;
    const char *region, *near;
};

static int refuse(struct fault *fault, const char *option, const char *form, const char *given)
{
    return fault_set(fault, ERR_SYNTAX, "", "--%s is %s or none, not \"%.64s\"", option, form,
                     given);
}

static int read_region(const char *text, json_t **out, struct fault *fault)
{
    int x, y, width, height, used = 0;
    if (strcmp(text, "none") == 0) {
        *out = json_null();
        return 0;
    }
    if (sscanf(text, "%6d,%6d,%6dx%6d%n", &x, &y, &width, &height, &used) != 4 || text[used])
        return refuse(fault, "region", "X,Y,WIDTHxHEIGHT", text);
    *out = json_pack("{s:i,s:i,s:i,s:i}", "x", x, "y", y, "width", width, "height", height);
    return *out ? 0 : fault_set(fault, ERR_MEMORY, "", "memory is exhausted");
}

static int read_near(const char *text, json_t **out, struct fault *fault)
{
    int x, y, used = 0;
    if (strcmp(text, "none") == 0) {
        *out = json_null();
        return 0;
    }
    if (sscanf(text, "%6d,%6d%n", &x, &y, &used) != 2 || text[used])
        return refuse(fault, "near", "X,Y", text);
    *out = json_pack("{s:i,s:i}", "x", x, "y", y);
    return *out ? 0 : fault_set(fault, ERR_MEMORY, "", "memory is exhausted");
}

/* Writes the document of the request. */
static int write_patch(const struct wanted *w, json_t *patch, struct fault *fault)
{
    json_t *value = NULL;
    int error = 0;
    if (w->pause && w->resume)
        return fault_set(fault, ERR_SYNTAX, "", "--pause and --resume exclude each other");
    if (w->pause || w->resume) json_object_set_new(patch, "paused", json_boolean(w->pause));
    if (w->priority != NOT_GIVEN)
        json_object_set_new(patch, "priority", json_integer((json_int_t)w->priority));
    if (w->region) {
        error = read_region(w->region, &value, fault);
        if (!error) json_object_set_new(patch, "region", value);
    }
    if (!error && w->near) {
        error = read_near(w->near, &value, fault);
        if (!error) json_object_set_new(patch, "near", value);
    }
    if (!error && json_object_size(patch) == 0)
        return fault_set(fault, ERR_MISSING, "", "give at least one change; --help lists them");
    return error;
}

static void print_job(const json_t *job)
{
    printf("%s: %s%s, priority %lld\n", json_string_value(json_object_get(job, "id")),
           json_string_value(json_object_get(job, "state")),
           json_is_true(json_object_get(job, "paused")) ? ", paused" : "",
           (long long)json_integer_value(json_object_get(job, "priority")));
}

static int steer(const struct client_target *target, const char *id, const struct wanted *wanted)
{
    struct fault fault = {0};
    json_t *patch = json_object(), *job = NULL;
    int error = write_patch(wanted, patch, &fault);
    if (!error) error = job_patch(target, id, patch, &job, &fault);
    if (!error) print_job(job);
    json_decref(patch);
    json_decref(job);
    return error ? job_file_complain("steer", &fault) : 0;
}

int cli_steer(int argc, char **argv)
{
    struct client_target target = {0};
    struct wanted wanted = {.priority = NOT_GIVEN};
    const struct option_line lines[] = {
        {"pause", 0, OPTION_FLAG, NULL, "give the job no more tiles; keep what it has", 0, 0,
         &wanted.pause},
        {"resume", 0, OPTION_FLAG, NULL, "give the job tiles again", 0, 0, &wanted.resume},
        {"priority", 'p', OPTION_NUMBER, "N", "-100 to 100; the highest goes first",
         -LIMIT_PRIORITY, LIMIT_PRIORITY, &wanted.priority},
        {"region", 0, OPTION_TEXT, "X,Y,WxH", "render these pixels first; none: no region", 0, 0,
         &wanted.region},
        {"near", 0, OPTION_TEXT, "X,Y",
         "render what is nearest to this pixel first; none: no pixel", 0, 0, &wanted.near},
        CLIENT_TARGET_OPTIONS(&target),
    };
    const struct option_table table = {
        .usage = "shearwater steer JOB-ID [options]",
        .summary = "Changes when a job is rendered, and never its result.",
        .lines = lines,
        .line_count = sizeof lines / sizeof *lines,
        .least_arguments = 1,
        .most_arguments = 1,
    };
    int arguments, status = option_parse(&table, argc, argv, &arguments);
    return status != OPTION_GO_ON ? status : steer(&target, argv[1], &wanted);
}
