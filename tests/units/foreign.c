/* An FMI 2.0 co-simulation FMU by "another maker": x' = u, z' = x, y = x + sign u.
   Exact for inputs with derivatives up to the second; discards steps that take x above the limit, or are too long, of which it
   tells where it is. */
#include <stddef.h>
#include <stdlib.h>

typedef struct {
    void (*logger)(void *, const char *, int, const char *, const char *, ...);
    void *allocate, *release, *finished, *environment;
} Callbacks;
typedef struct { double u, x, z, y, limit, longest; int sign, told; double du[3], t; const Callbacks *callbacks; } Unit;
enum { OK, WARNING, DISCARD, ERROR };
#define API __attribute__((visibility("default")))
#define ABSENT(name) API int name(void) { return ERROR; }
#define FINE(name) API int name(void *c) { (void)c; return OK; }

API const char *fmi2GetTypesPlatform(void) { return "default"; }
API const char *fmi2GetVersion(void) { return "2.0"; }
API int fmi2SetDebugLogging(void *c, int on, size_t n, const char **categories) { return OK; }
API void *fmi2Instantiate(const char *name, int type, const char *guid, const char *place, const Callbacks *callbacks, int v, int l) {
    Unit *unit = calloc(1, sizeof(Unit));
    unit->limit = unit->longest = 1e9, unit->sign = 1, unit->callbacks = callbacks;
    return unit;
}
API void fmi2FreeInstance(void *c) { free(c); }
API int fmi2SetupExperiment(void *c, int a, double tolerance, double start, int b, double stop) { return OK; }
FINE(fmi2EnterInitializationMode) FINE(fmi2ExitInitializationMode) FINE(fmi2Terminate) FINE(fmi2Reset)
API int fmi2GetReal(Unit *c, const unsigned *vr, size_t n, double *value) {
    c->y = c->x + c->sign * c->u;
    for (size_t i = 0; i < n; i++) value[i] = (&c->u)[vr[i]];
    return OK;
}
API int fmi2SetReal(Unit *c, const unsigned *vr, size_t n, const double *value) {
    for (size_t i = 0; i < n; i++) (&c->u)[vr[i]] = value[i];
    return OK;
}
API int fmi2SetInteger(Unit *c, const unsigned *vr, size_t n, const int *value) { c->sign = *value; return OK; }
API int fmi2GetInteger(Unit *c, const unsigned *vr, size_t n, int *value) { *value = c->sign; return OK; }
API int fmi2SetRealInputDerivatives(Unit *c, const unsigned *vr, size_t n, const int *order, const double *value) {
    for (size_t i = 0; i < n; i++) c->du[order[i]] = value[i];
    return OK;
}
API int fmi2GetRealStatus(Unit *c, int kind, double *value) { *value = c->t; return c->told && kind == 2 ? OK : ERROR; }
API int fmi2DoStep(Unit *c, double t, double h, int no_rollback) {
    c->t = t;
    if ((c->told = h > c->longest)) return DISCARD;
    double x = c->x + h * (c->u + h * (c->du[1] / 2 + h * c->du[2] / 6));
    if (x > c->limit) {
        c->callbacks->logger(c->callbacks->environment, "", DISCARD, "", "x = %.3f is above the limit", x);
        return DISCARD;
    }
    c->z += h * (c->x + h * (c->u / 2 + h * (c->du[1] / 6 + h * c->du[2] / 24)));
    c->x = x;
    c->u += h * (c->du[1] + h * c->du[2] / 2);
    c->du[1] = c->du[2] = 0;
    return OK;
}
ABSENT(fmi2GetBoolean) ABSENT(fmi2GetString) ABSENT(fmi2SetBoolean) ABSENT(fmi2SetString)
ABSENT(fmi2GetFMUstate) ABSENT(fmi2SetFMUstate) ABSENT(fmi2FreeFMUstate) ABSENT(fmi2SerializedFMUstateSize)
ABSENT(fmi2SerializeFMUstate) ABSENT(fmi2DeSerializeFMUstate) ABSENT(fmi2GetDirectionalDerivative)
ABSENT(fmi2GetRealOutputDerivatives) ABSENT(fmi2CancelStep) ABSENT(fmi2GetStatus)
ABSENT(fmi2GetIntegerStatus) ABSENT(fmi2GetBooleanStatus) ABSENT(fmi2GetStringStatus)
