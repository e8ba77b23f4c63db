#pragma once
/* Analytic cases: scenes whose picture is known in closed form, or by an integral that is done here
 * without any randomness, traced in-process and held to four standard errors.
 *
 *   struct stage *s = stage_new();                      an empty scene, a plan of 32 x 32 pixels
 *   stage_panel(s, stage_lambert(s, 0.5, 0.5, 0.5), ...);
 *   stage_look(s, eye, target, POINT);
 *   struct picture *p = stage_trace(s);
 *   picture_expect(p, "a name", PLANE_PATH_RADIANCE, (double[3]){1, 1, 1}, 0);
 *   stage_free(&s); picture_free(&p);
 *
 * All that a case places goes through the stage's scale and shift (x' = scale x + shift), so that
 * any case can be held at other scales. */
#include "proto/plan.h"
#include "proto/scene/environment.h"
#include "tests/unit/worker/scene_fixture.h"

#define STAGE_SIDE_PX 32
#define POINT         1e-4f /* half the image's width at distance 1: all pixels see one point */

struct stage {
    struct scene_fixture *f;
    struct plan plan;
    struct environment_blob map; /* blob owned; NULL: none */
    double scale, shift[3];
    uint32_t spp; /* set by the run: 2^20 or 2^17 samples a picture */
};

struct stage *stage_new(void);
void stage_free(struct stage **s);

/* A glTF material with every default of the specification, but KHR_materials_specular's factor 0:
 * base colour 1, not metallic, pure Lambert. */
struct scene_material *stage_material(struct stage *s, uint32_t *index);
uint32_t stage_lambert(struct stage *s, double r, double g, double b);
/* Black, and emits. */
uint32_t stage_emitter(struct stage *s, double r, double g, double b);

/* fixture_panel at the stage's scale; the instance's index. */
uint32_t stage_panel(struct stage *s, uint32_t material, const double c[3], const double u[3],
                     const double v[3]);
/* The box [-h, h] around c, faces outwards or inwards, one mesh. */
void stage_box(struct stage *s, uint32_t material, const double c[3], const double h[3],
               bool inwards);
/* A sphere of 64 x 32 quads and triangles, corners on the radius, flat. Its area, scale left out.*/
double stage_sphere(struct stage *s, uint32_t material, const double c[3], double radius,
                    bool inwards);

/* A rectangle light (no geometry) that shines where u x v points; more of it can be set. */
struct plan_light *stage_rectangle(struct stage *s, const double c[3], const double u[3],
                                   const double v[3], double radiance);
/* Its geometry too, as the importer recognises it: a mesh of the light's own. */
struct plan_light *stage_lamp(struct stage *s, const double c[3], const double u[3],
                              const double v[3], double radiance);
/* The same as a mesh emitter. */
void stage_glow(struct stage *s, const double c[3], const double u[3], const double v[3],
                double radiance);
/* Intensity per steradian is scaled along, so that pictures stay the same. */
struct plan_light *stage_point(struct stage *s, const double position[3], double intensity);

void stage_constant_environment(struct stage *s, double r, double g, double b);
/* A map by a function of its texel's centre u, v in [0, 1): grey radiance. */
void stage_environment_map(struct stage *s, uint32_t width, uint32_t height,
                           double (*radiance)(double u, double v), double rotation_rad);

/* From eye to target; `half`: half the image's width at distance 1. */
void stage_look(struct stage *s, const double eye[3], const double target[3], double half);

struct picture {
    int32_t width, height;
    uint32_t spp;
    double *mean[PLANE_ID_COUNT][3]; /* a pixel; NULL for planes that were not traced */
    double *variance[3];             /* of a pixel's mean of PATH_RADIANCE, by the spread */
};

/* All passes, summed as the film does. Ends the program when tracing fails. */
struct picture *stage_trace(struct stage *s);
/* The light field of indirect light (with bounces) and of ambient occlusion (with its distance):
 * the planes INDIRECT_MEAN and AMBIENT_VISIBILITY, of as many samples, or nearly. `beside_paths`:
 * under a plan whose paths bring all direct light. */
struct picture *stage_trace_field(struct stage *s, bool beside_paths);
void picture_free(struct picture **p);

/* One test: the mean over all pixels of a plane, whose pixels all have the same expectation.
 * Holds when the radiance is within four standard errors by the spread (as the layer "error" gives
 * them) and every plane within four by the scatter between pixels, which is smaller, since samples
 * of a pixel are stratified; both widened by `allowance` times the expectation: what the case's
 * own geometry leaves open. 2e-5 is always allowed for sums of floats. */
void picture_expect(const struct picture *p, const char *name, enum plane_id plane,
                    const double expected[3], double allowance);
/* The same for grey. */
void picture_expect_grey(const struct picture *p, const char *name, enum plane_id plane,
                         double expected, double allowance);
/* A weighted sum over pixels of PATH_RADIANCE's first channel: by the spread alone. `allowance` is
 * absolute. */
void picture_expect_sum(const struct picture *p, const char *name, const double *weights,
                        double expected, double allowance);
/* A single truth that is not a mean. */
void analytic_expect(const char *name, bool holds, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* The groups of cases. */
void analytic_furnaces(void);
void analytic_lights(void);
void analytic_fields(void);
void analytic_environments(void);
void analytic_surfaces(void);
void analytic_lenses(void);
void analytic_scales(void);
