#include "proto/scene/matte.h"

#include <stdio.h>
#include <string.h>

static uint32_t turn(uint32_t x, unsigned by)
{
    return x << by | x >> (32 - by);
}

static uint32_t scramble(uint32_t k)
{
    return turn(k * 0xcc9e2d51u, 15) * 0x1b873593u;
}

/* Returns up to four bytes as a little-endian number. */
static uint32_t word_of(const char *text, size_t count)
{
    uint32_t k = 0;
    for (size_t i = 0; i < count; i++) k |= (uint32_t)(uint8_t)text[i] << 8 * i;
    return k;
}

uint32_t matte_hash(const char *text)
{
    const size_t length = strlen(text), rest = length % 4;
    uint32_t h = 0;
    for (size_t i = 0; i < length - rest; i += 4)
        h = turn(h ^ scramble(word_of(text + i, 4)), 13) * 5 + 0xe6546b64u;
    if (rest > 0) h ^= scramble(word_of(text + length - rest, rest));
    h ^= (uint32_t)length;
    h = (h ^ h >> 16) * 0x85ebca6bu;
    h = (h ^ h >> 13) * 0xc2b2ae35u;
    return h ^ h >> 16;
}

uint32_t matte_id(const char *name)
{
    const uint32_t hash = matte_hash(name), exponent = hash >> 23 & 255u;
    return exponent == 0 || exponent == 255 ? hash ^ 1u << 23 : hash;
}

const char *matte_name(const struct scene *scene, enum matte_kind kind, uint32_t instance,
                       char room[32])
{
    const struct scene_instance *at = &scene->instances[instance];
    const struct scene_mesh *mesh = &scene->meshes[at->mesh];
    const char *name = kind == MATTE_MATERIAL
                           ? scene_name(scene, scene->materials[mesh->material].name)
                           : scene_name(scene, at->name ? at->name : mesh->name);
    if (*name) return name;
    snprintf(room, 32, kind == MATTE_MATERIAL ? "material %u" : "object %u",
             kind == MATTE_MATERIAL ? mesh->material : instance);
    return room;
}
