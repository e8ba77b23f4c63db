#pragma once
/* How the numbers of a layer become the samples of a PNG file. */
#include "server/image/image.h"
#include "server/image/tonemap.h"
#include "server/image/view_transform.h"

/* All zero: 8 bits, opaque, plain sRGB. */
struct png_options {
    enum view_curve view; /* of layers of light */
    float exposure_ev;    /* of colours of any kind */
    bool is_deep;         /* 16 bits a sample instead of 8 */
    bool alpha;           /* of beauty: what no surface covers is transparent */
};

/* Returns a picture's options as they are for one of its layers: the exposure of its light is none
 * of albedo's or of an error's. */
struct png_options png_options_of_layer(const struct png_options *options, const char *layer);

enum png_shade {
    PNG_SHADE_COLOR,  /* sRGB of what the view shows */
    PNG_SHADE_VECTOR, /* (v + 1) / 2 */
    PNG_SHADE_SHARE,  /* v */
    PNG_SHADE_SCALED  /* v over the largest */
};

struct png_shader {
    const struct plane *rgb[3], *alpha; /* borrowed; alpha: NULL for opaque pictures */
    enum png_shade shade;
    struct view_transform view;
    bool is_deep;
    float factor;     /* of v; 1 but for SCALED */
    bool is_straight; /* colours have alpha taken out already, or what is behind is in them */
    struct tonemap_table table;
};

/* Finds the planes of a layer (image_layer_planes) and how they are shown. ERR_NOT_FOUND. Other
 * functions take the shader after this. */
int png_shader_bind(struct png_shader *shader, const struct image *image, const char *layer,
                    const struct png_options *options);

/* Returns whether rows can be shaded before all others are there. */
bool png_shader_is_local(const struct png_shader *shader);

/* Makes it ready for rows; all of them must be there unless it is local. */
void png_shader_begin(struct png_shader *shader);

/* Samples of a pixel, 3 or 4, and the bytes of a row. */
int png_shader_channels(const struct png_shader *shader);
size_t png_shader_row_bytes(const struct png_shader *shader);

/* Shades row y; samples of 16 bits have their high byte first. */
void png_shader_row(const struct png_shader *shader, int32_t y, uint8_t *out);
