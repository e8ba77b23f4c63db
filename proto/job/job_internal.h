#pragma once
/* Parts, words and numbers of a job document, for the files that read and write it. */
#include "proto/job/job.h"

/* Read members into a struct job; each is a json_member_read. */

/* Reads the camera. null leaves it as it is, at first the scene's own. */
int job_camera_read(struct json_cursor *at, const struct json_member *member, const json_t *value,
                    void *job);
/* Reads the environment. null means none. */
int job_environment_read(struct json_cursor *at, const struct json_member *member,
                         const json_t *value, void *job);
/* Reads the lens. null and an aperture of radius 0 mean none, with all fields 0. */
int job_lens_read(struct json_cursor *at, const struct json_member *member, const json_t *value,
                  void *job);
/* Reads the moves of nodes, in place of those that there are. */
int job_moves_read(struct json_cursor *at, const struct json_member *member, const json_t *value,
                   void *job);
/* The members of the object camera, and what is written of it. */
extern const struct json_member job_shutter_members[];
json_t *job_shutter_write(const struct job *job);
/* The members of the object image. */
extern const struct json_member job_image_members[];
/* Reads frames, an object or a list as a text. */
int job_frames_read(struct json_cursor *at, const struct json_member *member, const json_t *value,
                    void *job);
/* Reads 1, 0.5 or "auto"; and what writes it. */
int job_field_scale_read(struct json_cursor *at, const struct json_member *member,
                         const json_t *value, void *job);
json_t *job_field_scale_write(enum field_scale scale);
int job_lights_read(struct json_cursor *at, const struct json_member *member, const json_t *value,
                    void *job);

/* Read the marks. null is none. */
int job_name_read(struct json_cursor *at, const struct json_member *member, const json_t *value,
                  void *job);
int job_comment_read(struct json_cursor *at, const struct json_member *member, const json_t *value,
                     void *job);
int job_labels_read(struct json_cursor *at, const struct json_member *member, const json_t *value,
                    void *job);
int job_webhook_read(struct json_cursor *at, const struct json_member *member, const json_t *value,
                     void *job);

/* Read the members of a picture that is composed with a photograph. */
int job_plate_read(struct json_cursor *at, const struct json_member *member, const json_t *value,
                   void *job);
int job_rgbd_read(struct json_cursor *at, const struct json_member *member, const json_t *value,
                  void *job);
int job_catchers_read(struct json_cursor *at, const struct json_member *member, const json_t *value,
                      void *job);
int job_holdouts_read(struct json_cursor *at, const struct json_member *member, const json_t *value,
                      void *job);
int job_composite_mode_read(struct json_cursor *at, const struct json_member *member,
                            const json_t *value, void *job);
/* Sets what such a job has by default, where its document does not say layers or image.view. */
void job_composite_defaults(struct job *job, bool has_layers, bool has_view);
/* Checks what these members ask of others; the cursor stands at the root. */
int job_composite_check(struct json_cursor *at, const struct job *job);

/* Checks what all members ask of each other; the cursor stands at the root. */
int job_relations_check(struct json_cursor *at, const struct job *job);
/* Adds them to a document, if there are any. Returns the failed allocations. */
int job_composite_write(const struct job *job, json_t *document);

/* Write members that job.h has no writer of. Return a new reference; NULL on failed allocation. */

/* Writes the environment; none is null. */
json_t *job_environment_write(const struct job_environment *environment);
json_t *job_image_write(const struct job *job);
json_t *job_lights_write(const struct job *job);
json_t *job_frames_write(const struct job *job);
json_t *job_webhook_write(const char *url);
json_t *job_labels_write(const struct job_marks *marks);
/* Writes a text; NULL is null. */
json_t *job_text_write(const char *text);

/* Write floats as the shortest decimals that read back to the same bits. Return a new reference;
 * NULL on failed allocation. */
json_t *job_number_write(float v);
json_t *job_number_write3(const float v[3]);

/* Returns v rounded to a number of decimal digits. */
double job_number_rounded(double v, int digits);

/* The words of the document. A NULL name ends each table. */
extern const struct json_choice job_layer_words[];
extern const struct json_choice job_method_words[];
extern const struct json_choice job_indirect_words[];
extern const struct json_choice job_glossy_words[];
extern const struct json_choice job_environment_words[];
extern const struct json_choice job_residual_words[];
extern const struct json_choice job_temporal_words[];
extern const struct json_choice job_lens_words[];
extern const struct json_choice job_pixel_type_words[];
extern const struct json_choice job_view_words[];
extern const struct json_choice job_pixel_filter_words[];
extern const struct json_choice job_exr_codec_words[];
extern const struct json_choice job_view_curve_words[];
extern const struct json_choice job_light_type_words[];
extern const struct json_choice job_profile_words[];

/* Returns the word of a value; NULL for an unknown one. */
const char *job_word(const struct json_choice *words, uint32_t value);
