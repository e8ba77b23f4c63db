#pragma once
/* The server's certificate and its key, in PEM. */
#include "proto/error.h"

struct tls {
    char *certificate, *key; /* owned texts; both or none */
};

/* Reads both and tests them. Only the owner may read the key's file (secret_file.h). *fault says
 * which one is wrong. */
int tls_read(struct tls *tls, const char *certificate_path, const char *key_path,
             struct fault *fault);
void tls_fini(struct tls *tls);

/* Allows TLS 1.2 with forward secrecy, and 1.3. */
#define TLS_PRIORITIES "SECURE128:-VERS-ALL:+VERS-TLS1.3:+VERS-TLS1.2:-RSA:%SERVER_PRECEDENCE"
