/* A replayed path for people. */
#include <math.h>

#include "worker/replay/replay.h"
#include "worker/scene/light_table.h"

static void vector(FILE *out, const char *before, const float v[3])
{
    fprintf(out, "%s(%.9g, %.9g, %.9g)", before, (double)v[0], (double)v[1], (double)v[2]);
}

/* Prints a position in the scene's own coordinates. */
static void position(FILE *out, const struct replay_sheet *s, const char *before, const float v[3])
{
    const double *origin = s->scene->info->origin;
    fprintf(out, "%s(%.9g, %.9g, %.9g)", before, origin[0] + (double)v[0], origin[1] + (double)v[1],
            origin[2] + (double)v[2]);
}

/* Names come out of scene files: terminals do not get their control characters. */
static void name(FILE *out, const char *before, const char *text)
{
    if (!text[0]) return;
    fprintf(out, "%s\"", before);
    for (; *text; text++) fputc((unsigned char)*text < ' ' || *text == 127 ? '?' : *text, out);
    fputc('"', out);
}

static void instance(FILE *out, const struct replay_sheet *s, uint32_t id)
{
    const struct replay_names n = replay_names(s->scene, id);
    if (id == 0) {
        fputs("something", out);
        return;
    }
    fprintf(out, "instance %u", id - 1);
    name(out, " ", n.instance);
    name(out, " of mesh ", n.mesh);
    name(out, ", material ", n.material);
}

static void light(FILE *out, const struct replay_sheet *s, uint32_t k)
{
    if (k < LIMIT_LIGHTS) {
        fprintf(out, "light %u", k);
        name(out, " ", replay_light_name(s->plan, s->scene, k));
        fputs(", a ", out);
    }
    fputs(replay_light(s->plan, k), out);
}

static void head(FILE *out, const struct replay_sheet *s)
{
    const struct plan *p = s->plan;
    const struct path_record *r = s->record;
    const struct plan_camera *c = &p->camera;
    fprintf(out, "pixel %d,%d of %dx%d, %s %u of %u to %u, frame %u, seed %llu, kernels %s\n", s->x,
            s->y, p->width_px, p->height_px, replay_kind(r), s->sample, r->first, r->last,
            p->pattern.frame, (unsigned long long)p->pattern.seed, s->isa);
    fprintf(out, "through image point %.9g, %.9g", (double)r->pixel[0], (double)r->pixel[1]);
    if (c->aperture_radius > 0.0f) position(out, s, ", lens point ", r->vertices[0].origin);
    fputc('\n', out);
    if (p->paths.without_diffuse_direct == DIRECT_LEFT_ALL)
        fputs("light fields bring all that the first surface's diffuse lobe sends on, and what the "
              "camera sees shine: both are left out here\n",
              out);
    if (p->paths.without_diffuse_direct == DIRECT_LEFT_LISTED)
        fputs("light fields bring what the first surface's diffuse lobe sends on of listed lights "
              "directly, and surfaces that the camera sees shine: both are left out here\n",
              out);
    if (p->paths.without_diffuse_direct != DIRECT_LEFT_ALL && p->paths.without_diffuse_indirect)
        fprintf(out,
                "light fields bring indirect light%s of the first surface's diffuse%s lobe: it is "
                "left out here\n",
                plan_sky_in_fields(p) ? " and the soft share of the environment's" : "",
                p->paths.without_glossy_indirect ? " and glossy" : "");
}

static void surface(FILE *out, const struct replay_sheet *s, const struct path_record_vertex *v)
{
    const struct bsdf *b = &v->bsdf;
    position(out, s, "    position ", v->position);
    vector(out, ", normal ", v->normal);
    vector(out, ", geometric ", v->facet);
    fprintf(out, "%s\n    %s, albedo ", v->behind ? ", from behind" : "", replay_model(v));
    vector(out, "", v->albedo);
    if (!v->lambert && b->model != BSDF_BLACK && b->model != BSDF_MIRROR)
        fprintf(out, ", alpha %.9g x %.9g", (double)b->alpha_u, (double)b->alpha_v);
    if (!v->lambert && b->model == BSDF_GLTF)
        fprintf(out, ", metallic %.9g, transmission %.9g, specular %.9g, ior %.9g%s",
                (double)b->metallic, (double)b->transmission, (double)b->specular, (double)b->ior,
                b->thin     ? ", thin"
                : b->inside ? ", inside"
                            : "");
    else if (!v->lambert && b->model > BSDF_GLTF)
        vector(out, ", specular ", b->model_specular);
    if (!v->lambert && b->exponent_u > 0.0f)
        fprintf(out, ", exponents %.9g, %.9g", (double)b->exponent_u, (double)b->exponent_v);
    fputc('\n', out);
}

static void met(FILE *out, const struct replay_sheet *s, const struct path_record_met *m)
{
    fputs("    meets ", out);
    light(out, s, m->light);
    vector(out, ": radiance ", m->radiance);
    fprintf(out, ", weight %.9g", (double)m->weight);
    vector(out, ", adds ", m->value);
    fputc('\n', out);
}

static void light_sample(FILE *out, const struct replay_sheet *s, const struct path_record_light *l)
{
    fputs("    tries ", out);
    light(out, s, l->light);
    fprintf(out, ", chosen with %.9g", (double)l->probability);
    if (!l->skip) {
        vector(out, ": towards ", l->direction);
        fprintf(out, ", distance %.9g, density %.9g, scattering's %.9g, weight %.9g",
                (double)l->distance, (double)l->density, (double)l->scattered, (double)l->weight);
    }
    fputs("\n        ", out);
    if (!l->traced) {
        fprintf(out, "no ray: %s\n", replay_skip(l));
        return;
    }
    vector(out, "sends on ", l->reflected);
    fputs(l->blocked ? "; blocked by " : "; visible", out);
    if (l->blocked) {
        instance(out, s, l->blocker);
        fprintf(out, " at %.9g", (double)l->blocked_at);
    }
    vector(out, ", adds ", l->value);
    fputc('\n', out);
}

static void scatter(FILE *out, const struct path_record_scatter *c)
{
    vector(out, "    scatters to ", c->direction);
    if (c->pdf > 0.0f)
        fprintf(out, ", density %.9g", (double)c->pdf);
    else
        fputs(", found by no light sample", out);
    fprintf(out, "%s%s", c->dirac ? ", Dirac lobe" : "", c->transmitted ? ", through" : "");
    vector(out, "\n        weight ", c->weight);
    vector(out, " = diffuse ", c->diffuse);
    vector(out, " + specular ", c->specular);
    if (c->roulette)
        fprintf(out, "\n        roulette: %.9g %s %.9g", (double)c->chance,
                c->goes_on ? "is below" : "is not below", (double)c->survival);
    fputc('\n', out);
}

static void vertex(FILE *out, const struct replay_sheet *s, uint32_t k)
{
    const struct path_record_vertex *v = &s->record->vertices[k];
    fprintf(out, "%u: from ", k);
    position(out, s, "", v->origin);
    vector(out, " towards ", v->direction);
    vector(out, ", throughput ", v->throughput);
    fputs(v->hit ? "\n    hits " : "\n    hits nothing\n", out);
    if (v->hit) {
        instance(out, s, v->instance);
        fprintf(out, ", triangle %u at (%.9g, %.9g), distance %.9g\n", v->triangle, (double)v->u,
                (double)v->v, (double)v->distance);
        surface(out, s, v);
    }
    for (uint32_t i = 0; i < v->met_count; i++) met(out, s, &v->met[i]);
    if (v->is_kept && !v->left) {
        vector(out, "    what light fields bring is left out: throughput ", v->kept);
        fputc('\n', out);
    }
    if (v->stays > 0.0f && !v->thinned)
        fprintf(out, "    goes on with other lobes by a chance of %.9g: throughput over it\n",
                (double)v->stays);
    for (uint32_t i = 0; i < v->light_count; i++) light_sample(out, s, &v->lights[i]);
    if (v->scatter.tried && v->scatter.on) scatter(out, &v->scatter);
}

void replay_print_text(const struct replay_sheet *s, FILE *out)
{
    const struct path_record *r = s->record;
    head(out, s);
    for (uint32_t k = 0; k < r->count; k++) vertex(out, s, k);
    fprintf(out, "ends: %s\n", replay_end(s));
    vector(out, "radiance ", r->radiance);
    vector(out, " = emission ", r->emission);
    vector(out, " + direct ", r->direct);
    vector(out, " + indirect ", r->indirect);
    if (r->kind == PATH_RECORD_LENS && s->plan->lens_relight != LENS_RELIGHT_OWN)
        vector(out, "; without what light fields bring ", r->stored);
    if (r->rejected) fputs("; rejected: it is not finite, and counts as nothing", out);
    fputc('\n', out);
}
