#include "server/access/tokens.h"

#include <gnutls/crypto.h>
#include <gnutls/gnutls.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "proto/json.h"
#include "proto/runtime/secret_file.h"

#define TOKEN_RANDOM_BYTES 32u
#define TOKEN_PREFIX       "sw_"
#define TOKEN_LETTERS                                                                              \
    "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-._~+/=" /* RFC 6750, 2.1 */
#define TOKEN_MIN_BYTES 20u
#define TOKEN_MAX_BYTES 256u

static const char *const role_names[ROLE_COUNT] = {"none", "viewer", "submitter", "admin"};

const char *role_name(enum role role)
{
    return role_names[role];
}

bool role_from_name(const char *name, enum role *out)
{
    for (int i = ROLE_VIEWER; i < ROLE_COUNT; i++)
        if (strcmp(name, role_names[i]) == 0) {
            *out = (enum role)i;
            return true;
        }
    return false;
}

/* ---- reading ---- */

static int read_name(struct json_cursor *at, const struct json_member *m, const json_t *v, void *o)
{
    char *out = (char *)o + m->offset;
    const char *text = json_string_value(v);
    size_t n = text ? strspn(text, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789"
                                   "-_.")
                    : 0;
    if (n == 0 || n >= TOKEN_NAME_BYTES || text[n])
        return json_cursor_refuse(at, ERR_RANGE, "a name has 1 to 64 of a-z, A-Z, 0-9, -, _ and .");
    memcpy(out, text, n + 1);
    return 0;
}

bool tokens_is_tenant(const char *text)
{
    const size_t n = strspn(text, "abcdefghijklmnopqrstuvwxyz0123456789-_");
    return n > 0 && n < JOB_OWNER_BYTES && text[n] == '\0';
}

static int read_tenant(struct json_cursor *at, const struct json_member *m, const json_t *v,
                       void *o)
{
    const char *text = json_string_value(v);
    if (!text || !tokens_is_tenant(text))
        return json_cursor_refuse(at, ERR_RANGE, "a tenant has 1 to 64 of a-z, 0-9, - and _");
    memcpy((char *)o + m->offset, text, strlen(text) + 1);
    return 0;
}

static int read_role(struct json_cursor *at, const struct json_member *m, const json_t *v, void *o)
{
    const char *text = json_string_value(v);
    if (!text || !role_from_name(text, (enum role *)(void *)((char *)o + m->offset)))
        return json_cursor_refuse(at, ERR_RANGE,
                                  "a role is viewer, submitter or admin (workers prove themselves "
                                  "by their link's key: serve --worker-key)");
    return 0;
}

static int read_hash(struct json_cursor *at, const struct json_member *m, const json_t *v, void *o)
{
    return json_cursor_digest(at, v, (struct digest *)(void *)((char *)o + m->offset));
}

static const struct json_member token_members[] = {
    {.name = "name", .read = read_name, .offset = offsetof(struct token, name), .required = true},
    {.name = "tenant",
     .read = read_tenant,
     .offset = offsetof(struct token, tenant),
     .required = true},
    {.name = "role", .read = read_role, .offset = offsetof(struct token, role), .required = true},
    {.name = "sha256", .read = read_hash, .offset = offsetof(struct token, hash), .required = true},
    {0},
};

/* Tokens of one name could not be told apart by people, nor tokens of one hash by the server. */
static int check_alone(struct json_cursor *at, const struct tokens *tokens)
{
    const struct token *last = &tokens->list[tokens->count];
    for (size_t i = 0; i < tokens->count; i++) {
        if (strcmp(tokens->list[i].name, last->name) == 0)
            return json_cursor_refuse_member(at, "name", ERR_EXISTS, "%s is there already",
                                             last->name);
        if (digest_equal(&tokens->list[i].hash, &last->hash))
            return json_cursor_refuse_member(at, "sha256", ERR_EXISTS, "the token of %s again",
                                             tokens->list[i].name);
    }
    return 0;
}

static int read_list(struct json_cursor *at, const json_t *list, struct tokens *tokens)
{
    size_t i;
    json_t *value;
    int error = 0;
    json_array_foreach (list, i, value) {
        const size_t outside = json_cursor_enter_index(at, i);
        error = json_cursor_members(at, value, token_members, &tokens->list[i]);
        if (!error) error = check_alone(at, tokens);
        if (error) break;
        tokens->count++;
        json_cursor_leave(at, outside);
    }
    return error;
}

static int read_weight(struct json_cursor *at, const char *tenant, const json_t *value,
                       struct tokens *tokens)
{
    const json_t *weight = json_object_get(value, "weight");
    const json_int_t number = json_integer_value(weight);
    bool known = false;
    if (json_object_size(value) != 1 || !json_is_integer(weight) || number < 1 ||
        number > TENANT_WEIGHT_MAX)
        return json_cursor_refuse(at, ERR_RANGE, "expected {\"weight\": 1 to %d}",
                                  TENANT_WEIGHT_MAX);
    for (size_t i = 0; i < tokens->count; i++)
        if (strcmp(tokens->list[i].tenant, tenant) == 0) {
            tokens->list[i].weight = (uint32_t)number;
            known = true;
        }
    return known ? 0 : json_cursor_refuse(at, ERR_NOT_FOUND, "no token is of this tenant");
}

static int read_tenants(struct json_cursor *at, json_t *tenants, struct tokens *tokens)
{
    const char *name;
    json_t *value;
    int error = 0;
    for (size_t i = 0; i < tokens->count; i++) tokens->list[i].weight = 1;
    if (!tenants) return 0;
    const size_t outside = json_cursor_enter(at, "tenants");
    if (!json_is_object(tenants))
        return json_cursor_refuse(at, ERR_TYPE, "expected an object of tenants");
    json_object_foreach (tenants, name, value) {
        const size_t here = json_cursor_enter(at, name);
        error = read_weight(at, name, value, tokens);
        if (error) return error;
        json_cursor_leave(at, here);
    }
    json_cursor_leave(at, outside);
    return 0;
}

/* The document's list of tokens. */
static int list_of(struct json_cursor *at, const json_t *root, json_t **list)
{
    *list = json_object_get(root, "tokens");
    const size_t members = json_object_get(root, "tenants") ? 2 : 1;
    if (!json_is_object(root) || json_object_size(root) != members || !json_is_array(*list))
        return json_cursor_refuse(
            at, ERR_TYPE, "expected {\"tokens\": [...], \"tenants\": {...}} and nothing else");
    if (json_array_size(*list) > LIMIT_TOKENS)
        return json_cursor_refuse(at, ERR_LIMIT, "at most %d tokens are taken", LIMIT_TOKENS);
    return 0;
}

static int read_document(const json_t *root, struct tokens **out, struct fault *fault)
{
    struct json_cursor at;
    json_t *list;
    json_cursor_init(&at, fault);
    int error = list_of(&at, root, &list);
    if (error) return error;
    struct tokens *tokens =
        calloc(1, sizeof *tokens + (json_array_size(list) + 1) * sizeof(struct token));
    if (!tokens) return fault_set(fault, ERR_MEMORY, "", "memory is exhausted");
    const size_t outside = json_cursor_enter(&at, "tokens");
    error = read_list(&at, list, tokens);
    json_cursor_leave(&at, outside);
    if (!error) error = read_tenants(&at, json_object_get(root, "tenants"), tokens);
    if (error)
        free(tokens);
    else
        *out = tokens;
    return error;
}

/* The place in the document behind the file's name, which is what people look for first. */
static void name_file(struct fault *fault, const char *path)
{
    struct fault inner = *fault;
    fault_set(fault, inner.code, path, "%s%s%s", inner.pointer, inner.pointer[0] ? ": " : "",
              inner.detail[0] ? inner.detail : error_text(inner.code));
}

static int read_json(const char *path, json_t **out, struct fault *fault)
{
    char *text = NULL;
    size_t size_bytes = 0;
    int error = secret_file_read(path, SECRET_READERS_GROUP, LIMIT_TOKENS_FILE_BYTES, &text,
                                 &size_bytes, fault);
    if (error) return error;
    error = json_read(text, size_bytes, LIMIT_TOKENS_FILE_BYTES, out, fault);
    free(text);
    if (error) name_file(fault, path);
    return error;
}

int tokens_read(const char *path, struct tokens **out, struct fault *fault)
{
    json_t *root = NULL;
    *out = NULL;
    int error = read_json(path, &root, fault);
    if (error) return error;
    error = read_document(root, out, fault);
    if (error) name_file(fault, path);
    json_decref(root);
    return error;
}

/* ---- finding ---- */

const struct token *tokens_find_hash(const struct tokens *tokens, const struct digest *hash)
{
    const struct token *found = NULL;
    for (size_t i = 0; i < tokens->count; i++)
        if (gnutls_memcmp(tokens->list[i].hash.bytes, hash->bytes, DIGEST_BYTES) == 0)
            found = &tokens->list[i];
    return found;
}

bool tokens_is_text(const char *text, size_t size_bytes)
{
    if (size_bytes < TOKEN_MIN_BYTES || size_bytes > TOKEN_MAX_BYTES) return false;
    for (size_t i = 0; i < size_bytes; i++)
        if (!memchr(TOKEN_LETTERS, text[i], sizeof TOKEN_LETTERS - 1)) return false;
    return true;
}

const struct token *tokens_find(const struct tokens *tokens, const char *text, size_t size_bytes)
{
    struct digest hash;
    if (!tokens_is_text(text, size_bytes)) return NULL;
    digest_of(text, size_bytes, &hash);
    return tokens_find_hash(tokens, &hash);
}

/* ---- making ---- */

int tokens_make(char out[TOKEN_TEXT_BYTES])
{
    uint8_t random[TOKEN_RANDOM_BYTES];
    if (gnutls_rnd(GNUTLS_RND_KEY, random, sizeof random) != 0) return ERR_IO;
    char *end = stpcpy(out, TOKEN_PREFIX);
    for (size_t i = 0; i < sizeof random; i++) end += sprintf(end, "%02x", random[i]);
    gnutls_memset(random, 0, sizeof random);
    return 0;
}

static json_t *token_json(const struct token *token)
{
    char hex[DIGEST_HEX_BYTES];
    digest_to_hex(&token->hash, hex);
    return json_pack("{s:s, s:s, s:s, s:s}", "name", token->name, "tenant", token->tenant, "role",
                     role_name(token->role), "sha256", hex);
}

/* What the new file says must be readable by the rules, or the old one stays. */
static int write_checked(const char *path, json_t *root, struct fault *fault)
{
    struct tokens *tokens = NULL;
    int error = read_document(root, &tokens, fault);
    free(tokens);
    if (error) {
        name_file(fault, path);
        return error;
    }
    char *text = json_text(root, JSON_INDENT(2));
    if (!text) return fault_set(fault, ERR_MEMORY, path, "memory is exhausted");
    error = secret_file_write(path, text, strlen(text), fault);
    free(text);
    return error;
}

int tokens_add(const char *path, const struct token *token, struct fault *fault)
{
    json_t *root = NULL;
    int error = read_json(path, &root, fault);
    if (error == ERR_NOT_FOUND) {
        root = json_pack("{s:[]}", "tokens");
        error = root ? 0 : fault_set(fault, ERR_MEMORY, path, "memory is exhausted");
    }
    if (error) return error;
    json_t *list = json_object_get(root, "tokens");
    if (!json_is_array(list) || json_array_append_new(list, token_json(token)) != 0)
        error = fault_set(fault, ERR_TYPE, path, "expected {\"tokens\": [...]}");
    if (!error) error = write_checked(path, root, fault);
    json_decref(root);
    return error;
}
