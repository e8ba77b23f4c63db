#include "server/http/resource/picture_task.h"

#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "server/http/resource/picture.h"
#include "server/image/exr_mattes.h"
#include "server/image/png.h"

static void copy_plane(const struct plane *from, const struct plane *to)
{
    for (int32_t y = 0; y < from->height_px; y++)
        memcpy(plane_row(to, y), plane_row(from, y), (size_t)from->width_px * sizeof(float));
}

/* Channels of the image by name into an image of their own. */
static struct image *copy_channels(const struct image *image, const char *const *names,
                                   uint32_t count)
{
    struct image *copy = NULL;
    if (image_create_named(names, count, image->width_px, image->height_px, &copy) != 0)
        return NULL;
    for (uint32_t i = 0; i < count; i++)
        copy_plane(image_plane(image, names[i]), image_plane(copy, names[i]));
    return copy;
}

static struct image *copy_all(const struct image *image)
{
    const char *names[IMAGE_CHANNELS];
    for (uint32_t i = 0; i < image->channel_count; i++) names[i] = image->channels[i].name;
    return copy_channels(image, names, image->channel_count);
}

/* Adds the name of the channel that a plane is of, once. */
static uint32_t add_name(const struct image *image, const struct plane *plane, const char **names,
                         uint32_t count)
{
    for (uint32_t i = 0; i < image->channel_count; i++) {
        const struct image_channel *channel = &image->channels[i];
        if (channel->plane.data != plane->data) continue;
        for (uint32_t k = 0; k < count; k++)
            if (names[k] == channel->name) return count;
        names[count++] = channel->name;
    }
    return count;
}

/* The channels that show a layer, and beauty's alpha; an image without the layer gives its first
 * channel, which does not show it either. */
static struct image *copy_layer(const struct image *image, const char *layer)
{
    const struct plane *rgb[3], *alpha = image_plane(image, "A");
    const char *names[4] = {image->channels[0].name};
    uint32_t count = 0;
    if (!image_layer_planes(image, layer, rgb)) return copy_channels(image, names, 1);
    for (int c = 0; c < 3; c++) count = add_name(image, rgb[c], names, count);
    if (alpha && strcmp(layer, "beauty") == 0) count = add_name(image, alpha, names, count);
    return copy_channels(image, names, count);
}

static void copy_metadata(struct picture_task *t, const struct exr_metadata *metadata)
{
    if (!metadata) return;
    t->metadata = *metadata;
    exr_mattes_hold(metadata->mattes);
    if (metadata->job) {
        snprintf(t->job, sizeof t->job, "%s", metadata->job);
        t->metadata.job = t->job;
    }
    if (metadata->build) {
        snprintf(t->build, sizeof t->build, "%s", metadata->build);
        t->metadata.build = t->build;
    }
}

struct picture_task *picture_task_create(enum picture_form form,
                                         const struct picture_source *source)
{
    struct picture_task *t = calloc(1, sizeof *t);
    if (!t) return NULL;
    t->form = form;
    t->fd = -1;
    snprintf(t->layer, sizeof t->layer, "%s", source->layer);
    copy_metadata(t, source->metadata);
    if (source->exr) {
        objects_path(source->objects, source->exr, t->exr_path);
        return t;
    }
    t->image =
        form == PICTURE_EXR ? copy_all(source->image) : copy_layer(source->image, source->layer);
    t->objects = source->objects;
    if (!t->image) picture_task_destroy(&t);
    return t;
}

void picture_task_destroy(struct picture_task **task)
{
    struct picture_task *t = *task;
    if (!t) return;
    image_destroy(&t->image);
    exr_mattes_drop(&t->metadata.mattes);
    if (t->fd >= 0) close(t->fd);
    free(t->png);
    free(t);
    *task = NULL;
}

/* The file is sent from its descriptor; its name goes at once. */
static int write_exr(struct picture_task *t)
{
    struct stat info;
    struct fault fault;
    struct object_writer *writer;
    int error = object_writer_begin(t->objects, &writer);
    if (error) return error;
    const char *path = object_writer_path(writer);
    error = exr_write(path, t->image, &t->metadata, &fault);
    if (!error) t->fd = open(path, O_RDONLY | O_CLOEXEC);
    if (!error && (t->fd < 0 || fstat(t->fd, &info) != 0)) error = ERR_IO;
    if (!error) t->fd_bytes = (uint64_t)info.st_size;
    object_writer_abort(&writer);
    return error;
}

static void run(struct pool_task *task)
{
    struct picture_task *t = (struct picture_task *)task;
    struct fault fault;
    const struct plane *rgb[3];
    t->error = t->image ? 0 : exr_read(t->exr_path, &t->image, &fault);
    if (t->error) return;
    if (t->form == PICTURE_PNG)
        t->error = png_encode(t->image, t->layer, &t->png_options, &t->png, &t->png_bytes);
    else if (t->form == PICTURE_EXR)
        t->error = write_exr(t);
    else if (!image_layer_planes(t->image, t->layer, rgb))
        t->error = ERR_NOT_FOUND;
    if (t->form != PICTURE_FEED) image_destroy(&t->image);
}

static struct MHD_Response *take_response(struct picture_task *t)
{
    struct MHD_Response *response;
    if (t->form == PICTURE_EXR) {
        int fd = t->fd;
        t->fd = -1;
        return response_of_file(fd, 0, t->fd_bytes, "image/x-exr");
    }
    response = response_of_taken(t->png, t->png_bytes, "image/png");
    t->png = NULL;
    return response;
}

static void answer_feed(struct request *r, struct picture_task *t)
{
    struct image *image = t->image;
    struct pixels_request wanted;
    if (!picture_pixels_request(r, &wanted)) return;
    t->image = NULL;
    struct MHD_Response *response =
        stream_still_response(r->http->options.streams, r->mhd, image, &wanted);
    if (response && response_protect(response, "application/octet-stream"))
        response_header(response, "Cache-Control", "no-store");
    r->streams = true;
    request_answer(r, 200, response);
}

static void answer(struct request *r, struct picture_task *t)
{
    if (t->error == ERR_NOT_FOUND) {
        request_problem(r, PROBLEM_NOT_FOUND, "the picture does not have this layer", NULL);
    } else if (t->error) {
        request_trouble(r, t->error, "the picture could not be made");
    } else if (t->form == PICTURE_FEED) {
        answer_feed(r, t);
    } else {
        struct MHD_Response *response = take_response(t);
        if (response) {
            response_header(response, "ETag", t->etag);
            response_header(response, "Cache-Control", t->so_far ? "no-store" : "no-cache");
        }
        request_answer(r, 200, response);
    }
}

static void done(struct pool_task *task)
{
    struct picture_task *t = (struct picture_task *)task;
    if (request_back(t->request)) answer(t->request, t);
    picture_task_destroy(&t);
}

void picture_task_start(struct picture_task *t, struct request *r)
{
    t->task = (struct pool_task){.run = run, .done = done};
    t->request = r;
    request_hold(r);
    thread_pool_submit(r->http->options.pool, &t->task);
}
