/* shearwater watch: a running job's progress, and its pictures when it is done. */
#include <stdio.h>

#include "server/cli/cli.h"
#include "server/cli/client/client_target.h"
#include "server/cli/client/output_file.h"
#include "server/cli/frame_files.h"
#include "server/cli/job_file.h"
#include "server/cli/job_watch.h"
#include "server/cli/option.h"
#include "server/cli/tev/tev_push.h"

/* Begins to show the job's layers in tev, if that is asked for. */
static int show(struct client *c, const struct client_target *target, const char *id,
                const char *tev, bool anywhere, struct tev_push **push, struct fault *fault)
{
    const char *layers[32];
    struct tev_link link;
    char url[128];
    json_t *job = NULL, *name;
    uint32_t count = 0;
    size_t i;
    if (!tev) return 0;
    snprintf(url, sizeof url, "/v1/jobs/%.32s", id);
    int error = tev_link_parse(tev, anywhere, &link, fault);
    if (!error) error = client_json(c, "GET", url, NULL, &job, fault);
    json_array_foreach (json_object_get(json_object_get(job, "document"), "layers"), i, name)
        if (json_is_string(name) && count < 32) layers[count++] = json_string_value(name);
    if (!error && count == 0) layers[count++] = "beauty";
    if (!error) error = tev_push_start(target, id, layers, count, &link, push, fault);
    json_decref(job);
    return error;
}

int cli_watch(int argc, char **argv)
{
    struct client_target target = {0};
    const char *exr = NULL, *png = NULL, *tev = NULL;
    bool quiet = false, anywhere = false;
    const struct option_line lines[] = {
        CLIENT_TARGET_OPTIONS(&target),
        {"output", 'o', OPTION_TEXT, "OUT.exr",
         "save all layers; # is the frame's number, as in shot.####.exr", 0, 0, &exr},
        {"png", 'p', OPTION_TEXT, "OUT.png",
         "save the composite or beauty as an 8-bit sRGB picture", 0, 0, &png},
        {"tev", 't', OPTION_TEXT, "HOST:PORT",
         "show all layers in a running tev while they form (tev listens at 127.0.0.1:14158)", 0, 0,
         &tev},
        {"tev-anywhere", 0, OPTION_FLAG, NULL,
         "allow a tev on another machine; the connection is not encrypted", 0, 0, &anywhere},
        {"quiet", 'q', OPTION_FLAG, NULL, "no progress on standard error", 0, 0, &quiet},
    };
    const struct option_table table = {
        .usage = "shearwater watch JOB-ID [options]",
        .summary = "Shows a job's progress until it ends, and then saves its frames if it is told "
                   "where. The "
                   "exit status is 0 if the job finished.",
        .lines = lines,
        .line_count = sizeof lines / sizeof *lines,
        .least_arguments = 1,
        .most_arguments = 1,
    };
    struct fault fault = {0};
    struct client *client = NULL;
    struct tev_push *push = NULL;
    struct progress progress;
    json_t *job = NULL;
    int arguments, status = option_parse(&table, argc, argv, &arguments);
    if (status != OPTION_GO_ON) return status;
    progress_begin(&progress, quiet);
    int error = exr ? output_file_check_picture(exr, "exr", &fault) : 0;
    if (!error && png) error = output_file_check_picture(png, "png", &fault);
    const char *const outputs[] = {exr, png};
    if (!error) error = output_files_check_apart(outputs, 2, &fault);
    if (!error) error = client_target_open(&target, &client, &fault);
    if (!error) error = show(client, &target, argv[1], tev, anywhere, &push, &fault);
    if (!error) error = job_watch(client, argv[1], &progress, &job, &fault);
    if (!error) error = frame_files_save(client, job, exr, png, &fault);
    if (push) {
        struct fault pushed = {0};
        const int unseen = tev_push_finish(&push, &pushed);
        if (!error && unseen) fault = pushed;
        error = error ? error : unseen;
    }
    progress_end(&progress, error ? NULL : "finished");
    status = error ? job_file_complain("watch", &fault) : 0;
    client_destroy(&client);
    json_decref(job);
    return status;
}
