#include "server/image/png_shade.h"

#include <math.h>
#include <string.h>

/* The largest finite value of a plane, at least 0. */
static float plane_max(const struct plane *plane)
{
    float max = 0.0f;
    for (int32_t y = 0; y < plane->height_px; y++) {
        const float *row = plane_row(plane, y);
        for (int32_t x = 0; x < plane->width_px; x++) {
            if (row[x] > max && isfinite(row[x])) max = row[x];
        }
    }
    return max;
}

/* Returns whether there is light where nothing covers the pixel: an environment, which is in the
 * colours of edges, too. */
static bool has_ground(const struct png_shader *s)
{
    for (int32_t y = 0; y < s->alpha->height_px; y++)
        for (int32_t x = 0; x < s->alpha->width_px; x++) {
            if (*plane_at(s->alpha, x, y) > 0.0f) continue;
            for (int c = 0; c < 3; c++)
                if (*plane_at(s->rgb[c], x, y) > 0.0f) return true;
        }
    return false;
}

/* Numbers that are shares of 1 already. */
static bool is_share(const char *layer)
{
    return !strcmp(layer, "visibility");
}

static bool is_vector(const char *layer)
{
    return !strcmp(layer, "normal");
}

struct png_options png_options_of_layer(const struct png_options *options, const char *layer)
{
    struct png_options own = *options;
    if (!image_layer_is_light(layer)) own.exposure_ev = 0.0f;
    return own;
}

int png_shader_bind(struct png_shader *s, const struct image *image, const char *layer,
                    const struct png_options *options)
{
    const bool is_light = image_layer_is_light(layer);
    *s = (struct png_shader){.view = view_transform_of(is_light ? options->view : VIEW_LINEAR,
                                                       (double)options->exposure_ev),
                             .is_deep = options->is_deep,
                             .factor = 1.0f};
    if (!image_layer_planes(image, layer, s->rgb)) return ERR_NOT_FOUND;
    if (options->alpha && !strcmp(layer, "beauty")) s->alpha = image_plane(image, "A");
    if (is_vector(layer))
        s->shade = PNG_SHADE_VECTOR;
    else if (s->rgb[0] == s->rgb[1])
        s->shade = is_share(layer) ? PNG_SHADE_SHARE : PNG_SHADE_SCALED;
    return 0;
}

bool png_shader_is_local(const struct png_shader *s)
{
    return s->shade != PNG_SHADE_SCALED && !s->alpha;
}

void png_shader_begin(struct png_shader *s)
{
    if (s->shade == PNG_SHADE_COLOR) tonemap_table_init(&s->table);
    if (s->alpha) s->is_straight = has_ground(s);
    if (s->shade != PNG_SHADE_SCALED) return;
    const float max = plane_max(s->rgb[0]);
    s->factor = max > 1e-30f ? 1.0f / max : 0.0f; /* a tiny maximum has no finite inverse */
}

int png_shader_channels(const struct png_shader *s)
{
    return s->alpha ? 4 : 3;
}

size_t png_shader_row_bytes(const struct png_shader *s)
{
    return (size_t)s->rgb[0]->width_px * (size_t)png_shader_channels(s) * (s->is_deep ? 2 : 1);
}

/* v clipped to [0, 1]; NaN gives 0. */
static float clip(float v)
{
    return v > 0.0f ? (v < 1.0f ? v : 1.0f) : 0.0f;
}

/* Stores round(most * v) of v in [0, 1]. Returns where the next sample goes. */
static uint8_t *put(const struct png_shader *s, float v, uint8_t *out)
{
    if (!s->is_deep) {
        *out = (uint8_t)lrintf(255.0f * v);
        return out + 1;
    }
    const long sample = lrintf(65535.0f * v);
    out[0] = (uint8_t)(sample >> 8);
    out[1] = (uint8_t)(sample & 0xff);
    return out + 2;
}

/* PNG files have the colour of what covers the pixel, without alpha in it. */
static double straight(const struct png_shader *s, float light, float alpha)
{
    if (!(alpha > 0.0f)) return 0.0;
    return (double)light / (s->is_straight ? 1.0 : (double)clip(alpha));
}

static void load(const struct png_shader *s, int32_t y, int32_t x0, int32_t count,
                 struct view_pixels *pixels)
{
    const float *alpha = s->alpha ? plane_row(s->alpha, y) + x0 : NULL;
    for (int c = 0; c < 3; c++) {
        const float *light = plane_row(s->rgb[c], y) + x0;
        double *to = pixels->channel[c];
        for (int32_t i = 0; i < count; i++)
            to[i] = alpha ? straight(s, light[i], alpha[i]) : (double)light[i];
    }
}

/* Stores a sample of each of `count` pixels; of 8 bits by the table. */
static void store(const struct png_shader *s, const double *shown, int32_t count, uint8_t *out)
{
    const int channels = png_shader_channels(s);
    if (!s->is_deep) tonemap_table_bytes(&s->table, shown, count, out, channels);
    for (int32_t i = 0; s->is_deep && i < count; i++)
        put(s, tonemap_srgb((float)shown[i]), out + 2 * channels * i);
}

static void shade_colors(const struct png_shader *s, int32_t y, uint8_t *out)
{
    const int32_t width = s->rgb[0]->width_px, sample = s->is_deep ? 2 : 1;
    const int32_t pixel = png_shader_channels(s) * sample;
    struct view_pixels pixels = {0};
    for (int32_t x = 0; x < width; x += VIEW_PIXELS) {
        const int32_t count = width - x < VIEW_PIXELS ? width - x : VIEW_PIXELS;
        load(s, y, x, count, &pixels);
        view_transform_apply(&s->view, &pixels);
        for (int c = 0; c < 3; c++)
            store(s, pixels.channel[c], count, out + x * pixel + c * sample);
    }
    for (int32_t x = 0; s->alpha && x < width; x++)
        put(s, clip(*plane_at(s->alpha, x, y)), out + x * pixel + 3 * sample);
}

void png_shader_row(const struct png_shader *s, int32_t y, uint8_t *out)
{
    if (s->shade == PNG_SHADE_COLOR) {
        shade_colors(s, y, out);
        return;
    }
    for (int32_t x = 0; x < s->rgb[0]->width_px; x++)
        for (int c = 0; c < 3; c++) {
            const float v = *plane_at(s->rgb[c], x, y);
            out =
                put(s, clip(s->shade == PNG_SHADE_VECTOR ? 0.5f * (v + 1.0f) : v * s->factor), out);
        }
}
