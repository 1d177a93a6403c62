/* A host without Python: pantograph and catenary stepped in turns with held inputs, and how long each pair of steps takes.

   railway PANTOGRAPH GUID REFERENCES CATENARY GUID REFERENCES STEP STEPS PASSES; references: inputs, then outputs, by commas.
   Each pass begins with the states after initialization. Prints the last outputs as hexadecimal numbers, then the mean, the
   99.99th percentile and the longest duration in microseconds, of the clock and of the processor. */
#define _POSIX_C_SOURCE 200809L
#include <stdio.h>
#include <stdlib.h>
#include <time.h>
#include "dynamic.h"

typedef struct {
    fmi2Component instance;
    fmi2ValueReference references[3];
    fmi2GetRealTYPE *get;
    fmi2SetRealTYPE *set;
    fmi2DoStepTYPE *step;
    fmi2GetFMUstateTYPE *save;
    fmi2SetFMUstateTYPE *restore;
    fmi2FMUstate begin;
} Unit;

static Unit opened(char **arguments) {
    Unit u;
    void *library;
    u.instance = instance(arguments[0], arguments[1], &library);
    if (sscanf(arguments[2], "%u,%u,%u", u.references, u.references + 1, u.references + 2) != 3) exit(1);
    u.get = symbol(library, "fmi2GetReal"), u.set = symbol(library, "fmi2SetReal"), u.step = symbol(library, "fmi2DoStep");
    u.save = symbol(library, "fmi2GetFMUstate"), u.restore = symbol(library, "fmi2SetFMUstate");
    u.begin = NULL;
    check(u.save(u.instance, &u.begin), "GetFMUstate");
    return u;
}
static double microseconds(clockid_t clock) {
    struct timespec now;
    clock_gettime(clock, &now);
    return 1e6 * (double)now.tv_sec + 1e-3 * (double)now.tv_nsec;
}
static int ascending(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

int main(int argc, char **arguments) {
    if (argc != 10) return 2;
    Unit p = opened(arguments + 1), c = opened(arguments + 4);
    const double h = atof(arguments[7]);
    const long steps = atol(arguments[8]), passes = atol(arguments[9]);
    static const clockid_t clocks[] = {CLOCK_MONOTONIC, CLOCK_THREAD_CPUTIME_ID};
    double *durations[2], height, contact[2];
    for (int q = 0; q < 2; q++) durations[q] = malloc(sizeof **durations * (size_t)(steps * passes));
    for (long pass = 0; pass < passes; pass++) {
        check(p.restore(p.instance, p.begin), "SetFMUstate");
        check(c.restore(c.instance, c.begin), "SetFMUstate");
        for (long k = 0; k < steps; k++) {
            double before[2];
            for (int q = 0; q < 2; q++) before[q] = microseconds(clocks[q]);
            check(c.get(c.instance, c.references + 2, 1, &height), "GetReal");
            check(p.set(p.instance, p.references, 1, &height), "SetReal");
            check(p.step(p.instance, (double)k * h, h, 0), "DoStep");
            check(p.get(p.instance, p.references + 1, 2, contact), "GetReal");
            check(c.set(c.instance, c.references, 2, contact), "SetReal");
            check(c.step(c.instance, (double)k * h, h, 0), "DoStep");
            for (int q = 0; q < 2; q++) durations[q][pass * steps + k] = microseconds(clocks[q]) - before[q];
        }
    }
    check(c.get(c.instance, c.references + 2, 1, &height), "GetReal");
    printf("%a %a %a\n", height, contact[0], contact[1]);
    for (int q = 0; q < 2; q++) {
        const long n = steps * passes;
        double total = 0.0;
        for (long k = 0; k < n; k++) total += durations[q][k];
        qsort(durations[q], (size_t)n, sizeof **durations, ascending);
        printf("%.2f %.2f %.2f\n", total / (double)n, durations[q][(long)(0.9999 * (double)(n - 1))], durations[q][n - 1]);
        free(durations[q]);
    }
    return 0;
}
