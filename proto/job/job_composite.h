#pragma once
/* How a job's picture is composed with a photograph: which parts of the scene stand for what the
 * photograph shows, and how the light that virtual objects take from them and give them changes it.
 *
 *   backplate  {asset, fit, color_space} or null
 *   rgbd       {document, surfaces, light, fit, color_space} or null: frames of a camera that
 * measures depth, instead catchers   [names of nodes or materials, {"ground": {"height": y}}]
 * holdouts [names of nodes or materials] composite  {mode}
 *
 * docs/mixed-reality.md explains them. */
#include <stdbool.h>
#include <stddef.h>

#include "proto/digest.h"

/* How a photograph of another size or shape becomes as large as the picture. */
enum plate_fit {
    PLATE_FIT_EXACT,  /* it does not: another size is refused */
    PLATE_FIT_COVER,  /* scaled until it covers the picture, and cut on both sides alike */
    PLATE_FIT_STRETCH /* scaled by each axis */
};

/* What numbers of PNG, JPEG and WebP files mean. Those of .hdr and .exr files are linear. */
enum plate_color { PLATE_COLOR_SRGB, PLATE_COLOR_LINEAR };

/* What surfaces a frame of a sequence of colour and depth has. */
enum rgbd_surfaces {
    RGBD_SCREEN, /* what it and those beside it saw */
    RGBD_FUSED   /* one model of all frames */
};

/* What lights a sequence of colour and depth beside the job's lights and environment. */
enum rgbd_lighting {
    RGBD_LIGHT_AUTO,     /* where nothing else lights it, what the frames tell of the light */
    RGBD_LIGHT_ESTIMATE, /* the same, beside lights of the scene and the job */
    RGBD_LIGHT_STUDIO    /* nothing: without any light the studio light, as other scenes */
};

/* Whether the importer estimates it. */
enum rgbd_estimate {
    RGBD_ESTIMATE_NONE,
    RGBD_ESTIMATE_UNLESS_LIT, /* where the scene's file has no lights */
    RGBD_ESTIMATE_ALWAYS
};

/* How a catcher's change becomes the photograph's. */
enum composite_mode {
    COMPOSITE_MULTIPLY, /* plate * with / without: Mehta et al. 2015, equation 2 */
    COMPOSITE_ADD       /* plate + with - without: Debevec 1998, differential rendering */
};

struct job_composite {
    bool on; /* the document has one of the members; else all here is zero */
    bool has_plate;
    struct digest plate;         /* asset: .jpg, .png, .webp, .hdr or .exr */
    char *rgbd;                  /* owned; document: one of scene.files; NULL: none */
    enum rgbd_surfaces surfaces; /* of rgbd; default screen */
    enum rgbd_lighting light;    /* of rgbd; default auto */
    enum rgbd_estimate estimate; /* what light, the job's lights and environment mean */
    enum plate_fit fit;          /* default exact */
    enum plate_color color;      /* default sRGB */
    char *catchers, *holdouts;   /* owned; JSON arrays of names, null for the ground; NULL: none */
    bool has_ground;             /* a floor of our making catches, too */
    float ground_height;         /* of the floor: y, scene units */
    enum composite_mode mode;    /* default multiply */
};

/* Returns whether the picture has a photograph: one for all frames, or one for each. */
static inline bool job_composite_has_plate(const struct job_composite *composite)
{
    return composite->has_plate || composite->rgbd;
}

/* ERR_MEMORY: *out is empty. */
int job_composite_copy(const struct job_composite *from, struct job_composite *out);
void job_composite_fini(struct job_composite *composite);
