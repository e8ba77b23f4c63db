/* The light field of indirect light beside the path tracer: together they are the picture that the
 * path tracer gives alone, whatever the surface, the lights and the number of bounces. */
#include <stdio.h>
#include <stdlib.h>

#include "tests/unit/unit.h"
#include "tests/unit/worker/trace/field/field_room.h"

static void compare(enum kind kind, uint32_t shines, uint32_t bounces)
{
    static const char *const names[] = {"Lambert", "dielectric",        "coated",
                                        "Phong",   "Ashikhmin-Shirley", "metal"};
    struct scene_fixture *f = fixture_new();
    struct plan plain = room(f, kind, shines), hybrid;
    char what[96];
    plain.bounces = bounces;
    hybrid = plain;
    add_field(&hybrid, 16);
    struct sums *a = trace_sums(f, &plain), *b = trace_sums(f, &hybrid);
    for (uint32_t c = 0; c < 3; c++) {
        double together[AREA], rest[AREA];
        for (int i = 0; i < AREA; i++) {
            together[i] = b->radiance[c][i] + field_at(b->first, c, i);
            rest[i] = a->direct[c][i] - b->direct[c][i];
            assert_true(rest[i] == 0.0);
            if (kind == LAMBERT) assert_true(b->indirect[c][i] == 0.0);
            if (kind == METAL)
                assert_int_equal(samples_u16(b->first, PLANE_BOUNCE_DISTANCE_MIN, 0)[i], 0);
        }
        snprintf(what, sizeof what, "%s, lights %u, %u bounces, channel %u", names[kind], shines,
                 bounces, c);
        expect_same(what, a->radiance[c], together, 0.02);
    }
    if (kind == LAMBERT) assert_true(b->counters.value[COUNTER_SKIPPED_LIGHT_FIELD] > 0);
    if (kind == METAL) assert_int_equal(b->counters.value[COUNTER_SKIPPED_LIGHT_FIELD], 0);
    sums_free(&a);
    sums_free(&b);
    free(f);
}

TEST(field_and_paths_are_the_picture)
{
    for (int kind = 0; kind < KIND_COUNT; kind++) {
        compare((enum kind)kind, SHINES_RECT | SHINES_MESH | SHINES_SKY, 8);
        if (kind == LAMBERT || kind == DIELECTRIC)
            compare((enum kind)kind, SHINES_RECT | SHINES_MESH | SHINES_SKY, 1);
    }
}

TEST(whatever_shines)
{
    static const uint32_t lights[] = {SHINES_RECT,  SHINES_MESH,
                                      SHINES_SKY,   SHINES_MAP,
                                      SHINES_POINT, SHINES_RECT | SHINES_POINT | SHINES_MAP};
    for (int k = 0; k < 6; k++) compare(k % 2 ? LAMBERT : DIELECTRIC, lights[k], 2);
}

/* A pure light field of lights alone is the path tracer's demodulated indirect light. */
TEST(fields_need_no_paths)
{
    for (uint32_t bounces = 1; bounces <= 3; bounces++) {
        struct scene_fixture *f = fixture_new();
        struct plan plain = room(f, LAMBERT, SHINES_RECT | SHINES_POINT), field;
        plain.bounces = bounces;
        field = plain;
        field.paths.spp = 0;
        field.planes = 0;
        add_field(&field, 16);
        struct sums *a = trace_sums(f, &plain), *b = trace_sums(f, &field);
        for (uint32_t c = 0; c < 3; c++) {
            double mean[AREA];
            for (int i = 0; i < AREA; i++) mean[i] = field_at(b->first, c, i);
            expect_same("indirect light without paths", a->indirect[c], mean, 0.03);
        }
        sums_free(&a);
        sums_free(&b);
        free(f);
    }
}

/* Samples per axis and maps of the strata change the noise, nothing else. */
TEST(strata_do_not_matter)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = room(f, DIELECTRIC, SHINES_RECT | SHINES_MESH);
    p.bounces = 2;
    p.paths.spp = 0;
    p.planes = 0;
    add_field(&p, 16);
    p.planes |= BIT(INDIRECT_STRATA) | BIT(INDIRECT_HALVES);
    struct sums *reference = trace_sums(f, &p);
    static const uint32_t axes[] = {1, 2, 3, 5, 16};
    for (int k = 0; k < 10; k++) {
        p.indirect_strata_per_axis = axes[k / 2];
        p.indirect_filter = k & 1 ? INDIRECT_FILTER_SHEARED : INDIRECT_FILTER_NONE;
        struct sums *s = trace_sums(f, &p);
        const uint32_t n = axes[k / 2] * axes[k / 2];
        for (uint32_t c = 0; c < 3; c++) {
            double a[AREA], b[AREA];
            for (int i = 0; i < AREA; i++) {
                double strata = 0;
                a[i] = half_at(reference->first, PLANE_INDIRECT_MEAN, c, i);
                b[i] = half_at(s->first, PLANE_INDIRECT_MEAN, c, i);
                double even = half_at(s->first, PLANE_INDIRECT_HALVES, c, i);
                double odd = half_at(s->first, PLANE_INDIRECT_HALVES, c + 3, i);
                double both = ((n + 1) / 2 * even + n / 2 * odd) / n;
                for (uint32_t j = 0; j < n; j++)
                    strata += half_at(s->first, PLANE_INDIRECT_STRATA, 4 * j + c, i) / n;
                assert_true(fabs(both - b[i]) <= 1e-3 * b[i] + 1e-6);
                assert_true(fabs(strata - b[i]) <= 1e-3 * b[i] + 1e-6);
            }
            expect_same("another number of strata", a, b, n == 1 ? 0.5 : 0.25);
        }
        sums_free(&s);
    }
    sums_free(&reference);
    free(f);
}

/* The nearest of the strata's distances, and the share of those that are not nearer than the
 * occlusion's: with radiance or alone, where rays end there. */
TEST(distances_are_the_first_hits)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = room(f, COATED, SHINES_RECT);
    p.bounces = 1;
    p.paths.spp = 0;
    p.planes = 0;
    add_field(&p, 4);
    p.planes |= BIT(INDIRECT_STRATA) | BIT(AMBIENT_VISIBILITY);
    p.occlusion_distance = 1.25f;
    struct sums *all = trace_sums(f, &p);
    p.planes &= ~(BIT(INDIRECT_STRATA) | BIT(INDIRECT_MEAN));
    p.bounces = 0;
    struct sums *alone = trace_sums(f, &p);
    uint64_t open_rays = 0, near_pixels = 0;
    for (int i = 0; i < AREA; i++) {
        double nearest = (double)BOUNCE_DISTANCE_NONE, open = 0;
        for (uint32_t k = 0; k < 16; k++) {
            double d = half_at(all->first, PLANE_INDIRECT_STRATA, 4 * k + 3, i);
            if (d > 0) nearest = fmin(nearest, d);
            open += d == 0 || d >= 1.25;
        }
        open_rays += (uint64_t)open;
        near_pixels += nearest < 1.25;
        assert_true(half_at(all->first, PLANE_BOUNCE_DISTANCE_MIN, 0, i) == nearest);
        assert_true(fabs(half_at(all->first, PLANE_AMBIENT_VISIBILITY, 0, i) - open / 16) < 1e-3);
        assert_true(half_at(alone->first, PLANE_AMBIENT_VISIBILITY, 0, i) ==
                    half_at(all->first, PLANE_AMBIENT_VISIBILITY, 0, i));
        assert_true(half_at(alone->first, PLANE_BOUNCE_DISTANCE_MIN, 0, i) ==
                    (nearest < 1.25 ? nearest : (double)BOUNCE_DISTANCE_NONE));
    }
    assert_true(open_rays > 0 && open_rays < 16 * AREA && near_pixels > 0);
    assert_int_equal(alone->counters.value[COUNTER_RAYS_OCCLUSION], 16 * AREA);
    assert_int_equal(alone->counters.value[COUNTER_RAYS_INDIRECT], 0);
    assert_int_equal(all->counters.value[COUNTER_RAYS_OCCLUSION], 0);
    assert_true(all->counters.value[COUNTER_RAYS_INDIRECT] >= 16 * AREA);
    sums_free(&all);
    sums_free(&alone);
    free(f);
}

/* Any part of the picture has the bytes of the whole, borders within blocks or not. */
TEST(tiles_do_not_matter)
{
    static const struct rect parts[] = {{0, 0, 5, 16}, {5, 0, 16, 7}, {5, 7, 16, 16}, {3, 3, 4, 4}};
    struct scene_fixture *f = fixture_new();
    struct plan p = room(f, COATED, SHINES_RECT | SHINES_MESH | SHINES_SKY);
    p.camera.half_width = p.camera.half_height = 0.6f;
    p.bounces = 3;
    p.paths.spp = 4;
    add_field(&p, 3);
    p.planes |= BIT(AMBIENT_VISIBILITY) | BIT(SUB_ALBEDO) | BIT(INDIRECT_STRATA);
    p.sub_samples = 2;
    p.occlusion_distance = 1.0f;
    struct traced whole = trace_all(f, &p);
    for (int k = 0; k < 4; k++) {
        struct traced part = trace(f, &p, parts[k]);
        for (int32_t y = parts[k].y0; y < parts[k].y1; y++)
            for (int32_t x = parts[k].x0; x < parts[k].x1; x++) {
                int32_t to = (y - parts[k].y0) * rect_width(parts[k]) + x - parts[k].x0;
                int32_t from = y * SIDE_PX + x;
                for (uint32_t c = 0; c < 4 * 9; c++)
                    assert_int_equal(samples_u16(whole.samples, PLANE_INDIRECT_STRATA, c)[from],
                                     samples_u16(part.samples, PLANE_INDIRECT_STRATA, c)[to]);
                for (uint32_t c = 0; c < 3; c++) {
                    assert_int_equal(samples_u16(whole.samples, PLANE_SUB_ALBEDO, c)[from],
                                     samples_u16(part.samples, PLANE_SUB_ALBEDO, c)[to]);
                    assert_true(samples_f32(whole.samples, PLANE_PATH_RADIANCE, c)[from] ==
                                samples_f32(part.samples, PLANE_PATH_RADIANCE, c)[to]);
                }
                assert_int_equal(samples_u16(whole.samples, PLANE_AMBIENT_VISIBILITY, 0)[from],
                                 samples_u16(part.samples, PLANE_AMBIENT_VISIBILITY, 0)[to]);
            }
        traced_fini(&part);
    }
    traced_fini(&whole);
    free(f);
}

/* Sub-samples' diffuse albedo marks a pixel too: stripes of a metal and a matt colour
 * leaves no pixel without light, and none is lit that has only metal. */
TEST(diffuse_albedo_decides)
{
    uint8_t metal_or_not[4 * 16];
    for (int i = 0; i < 64; i++) metal_or_not[i] = i % 4 == 2 && i / 8 % 2 ? 0 : 255;
    struct scene_fixture *f = fixture_new();
    struct plan p = room(f, DIELECTRIC, SHINES_RECT);
    f->materials[0].metallic = 1.0f;
    f->materials[0].metallic_roughness_texture.texture = fixture_texture(f, 16, 1, metal_or_not, 0);
    p.camera.half_width = p.camera.half_height = 0.4f;
    p.bounces = 1;
    add_field(&p, 2);
    p.planes |= BIT(SUB_ALBEDO);
    p.sub_samples = 3;
    struct traced t = trace_all(f, &p);
    int dark = 0, mixed = 0, bright = 0;
    for (int i = 0; i < AREA; i++) {
        bool centre = samples_u16(t.samples, PLANE_ALBEDO, 0)[i] > 0, any = centre;
        for (uint32_t k = 0; k < 3; k++)
            any |= samples_u16(t.samples, PLANE_SUB_ALBEDO, 3 * k)[i] > 0;
        assert_int_equal(samples_u16(t.samples, PLANE_BOUNCE_DISTANCE_MIN, 0)[i] != 0, any);
        dark += !any;
        bright += centre;
        mixed += any && !centre && half_at(t.samples, PLANE_INDIRECT_MEAN, 0, i) > 0;
    }
    assert_true(dark > 0 && mixed > 0 && bright > 0);
    /* Occlusion is of all, and rays for its sake alone bring no light. */
    p.planes |= BIT(AMBIENT_VISIBILITY) | BIT(AMBIENT_DISTANCE_MIN);
    p.occlusion_distance = 1e6f;
    struct traced open = trace_all(f, &p);
    assert_memory_equal(samples_u16(t.samples, PLANE_BOUNCE_DISTANCE_MIN, 0),
                        samples_u16(open.samples, PLANE_BOUNCE_DISTANCE_MIN, 0), 2 * AREA);
    for (uint32_t c = 0; c < 3; c++)
        assert_memory_equal(samples_u16(t.samples, PLANE_INDIRECT_MEAN, c),
                            samples_u16(open.samples, PLANE_INDIRECT_MEAN, c), 2 * AREA);
    for (int i = 0; i < AREA; i++)
        assert_true(samples_u16(open.samples, PLANE_AMBIENT_DISTANCE_MIN, 0)[i] != 0);
    traced_fini(&open);
    traced_fini(&t);
    free(f);
}

/* Radiance beyond what floats hold: black, counted, and no plane holds anything but numbers. */
TEST(samples_that_are_not_finite_are_rejected)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = room(f, LAMBERT, 0);
    for (uint32_t k = 1; k < f->material_count; k++)
        for (int c = 0; c < 3; c++) f->materials[k].emission[c] = 3e38f;
    p.bounces = 4;
    p.paths.spp = 0;
    p.paths.emitter_power = 1.0f;
    p.planes = 0;
    add_field(&p, 3);
    p.planes |= BIT(INDIRECT_HALVES) | BIT(INDIRECT_STRATA);
    struct sums *s = trace_sums(f, &p);
    assert_true(s->counters.value[COUNTER_REJECTED_NOT_FINITE] > 0);
    for (int i = 0; i < AREA; i++) {
        for (uint32_t c = 0; c < 4 * 9; c++)
            assert_true(half_at(s->first, PLANE_INDIRECT_STRATA, c, i) < (double)INFINITY);
        for (uint32_t c = 0; c < 6; c++)
            assert_true(half_at(s->first, PLANE_INDIRECT_HALVES, c, i) < (double)INFINITY);
        for (uint32_t c = 0; c < 3; c++)
            assert_true(half_at(s->first, PLANE_INDIRECT_MEAN, c, i) < (double)INFINITY);
    }
    sums_free(&s);
    free(f);
}

/* A frame of one pixel, and surfaces of every size: the same, but for the unit of length. */
TEST(size_does_not_matter)
{
    static const float scales[] = {1.0f, 0x1p-13f, 0x1p16f};
    uint16_t mean[3] = {0}, bounce_distance_min[3] = {0};
    for (int k = 0; k < 3; k++) {
        struct scene_fixture *f = fixture_new();
        struct plan p = room(f, DIELECTRIC, SHINES_RECT | SHINES_SKY);
        for (uint32_t i = 0; i < 3 * f->vertex_count; i++) f->positions[i] *= scales[k];
        for (int i = 0; i < 3; i++) {
            p.camera.eye[i] *= scales[k];
            p.lights[0].position[i] *= scales[k];
            p.lights[0].half_u[i] *= scales[k];
            p.lights[0].half_v[i] *= scales[k];
        }
        p.width_px = p.height_px = 1;
        p.length_unit = scales[k];
        p.bounces = 2;
        p.paths.spp = 0;
        p.planes = 0;
        add_field(&p, 16);
        struct traced t = trace_all(f, &p);
        mean[k] = *samples_u16(t.samples, PLANE_INDIRECT_MEAN, 0);
        bounce_distance_min[k] = *samples_u16(t.samples, PLANE_BOUNCE_DISTANCE_MIN, 0);
        assert_true(half_to_float(mean[k]) > 0.0f && half_to_float(bounce_distance_min[k]) > 0.0f);
        traced_fini(&t);
        free(f);
    }
    /* scaled by powers of two: the same but where Embree or an offset rounds otherwise */
    for (int k = 1; k < 3; k++) {
        assert_in_range(bounce_distance_min[k], bounce_distance_min[0] - 1u,
                        bounce_distance_min[0] + 1u);
        assert_true(fabsf(half_to_float(mean[k]) - half_to_float(mean[0])) <
                    0.05f * half_to_float(mean[0]));
    }
}

/* Nothing met, something at once, nothing sent. */
TEST(a_hit_at_once_is_a_hit)
{
    struct path_scratch *s = aligned_alloc(LANES_ALIGN, sizeof *s);
    assert_non_null(s);
    path_scratch_init(s);
    struct path_packet *p = &s->pools[0].packets[0];
    struct lanes_mask valid = {{-1, -1, -1, 0}};
    p->count = 4;
    for (uint32_t i = 0; i < 4; i++) {
        p->slot[i] = i;
        p->rays.hit.geomID[i] = i == 1 ? RTC_INVALID_GEOMETRY_ID : 0;
        p->rays.ray.tfar[i] = i == 1 ? INFINITY : 0.5f * (float)i;
    }
    path_note_reach(p, &valid, &s->radiance);
    assert_true(s->radiance.distance[0] > 0.0f && s->radiance.distance[0] < 1e-30f);
    assert_true(s->radiance.distance[1] == INFINITY);
    assert_true(s->radiance.distance[2] == 1.0f);
    assert_true(s->radiance.distance[3] == 0.0f);
    free(s);
}
