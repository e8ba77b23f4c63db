/* Whole files by their paths, DWA too. Importers do not have this: their files are hostile. */
#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <unistd.h>

#include "server/image/dwa/dwa_shim.h"
#include "server/image/exr_reader.h"

static int read_dwa(struct exr_reader *r)
{
    struct dwa_plane planes[IMAGE_CHANNELS];
    const struct image *image = r->image;
    for (uint32_t c = 0; c < image->channel_count; c++) {
        const struct image_channel *channel = &image->channels[c];
        planes[c] = (struct dwa_plane){channel->name, channel->plane.data, channel->plane.stride};
    }
    const enum dwa_status status = dwa_shim_read(r->file.fd, planes, (int)image->channel_count);
    if (status == DWA_OK) return 0;
    return fault_set(r->fault, status == DWA_NO_MEMORY ? ERR_MEMORY : ERR_CORRUPT, r->path, "%s",
                     status == DWA_NO_MEMORY ? "memory is exhausted"
                                             : "OpenEXR: its DWA chunks are damaged");
}

int exr_read(const char *path, struct image **out, struct fault *fault)
{
    struct exr_reader r = {.path = path, .fault = fault, .read_dwa = read_dwa};
    *out = NULL;
    r.file.fd = open(path, O_RDONLY | O_CLOEXEC);
    if (r.file.fd < 0) {
        int code = errno == ENOENT ? ERR_NOT_FOUND : ERR_IO;
        return fault_set(fault, code, path, "%s", strerror(errno));
    }
    int error = exr_reader_run(&r);
    close(r.file.fd);
    if (error)
        image_destroy(&r.image);
    else
        *out = r.image;
    return error;
}
