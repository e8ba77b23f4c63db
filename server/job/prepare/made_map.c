#include "server/job/prepare/made_map.h"

static int write_blob(const struct objects *objects, const struct environment_header *header,
                      const float *texels, size_t texel_bytes, struct digest *blob)
{
    struct object_writer *writer = NULL;
    bool existed;
    int error = object_writer_begin(objects, &writer);
    if (error) return error;
    error = object_writer_append(writer, header, sizeof *header);
    if (!error) error = object_writer_append(writer, texels, texel_bytes);
    if (!error) error = object_writer_finish(&writer, NULL, blob, &existed);
    if (!error) objects_release(objects, blob); /* nothing removes blobs without an asset */
    if (writer) object_writer_abort(&writer);
    return error;
}

int made_map_place(const struct objects *objects, uint32_t width_px, uint32_t height_px,
                   const float *texels, struct environment_header *header, struct digest *blob,
                   struct fault *fault)
{
    const size_t texel_bytes = 3 * sizeof(float) * width_px * height_px;
    int error = environment_describe(width_px, height_px, texels, header, fault);
    if (error) return error;
    error = write_blob(objects, header, texels, texel_bytes, blob);
    return error ? fault_set(fault, error, "", "a map of light cannot be stored") : 0;
}
