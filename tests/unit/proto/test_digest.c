/* SHA-256 against published values (FIPS 180-2, appendix B), and the hexadecimal form. */
#include <stdlib.h>
#include <string.h>

#include "proto/digest.h"
#include "proto/error.h"
#include "tests/unit/unit.h"

static void check(const char *text, const char *expected)
{
    struct digest d;
    char hex[DIGEST_HEX_BYTES];
    digest_of(text, strlen(text), &d);
    digest_to_hex(&d, hex);
    assert_string_equal(hex, expected);
}

TEST(known_values)
{
    check("", "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
    check("abc", "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    check("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq",
          "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
    struct digest empty;
    digest_of(NULL, 0, &empty);
    assert_int_equal(empty.bytes[0], 0xe3);
}

TEST(pieces_make_the_whole)
{
    uint8_t data[1000];
    for (size_t i = 0; i < sizeof data; i++) data[i] = (uint8_t)(i * 37);
    struct digest whole, pieces;
    digest_of(data, sizeof data, &whole);
    for (size_t piece_bytes = 1; piece_bytes <= sizeof data; piece_bytes += 111) {
        struct digest_state *running = digest_begin();
        assert_non_null(running);
        for (size_t at = 0; at < sizeof data; at += piece_bytes) {
            size_t left = sizeof data - at;
            size_t now = piece_bytes < left ? piece_bytes : left;
            assert_int_equal(digest_update(running, data + at, now), ERR_OK);
        }
        assert_int_equal(digest_update(running, NULL, 0), ERR_OK);
        digest_finish(&running, &pieces);
        assert_null(running);
        assert_true(digest_equal(&whole, &pieces));
    }
}

TEST(hex_round_trip)
{
    struct digest d, back;
    char hex[DIGEST_HEX_BYTES];
    for (size_t i = 0; i < DIGEST_BYTES; i++) d.bytes[i] = (uint8_t)(i * 8 + 3);
    digest_to_hex(&d, hex);
    assert_int_equal(strlen(hex), 64);
    assert_int_equal(digest_from_hex(hex, &back), ERR_OK);
    assert_true(digest_equal(&d, &back));
    back.bytes[31] ^= 1;
    assert_false(digest_equal(&d, &back));
}

TEST(hex_refuses)
{
    static const char good[] = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
    struct digest d = {{1}};
    for (size_t length = 0; length < 64; length++) {
        char *shorter = strndup(good, length); /* exact: reading on is seen by a sanitizer */
        assert_non_null(shorter);
        assert_int_equal(digest_from_hex(shorter, &d), ERR_SYNTAX);
        free(shorter);
    }
    char text[67];
    for (size_t at = 0; at < 64; at++) {
        static const char wrong[] = "gAF /:`@\x7f\xff";
        for (const char *c = wrong; *c != '\0'; c++) {
            memcpy(text, good, sizeof good);
            text[at] = *c;
            assert_int_equal(digest_from_hex(text, &d), ERR_SYNTAX);
        }
    }
    memcpy(text, good, sizeof good);
    memcpy(text + 64, "0", 2);
    assert_int_equal(digest_from_hex(text, &d), ERR_SYNTAX);
    assert_int_equal(d.bytes[0], 1); /* untouched on failure */
}

TEST(zero_is_known)
{
    struct digest d = {{0}};
    assert_true(digest_is_zero(&d));
    d.bytes[31] = 1;
    assert_false(digest_is_zero(&d));
}
