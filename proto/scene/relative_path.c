#include "proto/scene/relative_path.h"

#include <stddef.h>
#include <string.h>

#include "proto/limits.h"

static bool part_is_plain(const char *part, size_t length)
{
    if (length == 0) return false;
    if (length == 1 && part[0] == '.') return false;
    return !(length == 2 && part[0] == '.' && part[1] == '.');
}

static bool character_is_plain(char c)
{
    const unsigned char byte = (unsigned char)c;
    return byte >= 0x20 && byte != 0x7f && c != '\\';
}

bool relative_path_is_inside(const char *path)
{
    if (strlen(path) >= LIMIT_PATH_BYTES) return false;
    for (const char *c = path; *c; c++)
        if (!character_is_plain(*c)) return false;
    for (;;) {
        const size_t length = strcspn(path, "/");
        if (!part_is_plain(path, length)) return false;
        if (path[length] == '\0') return true;
        path += length + 1;
    }
}
