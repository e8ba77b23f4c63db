#pragma once
/* A job's marks: the name, comment and labels by which people find it again, and the address that
 * is told of its end. They change no pixel. */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "proto/json.h"

struct job_marks {
    char *name;                     /* owned; NULL: none */
    char *comment;                  /* owned; may have line breaks and tabs; NULL: none */
    char *labels[LIMIT_JOB_LABELS]; /* owned; in the order of their bytes, all different */
    uint32_t label_count;
    char *webhook; /* owned; an http or https URL; NULL: none */
};

void job_marks_fini(struct job_marks *marks);
/* ERR_MEMORY: *out is empty. */
int job_marks_copy(const struct job_marks *marks, struct job_marks *out);

/* Reads a change of marks: {name, comment, labels}, at least one of them, as in a job document.
 * *out has the members that were given, as job_write writes them; the caller owns it. On failure
 * *fault has the code, the JSON pointer and a sentence. */
int job_marks_read_change(const char *text, size_t size_bytes, json_t **out, struct fault *fault);

/* Returns what is wrong with a label, as the rest of a sentence about it; NULL: nothing. The text
 * must be UTF-8. */
const char *job_label_fault(const char *label);
