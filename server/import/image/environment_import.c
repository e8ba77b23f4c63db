#include "server/import/image/environment_import.h"

#include <unistd.h>

#include "server/import/image/photograph.h"
#include "server/import/scene/blob_writer.h"

bool environment_is_known(const struct file_view *file)
{
    return panorama_is_radiance(file) || panorama_is_exr(file) || photograph_is_known(file);
}

static int write_blob(const struct panorama *p, uint32_t flags, const struct warnings *warnings,
                      const char *out, struct fault *fault)
{
    struct environment_header header;
    int rc = environment_describe(p->width_px, p->height_px, p->texels, &header, fault);
    header.flags = flags;
    return rc != 0 ? rc : blob_write_environment(&header, p->texels, warnings, out, fault);
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
    const bool photograph = photograph_is_known(file);
    int rc = photograph              ? photograph_read(file, name, &p, warnings, fault)
             : panorama_is_exr(file) ? panorama_read_exr(file, name, &p, fault)
                                     : panorama_read_radiance(file, name, &p, warnings, fault);
    if (rc != 0) return rc;
    panorama_repair(&p, warnings);
    rc = write_blob(&p, photograph ? ENVIRONMENT_IS_PHOTOGRAPH : 0, warnings, out, fault);
    panorama_destroy(&p);
    return rc == 0 ? verify(out, stats, fault) : rc;
}
