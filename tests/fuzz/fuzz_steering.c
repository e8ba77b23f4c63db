/* The document that steers a job: what is accepted lies within its limits, what is not is named. */
// sources: server/job/steering.c
#include <stdint.h>
#include <stdlib.h>

#include "server/job/steering.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size_bytes);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size_bytes)
{
    struct steering s;
    struct fault fault = {0};
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
