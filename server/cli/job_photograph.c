/* What a command line says of the photograph that a picture is composed with. */
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "server/cli/job_changes.h"

static int set_plate(const char *path, json_t *document, struct fault *fault)
{
    char *whole = realpath(path, NULL);
    if (!whole)
        return fault_set(fault, ERR_NOT_FOUND, "", "--backplate: %s: %s", path, strerror(errno));
    json_t *plate = json_object_get(document, "backplate");
    if (json_is_null(plate))
        json_object_del(document, "backplate");
    else
        json_object_del(plate, "asset");
    int error = job_changes_set(document, "backplate", "file", json_string(whole));
    free(whole);
    return error;
}

/* Returns document[member], an array that is made if it is not there; NULL without memory. */
static json_t *list_of(json_t *document, const char *member)
{
    json_t *list = json_object_get(document, member);
    if (list) return list;
    list = json_array();
    return json_object_set_new(document, member, list) == 0 ? list : NULL;
}

/* Adds names, parted by commas. */
static int add_names(const char *option, const char *names, const char *member, json_t *document,
                     struct fault *fault)
{
    json_t *list = list_of(document, member);
    if (!list) return ERR_MEMORY;
    for (const char *at = names, *end; at; at = *end ? end + 1 : NULL) {
        end = strchrnul(at, ',');
        json_t *name = json_stringn(at, (size_t)(end - at));
        if (!name)
            return fault_set(fault, ERR_RANGE, "", "--%s: \"%.40s\" is no UTF-8", option, names);
        if (json_is_array(list) && json_array_append(list, name) != 0) list = NULL;
        json_decref(name);
        if (!list) return ERR_MEMORY;
    }
    return 0;
}

static int add_ground(const char *text, json_t *document, struct fault *fault)
{
    char *end;
    const double height = strtod(text, &end);
    if (end == text || *end || !isfinite(height))
        return fault_set(fault, ERR_RANGE, "", "--catcher-ground: \"%.40s\" is no number", text);
    json_t *list = list_of(document, "catchers");
    json_t *ground = json_pack("{s:{s:f}}", "ground", "height", height);
    if (list && !json_is_array(list)) {
        json_decref(ground);
        return 0;
    }
    return list && json_array_append_new(list, ground) == 0 ? 0 : ERR_MEMORY;
}

int job_changes_photograph(const struct job_changes *changes, json_t *document, struct fault *fault)
{
    int error = 0;
    if (changes->backplate) error = set_plate(changes->backplate, document, fault);
    if (!error && changes->fit)
        error = job_changes_set(document, "backplate", "fit", json_string(changes->fit));
    for (size_t i = 0; i < changes->catchers.count && !error; i++)
        error = add_names("catcher", changes->catchers.values[i], "catchers", document, fault);
    if (!error && changes->ground) error = add_ground(changes->ground, document, fault);
    for (size_t i = 0; i < changes->holdouts.count && !error; i++)
        error = add_names("holdout", changes->holdouts.values[i], "holdouts", document, fault);
    if (!error && changes->composite)
        error = job_changes_set(document, "composite", "mode", json_string(changes->composite));
    return error;
}
