/* exr_unet WEIGHTS.tza IN.exr OUT.exr [half]: what Open Image Denoise's network makes of a picture
 * with the layers beauty, albedo and normal, by weights for HDR, albedo and normal. Prints its CPU
 * seconds as JSON. half: as half floats. */
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

#include "server/image/exr.h"
#include "tests/bench/unet/network.h"
#include "tests/bench/unet/tone.h"

struct picture {
    struct image *image; /* owned */
    const struct plane *colour[3], *albedo[3], *normal[3];
    float exposure;
};

static int complain(const char *path, const struct fault *fault)
{
    fprintf(stderr, "exr_unet: %s: %s\n", path, fault->detail);
    return -1;
}

static int read_picture(const char *path, struct picture *p)
{
    struct fault fault = {0};
    if (exr_read(path, &p->image, &fault)) return complain(path, &fault);
    if (image_layer_planes(p->image, "beauty", p->colour) &&
        image_layer_planes(p->image, "albedo", p->albedo) &&
        image_layer_planes(p->image, "normal", p->normal)) {
        p->exposure = tone_exposure(p->colour);
        return 0;
    }
    fprintf(stderr, "exr_unet: %s: it lacks one of the layers beauty, albedo, normal\n", path);
    return -1;
}

/* What is not a number becomes `low`. */
static float clamped(float v, float low, float high)
{
    return v > low ? v < high ? v : high : low;
}

static void fill_pixel(const struct picture *p, int32_t x, int32_t y, float to[NETWORK_INPUTS])
{
    for (int i = 0; i < 3; i++) {
        const float normal = *plane_at(p->normal[i], x, y);
        to[i] = tone_forward(clamped(*plane_at(p->colour[i], x, y) * p->exposure, 0.0f, INFINITY));
        to[3 + i] = clamped(*plane_at(p->albedo[i], x, y), 0.0f, 1.0f);
        to[6 + i] = clamped(isnan(normal) ? 0.0f : normal, -1.0f, 1.0f) * 0.5f + 0.5f;
    }
}

static int32_t padded(int32_t size)
{
    return (size + NETWORK_MULTIPLE - 1) / NETWORK_MULTIPLE * NETWORK_MULTIPLE;
}

static int fill(const struct picture *p, struct tensor *in)
{
    const int32_t width = p->image->width_px, height = p->image->height_px;
    int rc = tensor_init(in, padded(width), padded(height), NETWORK_INPUTS);
    for (int32_t y = 0; y < height && !rc; y++)
        for (int32_t x = 0; x < width; x++) fill_pixel(p, x, y, tensor_at(in, x, y));
    return rc;
}

static int write_picture(const struct picture *p, const struct tensor *out, const char *path,
                         bool half)
{
    static const char *const names[] = {"R", "G", "B"};
    const int32_t width = p->image->width_px, height = p->image->height_px;
    struct image *image = NULL;
    struct fault fault = {0};
    if (image_create_named(names, 3, width, height, &image)) return -1;
    for (int i = 0; i < 3; i++)
        for (int32_t y = 0; y < height; y++)
            for (int32_t x = 0; x < width; x++)
                *plane_at(&image->channels[i].plane, x, y) =
                    tone_inverse(tensor_at(out, x, y)[i]) / p->exposure;
    int rc = exr_write(path, image, &(struct exr_metadata){.half = half}, &fault);
    image_destroy(&image);
    return rc ? complain(path, &fault) : 0;
}

static int denoise(const struct network *network, const struct picture *p, struct tensor *out)
{
    struct tensor in;
    struct fault fault = {0};
    int rc = fill(p, &in);
    if (!rc) rc = network_run(network, &in, out, &fault);
    tensor_fini(&in);
    return rc ? complain("network", &fault) : 0;
}

static int read_network(const char *path, struct network *network)
{
    struct tza tza;
    struct fault fault = {0};
    int rc = tza_read(path, &tza, &fault);
    if (!rc) rc = network_init(network, &tza, &fault);
    tza_fini(&tza);
    return rc ? complain(path, &fault) : 0;
}

int main(int argc, char **argv)
{
    struct network network = {0};
    struct picture picture = {0};
    struct tensor out = {0};
    const bool half = argc == 5 && strcmp(argv[4], "half") == 0;
    if (argc != 4 && !half) {
        fprintf(stderr, "usage: exr_unet WEIGHTS.tza IN.exr OUT.exr [half]\n");
        return 2;
    }
    int rc = read_network(argv[1], &network);
    if (!rc) rc = read_picture(argv[2], &picture);
    const clock_t begun = clock();
    if (!rc) rc = denoise(&network, &picture, &out);
    const double cpu_s = (double)(clock() - begun) / CLOCKS_PER_SEC;
    if (!rc) rc = write_picture(&picture, &out, argv[3], half);
    if (!rc) printf("{\"cpu_s\":%.3f,\"exposure\":%.6g}\n", cpu_s, (double)picture.exposure);
    tensor_fini(&out);
    network_fini(&network);
    image_destroy(&picture.image);
    return rc ? 1 : 0;
}
