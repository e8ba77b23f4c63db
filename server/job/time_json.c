#include "server/job/time_json.h"

#include <stdio.h>
#include <time.h>

json_t *time_json(int64_t time_ms)
{
    char text[48];
    struct tm parts;
    time_t seconds = (time_t)(time_ms / 1000);
    if (!gmtime_r(&seconds, &parts)) return json_null();
    size_t n = strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%S", &parts);
    snprintf(text + n, sizeof text - n, ".%03dZ", (int)(time_ms % 1000));
    return json_string(text);
}
