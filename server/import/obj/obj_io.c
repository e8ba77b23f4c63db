#include "server/import/obj/obj_io.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* One open file; `file` comes first, so that assimp's pointer leads back here. */
struct open_file {
    struct aiFile file;
    struct file_view view;
    bool mapped; /* view is ours to unmap */
    size_t at;
};

static struct open_file *self(struct aiFile *file)
{
    return (struct open_file *)(void *)file;
}

static size_t on_read(struct aiFile *file, char *out, size_t size, size_t count)
{
    struct open_file *f = self(file);
    size_t left = f->view.size_bytes - f->at;
    if (size == 0) return 0;
    if (count > left / size) count = left / size;
    memcpy(out, f->view.data + f->at, size * count);
    f->at += size * count;
    return count;
}

static size_t on_write(struct aiFile *file, const char *data, size_t size, size_t count)
{
    (void)file; /* nothing is ever written */
    (void)data;
    (void)size;
    (void)count;
    return 0;
}

static size_t on_tell(struct aiFile *file)
{
    return self(file)->at;
}

static size_t on_size(struct aiFile *file)
{
    return self(file)->view.size_bytes;
}

static enum aiReturn on_seek(struct aiFile *file, size_t offset, enum aiOrigin origin)
{
    struct open_file *f = self(file);
    size_t size = f->view.size_bytes;
    size_t base = origin == aiOrigin_SET ? 0 : origin == aiOrigin_CUR ? f->at : size;
    size_t to = base + offset; /* assimp passes steps back as wrapped numbers */
    if (to > size) return aiReturn_FAILURE;
    f->at = to;
    return aiReturn_SUCCESS;
}

static void on_flush(struct aiFile *file)
{
    (void)file;
}

/* Keeps the first failure: the mtllib that was asked for, not assimp's guesses after it. */
static void keep_fault(struct obj_io *io, const struct fault *fault)
{
    if (!io->failed) io->fault = *fault;
    io->failed = true;
}

static bool find_file(struct obj_io *io, const char *name, struct open_file *f)
{
    struct fault fault = {0};
    char cleaned[LIMIT_PATH_BYTES], path[LIMIT_PATH_BYTES];
    if (strcmp(name, io->alias) == 0) {
        f->view = *io->main;
        return true;
    }
    snprintf(cleaned, sizeof cleaned, "%s", name);
    for (char *c = cleaned; *c != 0; c++)
        if (*c == '\\') *c = '/'; /* as written on Windows */
    for (size_t n = strlen(cleaned); n > 0 && strchr(" \t\r", cleaned[n - 1]) != NULL; n--)
        cleaned[n - 1] = 0;
    int rc = files_resolve("", cleaned, false, path, "mtllib", &fault);
    if (rc == 0) rc = files_map(io->files, path, "mtllib", &f->view, &fault);
    if (rc == 0) f->mapped = true;
    if (rc != 0) keep_fault(io, &fault);
    return rc == 0;
}

static struct aiFile *on_open(struct aiFileIO *callbacks, const char *name, const char *mode)
{
    struct obj_io *io = (struct obj_io *)(void *)callbacks->UserData;
    struct open_file *f = mode[0] == 'r' ? calloc(1, sizeof *f) : NULL;
    if (f == NULL) return NULL;
    if (!find_file(io, name, f)) {
        free(f);
        return NULL;
    }
    f->file = (struct aiFile){.ReadProc = on_read,
                              .WriteProc = on_write,
                              .TellProc = on_tell,
                              .FileSizeProc = on_size,
                              .SeekProc = on_seek,
                              .FlushProc = on_flush,
                              .UserData = NULL};
    return &f->file;
}

static void on_close(struct aiFileIO *callbacks, struct aiFile *file)
{
    (void)callbacks;
    struct open_file *f = self(file);
    if (f == NULL) return;
    if (f->mapped) files_unmap(&f->view);
    free(f);
}

void obj_io_init(struct obj_io *io, struct files *files, const char *alias,
                 const struct file_view *main)
{
    *io = (struct obj_io){.files = files, .alias = alias, .main = main};
    io->callbacks = (struct aiFileIO){
        .OpenProc = on_open, .CloseProc = on_close, .UserData = (aiUserData)(void *)io};
}
