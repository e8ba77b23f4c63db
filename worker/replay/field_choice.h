#pragma once
/* Which light field of pixel centres somebody asks for: of a plan's, in words. */
#include "proto/plan.h"
#include "proto/scene/scene.h"
#include "worker/trace/path/path_record.h"

struct field_choice {
    enum path_record_kind kind; /* PATH_RECORD_LIGHT, _INDIRECT, _GLOSSY */
    uint32_t light;             /* of the plan */
    uint32_t pass;              /* that traced the sample */
    uint32_t side;              /* l, of passes after the schedule, who give pixels their own */
};

/* "light:0", "light:NAME", "indirect", "glossy". ERR_SYNTAX or ERR_NOT_FOUND; *fault tells what
 * there is to ask for. */
int field_choice_read(const char *text, const struct plan *plan, const struct scene *scene,
                      struct field_choice *out, struct fault *fault);

/* l of the choice's samples; 0: the plan has no such field. */
uint32_t field_choice_side(const struct plan *plan, const struct field_choice *choice);

/* The fields that the plan has, as they are asked for, and how many samples they have; how a pixel
 * is asked for otherwise if there is none. */
#define FIELD_CHOICE_TEXT 320 /* part of a fault's sentence; where lights are many, cut */
const char *field_choice_list(const struct plan *plan, const struct scene *scene,
                              char out[FIELD_CHOICE_TEXT]);

/* What the scene calls a light of the plan; "" for those of the job. */
const char *field_choice_name(const struct plan *plan, const struct scene *scene, uint32_t light);
