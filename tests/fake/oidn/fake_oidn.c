/* A libOpenImageDenoise.so.2 that misbehaves on purpose. FAKE_OIDN says how:
 *   same      it gives all light back as it is
 *   half      it gives half of the light back (also without a word)
 *   guides    the same, but the first pixel's albedo and normal stand in the next two
 *   slow      the same, and it takes four seconds to load
 *   version   it is of version 1.4.3
 *   device    its device does not commit
 *   nowhere   it makes no device
 *   filter    it makes no filter, and tells no reason
 *   execute   it fails while it filters
 *   memory    it runs out of memory once, then gives half of the light
 *   nan       some of its numbers are none
 *   negative  its light is below zero
 * Built with FAKE_OIDN_LACKS it has no oidnSetFilterBool, as of version 1. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "tests/bench/oidn/oidn.h"

struct fake_filter {
    float *images[4]; /* color, albedo, normal, output */
    size_t pixels;
};

static _Thread_local int error;
static _Thread_local const char *reason;

static bool does(const char *what)
{
    const char *word = getenv("FAKE_OIDN");
    return strcmp(word && *word ? word : "half", what) == 0;
}

__attribute__((constructor)) static void load(void)
{
    if (does("slow")) sleep(4);
}

static void fail(int code, const char *text)
{
    error = code;
    reason = text;
}

void *oidnNewDevice(int type)
{
    static char device;
    if (does("nowhere") || type != 1) fail(OIDN_UNSUPPORTED_HARDWARE, "this CPU is too old");
    return error ? NULL : &device;
}

void oidnSetDeviceInt(void *device, const char *name, int value)
{
    (void)device, (void)name, (void)value;
}

void oidnSetDeviceBool(void *device, const char *name, bool value)
{
    (void)device, (void)name, (void)value;
}

int oidnGetDeviceInt(void *device, const char *name)
{
    (void)device, (void)name;
    return does("version") ? 10403 : 20399;
}

int oidnGetDeviceError(void *device, const char **message)
{
    const int code = error;
    (void)device;
    *message = code ? reason : NULL;
    error = 0;
    return code;
}

void oidnCommitDevice(void *device)
{
    (void)device;
    if (does("device")) fail(OIDN_UNSUPPORTED_HARDWARE, "the device is out of order");
}

void oidnReleaseDevice(void *device)
{
    (void)device;
}

void *oidnNewFilter(void *device, const char *type)
{
    (void)device, (void)type;
    return does("filter") ? NULL : calloc(1, sizeof(struct fake_filter));
}

void oidnSetSharedFilterImage(void *filter, const char *name, void *pixels, int format,
                              size_t width, size_t height, size_t offset_bytes, size_t pixel_bytes,
                              size_t row_bytes)
{
    static const char *const names[] = {"color", "albedo", "normal", "output"};
    struct fake_filter *f = filter;
    const bool fits = format == 3 && offset_bytes == 0 && pixel_bytes == 3 * sizeof(float) &&
                      row_bytes == width * pixel_bytes;
    if (!fits) fail(OIDN_INVALID_ARGUMENT, "pixels are packed float3");
    for (int i = 0; i < 4; i++)
        if (strcmp(name, names[i]) == 0) f->images[i] = pixels;
    f->pixels = width * height;
}

#ifndef FAKE_OIDN_LACKS
void oidnSetFilterBool(void *filter, const char *name, bool value)
{
    (void)filter;
    if (strcmp(name, "hdr") != 0 || !value) fail(OIDN_INVALID_ARGUMENT, "hdr is wanted");
}
#endif

void oidnSetFilterInt(void *filter, const char *name, int value)
{
    (void)filter;
    if (strcmp(name, "maxMemoryMB") != 0 || value < 64) fail(OIDN_INVALID_ARGUMENT, "of memory");
}

void oidnSetFilterProgressMonitorFunction(void *filter, bool (*go_on)(void *, double), void *ctx)
{
    (void)filter;
    if (!go_on(ctx, 0.0)) fail(OIDN_CANCELLED, "it was cancelled");
}

void oidnCommitFilter(void *filter)
{
    const struct fake_filter *f = filter;
    for (int i = 0; i < 4; i++)
        if (!f->images[i]) fail(OIDN_INVALID_OPERATION, "an image is missing");
}

static void show_guides(const struct fake_filter *f)
{
    for (size_t c = 0; c < 6 && f->pixels >= 3; c++)
        f->images[3][3 + c] = f->images[1 + c / 3][c % 3];
}

void oidnExecuteFilter(void *filter)
{
    static bool was_short;
    const struct fake_filter *f = filter;
    const float by = does("negative") ? -1.0f : does("same") ? 1.0f : 0.5f;
    if (does("execute")) fail(OIDN_INVALID_OPERATION, "it was asked to fail");
    if (does("memory") && !was_short) {
        was_short = true;
        fail(OIDN_OUT_OF_MEMORY, "there is no memory");
    }
    if (error) return;
    for (size_t i = 0; i < 3 * f->pixels; i++) f->images[3][i] = by * f->images[0][i];
    if (does("nan")) f->images[3][0] = NAN;
    if (does("guides")) show_guides(f);
}

void oidnReleaseFilter(void *filter)
{
    free(filter);
}
