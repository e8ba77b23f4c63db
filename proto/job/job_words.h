#pragma once
/* The words of a job document, for its reader and its writer. Each table ends with a NULL name. */
#include "proto/job/job.h"

extern const struct json_choice job_layer_words[];
extern const struct json_choice job_method_words[];
extern const struct json_choice job_indirect_words[];
extern const struct json_choice job_glossy_words[];
extern const struct json_choice job_lens_words[];
extern const struct json_choice job_pixel_type_words[];
extern const struct json_choice job_pixel_filter_words[];
extern const struct json_choice job_light_type_words[];
extern const struct json_choice job_profile_words[];

/* NULL for an unknown value. */
const char *job_word(const struct json_choice *words, uint32_t value);
