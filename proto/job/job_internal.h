#pragma once
/* What reading and writing a job document share: its parts, its words and its numbers. */
#include "proto/job/job.h"

/* Readers of members into a struct job, each a json_member_read. */

/* null leaves the camera as it is, the scene's own at first. */
int job_camera_read(struct json_cursor *at, const struct json_member *member, const json_t *value,
                    void *job);
/* null: none. */
int job_environment_read(struct json_cursor *at, const struct json_member *member,
                         const json_t *value, void *job);
/* null, and an aperture of radius 0: no lens, and then all fields are 0. */
int job_lens_read(struct json_cursor *at, const struct json_member *member, const json_t *value,
                  void *job);
int job_lights_read(struct json_cursor *at, const struct json_member *member, const json_t *value,
                    void *job);

/* Writers of members, beside those of job.h. New reference; NULL on failed allocation. */

/* null without an environment. */
json_t *job_environment_write(const struct job_environment *environment);
json_t *job_lights_write(const struct job *job);

/* Write floats as the shortest decimals that read back to the same bits. New reference; NULL on
 * failed allocation. */
json_t *job_number_write(float v);
json_t *job_number_write3(const float v[3]);

/* v rounded to so many decimal digits. */
double job_number_rounded(double v, int digits);

/* The words of the document. Each table ends with a NULL name. */
extern const struct json_choice job_layer_words[];
extern const struct json_choice job_method_words[];
extern const struct json_choice job_indirect_words[];
extern const struct json_choice job_glossy_words[];
extern const struct json_choice job_residual_words[];
extern const struct json_choice job_lens_words[];
extern const struct json_choice job_pixel_type_words[];
extern const struct json_choice job_pixel_filter_words[];
extern const struct json_choice job_light_type_words[];
extern const struct json_choice job_profile_words[];

/* NULL for an unknown value. */
const char *job_word(const struct json_choice *words, uint32_t value);
