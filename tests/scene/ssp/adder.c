/* An FMI 2.0 co-simulation FMU: x' = u, y = gain u + count + 100 flag + 1000 mode + 10000 letters in the text. */
#include <stdlib.h>
#include <string.h>

typedef struct { double u, x, y, gain; int count, mode, flag; size_t letters; char *text; } Unit;
enum { OK, ERROR = 3 };
#define API __attribute__((visibility("default")))
#define ABSENT(name) API int name(void) { return ERROR; }
#define FINE(name) API int name(void *c) { (void)c; return OK; }

API const char *fmi2GetTypesPlatform(void) { return "default"; }
API const char *fmi2GetVersion(void) { return "2.0"; }
API int fmi2SetDebugLogging(void *c, int on, size_t n, const char **categories) { return OK; }
API void *fmi2Instantiate(const char *name, int type, const char *guid, const char *place, const void *callbacks, int v, int l) {
    Unit *unit = calloc(1, sizeof(Unit));
    unit->gain = 1.0, unit->text = strdup("");
    return unit;
}
API void fmi2FreeInstance(void *c) { free(((Unit *)c)->text); free(c); }
API int fmi2SetupExperiment(void *c, int a, double tolerance, double start, int b, double stop) { return OK; }
FINE(fmi2EnterInitializationMode) FINE(fmi2ExitInitializationMode) FINE(fmi2Terminate) FINE(fmi2Reset)
API int fmi2GetReal(Unit *c, const unsigned *vr, size_t n, double *value) {
    c->y = c->gain * c->u + c->count + 100.0 * c->flag + 1000.0 * c->mode + 1e4 * c->letters;
    for (size_t i = 0; i < n; i++) value[i] = (&c->u)[vr[i]];
    return OK;
}
API int fmi2SetReal(Unit *c, const unsigned *vr, size_t n, const double *value) {
    for (size_t i = 0; i < n; i++) (&c->u)[vr[i]] = value[i];
    return OK;
}
API int fmi2SetInteger(Unit *c, const unsigned *vr, size_t n, const int *value) {
    for (size_t i = 0; i < n; i++) (&c->count)[vr[i]] = value[i];
    return OK;
}
API int fmi2SetBoolean(Unit *c, const unsigned *vr, size_t n, const int *value) { c->flag = value[0]; return OK; }
API int fmi2SetString(Unit *c, const unsigned *vr, size_t n, const char *const *value) {
    free(c->text);
    c->text = strdup(value[0]), c->letters = strlen(value[0]);
    return OK;
}
API int fmi2DoStep(Unit *c, double t, double h, int no_rollback) { c->x += h * c->u; return OK; }
API int fmi2GetInteger(Unit *c, const unsigned *vr, size_t n, int *value) {
    for (size_t i = 0; i < n; i++) value[i] = (&c->count)[vr[i]];
    return OK;
}
API int fmi2GetBoolean(Unit *c, const unsigned *vr, size_t n, int *value) {
    for (size_t i = 0; i < n; i++) value[i] = c->flag;
    return OK;
}
API int fmi2GetString(Unit *c, const unsigned *vr, size_t n, const char **value) {
    for (size_t i = 0; i < n; i++) value[i] = c->text;
    return OK;
}
ABSENT(fmi2SetRealInputDerivatives)
ABSENT(fmi2GetFMUstate) ABSENT(fmi2SetFMUstate) ABSENT(fmi2FreeFMUstate) ABSENT(fmi2SerializedFMUstateSize)
ABSENT(fmi2SerializeFMUstate) ABSENT(fmi2DeSerializeFMUstate) ABSENT(fmi2GetDirectionalDerivative)
ABSENT(fmi2GetRealOutputDerivatives) ABSENT(fmi2CancelStep) ABSENT(fmi2GetStatus) ABSENT(fmi2GetRealStatus)
ABSENT(fmi2GetIntegerStatus) ABSENT(fmi2GetBooleanStatus) ABSENT(fmi2GetStringStatus)
