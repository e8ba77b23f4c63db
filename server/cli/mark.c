/* shearwater mark: changes the name, comment and labels by which people find a job. */
#include <stdio.h>
#include <string.h>

#include "server/cli/cli.h"
#include "server/cli/client/client_target.h"
#include "server/cli/job_changes.h"
#include "server/cli/job_file.h"
#include "server/cli/job_patch.h"

/* Texts as they are given; "none": none from now on. NULL: as it is. */
struct marks {
    const char *name, *comment, *labels;
};

static const char *unless_none(const char *text)
{
    return text && strcmp(text, "none") != 0 ? text : NULL;
}

/* Writes the document of the request. */
static int write_patch(const struct marks *m, json_t *patch, struct fault *fault)
{
    struct job_changes changes = JOB_CHANGES_NONE;
    changes.name = unless_none(m->name);
    changes.comment = unless_none(m->comment);
    if (unless_none(m->labels)) changes.labels = (struct option_list){{m->labels}, 1};
    if (m->name && !changes.name) json_object_set_new(patch, "name", json_null());
    if (m->comment && !changes.comment) json_object_set_new(patch, "comment", json_null());
    if (m->labels && changes.labels.count == 0) json_object_set_new(patch, "labels", json_array());
    const int error = job_changes_apply(&changes, patch, fault);
    if (!error && json_object_size(patch) == 0)
        return fault_set(fault, ERR_MISSING, "", "give at least one change; --help lists them");
    return error;
}

static void print_job(const json_t *job)
{
    const char *name = json_string_value(json_object_get(job, "name"));
    size_t i;
    json_t *label;
    printf("%s: %s", json_string_value(json_object_get(job, "id")), name ? name : "-");
    json_array_foreach (json_object_get(job, "labels"), i, label)
        printf(" [%s]", json_string_value(label));
    putchar('\n');
}

static int mark(const struct client_target *target, const char *id, const struct marks *marks)
{
    struct fault fault = {0};
    json_t *patch = json_object(), *job = NULL;
    int error = write_patch(marks, patch, &fault);
    if (!error) error = job_patch(target, id, patch, &job, &fault);
    if (!error) print_job(job);
    json_decref(patch);
    json_decref(job);
    return error ? job_file_complain("mark", &fault) : 0;
}

int cli_mark(int argc, char **argv)
{
    struct client_target target = {0};
    struct marks marks = {0};
    const struct option_line lines[] = {
        JOB_CHANGE_TEXT("name", 0, "TEXT", "name of the job; none: no name", &marks.name),
        JOB_CHANGE_TEXT("comment", 0, "TEXT", "comment on the job; none: no comment",
                        &marks.comment),
        JOB_CHANGE_TEXT("label", 0, "LIST",
                        "labels instead of the job's, parted by commas; none: no label",
                        &marks.labels),
        CLIENT_TARGET_OPTIONS(&target),
    };
    const struct option_table table = {
        .usage = "shearwater mark JOB-ID [options]",
        .summary = "Changes by what people find a job, also one that has ended.",
        .lines = lines,
        .line_count = sizeof lines / sizeof *lines,
        .least_arguments = 1,
        .most_arguments = 1,
    };
    int arguments, status = option_parse(&table, argc, argv, &arguments);
    return status != OPTION_GO_ON ? status : mark(&target, argv[1], &marks);
}
