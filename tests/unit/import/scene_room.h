#pragma once
/* A folder of its own for a test's scene files, and the way from a file to an open blob. */
#include <stdbool.h>

#include "server/import/import.h"
#include "tests/unit/unit.h"

extern char room[64];
extern struct scene_choice room_choice; /* what is imported; zero: the file as it is */
extern struct warnings room_warnings;
extern struct fault room_fault;
extern struct import_stats room_stats;
int room_open(void **state);
int room_close(void **state);
void room_write(const char *name, const void *data, size_t size_bytes);

/* Imports a file that is there; `path` becomes the blob's. */
int room_import_blob(const char *name, char path[256]);

int room_import_text(const char *name, const char *text, struct scene *out);

/* Expects a failure at a place. */
void room_refuses(const char *name, const char *text, int code, const char *pointer);

bool room_warned(const char *part);
