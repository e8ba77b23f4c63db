#include "server/image/exr_attributes.h"

#include <math.h>
#include <stdio.h>

#include "server/image/exr_mattes.h"

/* The planes of NDC, in scene units before the camera. */
#define NEAR_PLANE 0.01
#define FAR_PLANE  1e6

static exr_result_t add_own(exr_context_t context, const struct exr_metadata *m)
{
    char seed[24];
    snprintf(seed, sizeof seed, "%llu", (unsigned long long)m->seed);
    exr_result_t r = exr_attr_set_string(context, 0, "shearwater:seed", seed);
    if (!r && m->job) r = exr_attr_set_string(context, 0, "shearwater:job", m->job);
    if (!r && m->build) r = exr_attr_set_string(context, 0, "shearwater:build", m->build);
    if (!r && m->denoiser) r = exr_attr_set_string(context, 0, "shearwater:denoiser", m->denoiser);
    if (!r) r = exr_attr_set_int(context, 0, "shearwater:spp", (int32_t)m->spp);
    if (!r) r = exr_attr_set_int(context, 0, "shearwater:frame", m->frame);
    return r;
}

/* Whole rates, those of television (24000/1001), and any other to a thousandth. */
static exr_attr_rational_t rational_of(double fps)
{
    const double whole = round(fps), television = round(fps * 1.001);
    if (fabs(fps - whole) < 1e-9) return (exr_attr_rational_t){(int32_t)whole, 1};
    if (fabs(fps - television / 1.001) < 1e-3)
        return (exr_attr_rational_t){(int32_t)(television * 1000), 1001};
    return (exr_attr_rational_t){(int32_t)round(fps * 1000), 1000};
}

static double dot(const float a[3], const float b[3])
{
    return (double)a[0] * (double)b[0] + (double)a[1] * (double)b[1] + (double)a[2] * (double)b[2];
}

static void world_to_camera(const struct plan_camera *c, double out[4][4])
{
    const float *const axes[3] = {c->right, c->up, c->forward};
    for (int j = 0; j < 3; j++) {
        const double sign = j == 2 ? -1 : 1;
        for (int i = 0; i < 3; i++) out[i][j] = sign * (double)axes[j][i];
        out[3][j] = -sign * dot(c->eye, axes[j]);
    }
    for (int i = 0; i < 4; i++) out[i][3] = i == 3;
}

static void camera_to_ndc(const struct plan_camera *c, double out[4][4])
{
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++) out[i][j] = 0;
    out[0][0] = 1 / (double)c->half_width;
    out[1][1] = 1 / (double)c->half_height;
    const int from = c->type == CAMERA_PERSPECTIVE ? 2 : 3; /* ahead is -z */
    out[from][0] = (from == 2 ? -1 : 1) * (double)c->centre_x;
    out[from][1] = (from == 2 ? -1 : 1) * (double)c->centre_y;
    if (c->type == CAMERA_PERSPECTIVE) {
        out[2][2] = out[2][3] = -1;
        out[3][2] = -2 * NEAR_PLANE;
    } else {
        out[2][2] = -2 / (FAR_PLANE - NEAR_PLANE);
        out[3][2] = -(FAR_PLANE + NEAR_PLANE) / (FAR_PLANE - NEAR_PLANE);
        out[3][3] = 1;
    }
}

static exr_attr_m44f_t product(double a[4][4], double b[4][4])
{
    exr_attr_m44f_t out;
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++) {
            double sum = 0;
            for (int k = 0; k < 4; k++) sum += a[i][k] * b[k][j];
            out.m[4 * i + j] = (float)sum;
        }
    return out;
}

static exr_result_t add_camera(exr_context_t context, const struct plan_camera *c)
{
    double camera[4][4], projection[4][4];
    double identity[4][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}};
    world_to_camera(c, camera);
    camera_to_ndc(c, projection);
    const exr_attr_m44f_t to_camera = product(camera, identity),
                          to_ndc = product(camera, projection);
    exr_result_t r = exr_attr_set_m44f(context, 0, "worldToCamera", &to_camera);
    if (!r) r = exr_attr_set_m44f(context, 0, "worldToNDC", &to_ndc);
    if (!r && c->type == CAMERA_PERSPECTIVE)
        r = exr_set_screen_window_width(context, 0, 2 * c->half_width);
    return r;
}

/* A layer's key is the first seven digits of its name's hash. */
static exr_result_t add_layer(exr_context_t context, const char *name, const char *manifest)
{
    const struct {
        const char *key, *value;
    } all[] = {{"name", name},
               {"hash", "MurmurHash3_32"},
               {"conversion", "uint32_to_float32"},
               {"manifest", manifest}};
    exr_result_t r = EXR_ERR_SUCCESS;
    for (size_t i = 0; i < sizeof all / sizeof *all && !r; i++) {
        char key[40];
        snprintf(key, sizeof key, "cryptomatte/%07x/%s", matte_hash(name) >> 4, all[i].key);
        r = exr_attr_set_string(context, 0, key, all[i].value);
    }
    return r;
}

static exr_result_t add_mattes(exr_context_t context, const struct exr_mattes *mattes)
{
    static const char *const names[MATTE_KINDS] = {
        [MATTE_OBJECT] = MATTE_OBJECT_LAYER, [MATTE_MATERIAL] = MATTE_MATERIAL_LAYER};
    exr_result_t r = EXR_ERR_SUCCESS;
    for (int k = 0; k < MATTE_KINDS && !r; k++)
        if (exr_mattes_manifest(mattes, (enum matte_kind)k))
            r = add_layer(context, names[k], exr_mattes_manifest(mattes, (enum matte_kind)k));
    return r;
}

exr_result_t exr_attributes_add(exr_context_t context, const struct exr_metadata *m)
{
    static const exr_attr_chromaticities_t rec709 = {0.64f, 0.33f, 0.3f,    0.6f,
                                                     0.15f, 0.06f, 0.3127f, 0.329f};
    char software[96];
    snprintf(software, sizeof software, "Shearwater%s%.64s", m->build ? " " : "",
             m->build ? m->build : "");
    exr_result_t r = add_own(context, m);
    if (!r) r = exr_attr_set_chromaticities(context, 0, "chromaticities", &rec709);
    if (!r) r = exr_attr_set_string(context, 0, "software", software);
    if (!r && m->fps > 0) {
        const exr_attr_rational_t fps = rational_of(m->fps);
        r = exr_attr_set_rational(context, 0, "framesPerSecond", &fps);
    }
    if (!r && m->mattes) r = add_mattes(context, m->mattes);
    return !r && m->has_camera ? add_camera(context, &m->camera) : r;
}
