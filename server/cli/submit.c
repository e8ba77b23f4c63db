/* shearwater submit: sends a job to a running coordinator and prints its id. */
#include <stdio.h>
#include <string.h>

#include "server/cli/cli.h"
#include "server/cli/client/client_target.h"
#include "server/cli/job_file.h"
#include "server/cli/job_watch.h"
#include "server/cli/option.h"

static int print_plan(struct client *c, const char *path, const struct job_changes *changes,
                      json_t *document, struct fault *fault)
{
    json_t *plan = NULL;
    int error = job_file_prepare(c, path, changes, document, fault);
    if (!error) error = client_json(c, "POST", "/v1/jobs?dry_run=1", document, &plan, fault);
    if (error) return error;
    json_dumpf(plan, stdout, JSON_INDENT(2));
    putchar('\n');
    json_decref(plan);
    return 0;
}

int cli_submit(int argc, char **argv)
{
    struct client_target target = {0};
    struct job_changes changes = JOB_CHANGES_NONE;
    bool quiet = false, watch = false, dry_run = false;
    const struct option_line lines[] = {
        CLIENT_TARGET_OPTIONS(&target),
        {"watch", 'w', OPTION_FLAG, NULL, "wait until the job has ended", 0, 0, &watch},
        {"dry-run", 'n', OPTION_FLAG, NULL, "only check the job and print its plan", 0, 0,
         &dry_run},
        JOB_CHANGES_OPTIONS(&changes),
        JOB_CHANGE_TEXT("webhook", 0, "URL", "tell this address when the job has ended",
                        &changes.webhook),
        {"quiet", 'q', OPTION_FLAG, NULL, "print only the id", 0, 0, &quiet},
    };
    const struct option_table table = {
        .usage = "shearwater submit JOB.json|SCENE [options]",
        .summary =
            "Uploads a job's scene and environment, submits the job and prints its id. A scene "
            "(.glb, .gltf, .obj) in place of a job is one with all defaults.",
        .lines = lines,
        .line_count = sizeof lines / sizeof *lines,
        .least_arguments = 1,
        .most_arguments = 1,
    };
    struct fault fault = {0};
    struct client *client = NULL;
    struct progress progress;
    json_t *document = NULL, *job = NULL, *ended = NULL;
    int arguments, status = option_parse(&table, argc, argv, &arguments);
    if (status != OPTION_GO_ON) return status;
    int error = job_file_read(argv[1], &document, &fault);
    if (!error) error = client_target_open(&target, &client, &fault);
    if (!error && dry_run)
        error = print_plan(client, argv[1], &changes, document, &fault);
    else if (!error)
        error = job_file_submit(client, argv[1], &changes, document, &job, &fault);
    if (!error && job) {
        const char *id = json_string_value(json_object_get(job, "id"));
        printf("%s\n", id);
        fflush(stdout);
        if (!quiet && !watch)
            fprintf(stderr, "watch it: shearwater watch %s, or %s/#/jobs/%s\n", id,
                    client_base_url(target.server), id);
        if (watch) {
            progress_begin(&progress, quiet);
            error = job_watch(client, id, &progress, &ended, &fault);
            progress_end(&progress, error ? NULL : "finished");
        }
    }
    status = error ? job_file_complain("submit", &fault) : 0;
    client_destroy(&client);
    json_decref(document);
    json_decref(job);
    json_decref(ended);
    return status;
}
