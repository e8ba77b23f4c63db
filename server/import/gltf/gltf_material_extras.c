/* extras.shearwater: reflection models that glTF has no words for. */
#include <string.h>

#include "server/import/gltf/gltf_material.h"
#include "server/import/measured/lobe_fit.h"
#include "server/import/scene/surface.h"

#define EXPONENT_MAX 1e5  /* a lobe of a quarter of a degree */
#define ETA_MIN      1e-3 /* of silver and gold: 0.04 and more */
#define INDEX_MAX    1e3

/* Members of the object, as bits. */
enum {
    HAS_MODEL = 1u << 0,
    HAS_EXPONENT = 1u << 1,
    HAS_EXPONENT_U = 1u << 2,
    HAS_EXPONENT_V = 1u << 3,
    HAS_ALPHA = 1u << 4,
    HAS_SPECULAR = 1u << 5,
    HAS_ETA = 1u << 6,
    HAS_K = 1u << 7,
    HAS_ALPHA_U = 1u << 8,
    HAS_ALPHA_V = 1u << 9,
    HAS_URI = 1u << 10
};

static const char *const members[] = {"model",   "exponent", "exponent_u", "exponent_v",
                                      "alpha",   "specular", "eta",        "k",
                                      "alpha_u", "alpha_v",  "uri"};

#define MEMBER_COUNT (sizeof members / sizeof members[0])
#define AS_GLTF      MODEL_COUNT /* "lambert": glTF's own model without its coat */

/* A number along the tangent and one across it, or one for both. */
#define ALPHAS    (HAS_ALPHA | HAS_ALPHA_U | HAS_ALPHA_V)
#define EXPONENTS (HAS_EXPONENT | HAS_EXPONENT_U | HAS_EXPONENT_V)

/* What `needs` must all be there, and of the rest only what it `may` have. Of `widths` there is the
 * one or the pair. */
static const struct model {
    const char *name;
    uint32_t model;
    uint32_t needs, may, widths;
} models[] = {
    {"lambert", AS_GLTF, 0, 0, 0},
    {"phong", MODEL_PHONG, HAS_EXPONENT | HAS_SPECULAR, 0, 0},
    {"blinn_phong", MODEL_BLINN_PHONG, HAS_EXPONENT | HAS_SPECULAR, 0, 0},
    {"beckmann", MODEL_BECKMANN, 0, HAS_SPECULAR | HAS_ETA | HAS_K, ALPHAS},
    {"ashikhmin_shirley", MODEL_ASHIKHMIN_SHIRLEY, HAS_SPECULAR, 0, EXPONENTS},
    {"ward", MODEL_WARD, HAS_SPECULAR, 0, ALPHAS},
    {"kelemen", MODEL_KELEMEN, HAS_ALPHA | HAS_SPECULAR, 0, 0},
    {"measured", MODEL_MEASURED, HAS_URI, 0, 0},
    {"mirror", MODEL_MIRROR, 0, HAS_SPECULAR, 0},
};

static int find_model(const json_t *json, const char *place, const struct model **out,
                      struct fault *fault)
{
    const char *name;
    gltf_place at;
    int rc = gltf_text(json, place, "model", &name, fault);
    if (rc != 0) return rc;
    gltf_place_set(at, "%s.model", place);
    if (name == NULL) return fault_set(fault, ERR_MISSING, at, "it names the reflection model");
    for (size_t i = 0; i < sizeof models / sizeof models[0]; i++) {
        *out = &models[i];
        if (strcmp(models[i].name, name) == 0) return 0;
    }
    return fault_set(fault, ERR_RANGE, at,
                     "\"%.40s\" is not lambert, phong, blinn_phong, beckmann, ashikhmin_shirley, "
                     "ward, kelemen, measured or mirror",
                     name);
}

/* Lists the members that are there. Unknown ones and those that the model has no use for are
 * refused. */
static int list_members(const json_t *json, const char *place, const struct model *model,
                        uint32_t *out, struct fault *fault)
{
    gltf_place at;
    const char *key;
    json_t *value;
    *out = 0;
    json_object_foreach ((json_t *)json, key, value) {
        uint32_t i = 0;
        while (i < MEMBER_COUNT && strcmp(members[i], key) != 0) i++;
        gltf_place_set(at, "%s.%.60s", place, key);
        text_make_printable(at);
        if (i == MEMBER_COUNT) return fault_set(fault, ERR_UNKNOWN_MEMBER, at, "it is unknown");
        if (!((HAS_MODEL | model->needs | model->may | model->widths) & 1u << i))
            return fault_set(fault, ERR_UNKNOWN_MEMBER, at, "the model %s has none", model->name);
        *out |= 1u << i;
    }
    for (uint32_t i = 0; i < MEMBER_COUNT; i++) {
        if (!(model->needs & ~*out & 1u << i)) continue;
        gltf_place_set(at, "%s.%s", place, members[i]);
        return fault_set(fault, ERR_MISSING, at, "the model %s needs it", model->name);
    }
    return 0;
}

/* A lobe has one width, or one along the tangent and one across it. */
static int check_widths(const char *place, uint32_t has, uint32_t one, uint32_t both,
                        struct fault *fault)
{
    const char *name = one == HAS_ALPHA ? "alpha" : "exponent";
    const bool is_one = has & one, is_pair = (has & both) == both;
    if (is_one ? !(has & both) : is_pair) return 0;
    return fault_set(fault, is_one && is_pair ? ERR_MISMATCH : ERR_MISSING, place,
                     "it has either %s or both %s_u and %s_v", name, name, name);
}

/* Members of which one excludes the other. */
static int check_choice(const struct model *model, const char *place, uint32_t has,
                        struct fault *fault)
{
    const uint32_t index = HAS_ETA | HAS_K;
    int rc = 0;
    if (model->widths == ALPHAS)
        rc = check_widths(place, has, HAS_ALPHA, HAS_ALPHA_U | HAS_ALPHA_V, fault);
    if (model->widths == EXPONENTS)
        rc = check_widths(place, has, HAS_EXPONENT, HAS_EXPONENT_U | HAS_EXPONENT_V, fault);
    if (rc != 0 || model->model != MODEL_BECKMANN) return rc;
    if ((has & index) == index || (has & (index | HAS_SPECULAR)) == HAS_SPECULAR) return 0;
    return fault_set(fault, ERR_MISSING, place, "it has specular, or both eta and k");
}

static int read_numbers(const json_t *json, const char *place, struct scene_material *m,
                        struct fault *fault)
{
    const double most = EXPONENT_MAX;
    int rc = gltf_float(json, place, "exponent", 0, most, &m->exponent_u, fault);
    m->exponent_v = m->exponent_u;
    if (rc == 0) rc = gltf_float(json, place, "exponent_u", 0, most, &m->exponent_u, fault);
    if (rc == 0) rc = gltf_float(json, place, "exponent_v", 0, most, &m->exponent_v, fault);
    if (rc == 0) rc = gltf_float(json, place, "alpha", 0, 1, &m->alpha_u, fault);
    m->alpha_v = m->alpha_u;
    if (rc == 0) rc = gltf_float(json, place, "alpha_u", 0, 1, &m->alpha_u, fault);
    if (rc == 0) rc = gltf_float(json, place, "alpha_v", 0, 1, &m->alpha_v, fault);
    if (rc == 0) rc = gltf_floats(json, place, "specular", 3, 0, 1, m->model_specular, fault);
    if (rc == 0) rc = gltf_floats(json, place, "eta", 3, ETA_MIN, INDEX_MAX, m->eta, fault);
    if (rc == 0) rc = gltf_floats(json, place, "k", 3, 0, INDEX_MAX, m->k, fault);
    return rc;
}

/* Metals and mirrors have no diffuse lobe; of the others both lobes must fit. */
static void settle(const struct model *model, const char *place, struct scene_material *m,
                   struct warnings *warnings)
{
    m->metallic = 0;
    m->transmission = 0;
    m->anisotropy = 0;
    if (model->model == AS_GLTF) {
        m->specular = 0;
        return;
    }
    m->model = model->model;
    if (model->model == MODEL_MIRROR || m->eta[0] > 0)
        for (int i = 0; i < 3; i++) m->base_color[i] = 0;
    else if (model->model != MODEL_KELEMEN &&
             model->model != MODEL_MEASURED) /* its diffuse lobe leaves room by itself */
        surface_conserve(m, place, warnings);
}

static void take_fit(const struct lobe_fit *fit, const char *place, struct scene_material *m,
                     struct warnings *warnings)
{
    for (int c = 0; c < 3; c++) {
        m->base_color[c] = fit->diffuse[c];
        m->model_specular[c] = fit->specular[0][c];
        m->second_specular[c] = fit->specular[1][c];
    }
    m->alpha_u = m->alpha_v = fit->alpha[0];
    m->second_alpha = fit->alpha[1];
    memcpy(m->grazing, fit->grazing, sizeof m->grazing);
    m->base_color_texture.texture = SCENE_NONE;
    warnings_add(
        warnings, place,
        "the measurement is fitted by a diffuse lobe and two of alpha %.3g and %.3g, which "
        "put %.3g %% of its light elsewhere",
        (double)m->alpha_u, (double)m->second_alpha, 100 * fit->off);
}

/* Reads the file of a measured surface and fits lobes to it. */
static int read_measured(struct gltf *g, const json_t *json, const char *place,
                         struct scene_material *m, struct fault *fault)
{
    struct gltf_payload payload;
    struct lobe_fit fit;
    struct merl merl;
    gltf_place at;
    const char *uri;
    gltf_place_set(at, "%s.uri", place);
    int rc = gltf_text(json, place, "uri", &uri, fault);
    if (rc == 0) rc = gltf_payload_load(g, uri, at, &payload, fault);
    if (rc != 0) return rc;
    rc = merl_open(&payload.view, at, &merl, fault);
    if (rc == 0 && (rc = lobe_fit_make(&merl, &fit)) != 0)
        fault_set(fault, rc, at, "no memory to fit the measurement");
    gltf_payload_free(&payload);
    if (rc == 0) take_fit(&fit, at, m, &g->builder->warnings);
    return rc;
}

int gltf_material_extras_read(struct gltf *g, const json_t *json, const char *place,
                              struct scene_material *m, struct fault *fault)
{
    const struct model *model = models;
    const json_t *ours;
    gltf_place at;
    uint32_t has;
    const json_t *extras = json_object_get(json, "extras");
    if (!json_is_object(extras)) return 0;
    gltf_place_set(at, "%s.extras", place);
    int rc = gltf_object(extras, at, "shearwater", &ours, fault);
    if (rc != 0 || ours == NULL) return rc;
    gltf_place_set(at, "%s.extras.shearwater", place);
    rc = find_model(ours, at, &model, fault);
    if (rc == 0) rc = list_members(ours, at, model, &has, fault);
    if (rc == 0) rc = check_choice(model, at, has, fault);
    if (rc != 0) return rc;
    for (int i = 0; i < 3; i++) m->model_specular[i] = 1;
    rc = read_numbers(ours, at, m, fault);
    if (rc == 0 && model->model == MODEL_MEASURED) rc = read_measured(g, ours, at, m, fault);
    if (rc == 0) settle(model, at, m, &g->builder->warnings);
    return rc;
}
