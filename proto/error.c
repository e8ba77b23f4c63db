#include "proto/error.h"

#include <errno.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>

const char *error_name(int code)
{
    switch (code) {
#define ERROR(name, number, text)                                                                  \
    case number:                                                                                   \
        return #name;
#include "proto/error.def"
#undef ERROR
    default:
        return "UNKNOWN";
    }
}

int error_of_errno(int number)
{
    if (number == ENOMEM) return ERR_MEMORY;
    return number == ENOSPC || number == EDQUOT ? ERR_NO_SPACE : ERR_IO;
}

const char *error_text(int code)
{
    switch (code) {
#define ERROR(name, number, text)                                                                  \
    case number:                                                                                   \
        return text;
#include "proto/error.def"
#undef ERROR
    default:
        return "an unknown error";
    }
}

/* Faults travel in JSON: where snprintf cut a text, half a UTF-8 character must not stay behind.
 * `length` is what the whole text would have had. */
static void trim_cut(char *text, size_t capacity, int length)
{
    if (length < 0 || (size_t)length < capacity) return;
    size_t last = capacity - 1; /* of the last character's first byte, in the end */
    while (last > 0 && capacity - last < 5 && ((unsigned char)text[last - 1] & 0xc0) == 0x80)
        last--;
    if (last == 0 || (unsigned char)text[last - 1] < 0xc0) return;
    unsigned char lead = (unsigned char)text[last - 1];
    size_t needed = lead < 0xe0 ? 2 : lead < 0xf0 ? 3 : 4;
    if (capacity - last < needed) text[last - 1] = '\0';
}

int fault_set(struct fault *fault, int code, const char *pointer, const char *format, ...)
{
    if (fault == NULL) return code;
    fault->code = code;
    int length =
        snprintf(fault->pointer, sizeof fault->pointer, "%s", pointer != NULL ? pointer : "");
    trim_cut(fault->pointer, sizeof fault->pointer, length);
    va_list arguments;
    va_start(arguments, format);
    length = vsnprintf(fault->detail, sizeof fault->detail, format, arguments);
    va_end(arguments);
    if (length < 0) snprintf(fault->detail, sizeof fault->detail, "%s", error_text(code));
    trim_cut(fault->detail, sizeof fault->detail, length);
    return code;
}
