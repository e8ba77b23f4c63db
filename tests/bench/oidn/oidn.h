#pragma once
/* The functions of Open Image Denoise 2 that server/reconstruct/oidn calls, as its header oidn.h
 * has them. Devices and filters are pointers of no known type, enumerations are ints. */
#include <stdbool.h>
#include <stddef.h>

enum {
    OIDN_INVALID_ARGUMENT = 2,
    OIDN_INVALID_OPERATION = 3,
    OIDN_OUT_OF_MEMORY = 4,
    OIDN_UNSUPPORTED_HARDWARE = 5,
    OIDN_CANCELLED = 6
};

#define OIDN_EXPORT __attribute__((visibility("default")))
OIDN_EXPORT void *oidnNewDevice(int type);
OIDN_EXPORT void oidnSetDeviceInt(void *device, const char *name, int value);
OIDN_EXPORT void oidnSetDeviceBool(void *device, const char *name, bool value);
OIDN_EXPORT int oidnGetDeviceInt(void *device, const char *name);
OIDN_EXPORT int oidnGetDeviceError(void *device, const char **message);
OIDN_EXPORT void oidnCommitDevice(void *device);
OIDN_EXPORT void oidnReleaseDevice(void *device);
OIDN_EXPORT void *oidnNewFilter(void *device, const char *type);
OIDN_EXPORT void oidnSetSharedFilterImage(void *filter, const char *name, void *pixels, int format,
                                          size_t width, size_t height, size_t offset_bytes,
                                          size_t pixel_bytes, size_t row_bytes);
OIDN_EXPORT void oidnSetFilterBool(void *filter, const char *name, bool value);
OIDN_EXPORT void oidnSetFilterInt(void *filter, const char *name, int value);
OIDN_EXPORT void oidnSetFilterProgressMonitorFunction(void *filter, bool (*go_on)(void *, double),
                                                      void *ctx);
OIDN_EXPORT void oidnCommitFilter(void *filter);
OIDN_EXPORT void oidnExecuteFilter(void *filter);
OIDN_EXPORT void oidnReleaseFilter(void *filter);
