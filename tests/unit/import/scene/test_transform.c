/* Affine transforms against what can be worked out by hand. */
#include <math.h>

#include "server/import/scene/transform.h"
#include "tests/unit/unit.h"

static void assert_near(double a, double b)
{
    assert_true(fabs(a - b) < 1e-12);
}

TEST(trs_scales_then_turns_then_moves)
{
    const double h = sqrt(0.5);
    const double t[3] = {10, 20, 30}, q[4] = {0, 0, h, h},
                 s[3] = {2, 3, 4}; /* 90 degrees about z */
    const struct affine a = affine_from_trs(t, q, s);
    float p[3];
    affine_point(&a, (const float[3]){1, 1, 1}, p);
    assert_near((double)p[0], 10 - 3);
    assert_near((double)p[1], 20 + 2);
    assert_near((double)p[2], 30 + 4);
    assert_near(affine_determinant(&a), 24);
}

TEST(products_apply_the_right_one_first)
{
    const struct affine move = {{1, 0, 0, 5, 0, 1, 0, 0, 0, 0, 1, 0}};
    const struct affine scale = {{2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0}};
    float p[3];
    struct affine both = affine_multiply(&scale, &move);
    affine_point(&both, (const float[3]){1, 0, 0}, p);
    assert_near((double)p[0], 12);
    both = affine_multiply(&move, &scale);
    affine_point(&both, (const float[3]){1, 0, 0}, p);
    assert_near((double)p[0], 7);
}

TEST(columns_are_read_as_gltf_writes_them)
{
    double columns[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 7, 8, 9, 1};
    struct affine a;
    assert_true(affine_from_columns(columns, &a));
    assert_near(a.m[3], 7);
    assert_near(a.m[7], 8);
    assert_near(a.m[11], 9);
    columns[3] = 0.5;
    assert_false(affine_from_columns(columns, &a));
}

TEST(normals_stay_at_right_angles)
{
    /* Shear and uneven scale: a plane through u and v keeps its normal at right angles to both. */
    const struct affine a = {{2, 1, 0, 0, 0, 3, 0.5, 0, 0.25, 0, 1, 0}};
    const double u[3] = {1, 2, -1}, v[3] = {0, 1, 3};
    double n[3], nu[3], nv[3], nn[3];
    cross3(u, v, n);
    affine_direction(&a, u, nu);
    affine_direction(&a, v, nv);
    affine_normal(&a, n, nn);
    assert_near(dot3(nu, nn), 0);
    assert_near(dot3(nv, nn), 0);
}

TEST(singular_is_judged_by_shape_not_by_size)
{
    const struct affine tiny = {{1e-6, 0, 0, 0, 0, 1e-6, 0, 0, 0, 0, 1e-6, 0}};
    const struct affine flat = {{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0}};
    const struct affine skewed = {{1, 1, 0, 0, 0, 1e-10, 0, 0, 0, 0, 1, 0}};
    assert_false(affine_is_singular(&tiny));
    assert_true(affine_is_singular(&flat));
    assert_true(affine_is_singular(&skewed));
}

TEST(mirroring_undoes_itself)
{
    const struct affine a = {{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 12, 11}};
    const struct affine once = affine_mirrored(&a), twice = affine_mirrored(&once);
    assert_near(affine_determinant(&once), -affine_determinant(&a));
    assert_memory_equal(&twice, &a, sizeof a);
}

TEST(zero_has_no_direction)
{
    double zero[3] = {0, 0, 0}, huge[3] = {1e200, 0, 0}, broken[3] = {NAN, 0, 0};
    assert_false(normalize3(zero));
    assert_true(normalize3(huge));
    assert_near(huge[0], 1);
    assert_false(normalize3(broken));
}
