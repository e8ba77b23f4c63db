/* A replayed path for programs. */
#include <jansson.h>
#include <math.h>

#include "worker/replay/replay.h"
#include "worker/scene/light_table.h"

#define FLOAT_DIGITS 9 /* that tell all floats apart */

/* Writes a number, null where JSON has none. */
static json_t *number(float v)
{
    return v > -INFINITY && v < INFINITY ? json_real((double)v) : json_null();
}

static json_t *vector(const float v[3])
{
    return json_pack("[o, o, o]", number(v[0]), number(v[1]), number(v[2]));
}

/* Writes a position in the scene's own coordinates. */
static json_t *position(const struct replay_sheet *s, const float v[3])
{
    const double *origin = s->scene->info->origin;
    json_t *all = json_array();
    for (int i = 0; all && i < 3; i++) {
        const double at = origin[i] + (double)v[i];
        json_array_append_new(all, isfinite(at) ? json_real(at) : json_null());
    }
    return all;
}

static json_t *text_or_null(const char *text)
{
    return text[0] ? json_string(text) : json_null();
}

static json_t *instance(const struct replay_sheet *s, uint32_t id)
{
    const struct replay_names n = replay_names(s->scene, id);
    if (id == 0) return json_null();
    return json_pack("{s:I, s:o, s:o, s:o}", "index", (json_int_t)id - 1, "name",
                     text_or_null(n.instance), "mesh", text_or_null(n.mesh), "material",
                     text_or_null(n.material));
}

static json_t *light(const struct replay_sheet *s, uint32_t k)
{
    const char *name = k < LIMIT_LIGHTS ? replay_light_name(s->plan, s->scene, k) : "";
    return json_pack("{s:s, s:o, s:o}", "type", replay_light(s->plan, k), "index",
                     k < LIMIT_LIGHTS ? json_integer(k) : json_null(), "name", text_or_null(name));
}

static json_t *mets(const struct replay_sheet *s, const struct path_record_vertex *v)
{
    json_t *all = json_array();
    for (uint32_t k = 0; k < v->met_count; k++) {
        const struct path_record_met *m = &v->met[k];
        json_array_append_new(all, json_pack("{s:o, s:o, s:o, s:o}", "light", light(s, m->light),
                                             "radiance", vector(m->radiance), "weight",
                                             number(m->weight), "adds", vector(m->value)));
    }
    return all;
}

static json_t *light_sample(const struct replay_sheet *s, const struct path_record_light *l)
{
    json_t *out = json_pack("{s:o, s:o, s:b, s:o, s:o}", "light", light(s, l->light), "chosen_with",
                            number(l->probability), "traced", (int)l->traced, "not_traced_for",
                            text_or_null(replay_skip(l)), "adds", vector(l->value));
    if (!l->skip)
        json_object_update_new(out, json_pack("{s:o, s:o, s:o, s:o, s:o, s:o, s:o}", "origin",
                                              position(s, l->origin), "direction",
                                              vector(l->direction), "distance", number(l->distance),
                                              "density", number(l->density), "scattering_density",
                                              number(l->scattered), "weight", number(l->weight),
                                              "sends_on", vector(l->reflected)));
    if (l->traced) json_object_set_new(out, "visible", json_boolean(!l->blocked));
    if (l->blocked) {
        json_object_set_new(out, "blocked_by", instance(s, l->blocker));
        json_object_set_new(out, "blocked_at", number(l->blocked_at));
    }
    return out;
}

static json_t *light_samples(const struct replay_sheet *s, const struct path_record_vertex *v)
{
    json_t *all = json_array();
    for (uint32_t k = 0; k < v->light_count; k++)
        json_array_append_new(all, light_sample(s, &v->lights[k]));
    return all;
}

static json_t *scatter(const struct path_record_scatter *c)
{
    if (!c->tried || !c->on) return json_null();
    return json_pack("{s:o, s:o, s:b, s:b, s:o, s:o, s:o, s:o, s:b}", "direction",
                     vector(c->direction), "density", number(c->pdf), "dirac", (int)c->dirac,
                     "transmitted", (int)c->transmitted, "weight", vector(c->weight), "diffuse",
                     vector(c->diffuse), "specular", vector(c->specular), "roulette",
                     c->roulette ? json_pack("{s:o, s:o}", "chance", number(c->chance), "survival",
                                             number(c->survival))
                                 : json_null(),
                     "goes_on", (int)c->goes_on);
}

static json_t *bsdf(const struct path_record_vertex *v)
{
    const struct bsdf *b = &v->bsdf;
    json_t *out = json_pack("{s:s, s:o}", "model", replay_model(v), "albedo", vector(v->albedo));
    if (v->lambert) return out;
    json_object_update_new(
        out, json_pack("{s:[o, o]}", "alpha", number(b->alpha_u), number(b->alpha_v)));
    if (b->model == BSDF_GLTF)
        json_object_update_new(
            out, json_pack("{s:o, s:o, s:o, s:o, s:o, s:b, s:b}", "base_color",
                           vector(b->base_color), "metallic", number(b->metallic), "transmission",
                           number(b->transmission), "specular", number(b->specular), "ior",
                           number(b->ior), "thin", (int)b->thin, "inside", (int)b->inside));
    else
        json_object_update_new(out, json_pack("{s:o, s:[o, o], s:o, s:o}", "specular",
                                              vector(b->model_specular), "exponents",
                                              number(b->exponent_u), number(b->exponent_v), "eta",
                                              vector(b->eta), "k", vector(b->k)));
    return out;
}

static json_t *surface(const struct replay_sheet *s, const struct path_record_vertex *v)
{
    if (!v->hit) return json_null();
    return json_pack("{s:o, s:I, s:[o, o], s:o, s:o, s:o, s:o, s:b, s:o}", "instance",
                     instance(s, v->instance), "triangle", (json_int_t)v->triangle, "barycentric",
                     number(v->u), number(v->v), "distance", number(v->distance), "position",
                     position(s, v->position), "normal", vector(v->normal), "geometric_normal",
                     vector(v->facet), "from_behind", (int)v->behind, "bsdf", bsdf(v));
}

static json_t *vertices(const struct replay_sheet *s)
{
    json_t *all = json_array();
    for (uint32_t k = 0; k < s->record->count; k++) {
        const struct path_record_vertex *v = &s->record->vertices[k];
        json_array_append_new(
            all, json_pack("{s:{s:o, s:o, s:o}, s:o, s:o, s:o, s:o, s:o, s:o}", "ray", "origin",
                           position(s, v->origin), "direction", vector(v->direction), "density",
                           number(v->pdf), "throughput", vector(v->throughput), "hits",
                           surface(s, v), "meets", mets(s, v), "left_to_light_fields",
                           v->left      ? json_string("all")
                           : v->is_kept ? vector(v->kept)
                                        : json_null(),
                           "light_samples", light_samples(s, v), "scatters", scatter(&v->scatter)));
    }
    return all;
}

int replay_print_json(const struct replay_sheet *s, FILE *out)
{
    const struct path_record *r = s->record;
    const struct plan *p = s->plan;
    const bool lens = p->camera.aperture_radius > 0.0f;
    json_t *all = json_pack(
        "{s:[i, i], s:s, s:I, s:[I, I], s:I, s:I, s:s, s:[o, o], s:o}", "pixel", s->x, s->y, "kind",
        replay_kind(r), "sample", (json_int_t)s->sample, "samples", (json_int_t)r->first,
        (json_int_t)r->last, "frame", (json_int_t)p->pattern.frame, "seed",
        (json_int_t)p->pattern.seed, "kernels", s->isa, "image_point", number(r->pixel[0]),
        number(r->pixel[1]), "lens_point", lens ? position(s, r->vertices[0].origin) : json_null());
    json_t *rest =
        json_pack("{s:o, s:s, s:o, s:o, s:o, s:o, s:o, s:b}", "path", vertices(s), "ends",
                  replay_end(s), "emission", vector(r->emission), "direct", vector(r->direct),
                  "indirect", vector(r->indirect), "radiance", vector(r->radiance), "stored",
                  vector(r->stored), "rejected", (int)r->rejected);
    if (all && rest) json_object_update(all, rest);
    if (!rest) json_decref(all), all = NULL;
    json_decref(rest);
    if (!all) return ERR_MEMORY;
    const int failed = json_dumpf(all, out, JSON_INDENT(2) | JSON_REAL_PRECISION(FLOAT_DIGITS));
    json_decref(all);
    return failed || fputc('\n', out) == EOF ? ERR_IO : 0;
}
