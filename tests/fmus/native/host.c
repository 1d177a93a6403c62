/* Random sequences of calls of both versions of FMI, right ones and wrong ones; sanitizers watch.

   host TOKEN SEED SEQUENCES: linked with the runtime and a model. Prints the number of calls, of refusals and of messages. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "fmi2Functions.h"
#include "fmi3Functions.h"

enum { SLOTS = 3, MOST = 8, BUFFER = 1 << 16 };
static unsigned long long seed;
static long calls, refused, messages;
static unsigned below(unsigned n) { /* xorshift */
    seed ^= seed << 13; seed ^= seed >> 7; seed ^= seed << 17;
    return (unsigned)(seed >> 33) % n;
}
static void logger2(void *e, fmi2String n, fmi2Status s, fmi2String c, fmi2String m, ...) {
    (void)e; (void)n;
    if (s < 0 || s > 3 || !strlen(c) || !strlen(m)) abort();
    messages++;
}
static void logger3(void *e, fmi3Status s, fmi3String c, fmi3String m) { logger2(e, "", (fmi2Status)s, c, m); }
static const fmi2CallbackFunctions WITH = {logger2, NULL, NULL, NULL, NULL}, WITHOUT = {NULL, NULL, NULL, NULL, NULL};

static double number(void) {
    static const double odd[] = {0.0, -1.0, 1e-3, 1e-300, 1e308, INFINITY, -INFINITY, NAN};
    return below(4) ? below(1000) * 1e-3 - 0.5 : odd[below(8)];
}
static void answered(int status) {
    calls++;
    if (status < 0 || status > 3) { printf("status %d\n", status); abort(); }
    refused += status > 1;
}
static void no_nan(int status, const double *v, size_t n) {
    answered(status);
    for (size_t k = 0; status == 0 && k < n; k++)
        if (!isfinite(v[k])) { puts("a value that is not finite was given as one"); abort(); }
}

static void one(void *c, void **state, char *bytes, size_t *held, double *t, unsigned variables, int three) {
    unsigned r[MOST];
    double v[64], w[MOST], h = below(8) ? 1e-4 * (1 + below(30)) : number();
    int i[MOST];
    bool b[MOST], x, y, z;
    const char *s[MOST] = {0};
    size_t n = below(MOST), m = below(3) ? n : below(MOST), size = 0;
    unsigned *rp = below(30) ? r : NULL;
    double *vp = below(30) ? v : NULL;
    const unsigned first = below(variables + 4);
    for (size_t k = 0; k < MOST; k++) {
        r[k] = below(3) ? first + (unsigned)k : below(50) ? below(variables + 4) : 0xffffffffu - below(3);
        w[k] = number();
        i[k] = (int)below(5) - 1;
    }
    for (size_t k = 0; k < 64; k++) v[k] = below(6) ? 0.0 : number();
    switch (below(26)) {
    case 0: answered(three ? (int)fmi3EnterInitializationMode(c, 0, 0, below(8) ? 0.0 : number(), below(2), below(4) ? 10.0 : number())
                           : (int)fmi2SetupExperiment(c, 0, 0, below(8) ? 0.0 : number(), below(2), below(4) ? 10.0 : number())); break;
    case 1: answered(three ? (int)fmi3EnterInitializationMode(c, 0, 0, 0.0, 0, 0) : (int)fmi2EnterInitializationMode(c)); *t = 0.0; break;
    case 2: answered(three ? (int)fmi3ExitInitializationMode(c) : (int)fmi2ExitInitializationMode(c)); break;
    case 3: answered(three ? (int)fmi3Terminate(c) : (int)fmi2Terminate(c)); break;
    case 4: answered(three ? (int)fmi3Reset(c) : (int)fmi2Reset(c)); *t = 0.0; break;
    case 5: case 6: no_nan(three ? (int)fmi3GetFloat64(c, rp, n, vp, m) : (int)fmi2GetReal(c, rp, n, vp), v, three ? m : n); break;
    case 7: case 8: answered(three ? (int)fmi3SetFloat64(c, rp, n, vp, m) : (int)fmi2SetReal(c, rp, n, vp)); break;
    case 9: answered(three ? (int)fmi3GetInt32(c, rp, n, i, m) : (int)fmi2GetInteger(c, rp, n, i)); break;
    case 10: answered(three ? (int)fmi3SetInt32(c, rp, n, i, m) : (int)fmi2SetInteger(c, rp, n, i)); break;
    case 11: answered(three ? (int)fmi3GetBoolean(c, rp, n, b, m) : (int)fmi2GetBoolean(c, rp, n, i)); break;
    case 12: answered(three ? (int)fmi3SetBoolean(c, rp, n, b, m) : (int)fmi2SetBoolean(c, rp, n, i)); break;
    case 13: answered(three ? (int)fmi3GetString(c, rp, n, s, m) : (int)fmi2GetString(c, rp, n, s)); break;
    case 14: answered(three ? (int)fmi3SetString(c, rp, n, s, m) : (int)fmi2SetString(c, rp, n, s)); break;
    case 15: answered(three ? (int)fmi3GetFMUState(c, below(20) ? state : NULL) : (int)fmi2GetFMUstate(c, below(20) ? state : NULL)); break;
    case 16: answered(three ? (int)fmi3SetFMUState(c, *state) : (int)fmi2SetFMUstate(c, *state)); break;
    case 17: answered(three ? (int)fmi3FreeFMUState(c, state) : (int)fmi2FreeFMUstate(c, state)); break;
    case 18:
        answered(three ? (int)fmi3SerializedFMUStateSize(c, *state, &size) : (int)fmi2SerializedFMUstateSize(c, *state, &size));
        if (size > BUFFER) abort();
        if (below(5) == 0) size = below(100);
        if (!(three ? (int)fmi3SerializeFMUState(c, *state, (unsigned char *)bytes, size) : (int)fmi2SerializeFMUstate(c, *state, bytes, size)))
            *held = size;
        if (*held && !below(5)) bytes[below((unsigned)*held)] ^= 4;
        break;
    case 19: answered(three ? (int)fmi3DeserializeFMUState(c, below(20) ? (unsigned char *)bytes : NULL, *held, state)
                            : (int)fmi2DeSerializeFMUstate(c, below(20) ? bytes : NULL, *held, state)); break;
    case 20:
        no_nan(three ? (int)fmi3GetDirectionalDerivative(c, rp, n, r + MOST / 2, m / 2, w, m / 2, vp, n)
                     : (int)fmi2GetDirectionalDerivative(c, rp, n, r + MOST / 2, m / 2, w, vp), v, n); break;
    case 21: answered(three ? (int)fmi3GetOutputDerivatives(c, rp, n, i, vp, m) : (int)fmi2SetRealInputDerivatives(c, rp, n, i, w)); break;
    case 22: answered(three ? (int)fmi3EnterEventMode(c) : (int)fmi2GetRealStatus(c, (fmi2StatusKind)below(4), vp)); break;
    case 23: {
        const char *categories[] = {"logAll", below(2) ? "logStatusError" : "none of these", NULL};
        answered(three ? (int)fmi3SetDebugLogging(c, below(2), below(3), categories) : (int)fmi2SetDebugLogging(c, below(2), below(3), categories));
        break;
    }
    default: {
        const double at = below(10) ? *t : number();
        double last = 0.0;
        int status = three ? (int)fmi3DoStep(c, at, h, below(2), &x, &y, &z, below(20) ? &last : NULL) : (int)fmi2DoStep(c, at, h, below(2));
        answered(status);
        if (status == 0) *t = at + h;
    }
    }
}

int main(int argc, char **a) {
    static char bytes[2][BUFFER];
    size_t held[2] = {0};
    char *long_name = malloc(100000);
    if (argc < 5) return 2;
    const char *token = a[1];
    const unsigned variables = (unsigned)atoi(a[4]);
    memset(long_name, 'x', 99999); long_name[99999] = 0;
    for (long k = 0, sequences = atol(a[3]); k < sequences; k++) {
        void *c[2][SLOTS] = {{0}}, *state[2][2] = {{0}};
        double t[2][SLOTS] = {{0}};
        seed = 88172645463325252ull + 7919ull * (unsigned long long)(k + 1000003L * atol(a[2]));
        for (int q = 0; q < 8; q++) below(2);
        const unsigned length = 5 + below(60);
        for (unsigned q = 0; q < length; q++) {
            const int three = (int)below(2), slot = (int)below(SLOTS), at = (int)below(2);
            const char *name = below(20) ? "unit" : below(2) ? long_name : NULL, *given = below(20) ? token : below(2) ? "{}" : NULL;
            if (!c[three][slot]) {
                calls++;
                c[three][slot] = three ? fmi3InstantiateCoSimulation(name, given, NULL, 0, below(2), !below(20), 0, NULL, 0, NULL, below(10) ? logger3 : NULL, NULL)
                                       : fmi2Instantiate(name, below(20) ? fmi2CoSimulation : fmi2ModelExchange, given, NULL, below(20) ? below(10) ? &WITH : &WITHOUT : NULL, 0, below(2));
                t[three][slot] = 0.0;
                if (below(4)) { /* most get as far as steps */
                    answered(three ? (int)fmi3EnterInitializationMode(c[1][slot], 0, 0, 0.0, 0, 0) : (int)fmi2EnterInitializationMode(c[0][slot]));
                    answered(three ? (int)fmi3ExitInitializationMode(c[1][slot]) : (int)fmi2ExitInitializationMode(c[0][slot]));
                }
            } else if (!below(30)) {
                three ? fmi3FreeInstance(c[1][slot]) : fmi2FreeInstance(c[0][slot]);
                c[three][slot] = NULL;
            } else {
                one(below(40) ? c[three][slot] : NULL, &state[three][at], bytes[three], &held[three], &t[three][slot], variables, three);
            }
        }
        for (int three = 0; three < 2; three++) {
            for (int at = 0; at < 2; at++)
                if (state[three][at]) {
                    void *owner = three ? fmi3InstantiateCoSimulation("last", token, NULL, 0, 0, 0, 0, NULL, 0, NULL, NULL, NULL)
                                        : fmi2Instantiate("last", fmi2CoSimulation, token, NULL, &WITH, 0, 0);
                    answered(three ? (int)fmi3FreeFMUState(owner, &state[1][at]) : (int)fmi2FreeFMUstate(owner, &state[0][at]));
                    three ? fmi3FreeInstance(owner) : fmi2FreeInstance(owner);
                }
            for (int slot = 0; slot < SLOTS; slot++) three ? fmi3FreeInstance(c[1][slot]) : fmi2FreeInstance(c[0][slot]);
        }
    }
    free(long_name);
    printf("%ld calls, %ld refused, %ld messages\n", calls, refused, messages);
    return 0;
}
