/* Cameras, where a node of the scene bears them. */
#include <string.h>

#include "proto/plan.h"
#include "server/import/gltf/gltf.h"
#include "server/import/scene/cameras.h"

static int read_perspective(const json_t *json, const char *place, struct scene_camera *out,
                            struct fault *fault)
{
    double yfov = 0, aspect = 0;
    int rc = gltf_number(json, place, "yfov", 1e-6, 3.1415, &yfov, fault);
    if (rc == 0) rc = gltf_number(json, place, "aspectRatio", 1e-6, 1e6, &aspect, fault);
    if (rc == 0 && yfov == 0) rc = fault_set(fault, ERR_MISSING, place, "the camera has no yfov");
    out->type = CAMERA_PERSPECTIVE;
    out->yfov_rad = (float)yfov;
    out->aspect = (float)aspect;
    return rc;
}

static int read_orthographic(const json_t *json, const char *place, struct scene_camera *out,
                             struct fault *fault)
{
    const double far = (double)LIMIT_COORDINATE;
    double xmag = 0, ymag = 0;
    int rc = gltf_number(json, place, "xmag", -far, far, &xmag, fault);
    if (rc == 0) rc = gltf_number(json, place, "ymag", -far, far, &ymag, fault);
    /* Negative values would mirror the picture; they are written by mistake. */
    out->half_width = (float)(xmag < 0 ? -xmag : xmag);
    out->half_height = (float)(ymag < 0 ? -ymag : ymag);
    if (rc == 0 && !(out->half_width >= 1e-8f && out->half_height >= 1e-8f))
        rc = fault_set(fault, ERR_RANGE, place, "xmag %g and ymag %g span no picture", xmag, ymag);
    out->type = CAMERA_ORTHOGRAPHIC;
    return rc;
}

static int read_projection(const json_t *json, const char *place, struct scene_camera *out,
                           struct fault *fault)
{
    const char *type;
    const json_t *projection;
    gltf_place at;
    int rc = gltf_text(json, place, "type", &type, fault);
    if (rc != 0) return rc;
    gltf_place_set(at, "%s.type", place);
    if (type == NULL) return fault_set(fault, ERR_MISSING, at, "a camera has a type");
    bool perspective = strcmp(type, "perspective") == 0;
    if (!perspective && strcmp(type, "orthographic") != 0)
        return fault_set(fault, ERR_RANGE, at, "\"%.40s\" is not perspective or orthographic",
                         type);
    rc = gltf_object(json, place, type, &projection, fault);
    gltf_place_set(at, "%s.%s", place, type);
    if (rc == 0 && projection == NULL)
        rc = fault_set(fault, ERR_MISSING, at, "the camera has no such object");
    if (rc != 0) return rc;
    return perspective ? read_perspective(projection, at, out, fault)
                       : read_orthographic(projection, at, out, fault);
}

/* The camera's own name, or its node's. */
static int read_name(struct gltf *g, const json_t *camera, const char *place, uint32_t node,
                     uint32_t *out, struct fault *fault)
{
    const char *name;
    const json_t *json;
    gltf_place node_place;
    int rc = gltf_text(camera, place, "name", &name, fault);
    if (rc == 0 && name == NULL) {
        rc = gltf_item(g->root, "nodes", node, &json, node_place, fault);
        if (rc == 0) rc = gltf_text(json, node_place, "name", &name, fault);
    }
    return rc == 0 ? builder_name(g->builder, name, out, fault) : rc;
}

static int append_camera(struct gltf *g, const struct gltf_node *node, struct fault *fault)
{
    const json_t *json;
    gltf_place place;
    struct scene_camera camera = {0};
    void *at;
    int rc = gltf_item(g->root, "cameras", node->camera, &json, place, fault);
    if (rc == 0) rc = read_projection(json, place, &camera, fault);
    if (rc == 0) rc = read_name(g, json, place, node->index, &camera.name, fault);
    if (rc != 0) return rc;
    if (!camera_set_frame(&camera, &node->to_world)) {
        warnings_add(&g->builder->warnings, place,
                     "its node has no direction to look in; the camera is left out");
        return 0;
    }
    rc = builder_append(g->builder, SCENE_CAMERAS, 1, &at, fault);
    if (rc == 0) memcpy(at, &camera, sizeof camera);
    return rc;
}

int gltf_cameras_read(struct gltf *g, struct fault *fault)
{
    int rc = 0;
    for (uint32_t i = 0; rc == 0 && i < g->nodes.count; i++)
        if (g->nodes.list[i].camera != SCENE_NONE) rc = append_camera(g, &g->nodes.list[i], fault);
    return rc;
}
