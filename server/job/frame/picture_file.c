#include "server/job/frame/picture_file.h"

#include <stdio.h>
#include <stdlib.h>

#include "server/image/png.h"

struct png_options picture_png_options(const struct job *job)
{
    return (struct png_options){.view = job->view,
                                .exposure_ev = job->exposure,
                                .is_deep = job->png_bits == 16,
                                .alpha = job->png_alpha};
}

static int begin_exr(struct picture_file *file, struct fault *fault)
{
    char path[OBJECTS_PATH_BYTES + 16];
    int error = objects_make_dir(file->objects, file->dir);
    if (error) {
        file->dir[0] = '\0';
        return fault_set(fault, error, "", "no folder to write the picture in");
    }
    snprintf(path, sizeof path, "%s/image.exr", file->dir);
    return exr_rows_begin(path, file->image, file->metadata, &file->exr, fault);
}

static int begin(struct picture_file *file, struct fault *fault)
{
    if (file->exr || file->png) return 0;
    if (file->kind == PICTURE_FILE_EXR) return begin_exr(file, fault);
    const int error = png_rows_begin(file->image, file->layer, &file->png_options, &file->png);
    return error ? fault_set(fault, error, "", "the PNG file could not be begun") : 0;
}

static int write(struct picture_file *file, int32_t end, struct fault *fault)
{
    int error = begin(file, fault);
    if (error) return error;
    if (file->exr) return exr_rows_write(file->exr, end, fault);
    error = png_rows_write(file->png, end);
    return error ? fault_set(fault, error, "", "the PNG file could not be encoded") : 0;
}

int picture_file_write(struct picture_file *file, int32_t end, struct fault *fault)
{
    const int error = write(file, end, fault);
    if (error) picture_file_drop(file);
    return error;
}

static int store_exr(struct picture_file *file, struct digest *out, struct fault *fault)
{
    char path[OBJECTS_PATH_BYTES + 16];
    snprintf(path, sizeof path, "%s/image.exr", file->dir);
    int error = exr_rows_finish(&file->exr, fault);
    if (!error && (error = objects_adopt(file->objects, path, out)) != 0)
        fault_set(fault, error, "", "the EXR file could not be stored");
    return error;
}

static int store_png(struct picture_file *file, struct digest *out, struct fault *fault)
{
    struct object_writer *writer = NULL;
    uint8_t *bytes = NULL;
    size_t size_bytes = 0;
    bool existed;
    int error = png_rows_finish(&file->png, &bytes, &size_bytes);
    if (!error) error = object_writer_begin(file->objects, &writer);
    if (!error) error = object_writer_append(writer, bytes, size_bytes);
    if (!error) error = object_writer_finish(&writer, NULL, out, &existed);
    if (error) fault_set(fault, error, "", "the PNG file could not be stored");
    if (writer) object_writer_abort(&writer);
    free(bytes);
    return error;
}

int picture_file_finish(struct picture_file *file, struct digest *out, struct fault *fault)
{
    int error = begin(file, fault);
    if (!error) error = file->exr ? store_exr(file, out, fault) : store_png(file, out, fault);
    picture_file_drop(file);
    return error;
}

void picture_file_drop(struct picture_file *file)
{
    exr_rows_abort(&file->exr);
    png_rows_abort(&file->png);
    if (file->dir[0]) objects_remove_dir(file->dir);
    file->dir[0] = '\0';
}
