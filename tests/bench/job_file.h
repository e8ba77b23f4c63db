#pragma once
/* A job's document from a file, for benchmarks that trace without a coordinator. */
#include <stdio.h>
#include <stdlib.h>

#include "proto/job/job.h"

/* Ends the program with a sentence where that fails. */
static void read_job(const char *path, struct job *out)
{
    static char text[LIMIT_JOB_BYTES];
    struct fault fault = {0};
    FILE *f = fopen(path, "rb");
    const size_t size_bytes = f ? fread(text, 1, sizeof text, f) : 0;
    if (f) fclose(f);
    if (f && !job_read(text, size_bytes, out, &fault)) return;
    fprintf(stderr, "%s: %s: %s\n", path, fault.pointer, f ? fault.detail : "cannot be read");
    exit(1);
}
