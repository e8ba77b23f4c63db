#include "server/cli/directories.h"

#include <errno.h>
#include <fcntl.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

typedef char path_text[DIRECTORIES_PATH_BYTES];

/* Joins dir and name; false when the path is too long. */
static bool join(path_text out, const char *dir, const char *name)
{
    if (strlen(dir) + strlen(name) + 2 > DIRECTORIES_PATH_BYTES) return false;
    char *end = stpcpy(out, dir);
    *end = '/';
    stpcpy(end + 1, name);
    return true;
}

static int own_folder(path_text out, struct fault *fault)
{
    ssize_t n = readlink("/proc/self/exe", out, DIRECTORIES_PATH_BYTES - 1);
    if (n <= 0) return fault_set(fault, ERR_IO, "/proc/self/exe", "%s", strerror(errno));
    out[n] = '\0';
    *strrchr(out, '/') = '\0';
    return 0;
}

static int find_program(const char *folder, const char *name, path_text out, struct fault *fault)
{
    if (join(out, folder, name) && access(out, X_OK) == 0) return 0;
    return fault_set(fault, ERR_NOT_FOUND, name, "%s is not beside this program: %s", out,
                     strerror(errno));
}

/* Finds a path beside the program, from build/, build/asan/ and bin/ of an installation. */
static int find_beside(const char *folder, const char *const tries[3], path_text out,
                       struct fault *fault)
{
    for (int i = 0; i < 3; i++)
        if (join(out, folder, tries[i]) && access(out, R_OK) == 0) return 0;
    return fault_set(fault, ERR_NOT_FOUND, tries[0], "%s, %s and %s do not exist, seen from %s",
                     tries[0], tries[1], tries[2], folder);
}

static int find_shipped(const char *web, struct directories *out, struct fault *fault)
{
    static const char *const pages[3] = {"../web", "../../web", "../share/shearwater/web"};
    static const char *const contract[3] = {"../proto/openapi.yaml", "../../proto/openapi.yaml",
                                            "../share/shearwater/openapi.yaml"};
    path_text folder;
    int error = own_folder(folder, fault);
    if (!error) error = find_program(folder, "shearwater-worker", out->worker, fault);
    if (!error) error = find_program(folder, "shearwater-import", out->import, fault);
    /* Without the contract's text everything but its own page works. */
    if (!error && find_beside(folder, contract, out->openapi, fault) != 0) out->openapi[0] = '\0';
    if (!error && !web) error = find_beside(folder, pages, out->web, fault);
    if (!error && web && (!realpath(web, out->web) || access(out->web, R_OK | X_OK) != 0))
        error = fault_set(fault, ERR_NOT_FOUND, web, "%s", strerror(errno));
    return error;
}

int directories_find_worker(char out[DIRECTORIES_PATH_BYTES], struct fault *fault)
{
    path_text folder;
    const int error = own_folder(folder, fault);
    return error ? error : find_program(folder, "shearwater-worker", out, fault);
}

static int make_folders(path_text path)
{
    for (char *slash = path + 1; (slash = strchr(slash, '/')); *slash++ = '/') {
        *slash = '\0';
        if (mkdir(path, 0700) != 0 && errno != EEXIST) return -1;
    }
    return mkdir(path, 0700) != 0 && errno != EEXIST ? -1 : 0;
}

static int default_data(path_text out, struct fault *fault)
{
    const char *base = getenv("XDG_DATA_HOME"), *home = getenv("HOME");
    if (base && base[0] == '/' && join(out, base, "shearwater")) return 0;
    if (home && home[0] == '/' && join(out, home, ".local/share/shearwater")) return 0;
    return fault_set(fault, ERR_MISSING, "--data", "HOME is not set: give a directory");
}

int directories_lock(const char *data, int *fd, struct fault *fault)
{
    path_text lock;
    if (!join(lock, data, "serve.lock"))
        return fault_set(fault, ERR_LIMIT, data, "the path is too long");
    *fd = open(lock, O_RDWR | O_CREAT | O_CLOEXEC, 0600);
    if (*fd < 0) return fault_set(fault, ERR_IO, lock, "%s", strerror(errno));
    if (flock(*fd, LOCK_EX | LOCK_NB) == 0) return 0;
    if (errno == EWOULDBLOCK)
        return fault_set(fault, ERR_EXISTS, data, "another coordinator uses this folder");
    return fault_set(fault, ERR_UNSUPPORTED, lock,
                     "its file system cannot lock it against other coordinators: %s",
                     strerror(errno));
}

static int open_data(const char *data, struct directories *out, struct fault *fault)
{
    path_text wanted;
    int error = 0;
    if (data)
        snprintf(wanted, sizeof wanted, "%s", data);
    else
        error = default_data(wanted, fault);
    if (error) return error;
    if (make_folders(wanted) != 0 || !realpath(wanted, out->data))
        return fault_set(fault, ERR_IO, wanted, "%s", strerror(errno));
    if (!join(out->blobs, out->data, "objects") || !join(out->cache, out->data, "cache"))
        return fault_set(fault, ERR_LIMIT, out->data, "the path is too long");
    return directories_lock(out->data, &out->lock_fd, fault);
}

/* A socket's path has room for 107 bytes. Where the data folder's is longer, the socket goes into a
 * private folder of its own. */
static int place_socket(struct directories *out, struct fault *fault)
{
    const char *base = getenv("XDG_RUNTIME_DIR");
    size_t room = sizeof((struct sockaddr_un *)NULL)->sun_path;
    if (join(out->socket, out->data, "worker.sock") && strlen(out->socket) < room) return 0;
    if (!base || base[0] != '/' || strlen(base) + 40 > room || access(base, W_OK) != 0)
        base = "/tmp";
    if (!join(out->socket_dir, base, "shearwater-XXXXXX") || !mkdtemp(out->socket_dir)) {
        int error = fault_set(fault, ERR_IO, out->socket_dir, "%s", strerror(errno));
        out->socket_dir[0] = '\0';
        return error;
    }
    return join(out->socket, out->socket_dir, "worker.sock")
               ? 0
               : fault_set(fault, ERR_LIMIT, out->socket_dir, "the path is too long");
}

int directories_find(const char *data, const char *web, struct directories *out,
                     struct fault *fault)
{
    memset(out, 0, sizeof *out);
    out->lock_fd = -1;
    int error = find_shipped(web, out, fault);
    if (!error) error = open_data(data, out, fault);
    if (!error) error = place_socket(out, fault);
    if (error) directories_leave(out);
    return error;
}

void directories_leave(struct directories *directories)
{
    if (directories->socket_dir[0]) {
        unlink(directories->socket);
        rmdir(directories->socket_dir);
    }
    if (directories->lock_fd >= 0) close(directories->lock_fd);
    directories->lock_fd = -1;
    directories->socket_dir[0] = '\0';
}
