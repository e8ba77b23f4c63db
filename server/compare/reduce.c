#include "server/compare/reduce.h"

#include <math.h>
#include <string.h>

static bool is_error(const char *channel)
{
    return !strncmp(channel, "error.", 6);
}

struct rect image_rect(const struct image *image)
{
    return (struct rect){0, 0, image->width_px, image->height_px};
}

static double sum_square(const struct plane *from, int32_t x0, int32_t y0, int32_t box,
                         bool squared)
{
    double sum = 0;
    for (int32_t y = y0; y < y0 + box; y++) {
        const float *row = plane_row(from, y);
        for (int32_t x = x0; x < x0 + box; x++)
            sum += squared ? (double)row[x] * row[x] : (double)row[x];
    }
    return sum;
}

static void reduce_plane(const struct plane *from, const struct plane *to, struct rect crop,
                         int32_t box, bool errors)
{
    double count = (double)box * box;
    for (int32_t y = 0; y < to->height_px; y++) {
        float *row = plane_row(to, y);
        for (int32_t x = 0; x < to->width_px; x++) {
            double sum = sum_square(from, crop.x0 + x * box, crop.y0 + y * box, box, errors);
            row[x] = (float)((errors ? sqrt(sum) : sum) / count);
        }
    }
}

static int check(const struct image *image, struct rect crop, int32_t box, struct fault *fault)
{
    if (rect_is_empty(crop) || crop.x0 < 0 || crop.y0 < 0 || crop.x1 > image->width_px ||
        crop.y1 > image->height_px)
        return fault_set(fault, ERR_RANGE, "", "the crop %d..%d, %d..%d is not inside %d x %d",
                         crop.x0, crop.x1, crop.y0, crop.y1, image->width_px, image->height_px);
    if (box < 1 || box > rect_width(crop) || box > rect_height(crop))
        return fault_set(fault, ERR_RANGE, "", "a box of %d pixels does not fit %d x %d", box,
                         rect_width(crop), rect_height(crop));
    return 0;
}

int image_reduce(const struct image *image, struct rect crop, int32_t box_px, struct image **out,
                 struct fault *fault)
{
    const char *names[IMAGE_CHANNELS];
    *out = NULL;
    int error = check(image, crop, box_px, fault);
    if (error) return error;
    for (uint32_t c = 0; c < image->channel_count; c++) names[c] = image->channels[c].name;
    error = image_create_named(names, image->channel_count, rect_width(crop) / box_px,
                               rect_height(crop) / box_px, out);
    if (error) return fault_set(fault, error, "", "no room for the reduced image");
    for (uint32_t c = 0; c < image->channel_count; c++)
        reduce_plane(&image->channels[c].plane, &(*out)->channels[c].plane, crop, box_px,
                     is_error(names[c]));
    return 0;
}
