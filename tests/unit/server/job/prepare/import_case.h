#pragma once
/* Files of a scene among the objects, and shell scripts in the importer's place. */
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

#include "server/store/objects.h"
#include "tests/unit/unit.h"

/* Stores a text; nobody holds it. */
static inline void import_case_put(const struct objects *objects, const char *text,
                                   struct digest *out)
{
    struct object_writer *writer = NULL;
    bool existed;
    assert_int_equal(object_writer_begin(objects, &writer), 0);
    assert_int_equal(object_writer_append(writer, text, strlen(text)), 0);
    assert_int_equal(object_writer_finish(&writer, NULL, out, &existed), 0);
    objects_release(objects, out);
}

/* An importer, which is called with --root $2 --in $4 --out $6. */
static inline void import_case_write(const char *path, const char *script)
{
    FILE *f = fopen(path, "w");
    assert_non_null(f);
    fprintf(f, "#!/bin/sh\nroot=$2 name=$4 blob=$6\n%s\n", script);
    fclose(f);
    assert_int_equal(chmod(path, 0700), 0);
}
