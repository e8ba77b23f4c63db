#pragma once
/* A small scene with its job, as numbers that can be drawn from a seed, written as text, read back,
 * and made simpler one step at a time. All lengths are multiples of CASE_GRID, so that powers of
 * two scale them and shifts by multiples of it move them without rounding. */
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "tests/random.h"

#define CASE_GRID 0x1p-6

enum { CASE_BODIES = 8, CASE_LIGHTS = 4 };

enum body_shape {
    BODY_PANEL,  /* half sides along two axes of its frame */
    BODY_BOX,    /* faces outwards */
    BODY_ROOM,   /* a box whose faces point inwards */
    BODY_NEEDLE, /* a triangle as long as size[0] and as wide as a hair */
    BODY_POINT,  /* triangles without area */
    BODY_SHAPES
};

enum body_surface {
    SURFACE_LAMBERT,
    SURFACE_BLACK,
    SURFACE_EMITTER,
    SURFACE_GLOSSY, /* glTF, roughness by `sharpness` */
    SURFACE_METAL,  /* the same, metallic */
    SURFACE_GLASS,  /* transmits */
    SURFACE_MIRROR,
    SURFACE_PHONG,     /* exponent by `sharpness` */
    SURFACE_BLINN,     /* the same */
    SURFACE_ASHIKHMIN, /* the same */
    SURFACE_BECKMANN,  /* alpha by `sharpness` */
    SURFACE_FURNACE,   /* emits 1 and reflects its albedo */
    SURFACES
};

/* What is not the same all over a surface: textures of its own, of CASE_TEXELS x CASE_TEXELS. */
enum body_dress {
    DRESS_PLAIN,
    DRESS_COLOR,
    DRESS_MASK,   /* holes */
    DRESS_BLEND,  /* lets through by parts */
    DRESS_NORMAL, /* a normal map */
    DRESS_ROUGH,  /* roughness and metal of glTF surfaces */
    DRESS_GLOW,   /* emits here and there */
    DRESS_UNLIT,  /* colours that no light touches */
    DRESSES
};
enum { CASE_TEXELS = 8 };

struct case_body {
    enum body_shape shape;
    enum body_surface surface;
    enum body_dress dress;
    unsigned texels; /* seed of the dress */
    int smooth;      /* 1: normals lean outwards at corners */
    double centre[3], size[3];
    int facing; /* of panels, needles and points: axis 0 .. 2, + 3 for its other side */
    double albedo[3];
    double sharpness; /* 0 .. 1 */
};

enum case_light_kind {
    CASE_RECTANGLE,
    CASE_GAUSSIAN,
    CASE_POINT,
    CASE_SPOT,
    CASE_SUN,
    CASE_LIGHT_KINDS
};

struct case_light {
    enum case_light_kind kind;
    double centre[3], half[2];
    int facing; /* as a body's: where rectangles, spots and suns shine to */
    double level[3];
};

struct property_case {
    int width, height, tile, block; /* pixels; block a multiple of 32 */
    int spp, bounces, method, indirect, glossy, lens_filter;
    int environment_filter, residual;
    int halved;          /* 1: light fields at half resolution */
    double mu;           /* of adaptive sampling, among others; 0: 1 */
    double error;        /* the target that sampling goes on to; 0: none */
    int most;            /* samples of a pixel, under a target and adaptive sampling; 0: not said */
    int lens_second_set; /* paths a pixel of second sets through the lens; 0: none */
    unsigned seed;
    double eye[3], target[3], yfov_deg;
    int orthographic;       /* 1: as high as the field of view is at the target */
    int tent;               /* 1: the pixel filter */
    double aperture, focus; /* no lens: focus 0 */
    int blades;
    int layers;            /* 0: the picture alone; 1: all of PICTURE_LAYERS */
    double occlusion;      /* distance; 0: no such layer */
    double environment[3]; /* radiance; black: none */
    unsigned map;          /* seed of a map in its place; 0: none */
    int body_count, light_count;
    struct case_body bodies[CASE_BODIES];
    struct case_light lights[CASE_LIGHTS];
};

/* Of case_methods, case_indirects and case_lenses. */
enum { CASE_AVERAGE = 3, CASE_INDIRECT_SHEARED = 5, CASE_ADAPTIVE = 6, CASE_LENS_SHEARED = 3 };

/* Names of job documents, by the numbers in a case; ended by NULL. */
extern const char *const case_methods[],
    *const case_indirects[], *const case_glossies[], *const case_lenses[],
                                                         *const case_environments[],
                                                             *const case_residuals[];

void case_draw(uint64_t seed, struct property_case *out);

/* Lines of words and numbers. */
void case_write(const struct property_case *c, FILE *out);
/* Negative: not a case; the line's number is *line. */
int case_read(FILE *in, struct property_case *out, int *line);

/* The n-th of the ways to make a case simpler; false when there are no more than n. *out equals the
 * case where that way changes nothing. */
bool case_simpler(const struct property_case *c, int n, struct property_case *out);
