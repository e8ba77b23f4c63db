/* A libOpenImageDenoise.so.2 for tests: the functions of Open Image Denoise's oidn.h that
 * server/reconstruct/oidn calls, by our own reading of its network (../unet). It filters as that
 * library does, with weights from the file that SHEARWATER_PEER_WEIGHTS names, and makes no device
 * without them. Pictures have all guides, and are of high dynamic range. */
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/bench/oidn/oidn.h"
#include "tests/bench/unet/denoise.h"

#define FORMAT_FLOAT3 3

struct device {
    struct network network;
    int threads;
    int error;
    char message[LIMIT_DETAIL_BYTES];
};

/* color, albedo, normal, output */
struct filter_image {
    unsigned char *pixels;
    size_t pixel_bytes, row_bytes;
};
static const char *const image_names[] = {"color", "albedo", "normal", "output"};
#define IMAGES 4

struct filter {
    struct device *device;
    size_t width, height;
    struct filter_image images[IMAGES];
    bool (*go_on)(void *ctx, double share);
    void *ctx;
};

/* Of what happens before there is a device. */
static _Thread_local struct device nobody;

static void fail(struct device *device, int error, const char *message)
{
    if (device->error) return;
    device->error = error;
    snprintf(device->message, sizeof device->message, "%s", message);
}

void *oidnNewDevice(int type)
{
    struct device *device = calloc(1, sizeof *device);
    if (device && type == 1) return device;
    free(device);
    fail(&nobody, OIDN_INVALID_ARGUMENT, "only CPUs");
    return NULL;
}

void oidnSetDeviceInt(void *device, const char *name, int value)
{
    if (strcmp(name, "numThreads") == 0) ((struct device *)device)->threads = value;
}

void oidnSetDeviceBool(void *device, const char *name, bool value)
{
    (void)device, (void)name, (void)value;
}

int oidnGetDeviceInt(void *device, const char *name)
{
    (void)device;
    return strcmp(name, "version") == 0 ? 20300 : 0;
}

int oidnGetDeviceError(void *device, const char **message)
{
    static _Thread_local char told[LIMIT_DETAIL_BYTES];
    struct device *d = device ? device : &nobody;
    const int error = d->error;
    memcpy(told, d->message, sizeof told);
    if (message) *message = error ? told : NULL;
    d->error = 0;
    return error;
}

void oidnCommitDevice(void *device)
{
    struct device *d = device;
    const char *path = getenv("SHEARWATER_PEER_WEIGHTS");
    struct tza tza;
    struct fault fault = {0};
    if (!path || !*path) {
        fail(d, OIDN_INVALID_OPERATION, "SHEARWATER_PEER_WEIGHTS names no weights");
        return;
    }
    int error = tza_read(path, &tza, &fault);
    if (!error) error = network_init(&d->network, &tza, &fault);
    tza_fini(&tza);
    network_set_threads(&d->network, d->threads);
    if (error) fail(d, OIDN_INVALID_OPERATION, fault.detail);
}

void oidnReleaseDevice(void *device)
{
    network_fini(&((struct device *)device)->network);
    free(device);
}

void *oidnNewFilter(void *device, const char *type)
{
    struct filter *filter = strcmp(type, "RT") == 0 ? calloc(1, sizeof *filter) : NULL;
    if (filter)
        filter->device = device;
    else
        fail(device, OIDN_INVALID_ARGUMENT, "no such filter");
    return filter;
}

void oidnSetSharedFilterImage(void *filter, const char *name, void *pixels, int format,
                              size_t width, size_t height, size_t offset_bytes, size_t pixel_bytes,
                              size_t row_bytes)
{
    struct filter *f = filter;
    f->width = width;
    f->height = height;
    if (format != FORMAT_FLOAT3) fail(f->device, OIDN_INVALID_ARGUMENT, "pixels are float3");
    for (int i = 0; i < IMAGES; i++)
        if (strcmp(name, image_names[i]) == 0)
            f->images[i] = (struct filter_image){(unsigned char *)pixels + offset_bytes,
                                                 pixel_bytes, row_bytes};
}

void oidnSetFilterBool(void *filter, const char *name, bool value)
{
    struct filter *f = filter;
    if (strcmp(name, "hdr") != 0 || !value)
        fail(f->device, OIDN_INVALID_ARGUMENT, "there are weights for hdr alone");
}

/* It takes pictures whole. */
void oidnSetFilterInt(void *filter, const char *name, int value)
{
    (void)filter, (void)name, (void)value;
}

void oidnSetFilterProgressMonitorFunction(void *filter, bool (*go_on)(void *, double), void *ctx)
{
    struct filter *f = filter;
    f->go_on = go_on;
    f->ctx = ctx;
}

void oidnCommitFilter(void *filter)
{
    const struct filter *f = filter;
    for (int i = 0; i < IMAGES; i++)
        if (!f->images[i].pixels) fail(f->device, OIDN_INVALID_OPERATION, "an image is missing");
}

/* Channels of all images as planes: what is given, or what was made. */
struct planes {
    struct plane of[IMAGES][3];
    const struct plane *at[IMAGES][3];
    float *memory; /* owned */
};

static bool planes_create(const struct filter *f, struct planes *out)
{
    const size_t area = f->width * f->height;
    out->memory = calloc(area, IMAGES * 3 * sizeof *out->memory);
    for (size_t i = 0; i < IMAGES; i++)
        for (size_t c = 0; c < 3; c++) {
            out->of[i][c] = (struct plane){out->memory + (3 * i + c) * area, (int32_t)f->width,
                                           (int32_t)f->height, (ptrdiff_t)f->width};
            out->at[i][c] = &out->of[i][c];
        }
    return out->memory != NULL;
}

static void copy_image(const struct filter *f, int i, const struct planes *planes, bool back)
{
    const struct filter_image *image = &f->images[i];
    for (size_t y = 0; y < f->height; y++)
        for (size_t x = 0; x < f->width; x++)
            for (size_t c = 0; c < 3; c++) {
                float *own = plane_at(planes->at[i][c], (int32_t)x, (int32_t)y);
                unsigned char *theirs = image->pixels + y * image->row_bytes +
                                        x * image->pixel_bytes + c * sizeof(float);
                if (back)
                    memcpy(theirs, own, sizeof(float));
                else
                    memcpy(own, theirs, sizeof(float));
            }
}

static void *execute(void *filter)
{
    const struct filter *f = filter;
    struct planes planes;
    struct fault fault = {0};
    float exposure;
    if (f->device->error) return NULL;
    if (f->go_on && !f->go_on(f->ctx, 0.0)) {
        fail(f->device, OIDN_CANCELLED, "cancelled");
        return NULL;
    }
    if (!planes_create(f, &planes)) {
        fail(f->device, OIDN_OUT_OF_MEMORY, "no memory for a picture");
        return NULL;
    }
    for (int i = 0; i < IMAGES - 1; i++) copy_image(f, i, &planes, false);
    const struct denoise_input in = {planes.at[0], planes.at[1], planes.at[2]};
    if (denoise_run(&f->device->network, &in, planes.at[3], &exposure, &fault))
        fail(f->device, OIDN_OUT_OF_MEMORY, fault.detail);
    else
        copy_image(f, IMAGES - 1, &planes, true);
    free(planes.memory);
    if (f->go_on) f->go_on(f->ctx, 1.0);
    return NULL;
}

/* On a thread of its own, as the library does from version 2.3 on. */
void oidnExecuteFilter(void *filter)
{
    pthread_t thread;
    if (pthread_create(&thread, NULL, execute, filter) != 0)
        fail(((struct filter *)filter)->device, OIDN_OUT_OF_MEMORY, "no thread to run on");
    else
        pthread_join(thread, NULL);
}

void oidnReleaseFilter(void *filter)
{
    free(filter);
}
