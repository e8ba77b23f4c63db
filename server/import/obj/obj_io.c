#include "server/import/obj/obj_io.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* One open file; `file` comes first, so that assimp's pointer leads back here. */
struct open_file {
    struct aiFile file;
    struct file_view view;
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

static struct aiFile *on_open(struct aiFileIO *callbacks, const char *name, const char *mode)
{
    struct obj_io *io = (struct obj_io *)(void *)callbacks->UserData;
    if (mode[0] != 'r' || strcmp(name, io->alias) != 0) return NULL;
    struct open_file *f = calloc(1, sizeof *f);
    if (f == NULL) return NULL;
    f->view = *io->main;
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
    free(f);
}

void obj_io_init(struct obj_io *io, const char *alias, const struct file_view *main)
{
    *io = (struct obj_io){.alias = alias, .main = main};
    io->callbacks = (struct aiFileIO){
        .OpenProc = on_open, .CloseProc = on_close, .UserData = (aiUserData)(void *)io};
}
