/* Streams of KHR_draco_mesh_compression: whatever the bytes, no mesh, or one whose triangles name
 * its vertices and whose numbers fill exactly what they were counted to; the address sanitizer
 * watches. */
// sources: server/import/draco/*.cc
// libs: -ldraco -lstdc++
#include <stdlib.h>
#include <string.h>

#include "server/import/draco/draco_shim.h"

/* Fuzzing is for streams, not for filling memory. */
#define ELEMENTS_MAX 1000000u
#define IDS          10u

static void check_triangles(const struct draco_shim *mesh)
{
    const uint32_t vertices = draco_shim_vertices(mesh);
    const size_t count = (size_t)3 * draco_shim_triangles(mesh);
    uint32_t *corners = malloc(count * sizeof *corners + 1);
    if (!corners) abort();
    if (draco_shim_indices(mesh, corners))
        for (size_t i = 0; i < count; i++)
            if (corners[i] >= vertices) abort();
    free(corners);
}

static void check_attribute(const struct draco_shim *mesh, uint32_t id)
{
    const uint32_t components = draco_shim_components(mesh, id);
    if (components == 0 || components > 4) return;
    float *numbers = malloc((size_t)components * draco_shim_vertices(mesh) * sizeof *numbers + 1);
    if (!numbers) abort();
    (void)draco_shim_floats(mesh, id, components, numbers);
    free(numbers);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size_bytes);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size_bytes)
{
    struct draco_shim *mesh = NULL;
    uint8_t *exact = malloc(size_bytes + (size_bytes == 0));
    if (!exact) abort();
    if (size_bytes > 0) memcpy(exact, data, size_bytes);
    const enum draco_shim_status status = draco_shim_decode(exact, size_bytes, &mesh);
    if ((status == DRACO_SHIM_OK) != (mesh != NULL)) abort();
    if (mesh && draco_shim_vertices(mesh) <= ELEMENTS_MAX &&
        draco_shim_triangles(mesh) <= ELEMENTS_MAX) {
        check_triangles(mesh);
        for (uint32_t id = 0; id < IDS; id++) check_attribute(mesh, id);
    }
    draco_shim_destroy(&mesh);
    free(exact);
    return 0;
}
