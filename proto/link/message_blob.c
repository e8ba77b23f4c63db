/* Messages about blobs. */
#include "proto/link/message.h"
#include "proto/link/message_parts.h"

void message_encode_blob_get(struct bytes_writer *w, const struct message_blob_get *m)
{
    message_write_digest(w, &m->digest);
    bytes_write_u64(w, m->offset);
    bytes_write_u32(w, m->size_bytes);
}

int message_decode_blob_get(const void *payload, size_t size_bytes, struct message_blob_get *m)
{
    struct bytes_reader r = message_reader(payload, size_bytes, m, sizeof *m);
    message_read_digest(&r, &m->digest);
    m->offset = bytes_read_u64(&r);
    m->size_bytes = bytes_read_u32(&r);
    int code = bytes_finish(&r);
    if (code != ERR_OK) return code;
    if (m->offset >= LIMIT_BLOB_BYTES || m->size_bytes > LIMIT_BLOB_PART_BYTES) return ERR_LIMIT;
    return m->size_bytes != 0 ? ERR_OK : ERR_RANGE;
}

void message_encode_blob_part(struct bytes_writer *w, const struct message_blob_part *m)
{
    message_write_digest(w, &m->digest);
    bytes_write_u64(w, m->total_bytes);
    bytes_write_u64(w, m->offset);
}

static int check_blob_part(const struct message_blob_part *m)
{
    if (m->total_bytes > LIMIT_BLOB_BYTES || m->size_bytes > LIMIT_BLOB_PART_BYTES)
        return ERR_LIMIT;
    if (m->size_bytes == 0 || m->offset >= m->total_bytes) return ERR_RANGE;
    return m->size_bytes <= m->total_bytes - m->offset ? ERR_OK : ERR_RANGE;
}

int message_decode_blob_part(const void *payload, size_t size_bytes, struct message_blob_part *m)
{
    struct bytes_reader r = message_reader(payload, size_bytes, m, sizeof *m);
    message_read_digest(&r, &m->digest);
    m->total_bytes = bytes_read_u64(&r);
    m->offset = bytes_read_u64(&r);
    int code = message_read_tail(&r, &m->bytes, &m->size_bytes);
    if (code == ERR_OK) code = bytes_finish(&r);
    return code != ERR_OK ? code : check_blob_part(m);
}

void message_encode_blob_none(struct bytes_writer *w, const struct message_blob_none *m)
{
    message_write_digest(w, &m->digest);
}

int message_decode_blob_none(const void *payload, size_t size_bytes, struct message_blob_none *m)
{
    struct bytes_reader r = message_reader(payload, size_bytes, m, sizeof *m);
    message_read_digest(&r, &m->digest);
    return bytes_finish(&r);
}
