/* The member image: size, pixels, files, and how people see it. */
#include "proto/job/job_internal.h"

static int read_png_bits(struct json_cursor *at, const struct json_member *m, const json_t *v,
                         void *o)
{
    const int error = json_member_u32(at, m, v, o);
    const uint32_t bits = ((struct job *)o)->png_bits;
    if (error || bits == 8 || bits == 16) return error;
    return json_cursor_refuse(at, ERR_RANGE, "%u is neither 8 nor 16", bits);
}

#define NUMBER(member, reader, field, least, most)                                                 \
    {                                                                                              \
        .name = (member), .read = (reader), .offset = offsetof(struct job, field), .min = (least), \
        .max = (most)                                                                              \
    }
#define WORD(member, field, words)                                                                 \
    {                                                                                              \
        .name = (member), .read = json_member_choice, .offset = offsetof(struct job, field),       \
        .choices = (words)                                                                         \
    }

const struct json_member job_image_members[] = {
    NUMBER("width", json_member_i32, width_px, 1, LIMIT_IMAGE_SIDE_PX),
    NUMBER("height", json_member_i32, height_px, 1, LIMIT_IMAGE_SIDE_PX),
    WORD("pixel_type", pixel_type, job_pixel_type_words),
    WORD("pixel_filter", pixel_filter, job_pixel_filter_words),
    WORD("exr_compression", exr_compression, job_exr_codec_words),
    WORD("view", view, job_view_curve_words),
    NUMBER("exposure", json_member_f32, exposure, -LIMIT_EXPOSURE_EV, LIMIT_EXPOSURE_EV),
    NUMBER("png_bits", read_png_bits, png_bits, 8, 16),
    {.name = "png_alpha", .read = json_member_bool, .offset = offsetof(struct job, png_alpha)},
    {.name = NULL}};

static int set(json_t *object, const char *key, json_t *value)
{
    return json_object_set_new(object, key, value) != 0;
}

json_t *job_image_write(const struct job *job)
{
    const char *pixel_type = job_word(job_pixel_type_words, job->pixel_type);
    const char *pixel_filter = job_word(job_pixel_filter_words, job->pixel_filter);
    const char *compression = job_word(job_exr_codec_words, job->exr_compression);
    json_t *object = json_object();
    int failures = set(object, "width", json_integer(job->width_px));
    failures += set(object, "height", json_integer(job->height_px));
    failures += set(object, "pixel_type", json_string(pixel_type));
    failures += set(object, "pixel_filter", json_string(pixel_filter));
    failures += set(object, "exr_compression", json_string(compression));
    failures += set(object, "view", json_string(view_curve_name(job->view)));
    failures += set(object, "exposure", job_number_write(job->exposure));
    failures += set(object, "png_bits", json_integer(job->png_bits));
    failures += set(object, "png_alpha", json_boolean(job->png_alpha));
    if (failures == 0) return object;
    json_decref(object);
    return NULL;
}
