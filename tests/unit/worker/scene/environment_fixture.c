#include "tests/unit/worker/scene/environment_fixture.h"

#include <stdlib.h>
#include <string.h>

void environment_fixture_open(struct environment_fixture *f, uint32_t width, uint32_t height,
                              const float *texels)
{
    struct environment_header header;
    struct fault fault = {0};
    void *memory = NULL;
    const size_t texel_bytes = 3 * sizeof(float) * width * height;
    if (environment_describe(width, height, texels, &header, &fault))
        fail_msg("%s: %s", fault.pointer, fault.detail);
    assert_int_equal(posix_memalign(&memory, 64, sizeof header + texel_bytes), 0);
    memcpy(memory, &header, sizeof header);
    memcpy((char *)memory + sizeof header, texels, texel_bytes);
    if (environment_open(memory, sizeof header + texel_bytes, &f->blob, &fault))
        fail_msg("%s: %s", fault.pointer, fault.detail);
    assert_int_equal(environment_create(&f->blob, &f->map), 0);
}

void environment_fixture_close(struct environment_fixture *f)
{
    environment_destroy(&f->map);
    assert_null(f->map);
    free((void *)(uintptr_t)f->blob.blob);
}

static struct environment_spot environment_spot_of(const struct environment *e,
                                                   const float direction[3])
{
    float width, height;
    environment_size(e, &width, &height);
    return environment_find(direction, width, height);
}

void environment_lookup(const struct environment *e, const float direction[3], float radiance[3])
{
    environment_read(e, environment_spot_of(e, direction), radiance);
}

float environment_pdf(const struct environment *e, const float direction[3])
{
    const struct environment_density at =
        environment_density(e, direction, environment_spot_of(e, direction));
    return (float)environment_bin_share(e, at.bin) * at.within;
}

/* The bin that `choice` takes in proportion to bins' shares; it becomes the place in it. */
static uint32_t choose_bin(const struct environment *e, float *choice)
{
    double before = 0.0;
    uint32_t bin = 0;
    for (uint32_t i = 0; i < ENVIRONMENT_BINS; i++) {
        const double share = environment_bin_share(e, i);
        if (!(share > 0.0)) continue;
        bin = i;
        if (*choice < before + share) break;
        before += share;
    }
    const double share = environment_bin_share(e, bin);
    const double within = share > 0.0 ? ((double)*choice - before) / share : 0.0;
    *choice = (float)(within < 1.0 ? within : 0x1.fffffep-1);
    return bin;
}

void environment_sample(const struct environment *e, float choice, const float u[2],
                        float direction[3], float *pdf)
{
    float width, height;
    const uint32_t bin = choose_bin(e, &choice);
    const struct environment_texel t =
        environment_texel_of(e, environment_choose(e, bin, choice, u));
    environment_size(e, &width, &height);
    environment_place(t, width, u, direction);
    *pdf = (float)environment_bin_share(e, bin) * t.density;
}
