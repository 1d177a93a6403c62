/* A host without Python of its own: loads the library of an FMU (FMI 2.0), makes instances one after another, takes steps
   with each, and prints every bit of some outputs at the start and behind each step.
   Arguments: library, GUID, resource URI, log or quiet, number of instances, number of steps, step (s), value references. */
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct {
    void (*logger)(void *, const char *, int, const char *, const char *, ...);
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void *step_finished, *environment;
} Callbacks;

static void logger(void *e, const char *n, int s, const char *c, const char *m, ...) { fprintf(stderr, "log %d: %s\n", s, m); }

int main(int argc, char **argv) {
    void *library = dlopen(argv[1], RTLD_NOW | RTLD_LOCAL);
    if (!library) return fprintf(stderr, "%s\n", dlerror()), 2;
    void *(*instantiate)(const char *, int, const char *, const char *, const Callbacks *, int, int) = dlsym(library, "fmi2Instantiate");
    int (*setup)(void *, int, double, double, int, double) = dlsym(library, "fmi2SetupExperiment");
    int (*enter)(void *) = dlsym(library, "fmi2EnterInitializationMode"), (*leave)(void *) = dlsym(library, "fmi2ExitInitializationMode");
    int (*step)(void *, double, double, int) = dlsym(library, "fmi2DoStep");
    int (*get)(void *, const unsigned *, size_t, double *) = dlsym(library, "fmi2GetReal");
    int (*terminate)(void *) = dlsym(library, "fmi2Terminate");
    void (*release)(void *) = dlsym(library, "fmi2FreeInstance");
    const Callbacks callbacks = {logger, calloc, free, NULL, NULL};
    const int log = !strcmp(argv[4], "log"), instances = atoi(argv[5]), steps = atoi(argv[6]), outputs = argc - 8;
    const double h = strtod(argv[7], NULL);
    for (int n = 0; n < instances; n++) {
        void *unit = instantiate("unit", 1, argv[2], argv[3], &callbacks, 0, log);
        if (!unit || setup(unit, 0, 0.0, 0.0, 0, 0.0) || enter(unit) || leave(unit)) return 3;
        for (int k = 0; k <= steps; k++) {
            if (k && step(unit, (k - 1) * h, h, 1)) return 4;
            for (int i = 0; i < outputs; i++) {
                const unsigned reference = (unsigned)atoi(argv[8 + i]);
                double value;
                if (get(unit, &reference, 1, &value)) return 5;
                printf("%a%c", value, i + 1 < outputs ? ' ' : '\n');
            }
        }
        if (terminate(unit)) return 6;
        release(unit);
    }
    fprintf(stderr, "done\n");
    return 0;
}
