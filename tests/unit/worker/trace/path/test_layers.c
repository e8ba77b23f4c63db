/* Layers in lanes bring the bits of the models one by one, on every instruction set. */
#include "tests/random.h"
#include "tests/unit/unit.h"
#include "tests/unit/worker/tile_fixture.h"
#include "tests/unit/worker/trace/field/glossy_fixture.h"
#include "tests/unit/worker/trace/isa_fixture.h"

#include "worker/shade/direction.h"
#include "worker/trace/path/path_kernels.h"

static const float shares[] = {0.0f, 1e-7f, 0.3f, 0.8f, 0.9999999f, 1.0f};
static const float alphas[] = {0.0f, 0.99e-4f, 1e-4f, 1.01e-4f, 1e-3f, 0.1f, 0.5f, 1.0f};

static float share(struct random *r)
{
    return random_bits(r) & 1 ? random_unit(r) : shares[random_bits(r) % 6];
}

static float alpha(struct random *r)
{
    return random_bits(r) & 1 ? random_unit(r) : alphas[random_bits(r) % 8];
}

/* Mostly layers; others among them. */
static struct bsdf random_bsdf(struct random *r)
{
    struct bsdf b = {.model = random_bits(r) % 8 ? BSDF_GLTF : BSDF_PHONG, .ior = 1.5f};
    b.alpha_u = b.alpha_v = alpha(r);
    if (random_bits(r) & 1) b.alpha_v = alpha(r);
    b.metallic = share(r), b.specular = share(r), b.exponent_u = 20.0f;
    b.seen = random_bits(r) % 2;
    b.transmission = random_bits(r) % 8 ? 0.0f : share(r);
    for (int k = 0; k < 3; k++) {
        b.base_color[k] = share(r), b.specular_f0[k] = share(r);
        b.albedo[k] = b.base_color[k] * (1.0f - b.metallic) * (1.0f - b.transmission);
    }
    return b;
}

/* Unit, `lift` of it along z at most. */
static void random_direction(struct random *r, float lift, float d[3])
{
    const float x = random_unit(r) - 0.5f, y = random_unit(r) - 0.5f;
    direction_normalize(x, y, lift * (random_unit(r) - 0.2f), d);
}

static void put(const float d[3], int i, struct lanes3 *out)
{
    out->x[i] = d[0], out->y[i] = d[1], out->z[i] = d[2];
}

static void get(const struct lanes3 *from, int i, float d[3])
{
    d[0] = from->x[i], d[1] = from->y[i], d[2] = from->z[i];
}

static void random_vertex(struct random *r, struct path_vertex *v)
{
    memset(v, 0, sizeof *v);
    v->any_general = true;
    for (int i = 0; i < LANES; i++) {
        float n[3], s[3], t[3], facet[3], back[3];
        random_direction(r, 1.0f, n);
        direction_frame(n, s, t);
        for (int k = 0; k < 3; k++) facet[k] = n[k] + 0.2f * (random_unit(r) - 0.5f);
        random_direction(r, random_bits(r) % 4 ? 2.0f : 1e-3f, back);
        if (random_bits(r) % 16 == 0) back[2] = 1e-7f;
        if (random_bits(r) % 16 == 0) direction_set(0.0f, 0.0f, 1.0f, back);
        put(n, i, &v->surface.normal), put(facet, i, &v->surface.facet);
        put(s, i, &v->tangent), put(t, i, &v->bitangent);
        put(back, i, &v->back);
        v->bsdf[i] = random_bsdf(r);
        v->active.on[i] = random_bits(r) % 8 ? -1 : 0;
        v->lambert.on[i] = random_bits(r) % 8 ? 0 : v->active.on[i];
    }
}

static void to_frame(const struct path_vertex *v, int i, const float d[3], float out[3])
{
    float s[3], t[3], n[3];
    get(&v->tangent, i, s), get(&v->bitangent, i, t), get(&v->surface.normal, i, n);
    direction_set(direction_dot(d, s), direction_dot(d, t), direction_dot(d, n), out);
}

/* Which lanes are layers, and that others are told of. */
static int check_on(const struct path_vertex *v, const struct layers *l)
{
    int count = 0;
    bool others = false;
    for (int i = 0; i < LANES; i++) {
        const struct bsdf *b = &v->bsdf[i];
        const bool general = v->active.on[i] && !v->lambert.on[i];
        const bool smooth = b->alpha_u < BSDF_SMOOTH && b->alpha_v < BSDF_SMOOTH;
        const bool on = general && b->model == BSDF_GLTF && b->transmission == 0.0f && !smooth;
        assert_int_equal(l->on.on[i], on ? -1 : 0);
        others |= general && !on;
        count += on;
    }
    assert_int_equal(l->any, count > 0);
    assert_int_equal(l->others, others);
    return count;
}

static void same(const struct lanes3 *got, int i, const float expected[3])
{
    float at[3];
    get(got, i, at);
    assert_memory_equal(at, expected, sizeof at);
}

static const float untouched[3] = {7.0f, 8.0f, 9.0f};

static void fill(struct lanes3 *out)
{
    for (int i = 0; i < LANES; i++) put(untouched, i, out);
}

/* Lane i of what paths scatter, as one bsdf_sample has it; returns whether it goes on. */
static bool check_scattered(const struct path_vertex *v, int i, float choice, const float u[2],
                            const struct path_scattering *s)
{
    struct bsdf_sample sample;
    float wo[3], n[3], t[3], b[3], facet[3], d[3], weight[3];
    get(&v->back, i, wo), get(&v->surface.normal, i, n), get(&v->surface.facet, i, facet);
    get(&v->tangent, i, t), get(&v->bitangent, i, b);
    bool goes = bsdf_sample(&v->bsdf[i], wo, choice, u, &sample);
    for (int k = 0; goes && k < 3; k++) {
        d[k] = sample.wi[0] * t[k] + sample.wi[1] * b[k] + sample.wi[2] * n[k];
        weight[k] = v->bsdf[i].albedo[k] * sample.diffuse + sample.specular[k];
    }
    goes = goes && direction_dot(d, facet) > 0.0f;
    assert_int_equal(s->on.on[i], goes ? -1 : 0);
    assert_int_equal(s->through.on[i], 0);
    if (!goes) return false;
    same(&s->direction, i, d), same(&s->weight, i, weight), same(&s->specular, i, sample.specular);
    assert_true(s->pdf[i] == sample.pdf && s->diffuse[i] == sample.diffuse);
    return true;
}

TEST(test_scatter)
{
    static struct path_vertex v;
    static struct path_scattering s;
    struct random seed = {3};
    int checked = 0, gone = 0;
    for (int round = 0; round < 1500; round++) {
        _Alignas(64) float choice[LANES], u[LANES], w[LANES];
        random_vertex(&seed, &v);
        for (int i = 0; i < LANES; i++) {
            choice[i] = random_unit(&seed), u[i] = random_unit(&seed), w[i] = random_unit(&seed);
            if (random_bits(&seed) % 8 == 0) w[i] = i & 1 ? 0.0f : 0x1.fffffep-1f;
        }
        for (int k = 0; k < isa_count(); k++) {
            const struct path_kernels *kernels = KERNELS_FOR(path_kernels, all_isas[k]);
            layers_see(kernels, &v, &v.layers);
            checked += check_on(&v, &v.layers);
            if (!v.layers.any) continue;
            memset(&s, 0xff, sizeof s);
            fill(&s.weight);
            kernels->layers_scatter(&v, choice, u, w, &s);
            for (int i = 0; i < LANES; i++) {
                if (v.layers.on.on[i])
                    gone += check_scattered(&v, i, choice[i], (float[]){u[i], w[i]}, &s);
                else
                    same(&s.weight, i, untouched);
            }
        }
    }
    assert_true(checked > 10000 && gone > checked / 2 && gone < checked);
}

/* Lane i of what a light sample sends on, as one bsdf_evaluate has it. */
static void check_lit(const struct path_vertex *v, const struct nee_sample *l, int i,
                      float probability, const struct lanes3 *diffuse, const struct lanes3 *all)
{
    const struct RTCRay16 *r = &l->packet.rays.ray;
    const struct bsdf *b = &v->bsdf[i];
    const float d[3] = {r->dir_x[i], r->dir_y[i], r->dir_z[i]};
    const float squared = direction_dot(d, d), scale = 1.0f / sqrtf(squared > 0 ? squared : 1.0f);
    float wo[3], wi[3], color[3], white[3], whole[3];
    struct bsdf_value f;
    get(&v->back, i, wo), get(&l->color, i, color), to_frame(v, i, d, wi);
    for (int k = 0; k < 3; k++) wi[k] = scale * wi[k];
    bsdf_evaluate(b, wo, wi, &f);
    const float density = l->packet.density[i] * probability;
    const float ratio = density > 0.0f ? f.pdf / density : 0.0f;
    const float e = l->packet.irradiance[i] / (1.0f + ratio * ratio);
    for (int k = 0; k < 3; k++) {
        white[k] = f.diffuse * e * color[k];
        whole[k] = (b->albedo[k] * f.diffuse + f.specular[k]) * e * color[k];
    }
    same(diffuse, i, white), same(all, i, whole);
}

static void random_samples(struct random *r, struct nee_sample *l, float probability[LANES])
{
    memset(l, 0, sizeof *l);
    for (int i = 0; i < LANES; i++) {
        float d[3];
        random_direction(r, 3.0f, d);
        l->packet.rays.ray.dir_x[i] = 3.0f * d[0];
        l->packet.rays.ray.dir_y[i] = 3.0f * d[1];
        l->packet.rays.ray.dir_z[i] = random_bits(r) % 32 ? 3.0f * d[2] : 0.0f;
        l->packet.density[i] = random_bits(r) % 4 ? 5.0f * random_unit(r) : 0.0f;
        l->packet.irradiance[i] = random_unit(r);
        l->packet.traced.on[i] = random_bits(r) % 4 ? -1 : 0;
        l->color.x[i] = random_unit(r), l->color.y[i] = 100.0f * random_unit(r);
        l->color.z[i] = random_unit(r);
        probability[i] = random_unit(r);
    }
}

TEST(test_light)
{
    static struct path_vertex v;
    static struct nee_sample l;
    struct random seed = {4};
    for (int round = 0; round < 1500; round++) {
        _Alignas(64) float probability[LANES];
        struct lanes3 diffuse, all;
        random_vertex(&seed, &v);
        random_samples(&seed, &l, probability);
        for (int k = 0; k < isa_count(); k++) {
            const struct path_kernels *kernels = KERNELS_FOR(path_kernels, all_isas[k]);
            layers_see(kernels, &v, &v.layers);
            if (!v.layers.any) continue;
            fill(&diffuse), fill(&all);
            kernels->layers_light(&l, &v, probability, &diffuse, &all);
            for (int i = 0; i < LANES; i++) {
                if (v.layers.on.on[i] & l.packet.traced.on[i])
                    check_lit(&v, &l, i, probability[i], &diffuse, &all);
                else
                    same(&diffuse, i, untouched), same(&all, i, untouched);
            }
        }
    }
}

TEST(test_diffuse)
{
    static struct path_vertex v;
    struct random seed = {5};
    for (int round = 0; round < 1500; round++) {
        struct lanes3 way;
        random_vertex(&seed, &v);
        for (int i = 0; i < LANES; i++) {
            float d[3];
            random_direction(&seed, 3.0f, d);
            put(d, i, &way);
        }
        for (int k = 0; k < isa_count(); k++) {
            const struct path_kernels *kernels = KERNELS_FOR(path_kernels, all_isas[k]);
            _Alignas(64) float weight[LANES];
            for (int i = 0; i < LANES; i++) weight[i] = 7.0f;
            layers_see(kernels, &v, &v.layers);
            if (!v.layers.any) continue;
            kernels->layers_diffuse(&v, &v.layers, &way, weight);
            for (int i = 0; i < LANES; i++) {
                struct bsdf white = v.bsdf[i];
                struct bsdf_value f;
                float wo[3], wi[3], d[3];
                white.albedo[0] = white.albedo[1] = white.albedo[2] = 1.0f;
                get(&way, i, d), get(&v.back, i, wo), to_frame(&v, i, d, wi);
                bsdf_evaluate(&white, wo, wi, &f);
                assert_true(weight[i] == (v.layers.on.on[i] ? ELEMENTARY_PI * f.diffuse : 7.0f));
            }
        }
    }
}

/* Of the isotropic ones; pairs of numbers are those of path_pair. */
TEST(test_gloss)
{
    static struct path_vertex v;
    struct random seed = {6};
    for (int round = 0; round < 1500; round++) {
        _Alignas(64) float u[LANES], w[LANES];
        uint32_t sample[LANES];
        const uint32_t key = (uint32_t)random_bits(&seed);
        random_vertex(&seed, &v);
        for (int i = 0; i < LANES; i++) sample[i] = (uint32_t)random_bits(&seed);
        for (int k = 0; k < isa_count(); k++) {
            const struct path_kernels *kernels = KERNELS_FOR(path_kernels, all_isas[k]);
            struct layer_gloss lobe;
            layers_see(kernels, &v, &v.layers);
            if (!v.layers.any) continue;
            kernels->frame_pairs(key, sample, 5, u, w);
            kernels->layers_gloss(&v, &v.layers, u, w, &lobe);
            for (int i = 0; i < LANES; i++) {
                float at[2], wo[3], wi[3], weight[3], way[3], back[3], facet[3];
                path_pair(key, sample[i], 5, &at[0], &at[1]);
                assert_true(u[i] == at[0] && w[i] == at[1]);
                if (!v.layers.on.on[i]) assert_int_equal(lobe.on.on[i], 0);
                if (!v.layers.on.on[i] || !glossy_has(&v.bsdf[i])) continue;
                get(&v.back, i, wo), get(&v.surface.facet, i, facet);
                const bool on = glossy_sample_ggx(&v.bsdf[i], wo, at, wi, weight);
                assert_int_equal(lobe.on.on[i], on ? -1 : 0);
                if (!on) continue;
                same(&lobe.local, i, wi), same(&lobe.weight, i, weight);
                get(&lobe.direction, i, way), to_frame(&v, i, way, back);
                for (int c = 0; c < 3; c++) assert_true(fabsf(back[c] - wi[c]) < 1e-5f);
                assert_int_equal(lobe.above.on[i], direction_dot(way, facet) > 0.0f ? -1 : 0);
            }
        }
    }
}
