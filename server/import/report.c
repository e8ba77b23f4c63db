#include "server/import/report.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "proto/json.h"

/* Takes `json`, which may be NULL. */
static char *to_line(json_t *json)
{
    char *text = json_text(json, JSON_COMPACT | JSON_REAL_PRECISION(6));
    char *line = text != NULL ? malloc(strlen(text) + 2) : NULL;
    if (line != NULL) sprintf(line, "%s\n", text);
    free(text);
    json_decref(json);
    return line;
}

char *report_success(const struct import_stats *stats, const struct warnings *warnings,
                     double cpu_s)
{
    json_t *list = json_array();
    for (uint32_t i = 0; list != NULL && i < warnings->count; i++) {
        char text[WARNING_TEXT_BYTES];
        warnings_text(warnings, i, text);
        json_array_append_new(list, json_string(text));
    }
    const bool is_map = stats->width_px > 0;
    return to_line(
        json_pack("{s:b,s:I,s:I,s:i,s:o,s:f}", "ok", 1, is_map ? "width_px" : "triangles",
                  is_map ? (json_int_t)stats->width_px : (json_int_t)stats->triangles,
                  is_map ? "height_px" : "placed_triangles",
                  is_map ? (json_int_t)stats->height_px : (json_int_t)stats->placed_triangles,
                  "frames", (int)stats->frames, "warnings", list, "cpu_s", cpu_s));
}

char *report_failure(const struct fault *fault)
{
    struct fault printable = *fault;
    text_make_printable(printable.pointer);
    text_make_printable(printable.detail);
    return to_line(json_pack("{s:b,s:s,s:s,s:s}", "ok", 0, "code", error_name(fault->code),
                             "pointer", printable.pointer, "detail", printable.detail));
}
