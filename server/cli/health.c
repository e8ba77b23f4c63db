/* shearwater health: whether a coordinator lives, or can take and do work. For health checks of
 * containers, which have no other client. */
#include "server/cli/cli.h"
#include "server/cli/client/client_target.h"
#include "server/cli/job_file.h"
#include "server/cli/option.h"

int cli_health(int argc, char **argv)
{
    struct client_target target = {0};
    bool ready = false;
    const struct option_line lines[] = {
        CLIENT_TARGET_OPTIONS(&target),
        {"ready", 0, OPTION_FLAG, NULL,
         "ask whether it takes work and has a worker, not only whether it lives", 0, 0, &ready},
    };
    const struct option_table table = {
        .usage = "shearwater health [options]",
        .summary = "Ends with status 0 when the coordinator is well, and says what is wrong else.",
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
    if (!error)
        error = client_json(client, "GET", ready ? "/readyz" : "/livez", NULL, &answer, &fault);
    client_destroy(&client);
    json_decref(answer);
    return error ? job_file_complain("health", &fault) : 0;
}
