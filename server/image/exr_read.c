#include <stdlib.h>
#include <string.h>

#include "server/image/exr_reader.h"

static int refuse(struct exr_reader *r, int code, const char *why)
{
    return fault_set(r->fault, code, r->path, "%s", why);
}

static int check(struct exr_reader *r, exr_result_t result)
{
    return exr_file_fault(&r->file, result, r->path, r->fault);
}

/* Accepts one flat part. Deep parts are never touched, because the library's readers of them are
 * not safe. */
static int check_storage(struct exr_reader *r, bool *tiled)
{
    int parts = 0;
    exr_storage_t storage;
    int error = check(r, exr_get_count(r->context, &parts));
    if (!error && parts != 1)
        return refuse(r, ERR_UNSUPPORTED, "files of several parts are not read");
    if (!error) error = check(r, exr_get_storage(r->context, 0, &storage));
    if (error) return error;
    if (storage != EXR_STORAGE_SCANLINE && storage != EXR_STORAGE_TILED)
        return refuse(r, ERR_UNSUPPORTED, "deep files are not read");
    *tiled = storage == EXR_STORAGE_TILED;
    return 0;
}

/* The library's C core knows these by name only. */
static int check_compression(struct exr_reader *r, bool *dwa)
{
    exr_compression_t compression = EXR_COMPRESSION_NONE;
    int error = check(r, exr_get_compression(r->context, 0, &compression));
    *dwa = compression == EXR_COMPRESSION_DWAA || compression == EXR_COMPRESSION_DWAB;
    if (!error && *dwa && !r->read_dwa)
        error = refuse(r, ERR_UNSUPPORTED,
                       "DWA compression is not read: save it with ZIP or PIZ compression");
    return error;
}

static int check_window(struct exr_reader *r, int64_t *width, int64_t *height)
{
    int error = check(r, exr_get_data_window(r->context, 0, &r->window));
    if (error) return error;
    *width = (int64_t)r->window.max.x - r->window.min.x + 1;
    *height = (int64_t)r->window.max.y - r->window.min.y + 1;
    if (*width < 1 || *height < 1) return refuse(r, ERR_RANGE, "the data window is empty");
    if (*width > LIMIT_IMAGE_SIDE_PX || *height > LIMIT_IMAGE_SIDE_PX)
        return refuse(r, ERR_LIMIT, "the data window is above the limit");
    if (r->selection && *width * *height > r->selection->pixels_max)
        return refuse(r, ERR_LIMIT, "the data window has more pixels than are allowed");
    return 0;
}

static int check_whole(struct exr_reader *r)
{
    exr_attr_box2i_t display;
    int error = check(r, exr_get_display_window(r->context, 0, &display));
    if (!error && memcmp(&display, &r->window, sizeof display) != 0)
        error = refuse(r, ERR_UNSUPPORTED,
                       "the data window is not the display window: a part of the picture is cut");
    return error;
}

static bool is_wanted(const struct exr_reader *r, const char *channel)
{
    if (!r->selection) return true;
    for (uint32_t c = 0; c < r->selection->channel_count; c++)
        if (strcmp(r->selection->channels[c], channel) == 0) return true;
    return false;
}

/* The wanted channels' names, borrowed from the context. */
static int list_channels(struct exr_reader *r, const char *names[IMAGE_CHANNELS], uint32_t *count)
{
    const exr_attr_chlist_t *channels;
    int error = check(r, exr_get_channels(r->context, 0, &channels));
    if (error) return error;
    if (channels->num_channels < 1 || channels->num_channels > IMAGE_CHANNELS)
        return refuse(r, ERR_LIMIT, "the number of channels is out of range");
    *count = 0;
    for (int c = 0; c < channels->num_channels; c++) {
        const exr_attr_chlist_entry_t *entry = &channels->entries[c];
        if (entry->x_sampling != 1 || entry->y_sampling != 1)
            return refuse(r, ERR_UNSUPPORTED, "subsampled channels are not read");
        if (!is_wanted(r, entry->name.str)) continue;
        names[(*count)++] = entry->name.str;
    }
    return *count > 0 ? 0 : refuse(r, ERR_MISSING, "it has none of the channels that are wanted");
}

static int create_image(struct exr_reader *r)
{
    const char *names[IMAGE_CHANNELS];
    uint32_t count = 0;
    int64_t width = 0, height = 0;
    int error = check_window(r, &width, &height);
    if (!error) error = list_channels(r, names, &count);
    if (!error && r->selection && r->selection->whole) error = check_whole(r);
    if (error) return error;
    error = image_create_named(names, count, (int32_t)width, (int32_t)height, &r->image);
    if (!error && r->selection) {
        r->sink = malloc((size_t)width * sizeof *r->sink);
        error = r->sink ? 0 : ERR_MEMORY;
    }
    return error ? refuse(r, error, error_text(error)) : 0;
}

/* Sends a skipped channel's rows to one row, over each other. Not every path of the library checks
 * for NULL. */
static void pass_over(const struct exr_reader *r, exr_coding_channel_info_t *channel)
{
    channel->decode_to_ptr = (uint8_t *)r->sink;
    channel->user_bytes_per_element = 4;
    channel->user_data_type = EXR_PIXEL_FLOAT;
    channel->user_pixel_stride = 4;
    channel->user_line_stride = 0;
}

/* Binds channels to where a chunk's rows go. The library converts halves and integers to floats. */
static int bind(struct exr_reader *r, int32_t x, int32_t y)
{
    for (int16_t c = 0; c < r->decoder.channel_count; c++) {
        exr_coding_channel_info_t *channel = &r->decoder.channels[c];
        const struct plane *plane = image_plane(r->image, channel->channel_name);
        if (!plane && r->sink && channel->width <= r->image->width_px) {
            pass_over(r, channel);
            continue;
        }
        if (!plane || x < 0 || y < 0 || x + channel->width > plane->width_px ||
            y + channel->height > plane->height_px)
            return refuse(r, ERR_CORRUPT, "a chunk lies outside the data window");
        channel->decode_to_ptr = (uint8_t *)plane_at(plane, x, y);
        channel->user_bytes_per_element = 4;
        channel->user_data_type = EXR_PIXEL_FLOAT;
        channel->user_pixel_stride = 4;
        channel->user_line_stride = (int32_t)plane->stride * 4;
    }
    return 0;
}

/* x, y: the chunk's corner in the image. */
static int read_chunk(struct exr_reader *r, const exr_chunk_info_t *chunk, int32_t x, int32_t y)
{
    bool first = !r->decoding;
    int error;
    if (first) {
        error = check(r, exr_decoding_initialize(r->context, 0, chunk, &r->decoder));
        r->decoding = !error;
    } else {
        error = check(r, exr_decoding_update(r->context, 0, chunk, &r->decoder));
    }
    if (!error) error = bind(r, x, y);
    if (!error && first)
        error = check(r, exr_decoding_choose_default_routines(r->context, 0, &r->decoder));
    return error ? error : check(r, exr_decoding_run(r->context, 0, &r->decoder));
}

static int read_scanlines(struct exr_reader *r)
{
    int32_t rows = 0;
    int error = check(r, exr_get_scanlines_per_chunk(r->context, 0, &rows));
    if (!error && rows < 1) return refuse(r, ERR_CORRUPT, "chunks have no rows");
    for (int32_t y = 0; !error && y < r->image->height_px; y += rows) {
        exr_chunk_info_t chunk;
        error = check(r, exr_read_scanline_chunk_info(r->context, 0, r->window.min.y + y, &chunk));
        if (!error) error = read_chunk(r, &chunk, 0, y);
    }
    return error;
}

/* The finest level alone. */
static int read_tiles(struct exr_reader *r)
{
    int32_t width = 0, height = 0;
    int error = check(r, exr_get_tile_sizes(r->context, 0, 0, 0, &width, &height));
    if (!error && (width < 1 || height < 1)) return refuse(r, ERR_CORRUPT, "tiles have no size");
    for (int32_t y = 0; !error && y < r->image->height_px; y += height) {
        for (int32_t x = 0; !error && x < r->image->width_px; x += width) {
            exr_chunk_info_t chunk;
            error = check(
                r, exr_read_tile_chunk_info(r->context, 0, x / width, y / height, 0, 0, &chunk));
            if (!error) error = read_chunk(r, &chunk, x, y);
        }
    }
    return error;
}

int exr_reader_run(struct exr_reader *r)
{
    bool tiled = false, dwa = false;
    exr_context_initializer_t init;
    exr_file_context(&r->file, &init);
    init.write_fn = NULL;
    int error = check(r, exr_start_read(&r->context, r->path, &init));
    if (error) return error;
    error = check_storage(r, &tiled);
    if (!error) error = check_compression(r, &dwa);
    if (!error) error = create_image(r);
    if (!error) error = dwa ? r->read_dwa(r) : tiled ? read_tiles(r) : read_scanlines(r);
    if (r->decoding) exr_decoding_destroy(r->context, &r->decoder);
    exr_finish(&r->context);
    return error;
}

int exr_read_memory(const void *data, size_t size_bytes, const char *name,
                    const struct exr_selection *selection, struct image **out, struct fault *fault)
{
    struct exr_reader r = {.path = name,
                           .selection = selection,
                           .fault = fault,
                           .file = {.fd = -1, .memory = data, .memory_bytes = size_bytes}};
    *out = NULL;
    int error = exr_reader_run(&r);
    free(r.sink);
    if (error)
        image_destroy(&r.image);
    else
        *out = r.image;
    return error;
}
