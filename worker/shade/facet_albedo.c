#include "worker/shade/facet_albedo.h"

#include <pthread.h>
#include <stdatomic.h>

#include "worker/shade/coupling.h"
#include "worker/shade/direction.h"

/* Azimuths lie evenly from x to y: lobes are alike in all quarters. */
#define AZIMUTHS     9
#define SAMPLES      144 /* of a lattice whose steps are Fibonacci numbers */
#define LATTICE      89
#define QUARTER      (0.5f * ELEMENTARY_PI)
#define EXPONENT_MAX 1e5f
#define COSINE_LEAST 1e-3f

/* What is known of facets of one pair of widths, by azimuth and sqrt(cosine). */
struct slab {
    atomic_bool made;
    float share[AZIMUTHS][COUPLING_NODES];
    float root[AZIMUTHS][COUPLING_NODES]; /* the fifth root of grazing */
};

/* Models with facets; by sqrt of both widths in equal steps. */
enum { KINDS = 5 };
static struct slab slabs[KINDS][COUPLING_NODES][COUPLING_NODES];
static pthread_mutex_t making = PTHREAD_MUTEX_INITIALIZER;

static int kind_of(enum bsdf_model model)
{
    return model == BSDF_GLTF          ? 0
           : model == BSDF_BLINN_PHONG ? 1
           : model == BSDF_BECKMANN    ? 2
           : model == BSDF_WARD        ? 3
                                       : 4;
}

static float width_of(float exponent)
{
    return sqrtf(2.0f / (exponent + 2.0f));
}

static float exponent_of(float width)
{
    const float squared = width * width;
    const float n = squared > 0.0f ? 2.0f / squared - 2.0f : EXPONENT_MAX;
    return n < EXPONENT_MAX ? n : EXPONENT_MAX;
}

void facet_widths(const struct bsdf *b, float alpha[2])
{
    const bool along = b->model == BSDF_BLINN_PHONG, both = b->model == BSDF_ASHIKHMIN_SHIRLEY;
    alpha[0] = along || both ? width_of(b->exponent_u) : b->alpha_u;
    alpha[1] = along ? alpha[0] : both ? width_of(b->exponent_v) : b->alpha_v;
}

/* Facets of these widths that reflect `color` at normal incidence, under Schlick's Fresnel. */
static struct bsdf facets(enum bsdf_model model, const float width[2], float color)
{
    return (struct bsdf){.model = model,
                         .alpha_u = width[0],
                         .alpha_v = width[1],
                         .exponent_u = exponent_of(width[0]),
                         .exponent_v = exponent_of(width[1]),
                         .base_color = {color, color, color},
                         .metallic = 1.0f,
                         .ior = 1.5f,
                         .model_specular = {color, color, color}};
}

/* Returns the mean weight of samples of a lobe beside which there is no other. */
static float mean_weight(const struct bsdf *b, const float wo[3])
{
    float sum = 0.0f;
    for (int i = 0; i < SAMPLES; i++) {
        const float u[2] = {((float)i + 0.5f) / SAMPLES,
                            ((float)(i * LATTICE % SAMPLES) + 0.5f) / SAMPLES};
        struct bsdf_sample s;
        if (bsdf_sample(b, wo, 0.0f, u, &s)) sum += s.specular[0];
    }
    return sum / SAMPLES;
}

static void make(enum bsdf_model model, const float width[2], struct slab *s)
{
    const struct bsdf white = facets(model, width, 1.0f), black = facets(model, width, 0.0f);
    for (int a = 0; a < AZIMUTHS; a++)
        for (int c = 0; c < COUPLING_NODES; c++) {
            const float root = (float)c / (COUPLING_NODES - 1), z = root * root;
            const float azimuth = QUARTER * (float)a / (AZIMUTHS - 1);
            const float cosine = z > COSINE_LEAST ? z : COSINE_LEAST;
            const float sine = sqrtf((1.0f - cosine) * (1.0f + cosine));
            const float wo[3] = {sine * elementary_cos(azimuth), sine * elementary_sin(azimuth),
                                 cosine};
            const float share = mean_weight(&white, wo), grazing = mean_weight(&black, wo);
            s->share[a][c] = share;
            s->root[a][c] = share > 0.0f ? facet_fifth_root(grazing / share) : 0.0f;
        }
}

static const struct slab *slab_at(enum bsdf_model model, int u, int v)
{
    struct slab *s = &slabs[kind_of(model)][u][v];
    const float root[2] = {(float)u / (COUPLING_NODES - 1), (float)v / (COUPLING_NODES - 1)};
    const float width[2] = {root[0] * root[0], root[1] * root[1]};
    if (atomic_load_explicit(&s->made, memory_order_acquire)) return s;
    pthread_mutex_lock(&making);
    if (!atomic_load_explicit(&s->made, memory_order_relaxed)) make(model, width, s);
    atomic_store_explicit(&s->made, true, memory_order_release);
    pthread_mutex_unlock(&making);
    return s;
}

/* A direction among the nodes of a slab. */
struct spot {
    int azimuth, cosine;
    float turn, rise; /* fractions up to the next nodes */
};

static float between(const float table[][COUPLING_NODES], const struct spot *at)
{
    const float *a = &table[at->azimuth][at->cosine], *b = &table[at->azimuth + 1][at->cosine];
    const float low = a[0] + (a[1] - a[0]) * at->rise, high = b[0] + (b[1] - b[0]) * at->rise;
    return low + (high - low) * at->turn;
}

static struct spot spot_of(const float wo[3])
{
    struct spot at;
    const float turn = elementary_atan2(fabsf(wo[1]), fabsf(wo[0])) * ((AZIMUTHS - 1) / QUARTER);
    at.azimuth = turn < AZIMUTHS - 2 ? (int)turn : AZIMUTHS - 2;
    at.turn = turn - (float)at.azimuth;
    at.cosine = coupling_node(sqrtf(wo[2] < 1.0f ? wo[2] : 1.0f), &at.rise);
    return at;
}

struct facet_albedo facet_albedo_of(const struct bsdf *b, const float wo[3])
{
    float width[2], f[2], share = 0.0f, root = 0.0f;
    facet_widths(b, width);
    const struct spot at = spot_of(wo);
    const int u = coupling_node(sqrtf(width[0]), &f[0]), v = coupling_node(sqrtf(width[1]), &f[1]);
    for (int k = 0; k < 4; k++) {
        const float x = k & 1 ? f[0] : 1.0f - f[0], y = k & 2 ? f[1] : 1.0f - f[1];
        if (!(x * y > 0.0f)) continue;
        const struct slab *s = slab_at(b->model, u + (k & 1), v + (k >> 1));
        share += x * y * between(s->share, &at);
        root += x * y * between(s->root, &at);
    }
    const float square = root * root;
    return (struct facet_albedo){share, square * square * root};
}
