/* Facets of round surfaces stand in no light that the surface itself sees (lift_lanes.h). */
#include <math.h>
#include <stdlib.h>

#include "proto/octahedron.h"
#include "tests/unit/unit.h"
#include "tests/unit/worker/tile_fixture.h"
#include "tests/unit/worker/trace/isa_fixture.h"
#include "worker/trace/hit/hit_kernels.h"

enum { SIDE_PX = 64, RINGS = 8, SEGMENTS = 16 };

static const float sun[3] = {-0.8899382f, -0.2966461f, 0.3461f}; /* beside all meridians */

static void sphere_vertex(struct scene_fixture *f, const float centre[3], float radius, int ring,
                          int segment)
{
    const double polar = M_PI * ring / RINGS, around = 2 * M_PI * segment / SEGMENTS;
    float *n = f->normals + (size_t)3 * f->vertex_count;
    n[0] = (float)(sin(polar) * cos(around));
    n[1] = (float)cos(polar);
    n[2] = (float)(sin(polar) * sin(around));
    fixture_vertex(f, centre[0] + radius * n[0], centre[1] + radius * n[1],
                   centre[2] + radius * n[2]);
}

/* A coarse sphere with smooth normals; its mesh. */
static uint32_t add_sphere(struct scene_fixture *f, const float centre[3], float radius)
{
    const uint32_t material = fixture_material(f, 0.5f, 0.5f, 0.5f);
    const uint32_t mesh = fixture_mesh(f, material, MESH_HAS_NORMALS);
    for (int ring = 0; ring <= RINGS; ring++)
        for (int s = 0; s <= SEGMENTS; s++) sphere_vertex(f, centre, radius, ring, s);
    for (uint32_t ring = 0; ring < RINGS; ring++)
        for (uint32_t s = 0; s < SEGMENTS; s++) {
            const uint32_t a = ring * (SEGMENTS + 1) + s, b = a + SEGMENTS + 1;
            fixture_triangle(f, a, a + 1, b);
            fixture_triangle(f, a + 1, b + 1, b);
        }
    return mesh;
}

static struct plan lit_plan(void)
{
    struct plan p = fixture_plan(SIDE_PX, SIDE_PX, (float[]){0, 0, 5}, 0.22f);
    struct plan_light *light = fixture_light(&p, LIGHT_DIRECTIONAL, 1);
    memcpy(light->direction, sun, sizeof sun);
    return p;
}

static double sun_cosine(const struct traced *t, int32_t i)
{
    float n[3];
    octahedron_unpack16(samples_u32(t->samples, PLANE_NORMAL, 0)[i], n);
    return -(double)(n[0] * sun[0] + n[1] * sun[1] + n[2] * sun[2]);
}

/* The field's irradiance is the cosine to the smooth normal, up to the terminator. */
static void expect_cosines(const struct traced *t)
{
    uint32_t lit = 0, dark = 0;
    for (int32_t i = 0; i < SIDE_PX * SIDE_PX; i++) {
        if (samples_u32(t->samples, PLANE_ID, 0)[i] == 0) continue;
        const double cosine = sun_cosine(t, i);
        const double got = (double)samples_light_irradiance(t->samples, 0)[i];
        if (fabs(cosine) < 0.01) continue; /* on the terminator itself */
        lit += cosine > 0;
        dark += cosine < 0;
        assert_true(fabs(got - fmax(cosine, 0)) < 2e-3);
    }
    assert_true(lit > 300 && dark > 300);
}

TEST(fields_end_at_the_smooth_terminator)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = lit_plan();
    fixture_place(f, add_sphere(f, (float[]){0, 0, 0}, 1));
    struct traced t = trace_all(f, &p);
    expect_cosines(&t);
    traced_fini(&t);
    free(f);
}

TEST(instances_do_as_well)
{
    static const float m[12] = {0, 0, -2, 0, 0, 2, 0, -1, 2, 0, 0, 0}; /* turned and larger */
    struct scene_fixture *f = fixture_new();
    struct plan p = lit_plan();
    fixture_place_at(f, add_sphere(f, (float[]){0, 0.5f, 0}, 0.5f), m);
    struct traced t = trace_all(f, &p);
    expect_cosines(&t);
    traced_fini(&t);
    free(f);
}

TEST(paths_end_at_the_smooth_terminator)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = lit_plan();
    p.light_planes = 0;
    p.planes |= PLANES_PATH & ~PLANE_BIT(PATH_VISIBILITY);
    p.paths.spp = 1;
    fixture_place(f, add_sphere(f, (float[]){0, 0, 0}, 1));
    struct traced t = trace_all(f, &p);
    uint32_t grazed = 0;
    for (int32_t i = 0; i < SIDE_PX * SIDE_PX; i++) {
        if (samples_u32(t.samples, PLANE_ID, 0)[i] == 0) continue;
        const double cosine = sun_cosine(&t, i); /* at the centre: paths are within half a pixel */
        const double got = (double)samples_f32(t.samples, PLANE_PATH_RADIANCE, 0)[i] * 2 * M_PI;
        if (cosine < 0.1 || cosine > 0.3) continue;
        grazed++;
        if (samples_u32(t.samples, PLANE_ID, 0)[i + 1] &&
            samples_u32(t.samples, PLANE_ID, 0)[i - 1])
            assert_true(fabs(got - cosine) < 0.08);
    }
    assert_true(grazed > 100);
    traced_fini(&t);
    free(f);
}

/* Resolves a ray straight down onto (x, 0, z). */
static void resolve(struct render_scene *scene, const struct hit_kernels *kernels, float x, float z,
                    struct surface *s)
{
    struct queries q;
    struct lanes_mask valid = {0};
    _Alignas(LANES_ALIGN) struct RTCRayHit16 rays;
    queries_init(&q);
    q.scene = scene;
    q.kernels = kernels;
    queries_init_rays(&rays);
    valid.on[3] = -1;
    rays.ray.org_x[3] = x, rays.ray.org_y[3] = 2, rays.ray.org_z[3] = z;
    rays.ray.dir_y[3] = -1;
    rays.ray.tfar[3] = INFINITY;
    queries_closest(&q, QUERY_CAMERA, &valid, &rays);
    hit_resolve(&q, &valid, &rays, s);
    assert_true(s->hit.on[3]);
}

/* Two triangles of a level square whose corners' normals lean outwards by `lean`. */
static struct render_scene *square(struct scene_fixture *f, float lean)
{
    static const float corner[4][2] = {{-1, -1}, {-1, 1}, {1, 1}, {1, -1}};
    struct render_scene *scene;
    struct fault fault = {0};
    const float scale = 1.0f / sqrtf(1.0f + 2.0f * lean * lean);
    const uint32_t mesh = fixture_mesh(f, fixture_material(f, 0.5f, 0.5f, 0.5f), MESH_HAS_NORMALS);
    for (int k = 0; k < 4; k++) {
        float *n = f->normals + (size_t)3 * f->vertex_count;
        n[0] = lean * scale * corner[k][0], n[1] = scale, n[2] = lean * scale * corner[k][1];
        fixture_vertex(f, corner[k][0], 0, corner[k][1]);
    }
    fixture_triangle(f, 0, 1, 2);
    fixture_triangle(f, 0, 2, 3);
    fixture_place(f, mesh);
    assert_int_equal(render_scene_create(fixture_scene(f), 1, NULL, &scene, &fault), 0);
    return scene;
}

/* On the diagonal only its ends count. At (a, a) the plane of the near end is 2 lean (1 - a) scale
 * away along its normal, that of the far end 2 lean (1 + a) scale; their shares are (1 + a) / 2 and
 * (1 - a) / 2. Normals further from the facet's than 39 degrees lift nothing. */
TEST(normals_that_lean_outwards_lift)
{
    static const float leans[] = {0, 0.2f, -0.2f, 1}, a = 0.25f;
    for (int k = 0; k < isa_count(); k++)
        for (size_t row = 0; row < sizeof leans / sizeof *leans; row++) {
            static struct surface s;
            struct scene_fixture *f = fixture_new();
            struct render_scene *scene = square(f, leans[row]);
            const float lift = 2 * leans[row] * (1 - a * a) / (1 + 2 * leans[row] * leans[row]);
            const bool lifted = row == 1;
            resolve(scene, KERNELS_FOR(hit_kernels, all_isas[k]), a, a, &s);
            assert_true(fabsf(s.lift.y[3] - (lifted ? lift : 0)) < 1e-5f);
            assert_true(fabsf(s.origin.y[3]) < 1e-5f && s.plane.y[3] == 1.0f);
            assert_true((s.facet.y[3] == 1.0f) == !lifted);
            assert_true(s.position.y[3] == 0);
            render_scene_destroy(&scene);
            free(f);
        }
}
