#pragma once
/* Environment maps, imported from files of the room. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "proto/scene/environment.h"
#include "tests/unit/import/scene_room.h"
#include "tests/unit/unit.h"

static struct environment_blob map;

static inline int import_map(const char *name)
{
    char path[256];
    int rc = room_import_blob(name, path);
    if (rc != 0) {
        assert_true(room_fault.detail[0] != '\0');
        return rc;
    }
    assert_int_equal(environment_map(path, &map, NULL), 0);
    assert_int_equal(room_stats.width_px, map.header->width_px);
    assert_int_equal(room_stats.height_px, map.header->height_px);
    assert_int_equal(room_stats.triangles, 0);
    return 0;
}

static inline void must_import(const char *name)
{
    if (import_map(name) != 0) fail_msg("%s: %s", room_fault.pointer, room_fault.detail);
}

static inline const float *texel(uint32_t x, uint32_t y)
{
    return map.texels + 3 * ((size_t)y * map.header->width_px + x);
}

static char bytes[1 << 16];
static size_t byte_count;

static inline int import_bytes(const char *name)
{
    room_write(name, bytes, byte_count);
    return import_map(name);
}

/* Imports a file of the folder of scenes from a copy in the room. */
static inline void import_copy(const char *name, char path[UNIT_PATH_BYTES])
{
    const char *base = strrchr(name, '/') + 1;
    char command[2 * UNIT_PATH_BYTES];
    scene_path(name, path);
    snprintf(command, sizeof command, "cp '%s' '%s'", path, room);
    assert_int_equal(system(command), 0);
    must_import(base);
}
