/* Words of a job document, and the names that they have elsewhere. */
#include "proto/job/job.h"
#include "tests/unit/unit.h"

TEST(words_have_names)
{
    for (uint32_t bit = 1; bit <= LAYER_DIFFUSE_INDIRECT; bit <<= 1) {
        assert_non_null(layer_name(bit));
        assert_int_equal(layer_from_name(layer_name(bit)), bit);
    }
    assert_null(layer_name(0));
    assert_int_equal(layer_from_name("nothing"), 0);
    assert_string_equal(filter_method_name(FILTER_AUTO), "auto");
    for (int i = INDIRECT_AUTO; i <= INDIRECT_SHEARED; i++)
        assert_non_null(indirect_method_name((enum indirect_method)i));
    assert_string_equal(indirect_method_name(INDIRECT_CONSTANT), "constant");
    for (int i = ENVIRONMENT_AUTO; i <= ENVIRONMENT_AXIS_ALIGNED; i++)
        assert_non_null(environment_method_name((enum environment_method)i));
    assert_string_equal(environment_method_name(ENVIRONMENT_AXIS_ALIGNED), "axis_aligned");
    assert_int_equal(job_strata_per_axis(1), 1);
    assert_int_equal(job_strata_per_axis(9), 3);
    assert_int_equal(job_strata_per_axis(10), 4);
    assert_int_equal(job_strata_per_axis(LIMIT_SPP), LIMIT_STRATA_PER_AXIS);
}
