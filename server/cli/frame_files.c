#include "server/cli/frame_files.h"

#include <stdio.h>
#include <string.h>

#include "proto/job/job.h"

void frame_files_path(const char *path, int32_t frame, bool several, char *out, size_t capacity)
{
    const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path;
    const char *dot = strrchr(name, '.'), *mark = strchr(name, '#');
    const int digits = mark ? (int)strspn(mark, "#") : 0;
    if (!dot) dot = path + strlen(path);
    if (mark)
        snprintf(out, capacity, "%.*s%0*d%s", (int)(mark - path), path, digits, frame,
                 mark + digits);
    else if (several)
        snprintf(out, capacity, "%.*s.%04d%s", (int)(dot - path), path, frame, dot);
    else
        snprintf(out, capacity, "%s", path);
}

int frame_files_save(struct client *c, const json_t *job, const char *exr, const char *png,
                     struct fault *fault)
{
    const char *id = json_string_value(json_object_get(job, "id"));
    struct job frames;
    const char *const outputs[] = {exr, png}, *const kinds[] = {"exr", "png"};
    int error = job_frames_of(json_object_get(job, "document"), &frames);
    const uint32_t count = error ? 0 : job_frame_count(&frames);
    for (uint32_t i = 0; i < 2 * count && !error; i++) {
        char url[128], path[4096];
        const int32_t frame = job_frame_number(&frames, i / 2);
        if (!outputs[i % 2]) continue;
        snprintf(url, sizeof url, "/v1/jobs/%s/frames/%d/image.%s", id, frame, kinds[i % 2]);
        frame_files_path(outputs[i % 2], frame, count > 1, path, sizeof path);
        error = client_download(c, url, path, fault);
    }
    return error;
}
