/* shearwater watch: a running job's progress, and its picture when it is done. */
#include <stdio.h>

#include "server/cli/cli.h"
#include "server/cli/job_file.h"
#include "server/cli/job_watch.h"
#include "server/cli/option.h"
#include "server/cli/output_file.h"

static int save(struct client *c, const char *id, long frame, const char *kind, const char *path,
                struct fault *fault)
{
    char url[128];
    if (!path) return 0;
    snprintf(url, sizeof url, "/v1/jobs/%.32s/frames/%ld/image.%s", id, frame, kind);
    return client_download(c, url, path, fault);
}

int cli_watch(int argc, char **argv)
{
    const char *server = NULL, *exr = NULL, *png = NULL;
    bool quiet = false;
    const struct option_line lines[] = {
        CLIENT_SERVER_OPTION(&server),
        {"output", 'o', OPTION_TEXT, "OUT.exr", "save the first frame", 0, 0, &exr},
        {"png", 'p', OPTION_TEXT, "OUT.png", "save the first frame for people", 0, 0, &png},
        {"quiet", 'q', OPTION_FLAG, NULL, "no progress on standard error", 0, 0, &quiet},
    };
    const struct option_table table = {
        .usage = "shearwater watch JOB-ID [options]",
        .summary = "Shows a job's progress until it has ended; exit status 0 when it finished.",
        .lines = lines,
        .line_count = sizeof lines / sizeof *lines,
        .least_arguments = 1,
        .most_arguments = 1,
    };
    struct fault fault = {0};
    struct client *client = NULL;
    struct progress progress;
    json_t *job = NULL;
    int arguments, status = option_parse(&table, argc, argv, &arguments);
    if (status != OPTION_GO_ON) return status;
    progress_begin(&progress, quiet);
    int error = exr ? output_file_check_picture(exr, "exr", &fault) : 0;
    if (!error && png) error = output_file_check_picture(png, "png", &fault);
    if (!error) error = client_create(client_base_url(server), &client);
    if (!error) error = job_watch(client, argv[1], &progress, &job, &fault);
    const json_t *frames = json_object_get(json_object_get(job, "document"), "frames");
    long first = (long)json_integer_value(json_object_get(frames, "first"));
    if (!error) error = save(client, argv[1], first, "exr", exr, &fault);
    if (!error) error = save(client, argv[1], first, "png", png, &fault);
    progress_end(&progress, error ? NULL : "finished");
    status = error ? job_file_complain("watch", &fault) : 0;
    client_destroy(&client);
    json_decref(job);
    return status;
}
