/* shearwater cancel: cancels a job, or removes it from the list. */
#include <stdio.h>

#include "server/cli/cli.h"
#include "server/cli/client/client_target.h"
#include "server/cli/job_file.h"
#include "server/cli/option.h"

int cli_cancel(int argc, char **argv)
{
    struct client_target target = {0};
    bool purge = false;
    const struct option_line lines[] = {
        CLIENT_TARGET_OPTIONS(&target),
        {"purge", 0, OPTION_FLAG, NULL, "also remove the job from the list", 0, 0, &purge},
    };
    const struct option_table table = {
        .usage = "shearwater cancel JOB-ID [options]",
        .summary = "Cancels a job that has not ended. With --purge it removes any job.",
        .lines = lines,
        .line_count = sizeof lines / sizeof *lines,
        .least_arguments = 1,
        .most_arguments = 1,
    };
    struct fault fault = {0};
    struct client *client = NULL;
    json_t *answer = NULL;
    char path[128];
    int arguments, status = option_parse(&table, argc, argv, &arguments);
    if (status != OPTION_GO_ON) return status;
    snprintf(path, sizeof path, "/v1/jobs/%.64s%s", argv[1], purge ? "?purge=1" : "");
    int error = client_target_open(&target, &client, &fault);
    if (!error) error = client_json(client, "DELETE", path, NULL, &answer, &fault);
    status = error ? job_file_complain("cancel", &fault) : 0;
    client_destroy(&client);
    json_decref(answer);
    return status;
}
