#pragma once
/* A stored object as an answer: strong tag, conditions, byte ranges (RFC 9110). */
#include "server/http/request.h"

/* Answers with the object. ending: "exr", for the name under which a browser saves it. */
void object_file_answer(struct request *r, const struct digest *digest, const char *type,
                        const char *ending);
