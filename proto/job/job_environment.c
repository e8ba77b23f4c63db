#include "proto/job/job_internal.h"

#define FIELD(member) offsetof(struct job_environment, member)

static const struct json_member map_members[] = {
    {.name = "asset", .read = json_member_digest, .offset = FIELD(asset)},
    {.name = "intensity",
     .read = json_member_f32,
     .offset = FIELD(intensity),
     .min = 0,
     .max = LIMIT_RADIANCE},
    {.name = "rotation_deg",
     .read = json_member_f32,
     .offset = FIELD(rotation_deg),
     .min = -360,
     .max = 360},
    {.name = "file",
     .read = json_member_unsupported,
     .sentence = "a file on your machine: submit with the command line, or upload it and give its "
                 "digest as \"asset\""},
    {.name = NULL}};

static const struct json_member constant_members[] = {{.name = "radiance",
                                                       .read = json_member_f32x3,
                                                       .offset = FIELD(radiance),
                                                       .min = 0,
                                                       .max = LIMIT_RADIANCE},
                                                      {.name = NULL}};

/* Looks first at which of the two forms it is, because that decides which members there may be. */
int job_environment_read(struct json_cursor *at, const struct json_member *member,
                         const json_t *value, void *object)
{
    struct job_environment *e = &((struct job *)object)->environment;
    (void)member;
    if (json_is_null(value)) return 0;
    int error = json_cursor_expect(at, value, JSON_OBJECT, "an object or null");
    if (error) return error;
    const bool constant = json_object_get(value, "radiance") != NULL;
    if (constant && json_object_get(value, "asset"))
        return json_cursor_refuse_member(at, "radiance", ERR_EXISTS,
                                         "it stands beside \"asset\": give one of the two");
    *e = (struct job_environment){.kind = constant ? ENVIRONMENT_CONSTANT : ENVIRONMENT_MAP,
                                  .intensity = 1.0f};
    error = json_cursor_members(at, value, constant ? constant_members : map_members, e);
    if (error || constant || json_object_get(value, "asset")) return error;
    return json_cursor_refuse_member(
        at, "asset", ERR_MISSING,
        "\"asset\" (a map) or \"radiance\" (the same from everywhere) is required");
}

static json_t *write_map(const struct job_environment *e)
{
    char hex[DIGEST_HEX_BYTES];
    digest_to_hex(&e->asset, hex);
    return json_pack("{s:s,s:o,s:o}", "asset", hex, "intensity", job_number_write(e->intensity),
                     "rotation_deg", job_number_write(e->rotation_deg));
}

json_t *job_environment_write(const struct job_environment *environment)
{
    switch (environment->kind) {
    case ENVIRONMENT_MAP:
        return write_map(environment);
    case ENVIRONMENT_CONSTANT:
        return json_pack("{s:o}", "radiance", job_number_write3(environment->radiance));
    default:
        return json_null();
    }
}
