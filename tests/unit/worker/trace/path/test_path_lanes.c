/* Steps of sixteen paths at once: as of one after the other, on every instruction set. */
#include "tests/random.h"
#include "tests/unit/unit.h"
#include "tests/unit/worker/tile_fixture.h"
#include "tests/unit/worker/trace/isa_fixture.h"

#include "worker/trace/path/path_kernels.h"
#include "worker/trace/path/path_sums.h"

static void random_lanes(struct random *r, struct lanes3 *out)
{
    for (int i = 0; i < LANES; i++) {
        out->x[i] = random_unit(r), out->y[i] = random_unit(r), out->z[i] = random_unit(r);
        if (random_bits(r) % 8 == 0) out->x[i] = out->y[i] = out->z[i] = (float)(i & 1);
    }
}

static float most_of(const float c[3])
{
    return fmaxf(c[0], fmaxf(c[1], c[2]));
}

/* A path stays with the probability of what its brightest channel carries, 0.98 at most, and then
 * carries so much more. */
TEST(segments_make_up_for_those_that_end)
{
    static struct path_packet p;
    static struct path_scattering s;
    struct random seed = {1};
    uint32_t stayed = 0;
    for (int round = 0; round < 400; round++) {
        _Alignas(64) float chance[LANES];
        random_lanes(&seed, &p.throughput), random_lanes(&seed, &s.weight);
        for (int i = 0; i < LANES; i++) chance[i] = random_unit(&seed);
        for (int i = 0; i < LANES; i++) s.promise[i] = i % 4 ? 1.0f : 1.5f;
        chance[3] = 0.0f, p.throughput.x[3] = p.throughput.y[3] = p.throughput.z[3] = 0.0f;
        p.throughput.x[5] = s.weight.x[5] = 1.0f, chance[5] = round & 1 ? 0.98f : 0.97f;
        for (int k = 0; k < isa_count(); k++) {
            const struct path_kernels *kernels = KERNELS_FOR(path_kernels, all_isas[k]);
            struct lanes3 t;
            struct lanes_mask stays;
            kernels->weigh_segments(&p, &s, NULL, &t, &stays);
            for (int i = 0; i < LANES; i++) {
                assert_true(stays.on[i] == -1 && t.x[i] == p.throughput.x[i] * s.weight.x[i]);
                assert_true(t.y[i] == p.throughput.y[i] * s.weight.y[i]);
                assert_true(t.z[i] == p.throughput.z[i] * s.weight.z[i]);
            }
            kernels->weigh_segments(&p, &s, chance, &t, &stays);
            for (int i = 0; i < LANES; i++) {
                const float whole[3] = {p.throughput.x[i] * s.weight.x[i],
                                        p.throughput.y[i] * s.weight.y[i],
                                        p.throughput.z[i] * s.weight.z[i]};
                const float stay = fminf(s.promise[i] * most_of(whole), 0.98f);
                assert_int_equal(stays.on[i], chance[i] < stay ? -1 : 0);
                if (!stays.on[i]) continue;
                stayed++;
                assert_true(t.x[i] == whole[0] / stay && t.y[i] == whole[1] / stay);
                assert_true(t.z[i] == whole[2] / stay);
            }
        }
    }
    assert_true(stayed > 1000);
}

/* What is off adds nothing, whatever its numbers and its slot's share are. */
TEST(radiance_takes_what_is_on)
{
    static struct path_radiance h, one;
    struct random seed = {2};
    for (int round = 0; round < 64; round++) {
        const struct path_context c = {.demodulate = round & 1,
                                       .skip = round & 2 ? SKIP_SOFT_SKY : 0};
        const uint32_t scatterings = 1 + (round >> 2 & 1);
        struct path_packet p = {.count = round % 3 ? LANES : 11};
        struct lanes_mask on;
        struct lanes3 value;
        memset(&h, 0, sizeof h);
        random_lanes(&seed, &value);
        for (uint32_t i = 0; i < LANES; i++) {
            const uint32_t slot = p.slot[i] = 7 * i + 3;
            on.on[i] = random_bits(&seed) & 1 ? -1 : 0;
            h.share.r[slot] = random_unit(&seed), h.share.g[slot] = h.share.b[slot] = 2.0f;
            if (on.on[i]) continue;
            value.y[i] = INFINITY, h.share.r[slot] = NAN;
        }
        one = h;
        path_radiance_add_lanes(&c, &h, scatterings, &p, &on, &value);
        for (uint32_t i = 0; i < p.count; i++)
            if (on.on[i])
                path_radiance_add(&c, &one, scatterings, p.slot[i],
                                  (float[]){value.x[i], value.y[i], value.z[i]});
        assert_memory_equal(&h, &one, sizeof h);
    }
}

/* Where paths came from, in the frames of what they met. */
TEST(back_is_in_the_shading_frame)
{
    static struct path_vertex v;
    static struct RTCRay16 r;
    struct random seed = {3};
    random_lanes(&seed, &v.tangent), random_lanes(&seed, &v.bitangent);
    random_lanes(&seed, &v.surface.normal);
    for (int i = 0; i < LANES; i++) {
        r.dir_x[i] = random_unit(&seed), r.dir_y[i] = random_unit(&seed);
        r.dir_z[i] = -random_unit(&seed);
    }
    for (int k = 0; k < isa_count(); k++) {
        const struct lanes3 *t = &v.tangent, *b = &v.bitangent, *n = &v.surface.normal;
        memset(&v.back, 0, sizeof v.back);
        KERNELS_FOR(path_kernels, all_isas[k])->look_back(&r, &v);
        for (int i = 0; i < LANES; i++) {
            const float d[3] = {-r.dir_x[i], -r.dir_y[i], -r.dir_z[i]};
            assert_true(v.back.x[i] == d[0] * t->x[i] + d[1] * t->y[i] + d[2] * t->z[i]);
            assert_true(v.back.y[i] == d[0] * b->x[i] + d[1] * b->y[i] + d[2] * b->z[i]);
            assert_true(v.back.z[i] == d[0] * n->x[i] + d[1] * n->y[i] + d[2] * n->z[i]);
        }
    }
}

/* One number that is not finite, wherever it is, takes its sample's light with it, and no other. */
TEST(odd_samples_count_as_black)
{
    static struct path_radiance h;
    static struct path_sums sums;
    struct path_rgb *const planes[] = {&h.emission, &h.direct, &h.indirect, &h.diffuse_direct,
                                       &h.diffuse_indirect};
    static const float odd[] = {NAN, INFINITY};
    for (int k = 0; k < 30; k++) {
        const struct plan_pass pass = {.first = 0};
        struct counters counters = {.value = {0}};
        memset(&h, 0, sizeof h);
        for (int plane = 0; plane < 5; plane++)
            for (int i = 0; i < 2 * LANES; i++)
                planes[plane]->r[i] = planes[plane]->g[i] = planes[plane]->b[i] = 1.0f;
        struct path_rgb *at = planes[k % 5];
        float *const channels[] = {at->r, at->g, at->b};
        channels[k / 5 % 3][LANES + 7] = odd[k / 15];
        path_sums_init(&sums, &pass, 0, 0);
        path_sums_add(&sums, &h, 2, true, &counters);
        assert_int_equal(counters.value[COUNTER_REJECTED_NOT_FINITE], 1);
        for (int i = 0; i < LANES; i++) {
            const float samples = i == 7 ? 1.0f : 2.0f;
            assert_true(sums.radiance.x[i] == 3.0f * samples);
            assert_true(sums.radiance.z[i] == 3.0f * samples && sums.emission.y[i] == samples);
            assert_true(sums.diffuse_direct.z[i] == samples);
            assert_true(sums.diffuse_indirect.x[i] == samples);
        }
    }
}
