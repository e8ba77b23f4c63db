#include "server/image/reduce.h"

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

/* The integral of the tent 1 - |t| from its left end to s. */
static double tent_until(double s)
{
    if (s <= -1) return 0;
    if (s >= 1) return 1;
    return s < 0 ? (1 + s) * (1 + s) / 2 : 1 - (1 - s) * (1 - s) / 2;
}

/* Shares of the 3 * times pixels from one large pixel before to one behind. */
static void tent_shares(int32_t times, double *shares)
{
    for (int32_t i = 0; i < 3 * times; i++)
        shares[i] = tent_until((i + 1.0) / times - 1.5) - tent_until((double)i / times - 1.5);
}

static float tent_at(const struct plane *from, int32_t x, int32_t y, int32_t times,
                     const double *shares)
{
    double sum = 0, weights = 0;
    for (int32_t j = 0; j < 3 * times; j++) {
        int32_t row_y = (y - 1) * times + j;
        if (row_y < 0 || row_y >= from->height_px || shares[j] <= 0) continue;
        const float *row = plane_row(from, row_y);
        for (int32_t i = 0; i < 3 * times; i++) {
            int32_t at = (x - 1) * times + i;
            if (at < 0 || at >= from->width_px || shares[i] <= 0) continue;
            sum += shares[j] * shares[i] * (double)row[at];
            weights += shares[j] * shares[i];
        }
    }
    return (float)(sum / weights); /* its own pixels are always there */
}

int image_reduce_tent(const struct image *image, int32_t times, struct image **out,
                      struct fault *fault)
{
    double shares[3 * REDUCE_TENT_MOST];
    *out = NULL;
    if (times > REDUCE_TENT_MOST)
        return fault_set(fault, ERR_RANGE, "", "a tent over %d pixels is not below %d", times,
                         REDUCE_TENT_MOST + 1);
    int error = image_reduce(image, image_rect(image), times, out, fault);
    if (error) return error;
    tent_shares(times, shares);
    for (uint32_t c = 0; c < image->channel_count; c++) {
        const struct plane *to = &(*out)->channels[c].plane;
        if (is_error(image->channels[c].name)) continue;
        for (int32_t y = 0; y < to->height_px; y++)
            for (int32_t x = 0; x < to->width_px; x++)
                *plane_at(to, x, y) = tent_at(&image->channels[c].plane, x, y, times, shares);
    }
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
