#include "server/import/draco/draco_claims.h"

#include <cstring>

namespace
{
constexpr uint64_t SMALL = 1000000;     /* elements that need no bytes to be believed */
constexpr uint64_t A_BYTE = 256;        /* elements that a byte may stand for beyond */
constexpr size_t HEAD_BYTES = 11;       /* magic, version, type, method, flags */
constexpr unsigned NESTED_MAX = 16;     /* metadata in metadata */
constexpr unsigned HAS_METADATA = 0x80; /* of the flags' second byte */

struct reader {
    const uint8_t *at, *end;
    bool ok;

    uint32_t byte()
    {
        if (at == end) ok = false;
        return ok ? *at++ : 0;
    }
    uint32_t varint()
    {
        uint64_t value = 0;
        for (unsigned shift = 0; shift < 35; shift += 7) {
            const uint32_t b = byte();
            value |= static_cast<uint64_t>(b & 127) << shift;
            if (b < 128) break;
        }
        if (value > UINT32_MAX) ok = false;
        return static_cast<uint32_t>(value);
    }
    void skip(uint32_t bytes)
    {
        if (bytes > static_cast<size_t>(end - at)) ok = false;
        if (ok) at += bytes;
    }
};

/* Entries of a name and a value each, then named metadata of the same kind. */
void skip_metadata(reader &r, unsigned depth)
{
    if (depth == NESTED_MAX) r.ok = false;
    for (uint32_t left = r.ok ? r.varint() : 0; r.ok && left > 0; left--) {
        r.skip(r.byte());
        r.skip(r.varint());
    }
    for (uint32_t left = r.ok ? r.varint() : 0; r.ok && left > 0; left--) {
        r.skip(r.byte());
        skip_metadata(r, depth + 1);
    }
}

void skip_all_metadata(reader &r)
{
    for (uint32_t left = r.varint(); r.ok && left > 0; left--) {
        r.varint(); /* the attribute's id */
        skip_metadata(r, 0);
    }
    skip_metadata(r, 0);
}
} // namespace

bool draco_claims_fit(const uint8_t *data, size_t size_bytes)
{
    if (size_bytes < HEAD_BYTES || std::memcmp(data, "DRACO\2\2\1", 8) != 0) return false;
    reader r = {data + HEAD_BYTES, data + size_bytes, true};
    if (data[10] & HAS_METADATA) skip_all_metadata(r);
    if (data[8] != 0) r.byte(); /* edgebreaker's way to walk; sequential has none */
    const uint32_t one = r.varint(), other = r.varint();
    const uint64_t most = SMALL + A_BYTE * size_bytes;
    return r.ok && one <= most && other <= most;
}
