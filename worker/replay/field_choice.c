#include "worker/replay/field_choice.h"

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "proto/samples.h"

#define LIGHT_PREFIX "light:"

static bool is_same(const float a[3], const float b[3])
{
    return a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
}

const char *field_choice_name(const struct plan *plan, const struct scene *scene, uint32_t light)
{
    const struct plan_light *p = &plan->lights[light];
    for (uint64_t i = 0; i < scene->count[SCENE_LIGHTS]; i++) {
        const struct scene_light *s = &scene->lights[i];
        /* The plan turns a rectangle's direction into its normal, and leaves the rest alone. */
        const bool turned = p->type == LIGHT_RECTANGLE;
        if (s->type == p->type && is_same(s->position, p->position) &&
            is_same(s->half_u, p->half_u) && is_same(s->half_v, p->half_v) &&
            is_same(s->color, p->color) && (turned || is_same(s->direction, p->direction)))
            return scene_name(scene, s->name);
    }
    return "";
}

uint32_t field_choice_side(const struct plan *plan, const struct field_choice *choice)
{
    if (choice->kind == PATH_RECORD_LIGHT) {
        if (choice->light >= plan->light_count || !plan_light_planes(plan, choice->light)) return 0;
        return plan->lights[choice->light].strata_per_axis;
    }
    const bool glossy = choice->kind == PATH_RECORD_GLOSSY;
    if (!(plan->planes & (glossy ? PLANES_GLOSSY : PLANES_BOUNCE_RAYS))) return 0;
    return choice->pass > 0 ? choice->side : plan->indirect_strata_per_axis;
}

/* Appends one of the fields. */
static size_t append(char out[FIELD_CHOICE_TEXT], size_t at, const char *what, const char *name,
                     uint32_t side)
{
    static const char more[] = ", ...";
    const size_t room = FIELD_CHOICE_TEXT - sizeof more;
    if (side == 0 || at >= room) return at;
    const int n =
        snprintf(out + at, room - at, "%s%s%s%.40s%s (samples 0 to %u)", at > 0 ? ", " : "", what,
                 name[0] ? " \"" : "", name, name[0] ? "\"" : "", side * side - 1);
    if (n > 0 && at + (size_t)n < room) return at + (size_t)n;
    memcpy(out + at, more, sizeof more);
    return room;
}

const char *field_choice_list(const struct plan *plan, const struct scene *scene,
                              char out[FIELD_CHOICE_TEXT])
{
    size_t at = 0;
    struct field_choice c = {.kind = PATH_RECORD_LIGHT};
    for (c.light = 0; c.light < plan->light_count; c.light++) {
        char word[32];
        snprintf(word, sizeof word, LIGHT_PREFIX "%u", c.light);
        at = append(out, at, word, field_choice_name(plan, scene, c.light),
                    field_choice_side(plan, &c));
    }
    c.kind = PATH_RECORD_INDIRECT;
    at = append(out, at, "indirect", "", field_choice_side(plan, &c));
    c.kind = PATH_RECORD_GLOSSY;
    at = append(out, at, "glossy", "", field_choice_side(plan, &c));
    if (at == 0)
        snprintf(out, FIELD_CHOICE_TEXT, "none: its paths bring all light, ask without --field");
    return out;
}

/* A number, or the name that exactly one of the plan's lights has. */
static int find_light(const char *text, const struct plan *plan, const struct scene *scene,
                      uint32_t *out, struct fault *fault)
{
    char list[FIELD_CHOICE_TEXT];
    uint32_t found = 0;
    const size_t digits = strspn(text, "0123456789");
    if (digits > 0 && digits < 10 && text[digits] == '\0') {
        *out = (uint32_t)strtoul(text, NULL, 10);
        if (*out < plan->light_count) return 0;
        return fault_set(fault, ERR_NOT_FOUND, "--field",
                         "the plan has no light %u but %u of them; fields there are: %s", *out,
                         plan->light_count, field_choice_list(plan, scene, list));
    }
    for (uint32_t k = 0; k < plan->light_count; k++) {
        if (text[0] == '\0' || strcmp(field_choice_name(plan, scene, k), text) != 0) continue;
        if (found++ == 0) *out = k;
    }
    if (found == 1) return 0;
    return fault_set(fault, ERR_NOT_FOUND, "--field",
                     "%s is called \"%.64s\"; fields there are: %s",
                     found ? "more than one light" : "no light of the plan", text,
                     field_choice_list(plan, scene, list));
}

int field_choice_read(const char *text, const struct plan *plan, const struct scene *scene,
                      struct field_choice *out, struct fault *fault)
{
    char list[FIELD_CHOICE_TEXT];
    const size_t prefix = sizeof LIGHT_PREFIX - 1;
    out->light = 0;
    out->kind = PATH_RECORD_LIGHT;
    if (strncmp(text, LIGHT_PREFIX, prefix) == 0)
        return find_light(text + prefix, plan, scene, &out->light, fault);
    out->kind = PATH_RECORD_INDIRECT;
    if (strcmp(text, "indirect") == 0) return 0;
    out->kind = PATH_RECORD_GLOSSY;
    if (strcmp(text, "glossy") == 0) return 0;
    return fault_set(fault, ERR_SYNTAX, "--field",
                     "\"%.64s\" is no field: light:N, light:NAME, indirect and glossy are; of this "
                     "plan %s",
                     text, field_choice_list(plan, scene, list));
}
