#pragma once
/* The sample buffer of a tile: which planes exist, their layout, packing, validation.
 *
 * Beside the planes there may be a list of lone sub-samples (lone.h).
 *
 * A plane is w*h elements of one component, row by row. Components of a plane follow each other
 * (planar). Planes are grouped by element size, 4-byte ones first, then 2, then 1, and each group
 * is shuffled and compressed as one (packing.h), its components filtered before that where they
 * cross a network (plane_filter.h). A plane whose samples are all the default (zero bits) need not
 * be sent: its bit in the tile's masks is then clear.
 *
 * Bytes a pixel before compression:
 *   depth 4 + normal 4 + albedo 6 + id 4
 *   + sub_samples * (depth 2 + normal 2 + albedo 6 + id 2)
 *   + emission 6 + indirect mean 6 + half-sums 12 + reflector distances 2 + 2 + open 2
 *   + indirect strata 8 l_i^2
 *   + glossy surfaces: mean 8 + half 8 + lobe 8 + nearness 2 + span 4 + 6 a sub-sample
 *   + lens samples 14 l_u^2 + coverage 2; where light fields light them 26 l_u^2 + 2
 *   + per light: irradiance 4 + visibility ceil(l^2 / 8) + slopes 4
 *   + paths: 12 for each plane of three components, 4 for coverage, occlusion and split: 108 at
 * most 9 spp, one area light, bounce light, three sub-samples, all of it but emission, the mean,
 * open shares and the farthest reflector: 18 + 36 + 14 + 10 = 78; with indirect strata instead of
 * half-sums 138. */
#include "proto/lone.h"
#include "proto/packing.h"
#include "proto/plan.h"

enum plane_id {
    PLANE_DEPTH = 0,         /* f32: distance along the unit camera ray; 0: no surface */
    PLANE_NORMAL = 1,        /* u32: octahedron_pack16 of the shading normal, facing the camera */
    PLANE_ALBEDO = 2,        /* 3 x u16: unorm, diffuse albedo */
    PLANE_ID = 3,            /* u32: instance index + 1; 0: no surface */
    PLANE_SUB_DEPTH = 4,     /* per sub-sample f16: d/d_ref - 1, d_ref the pixel's depth or, without
                                surface, length_unit; SUB_DEPTH_MISS: no surface. Where all of
                                PLANES_COMPARED are there, 0 of those that surely show their pixel's
                                surface (surface_match.h) */
    PLANE_SUB_NORMAL = 5,    /* per sub-sample u16: octahedron_pack8; of these the pixel's */
    PLANE_SUB_ALBEDO = 6,    /* per sub-sample 3 x u16: unorm */
    PLANE_SUB_ID = 7,        /* per sub-sample u16: low bits of the id, 0xffff where these are 0;
                                0: no surface */
    PLANE_EMISSION = 8,      /* 3 x f16: radiance * radiance_scale emitted towards the camera, mean
                                over the pixel's centre and sub-samples */
    PLANE_INDIRECT_MEAN = 9, /* 3 x f16: mean radiance * radiance_scale over the cosine-distributed
                                bounce rays: irradiance / pi */
    PLANE_INDIRECT_HALVES =
        10,               /* 6 x f16: mean over even samples, mean over odd ones, rgb each, even
                          where column and row of the stratum add up to an even number; for l = 1
                          both are the sample. The mean over all is
                          (ceil(n/2) even + floor(n/2) odd) / n */
    PLANE_REFLECTOR = 11, /* f16: nearest bounce hit's distance / length_unit; REFLECTOR_NONE: the
                             rays met nothing; 0: none were traced (no surface, or a black one) */
    PLANE_INDIRECT_STRATA = 12, /* per stratum 4 x f16: rgb * radiance_scale, hit distance /
                                length_unit (0: miss) */
    /* Of the path tracer, f32, each the sum over the pass's samples, in their order. Radiance is
     * what arrives at the camera: PATH_RADIANCE = emission + direct + indirect. */
    PLANE_PATH_RADIANCE = 13, /* 3: all of it */
    PLANE_PATH_SPREAD = 14,   /* 3: squared deviations from the pass's mean of PATH_RADIANCE */
    PLANE_PATH_EMISSION = 15, /* 3: seen without any scattering: emitters, environment */
    PLANE_PATH_DIRECT = 16,   /* 3: scattered once */
    PLANE_PATH_INDIRECT = 17, /* 3: scattered more often */
    PLANE_PATH_DIFFUSE_DIRECT = 18,   /* 3: the diffuse part of DIRECT, albedo taken out: what a
                                         white Lambert surface would send */
    PLANE_PATH_DIFFUSE_INDIRECT = 19, /* 3: the same of INDIRECT, by the first scattering */
    PLANE_PATH_ALBEDO = 20,           /* 3: diffuse albedo of what the camera sees */
    PLANE_PATH_COVERAGE = 21,         /* 1: samples that meet a surface */
    PLANE_PATH_OCCLUSION = 22,        /* 1: samples whose ambient occlusion ray is open, and those
                                         that meet no surface */
    PLANE_OPEN = 23,       /* f16: share of the bounce rays that meet nothing nearer than the plan's
                              occlusion_distance; 0 where none were traced */
    PLANE_PATH_SPLIT = 24, /* f32: squared differences between the sums of PATH_RADIANCE over the
                              first and over the second half of each of plan_pass_split's parts of
                              the pass, added up over these and rgb */
    PLANE_REFLECTOR_FAR = 25, /* f16: farthest bounce hit's distance / length_unit; 0: none was met,
                                 or none were traced */
    /* Of surfaces with a glossy lobe (worker/shade/glossy.h), by l^2 rays of that lobe's visible
     * facets; all 0 on others. A ray brings its weight, what the lobe sends on of light along it,
     * times the light; weights are taken over the lobe's reflectance of their channel, the
     * weight alone, added up over channels, over that of all. */
    PLANE_GLOSSY_MEAN = 26, /* 4 x f16: mean of weight * radiance * radiance_scale, rgb, and of the
                               weight alone */
    PLANE_GLOSSY_LOBE = 27, /* 4 x u16: unorm, directional albedo of the lobe, rgb, and its
                               roughness alpha; 0: no glossy lobe */
    PLANE_GLOSSY_NEARNESS = 28, /* f16: mean of length_unit / distance of the rays' hits, a miss
                                   counting as 0 */
    PLANE_SUB_REFLECTANCE = 29, /* per sub-sample 3 x u16: unorm, directional albedo of its glossy
                                   lobe; 0: none */
    PLANE_LENS_RADIANCE = 30,   /* per lens sample 3 x f32: what arrives through that point of the
                                   lens, LENS_RADIANCE_MAX at most. Halves are too narrow for
                                   suns, and for what is dim beside one */
    PLANE_LENS_SLOPE = 31,    /* per lens sample f16, finite: A f_px (1/z - 1/F), the way in pixels
                                 of what it shows per unit of the lens; A aperture_radius, F
                                 focus_distance, f_px = width_px / (2 half_width), z > 0 along
                                 forward of its first hit (a miss: infinity); positive in front of
                                 the focus */
    PLANE_LENS_COVERAGE = 32, /* f16: share of the lens samples that meet a surface */
    PLANE_GLOSSY_HALF = 33, /* 4 x f16: as GLOSSY_MEAN, over half of the rays: where column and row
                               of the pixel add up to an even number the first ceil(n/2), elsewhere
                               the others; for l = 1 all. Where an error is wanted */
    PLANE_GLOSSY_SPAN = 34, /* 2 x f16: nearest and farthest hit of a glossy lobe's rays, as
                               REFLECTOR and REFLECTOR_FAR of bounce rays */
    /* Where light fields of pixel centres light lens samples (enum lens_light), LENS_RADIANCE is
     * what is left of them without that light, and these say what it falls on. */
    PLANE_LENS_DEPTH = 35,  /* per lens sample f16: z along forward of its first hit / length_unit;
                               0: a miss */
    PLANE_LENS_NORMAL = 36, /* per lens sample u16: octahedron_pack8 of the shading normal */
    PLANE_LENS_ALBEDO = 37, /* per lens sample u32: diffuse albedo, of shared exponent, 9 bits */
    PLANE_LENS_LIGHT = 38,  /* per lens sample u32: what its own path found of that light, albedo
                               taken out, of shared exponent, 8 bits; for samples of points that
                               no pixel centre shows */
    PLANE_LENS_MORE = 39,   /* 4 x f32: of a pixel's second set of paths through the lens the mean
                               radiance, rgb, and the root of the mean of the sum of its squares;
                               0 where it has none */
    PLANE_LENS_LOBE = 40, /* per lens sample u32: directional albedo, of shared exponent, 9 bits, of
                             its glossy lobe, where fields bring what this sends on, too; else 0 */
    PLANE_ID_COUNT = 41,
    PLANE_LONE = 63 /* no plane but the list of lone sub-samples: among planes its bit alone */
};

/* A set of planes is the sum of these. */
#define PLANE_BIT(plane) (UINT64_C(1) << PLANE_##plane)

/* Planes of lens samples. */
#define PLANES_LENS                                                                                \
    (PLANE_BIT(LENS_RADIANCE) | PLANE_BIT(LENS_SLOPE) | PLANE_BIT(LENS_COVERAGE) |                 \
     PLANES_LENS_SURFACE)

/* The same, and what fields of glossy lobes light. */
#define PLANES_LENS_ALL (PLANES_LENS | PLANE_BIT(LENS_LOBE))

/* Of those the planes of what light falls on. */
#define PLANES_LENS_SURFACE                                                                        \
    (PLANE_BIT(LENS_DEPTH) | PLANE_BIT(LENS_NORMAL) | PLANE_BIT(LENS_ALBEDO) |                     \
     PLANE_BIT(LENS_LIGHT))

/* What second sets through the lens bring. */
#define PLANES_LENS_MORE (PLANE_BIT(LENS_MORE) | PLANE_BIT(LENS_COVERAGE))

/* Planes of the path tracer. */
#define PLANES_PATH                                                                                \
    ((2 * PLANE_BIT(PATH_OCCLUSION) - PLANE_BIT(PATH_RADIANCE)) | PLANE_BIT(PATH_SPLIT))

/* Planes of bounce rays: of the light that they bring, and all. */
#define PLANES_BOUNCE_LIGHT                                                                        \
    (PLANE_BIT(INDIRECT_MEAN) | PLANE_BIT(INDIRECT_HALVES) | PLANE_BIT(INDIRECT_STRATA))
#define PLANES_BOUNCE_RAYS                                                                         \
    (PLANES_BOUNCE_LIGHT | PLANE_BIT(REFLECTOR) | PLANE_BIT(OPEN) | PLANE_BIT(REFLECTOR_FAR))

/* Planes of glossy lobes: what their rays bring, and all. */
#define PLANES_GLOSSY_LIGHT                                                                        \
    (PLANE_BIT(GLOSSY_MEAN) | PLANE_BIT(GLOSSY_LOBE) | PLANE_BIT(GLOSSY_NEARNESS))
#define PLANES_GLOSSY (PLANES_GLOSSY_LIGHT | PLANE_BIT(SUB_REFLECTANCE) | PLANE_BIT(GLOSSY_HALF))

#define LENS_RADIANCE_MAX 1e30f

#define REFLECTOR_NONE 65504.0f /* the largest half float */

enum light_plane_id {
    LIGHT_PLANE_IRRADIANCE = 0, /* f32: E of plan.h with visibility: the plain Monte Carlo mean */
    LIGHT_PLANE_VISIBILITY = 1, /* bits, ceil(l^2/8) x u8: stratum i seen at bit i & 7 of byte i >>
                                   3; not traced (below the shading normal's horizon, facing away)
                                   counts as seen, hidden by the receiver's own facet as not; bits
                                   past the last stratum are clear, samples_pack sees to it */
    LIGHT_PLANE_SLOPES = 2,     /* 2 x f16: least and largest slope s = t/(1-t) over blocked strata;
                                   0, 0: none blocked */
    LIGHT_PLANE_COUNT = 3
};

/* Light planes that hold a rectangle's strata. */
#define LIGHT_PLANES_STRATA (1u << LIGHT_PLANE_VISIBILITY | 1u << LIGHT_PLANE_SLOPES)

#define SUB_DEPTH_MISS (-1.0f)

/* Planes by which sub-samples are found to be lone. */
#define PLANES_COMPARED                                                                            \
    (PLANE_BIT(DEPTH) | PLANE_BIT(NORMAL) | PLANE_BIT(ID) | PLANE_BIT(SUB_DEPTH) |                 \
     PLANE_BIT(SUB_NORMAL) | PLANE_BIT(SUB_ALBEDO) | PLANE_BIT(SUB_ID))

/* Where each plane lies. Offsets in bytes from the start of the data; SAMPLES_ABSENT if absent. */
#define SAMPLES_ABSENT UINT32_MAX
struct samples_layout {
    int32_t width_px, height_px;
    uint32_t light_count, sub_samples;
    uint32_t indirect_strata;            /* l_i^2 */
    uint32_t lens_strata;                /* l_u^2 */
    uint32_t light_strata[LIMIT_LIGHTS]; /* l^2 */
    uint32_t lone_parts;                 /* of the list of lone sub-samples; 0: there is none */
    uint64_t planes;                     /* of PLANE_BIT */
    uint8_t light_planes[LIMIT_LIGHTS];  /* bits of enum light_plane_id */
    uint32_t offset[PLANE_ID_COUNT];
    uint32_t light_offset[LIMIT_LIGHTS][LIGHT_PLANE_COUNT];
    uint32_t group_bytes[3]; /* sizes of the 4-, 2- and 1-byte groups */
    uint32_t total_bytes;
};

/* All planes that the plan asks for in this pass (plan_pass_planes), for a tile of w x h. ERR_LIMIT
 * when it would not fit a frame were all sub-samples lone. */
int samples_layout_init(struct samples_layout *layout, const struct plan *plan, uint32_t pass,
                        int32_t width_px, int32_t height_px);

/* The same with only the planes in `planes` and `light_planes` (a subset of the pass's). */
int samples_layout_subset(struct samples_layout *layout, const struct plan *plan, uint32_t pass,
                          int32_t width_px, int32_t height_px, uint64_t planes,
                          const uint8_t *light_planes);

struct samples {
    struct samples_layout layout;
    uint8_t *data;          /* layout.total_bytes, 64-byte aligned, owned */
    struct lone_list *lone; /* owned; of layout.lone_parts; NULL: no sub-sample is lone */
};

/* What planes and list hold. */
size_t samples_bytes(const struct samples *s);

/* What places of lone sub-samples are below. */
uint32_t samples_lone_places(const struct samples_layout *layout);

/* Zeroed buffer. Owned by the caller; destroy nulls the pointer. */
int samples_create(const struct samples_layout *layout, struct samples **out);
void samples_destroy(struct samples **s);

/* Component c of a plane, w*h elements; NULL when the plane is absent. Sub-sample planes: component
 * = sub * components_per_sub + c (depth, normal, id 1; albedo, reflectance 3); strata: stratum * 4
 * + c; lens samples: sample * 3 + c and sample. The element size must match the plane (asserted).
 */
float *samples_f32(const struct samples *s, enum plane_id plane, uint32_t component);
uint32_t *samples_u32(const struct samples *s, enum plane_id plane, uint32_t component);
uint16_t *samples_u16(const struct samples *s, enum plane_id plane, uint32_t component);
float *samples_light_irradiance(const struct samples *s, uint32_t light);
uint8_t *samples_light_visibility(const struct samples *s, uint32_t light, uint32_t byte);
uint16_t *samples_light_slope(const struct samples *s, uint32_t light, uint32_t which);

/* Packs s into w: drops planes that are all zero (counted in *dropped, which may be NULL), filters
 * the others where small is asked for, compresses. ERR_MEMORY leaves w as it was or failed.
 *
 *   u16 width, u16 height, u64 plane mask, u8 light plane mask per light,
 *   then per group (4-, 2-, 1-byte elements): u8 filter of each component (plane_filter.h), u32
 *   packed bytes, the bytes
 *   then, if PLANE_LONE is in the mask: u32 count, u32 packed bytes, the bytes of its words
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
