/* exr_unet WEIGHTS.tza IN.exr OUT.exr [half]: what Open Image Denoise's network makes of a picture
 * with the layers beauty, albedo and normal, by weights for HDR, albedo and normal. Prints its CPU
 * seconds as JSON. half: as half floats. */
#include <stdio.h>
#include <string.h>
#include <time.h>

#include "server/image/exr.h"
#include "tests/bench/unet/denoise.h"

struct picture {
    struct image *image; /* owned */
    const struct plane *colour[3], *albedo[3], *normal[3];
    struct image *denoised; /* owned */
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
        image_layer_planes(p->image, "normal", p->normal))
        return 0;
    fprintf(stderr, "exr_unet: %s: it lacks one of the layers beauty, albedo, normal\n", path);
    return -1;
}

static int denoise(const struct network *network, struct picture *p)
{
    static const char *const names[] = {"R", "G", "B"};
    const struct denoise_input in = {p->colour, p->albedo, p->normal};
    const struct plane *out[3];
    struct fault fault = {0};
    if (image_create_named(names, 3, p->image->width_px, p->image->height_px, &p->denoised))
        return -1;
    for (int i = 0; i < 3; i++) out[i] = &p->denoised->channels[i].plane;
    return denoise_run(network, &in, out, &p->exposure, &fault) ? complain("network", &fault) : 0;
}

static int write_picture(const struct picture *p, const char *path, bool half)
{
    struct fault fault = {0};
    int rc = exr_write(path, p->denoised, &(struct exr_metadata){.half = half}, &fault);
    return rc ? complain(path, &fault) : 0;
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
    const bool half = argc == 5 && strcmp(argv[4], "half") == 0;
    if (argc != 4 && !half) {
        fprintf(stderr, "usage: exr_unet WEIGHTS.tza IN.exr OUT.exr [half]\n");
        return 2;
    }
    int rc = read_network(argv[1], &network);
    if (!rc) rc = read_picture(argv[2], &picture);
    const clock_t begun = clock();
    if (!rc) rc = denoise(&network, &picture);
    const double cpu_s = (double)(clock() - begun) / CLOCKS_PER_SEC;
    if (!rc) rc = write_picture(&picture, argv[3], half);
    if (!rc) printf("{\"cpu_s\":%.3f,\"exposure\":%.6g}\n", cpu_s, (double)picture.exposure);
    network_fini(&network);
    image_destroy(&picture.image);
    image_destroy(&picture.denoised);
    return rc ? 1 : 0;
}
