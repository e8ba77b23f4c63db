/* exr_mean OUT.exr IN.exr...: the mean of pictures of one size, channel by channel. A channel that
 * some of them lack is the mean over those that have it: a reference takes its light from many
 * samples and its visibility from few. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "server/image/exr.h"

struct mean {
    struct image *image;            /* owned; size and names of the channels */
    double *sums[IMAGE_CHANNELS];   /* owned */
    uint32_t count[IMAGE_CHANNELS]; /* pictures that had the channel */
    size_t pixels;
};

static int complain(const char *path, const struct fault *fault)
{
    fprintf(stderr, "exr_mean: %s: %s\n", path, fault->detail);
    return -1;
}

static int add_channel(struct mean *m, const char *name)
{
    uint32_t c = m->image->channel_count;
    if (c == IMAGE_CHANNELS) return -1;
    m->sums[c] = calloc(m->pixels, sizeof *m->sums[c]);
    if (!m->sums[c]) return -1;
    memcpy(m->image->channels[c].name, name, strlen(name) + 1);
    m->image->channel_count++;
    return 0;
}

static uint32_t find_channel(const struct mean *m, const char *name)
{
    uint32_t c = 0;
    while (c < m->image->channel_count && strcmp(m->image->channels[c].name, name) != 0) c++;
    return c;
}

static int add(struct mean *m, const struct image *in)
{
    for (uint32_t i = 0; i < in->channel_count; i++) {
        const struct image_channel *channel = &in->channels[i];
        uint32_t c = find_channel(m, channel->name);
        if (c == m->image->channel_count && add_channel(m, channel->name)) return -1;
        for (size_t p = 0; p < m->pixels; p++) m->sums[c][p] += (double)channel->plane.data[p];
        m->count[c]++;
    }
    return 0;
}

static int add_file(struct mean *m, const char *path)
{
    struct image *in = NULL;
    struct fault fault = {0};
    if (exr_read(path, &in, &fault)) return complain(path, &fault);
    if (!m->image) {
        m->image = calloc(1, sizeof *m->image);
        if (!m->image) abort();
        m->image->width_px = in->width_px;
        m->image->height_px = in->height_px;
        m->pixels = (size_t)in->width_px * (size_t)in->height_px;
    }
    int rc = in->width_px == m->image->width_px && in->height_px == m->image->height_px ? add(m, in)
                                                                                        : -1;
    if (rc) fprintf(stderr, "exr_mean: %s: does not fit the others\n", path);
    image_destroy(&in);
    return rc;
}

static int write_mean(const struct mean *m, const char *path)
{
    const char *names[IMAGE_CHANNELS];
    struct image *out = NULL;
    struct fault fault = {0};
    uint32_t count = m->image->channel_count;
    for (uint32_t c = 0; c < count; c++) names[c] = m->image->channels[c].name;
    if (image_create_named(names, count, m->image->width_px, m->image->height_px, &out)) return -1;
    for (uint32_t c = 0; c < count; c++)
        for (size_t p = 0; p < m->pixels; p++)
            out->channels[c].plane.data[p] = (float)(m->sums[c][p] / (double)m->count[c]);
    int error = exr_write(path, out, &(struct exr_metadata){0}, &fault);
    image_destroy(&out);
    return error ? complain(path, &fault) : 0;
}

int main(int argc, char **argv)
{
    struct mean mean = {0};
    if (argc < 3) {
        fprintf(stderr, "usage: exr_mean OUT.exr IN.exr...\n");
        return 2;
    }
    int rc = 0;
    for (int i = 2; i < argc && !rc; i++) rc = add_file(&mean, argv[i]);
    if (!rc) rc = write_mean(&mean, argv[1]);
    for (uint32_t c = 0; mean.image && c < mean.image->channel_count; c++) free(mean.sums[c]);
    free(mean.image);
    return rc ? 1 : 0;
}
