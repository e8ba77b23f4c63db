#include "server/import/image/environment_import.h"

#include <unistd.h>

#include "server/import/scene/blob_writer.h"

bool environment_is_known(const struct file_view *file)
{
    return panorama_is_radiance(file) || panorama_is_exr(file);
}

static int write_blob(const struct panorama *p, const char *out, struct fault *fault)
{
    struct environment_header header;
    int rc = environment_describe(p->width_px, p->height_px, p->texels, &header, fault);
    return rc != 0 ? rc : blob_write_environment(&header, p->texels, out, fault);
}

/* Checks that workers would accept what was written. */
static int verify(const char *out, struct import_stats *stats, struct fault *fault)
{
    struct environment_blob blob;
    int rc = environment_map(out, &blob, fault);
    if (rc != 0) {
        unlink(out);
        return rc;
    }
    stats->width_px = blob.header->width_px;
    stats->height_px = blob.header->height_px;
    environment_unmap(&blob);
    return 0;
}

int environment_import(const struct file_view *file, const char *name, const char *out,
                       struct warnings *warnings, struct import_stats *stats, struct fault *fault)
{
    struct panorama p;
    int rc = panorama_is_exr(file) ? panorama_read_exr(file, name, &p, fault)
                                   : panorama_read_radiance(file, name, &p, warnings, fault);
    if (rc != 0) return rc;
    panorama_repair(&p, warnings);
    rc = write_blob(&p, out, fault);
    panorama_destroy(&p);
    return rc == 0 ? verify(out, stats, fault) : rc;
}
