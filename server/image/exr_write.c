#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "proto/half.h"
#include "server/image/exr_attributes.h"
#include "server/image/exr_dwa.h"
#include "server/image/exr_file.h"
#include "server/image/exr_zip.h"

/* A file in the making. */
struct exr_rows {
    const struct image *image;
    const struct exr_metadata *metadata;
    struct exr_file file;
    exr_context_t context;
    exr_encode_pipeline_t encoder;
    bool encoding;       /* encoder is initialised */
    struct exr_zip *zip; /* owned */
    uint16_t *halves;    /* owned; rows of one chunk, channel after channel; NULL for floats */
    int32_t chunk_rows;
    int32_t next;    /* the first row that is not written */
    char path[4352]; /* where it is written before it gets its name */
    char *name;      /* owned; its name, afterwards */
};

/* Depth, ids and counts, and shares beside ids, need more than eleven bits. */
static bool stays_float(const char *channel)
{
    const bool matte = !strncmp(channel, "Crypto", 6) && strchr(channel, '0');
    return matte || !strncmp(channel, "motion.", 7) || !strcmp(channel, "depth.Z") ||
           !strcmp(channel, "id.I") || !strcmp(channel, "samples.N");
}

static bool is_half(const struct exr_rows *w, const char *channel)
{
    return w->metadata->half && !stays_float(channel);
}

static exr_result_t add_channels(struct exr_rows *w)
{
    exr_result_t r = EXR_ERR_SUCCESS;
    for (uint32_t c = 0; !r && c < w->image->channel_count; c++) {
        const char *name = w->image->channels[c].name;
        /* Ids, counts and normals are no light: a lossy codec must not treat them as such. */
        exr_perceptual_treatment_t light = strchr("RGB", name[strlen(name) - 1])
                                               ? EXR_PERCEPTUALLY_LOGARITHMIC
                                               : EXR_PERCEPTUALLY_LINEAR;
        r = exr_add_channel(w->context, 0, name,
                            is_half(w, name) ? EXR_PIXEL_HALF : EXR_PIXEL_FLOAT, light, 1, 1);
    }
    return r;
}

static exr_compression_t compression_of(enum exr_codec codec)
{
    static const exr_compression_t of[] = {
        [EXR_CODEC_NONE] = EXR_COMPRESSION_NONE, [EXR_CODEC_ZIPS] = EXR_COMPRESSION_ZIPS,
        [EXR_CODEC_ZIP] = EXR_COMPRESSION_ZIP,   [EXR_CODEC_PIZ] = EXR_COMPRESSION_PIZ,
        [EXR_CODEC_DWAA] = EXR_COMPRESSION_DWAA,
    };
    return of[codec];
}

static exr_result_t write_header(struct exr_rows *w)
{
    int part;
    exr_result_t r = exr_add_part(w->context, NULL, EXR_STORAGE_SCANLINE, &part);
    if (!r)
        r = exr_initialize_required_attr_simple(w->context, 0, w->image->width_px,
                                                w->image->height_px,
                                                compression_of(w->metadata->codec));
    if (!r) r = add_channels(w);
    if (!r) r = exr_attributes_add(w->context, w->metadata);
    if (!r) r = exr_write_header(w->context);
    if (!r) r = exr_get_scanlines_per_chunk(w->context, 0, &w->chunk_rows);
    return r;
}

/* The library sorts channels: bind each by its name. */
static const struct plane *bound_plane(const struct exr_rows *w, const char *name)
{
    return image_plane(w->image, name);
}

static void bind_halves(struct exr_rows *w, exr_coding_channel_info_t *channel,
                        const struct plane *plane, int32_t y, uint16_t *halves)
{
    int32_t width = w->image->width_px;
    for (int32_t row = 0; row < channel->height; row++) {
        half_from_floats(plane_row(plane, y + row), halves + (ptrdiff_t)row * width, (size_t)width);
    }
    channel->encode_from_ptr = (const uint8_t *)halves;
    channel->user_line_stride = width * 2;
}

static exr_result_t bind(struct exr_rows *w, int32_t y)
{
    size_t chunk_pixels = (size_t)w->image->width_px * (size_t)w->chunk_rows;
    for (int16_t c = 0; c < w->encoder.channel_count; c++) {
        exr_coding_channel_info_t *channel = &w->encoder.channels[c];
        const struct plane *plane = bound_plane(w, channel->channel_name);
        if (!plane) return EXR_ERR_INVALID_ARGUMENT;
        bool half = channel->data_type == EXR_PIXEL_HALF;
        channel->user_bytes_per_element = half ? 2 : 4;
        channel->user_data_type = channel->data_type;
        channel->user_pixel_stride = half ? 2 : 4;
        if (half) {
            bind_halves(w, channel, plane, y, w->halves + (size_t)c * chunk_pixels);
        } else {
            channel->encode_from_ptr = (const uint8_t *)plane_row(plane, y);
            channel->user_line_stride = (int32_t)plane->stride * 4;
        }
    }
    return EXR_ERR_SUCCESS;
}

/* In place of the library's own, where it has none or a slow one. */
static void choose_compressor(struct exr_rows *w)
{
    const enum exr_codec codec = w->metadata->codec;
    if (codec == EXR_CODEC_DWAA) w->encoder.compress_fn = exr_dwa_compress;
    if (codec != EXR_CODEC_ZIP && codec != EXR_CODEC_ZIPS) return;
    w->encoder.compress_fn = exr_zip_compress;
    w->encoder.encoding_user_data = w->zip;
}

static exr_result_t write_chunk(struct exr_rows *w, int32_t y)
{
    exr_chunk_info_t chunk;
    exr_result_t r = exr_write_scanline_chunk_info(w->context, 0, y, &chunk);
    if (r) return r;
    bool first = !w->encoding;
    if (first) {
        r = exr_encoding_initialize(w->context, 0, &chunk, &w->encoder);
        w->encoding = !r;
    } else {
        r = exr_encoding_update(w->context, 0, &chunk, &w->encoder);
    }
    if (!r) r = bind(w, y);
    if (!r && first) {
        r = exr_encoding_choose_default_routines(w->context, 0, &w->encoder);
        choose_compressor(w);
    }
    return r ? r : exr_encoding_run(w->context, 0, &w->encoder);
}

/* Opens the library's context on the file under its temporary name, and writes all that comes
 * before the first chunk. */
static exr_result_t begin_file(struct exr_rows *w)
{
    exr_context_initializer_t init;
    w->file.is_written = true;
    exr_file_context(&w->file, &init);
    init.read_fn = NULL;
    exr_result_t r = exr_start_write(&w->context, w->path, EXR_WRITE_FILE_DIRECTLY, &init);
    if (r) return r;
    r = write_header(w);
    if (!r && !(w->zip = exr_zip_create())) r = EXR_ERR_OUT_OF_MEMORY;
    if (r || !w->metadata->half) return r;
    const size_t pixels = (size_t)w->image->width_px * (size_t)w->chunk_rows;
    w->halves = malloc(pixels * w->image->channel_count * sizeof *w->halves);
    return w->halves ? EXR_ERR_SUCCESS : EXR_ERR_OUT_OF_MEMORY;
}

/* Opens a file beside the target, under a name that no other thread of the system uses. */
static int open_beside(struct exr_rows *w, struct fault *fault)
{
    int length = snprintf(w->path, sizeof w->path, "%s.tmp-%d", w->name, (int)gettid());
    if (length >= (int)sizeof w->path)
        return fault_set(fault, ERR_LIMIT, "path", "the path is too long");
    w->file.fd = open(w->path, O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC | O_NOFOLLOW, 0666);
    if (w->file.fd >= 0) return 0;
    const int error = fault_set(fault, error_of_errno(errno), w->name, "%s", strerror(errno));
    w->path[0] = '\0';
    return error;
}

int exr_rows_begin(const char *path, const struct image *image, const struct exr_metadata *metadata,
                   struct exr_rows **out, struct fault *fault)
{
    struct exr_rows *w = calloc(1, sizeof *w);
    *out = NULL;
    if (!w) return fault_set(fault, ERR_MEMORY, path, "memory is exhausted");
    w->image = image;
    w->metadata = metadata;
    w->file.fd = -1;
    w->name = strdup(path);
    int error = w->name ? 0 : fault_set(fault, ERR_MEMORY, path, "memory is exhausted");
    if (!error) error = open_beside(w, fault);
    if (!error) error = exr_file_fault(&w->file, begin_file(w), path, fault);
    if (error)
        exr_rows_abort(&w);
    else
        *out = w;
    return error;
}

/* The chunks of a scan-line file must come in order, each once. */
int exr_rows_write(struct exr_rows *w, int32_t end, struct fault *fault)
{
    exr_result_t r = EXR_ERR_SUCCESS;
    const int32_t height = w->image->height_px;
    while (!r && w->next < height && (end >= height || w->next + w->chunk_rows <= end)) {
        r = write_chunk(w, w->next);
        w->next += w->chunk_rows;
    }
    return exr_file_fault(&w->file, r, w->name, fault);
}

/* Lets go of all but the file and its names. exr_finish writes the table of chunks, and says
 * nothing when chunks are missing: all that came before must have succeeded. */
static exr_result_t end_file(struct exr_rows *w)
{
    if (w->encoding) exr_encoding_destroy(w->context, &w->encoder);
    w->encoding = false;
    return w->context ? exr_finish(&w->context) : EXR_ERR_SUCCESS;
}

static int seal(struct exr_rows *w, struct fault *fault)
{
    int error = exr_file_fault(&w->file, end_file(w), w->name, fault);
    const int fd = w->file.fd;
    w->file.fd = -1;
    if (close(fd) && !error)
        error =
            fault_set(fault, error_of_errno(errno), w->name, "closing failed: %s", strerror(errno));
    if (!error && rename(w->path, w->name))
        error = fault_set(fault, error_of_errno(errno), w->name, "renaming failed: %s",
                          strerror(errno));
    if (!error) w->path[0] = '\0';
    return error;
}

int exr_rows_finish(struct exr_rows **rows, struct fault *fault)
{
    int error = exr_rows_write(*rows, (*rows)->image->height_px, fault);
    if (!error) error = seal(*rows, fault);
    exr_rows_abort(rows);
    return error;
}

void exr_rows_abort(struct exr_rows **rows)
{
    struct exr_rows *w = *rows;
    *rows = NULL;
    if (!w) return;
    end_file(w);
    if (w->file.fd >= 0) close(w->file.fd);
    if (w->path[0]) unlink(w->path);
    exr_zip_destroy(&w->zip);
    free(w->halves);
    free(w->name);
    free(w);
}

int exr_write(const char *path, const struct image *image, const struct exr_metadata *metadata,
              struct fault *fault)
{
    struct exr_rows *rows = NULL;
    const int error = exr_rows_begin(path, image, metadata, &rows, fault);
    return rows ? exr_rows_finish(&rows, fault) : error;
}
