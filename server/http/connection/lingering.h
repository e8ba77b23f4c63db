#pragma once
/* Closing a connection whose client still sends: if unread bytes lie in the socket when it is
 * closed, the kernel resets the connection, and the answer may be lost on its way. So the socket is
 * kept a second longer, emptied now and then, and closed; sooner where the client has ended. */
#define LINGERING_MOST  256
#define LINGERING_TICKS 4

struct lingering {
    unsigned most; /* 1 to LINGERING_MOST: descriptors */
    unsigned count;
    int fd[LINGERING_MOST];
    unsigned ticks[LINGERING_MOST];
};

/* Keeps a duplicate of the descriptor and says that no more will be sent. When there is no room,
 * the one that was kept longest is closed for it. */
void lingering_add(struct lingering *l, int fd);
void lingering_tick(struct lingering *l);
void lingering_close_all(struct lingering *l);
