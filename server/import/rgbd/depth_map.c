#include "server/import/rgbd/depth_map.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "server/import/image/image_decoder.h"
#include "server/import/image/panorama.h"
#include "server/import/image/photograph.h"

#define PLACE_BYTES 48

void depth_map_destroy(struct depth_map *map)
{
    free(map->z);
    free(map->sure);
    free(map->color);
    *map = (struct depth_map){0};
}

static int allocate(struct depth_map *m, uint32_t width, uint32_t height, const char *place,
                    struct fault *fault)
{
    const size_t count = (size_t)width * height;
    if (count > LIMIT_DEPTH_PIXELS)
        return fault_set(fault, ERR_LIMIT, place, "%u x %u px are above the limit of %u pixels",
                         width, height, LIMIT_DEPTH_PIXELS);
    m->width = (int32_t)width;
    m->height = (int32_t)height;
    m->z = calloc(count, sizeof *m->z);
    m->sure = calloc(count, sizeof *m->sure);
    if (m->z != NULL && m->sure != NULL) return 0;
    return fault_set(fault, ERR_MEMORY, place, "no memory for %u x %u px", width, height);
}

static void set(struct depth_map *m, size_t i, uint16_t value, const struct rgbd_document *d)
{
    const double z = value / d->scale;
    if (value == 0 || !(z >= d->near_m && z <= d->far_m)) return;
    m->z[i] = (float)z;
    m->sure[i] = 1;
}

static int read_png(const struct file_view *file, const char *place, const struct rgbd_document *d,
                    struct depth_map *m, struct fault *fault)
{
    struct image_header header;
    int rc = image_measure(file->data, file->size_bytes, place, &header, fault);
    if (rc == 0) rc = allocate(m, header.width_px, header.height_px, place, fault);
    if (rc != 0) return rc;
    const size_t count = (size_t)header.width_px * header.height_px;
    uint16_t *grey = malloc(count * sizeof *grey);
    if (grey == NULL) return fault_set(fault, ERR_MEMORY, place, "no memory for its pixels");
    rc = image_decode_grey16(file->data, file->size_bytes, &header, place, grey, fault);
    for (size_t i = 0; rc == 0 && i < count; i++) set(m, i, grey[i], d);
    free(grey);
    return rc;
}

static bool is_space(uint8_t byte)
{
    return byte && strchr(" \t\r\n", byte);
}

/* Reads a number of a PGM's header; 0: there is none, or it is far too large. */
static uint32_t pgm_number(const struct file_view *file, size_t *at)
{
    uint32_t v = 0;
    while (*at < file->size_bytes && (is_space(file->data[*at]) || file->data[*at] == '#'))
        if (file->data[(*at)++] == '#')
            while (*at < file->size_bytes && file->data[*at] != '\n') ++*at;
    for (; *at < file->size_bytes && file->data[*at] >= '0' && file->data[*at] <= '9'; ++*at) {
        if (v > LIMIT_IMAGE_SIDE_PX * 8) return 0;
        v = 10 * v + (uint32_t)(file->data[*at] - '0');
    }
    return v;
}

static int read_pgm(const struct file_view *file, const char *place, const struct rgbd_document *d,
                    struct depth_map *m, struct fault *fault)
{
    size_t at = 2;
    const uint32_t width = pgm_number(file, &at), height = pgm_number(file, &at);
    const uint32_t most = pgm_number(file, &at);
    if (width == 0 || height == 0 || most == 0 || most > UINT16_MAX)
        return fault_set(fault, ERR_CORRUPT, place, "the PGM's header is damaged");
    if (most < 256)
        return fault_set(fault, ERR_UNSUPPORTED, place, "its samples have 8 bits, not 16");
    if (width > LIMIT_IMAGE_SIDE_PX || height > LIMIT_IMAGE_SIDE_PX)
        return fault_set(fault, ERR_LIMIT, place, "%u x %u px are too many", width, height);
    int rc = allocate(m, width, height, place, fault);
    const size_t count = (size_t)width * height;
    if (rc == 0 && (at >= file->size_bytes || file->size_bytes - at - 1 < 2 * count))
        rc = fault_set(fault, ERR_TRUNCATED, place, "the PGM has fewer bytes than pixels");
    if (rc == 0 && (!is_space(file->data[at]) || file->size_bytes - at - 1 > 2 * count))
        rc = fault_set(fault, ERR_CORRUPT, place,
                       "samples do not follow the PGM's maximum after one byte of white space");
    if (rc != 0) return rc;
    const uint8_t *samples = file->data + at + 1;
    for (size_t i = 0; i < count; i++)
        set(m, i, (uint16_t)(samples[2 * i] << 8 | samples[2 * i + 1]), d);
    return 0;
}

static int read_depth(const struct rgbd_document *d, struct files *files, uint32_t frame,
                      struct depth_map *out, struct fault *fault)
{
    char place[PLACE_BYTES];
    struct file_view file;
    snprintf(place, sizeof place, "/rgbd/frames/%u/depth", frame);
    int rc = rgbd_file_map(d, files, d->frames[frame].depth, place, &file, fault);
    if (rc != 0) return rc;
    const bool is_pgm = file.size_bytes > 2 && memcmp(file.data, "P5", 2) == 0;
    rc = is_pgm ? read_pgm(&file, place, d, out, fault) : read_png(&file, place, d, out, fault);
    files_unmap(&file);
    if (rc != 0) return rc;
    const size_t count = (size_t)out->width * (size_t)out->height;
    for (size_t i = 0; i < count; i++)
        if (out->z[i] > 0) return 0;
    return fault_set(fault, ERR_MISSING, place,
                     "no pixel has a depth from %g to %g m: all are zero, or depth.scale is wrong",
                     d->near_m, d->far_m);
}

static int read_color(const struct rgbd_document *d, struct files *files, uint32_t frame,
                      struct depth_map *out, struct warnings *warnings, struct fault *fault)
{
    char place[PLACE_BYTES];
    struct file_view file;
    struct panorama p;
    snprintf(place, sizeof place, "/rgbd/frames/%u/color", frame);
    int rc = rgbd_file_map(d, files, d->frames[frame].color, place, &file, fault);
    if (rc != 0) return rc;
    rc = photograph_is_known(&file) ? photograph_read(&file, place, &p, warnings, fault)
         : panorama_is_exr(&file)   ? panorama_read_exr(&file, place, &p, fault)
                                    : fault_set(fault, ERR_UNSUPPORTED, place,
                                                "it is neither PNG, JPEG, WebP nor OpenEXR");
    files_unmap(&file);
    if (rc != 0) return rc;
    panorama_repair(&p, warnings);
    if ((int64_t)p.width_px != out->width || (int64_t)p.height_px != out->height)
        rc = fault_set(fault, ERR_MISMATCH, place,
                       "the colour image has %u x %u px, the depth image %d x %d", p.width_px,
                       p.height_px, out->width, out->height);
    out->color = p.texels;
    return rc;
}

int depth_map_read(const struct rgbd_document *d, struct files *files, uint32_t frame,
                   bool with_color, struct depth_map *out, struct warnings *warnings,
                   struct fault *fault)
{
    *out = (struct depth_map){0};
    int rc = read_depth(d, files, frame, out, fault);
    if (rc == 0 && with_color) rc = read_color(d, files, frame, out, warnings, fault);
    if (rc != 0) depth_map_destroy(out);
    return rc;
}

void depth_map_drop_strays(struct depth_map *m)
{
    for (int32_t y = 0; y < m->height; y++)
        for (int32_t x = 0; x < m->width; x++) {
            const size_t i = (size_t)y * (size_t)m->width + (size_t)x;
            const float z = m->z[i], near = 4 * depth_noise_m(z) + 0.01f * z;
            int alike = 0;
            if (!(z > 0)) continue;
            for (int32_t v = y > 0 ? y - 1 : 0; v <= y + 1 && v < m->height; v++)
                for (int32_t u = x > 0 ? x - 1 : 0; u <= x + 1 && u < m->width; u++)
                    alike += fabsf(m->z[(size_t)v * (size_t)m->width + (size_t)u] - z) < near;
            if (alike < 4) m->sure[i] = 0; /* itself among them */
        }
    const size_t count = (size_t)m->width * (size_t)m->height;
    for (size_t i = 0; i < count; i++)
        if (m->sure[i] == 0) m->z[i] = 0;
}
