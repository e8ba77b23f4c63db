#pragma once
/* Lingering close, for connections whose client still sends. If unread bytes lie in a socket when
 * it is closed, the kernel resets the connection, and the answer may be lost on its way. So the
 * socket is kept a second longer, emptied now and then, and closed earlier if the client ends. */
#define LINGER_MAX   256
#define LINGER_TICKS 4

struct linger_list {
    unsigned most; /* 1 to LINGER_MAX: descriptors */
    unsigned count;
    int fd[LINGER_MAX];
    unsigned ticks[LINGER_MAX];
};

/* Keeps a duplicate of the descriptor and shuts sending down. When there is no room, the socket
 * that was kept longest is closed for it. */
void linger_add(struct linger_list *l, int fd);
void linger_tick(struct linger_list *l);
void linger_close_all(struct linger_list *l);
