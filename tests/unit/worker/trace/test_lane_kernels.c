/* The lane kernels: the same bits on every instruction set, and what they do at the edges. */
#include "tests/random.h"
#include "tests/unit/unit.h"
#include "tests/unit/worker/tile_fixture.h"
#include "tests/unit/worker/trace/isa_fixture.h"

#include <xmmintrin.h>

#include "proto/octahedron.h"
#include "worker/trace/hit/hit_kernels.h"
#include "worker/trace/light/light_kernels.h"

/* In [-1, 1]. */
static float random_signed(struct random *r)
{
    return (float)(int32_t)(uint32_t)random_bits(r) * 0x1p-31f;
}

static void random_lanes(struct random *r, float scale, struct lanes3 *out)
{
    for (int i = 0; i < LANES; i++) {
        out->x[i] = scale * random_signed(r);
        out->y[i] = scale * random_signed(r);
        out->z[i] = scale * random_signed(r);
    }
}

static void random_surface(struct random *r, struct surface *s)
{
    memset(s, 0, sizeof *s);
    random_lanes(r, 3.0f, &s->position);
    s->origin = s->position;
    random_lanes(r, 1.0f, &s->normal);
    random_lanes(r, 1.0f, &s->facet);
    for (int i = 0; i < LANES; i++) s->hit.on[i] = -(int32_t)(random_bits(r) & 1);
}

static void random_light(struct random *r, uint32_t type, struct plan_light *p)
{
    *p = (struct plan_light){.type = type,
                             .profile = random_bits(r) & 1,
                             .half_u = {0.7f, 0, 0},
                             .half_v = {0, 0, 0.4f},
                             .direction = {0, -1, 0},
                             .cos_inner = 0.9f,
                             .cos_outer = 0.3f,
                             .range = random_bits(r) & 1 ? 3.0f : 0.0f,
                             .power = 1,
                             .strata_per_axis = 1};
    for (int i = 0; i < 3; i++) p->position[i] = 2.0f * random_signed(r);
}

TEST(test_light_samples_agree)
{
    struct random seed = {1};
    static struct light_packet expected, got; /* zeroed: padding compares equal */
    for (int round = 0; round < 400; round++) {
        struct plan plan = {.light_count = 1};
        struct light_table table;
        struct surface s;
        struct lanes_mask lanes;
        _Alignas(64) float u[LANES], v[LANES];
        random_light(&seed, (uint32_t)round % 4, &plan.lights[0]);
        light_table_init(&table, &plan, NULL);
        random_surface(&seed, &s);
        for (int i = 0; i < LANES; i++) {
            u[i] = 0.5f + 0.5f * random_signed(&seed);
            v[i] = 0.5f + 0.5f * random_signed(&seed);
            lanes.on[i] = s.hit.on[i];
        }
        light_kernels_sse42.sample_light(&table.lights[0], u, v, &s, &lanes, &expected);
        for (int k = 0; k < isa_count(); k++) {
            KERNELS_FOR(light_kernels, all_isas[k])
                ->sample_light(&table.lights[0], u, v, &s, &lanes, &got);
            assert_memory_equal(got.rays.ray.dir_x, expected.rays.ray.dir_x, 64);
            assert_memory_equal(got.rays.ray.dir_z, expected.rays.ray.dir_z, 64);
            assert_memory_equal(got.rays.ray.tfar, expected.rays.ray.tfar, 64);
            assert_memory_equal(got.traced.on, expected.traced.on, 64);
            assert_memory_equal(got.skip, expected.skip, 64);
            for (int i = 0; i < LANES; i++)
                if (got.traced.on[i])
                    assert_memory_equal(&got.irradiance[i], &expected.irradiance[i], 4);
        }
    }
}

static void assert_packets_agree(const struct light_packet *a, const struct light_packet *b)
{
    assert_memory_equal(a->rays.ray.org_x, b->rays.ray.org_x, 64);
    assert_memory_equal(a->rays.ray.dir_x, b->rays.ray.dir_x, 64);
    assert_memory_equal(a->rays.ray.dir_y, b->rays.ray.dir_y, 64);
    assert_memory_equal(a->rays.ray.dir_z, b->rays.ray.dir_z, 64);
    assert_memory_equal(a->rays.ray.tfar, b->rays.ray.tfar, 64);
    assert_memory_equal(a->traced.on, b->traced.on, 64);
    assert_memory_equal(a->skip, b->skip, 64);
    for (int i = 0; i < LANES; i++)
        if (b->traced.on[i]) assert_memory_equal(&a->irradiance[i], &b->irradiance[i], 4);
}

/* A batch of strata holds what samples one by one do, and says whether all lanes are traced. */
static void check_batch(const struct light_kernels *kernels, const struct light *light,
                        const struct strata *strata, uint32_t first, uint32_t count,
                        const struct surface *s)
{
    static struct light_packet batch[SHADOW_BATCH], expected;
    bool whole = true;
    const bool said = kernels->sample_strata(light, strata, first, count, s, &s->hit, batch);
    for (uint32_t i = 0; i < count; i++) {
        light_kernels_sse42.sample_light(light, strata_u(strata, first + i),
                                         strata_v(strata, first + i), s, &s->hit, &expected);
        assert_packets_agree(&batch[i], &expected);
        whole &= lanes_count(&expected.traced) == lanes_count(&s->hit);
    }
    assert_int_equal(said, whole);
}

TEST(test_strata_agree)
{
    struct random seed = {6};
    static struct strata strata;
    for (int round = 0; round < 400; round++) {
        struct plan plan = {.light_count = 1};
        struct light_table table;
        struct surface s;
        struct block block;
        const uint32_t l = 1 + (uint32_t)round % 12, all = l * l;
        random_light(&seed, (uint32_t)round % 4, &plan.lights[0]);
        light_table_init(&table, &plan, NULL);
        random_surface(&seed, &s);
        block_init(&block, 4 * round, 8, 4096, 16, (struct rect){0, 0, 4096, 16});
        for (int k = 0; k < isa_count(); k++) {
            const struct light_kernels *kernels = KERNELS_FOR(light_kernels, all_isas[k]);
            strata_init(&strata, kernels, &plan.pattern, NULL, &block, PATTERN_LIGHT, l);
            for (uint32_t first = 0; first < all; first += SHADOW_BATCH)
                check_batch(kernels, &table.lights[0], &strata, first,
                            all - first < SHADOW_BATCH ? all - first : SHADOW_BATCH, &s);
        }
    }
}

/* Texels in lanes are where texture_sample finds them, whatever the modes and the coordinates. */
TEST(test_texels_agree)
{
    struct random seed = {7};
    struct texture_decoding decoding;
    static uint8_t bytes[4 * 7 * 5];
    texture_decoding_init(&decoding);
    for (size_t i = 0; i < sizeof bytes; i++) bytes[i] = (uint8_t)random_bits(&seed);
    for (int round = 0; round < 600; round++) {
        const struct texture t = {.texels = bytes,
                                  .decode = round & 1 ? decoding.srgb : decoding.linear,
                                  .decode_alpha = decoding.linear,
                                  .width_px = round % 3 ? 7 : 1,
                                  .height_px = 5,
                                  .wrap_u = (uint32_t)round % 3,
                                  .wrap_v = (uint32_t)round / 3 % 3,
                                  .nearest = (uint32_t)round / 9 % 2,
                                  .transform = {1.5f, 0.25f, 0.125f, -0.5f, 2.0f, 0}};
        _Alignas(64) float u[LANES], v[LANES];
        const float scale = round % 4 ? 3.0f : 1e7f;
        for (int i = 0; i < LANES; i++) {
            u[i] = scale * random_signed(&seed);
            v[i] = scale * random_signed(&seed);
        }
        u[3] = NAN, v[4] = INFINITY, u[5] = v[5] = 0.0f, u[6] = 1.0f; /* edges */
        for (int k = 0; k < isa_count(); k++) {
            struct texel_lanes at;
            KERNELS_FOR(hit_kernels, all_isas[k])->place_texels(&t, u, v, &at);
            for (int i = 0; i < LANES; i++) {
                float expected[4], got[4];
                texture_sample(&t, u[i], v[i], expected);
                texels_blend(&t, &at, i, got);
                assert_memory_equal(got, expected, sizeof got);
            }
        }
    }
}

/* Rows of camera rays are those of each pixel's centre, in the image and not beside it. */
TEST(test_camera_rows_agree)
{
    static struct primary_packet row[PRIMARY_ROW];
    static struct RTCRay16 expected;
    for (int orthographic = 0; orthographic < 2; orthographic++) {
        const struct plan plan = {
            .width_px = 30,
            .height_px = 14,
            .camera = {.type = orthographic ? CAMERA_ORTHOGRAPHIC : CAMERA_PERSPECTIVE,
                       .eye = {1, 2, 3},
                       .right = {0.8f, 0, 0.6f},
                       .up = {0, 1, 0},
                       .forward = {-0.6f, 0, 0.8f},
                       .half_width = 0.7f,
                       .half_height = 0.4f}};
        for (int k = 0; k < isa_count(); k++) {
            const struct hit_kernels *kernels = KERNELS_FOR(hit_kernels, all_isas[k]);
            assert_int_equal(kernels->camera_row(&plan, 0, 12, PRIMARY_ROW, row), 0);
            for (int32_t n = 0; n < PRIMARY_ROW; n++) {
                _Alignas(64) float px[LANES], py[LANES];
                for (int32_t i = 0; i < LANES; i++) {
                    const int32_t x = 4 * n + i % 4, y = 12 + i / 4;
                    px[i] = (float)x + 0.5f, py[i] = (float)y + 0.5f;
                    assert_int_equal(row[n].valid.on[i], x < 30 && y < 14 ? -1 : 0);
                }
                hit_kernels_sse42.camera_rays(&plan, px, py, &expected);
                assert_memory_equal(row[n].rays.ray.org_x, expected.org_x, 64);
                assert_memory_equal(row[n].rays.ray.dir_x, expected.dir_x, 64);
                assert_memory_equal(row[n].rays.ray.dir_y, expected.dir_y, 64);
                assert_memory_equal(row[n].rays.ray.dir_z, expected.dir_z, 64);
                assert_memory_equal(row[n].rays.ray.tfar, expected.tfar, 64);
            }
        }
    }
}

TEST(test_surfaces_agree)
{
    struct random seed = {2};
    for (int round = 0; round < 300; round++) {
        static struct RTCRay16 rays;
        struct surface a, b;
        struct lanes3 way;
        _Alignas(64) float magnitude[LANES];
        random_surface(&seed, &a);
        random_lanes(&seed, 1.0f, &way);
        for (int i = 0; i < LANES; i++) {
            float length = sqrtf(way.x[i] * way.x[i] + way.y[i] * way.y[i] + way.z[i] * way.z[i]);
            rays.dir_x[i] = way.x[i] / length;
            rays.dir_y[i] = way.y[i] / length;
            rays.dir_z[i] = way.z[i] / length;
            magnitude[i] = fabsf(random_signed(&seed)) * 10.0f;
        }
        if (round % 3 == 0) a.normal.x[3] = a.normal.y[3] = a.normal.z[3] = 0.0f;
        if (round % 5 == 0) a.facet.x[9] = a.facet.y[9] = a.facet.z[9] = 0.0f;
        b = a;
        hit_kernels_sse42.finish_surface(&rays, magnitude, false, &a);
        for (int i = 0; i < LANES; i++) {
            float facing = a.facet.x[i] * rays.dir_x[i] + a.facet.y[i] * rays.dir_y[i] +
                           a.facet.z[i] * rays.dir_z[i];
            float shading = a.normal.x[i] * rays.dir_x[i] + a.normal.y[i] * rays.dir_y[i] +
                            a.normal.z[i] * rays.dir_z[i];
            float length = a.normal.x[i] * a.normal.x[i] + a.normal.y[i] * a.normal.y[i] +
                           a.normal.z[i] * a.normal.z[i];
            assert_true(facing <= 0.0f && shading < 0.0f && fabsf(length - 1.0f) < 1e-5f);
        }
        for (int k = 1; k < isa_count(); k++) {
            struct surface c = b;
            KERNELS_FOR(hit_kernels, all_isas[k])->finish_surface(&rays, magnitude, false, &c);
            assert_memory_equal(&c, &a, sizeof a);
        }
    }
}

/* Where all normals are those of facets, they need not be made twice. */
TEST(test_flat_surfaces)
{
    struct random seed = {5};
    static struct RTCRay16 rays;
    _Alignas(64) float magnitude[LANES] = {0};
    for (int i = 0; i < LANES; i++) rays.dir_z[i] = 1.0f;
    for (int round = 0; round < 100; round++) {
        struct surface expected, flat;
        random_surface(&seed, &expected);
        expected.normal = expected.facet;
        flat = expected;
        for (int i = 0; i < LANES; i++) flat.normal.x[i] = NAN; /* nobody reads them */
        hit_kernels_sse42.finish_surface(&rays, magnitude, false, &expected);
        for (int k = 0; k < isa_count(); k++) {
            struct surface got = flat;
            KERNELS_FOR(hit_kernels, all_isas[k])->finish_surface(&rays, magnitude, true, &got);
            assert_memory_equal(&got, &expected, sizeof got);
        }
    }
}

/* Camera rays are plan_camera_ray's, perspective and orthographic. */
TEST(test_camera_rays)
{
    struct plan p = fixture_plan(64, 48, (float[]){1, 2, 3}, 0.8f);
    fixture_look(&p, (float[]){0.6f, 0, -0.8f}, (float[]){0, 1, 0});
    for (int k = 0; k < isa_count(); k++)
        for (uint32_t type = 0; type < 2; type++) {
            _Alignas(64) float px[LANES], py[LANES];
            struct RTCRay16 r;
            p.camera.type = type;
            for (int i = 0; i < LANES; i++) px[i] = (float)i * 4.1f, py[i] = (float)i * 2.9f;
            KERNELS_FOR(hit_kernels, all_isas[k])->camera_rays(&p, px, py, &r);
            for (int i = 0; i < LANES; i++) {
                float o[3], d[3];
                plan_camera_ray(&p, px[i], py[i], o, d);
                assert_true(r.org_x[i] == o[0] && r.org_y[i] == o[1] && r.org_z[i] == o[2]);
                assert_true(r.dir_x[i] == d[0] && r.dir_y[i] == d[1] && r.dir_z[i] == d[2]);
            }
        }
}

TEST(test_unorms)
{
    _Alignas(64) float v[LANES] = {-1, 0, 0.5f, 1, 2, 1e-5f, 1.0f / 65535, INFINITY};
    static const uint16_t expected[] = {0, 0, 32768, 65535, 65535, 1, 1, 65535, 0};
    for (int k = 0; k < isa_count(); k++) {
        _Alignas(64) uint16_t packed[LANES];
        KERNELS_FOR(hit_kernels, all_isas[k])->pack_unorms(v, packed);
        assert_memory_equal(packed, expected, sizeof expected);
    }
}

TEST(test_packed_normals_are_octahedron_codes)
{
    struct random seed = {3};
    for (int round = 0; round < 500; round++) {
        struct lanes3 n;
        _Alignas(64) uint32_t wide[LANES], narrow[LANES];
        random_lanes(&seed, 1.0f, &n);
        if (round % 4 == 0) n.x[0] = 0, n.y[0] = 0, n.z[0] = round % 8 ? 1.0f : -1.0f;
        if (round % 4 == 1) n.x[5] = 0, n.z[5] = 0, n.y[5] = 1;
        if (round == 2) n.x[1] = n.y[1] = n.z[1] = 0;
        for (int k = 0; k < isa_count(); k++) {
            KERNELS_FOR(hit_kernels, all_isas[k])->pack_normals(&n, 16, wide);
            KERNELS_FOR(hit_kernels, all_isas[k])->pack_normals(&n, 8, narrow);
            for (int i = 0; i < LANES; i++) {
                const float v[3] = {n.x[i], n.y[i], n.z[i]};
                assert_int_equal(wide[i], octahedron_pack16(v));
                assert_int_equal(narrow[i], octahedron_pack8(v));
            }
        }
    }
}

TEST(test_unfit_rays_are_switched_off)
{
    for (int k = 0; k < isa_count(); k++) {
        struct RTCRay16 r = {.tnear = {0}};
        struct lanes_mask valid;
        for (int i = 0; i < LANES; i++) {
            valid.on[i] = i == 15 ? 0 : -1;
            r.dir_x[i] = 1;
            r.tfar[i] = INFINITY;
        }
        r.org_x[0] = NAN;
        r.org_y[1] = 2e18f;
        r.dir_z[2] = INFINITY;
        r.dir_y[3] = NAN;
        r.tnear[4] = -1;
        r.tfar[5] = NAN;
        r.tfar[6] = 0;
        r.org_z[15] = NAN;
        assert_int_equal(KERNELS_FOR(hit_kernels, all_isas[k])->sanitise(&r, &valid), 7);
        for (int i = 0; i < LANES; i++) assert_int_equal(valid.on[i], i < 7 || i == 15 ? 0 : -1);
    }
}

/* A receiver in the light itself: E overflows, no ray is sent, the sample is counted. */
TEST(test_not_finite_samples_are_rejected)
{
    static struct light_packet packet;
    struct plan plan = {.light_count = 1};
    struct light_table table;
    struct surface s = {.hit = {{0}}};
    struct lanes_mask lanes;
    struct counters counters = {0};
    _Alignas(64) float u[LANES] = {0};
    plan.lights[0] = (struct plan_light){.type = LIGHT_POINT, .power = 1, .strata_per_axis = 1};
    plan.lights[0].position[1] = 1e-15f;
    light_table_init(&table, &plan, NULL);
    for (int i = 0; i < LANES; i++) {
        s.normal.y[i] = s.facet.y[i] = 1.0f;
        lanes.on[i] = -1;
        s.position.x[i] = i == 2 ? 1.0f : 0.0f;
    }
    s.origin = s.position;
    for (int k = 0; k < isa_count(); k++) {
        unsigned int mode = _mm_getcsr();
        _mm_setcsr(mode | 0x8040u); /* as while tiles are traced: squares flush to zero */
        plan.lights[0].position[1] = 1e-20f;
        KERNELS_FOR(light_kernels, all_isas[k])
            ->sample_light(&table.lights[0], u, u, &s, &lanes, &packet);
        _mm_setcsr(mode);
        for (int i = 0; i < LANES; i++) assert_int_equal(packet.traced.on[i], i == 2 ? -1 : 0);
    }
    light_count_skips(&packet, &lanes, 1, &counters);
    assert_int_equal(counters.value[COUNTER_REJECTED_NOT_FINITE], LANES - 1);
}
