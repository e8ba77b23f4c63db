#include "server/reconstruct/oidn/oidn_library.h"

#include <dlfcn.h>
#include <pthread.h>
#include <stdio.h>
#include <string.h>

#define DEVICE_TYPE_CPU 1
#define VERSION_MIN     20000 /* 2.0.0 */
#define VERSION_END     30000

int oidn_library_check(const struct oidn_library *library, void *device, struct fault *fault)
{
    const char *message = NULL;
    const int code = library->GetDeviceError(device, &message);
    if (device && code == OIDN_ERROR_NONE) return 0;
    return fault_set(fault, code == OIDN_ERROR_OUT_OF_MEMORY ? ERR_MEMORY : ERR_UNSUPPORTED,
                     "/filter/residual", "%s: %s", library->label,
                     message && *message ? message : "it tells no reason");
}

/* One thread a frame, as of all work on pictures: several frames run side by side. */
void *oidn_library_device(const struct oidn_library *library, struct fault *fault)
{
    void *device = library->NewDevice(DEVICE_TYPE_CPU);
    if (oidn_library_check(library, device, fault) != 0) return NULL;
    library->SetDeviceInt(device, "numThreads", 1);
    library->SetDeviceBool(device, "setAffinity", false);
    library->CommitDevice(device);
    if (oidn_library_check(library, device, fault) == 0) return device;
    library->ReleaseDevice(device);
    return NULL;
}

/* C has no way from a pointer to data to one to a function but by its bytes (POSIX, dlsym). */
static bool find(void *handle, const char *name, void *function)
{
    void *symbol = dlsym(handle, name);
    memcpy(function, &symbol, sizeof symbol);
    return symbol != NULL;
}

/* Returns the name of a function that the library lacks; NULL: it has all. */
static const char *find_all(struct oidn_library *library)
{
#define OIDN_FIND(type, name, arguments)                                                           \
    if (!find(library->handle, "oidn" #name, &library->name)) return "oidn" #name;
    OIDN_FUNCTIONS(OIDN_FIND)
#undef OIDN_FIND
    return NULL;
}

static int check_version(struct oidn_library *library, struct fault *fault)
{
    void *device = oidn_library_device(library, fault);
    if (!device) return fault->code;
    const int version = library->GetDeviceInt(device, "version");
    library->ReleaseDevice(device);
    snprintf(library->label, sizeof library->label, "Open Image Denoise %d.%d.%d", version / 10000,
             version / 100 % 100, version % 100);
    if (version >= VERSION_MIN && version < VERSION_END) return 0;
    return fault_set(fault, ERR_UNSUPPORTED, "/filter/residual",
                     "%s is installed, but oidn needs a version 2", library->label);
}

int oidn_library_open(const char *name, struct oidn_library *out, struct fault *fault)
{
    *out = (struct oidn_library){.handle = dlopen(name, RTLD_NOW | RTLD_LOCAL),
                                 .label = "Open Image Denoise"};
    if (!out->handle)
        return fault_set(fault, ERR_UNSUPPORTED, "/filter/residual",
                         "Open Image Denoise 2 is not installed on the coordinator's machine (%s): "
                         "take auto, or ask who runs it",
                         dlerror());
    const char *lacks = find_all(out);
    const int error = lacks ? fault_set(fault, ERR_UNSUPPORTED, "/filter/residual",
                                        "%s lacks %s, which Open Image Denoise 2 has", name, lacks)
                            : check_version(out, fault);
    if (error) oidn_library_close(out);
    return error;
}

void oidn_library_close(struct oidn_library *library)
{
    if (library->handle) dlclose(library->handle);
    library->handle = NULL;
}

static struct oidn_library own;
static struct fault own_fault;
static int own_error;

static void open_own(void)
{
    own_error = oidn_library_open(OIDN_LIBRARY, &own, &own_fault);
}

const struct oidn_library *oidn_library_get(struct fault *fault)
{
    static pthread_once_t once = PTHREAD_ONCE_INIT;
    pthread_once(&once, open_own);
    if (!own_error) return &own;
    *fault = own_fault;
    return NULL;
}
