/* Ids of Cryptomatte: hashes against published values, names of what has none. */
#include <stdio.h>
#include <string.h>

#include "proto/scene/matte.h"
#include "tests/unit/unit.h"

/* Values of MurmurHash3_x86_32 with seed 0 that its implementations are tested by, for tails of
 * none to three bytes. */
TEST(hashes_are_murmurs)
{
    assert_int_equal(matte_hash(""), 0);
    assert_int_equal(matte_hash("a"), 0x3c2569b2);
    assert_int_equal(matte_hash("ab"), 0x9bbfd75f);
    assert_int_equal(matte_hash("abc"), 0xb3dd93fa);
    assert_int_equal(matte_hash("test"), 0xba6bd213);
    assert_int_equal(matte_hash("Hello, world!"), 0xc0363e43);
}

/* The vectors of Psyop's decoder (cryptomatte_utilities_tests.py). */
TEST(ids_are_those_of_the_reference_decoder)
{
    static const struct {
        const char *name;
        float id;
    } rows[] = {
        {"hello", 6.0705627102400005616e-17f},
        {"cube", -4.08461912519e+15f},
        {"sphere", 2.79018604383e+15f},
        {"plane", 3.66557617593e-11f},
        {"\xd1\x80\xd0\xb0\xd0\xb2\xd0\xbd\xd0\xb8\xd0\xbd\xd0\xb0", -1.3192631212399999468e-25f},
        {"m\xc3\xa4"
         "dchen",
         6.2361298211599995797e+25f},
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        const uint32_t id = matte_id(rows[i].name);
        float number;
        memcpy(&number, &id, sizeof number);
        assert_true(number == rows[i].id);
    }
}

/* Of so many names some hash to every exponent. */
TEST(ids_are_normal_floats)
{
    uint32_t turned = 0;
    for (int i = 0; i < 20000; i++) {
        char name[16];
        snprintf(name, sizeof name, "n%d", i);
        const uint32_t id = matte_id(name), exponent = id >> 23 & 255u;
        assert_in_range(exponent, 1, 254);
        turned += id != matte_hash(name);
        assert_int_equal(id & ~(1u << 23), matte_hash(name) & ~(1u << 23));
    }
    assert_in_range(turned, 50, 500);
}

TEST(what_has_no_name_gets_one)
{
    const struct scene_mesh meshes[] = {{.material = 1}, {.material = 0, .name = 1}};
    const struct scene_instance instances[] = {{.mesh = 0}, {.mesh = 1}, {.mesh = 1, .name = 5}};
    const struct scene_material materials[] = {{.name = 9}, {.name = 0}};
    const struct scene scene = {.meshes = meshes,
                                .instances = instances,
                                .materials = materials,
                                .names = "\0box\0one\0red"};
    char room[32];
    assert_string_equal(matte_name(&scene, MATTE_OBJECT, 0, room), "object 0");
    assert_string_equal(matte_name(&scene, MATTE_OBJECT, 1, room), "box");
    assert_string_equal(matte_name(&scene, MATTE_OBJECT, 2, room), "one");
    assert_string_equal(matte_name(&scene, MATTE_MATERIAL, 0, room), "material 1");
    assert_string_equal(matte_name(&scene, MATTE_MATERIAL, 2, room), "red");
}
