#pragma once
/* The scene blob. shearwater-import writes it, the coordinator plans from it and workers trace it.
 *
 * It is flat, little-endian and can be mapped. A header and a table of sections precede the
 * sections, each aligned to 64 bytes and followed by at least 16 readable bytes, as Embree reads
 * past the last vertex. A section is an array of one record type below. All cross references are
 * indexes, which scene_open checks once, so that every later access is safe. A frame of a scene
 * that moves has a blob of its own, whose first meshes and images are those of a base, another
 * blob; it has all else itself. So what never moves is stored, checked and built once. Coordinates
 * are in world units, from the origin in scene_info, with y up or not as in the source. Angles are
 * in radians, and colours linear with Rec. 709 primaries. */
#include <stddef.h>
#include <stdint.h>

#include "proto/digest.h"
#include "proto/error.h"
#include "proto/shutter.h"

#define SCENE_MAGIC       "SWSCENE"
#define SCENE_VERSION     7u
#define SCENE_ALIGN_BYTES 64u
#define SCENE_NONE        UINT32_MAX /* no index */

/* Of the light that the importer estimates: rows of texels from the top. */
#define SCENE_SKY_WIDTH_PX  64u
#define SCENE_SKY_HEIGHT_PX 32u
#define SCENE_SKY_TEXELS    (SCENE_SKY_WIDTH_PX * SCENE_SKY_HEIGHT_PX)

enum scene_section {
    SCENE_INFO = 0,      /* struct scene_info, exactly one */
    SCENE_POSITIONS = 1, /* float[3] */
    SCENE_NORMALS = 2,   /* float[3], unit */
    SCENE_TANGENTS = 3,  /* float[4], unit, w the bitangent's sign */
    SCENE_UVS = 4,       /* float[2] */
    SCENE_TRIANGLES = 5, /* uint32_t[3], relative to the mesh's first vertex */
    SCENE_MESHES = 6,
    SCENE_INSTANCES = 7,
    SCENE_MATERIALS = 8,
    SCENE_TEXTURES = 9,
    SCENE_IMAGES = 10,
    SCENE_PIXELS = 11, /* uint8_t */
    SCENE_LIGHTS = 12,
    SCENE_CAMERAS = 13,
    SCENE_NAMES = 14,    /* char: NUL-terminated strings that records refer to by offset; byte 0 is
                            NUL, so that offset 0 is the empty name */
    SCENE_WARNINGS = 15, /* char: NUL-terminated sentences, one after the other */
    SCENE_COLORS = 16,   /* float[4]: factors of the base colour, linear, and of alpha */
    SCENE_BASE = 17,     /* struct digest of the base; at most one */
    SCENE_MOVERS = 18,   /* what moves while the shutter is open, in the order of instances */
    SCENE_STEPS = 19,    /* SHUTTER_STEPS of each mover */
    SCENE_POSES = 20,    /* struct scene_camera, SHUTTER_STEPS of each camera; or none: all stand */
    SCENE_SKY = 21,      /* float[3]: light from far around, SCENE_SKY_TEXELS as a map of the
                            environment has them (environment.h); or none */
    SCENE_SECTION_COUNT = 22
};

struct scene_header {
    char magic[8]; /* "SWSCENE\0" */
    uint32_t version;
    uint32_t section_count; /* SCENE_SECTION_COUNT */
    uint64_t total_bytes;
    uint64_t reserved;
};

struct scene_section_entry {
    uint64_t offset; /* bytes from the blob's start, a multiple of SCENE_ALIGN_BYTES */
    uint64_t count;  /* records */
    uint32_t record_bytes;
    uint32_t reserved;
};

/* SCENE_MOVES: the file has an animation, so the scene differs from time to time. SCENE_IS_BASE: it
 * is for frames to stand on, and no picture by itself; its instances are the frames' first. */
enum { SCENE_MOVES = 1u, SCENE_IS_BASE = 2u };
struct scene_info {
    float bounds_min[3], bounds_max[3]; /* of all placed geometry; of a base, of the first pose of
                                           all that frames place */
    uint64_t placed_triangles;          /* after instancing */
    uint32_t default_camera;            /* index; there is always one camera */
    uint32_t flags;
    uint32_t plate; /* name of the job's file that the camera took here; 0: the job says */
    uint32_t reserved;
    double origin[3]; /* what the importer took from all positions: 0 unless they were far away */
};

/* MESH_IN_BASE: the base has its arrays, under the same index and in the same ranges. */
enum {
    MESH_HAS_NORMALS = 1u,
    MESH_HAS_TANGENTS = 2u,
    MESH_IS_LIGHT = 4u,
    MESH_HAS_COLORS = 8u,
    MESH_IN_BASE = 16u
};

/* One glTF primitive or OBJ group: one material. Meshes may share stretches of the arrays. Optional
 * arrays run parallel to the positions of the same mesh. Where a mesh lacks them the first_ index
 * is 0 and nothing is read. A material may refer to a UV set that the mesh lacks. MESH_IS_LIGHT:
 * its emission is in SCENE_LIGHTS, so scattered rays that hit it add nothing. The front of a
 * triangle is the side from which its corners run counter-clockwise; v of UVs grows downwards, as
 * rows of images do. */
struct scene_mesh {
    uint32_t first_vertex, vertex_count;
    uint32_t first_triangle, triangle_count;
    uint32_t first_normal, first_tangent;
    uint32_t first_uv[2]; /* SCENE_NONE: no such UV set */
    uint32_t material;
    uint32_t flags;
    uint32_t name;
    uint32_t first_color;
};

/* A placed mesh. Meshes placed once have the transform baked in and an identity here (flag). The
 * instances of a mesh stand together. The importer writes no mirroring transform: mirrored
 * placements get mirrored geometry, so that winding is the same in the mesh and in the world.
 * Catchers and holdouts stand for what a photograph shows (plan_view); only one flag is set. */
enum { INSTANCE_IDENTITY = 1u, INSTANCE_CATCHER = 2u, INSTANCE_HOLDOUT = 4u };
struct scene_instance {
    uint32_t mesh;
    uint32_t flags;
    uint32_t name;
    uint32_t reserved;
    float to_world[12]; /* 3 rows of 4: x' = R x + t */
};

/* An instance that moves. One that bends is the only one of a mesh of the frame's own. */
struct scene_mover {
    uint32_t instance;
    uint32_t bends; /* 1: the vertices move; 0: as a whole */
};

/* A mover at one step (proto/shutter.h). The one in the middle is the instance itself. */
struct scene_step {
    uint32_t first_vertex, first_normal; /* of one that bends, as a mesh has them; else 0 */
    float to_world[12];                  /* of one that does not; else the instance's */
};

enum alpha_mode { ALPHA_OPAQUE = 0, ALPHA_MASK = 1, ALPHA_BLEND = 2 };
/* MATERIAL_DOUBLE_SIDED: it emits from both sides. MATERIAL_COLORED: the colours of vertices
 * multiply base_color, where a mesh has them. MATERIAL_CULLED: cameras do not see its back. */
enum {
    MATERIAL_DOUBLE_SIDED = 1u,
    MATERIAL_UNLIT = 2u,
    MATERIAL_COLORED = 4u,
    MATERIAL_CULLED = 8u
};

struct scene_texture_ref {
    uint32_t texture;   /* SCENE_NONE: none */
    uint32_t uv_set;    /* 0 or 1 */
    float transform[6]; /* u' = t0 u + t1 v + t2, v' = t3 u + t4 v + t5 (KHR_texture_transform) */
};

/* How a surface scatters. GLTF, the default, is metallic-roughness with its extensions. The others
 * come from OBJ files (server/import/obj/obj_shading.h) and from a glTF material's extras,
 *
 *   "extras": {"shearwater": {"model": "phong", "exponent": 50, "specular": [0.2, 0.2, 0.2]}}
 *
 *   model              members beside it, required unless they have a default
 *   lambert            none: glTF's model without its coat, as KHR_materials_specular of factor 0
 *   phong              exponent in [0, 1e5], specular
 *   blinn_phong        exponent, specular
 *   ashikhmin_shirley  exponent, or exponent_u (along the tangent) and exponent_v; specular
 *   beckmann           alpha in [0, 1], or alpha_u (along the tangent) and alpha_v; specular, or a
 *                      metal's refractive index by colour: eta, its real part, in [1e-3, 1e3], and
 *                      k, its imaginary one, in [0, 1e3], whose reflectance specular scales, [1, 1,
 *                      1] if absent
 *   ward               alpha, or alpha_u and alpha_v; specular
 *   kelemen            alpha, specular
 *   measured           uri of a file as MERL has, to which the importer fits a diffuse lobe and two
 *                      of GGX facets (worker/shade/measured.h)
 *   mirror             specular, [1, 1, 1] if absent
 *
 * where specular has three numbers in [0, 1]. The diffuse albedo is baseColorFactor, times
 * baseColorTexture; it and specular are scaled down, with a warning, where they sum up to more than
 * 1, except under kelemen. Mirrors, metals and what is measured take none from there. Emission,
 * opacity and normal maps stay glTF's; metallic, clear and anisotropic parts are ignored. */
enum material_model {
#define MODEL(number, NAME, name) MODEL_##NAME = (number),
#include "proto/scene/model.def"
    MODEL_COUNT
};

/* A model ignores the fields that it does not name. base_color is the diffuse albedo of all. */
struct scene_material {
    float base_color[4];
    float emission[3]; /* radiance: emissiveFactor * emissiveStrength */
    float metallic, roughness;
    float normal_scale;
    float alpha_cutoff;
    float specular; /* KHR_materials_specular factor, 1 by default; 0: pure Lambert */
    float ior;      /* 1.5 by default; 0: reflects everything (KHR_materials_ior) */
    float transmission;
    uint32_t alpha_mode;
    uint32_t flags;
    uint32_t name;
    uint32_t model;             /* enum material_model */
    float specular_color[3];    /* KHR_materials_specular, 1 by default */
    float anisotropy;           /* KHR_materials_anisotropy strength, 0 .. 1 */
    float anisotropy_rad;       /* its rotation from the tangent towards the bitangent */
    float thickness;            /* KHR_materials_volume; 0: thin-walled */
    float attenuation[3];       /* transmittance over attenuation_distance, (0, 1] */
    float attenuation_distance; /* scene units; 0: clear */
    float model_specular[3];    /* of the models that are not glTF's */
    float exponent_u, exponent_v;
    float alpha_u, alpha_v;
    float second_specular[3], second_alpha; /* measured: the second lobe */
    float grazing[2];                       /* what both lobes reflect at grazing angles */
    float eta[3], k[3];                     /* complex refractive index of a conductor */
    float clearcoat, clearcoat_roughness;   /* KHR_materials_clearcoat; 0: none */
    float clearcoat_normal_scale;
    float dispersion;                      /* KHR_materials_dispersion: 20 / Abbe; 0: none */
    float sheen_color[3], sheen_roughness; /* KHR_materials_sheen; black: none */
    float iridescence, iridescence_ior;    /* KHR_materials_iridescence; 0: none */
    float iridescence_nm[2];               /* the film's thickness where its texture is 0, 1 */
    float diffuse_transmission;            /* KHR_materials_diffuse_transmission; 0: none */
    float diffuse_transmission_color[3];
    struct scene_texture_ref base_color_texture, metallic_roughness_texture, normal_texture,
        emission_texture, transmission_texture /* red */, specular_texture /* alpha */,
        specular_color_texture /* sRGB */, anisotropy_texture /* red, green: direction; blue:
        strength */
        ,
        clearcoat_texture /* red */, clearcoat_roughness_texture /* green */,
        clearcoat_normal_texture, sheen_color_texture /* sRGB */, sheen_roughness_texture /* alpha
                                                                                           */
        ,
        iridescence_texture /* red */, iridescence_thickness_texture /* green */,
        diffuse_transmission_texture /* alpha */, diffuse_transmission_color_texture /* sRGB */;
};

enum texture_wrap { WRAP_REPEAT = 0, WRAP_CLAMP = 1, WRAP_MIRROR = 2 };
enum texture_filter { FILTER_LINEAR = 0, FILTER_NEAREST = 1 };

struct scene_texture {
    uint32_t image;
    uint32_t wrap_u, wrap_v;
    uint32_t filter;
};

enum image_format { IMAGE_RGBA8 = 0 }; /* 4 bytes a pixel, rows from the top */
/* IMAGE_IS_SRGB: colour channels are sRGB-encoded. IMAGE_IN_BASE: the base has its pixels. */
enum { IMAGE_IS_SRGB = 1u, IMAGE_IN_BASE = 2u };

struct scene_image {
    uint32_t width_px, height_px;
    uint32_t format;
    uint32_t flags;
    uint64_t first_byte; /* in SCENE_PIXELS */
    uint32_t name;
    uint32_t reserved;
};

/* Has the fields of plan_light; `instance` is the recognised emitter or SCENE_NONE. */
struct scene_light {
    uint32_t type, profile;
    float position[3], direction[3], half_u[3], half_v[3], color[3];
    float cos_inner, cos_outer;
    float range;
    uint32_t instance; /* of the emitter's geometry; SCENE_NONE for punctual lights */
    uint32_t name;
};

/* Perspective: yfov_rad > 0, and half_width the image's half at distance 1, or 0 where its shape
 * says it. Orthographic: half_width, half_height > 0. aspect 0: the image's. centre: where forward
 * meets the image, in half images right of and above the middle. */
struct scene_camera {
    uint32_t type;
    uint32_t name;
    float eye[3], right[3], up[3], forward[3];
    float yfov_rad;
    float aspect;
    float half_width, half_height;
    uint32_t is_default; /* made by the importer because the file has none */
    uint32_t reserved;
    float centre_x, centre_y;
};

/* A checked view of a blob, into which its pointers lead. */
struct scene {
    const uint8_t *blob;
    size_t blob_bytes;
    uint64_t count[SCENE_SECTION_COUNT];
    const struct scene_info *info;
    const float *positions, *normals, *tangents, *uvs, *colors;
    const uint32_t *triangles;
    const struct scene_mesh *meshes;
    const struct scene_instance *instances;
    const struct scene_material *materials;
    const struct scene_texture *textures;
    const struct scene_image *images;
    const uint8_t *pixels;
    const struct scene_light *lights;
    const struct scene_camera *cameras, *poses;
    const struct scene_mover *movers;
    const struct scene_step *steps;
    const float *sky; /* 3 * SCENE_SKY_TEXELS where the section is there */
    const char *names, *warnings;
    const struct scene *base; /* borrowed; NULL: none */
};

/* Returns the size of a section's records; 0 for an unknown section. */
uint32_t scene_record_bytes(uint32_t section);

/* Checks the whole blob: table, alignment, overlaps, every index and every number. `blob` must be
 * aligned to 64 bytes (mmap is) and outlive *out. *fault names the record and field. */
int scene_open(const void *blob, size_t size_bytes, struct scene *out, struct fault *fault);

/* Opens a blob that may have a base. It outlives *out; NULL: there is none. ERR_MISSING for a blob
 * whose base is not given, ERR_MISMATCH where the two do not fit. */
int scene_open_on(const void *blob, size_t size_bytes, const struct scene *base, struct scene *out,
                  struct fault *fault);

/* Maps a file read-only and opens it; scene_unmap undoes it. */
int scene_map(const char *path, struct scene *out, struct fault *fault);
int scene_map_on(const char *path, const struct scene *base, struct scene *out,
                 struct fault *fault);
void scene_unmap(struct scene *s);

/* Reads which base a file's blob has; zero for none and for what is no blob. ERR_IO. */
int scene_find_base(const char *path, struct digest *out);

/* Reads which of the job's files is the backplate of a file's blob; "" for none and for what is no
 * blob. ERR_IO. */
int scene_find_plate(const char *path, char out[LIMIT_NAME_BYTES]);

/* Returns the scene that has a mesh's arrays, or an image's pixels. */
static inline const struct scene *scene_mesh_home(const struct scene *s,
                                                  const struct scene_mesh *mesh)
{
    return mesh->flags & MESH_IN_BASE ? s->base : s;
}
static inline const struct scene *scene_image_home(const struct scene *s,
                                                   const struct scene_image *image)
{
    return image->flags & IMAGE_IN_BASE ? s->base : s;
}

/* Returns a name by its offset; "" for 0. */
const char *scene_name(const struct scene *s, uint32_t name);
