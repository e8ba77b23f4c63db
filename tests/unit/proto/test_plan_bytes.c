/* The bytes of plans: what is encoded comes back, and nothing that is cut or grown does. */
#include "tests/unit/proto/golden.h"
#include "tests/unit/proto/plan_wire.h"
#include "tests/unit/unit.h"

TEST(plans_round_trip)
{
    static struct plan sent, got;
    for (uint32_t lights = 0; lights <= 4; lights++) {
        struct bytes_writer w, again;
        struct fault fault = {0};
        plan_case(&sent);
        sent.light_count = lights;
        if (lights == 2) {
            sent.indirect_filter = INDIRECT_FILTER_ADAPTIVE;
            sent.adaptive = (struct plan_adaptive){.mu = 2.5f, .rays_max = 4711};
            sent.planes &=
                ~(PLANE_BIT(INDIRECT_HALVES) | PLANE_BIT(INDIRECT_STRATA) | PLANE_BIT(GLOSSY_HALF));
        }
        if (lights == 3) sent.residual_filter = RESIDUAL_FILTER_HALVES;
        encode(&sent, &w);
        memset(&got, 0xee, sizeof got);
        if (decode(w.data, w.size_bytes, &got, &fault))
            fail_msg("%s: %s", fault.pointer, fault.detail);
        encode(&got, &again);
        assert_int_equal(w.size_bytes, again.size_bytes);
        assert_memory_equal(w.data, again.data, w.size_bytes);
        assert_memory_equal(&sent.camera, &got.camera, sizeof sent.camera);
        assert_memory_equal(&sent.environment, &got.environment, sizeof sent.environment);
        assert_memory_equal(&sent.paths, &got.paths, sizeof sent.paths);
        assert_int_equal(sent.shadow_filter, got.shadow_filter);
        assert_int_equal(sent.residual_filter, got.residual_filter);
        assert_true(sent.mu == got.mu);
        assert_true(sent.adaptive.mu == got.adaptive.mu &&
                    sent.adaptive.rays_max == got.adaptive.rays_max);
        assert_memory_equal(sent.lights, got.lights, lights * sizeof sent.lights[0]);
        assert_int_equal(sent.pattern.seed, got.pattern.seed);
        bytes_writer_fini(&w);
        bytes_writer_fini(&again);
    }
}

TEST(bytes_are_golden)
{
    static struct plan plan;
    struct bytes_writer w;
    plan_case(&plan);
    encode(&plan, &w);
    golden_check("tests/golden/wire/plan.bin", w.data, w.size_bytes);
    bytes_writer_fini(&w);
}

TEST(cut_and_grown_plans_fail)
{
    static struct plan plan, got;
    struct bytes_writer w;
    struct fault fault;
    plan_case(&plan);
    encode(&plan, &w);
    for (size_t size_bytes = 0; size_bytes < w.size_bytes; size_bytes++)
        assert_int_equal(decode(w.data, size_bytes, &got, &fault), ERR_TRUNCATED);
    bytes_write_u8(&w, 0);
    assert_int_equal(decode(w.data, w.size_bytes, &got, &fault), ERR_TRAILING);
    bytes_writer_fini(&w);
}

TEST(light_count_is_checked)
{
    static struct plan plan, got;
    struct bytes_writer w;
    struct fault fault = {0};
    plan_case(&plan);
    plan.light_count = 0;
    encode(&plan, &w);
    memset(w.data + w.size_bytes - 4, 0xff, 4); /* the count is last but the lights */
    assert_int_equal(decode(w.data, w.size_bytes, &got, &fault), ERR_LIMIT);
    assert_string_equal(fault.pointer, "light_count");
    w.data[w.size_bytes - 4] = LIMIT_LIGHTS;
    memset(w.data + w.size_bytes - 3, 0, 3);
    assert_int_equal(decode(w.data, w.size_bytes, &got, &fault), ERR_TRUNCATED);
    bytes_writer_fini(&w);
}
