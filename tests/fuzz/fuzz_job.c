/* The job document. What is accepted must be written, read back and written to the same text: then
 * the canonical document has one meaning, and every accepted job can be stored. */
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "proto/job/job.h"

static char *write_text(const struct job *job)
{
    json_t *document = job_write(job);
    if (!document) abort();
    char *text = json_dumps(document, JSON_COMPACT);
    json_decref(document);
    if (!text) abort();
    return text;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size_bytes);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size_bytes)
{
    static struct job job, again;
    struct fault fault = {0};
    if (job_read((const char *)data, size_bytes, &job, &fault) != 0) {
        if (fault.code >= 0 || fault.detail[0] == '\0') abort();
        return 0;
    }
    for (uint32_t k = 0; k < job.light_count; k++)
        if (plan_light_check(&job.lights[k], "light", &fault)) abort();
    char *text = write_text(&job);
    if (job_read(text, strlen(text), &again, &fault)) abort();
    char *twice = write_text(&again);
    if (strcmp(text, twice) != 0) abort();
    free(twice);
    free(text);
    job_fini(&again);
    job_fini(&job);
    return 0;
}
