/* A host without Python of its own: loads a pythonfmu FMU, makes three instances one after another, steps, ends. */
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>

typedef struct {
    void (*logger)(void *, const char *, int, const char *, const char *, ...);
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void *step_finished, *environment;
} Callbacks;

static void logger(void *e, const char *n, int s, const char *c, const char *m, ...) { fprintf(stderr, "log %d: %s\n", s, m); }

int main(int argc, char **argv) { /* argv: library, resource URI[, anything: with messages] */
    void *library = dlopen(argv[1], RTLD_NOW);
    if (!library) { puts(dlerror()); return 2; }
    void *(*instantiate)(const char *, int, const char *, const char *, Callbacks *, int, int) = dlsym(library, "fmi2Instantiate");
    int (*setup)(void *, int, double, double, int, double) = dlsym(library, "fmi2SetupExperiment");
    int (*enter)(void *) = dlsym(library, "fmi2EnterInitializationMode"), (*leave)(void *) = dlsym(library, "fmi2ExitInitializationMode");
    int (*step)(void *, double, double, int) = dlsym(library, "fmi2DoStep");
    void (*release)(void *) = dlsym(library, "fmi2FreeInstance");
    Callbacks callbacks = {logger, calloc, free, NULL, NULL};
    for (int n = 0; n < 3; n++) {
        void *unit = instantiate("unit", 1, "", argv[2], &callbacks, 0, argc > 3);
        if (!unit || setup(unit, 0, 0.0, 0.0, 0, 0.0) || enter(unit) || leave(unit)) return 3;
        for (int k = 0; k < 20; k++)
            if (step(unit, k * 1e-3, 1e-3, 1)) return 4;
        release(unit);
    }
    puts("done");
    return 0;
}
