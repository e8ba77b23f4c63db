/* What holds of the mean picture: other samples are drawn under the change, so that pictures differ
 * by noise. Means over the picture of some seeds are compared, and of many where these differ. */
#include <math.h>

#include "tests/property/property.h"

enum { FEW = 3, MANY = 32, SOME = 16, LEAST_PX = 8, LEAST_SPP = 4 };
enum { AVERAGE = 3, PATHS = 4 }; /* of case_methods */
/* Both must be exceeded: standard errors of the difference, and what it is of the light. Filters
 * are biased by what they find, which is other under other noise. */
#define ERRORS_MAX 6.0
#define SHARE_MAX  0.05
/* A picture's mean, of lights whose radiances are about 1: whether paths ever choose a light that
 * brings less is chance. */
#define NOTHING 1e-6

struct mean {
    double value, variance; /* of the mean */
};

static double light_of(const struct image *image)
{
    double sum = 0;
    static const char *const names[] = {"R", "G", "B"};
    for (int k = 0; k < 3; k++) {
        const struct plane *p = image_plane(image, names[k]);
        for (int32_t y = 0; y < image->height_px; y++)
            for (int32_t x = 0; x < image->width_px; x++) sum += (double)*plane_at(p, x, y);
    }
    return sum / (3.0 * image->width_px * image->height_px);
}

static bool mean_of(const struct property_case *c, struct change change, unsigned first, int count,
                    struct mean *out, char says[PROPERTY_SAYS_BYTES])
{
    double sum = 0, squares = 0;
    for (int i = 0; i < count; i++) {
        change.seed = first + (unsigned)i;
        struct image *image = property_picture(c, &change, says);
        if (!image) return false;
        const double v = light_of(image);
        sum += v;
        squares += v * v;
        image_destroy(&image);
    }
    out->value = sum / count;
    out->variance = fmax(squares / count - out->value * out->value, 0) / (count - 1);
    return true;
}

/* The sum of `count` means beside one. */
static bool apart(const struct mean *whole, const struct mean *parts, int count,
                  char says[PROPERTY_SAYS_BYTES])
{
    double sum = 0, variance = whole->variance;
    for (int i = 0; i < count; i++) sum += parts[i].value, variance += parts[i].variance;
    const double off = fabs(sum - whole->value), error = sqrt(variance) + 1e-6 * fabs(whole->value);
    snprintf(says, PROPERTY_SAYS_BYTES, "light of %.6g and %.6g: %.3g apart, %.3g standard errors",
             whole->value, sum, off, off / error);
    return off > NOTHING && off > ERRORS_MAX * error &&
           off > SHARE_MAX * fmax(fabs(whole->value), fabs(sum));
}

/* Of `seeds` pictures each. */
static enum property_result means_agree_of(int seeds, const struct property_case *c,
                                           const struct change *changes, int count,
                                           char says[PROPERTY_SAYS_BYTES])
{
    const struct change none = {0};
    struct mean whole, parts[CASE_LIGHTS + 2];
    if (!mean_of(c, none, 1000, seeds, &whole, says)) return PROPERTY_DOES_NOT_APPLY;
    for (int i = 0; i < count; i++)
        if (!mean_of(c, changes[i], 2000 + 100 * (unsigned)i, seeds, &parts[i], says))
            return PROPERTY_FAILS;
    return apart(&whole, parts, count, says) ? PROPERTY_FAILS : PROPERTY_HOLDS;
}

/* What lies in one plane, the eye among it and both sides of a box without height, is seen as
 * rounding has it: a little apart from each other. */
static struct property_case set_apart(const struct property_case *c)
{
    struct property_case out = *c;
    for (int k = 0; k < 3; k++) {
        out.eye[k] += CASE_GRID / 4;
        for (int i = 0; i < c->body_count; i++) {
            struct case_body *b = &out.bodies[i];
            b->centre[k] += CASE_GRID / 64 * i;
            if (b->shape == BODY_BOX || b->shape == BODY_ROOM)
                b->size[k] = fmax(b->size[k], CASE_GRID);
        }
    }
    return out;
}

static enum property_result means_agree(const struct property_case *c, const struct change *changes,
                                        int count, char says[PROPERTY_SAYS_BYTES])
{
    const struct property_case own = set_apart(c);
    const enum property_result few = means_agree_of(FEW, &own, changes, count, says);
    return few == PROPERTY_FAILS ? means_agree_of(MANY, &own, changes, count, says) : few;
}

/* The same of light fields: they know pixels by their centres, which miss some of what ends within
 * pixels, and filters little of small pictures. Of finer pixels they miss less: where they do not
 * agree at first, those four times as fine or sixteen times as fine must. */
static enum property_result fields_agree(const struct property_case *c,
                                         const struct change *changes, int count,
                                         char says[PROPERTY_SAYS_BYTES])
{
    struct property_case finer = set_apart(c);
    enum property_result result = means_agree(c, changes, count, says);
    for (int i = 0; i < 2 && result == PROPERTY_FAILS && c->method != PATHS; i++) {
        finer.width *= 4;
        finer.height *= 4;
        result = means_agree_of(FEW, &finer, changes, count, says);
    }
    return result;
}

enum property_result property_mirrored(const struct property_case *c,
                                       char says[PROPERTY_SAYS_BYTES])
{
    return means_agree(c, &(struct change){.mirrored = true}, 1, says);
}

enum property_result property_turned(const struct property_case *c, char says[PROPERTY_SAYS_BYTES])
{
    return means_agree(c, &(struct change){.turns = 1 + (int)(c->seed % 3)}, 1, says);
}

/* Filters move light about; they neither make nor take it. Samples without them have the same
 * light: some of them, since single ones of a light that all but touches what it lights hardly ever
 * find where it is bright. Of pixels at the picture's edge filters know one side alone, and small
 * pictures are all edge. */
enum property_result property_filtered(const struct property_case *c,
                                       char says[PROPERTY_SAYS_BYTES])
{
    if (c->method >= AVERAGE || c->width < LEAST_PX || c->height < LEAST_PX) {
        snprintf(says, PROPERTY_SAYS_BYTES, "nothing to filter");
        return PROPERTY_DOES_NOT_APPLY;
    }
    /* A single stratum that a horizon hides tells nothing. */
    struct property_case few = *c;
    few.spp = c->spp < LEAST_SPP ? LEAST_SPP : c->spp;
    const struct change plain = {.unfiltered = true, .spp = c->spp < SOME ? SOME : c->spp};
    return fields_agree(&few, &plain, 1, says);
}

enum property_result property_lights_add(const struct property_case *c,
                                         char says[PROPERTY_SAYS_BYTES])
{
    struct change changes[CASE_LIGHTS + 2] = {0};
    struct property_case lit = *c;
    const unsigned all = (1u << c->light_count) - 1;
    /* The parts may be made by light fields and the whole by paths: these resolve what ends within
     * a pixel, and small pictures are of nothing else. */
    const bool small = c->width < LEAST_PX || c->height < LEAST_PX;
    if (c->light_count < 1 || (small && c->method != PATHS)) {
        snprintf(says, PROPERTY_SAYS_BYTES, "no light of the list, or a picture of few pixels");
        return PROPERTY_DOES_NOT_APPLY;
    }
    for (int i = 0; i < c->light_count; i++)
        changes[i] = (struct change){
            .lights = all & ~(1u << i), .no_environment = true, .no_emitters = true};
    changes[c->light_count] = (struct change){.lights = all, .no_emitters = true};
    changes[c->light_count + 1] = (struct change){.lights = all, .no_environment = true};
    property_light_up(&lit);
    return fields_agree(&lit, changes, c->light_count + 2, says);
}

/* What was dealt is within what the job allows. */
static bool within(const struct property_case *c, char says[PROPERTY_SAYS_BYTES])
{
    const struct picture_facts *f = picture_facts();
    const uint64_t pixels = (uint64_t)c->width * (uint64_t)c->height,
                   most = (uint64_t)(c->most > c->spp ? c->most : c->spp),
                   rays = f->first_rays + f->second_rays;
    snprintf(says, PROPERTY_SAYS_BYTES,
             "of %llu pixels %llu paths, %llu bounces, %llu rays, %llu paths through the lens",
             (unsigned long long)pixels, (unsigned long long)f->paths,
             (unsigned long long)f->bounces, (unsigned long long)rays,
             (unsigned long long)f->lens_paths);
    if (c->most > 0 && (f->paths > pixels * most || f->bounces > pixels * most)) return false;
    return rays <= pixels * f->strata_maps * f->most_rays &&
           f->lens_paths <= pixels * (uint64_t)c->lens_second_set;
}

/* Samples of further rounds go where they are needed; they neither make nor take light. Light
 * fields beside the paths of a target know pixels' centres alone, and of small pictures little
 * besides. */
enum property_result property_dealt(const struct property_case *c, char says[PROPERTY_SAYS_BYTES])
{
    const struct change none = {0};
    const bool small = c->width < LEAST_PX || c->height < LEAST_PX;
    if (c->error == 0 ? c->lens_second_set == 0 && c->indirect != CASE_ADAPTIVE : small) {
        snprintf(says, PROPERTY_SAYS_BYTES, "has one round, or few pixels");
        return PROPERTY_DOES_NOT_APPLY;
    }
    struct image *image = property_picture(c, &none, says);
    if (!image) return PROPERTY_DOES_NOT_APPLY;
    image_destroy(&image);
    const struct picture_facts *f = picture_facts();
    if (!within(c, says)) return PROPERTY_FAILS;
    if (f->rounds < 2 && f->second_rays == 0 && f->lens_paths == 0) {
        snprintf(says, PROPERTY_SAYS_BYTES, "nothing is dealt");
        return PROPERTY_DOES_NOT_APPLY;
    }
    return fields_agree(c, &(struct change){.one_round = true}, 1, says);
}
