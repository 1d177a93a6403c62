/* Loading an FMU's library (FMI 2), on Linux and on Windows, up to the end of initialization. */
#include <stdio.h>
#include <stdlib.h>
#include "fmi2FunctionTypes.h"
#ifdef _WIN32
#include <windows.h>
enum { RTLD_NOW, RTLD_LOCAL };
static void *dlopen(const char *path, int mode) { (void)mode; return LoadLibraryA(path); }
static void *dlsym(void *library, const char *name) { return (void *)GetProcAddress(library, name); }
static const char *dlerror(void) { return "the library was not loaded"; }
#else
#include <dlfcn.h>
#endif

static void logger(void *e, fmi2String n, fmi2Status s, fmi2String c, fmi2String text, ...) {
    (void)e; (void)s; (void)c;
    fprintf(stderr, "%s: %s\n", n, text);
}
static const fmi2CallbackFunctions CALLBACKS = {logger, NULL, NULL, NULL, NULL};
static void check(int status, const char *call) {
    if (status > fmi2Warning) { fprintf(stderr, "%s: status %d\n", call, status); exit(1); }
}
static void *symbol(void *library, const char *name) {
    void *found = dlsym(library, name);
    if (!found) { fprintf(stderr, "no %s\n", name); exit(1); }
    return found;
}
/* An instance at the end of initialization, with its start values, and its library. */
static fmi2Component instance(const char *path, const char *token, void **library) {
    *library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    if (!*library) { fprintf(stderr, "%s\n", dlerror()); exit(1); }
    fmi2Component c = ((fmi2InstantiateTYPE *)symbol(*library, "fmi2Instantiate"))(path, fmi2CoSimulation, token, "", &CALLBACKS, 0, 0);
    if (!c) exit(1);
    check(((fmi2SetupExperimentTYPE *)symbol(*library, "fmi2SetupExperiment"))(c, 0, 0.0, 0.0, 0, 0.0), "SetupExperiment");
    check(((fmi2EnterInitializationModeTYPE *)symbol(*library, "fmi2EnterInitializationMode"))(c), "EnterInitializationMode");
    check(((fmi2ExitInitializationModeTYPE *)symbol(*library, "fmi2ExitInitializationMode"))(c), "ExitInitializationMode");
    return c;
}
