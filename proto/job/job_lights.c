#include "proto/job/job_internal.h"

#include <math.h>
#include <string.h>

#define RADIANS_PER_DEGREE 0.017453292519943295

/* Lengths that are this near 1 stay as they are, so that reading what was written changes nothing.
 */
#define UNIT_TOLERANCE 1e-5

/* Below this sine two half sides count as parallel. */
#define SINE_MIN 1e-6

/* A light as the document has it. */
struct document_light {
    struct plan_light light;
    float inner_deg, outer_deg;
};

#define FIELD(member) offsetof(struct document_light, member)
#define POSITION(word, field)                                                                      \
    {                                                                                              \
        .name = (word), .read = json_member_f32x3, .offset = FIELD(light.field),                   \
        .min = -LIMIT_COORDINATE, .max = LIMIT_COORDINATE, .required = true                        \
    }
#define COLOR(word)                                                                                \
    {                                                                                              \
        .name = (word), .read = json_member_f32x3, .offset = FIELD(light.color), .min = 0,         \
        .max = LIMIT_RADIANCE, .required = true                                                    \
    }
#define DEGREES(word, field)                                                                       \
    {                                                                                              \
        .name = (word), .read = json_member_f32, .offset = FIELD(field), .min = 0, .max = 90       \
    }
#define TYPE                                                                                       \
    {                                                                                              \
        .name = "type", .read = json_member_choice, .offset = FIELD(light.type),                   \
        .choices = job_light_type_words, .required = true                                          \
    }
#define PROFILE                                                                                    \
    {                                                                                              \
        .name = "profile", .read = json_member_choice, .offset = FIELD(light.profile),             \
        .choices = job_profile_words                                                               \
    }

static const struct json_member point_members[] = {
    TYPE, POSITION("position", position), COLOR("intensity"), {.name = NULL}};

static const struct json_member spot_members[] = {TYPE,
                                                  POSITION("position", position),
                                                  POSITION("direction", direction),
                                                  COLOR("intensity"),
                                                  DEGREES("inner_deg", inner_deg),
                                                  DEGREES("outer_deg", outer_deg),
                                                  {.name = NULL}};

static const struct json_member directional_members[] = {
    TYPE, POSITION("direction", direction), COLOR("irradiance"), {.name = NULL}};

static const struct json_member rectangle_members[] = {TYPE,
                                                       POSITION("center", position),
                                                       POSITION("half_u", half_u),
                                                       POSITION("half_v", half_v),
                                                       COLOR("radiance"),
                                                       PROFILE,
                                                       {.name = NULL}};

static const struct json_member *const members_of[] = {
    [LIGHT_POINT] = point_members,
    [LIGHT_SPOT] = spot_members,
    [LIGHT_DIRECTIONAL] = directional_members,
    [LIGHT_RECTANGLE] = rectangle_members,
};

static double length_of(const double v[3])
{
    return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

static void widen(const float v[3], double out[3])
{
    for (int i = 0; i < 3; i++) out[i] = (double)v[i];
}

static int make_unit(struct json_cursor *at, float v[3])
{
    double wide[3];
    widen(v, wide);
    const double length = length_of(wide);
    if (!(length >= 1e-30))
        return json_cursor_refuse_member(at, "direction", ERR_RANGE, "it has no length");
    if (fabs(length - 1.0) <= UNIT_TOLERANCE) return 0;
    for (int i = 0; i < 3; i++) v[i] = (float)(wide[i] / length);
    return 0;
}

static int finish_spot(struct json_cursor *at, struct document_light *d)
{
    struct plan_light *light = &d->light;
    light->cos_inner = (float)cos((double)d->inner_deg * RADIANS_PER_DEGREE);
    light->cos_outer = (float)fmax(cos((double)d->outer_deg * RADIANS_PER_DEGREE), 0.0);
    if (!(light->cos_inner > light->cos_outer))
        return json_cursor_refuse_member(at, "inner_deg", ERR_RANGE,
                                         "%.9g is not below outer_deg %.9g", (double)d->inner_deg,
                                         (double)d->outer_deg);
    return make_unit(at, light->direction);
}

static int finish_rectangle(struct json_cursor *at, struct plan_light *light)
{
    double u[3], v[3], n[3];
    widen(light->half_u, u);
    widen(light->half_v, v);
    for (int i = 0; i < 3; i++) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        n[i] = u[j] * v[k] - u[k] * v[j];
    }
    const double area = length_of(n), sides = length_of(u) * length_of(v);
    if (!(length_of(u) >= 1e-15))
        return json_cursor_refuse_member(at, "half_u", ERR_RANGE, "its length %.9g is too small",
                                         length_of(u));
    if (!(length_of(v) >= 1e-15))
        return json_cursor_refuse_member(at, "half_v", ERR_RANGE, "its length %.9g is too small",
                                         length_of(v));
    if (!(area >= 1e-30) || area < SINE_MIN * sides)
        return json_cursor_refuse_member(at, "half_v", ERR_RANGE, "it is parallel to half_u");
    for (int i = 0; i < 3; i++) light->direction[i] = (float)(n[i] / area);
    return 0;
}

static int finish(struct json_cursor *at, struct document_light *d)
{
    switch (d->light.type) {
    case LIGHT_SPOT:
        return finish_spot(at, d);
    case LIGHT_DIRECTIONAL:
        return make_unit(at, d->light.direction);
    case LIGHT_RECTANGLE:
        return finish_rectangle(at, &d->light);
    default:
        return 0;
    }
}

/* The type decides which members there may be, so it is read before them. */
static int read_type(struct json_cursor *at, const json_t *value, uint32_t *type)
{
    struct document_light d;
    const struct json_member *m = &point_members[0];
    int error = json_cursor_expect(at, value, JSON_OBJECT, "an object");
    if (error) return error;
    const json_t *word = json_object_get(value, "type");
    if (!word) return json_cursor_refuse_member(at, "type", ERR_MISSING, "\"type\" is required");
    const size_t length = json_cursor_enter(at, "type");
    error = m->read(at, m, word, &d);
    if (error) return error;
    json_cursor_leave(at, length);
    *type = d.light.type;
    return 0;
}

static int read_light(struct json_cursor *at, const json_t *value, struct plan_light *out)
{
    uint32_t type = LIGHT_POINT;
    struct document_light d = {.inner_deg = 0.0f, .outer_deg = 45.0f};
    int error = read_type(at, value, &type);
    if (!error) error = json_cursor_members(at, value, members_of[type], &d);
    if (!error) error = finish(at, &d);
    if (error) return error;
    d.light.power = 1.0f;
    d.light.strata_per_axis = 1;
    *out = d.light;
    return 0;
}

int job_lights_read(struct json_cursor *at, const struct json_member *member, const json_t *value,
                    void *object)
{
    struct job *job = object;
    int error = json_cursor_expect(at, value, JSON_ARRAY, "an array of lights");
    (void)member;
    if (error) return error;
    const size_t count = json_array_size(value);
    if (count > LIMIT_LIGHTS)
        return json_cursor_refuse(at, ERR_LIMIT, "%zu lights are above the limit of %d", count,
                                  LIMIT_LIGHTS);
    for (size_t i = 0; i < count; i++) {
        const size_t length = json_cursor_enter_index(at, i);
        error = read_light(at, json_array_get(value, i), &job->lights[i]);
        if (error) return error;
        json_cursor_leave(at, length);
    }
    job->light_count = (uint32_t)count;
    return 0;
}

/* The shortest angle whose cosine is the same float. */
static json_t *write_degrees(float cosine)
{
    const double degrees = acos((double)cosine) / RADIANS_PER_DEGREE;
    for (int digits = 1; digits < 17; digits++) {
        const double candidate = job_number_rounded(degrees, digits);
        if ((float)fmax(cos((double)(float)candidate * RADIANS_PER_DEGREE), 0.0) == cosine)
            return json_real(candidate);
    }
    return json_real(degrees);
}

static int write_spot(json_t *to, const struct plan_light *light)
{
    int failed = json_object_set_new(to, "position", job_number_write3(light->position));
    failed |= json_object_set_new(to, "direction", job_number_write3(light->direction));
    failed |= json_object_set_new(to, "intensity", job_number_write3(light->color));
    failed |= json_object_set_new(to, "inner_deg", write_degrees(light->cos_inner));
    failed |= json_object_set_new(to, "outer_deg", write_degrees(light->cos_outer));
    return failed;
}

static int write_rectangle(json_t *to, const struct plan_light *light)
{
    const char *profile = job_word(job_profile_words, light->profile);
    int failed = json_object_set_new(to, "center", job_number_write3(light->position));
    failed |= json_object_set_new(to, "half_u", job_number_write3(light->half_u));
    failed |= json_object_set_new(to, "half_v", job_number_write3(light->half_v));
    failed |= json_object_set_new(to, "radiance", job_number_write3(light->color));
    failed |= json_object_set_new(to, "profile", json_string(profile));
    return failed;
}

static int write_members(json_t *to, const struct plan_light *light)
{
    int failed = 0;
    switch (light->type) {
    case LIGHT_SPOT:
        return write_spot(to, light);
    case LIGHT_RECTANGLE:
        return write_rectangle(to, light);
    case LIGHT_DIRECTIONAL:
        failed |= json_object_set_new(to, "direction", job_number_write3(light->direction));
        failed |= json_object_set_new(to, "irradiance", job_number_write3(light->color));
        return failed;
    default:
        failed |= json_object_set_new(to, "position", job_number_write3(light->position));
        failed |= json_object_set_new(to, "intensity", job_number_write3(light->color));
        return failed;
    }
}

json_t *job_lights_write(const struct job *job)
{
    json_t *lights = json_array();
    for (uint32_t i = 0; lights && i < job->light_count; i++) {
        const char *type = job_word(job_light_type_words, job->lights[i].type);
        json_t *light = json_object();
        int failed = json_object_set_new(light, "type", json_string(type));
        if (!failed) failed = write_members(light, &job->lights[i]);
        if (failed) json_decref(light);
        if (failed || json_array_append_new(lights, light)) {
            json_decref(lights);
            return NULL;
        }
    }
    return lights;
}
