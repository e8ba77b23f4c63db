#include "tests/unit/import/scene_room.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

char room[64];
struct scene_choice room_choice;
struct warnings room_warnings;
struct fault room_fault;
struct import_stats room_stats;

int room_open(void **state)
{
    (void)state;
    snprintf(room, sizeof room, "/tmp/test_import.XXXXXX");
    return mkdtemp(room) == NULL ? -1 : 0;
}

int room_close(void **state)
{
    (void)state;
    char command[128];
    snprintf(command, sizeof command, "rm -rf %s", room);
    return system(command);
}

void room_write(const char *name, const void *data, size_t size_bytes)
{
    char path[256];
    snprintf(path, sizeof path, "%s/%s", room, name);
    FILE *f = fopen(path, "wb");
    assert_non_null(f);
    assert_int_equal(fwrite(data, 1, size_bytes, f), size_bytes);
    fclose(f);
}

int room_import_blob(const char *name, char path[256])
{
    snprintf(path, 256, "%s/out.blob", room);
    unlink(path);
    memset(&room_fault, 0, sizeof room_fault);
    int rc = import_scene(room, name, &room_choice, path, &room_warnings, &room_stats, &room_fault);
    if (rc == 0) return 0;
    assert_int_not_equal(access(path, F_OK), 0); /* nothing half-done is left */
    assert_int_equal(room_fault.code, rc);
    return rc;
}

/* The same of a scene. On success the caller calls scene_unmap. */
static int room_import(const char *name, struct scene *out)
{
    char path[256];
    int rc = room_import_blob(name, path);
    if (rc == 0) assert_int_equal(scene_map(path, out, NULL), 0);
    return rc;
}

int room_import_text(const char *name, const char *text, struct scene *out)
{
    room_write(name, text, strlen(text));
    return room_import(name, out);
}

void room_refuses(const char *name, const char *text, int code, const char *pointer)
{
    struct scene scene;
    int rc = room_import_text(name, text, &scene);
    if (rc != code || strcmp(room_fault.pointer, pointer) != 0)
        print_error("%s at %s: %s\n", error_name(rc), room_fault.pointer, room_fault.detail);
    assert_int_equal(rc, code);
    assert_string_equal(room_fault.pointer, pointer);
}

bool room_warned(const char *part)
{
    for (uint32_t i = 0; i < room_warnings.count; i++)
        if (strstr(room_warnings.list[i].sentence, part) != NULL) return true;
    return false;
}
