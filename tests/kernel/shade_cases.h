#pragma once
/* The surfaces that check_shade looks at. */
#include "worker/shade/bsdf.h"

struct shade_case {
    const char *name;
    struct bsdf bsdf;
    double narrowing; /* of the grid: 2 for broad lobes, up to 6 for sharp ones */
    double loss_max;  /* of a white surface's light at any direction; < 0: it isn't white */
    double gain_max;  /* beyond 1 */
    bool quick;       /* part of the smoke test */
};

#define WHITE                                                                                      \
    {                                                                                              \
        1.0f, 1.0f, 1.0f                                                                           \
    }
#define GREY                                                                                       \
    {                                                                                              \
        0.5f, 0.5f, 0.5f                                                                           \
    }
#define DIM                                                                                        \
    {                                                                                              \
        0.3f, 0.3f, 0.3f                                                                           \
    }
#define NONE                                                                                       \
    {                                                                                              \
        0.0f, 0.0f, 0.0f                                                                           \
    }
#define GOLD                                                                                       \
    {                                                                                              \
        1.0f, 0.77f, 0.34f                                                                         \
    }
#define F0                                                                                         \
    {                                                                                              \
        0.04f, 0.04f, 0.04f                                                                        \
    }

/* glTF: white metal; white dielectric; what transmits. */
#define METAL(u, v)                                                                                \
    {                                                                                              \
        .model = BSDF_GLTF, .alpha_u = (u), .alpha_v = (v), .base_color = WHITE, .metallic = 1.0f, \
        .specular = 1.0f, .specular_f0 = F0, .ior = 1.5f                                           \
    }
#define PAINT(u, v)                                                                                \
    {                                                                                              \
        .model = BSDF_GLTF, .albedo = WHITE, .alpha_u = (u), .alpha_v = (v), .base_color = WHITE,  \
        .specular = 1.0f, .specular_f0 = F0, .ior = 1.5f                                           \
    }
#define SEEN_PAINT(u, v)                                                                           \
    {                                                                                              \
        .model = BSDF_GLTF, .albedo = WHITE, .alpha_u = (u), .alpha_v = (v), .base_color = WHITE,  \
        .specular = 1.0f, .specular_f0 = F0, .ior = 1.5f, .seen = true                             \
    }
#define PANE(a)                                                                                    \
    {                                                                                              \
        .model = BSDF_GLTF, .alpha_u = (a), .alpha_v = (a), .base_color = WHITE,                   \
        .transmission = 1.0f, .specular = 1.0f, .specular_f0 = F0, .ior = 1.5f, .thin = true       \
    }
#define GLASS(a, n, f)                                                                             \
    {                                                                                              \
        .model = BSDF_GLTF, .alpha_u = (a), .alpha_v = (a), .base_color = WHITE,                   \
        .transmission = 1.0f, .specular = 1.0f, .specular_f0 = {(f), (f), (f)}, .ior = (n),        \
        .inside = (n) < 1.0f                                                                       \
    }
#define TWO_LOBES(m, kd, ks, ...)                                                                  \
    {                                                                                              \
        .model = (m), .albedo = kd, .model_specular = ks, .ior = 1.0f, __VA_ARGS__                 \
    }

/* White under a coat. */
#define COATED(m, a, c, ca)                                                                        \
    {                                                                                              \
        .model = BSDF_GLTF, .albedo = {1.0f - (m), 1.0f - (m), 1.0f - (m)}, .alpha_u = (a),        \
        .alpha_v = (a), .base_color = WHITE, .metallic = (m), .specular = 1.0f, .specular_f0 = F0, \
        .ior = 1.5f, .coat = (c), .coat_alpha = (ca)                                               \
    }

#define SEEN_COATED(ca)                                                                            \
    {                                                                                              \
        .model = BSDF_GLTF, .albedo = WHITE, .alpha_u = 0.3f, .alpha_v = 0.3f,                     \
        .base_color = WHITE, .specular = 1.0f, .specular_f0 = F0, .ior = 1.5f, .coat = 1.0f,       \
        .coat_alpha = (ca), .seen = true                                                           \
    }

/* The same with a coat whose normal leans by 21 degrees. */
#define LEANING(m, a, c, ca, s)                                                                    \
    {                                                                                              \
        .model = BSDF_GLTF, .albedo = {1.0f - (m), 1.0f - (m), 1.0f - (m)}, .alpha_u = (a),        \
        .alpha_v = (a), .base_color = WHITE, .metallic = (m), .specular = 1.0f, .specular_f0 = F0, \
        .ior = 1.5f, .coat = (c), .coat_alpha = (ca), .coat_bent = true, .coat_normal = {          \
            (s)*0.3f,                                                                              \
            (s)*0.2f,                                                                              \
            0.932738f                                                                              \
        }                                                                                          \
    }

/* Fibres of a grey on paint or metal. */
#define FURRY(m, a, sa, s)                                                                         \
    {                                                                                              \
        .model = BSDF_GLTF, .albedo = {1.0f - (m), 1.0f - (m), 1.0f - (m)}, .alpha_u = (a),        \
        .alpha_v = (a), .base_color = WHITE, .metallic = (m), .specular = 1.0f, .specular_f0 = F0, \
        .ior = 1.5f, .sheen = {(s), (s), (s)}, .sheen_alpha = (sa)                                 \
    }

/* A thin wall that lets a part t of diffuse light through. */
#define LEAF(t, a, s, ...)                                                                         \
    {                                                                                              \
        .model = BSDF_GLTF, .albedo = {1.0f - (t), 1.0f - (t), 1.0f - (t)},                        \
        .through = {(t), (t), (t)}, .alpha_u = (a), .alpha_v = (a), .base_color = WHITE,           \
        .specular = (s), .specular_f0 = __VA_ARGS__, .ior = 1.5f, .thin = true                     \
    }

/* A film of an index of 1.8 on paint, metal, a pane. */
#define FILMED(m, t, a, f, nm)                                                                     \
    {                                                                                              \
        .model = BSDF_GLTF, .albedo = {1.0f - (m) - (t), 1.0f - (m) - (t), 1.0f - (m) - (t)},      \
        .alpha_u = (a), .alpha_v = (a), .base_color = WHITE, .metallic = (m), .transmission = (t), \
        .specular = 1.0f, .specular_f0 = F0, .ior = 1.5f, .thin = (t) > 0.0f, .film = (f),         \
        .film_ior = 1.8f, .film_nm = (nm)                                                          \
    }

/* Glass of an index for each colour, of which it transmits one. */
#define PRISM(a, c, r, g, b)                                                                       \
    {                                                                                              \
        .model = BSDF_GLTF, .alpha_u = (a), .alpha_v = (a), .base_color = WHITE,                   \
        .transmission = 1.0f, .specular = 1.0f, .specular_f0 = F0, .iors = {(r), (g), (b)},        \
        .ior = (c) == 0   ? (r)                                                                    \
               : (c) == 1 ? (g)                                                                    \
                          : (b),                                                                   \
        .dispersed = true, .color = (c), .color_scale = 3.0f, .inside = (g) < 1.0f                 \
    }

static struct shade_case shade_cases[] = {
    {"lambert", {.model = BSDF_LAMBERT, .albedo = WHITE}, 2, 1e-4, 1e-4, true},
    {"mirror", {.model = BSDF_MIRROR, .model_specular = WHITE}, 2, 1e-6, 1e-6, false},

    {"phong n 0", TWO_LOBES(BSDF_PHONG, NONE, WHITE, .exponent_u = 0.0f), 2, 0.46, 1e-3, false},
    {"phong n 10, half diffuse", TWO_LOBES(BSDF_PHONG, GREY, GREY, .exponent_u = 10.0f), 2, 0.42,
     1e-3, true},
    {"phong n 200", TWO_LOBES(BSDF_PHONG, NONE, WHITE, .exponent_u = 200.0f), 4, 0.92, 1e-3, false},
    {"phong n 1e5", TWO_LOBES(BSDF_PHONG, NONE, WHITE, .exponent_u = 1e5f), 6, 0.92, 1e-3, false},

    {"blinn-phong n 0", TWO_LOBES(BSDF_BLINN_PHONG, NONE, WHITE, .exponent_u = 0.0f), 2, 1e-4, 1e-4,
     false},
    {"blinn-phong n 30, half diffuse", TWO_LOBES(BSDF_BLINN_PHONG, GREY, GREY, .exponent_u = 30.0f),
     2, 0.48, 1e-3, true},
    {"blinn-phong n 1000", TWO_LOBES(BSDF_BLINN_PHONG, NONE, WHITE, .exponent_u = 1e3f), 4, 0.995,
     1e-3, false},
    {"blinn-phong n 1e5", TWO_LOBES(BSDF_BLINN_PHONG, NONE, WHITE, .exponent_u = 1e5f), 6, 0.995,
     1e-3, false},

    {"beckmann alpha 0.01",
     TWO_LOBES(BSDF_BECKMANN, NONE, WHITE, .alpha_u = 0.01f, .alpha_v = 0.01f), 6, 1e-3, 1e-3,
     false},
    {"beckmann alpha 0.2", TWO_LOBES(BSDF_BECKMANN, NONE, WHITE, .alpha_u = 0.2f, .alpha_v = 0.2f),
     3, 0.08, 1e-3, true},
    {"beckmann alpha 1", TWO_LOBES(BSDF_BECKMANN, NONE, WHITE, .alpha_u = 1.0f, .alpha_v = 1.0f), 2,
     0.55, 1e-3, false},
    {"beckmann 0.1 x 0.5, half diffuse",
     TWO_LOBES(BSDF_BECKMANN, GREY, GREY, .alpha_u = 0.1f, .alpha_v = 0.5f), 3, 0.25, 1e-3, false},
    {"beckmann copper alpha 0.3",
     TWO_LOBES(BSDF_BECKMANN, NONE, WHITE, .alpha_u = 0.3f, .alpha_v = 0.3f,
               .eta = {0.2f, 0.92f, 1.1f}, .k = {3.9f, 2.45f, 2.14f}),
     3, -1, 0, false},

    {"ward alpha 0.01", TWO_LOBES(BSDF_WARD, NONE, WHITE, .alpha_u = 0.01f, .alpha_v = 0.01f), 6,
     0.01, 1e-3, false},
    {"ward alpha 0.1, 0.5, half diffuse",
     TWO_LOBES(BSDF_WARD, GREY, GREY, .alpha_u = 0.1f, .alpha_v = 0.5f), 3, 0.12, 1e-3, true},
    {"ward alpha 1", TWO_LOBES(BSDF_WARD, NONE, WHITE, .alpha_u = 1.0f, .alpha_v = 1.0f), 2, 0.64,
     1e-3, false},
    {"kelemen alpha 0.01", TWO_LOBES(BSDF_KELEMEN, WHITE, F0, .alpha_u = 0.01f, .alpha_v = 0.01f),
     6, 1e-3, 0.015, false},
    {"kelemen alpha 0.3", TWO_LOBES(BSDF_KELEMEN, WHITE, F0, .alpha_u = 0.3f, .alpha_v = 0.3f), 3,
     0.01, 0.01, true},
    {"kelemen alpha 1", TWO_LOBES(BSDF_KELEMEN, WHITE, GREY, .alpha_u = 1.0f, .alpha_v = 1.0f), 2,
     0.01, 0.01, false},
    {"kelemen alpha 0.2, white metal",
     TWO_LOBES(BSDF_KELEMEN, NONE, WHITE, .alpha_u = 0.2f, .alpha_v = 0.2f), 3, 0.2, 1e-3, false},
    {"measured, alpha 0.05 and 0.4",
     TWO_LOBES(BSDF_MEASURED, GREY, DIM, .alpha_u = 0.05f, .second_specular = {0.2f, 0.2f, 0.2f},
               .second_alpha = 0.4f, .grazing = {0.7f, 0.3f}),
     4, 0.19, 0.01, true},
    {"measured, one lobe of alpha 1",
     TWO_LOBES(BSDF_MEASURED, NONE, WHITE, .alpha_u = 1.0f, .grazing = {1.0f, 0.0f}), 2, 0.7, 1e-3,
     false},
    {"ashikhmin-shirley 10 x 10",
     TWO_LOBES(BSDF_ASHIKHMIN_SHIRLEY, NONE, WHITE, .exponent_u = 10.0f, .exponent_v = 10.0f), 2,
     0.49, 1e-3, false},
    {"ashikhmin-shirley 1000 x 10, half diffuse",
     TWO_LOBES(BSDF_ASHIKHMIN_SHIRLEY, GREY, GREY, .exponent_u = 1e3f, .exponent_v = 10.0f), 3,
     0.54, 1e-3, true},
    {"ashikhmin-shirley 1e5 x 100",
     TWO_LOBES(BSDF_ASHIKHMIN_SHIRLEY, NONE, WHITE, .exponent_u = 1e5f, .exponent_v = 100.0f), 5,
     0.38, 1e-3, false},

    {"gltf metal alpha 0", METAL(0.0f, 0.0f), 2, 1e-6, 1e-6, false},
    {"gltf metal alpha 0.001", METAL(0.001f, 0.001f), 6, 0.002, 1e-3, false},
    {"gltf metal alpha 0.01", METAL(0.01f, 0.01f), 6, 0.009, 1e-3, false},
    {"gltf metal alpha 0.1", METAL(0.1f, 0.1f), 4, 0.12, 1e-3, false},
    {"gltf metal alpha 0.25", METAL(0.25f, 0.25f), 3, 0.16, 1e-3, true},
    {"gltf metal alpha 0.5", METAL(0.5f, 0.5f), 2, 0.33, 1e-3, false},
    {"gltf metal alpha 1", METAL(1.0f, 1.0f), 2, 0.7, 1e-3, false},
    {"gltf metal alpha 0.05 x 0.6", METAL(0.05f, 0.6f), 3, 0.25, 1e-3, false},
    {"gltf paint alpha 0", PAINT(0.0f, 0.0f), 2, 0.004, 1e-3, false},
    {"gltf paint alpha 0.05", PAINT(0.05f, 0.05f), 4, 0.05, 1e-3, false},
    {"gltf paint alpha 0.3", PAINT(0.3f, 0.3f), 3, 0.018, 1e-3, true},
    {"gltf paint alpha 1", PAINT(1.0f, 1.0f), 2, 0.04, 1e-3, false},
    {"gltf paint alpha 0.05 x 0.6", PAINT(0.05f, 0.6f), 3, 0.007, 0.02, false},
    {"gltf paint alpha 0, seen", SEEN_PAINT(0.0f, 0.0f), 2, 0.004, 0.003, false},
    {"gltf paint alpha 0.05, seen", SEEN_PAINT(0.05f, 0.05f), 4, 0.05, 1e-3, true},
    {"coat alpha 0 on paint alpha 0.3, seen", SEEN_COATED(0.0f), 3, 0.05, 0.01, true},
    {"coat alpha 0.04 on paint alpha 0.3, seen", SEEN_COATED(0.04f), 5, 0.1, 0.02, false},
    {"coat alpha 0 on paint alpha 0.3", COATED(0.0f, 0.3f, 1.0f, 0.0f), 3, 0.05, 0.01, true},
    {"coat alpha 0 on paint alpha 0", COATED(0.0f, 0.0f, 1.0f, 0.0f), 2, 0.05, 0.01, false},
    {"coat alpha 0.04 on paint alpha 1", COATED(0.0f, 1.0f, 1.0f, 0.04f), 5, 0.1, 0.02, false},
    {"coat alpha 0.3 on paint alpha 0.3", COATED(0.0f, 0.3f, 1.0f, 0.3f), 3, 0.1, 0.01, false},
    {"half a coat alpha 1 on paint alpha 0.3", COATED(0.0f, 0.3f, 0.5f, 1.0f), 3, 0.1, 0.01, false},
    {"coat alpha 0 on metal alpha 0.25", COATED(1.0f, 0.25f, 1.0f, 0.0f), 3, 0.35, 1e-3, true},
    {"coat alpha 0.1 on metal alpha 0", COATED(1.0f, 0.0f, 1.0f, 0.1f), 4, 0.2, 0.01, false},
    {"coat alpha 0.1 on metal alpha 0.5", COATED(1.0f, 0.5f, 1.0f, 0.1f), 4, 0.5, 1e-3, false},
    {"leaning coat alpha 0.1 on paint alpha 0.3", LEANING(0.0f, 0.3f, 1.0f, 0.1f, 1.0f), 4, 0.1,
     0.01, true},
    {"coat alpha 0.3 that leans away on paint alpha 0.3", LEANING(0.0f, 0.3f, 1.0f, 0.3f, -1.0f), 3,
     0.2, 0.01, false},
    {"leaning coat alpha 0 on metal alpha 0.25", LEANING(1.0f, 0.25f, 1.0f, 0.0f, 1.0f), 3, 0.45,
     1e-3, false},
    {"leaning coat alpha 0.5 on metal alpha 0.5", LEANING(1.0f, 0.5f, 0.7f, 0.5f, -1.0f), 3, 0.4,
     1e-3, false},
    {"sheen alpha 0.01 on paint alpha 0.3", FURRY(0.0f, 0.3f, 0.01f, 1.0f), 3, 0.1, 0.02, false},
    {"sheen alpha 0.09 on paint alpha 0.3", FURRY(0.0f, 0.3f, 0.09f, 1.0f), 3, 0.3, 0.02, true},
    {"half a sheen alpha 0.36 on paint alpha 0", FURRY(0.0f, 0.0f, 0.36f, 0.5f), 2, 0.3, 0.02,
     false},
    {"sheen alpha 1 on metal alpha 0.25", FURRY(1.0f, 0.25f, 1.0f, 1.0f), 3, 0.4, 0.02, false},
    {"coat alpha 0.1 on sheen alpha 0.25 on paint alpha 0.3",
     {.model = BSDF_GLTF,
      .albedo = WHITE,
      .alpha_u = 0.3f,
      .alpha_v = 0.3f,
      .base_color = WHITE,
      .specular = 1.0f,
      .specular_f0 = F0,
      .ior = 1.5f,
      .coat = 1.0f,
      .coat_alpha = 0.1f,
      .sheen = WHITE,
      .sheen_alpha = 0.25f},
     3,
     0.4,
     0.02,
     false},
    {"blue sheen alpha 0.25 on a pane alpha 0.2",
     {.model = BSDF_GLTF,
      .alpha_u = 0.2f,
      .alpha_v = 0.2f,
      .base_color = WHITE,
      .transmission = 1.0f,
      .specular = 1.0f,
      .specular_f0 = F0,
      .ior = 1.5f,
      .thin = true,
      .sheen = {0.1f, 0.2f, 0.9f},
      .sheen_alpha = 0.25f},
     3,
     -1,
     0,
     false},
    {"sheen alpha 0.25 on glass alpha 0.2",
     {.model = BSDF_GLTF,
      .alpha_u = 0.2f,
      .alpha_v = 0.2f,
      .base_color = WHITE,
      .transmission = 1.0f,
      .specular = 1.0f,
      .specular_f0 = F0,
      .ior = 1.5f,
      .sheen = WHITE,
      .sheen_alpha = 0.25f},
     3,
     0.3,
     0.02,
     false},
    {"half through, alpha 0.3", LEAF(0.5f, 0.3f, 1.0f, F0), 3, 0.02, 1e-3, true},
    {"all through, alpha 0", LEAF(1.0f, 0.0f, 1.0f, F0), 2, 0.004, 0.005, false},
    {"half through, no specular", LEAF(0.5f, 0.3f, 0.0f, NONE), 2, 1e-4, 1e-4, false},
    {"half through under a coat alpha 0.1 and a sheen alpha 0.25",
     {.model = BSDF_GLTF,
      .albedo = GREY,
      .through = GREY,
      .alpha_u = 0.3f,
      .alpha_v = 0.3f,
      .base_color = WHITE,
      .specular = 1.0f,
      .specular_f0 = F0,
      .ior = 1.5f,
      .thin = true,
      .coat = 1.0f,
      .coat_alpha = 0.1f,
      .sheen = GREY,
      .sheen_alpha = 0.25f},
     3,
     0.3,
     0.02,
     false},
    {"half through, half clear, alpha 0.2",
     {.model = BSDF_GLTF,
      .albedo = {0.25f, 0.25f, 0.25f},
      .through = {0.25f, 0.25f, 0.25f},
      .alpha_u = 0.2f,
      .alpha_v = 0.2f,
      .base_color = WHITE,
      .transmission = 0.5f,
      .specular = 1.0f,
      .specular_f0 = F0,
      .ior = 1.5f,
      .thin = true},
     3,
     0.1,
     1e-3,
     false},
    {"film of 400 nm on paint alpha 0.3", FILMED(0.0f, 0.0f, 0.3f, 1.0f, 400.0f), 3, 0.3, 0.02,
     true},
    {"film of 100 nm on paint alpha 0", FILMED(0.0f, 0.0f, 0.0f, 1.0f, 100.0f), 2, 0.3, 0.02,
     false},
    {"half a film of 800 nm on paint alpha 1", FILMED(0.0f, 0.0f, 1.0f, 0.5f, 800.0f), 2, 0.3, 0.02,
     false},
    {"film of 300 nm on white metal alpha 0.25", FILMED(1.0f, 0.0f, 0.25f, 1.0f, 300.0f), 3, 0.5,
     1e-3, false},
    {"film of 500 nm on a pane alpha 0.2", FILMED(0.0f, 1.0f, 0.2f, 1.0f, 500.0f), 3, 0.3, 1e-3,
     false},
    {"film of 500 nm on glass alpha 0.2",
     {.model = BSDF_GLTF,
      .alpha_u = 0.2f,
      .alpha_v = 0.2f,
      .base_color = WHITE,
      .transmission = 1.0f,
      .specular = 1.0f,
      .specular_f0 = F0,
      .ior = 1.5f,
      .film = 1.0f,
      .film_ior = 1.8f,
      .film_nm = 500.0f},
     3,
     0.3,
     1e-3,
     false},
    {"film of 500 nm on glass alpha 0.2, from inside",
     {.model = BSDF_GLTF,
      .alpha_u = 0.2f,
      .alpha_v = 0.2f,
      .base_color = WHITE,
      .transmission = 1.0f,
      .specular = 1.0f,
      .specular_f0 = F0,
      .ior = 1.0f / 1.5f,
      .inside = true,
      .film = 1.0f,
      .film_ior = 1.8f,
      .film_nm = 500.0f},
     3,
     0.3,
     1e-3,
     false},
    {"dispersed glass alpha 0.2, green", PRISM(0.2f, 1, 1.4f, 1.5f, 1.6f), 3, 0.1, 0.01, false},
    {"dispersed glass alpha 0.2, blue", PRISM(0.2f, 2, 1.4f, 1.5f, 1.6f), 3, 0.1, 0.02, true},
    {"dispersed glass alpha 0.2, red from inside",
     PRISM(0.2f, 0, 1.0f / 1.4f, 1.0f / 1.5f, 1.0f / 1.6f), 3, 0.4, 0.2, false},
    {"dispersed glass alpha 0, blue", PRISM(0.0f, 2, 1.4f, 1.5f, 1.6f), 2, 0.03, 0.03, false},
    {"gltf paint, no specular",
     {.model = BSDF_GLTF,
      .albedo = WHITE,
      .alpha_u = 0.3f,
      .alpha_v = 0.3f,
      .base_color = WHITE,
      .specular_f0 = F0,
      .ior = 1.5f},
     2,
     1e-4,
     1e-4,
     false},
    {"coat alpha 0.2 on a pane alpha 0.2",
     {.model = BSDF_GLTF,
      .alpha_u = 0.2f,
      .alpha_v = 0.2f,
      .base_color = WHITE,
      .transmission = 1.0f,
      .specular = 1.0f,
      .specular_f0 = F0,
      .ior = 1.5f,
      .thin = true,
      .coat = 1.0f,
      .coat_alpha = 0.2f},
     3,
     0.2,
     0.01,
     false},
    {"coat alpha 0.1 on glass alpha 0.2",
     {.model = BSDF_GLTF,
      .alpha_u = 0.2f,
      .alpha_v = 0.2f,
      .base_color = WHITE,
      .transmission = 1.0f,
      .specular = 1.0f,
      .specular_f0 = F0,
      .ior = 1.5f,
      .coat = 1.0f,
      .coat_alpha = 0.1f},
     3,
     0.2,
     0.01,
     false},
    {"coat alpha 0.1 on glass alpha 0.2, from inside",
     {.model = BSDF_GLTF,
      .alpha_u = 0.2f,
      .alpha_v = 0.2f,
      .base_color = WHITE,
      .transmission = 1.0f,
      .specular = 1.0f,
      .specular_f0 = F0,
      .ior = 1.0f / 1.5f,
      .inside = true,
      .coat = 1.0f,
      .coat_alpha = 0.1f},
     3,
     0.4,
     0.01,
     false},
    {"gltf ior 0: reflects everything",
     {.model = BSDF_GLTF,
      .albedo = WHITE,
      .alpha_u = 0.2f,
      .alpha_v = 0.2f,
      .base_color = WHITE,
      .specular = 1.0f,
      .specular_f0 = WHITE,
      .ior = 0.0f},
     3,
     0.13,
     1e-3,
     false},
    {"gltf ior 1 paint",
     {.model = BSDF_GLTF,
      .albedo = WHITE,
      .alpha_u = 0.2f,
      .alpha_v = 0.2f,
      .base_color = WHITE,
      .specular = 1.0f,
      .ior = 1.0f},
     3,
     0.021,
     1e-3,
     false},
    {"gltf half metal, half clear, gold",
     {.model = BSDF_GLTF,
      .albedo = {0.25f, 0.1925f, 0.085f},
      .alpha_u = 0.3f,
      .alpha_v = 0.15f,
      .base_color = GOLD,
      .metallic = 0.5f,
      .transmission = 0.5f,
      .specular = 0.7f,
      .specular_f0 = {0.04f, 0.02f, 0.06f},
      .ior = 1.5f,
      .thin = true},
     3,
     -1,
     0,
     true},
    {"gltf thin pane alpha 0", PANE(0.0f), 2, 1e-6, 1e-6, false},
    {"gltf thin pane alpha 0.2", PANE(0.2f), 3, 0.13, 1e-3, true},
    {"gltf glass alpha 0", GLASS(0.0f, 1.5f, 0.04f), 2, 1e-6, 1e-6, false},
    {"gltf glass alpha 0, from inside", GLASS(0.0f, 1.0f / 1.5f, 0.04f), 2, 1e-6, 1e-6, false},
    {"gltf glass alpha 0.02", GLASS(0.02f, 1.5f, 0.04f), 6, 0.03, 1e-3, false},
    {"gltf glass alpha 0.2", GLASS(0.2f, 1.5f, 0.04f), 3, 0.08, 1e-3, true},
    {"gltf glass alpha 0.2, from inside", GLASS(0.2f, 1.0f / 1.5f, 0.04f), 3, 0.17, 1e-3, true},
    {"gltf glass alpha 0.8", GLASS(0.8f, 1.5f, 0.04f), 2, 0.23, 1e-3, false},
    {"gltf diamond alpha 0.1", GLASS(0.1f, 2.4f, 0.16955f), 4, 0.09, 1e-3, false},
    {"gltf diamond alpha 0.1, from inside", GLASS(0.1f, 1.0f / 2.4f, 0.16955f), 4, 0.13, 1e-3,
     false},
    {"gltf glass of index 1, alpha 0.3", GLASS(0.3f, 1.0f, 0.0f), 2, 1e-6, 1e-6, false},
    {"gltf milk: half clear volume",
     {.model = BSDF_GLTF,
      .albedo = GREY,
      .alpha_u = 0.3f,
      .alpha_v = 0.3f,
      .base_color = WHITE,
      .transmission = 0.5f,
      .specular = 1.0f,
      .specular_f0 = F0,
      .ior = 1.5f},
     3,
     0.06,
     1e-3,
     false},
};

#define SHADE_CASE_COUNT (int)(sizeof shade_cases / sizeof *shade_cases)
