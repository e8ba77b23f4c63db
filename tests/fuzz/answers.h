#pragma once
/* What a server sent on one connection, read as strictly as a client may that trusts nobody. */
#include <stdbool.h>
#include <stddef.h>

/* Is it a row of whole answers? Each has a status line, fields of one line, a body of its stated
 * length, in whole chunks, or up to the connection's end where `Connection: close` says so; a
 * problem is a JSON document with the same status. may_lack_bodies: some requests were HEAD, whose
 * answers state lengths and have no bodies. may_be_cut: the last one may stop anywhere. */
bool answers_are_whole(const char *text, size_t size_bytes, bool may_lack_bodies, bool may_be_cut);
