#pragma once
/* One primitive of a glTF mesh: which accessors it names, and the triangles behind them. */
#include "server/import/gltf/gltf.h"
#include "server/import/scene/mesh.h"

/* All that the triangles depend on. Primitives with equal keys share one geometry; keys are
 * compared as bytes. */
struct gltf_geometry {
    uint32_t position, normal, tangent, uv[2], color, indices; /* accessors; SCENE_NONE: none */
    uint32_t uv_number[2]; /* the file's numbers of the sets in uv */
    uint32_t mode;         /* 4 triangles, 5 strip, 6 fan */
    uint32_t tangent_set;  /* the UV set that tangents are made from; SCENE_NONE: none are */
    /* Where the vertices move (gltf_pose.h): which primitive, by which node. SCENE_NONE: they rest;
     * of the node alone: by the mesh's own weights. */
    uint32_t posed_mesh, posed_primitive, posed_node;
    uint32_t draco_mesh, draco_primitive; /* the primitive, if it is compressed; else SCENE_NONE */
};

struct gltf_primitive {
    struct gltf_geometry geometry;
    uint32_t material;     /* in SCENE_MATERIALS */
    uint32_t own_material; /* of the document; SCENE_NONE: none */
    bool drawn;            /* false for points, lines and primitives without positions */
};

/* Reads the description, and warns of what is ignored. `poser`: a node with a skin or with weights
 * of its own; SCENE_NONE: none. */
int gltf_primitive_read(struct gltf *g, uint32_t mesh, uint32_t primitive, uint32_t poser,
                        struct gltf_primitive *out, struct fault *fault);

/* Reads, checks and compacts the triangles. The caller owns *out; empty on failure. */
int gltf_geometry_load(struct gltf *g, const struct gltf_geometry *geometry, const char *place,
                       struct mesh *out, struct fault *fault);
