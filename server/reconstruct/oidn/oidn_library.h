#pragma once
/* Open Image Denoise 2 (Afra, github.com/RenderKit/oidn), where a machine has it. The library is
 * loaded at run time, and nothing needs it. What is called is of its header oidn.h, whose
 * enumerations are ints here. */
#include <stdbool.h>
#include <stddef.h>

#include "proto/error.h"

#define OIDN_LIBRARY     "libOpenImageDenoise.so.2"
#define OIDN_LABEL_BYTES 40

/* X(type, Name, (arguments)): the functions, each called oidnName. Devices and filters are
 * pointers of no known type. */
#define OIDN_FUNCTIONS(X)                                                                          \
    X(void *, NewDevice, (int type))                                                               \
    X(void, SetDeviceInt, (void *device, const char *name, int value))                             \
    X(void, SetDeviceBool, (void *device, const char *name, bool value))                           \
    X(int, GetDeviceInt, (void *device, const char *name))                                         \
    X(int, GetDeviceError, (void *device, const char **message))                                   \
    X(void, CommitDevice, (void *device))                                                          \
    X(void, ReleaseDevice, (void *device))                                                         \
    X(void *, NewFilter, (void *device, const char *type))                                         \
    X(void, SetSharedFilterImage,                                                                  \
      (void *filter, const char *name, void *pixels, int format, size_t width, size_t height,      \
       size_t offset_bytes, size_t pixel_bytes, size_t row_bytes))                                 \
    X(void, SetFilterBool, (void *filter, const char *name, bool value))                           \
    X(void, SetFilterInt, (void *filter, const char *name, int value))                             \
    X(void, SetFilterProgressMonitorFunction,                                                      \
      (void *filter, bool (*go_on)(void *ctx, double share), void *ctx))                           \
    X(void, CommitFilter, (void *filter))                                                          \
    X(void, ExecuteFilter, (void *filter))                                                         \
    X(void, ReleaseFilter, (void *filter))

enum oidn_error { OIDN_ERROR_NONE = 0, OIDN_ERROR_OUT_OF_MEMORY = 4 };

struct oidn_library {
    void *handle;                 /* owned; of dlopen */
    char label[OIDN_LABEL_BYTES]; /* "Open Image Denoise 2.3.1" */
#define OIDN_MEMBER(type, name, arguments) type(*name) arguments;
    OIDN_FUNCTIONS(OIDN_MEMBER)
#undef OIDN_MEMBER
};

/* Loads a library by its name or path. ERR_UNSUPPORTED, with a sentence in *fault, where it is not
 * there, lacks a function, is not of version 2, or has no device for this CPU. */
int oidn_library_open(const char *name, struct oidn_library *out, struct fault *fault);
void oidn_library_close(struct oidn_library *library);

/* Returns this machine's, which the first call loads for as long as the process runs; NULL with
 * the same *fault in each call if that fails. For any thread. */
const struct oidn_library *oidn_library_get(struct fault *fault);

/* Returns a device that is ready, with one thread; NULL with *fault. The caller releases it. */
void *oidn_library_device(const struct oidn_library *library, struct fault *fault);

/* Checks whether a device, or NULL where none could be made, tells of an error since the last call.
 * ERR_MEMORY, or ERR_UNSUPPORTED, with its sentence in *fault. */
int oidn_library_check(const struct oidn_library *library, void *device, struct fault *fault);
