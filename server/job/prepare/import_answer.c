#include "server/job/prepare/import_answer.h"

#include <stdbool.h>
#include <string.h>

/* Returns the code of a name, ERR_RANGE for "RANGE"; ERR_CORRUPT for one that is unknown here. */
static int code_of(const char *name)
{
    static const int codes[] = {
#define ERROR(name, number, text) number,
#include "proto/error.def"
#undef ERROR
    };
    for (size_t i = 0; name && i < sizeof codes / sizeof codes[0]; i++)
        if (codes[i] < 0 && !strcmp(error_name(codes[i]), name)) return codes[i];
    return ERR_CORRUPT;
}

/* Names of parts are the document's (server/import/scene/roles.h), and so is what is in the files
 * of a sequence (server/import/rgbd). */
static bool is_of_document(const char *place)
{
    return strncmp(place, "/catchers/", 10) == 0 || strncmp(place, "/holdouts/", 10) == 0 ||
           strncmp(place, "/scene/moves/", 13) == 0 || strncmp(place, "/rgbd", 5) == 0;
}

void import_answer_refusal(const json_t *answer, struct fault *fault)
{
    const char *place = json_string_value(json_object_get(answer, "pointer"));
    const char *detail = json_string_value(json_object_get(answer, "detail"));
    int code = code_of(json_string_value(json_object_get(answer, "code")));
    if (place && detail && is_of_document(place)) {
        fault_set(fault, code, place, "%s", detail);
        return;
    }
    fault_set(fault, code, "/scene/asset", "%s%s%s", place ? place : "",
              place && *place ? ": " : "",
              detail ? detail : "the importer refused the file without a reason");
}
