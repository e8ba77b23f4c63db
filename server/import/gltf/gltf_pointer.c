#include "server/import/gltf/gltf_pointer.h"

#include <inttypes.h>
#include <string.h>

#define TOKENS_MAX 12

struct tokens {
    char list[TOKENS_MAX][64];
    size_t count;
};

/* What may be moved: "#" stands for an index, "*" for any member, "**" for one or more of them.
 * These parts of the document are read after animations were applied, and checked then. */
static const struct rule {
    const char *pattern[6];
    uint32_t width;
    enum gltf_sampler_kind kind;
} rules[] = {
    {{"nodes", "#", "translation"}, 3, GLTF_SAMPLED_NUMBERS},
    {{"nodes", "#", "rotation"}, 4, GLTF_SAMPLED_ROTATION},
    {{"nodes", "#", "scale"}, 3, GLTF_SAMPLED_NUMBERS},
    {{"nodes", "#", "weights"}, 0, GLTF_SAMPLED_NUMBERS},
    {{"nodes", "#", "weights", "#"}, 1, GLTF_SAMPLED_NUMBERS},
    {{"nodes", "#", "extensions", "KHR_node_visibility", "visible"}, 1, GLTF_SAMPLED_NUMBERS},
    {{"meshes", "#", "weights"}, 0, GLTF_SAMPLED_NUMBERS},
    {{"meshes", "#", "weights", "#"}, 1, GLTF_SAMPLED_NUMBERS},
    {{"cameras", "#", "*", "*"}, 1, GLTF_SAMPLED_NUMBERS},
    {{"materials", "#", "**"}, 0, GLTF_SAMPLED_NUMBERS},
    {{"extensions", "KHR_lights_punctual", "lights", "#", "**"}, 0, GLTF_SAMPLED_NUMBERS},
};

/* Copies the token at *at, whose "~1" is "/" and "~0" is "~", and moves on. */
static bool next_token(const char **at, char out[64])
{
    size_t length = 0;
    const char *c = *at;
    for (; *c != '\0' && *c != '/'; c++) {
        if (length == 63) return false;
        if (*c == '~' && c[1] != '0' && c[1] != '1') return false;
        out[length++] = (char)(*c != '~' ? *c : *++c == '1' ? '/' : '~');
    }
    out[length] = '\0';
    *at = c;
    return length > 0;
}

static bool split(const char *text, struct tokens *out)
{
    out->count = 0;
    while (*text == '/') {
        text++;
        if (out->count == TOKENS_MAX || !next_token(&text, out->list[out->count++])) return false;
    }
    return *text == '\0' && out->count > 0;
}

static bool read_index(const char *token, size_t *out)
{
    *out = 0;
    if (token[0] == '\0' || strlen(token) > 9 || strspn(token, "0123456789") != strlen(token))
        return false;
    for (; *token; token++) *out = *out * 10 + (size_t)(*token - '0');
    return true;
}

static bool matches(const struct rule *rule, const struct tokens *tokens)
{
    size_t i = 0, ignored;
    for (; i < 6 && rule->pattern[i] != NULL; i++) {
        const char *part = rule->pattern[i];
        if (i >= tokens->count) return false;
        if (strcmp(part, "**") == 0) return true;
        if (strcmp(part, "#") == 0 ? !read_index(tokens->list[i], &ignored)
                                   : strcmp(part, "*") != 0 && strcmp(part, tokens->list[i]) != 0)
            return false;
    }
    return i == tokens->count;
}

/* Returns the member or element of a name; an object of defaults only may be left out. */
static json_t *step(json_t *from, const char *token)
{
    size_t index;
    if (json_is_array(from)) return read_index(token, &index) ? json_array_get(from, index) : NULL;
    json_t *to = json_object_get(from, token);
    if (to != NULL || strcmp(token, "pbrMetallicRoughness") != 0) return to;
    json_object_set_new(from, token, json_object());
    return json_object_get(from, token);
}

static bool is_movable(const json_t *value)
{
    if (json_is_array(value))
        return json_array_size(value) > 0 && json_is_number(json_array_get(value, 0));
    return value == NULL || json_is_number(value) || json_is_boolean(value);
}

/* Walks to the member's holder. False where there is nothing to move. */
static bool walk(json_t *root, const struct tokens *tokens, struct gltf_pointer *out)
{
    json_t *holder = root;
    const char *last = tokens->list[tokens->count - 1];
    for (size_t i = 0; i + 1 < tokens->count; i++) holder = step(holder, tokens->list[i]);
    memcpy(out->key, last, sizeof out->key);
    out->holder = holder;
    /* Which texture and which coordinates: that changes what is decoded, and what vertices have. */
    if (strcmp(last, "index") == 0 || strcmp(last, "texCoord") == 0) return false;
    if (json_is_object(holder)) return is_movable(json_object_get(holder, last));
    return json_is_array(holder) && read_index(last, &out->index) &&
           json_is_number(json_array_get(holder, out->index));
}

/* Returns how many morph targets the mesh has, that is, its first primitive. */
static uint32_t count_targets(const struct gltf *g, const json_t *mesh_index)
{
    if (!json_is_integer(mesh_index) || json_integer_value(mesh_index) < 0) return 0;
    const json_t *mesh =
        json_array_get(json_object_get(g->root, "meshes"), (size_t)json_integer_value(mesh_index));
    const json_t *first = json_array_get(json_object_get(mesh, "primitives"), 0);
    return (uint32_t)json_array_size(json_object_get(first, "targets"));
}

static uint32_t targets_of(const struct gltf *g, const struct tokens *tokens,
                           const struct gltf_pointer *p)
{
    size_t index = 0;
    if (strcmp(tokens->list[0], "nodes") == 0)
        return count_targets(g, json_object_get(p->holder, "mesh"));
    read_index(tokens->list[1], &index);
    json_t *number = json_integer((json_int_t)index);
    const uint32_t count = count_targets(g, number);
    json_decref(number);
    return count;
}

/* Names why a member stays as it is. */
static int leave_out(struct gltf *g, const char *place, const char *text, const char *why,
                     struct gltf_pointer *out)
{
    out->holder = NULL;
    warnings_add(&g->builder->warnings, place, "\"%.100s\" is not animated: %s", text, why);
    return 0;
}

static bool is_part_of_transform(const struct tokens *tokens)
{
    const char *name = tokens->list[tokens->count - 1];
    return strcmp(tokens->list[0], "nodes") == 0 && tokens->count == 3 &&
           strcmp(name, "weights") != 0;
}

int gltf_pointer_find(struct gltf *g, const char *text, const char *place, struct gltf_pointer *out,
                      struct fault *fault)
{
    struct tokens tokens = {0};
    size_t index;
    const struct rule *rule = rules, *end = rules + sizeof rules / sizeof *rules;
    *out = (struct gltf_pointer){0};
    if (!split(text, &tokens))
        return fault_set(fault, ERR_SYNTAX, place, "\"%.100s\" is no JSON pointer", text);
    while (rule < end && !matches(rule, &tokens)) rule++;
    if (rule == end) return leave_out(g, place, text, "only what pictures show is", out);
    if (read_index(tokens.list[1], &index) && index >= gltf_count(g->root, tokens.list[0]))
        return fault_set(fault, ERR_RANGE, place, "%s[%zu] does not exist", tokens.list[0], index);
    if (!walk(g->root, &tokens, out))
        return leave_out(g, place, text, "the document has no such number", out);
    out->width = rule->width;
    out->kind = rule->kind;
    const bool is_weights = tokens.count == 3 && strcmp(tokens.list[2], "weights") == 0 &&
                            strcmp(tokens.list[0], "materials") != 0;
    if (is_weights) out->targets = targets_of(g, &tokens, out);
    if (is_weights && out->targets == 0)
        return leave_out(g, place, text, "the mesh has no morph targets", out);
    if (is_part_of_transform(&tokens) && json_object_get(out->holder, "matrix") != NULL)
        return leave_out(g, place, text, "its node has a matrix", out);
    return 0;
}

static json_t *value_of(const json_t *old, bool is_list, const double *values, uint32_t count)
{
    if (json_is_boolean(old)) return json_boolean(values[0] != 0);
    if (!is_list) return json_real(values[0]);
    json_t *list = json_array();
    for (uint32_t i = 0; i < count; i++)
        if (json_array_append_new(list, json_real(values[i])) != 0) {
            json_decref(list);
            return NULL;
        }
    return list;
}

int gltf_pointer_set(const struct gltf_pointer *p, const double *values, uint32_t count,
                     const char *place, struct fault *fault)
{
    const bool in_object = json_is_object(p->holder);
    const json_t *old =
        in_object ? json_object_get(p->holder, p->key) : json_array_get(p->holder, p->index);
    gltf_place at;
    gltf_place_set(at, "%s.output", place);
    const uint32_t width = p->targets > 0 ? p->targets : p->width;
    if (width > 0 && count != width)
        return fault_set(fault, ERR_TYPE, at, "it has %" PRIu32 " numbers, where %s has %" PRIu32,
                         count, p->key, width);
    json_t *value = value_of(old, count > 1 || p->targets > 0 || json_is_array(old), values, count);
    if (json_is_null(value) || value == NULL)
        return fault_set(fault, ERR_MEMORY, at, "no memory for its value");
    const int failed = in_object ? json_object_set_new(p->holder, p->key, value)
                                 : json_array_set_new(p->holder, p->index, value);
    return failed ? fault_set(fault, ERR_MEMORY, at, "no memory for its value") : 0;
}
