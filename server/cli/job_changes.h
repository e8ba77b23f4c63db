#pragma once
/* What a command line changes of a job document before it is sent. */
#include <jansson.h>

#include "proto/error.h"
#include "proto/limits.h"
#include "server/cli/option.h"

struct job_changes {
    const char *size;               /* image.width x image.height, "640x360"; NULL */
    const char *camera;             /* scene.camera: name or index; NULL */
    const char *variant;            /* scene.variant; NULL */
    const char *animation;          /* scene.animation; NULL */
    const char *time;               /* scene.time_s, a number; NULL */
    const char *frames;             /* frames, "1-10,20-40x2"; NULL */
    const char *fps;                /* fps, a number; NULL */
    const char *shutter;            /* camera.shutter, a number; NULL */
    const char *name;               /* name; NULL */
    const char *comment;            /* comment; NULL */
    struct option_list labels;      /* to add; each may be several, parted by commas */
    const char *webhook;            /* webhook.url; NULL; `render` has no option for it */
    const char *environment;        /* .hdr or .exr on this machine; NULL: as in the document */
    const char *backplate;          /* photograph on this machine; NULL: as in the document */
    const char *fit;                /* backplate.fit; NULL */
    struct option_list catchers;    /* names to add to catchers, likewise */
    const char *ground;             /* height of a ground to add to them, a number; NULL */
    struct option_list holdouts;    /* names to add to holdouts, likewise */
    const char *composite;          /* composite.mode; NULL */
    const char *method;             /* filter.method; NULL */
    const char *indirect;           /* filter.indirect; NULL */
    const char *glossy;             /* filter.glossy; NULL */
    const char *lens;               /* filter.lens; NULL */
    const char *environment_filter; /* filter.environment; NULL */
    const char *residual;           /* filter.residual; NULL */
    const char *temporal;           /* filter.temporal; NULL */
    const char *view;               /* image.view; NULL */
    const char *exposure;           /* image.exposure, a number; NULL */
    const char *compression;        /* image.exr_compression; NULL */
    long png_bits;                  /* image.png_bits; 0 */
    bool png_alpha;                 /* image.png_alpha true */
    long bounces;                   /* effects.indirect_bounces; -1 */
    long spp;                       /* sampling.spp; 0 */
    long tile_px;                   /* sampling.tile_px; 0 */
    bool no_default_light;          /* scene.default_light false */
    bool cryptomatte;               /* adds both layers of ids */
};
#define JOB_CHANGES_NONE                                                                           \
    {                                                                                              \
        .bounces = -1                                                                              \
    }

#define JOB_CHANGE_TEXT(word, sign, what, sentence, where)                                         \
    {                                                                                              \
        .name = (word), .letter = (sign), .kind = OPTION_TEXT, .value = (what),                    \
        .text = (sentence), .out = (where)                                                         \
    }
#define JOB_CHANGE_LIST(word, what, sentence, where)                                               \
    {                                                                                              \
        .name = (word), .kind = OPTION_LIST, .value = (what), .text = (sentence), .out = (where)   \
    }
#define JOB_CHANGE_NUMBER(word, sign, sentence, from, to, where)                                   \
    {                                                                                              \
        .name = (word), .letter = (sign), .kind = OPTION_NUMBER, .value = "N", .text = (sentence), \
        .least = (from), .most = (to), .out = (where)                                              \
    }

/* The lines of a command's option table that fill *c. */
#define JOB_CHANGES_OPTIONS(c)                                                                     \
    JOB_CHANGE_TEXT("size", 's', "WxH", "pixels of the picture instead of the job's", &(c)->size), \
        JOB_CHANGE_TEXT("view", 0, "linear|filmic|agx", "how PNG files and the viewer show light", \
                        &(c)->view),                                                               \
        JOB_CHANGE_TEXT("exposure", 0, "STOPS", "exposure of PNG files and the viewer",            \
                        &(c)->exposure),                                                           \
        JOB_CHANGE_NUMBER("png-bits", 0, "bits of a PNG's samples: 8 or 16", 8, 16,                \
                          &(c)->png_bits),                                                         \
        {.name = "png-alpha",                                                                      \
         .kind = OPTION_FLAG,                                                                      \
         .text = "a PNG that is transparent where no surface is",                                  \
         .out = &(c)->png_alpha},                                                                  \
        JOB_CHANGE_TEXT("exr-compression", 0, "none|zips|zip|piz|dwaa",                            \
                        "compression of EXR files", &(c)->compression),                            \
        {.name = "cryptomatte",                                                                    \
         .kind = OPTION_FLAG,                                                                      \
         .text = "ids of objects and materials in the EXR, as Cryptomatte has them",               \
         .out = &(c)->cryptomatte},                                                                \
        JOB_CHANGE_TEXT("camera", 'c', "NAME|INDEX", "camera of the scene instead of the job's",   \
                        &(c)->camera),                                                             \
        JOB_CHANGE_TEXT("variant", 0, "NAME", "variant of the scene's materials", &(c)->variant),  \
        JOB_CHANGE_TEXT("animation", 0, "NAME", "animation of the scene that plays",               \
                        &(c)->animation),                                                          \
        JOB_CHANGE_TEXT("time", 0, "SECONDS", "show the scene as it is then, in all frames",       \
                        &(c)->time),                                                               \
        JOB_CHANGE_TEXT("frames", 0, "LIST", "frames instead of the job's, as 1-10,20-40x2",       \
                        &(c)->frames),                                                             \
        JOB_CHANGE_TEXT("fps", 0, "N", "frames per second instead of the job's", &(c)->fps),       \
        JOB_CHANGE_TEXT("shutter", 0, "SHARE",                                                     \
                        "share of a frame for which the shutter is open, 0 to 1: motion blur",     \
                        &(c)->shutter),                                                            \
        JOB_CHANGE_TEXT("name", 0, "TEXT", "name of the job, to find it by", &(c)->name),          \
        JOB_CHANGE_TEXT("comment", 0, "TEXT", "comment on the job", &(c)->comment),                \
        JOB_CHANGE_LIST("label", "LIST", "labels beside the job's, parted by commas",              \
                        &(c)->labels),                                                             \
        {.name = "no-default-light",                                                               \
         .kind = OPTION_FLAG,                                                                      \
         .text = "no studio light where nothing lights the scene",                                 \
         .out = &(c)->no_default_light},                                                           \
        JOB_CHANGE_TEXT("environment", 'e', "FILE",                                                \
                        "environment map (.hdr, .exr) instead of the job's", &(c)->environment),   \
        JOB_CHANGE_TEXT("backplate", 0, "FILE",                                                    \
                        "photograph (.jpg, .png, .webp, .exr, .hdr) that objects are put into",    \
                        &(c)->backplate),                                                          \
        JOB_CHANGE_TEXT("fit", 0, "exact|cover|stretch", "how it becomes as large as the picture", \
                        &(c)->fit),                                                                \
        JOB_CHANGE_LIST("catcher", "LIST",                                                         \
                        "nodes or materials that catch shadows in it, parted by commas",           \
                        &(c)->catchers),                                                           \
        JOB_CHANGE_TEXT("catcher-ground", 0, "Y", "height of a floor that catches them",           \
                        &(c)->ground),                                                             \
        JOB_CHANGE_LIST("holdout", "LIST",                                                         \
                        "nodes or materials that hide objects behind it, parted by commas",        \
                        &(c)->holdouts),                                                           \
        JOB_CHANGE_TEXT("composite", 0, "multiplicative|additive",                                 \
                        "how shadows and light are put into it", &(c)->composite),                 \
        JOB_CHANGE_NUMBER("bounces", 'b', "indirect bounces instead of the job's", 0,              \
                          LIMIT_INDIRECT_BOUNCES, &(c)->bounces),                                  \
        JOB_CHANGE_NUMBER("spp", 0, "samples per pixel instead of the job's", 1, LIMIT_SPP,        \
                          &(c)->spp),                                                              \
        JOB_CHANGE_TEXT("method", 'm', "auto|sheared|axis_aligned|average|none",                   \
                        "filter of soft shadows; none: plain paths, no filter at all",             \
                        &(c)->method),                                                             \
        JOB_CHANGE_TEXT("environment-filter", 0, "auto|average|axis_aligned",                      \
                        "what brings an environment's light: paths, or a light field",             \
                        &(c)->environment_filter),                                                 \
        JOB_CHANGE_TEXT("indirect", 0, "auto|average|constant|linear|blend|adaptive|sheared",      \
                        "filter of indirect light and ambient occlusion", &(c)->indirect),         \
        JOB_CHANGE_TEXT("glossy", 0, "auto|average|virtual_hit|bandlimit|sg|sg_mixture|asg",       \
                        "filter of glossy reflections", &(c)->glossy),                             \
        JOB_CHANGE_TEXT("lens", 0, "auto|average|axis_aligned|sheared",                            \
                        "filter of depth of field", &(c)->lens),                                   \
        JOB_CHANGE_TEXT("residual", 0, "auto|none|halves|oidn",                                    \
                        "filter of light that comes along paths", &(c)->residual),                 \
        JOB_CHANGE_TEXT("temporal", 0, "auto|none|1|2",                                            \
                        "frames on each side whose samples a frame uses", &(c)->temporal)

/* Sets the members of a picture that is composed with a photograph (job_photograph.c). */
int job_changes_photograph(const struct job_changes *changes, json_t *document,
                           struct fault *fault);
/* Sets document[group][key]; a member of the wrong shape is left for the server to refuse. */
int job_changes_set(json_t *document, const char *group, const char *key, json_t *value);

/* Changes the document. The map's file becomes {"environment": {"file": its whole path}}, beside
 * the intensity and rotation of a map that was there. Members of the wrong shape are left for the
 * server to refuse. ERR_NOT_FOUND for a map that is not there, ERR_MEMORY. */
int job_changes_apply(const struct job_changes *changes, json_t *document, struct fault *fault);
