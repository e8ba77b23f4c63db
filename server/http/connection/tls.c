#include "server/http/connection/tls.h"

#include <errno.h>
#include <fcntl.h>
#include <gnutls/gnutls.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "proto/runtime/secret_file.h"

#define PEM_LIMIT_BYTES 65536u

/* A certificate is no secret. */
static int read_public(const char *path, char **out, struct fault *fault)
{
    FILE *f = fopen(path, "rbe");
    if (!f) return fault_set(fault, ERR_NOT_FOUND, path, "%s", strerror(errno));
    char *text = calloc(1, PEM_LIMIT_BYTES + 1);
    size_t n = text ? fread(text, 1, PEM_LIMIT_BYTES + 1, f) : 0;
    int error = !text ? ERR_MEMORY : ferror(f) ? ERR_IO : n > PEM_LIMIT_BYTES ? ERR_LIMIT : 0;
    fclose(f);
    if (error) {
        free(text);
        return fault_set(fault, error, path, "%s", error_text(error));
    }
    *out = text;
    return 0;
}

/* Tests them here, before a first handshake fails. */
static int try_on(const struct tls *tls, const char *path, struct fault *fault)
{
    gnutls_certificate_credentials_t credentials;
    const gnutls_datum_t certificate = {(unsigned char *)tls->certificate,
                                        (unsigned)strlen(tls->certificate)};
    const gnutls_datum_t key = {(unsigned char *)tls->key, (unsigned)strlen(tls->key)};
    if (gnutls_certificate_allocate_credentials(&credentials) < 0)
        return fault_set(fault, ERR_MEMORY, path, "memory is exhausted");
    int code =
        gnutls_certificate_set_x509_key_mem(credentials, &certificate, &key, GNUTLS_X509_FMT_PEM);
    gnutls_certificate_free_credentials(credentials);
    if (code >= 0) return 0;
    return fault_set(fault, ERR_CORRUPT, path, "certificate and key cannot be used: %s",
                     gnutls_strerror(code));
}

int tls_read(struct tls *tls, const char *certificate_path, const char *key_path,
             struct fault *fault)
{
    size_t size_bytes;
    *tls = (struct tls){0};
    int error = read_public(certificate_path, &tls->certificate, fault);
    if (!error)
        error = secret_file_read(key_path, SECRET_READERS_GROUP, PEM_LIMIT_BYTES, &tls->key,
                                 &size_bytes, fault);
    if (!error) error = try_on(tls, certificate_path, fault);
    if (error) tls_fini(tls);
    return error;
}

void tls_fini(struct tls *tls)
{
    if (tls->key) gnutls_memset(tls->key, 0, strlen(tls->key));
    free(tls->certificate);
    free(tls->key);
    *tls = (struct tls){0};
}
