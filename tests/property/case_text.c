/* Cases as text: a line a thing, its name first. */
#include <string.h>

#include "tests/property/case.h"

static const char *const shape_names[] = {"panel", "box", "room", "needle", "point", NULL};
static const char *const surface_names[] = {"lambert",  "black",   "emitter", "glossy", "metal",
                                            "glass",    "mirror",  "phong",   "blinn",  "ashikhmin",
                                            "beckmann", "furnace", NULL};
static const char *const dress_names[] = {"plain", "color", "mask",  "blend", "normal",
                                          "rough", "glow",  "unlit", NULL};
static const char *const light_names[] = {"rectangle", "gaussian", "point", "spot", "sun", NULL};

static void write_body(const struct case_body *b, FILE *out)
{
    fprintf(out,
            "body %s %s at %.17g %.17g %.17g size %.17g %.17g %.17g facing %d albedo %.17g "
            "%.17g %.17g sharpness %.17g\n",
            shape_names[b->shape], surface_names[b->surface], b->centre[0], b->centre[1],
            b->centre[2], b->size[0], b->size[1], b->size[2], b->facing, b->albedo[0], b->albedo[1],
            b->albedo[2], b->sharpness);
    if (b->dress || b->smooth)
        fprintf(out, "dress %s texels %u smooth %d\n", dress_names[b->dress], b->texels, b->smooth);
}

void case_write(const struct property_case *c, FILE *out)
{
    fprintf(out, "image %d %d tile %d block %d layers %d\n", c->width, c->height, c->tile, c->block,
            c->layers);
    fprintf(out, "samples %d seed %u bounces %d occlusion %.17g\n", c->spp, c->seed, c->bounces,
            c->occlusion);
    fprintf(out, "filter %s %s %s %s\n", case_methods[c->method], case_indirects[c->indirect],
            case_glossies[c->glossy], case_lenses[c->lens_filter]);
    if (c->environment_filter || c->residual || c->halved)
        fprintf(out, "division environment %s residual %s halved %d\n",
                case_environments[c->environment_filter], case_residuals[c->residual], c->halved);
    fprintf(out, "rounds mu %.17g target %.17g most %d lens %d\n", c->mu, c->error, c->most,
            c->lens_second_set);
    fprintf(out, "camera %.17g %.17g %.17g to %.17g %.17g %.17g fov %.17g\n", c->eye[0], c->eye[1],
            c->eye[2], c->target[0], c->target[1], c->target[2], c->yfov_deg);
    if (c->orthographic || c->tent)
        fprintf(out, "view orthographic %d tent %d\n", c->orthographic, c->tent);
    fprintf(out, "lens %.17g focus %.17g blades %d\n", c->aperture, c->focus, c->blades);
    fprintf(out, "environment %.17g %.17g %.17g\n", c->environment[0], c->environment[1],
            c->environment[2]);
    if (c->map) fprintf(out, "map %u\n", c->map);
    for (int i = 0; i < c->body_count; i++) write_body(&c->bodies[i], out);
    for (int i = 0; i < c->light_count; i++) {
        const struct case_light *l = &c->lights[i];
        fprintf(
            out,
            "light %s at %.17g %.17g %.17g half %.17g %.17g facing %d level %.17g %.17g %.17g\n",
            light_names[l->kind], l->centre[0], l->centre[1], l->centre[2], l->half[0], l->half[1],
            l->facing, l->level[0], l->level[1], l->level[2]);
    }
}

/* The number of a name; -1 for none. */
static int number_of(const char *const *names, const char *name)
{
    for (int i = 0; names[i]; i++)
        if (!strcmp(names[i], name)) return i;
    return -1;
}

static bool read_filter(const char *line, struct property_case *c)
{
    char name[4][24];
    if (sscanf(line, "filter %23s %23s %23s %23s", name[0], name[1], name[2], name[3]) != 4)
        return false;
    c->method = number_of(case_methods, name[0]);
    c->indirect = number_of(case_indirects, name[1]);
    c->glossy = number_of(case_glossies, name[2]);
    c->lens_filter = number_of(case_lenses, name[3]);
    return c->method >= 0 && c->indirect >= 0 && c->glossy >= 0 && c->lens_filter >= 0;
}

static bool read_division(const char *line, struct property_case *c)
{
    char environment[24], residual[24];
    if (sscanf(line, "division environment %23s residual %23s halved %d", environment, residual,
               &c->halved) != 3)
        return false;
    c->environment_filter = number_of(case_environments, environment);
    c->residual = number_of(case_residuals, residual);
    return c->environment_filter >= 0 && c->residual >= 0;
}

static bool read_body(const char *line, struct property_case *c)
{
    char shape[24], surface[24];
    struct case_body b = {0};
    if (c->body_count == CASE_BODIES ||
        sscanf(line,
               "body %23s %23s at %lf %lf %lf size %lf %lf %lf facing %d albedo %lf %lf %lf "
               "sharpness %lf",
               shape, surface, &b.centre[0], &b.centre[1], &b.centre[2], &b.size[0], &b.size[1],
               &b.size[2], &b.facing, &b.albedo[0], &b.albedo[1], &b.albedo[2], &b.sharpness) != 13)
        return false;
    const int of = number_of(shape_names, shape), with = number_of(surface_names, surface);
    if (of < 0 || with < 0 || b.facing < 0 || b.facing > 5) return false;
    b.shape = (enum body_shape)of;
    b.surface = (enum body_surface)with;
    c->bodies[c->body_count++] = b;
    return true;
}

/* Of the body before it. */
static bool read_dress(const char *line, struct property_case *c)
{
    char dress[24];
    if (c->body_count == 0) return false;
    struct case_body *b = &c->bodies[c->body_count - 1];
    if (sscanf(line, "dress %23s texels %u smooth %d", dress, &b->texels, &b->smooth) != 3)
        return false;
    const int of = number_of(dress_names, dress);
    if (of >= 0) b->dress = (enum body_dress)of;
    return of >= 0;
}

static bool read_light(const char *line, struct property_case *c)
{
    char kind[24];
    struct case_light l;
    if (c->light_count == CASE_LIGHTS ||
        sscanf(line, "light %23s at %lf %lf %lf half %lf %lf facing %d level %lf %lf %lf", kind,
               &l.centre[0], &l.centre[1], &l.centre[2], &l.half[0], &l.half[1], &l.facing,
               &l.level[0], &l.level[1], &l.level[2]) != 10)
        return false;
    const int of = number_of(light_names, kind);
    if (of < 0 || l.facing < 0 || l.facing > 5) return false;
    l.kind = (enum case_light_kind)of;
    c->lights[c->light_count++] = l;
    return true;
}

static bool read_line(const char *line, struct property_case *c)
{
    if (line[0] == '#' || line[0] == '\n') return true;
    return sscanf(line, "image %d %d tile %d block %d layers %d", &c->width, &c->height, &c->tile,
                  &c->block, &c->layers) == 5 ||
           sscanf(line, "samples %d seed %u bounces %d occlusion %lf", &c->spp, &c->seed,
                  &c->bounces, &c->occlusion) == 4 ||
           read_filter(line, c) || read_division(line, c) ||
           sscanf(line, "rounds mu %lf target %lf most %d lens %d", &c->mu, &c->error, &c->most,
                  &c->lens_second_set) == 4 ||
           sscanf(line, "camera %lf %lf %lf to %lf %lf %lf fov %lf", &c->eye[0], &c->eye[1],
                  &c->eye[2], &c->target[0], &c->target[1], &c->target[2], &c->yfov_deg) == 7 ||
           sscanf(line, "view orthographic %d tent %d", &c->orthographic, &c->tent) == 2 ||
           sscanf(line, "lens %lf focus %lf blades %d", &c->aperture, &c->focus, &c->blades) == 3 ||
           sscanf(line, "environment %lf %lf %lf", &c->environment[0], &c->environment[1],
                  &c->environment[2]) == 3 ||
           sscanf(line, "map %u", &c->map) == 1 || read_body(line, c) || read_dress(line, c) ||
           read_light(line, c);
}

int case_read(FILE *in, struct property_case *out, int *line)
{
    char text[512];
    memset(out, 0, sizeof *out);
    for (*line = 1; fgets(text, sizeof text, in); ++*line)
        if (!read_line(text, out)) return -1;
    return out->width > 0 && out->body_count > 0 ? 0 : -1;
}
