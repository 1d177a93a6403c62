/* A host without Python: steps one FMU (FMI 2) with inputs that it reads, and prints the outputs.

   driven LIBRARY GUID STEP; reads the numbers of inputs, of outputs and of steps, the value references of both, and for each step the
   values of the inputs, as their bits in hexadecimal digits. Prints the outputs after initialization and after each step. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "dynamic.h"

static size_t whole(void) {
    unsigned long value;
    if (scanf("%lu", &value) != 1) exit(2);
    return value;
}
static double number(void) { /* not all C libraries read hexadecimal fractions */
    unsigned long long bits;
    double value;
    if (scanf("%llx", &bits) != 1) exit(2);
    memcpy(&value, &bits, sizeof value);
    return value;
}
static double *room(size_t n) { return malloc((n ? n : 1) * sizeof(double)); }
static fmi2ValueReference *references(size_t n) {
    fmi2ValueReference *r = malloc((n ? n : 1) * sizeof *r);
    for (size_t k = 0; k < n; k++) r[k] = (fmi2ValueReference)whole();
    return r;
}

int main(int argc, char **arguments) {
    if (argc != 4) return 2;
    void *library;
    fmi2Component c = instance(arguments[1], arguments[2], &library);
    fmi2GetRealTYPE *get = symbol(library, "fmi2GetReal");
    fmi2SetRealTYPE *set = symbol(library, "fmi2SetReal");
    fmi2DoStepTYPE *step = symbol(library, "fmi2DoStep");
    const double h = strtod(arguments[3], NULL);
    const size_t inputs = whole(), outputs = whole(), steps = whole();
    fmi2ValueReference *u = references(inputs), *y = references(outputs);
    double *in = room(inputs), *out = room(outputs);
    for (size_t k = 0; k <= steps; k++) {
        if (k) {
            for (size_t i = 0; i < inputs; i++) in[i] = number();
            check(set(c, u, inputs, in), "SetReal");
            check(step(c, (double)(k - 1) * h, h, 0), "DoStep");
        }
        check(get(c, y, outputs, out), "GetReal");
        for (size_t i = 0; i < outputs; i++) printf("%a ", out[i]);
        putchar('\n');
    }
    return 0;
}
