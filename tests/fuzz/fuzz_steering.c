/* The documents that steer a job and change its marks: what is accepted lies within its limits,
 * what is not is named. */
// sources: server/job/steering.c
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "proto/job/job_marks.h"
#include "server/job/steering.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size_bytes);

/* What is accepted is read again as the same. */
static void read_marks(const char *text, size_t size_bytes)
{
    struct fault fault = {0};
    json_t *change = NULL, *again = NULL;
    if (job_marks_read_change(text, size_bytes, &change, &fault) != 0) {
        if (change || fault.code >= 0 || fault.detail[0] == '\0') abort();
        return;
    }
    char *written = json_dumps(change, JSON_COMPACT);
    if (!written || json_object_size(change) == 0) abort();
    if (job_marks_read_change(written, strlen(written), &again, &fault) != 0) abort();
    if (!json_equal(change, again)) abort();
    free(written);
    json_decref(change);
    json_decref(again);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size_bytes)
{
    struct steering s;
    struct fault fault = {0};
    read_marks((const char *)data, size_bytes);
    if (steering_read((const char *)data, size_bytes, &s, &fault) != 0) {
        if (fault.code >= 0 || fault.detail[0] == '\0') abort();
        return 0;
    }
    if (s.given == 0 || abs(s.priority) > LIMIT_PRIORITY) abort();
    if (steering_check(&s, 640, 360, &fault) != 0) {
        if (fault.pointer[0] == '\0') abort();
        return 0;
    }
    if (s.region.x0 < 0 || s.region.x1 > 640 || s.region.y0 < 0 || s.region.y1 > 360) abort();
    if (s.has_near && (s.near_x < 0 || s.near_x >= 640 || s.near_y < 0 || s.near_y >= 360)) abort();
    return 0;
}
