#pragma once
/* The sample buffer of a tile: which planes exist, their layout, packing, validation.
 *
 * Beside the planes there may be a list of lone sub-samples (lone.h), and one of mixed pixels
 * (mixed.h).
 *
 * A plane is w*h elements of one component, row by row. Components of a plane follow each other
 * (planar). Planes are grouped by element size, 4-byte ones first, then 2, then 1, and each group
 * is shuffled and compressed as one (packing.h), its components filtered before that where they
 * cross a network (plane_filter.h). A plane whose samples are all the default (zero bits) need not
 * be sent: its bit in the tile's masks is then clear.
 *
 * Section 5 of PROTOCOL.md says what a plane holds, and how many bytes a pixel takes. */
#include "proto/lone.h"
#include "proto/mixed.h"
#include "proto/packing.h"
#include "proto/plan.h"

enum plane_id {
#define PLANE(number, name, ...) PLANE_##name = number,
#include "proto/plane.def"
    PLANE_ID_COUNT,
    PLANE_MIXED = 62, /* likewise, the list of mixed pixels */
    PLANE_LONE = 63   /* no plane but the list of lone sub-samples: among planes its bit alone */
};

enum light_plane_id {
#define LIGHT_PLANE(number, name, ...) LIGHT_PLANE_##name = number,
#include "proto/plane.def"
    LIGHT_PLANE_COUNT
};

enum samples_type { SAMPLES_F32, SAMPLES_U32, SAMPLES_F16, SAMPLES_U16, SAMPLES_U8 };

/* A plane has its components for each of these. */
enum samples_per {
    SAMPLES_PER_PIXEL,
    SAMPLES_PER_SUB,     /* a sub-sample */
    SAMPLES_PER_STRATUM, /* a stratum of bounce rays */
    SAMPLES_PER_LENS,    /* a lens sample */
    SAMPLES_PER_BITS,    /* eight strata of a light */
};

/* What values a plane may hold. */
enum samples_values {
    SAMPLES_ANY,        /* every bit pattern means something */
    SAMPLES_POSITIVE,   /* finite, not negative */
    SAMPLES_FINITE,     /* finite */
    SAMPLES_ABOVE_MISS, /* finite, at least SUB_DEPTH_MISS */
    SAMPLES_ID,         /* at most LIMIT_INSTANCES */
    SAMPLES_SHARED_8,   /* shared exponent of 8 bits: up to shared_exponent_max */
    SAMPLES_SLOPES,     /* pairs: finite, 0 <= first <= second */
    SAMPLES_BITS,       /* no bit past the last stratum */
};

/* What happens to a plane when the tile's next pass is added (server/film/passes.h). */
enum samples_merge {
    SAMPLES_FIRST,       /* nothing: only the first pass has the plane */
    SAMPLES_SUM,         /* sums over paths are added */
    SAMPLES_SPREAD,      /* squared deviations are added, and what the two means differ by */
    SAMPLES_MEAN,        /* means are weighted by bounce rays */
    SAMPLES_MEAN_LOBES,  /* means are weighted by rays of glossy lobes */
    SAMPLES_MEAN_LENS,   /* means are weighted by paths through the lens */
    SAMPLES_MEAN_HALVES, /* as MEAN; even rays have three components, and then odd ones */
    SAMPLES_NEAREST,     /* the smaller number stays */
    SAMPLES_LATEST,      /* the later number stays */
};

/* A slot numbers the planes of a layout: first those of the frame, by their numbers, then those of
 * light after light. */
#define SAMPLES_SLOTS (PLANE_ID_COUNT + LIMIT_LIGHTS * LIGHT_PLANE_COUNT)

static inline uint32_t samples_light_slot(uint32_t light, enum light_plane_id plane)
{
    return PLANE_ID_COUNT + light * LIGHT_PLANE_COUNT + plane;
}

/* Returns the light that the slot's plane belongs to; 0 for a plane of the frame. */
static inline uint32_t samples_slot_light(uint32_t slot)
{
    return slot < PLANE_ID_COUNT ? 0 : (slot - PLANE_ID_COUNT) / LIGHT_PLANE_COUNT;
}

/* Returns the slot's row in plane.def, where all lights share theirs. */
static inline uint32_t samples_row(uint32_t slot)
{
    return slot < PLANE_ID_COUNT ? slot
                                 : PLANE_ID_COUNT + (slot - PLANE_ID_COUNT) % LIGHT_PLANE_COUNT;
}

/* A row of plane.def. */
struct samples_plane {
    const char *name;
    enum samples_type type;
    uint32_t components;
    enum samples_per per;
    enum samples_values values;
    enum samples_merge merge;
};

const struct samples_plane *samples_plane(uint32_t slot);
uint32_t samples_type_bytes(enum samples_type type);

/* A set of planes is the sum of these. */
#define PLANE_BIT(plane) (UINT64_C(1) << PLANE_##plane)

/* Planes of lens samples. */
#define PLANES_LENS                                                                                \
    (PLANE_BIT(LENS_RADIANCE) | PLANE_BIT(LENS_SLOPE) | PLANE_BIT(LENS_COVERAGE) |                 \
     PLANES_LENS_SURFACE)

/* The same, and the lobes that fields of glossy lobes light. */
#define PLANES_LENS_ALL (PLANES_LENS | PLANE_BIT(LENS_LOBE))

/* The planes of these that describe surfaces. */
#define PLANES_LENS_SURFACE                                                                        \
    (PLANE_BIT(LENS_DEPTH) | PLANE_BIT(LENS_NORMAL) | PLANE_BIT(LENS_ALBEDO) |                     \
     PLANE_BIT(LENS_OWN_LIGHT))

/* What second sets through the lens bring. */
#define PLANES_LENS_SECOND_SET (PLANE_BIT(LENS_SECOND_SET) | PLANE_BIT(LENS_COVERAGE))

/* Planes of the path tracer. */
#define PLANES_PATH                                                                                \
    ((2 * PLANE_BIT(PATH_VISIBILITY) - PLANE_BIT(PATH_RADIANCE)) | PLANE_BIT(PATH_HALF_DIFFERENCE2))

/* What the residual filter needs of paths besides, and all that it reads. */
#define PLANES_RESIDUAL                                                                            \
    (PLANE_BIT(PATH_HALF_SCATTERED) | PLANE_BIT(PATH_HALF_DIRECT) |                                \
     PLANE_BIT(PATH_HALF_INDIRECT) | PLANE_BIT(PATH_NORMAL) | PLANE_BIT(PATH_DISTANCE) |           \
     PLANE_BIT(PATH_TINT))
#define PLANES_RESIDUAL_READ                                                                       \
    ((PLANES_RESIDUAL & ~PLANE_BIT(PATH_HALF_INDIRECT)) | PLANE_BIT(PATH_RADIANCE) |               \
     PLANE_BIT(PATH_EMISSION) | PLANE_BIT(PATH_DIFFUSE_DIRECT) | PLANE_BIT(PATH_ALBEDO) |          \
     PLANE_BIT(PATH_COVERAGE))

/* What Open Image Denoise is given of them. Colours of metals (PATH_TINT) beside albedo change its
 * error by .1 dB at most, for better or worse. */
#define PLANES_OIDN_READ                                                                           \
    (PLANE_BIT(PATH_RADIANCE) | PLANE_BIT(PATH_ALBEDO) | PLANE_BIT(PATH_NORMAL))

/* All planes of the path tracer. */
#define PLANES_PATH_ALL (PLANES_PATH | PLANES_RESIDUAL)

/* Planes of bounce rays: of the light that they bring, and all. */
#define PLANES_BOUNCE_LIGHT                                                                        \
    (PLANE_BIT(INDIRECT_MEAN) | PLANE_BIT(INDIRECT_HALVES) | PLANE_BIT(INDIRECT_STRATA))
#define PLANES_BOUNCE_RAYS                                                                         \
    (PLANES_BOUNCE_LIGHT | PLANE_BIT(BOUNCE_DISTANCE_MIN) | PLANE_BIT(AMBIENT_VISIBILITY) |        \
     PLANE_BIT(BOUNCE_DISTANCE_MAX) | PLANE_BIT(AMBIENT_DISTANCE_MIN))

/* Planes of glossy lobes: what their rays bring, and all. */
#define PLANES_GLOSSY_LIGHT                                                                        \
    (PLANE_BIT(GLOSSY_MEAN) | PLANE_BIT(GLOSSY_LOBE) | PLANE_BIT(GLOSSY_NEARNESS))
#define PLANES_GLOSSY_AXES (PLANE_BIT(GLOSSY_TANGENT) | PLANE_BIT(GLOSSY_STRETCH))
#define PLANES_GLOSSY                                                                              \
    (PLANES_GLOSSY_LIGHT | PLANES_GLOSSY_AXES | PLANE_BIT(SUB_REFLECTANCE) | PLANE_BIT(GLOSSY_HALF))

/* Planes of ids for compositors: of objects, of materials, and all. */
#define PLANES_MATTE_OBJECTS   (PLANE_BIT(MATTE_OBJECTS) | PLANE_BIT(MATTE_OBJECT_SHARES))
#define PLANES_MATTE_MATERIALS (PLANE_BIT(MATTE_MATERIALS) | PLANE_BIT(MATTE_MATERIAL_SHARES))
#define PLANES_MATTE           (PLANES_MATTE_OBJECTS | PLANES_MATTE_MATERIALS)

#define LENS_RADIANCE_MAX 1e30f

#define BOUNCE_DISTANCE_NONE 65504.0f /* the largest half float */

/* Light planes that hold a rectangle's strata. */
#define LIGHT_PLANES_STRATA (1u << LIGHT_PLANE_VISIBILITY | 1u << LIGHT_PLANE_SLOPES)

#define SUB_DEPTH_MISS (-1.0f)

/* Planes by which sub-samples are found to be lone. */
#define PLANES_CENTRE (PLANE_BIT(DEPTH) | PLANE_BIT(NORMAL) | PLANE_BIT(ID))
#define PLANES_COMPARED                                                                            \
    (PLANES_CENTRE | PLANE_BIT(SUB_DEPTH) | PLANE_BIT(SUB_NORMAL) | PLANE_BIT(SUB_ALBEDO) |        \
     PLANE_BIT(SUB_ID))

/* Returns how many components a plane has under the plan; 0: the plan does not ask for it. */
uint32_t samples_components(const struct plan *plan, uint32_t slot);

/* Where each plane lies. Offsets are in bytes from the start of the data; SAMPLES_ABSENT: there is
 * no such plane. */
#define SAMPLES_ABSENT UINT32_MAX
struct samples_layout {
    int32_t width_px, height_px;
    uint32_t light_count, sub_samples;
    uint32_t slots;                      /* planes of the frame and of these lights */
    uint32_t lens_strata;                /* l_u^2 */
    uint32_t light_strata[LIMIT_LIGHTS]; /* l^2 */
    uint32_t lone_parts;                 /* of the list of lone sub-samples; 0: there is none */
    uint32_t mixed_values;               /* of the list of mixed pixels; 0: there is none */
    uint64_t planes;                     /* of PLANE_BIT */
    uint8_t light_planes[LIMIT_LIGHTS];  /* bits of enum light_plane_id */
    uint32_t components[SAMPLES_SLOTS];  /* that the plan has of them */
    uint32_t offset[SAMPLES_SLOTS];
    uint32_t group_bytes[3]; /* sizes of the 4-, 2- and 1-byte groups */
    uint32_t total_bytes;
};

/* Lays out all planes that the plan asks for in this pass (plan_pass_planes), for a tile of w x h.
 * ERR_LIMIT when the result would not fit a wire frame were all sub-samples lone and all pixels
 * mixed. */
int samples_layout_init(struct samples_layout *layout, const struct plan *plan, uint32_t pass,
                        int32_t width_px, int32_t height_px);

/* Does the same with only the planes in `planes` and `light_planes` (a subset of the pass's). */
int samples_layout_subset(struct samples_layout *layout, const struct plan *plan, uint32_t pass,
                          int32_t width_px, int32_t height_px, uint64_t planes,
                          const uint8_t *light_planes);

struct samples {
    struct samples_layout layout;
    uint8_t *data;             /* layout.total_bytes, 64-byte aligned, owned */
    struct sparse_list *lone;  /* owned; of layout.lone_parts; NULL: no sub-sample is lone */
    struct sparse_list *mixed; /* owned; of layout.mixed_values; NULL: no pixel is mixed */
};

/* Returns the size of planes and lists. */
size_t samples_bytes(const struct samples *s);

/* Returns the bound that places of lone sub-samples are below. */
uint32_t samples_lone_places(const struct samples_layout *layout);

/* Does the same for entries of mixed pixels. */
uint32_t samples_mixed_places(const struct samples_layout *layout);

/* Creates a zeroed buffer. The caller owns it; destroy nulls the pointer. */
int samples_create(const struct samples_layout *layout, struct samples **out);
void samples_destroy(struct samples **s);

/* Returns component c of a plane, w*h elements; NULL when the plane is absent. In a plane of
 * sub-samples, strata or lens samples, c is sample * components + component. The type must be the
 * plane's (asserted); f16 are read as u16. */
void *samples_component(const struct samples *s, uint32_t slot, uint32_t component);
float *samples_f32(const struct samples *s, enum plane_id plane, uint32_t component);
uint32_t *samples_u32(const struct samples *s, enum plane_id plane, uint32_t component);
uint16_t *samples_u16(const struct samples *s, enum plane_id plane, uint32_t component);
float *samples_light_irradiance(const struct samples *s, uint32_t light);
uint8_t *samples_light_visibility(const struct samples *s, uint32_t light, uint32_t byte);
uint16_t *samples_light_slope(const struct samples *s, uint32_t light, uint32_t which);
uint16_t *samples_light_weight(const struct samples *s, uint32_t light);

/* Packs s into w: drops planes that are all zero (counted in *dropped, which may be NULL), filters
 * the others where small is asked for, compresses. ERR_MEMORY leaves w as it was or failed.
 *
 *   u16 width, u16 height, u64 plane mask, u8 light plane mask per light,
 *   then per group (4-, 2-, 1-byte elements): u8 filter of each component (plane_filter.h), u32
 *   packed bytes, the bytes
 *   then, if PLANE_LONE is in the mask: u32 count, u32 packed bytes, the bytes of its words; and
 *   the same for PLANE_MIXED
 *
 * A group, or list, whose packed size equals its size is stored as it is; otherwise it is a blosc
 * buffer. */
int samples_pack(struct samples *s, enum packing packing, struct bytes_writer *w,
                 uint64_t *dropped);

/* Unpacks and validates against the plan and the pass: sizes and masks fit it, every number is
 * finite and within its range. Absent planes read as zero: the result has all planes of the pass.
 * On error nothing is returned and *fault names the plane and the pixel. */
int samples_unpack(const void *data, size_t size_bytes, const struct plan *plan, uint32_t pass,
                   int32_t width_px, int32_t height_px, struct samples **out, struct fault *fault);
