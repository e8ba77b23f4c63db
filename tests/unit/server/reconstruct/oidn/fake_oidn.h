#pragma once
/* The library that misbehaves as it is told to (tests/fake/oidn), built beside the unit tests. */
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "server/reconstruct/oidn/oidn_library.h"
#include "tests/unit/unit.h"

/* Writes the path of BUILD_DIR/tests/oidn/WHICH's library. */
static inline void fake_oidn_path(const char *which, char path[UNIT_PATH_BYTES])
{
    static const char here[] = "/unit/";
    const ssize_t length = readlink("/proc/self/exe", path, UNIT_PATH_BYTES - 1);
    assert_true(length > 0);
    path[length] = '\0';
    char *end = strstr(path, here);
    assert_non_null(end);
    snprintf(end, UNIT_PATH_BYTES - (size_t)(end - path), "/oidn/%s/" OIDN_LIBRARY, which);
}

/* Opens it with the behaviour that FAKE_OIDN is to name. */
static inline int fake_oidn_open(const char *which, const char *behaviour, struct oidn_library *out,
                                 struct fault *fault)
{
    char path[UNIT_PATH_BYTES];
    fake_oidn_path(which, path);
    setenv("FAKE_OIDN", behaviour, 1);
    return oidn_library_open(path, out, fault);
}
