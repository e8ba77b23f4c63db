#include "proto/error.h"

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

int fault_set(struct fault *fault, int code, const char *pointer, const char *format, ...)
{
    if (fault == NULL) return code;
    fault->code = code;
    snprintf(fault->pointer, sizeof fault->pointer, "%s", pointer != NULL ? pointer : "");
    va_list arguments;
    va_start(arguments, format);
    int written = vsnprintf(fault->detail, sizeof fault->detail, format, arguments);
    va_end(arguments);
    if (written < 0) snprintf(fault->detail, sizeof fault->detail, "%s", error_text(code));
    return code;
}
