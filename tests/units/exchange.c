/* An FMU of FMI 2.0 for model exchange: x' = -k x + u (or - u where `reversed`), a ball that bounces and lies
   when it leaves slower than `rest` (or, with mu > 0, Van der Pol's oscillator in h and v), a counter of time
   events, a counter of u's passages through 0.5, and events of completed steps that put x back to 0. With BARE: no states.
   It is strict: a call in a wrong mode and a state taken back after it was given up are errors, which its log explains. */
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "fmi2Functions.h"

enum { INSTANTIATED = 1, INITIALIZATION = 2, EVENT = 4, CONTINUOUS = 8, OVER = 16 };
enum { U, X, K, H, V, E, Y, PERIOD, SAW, LIMIT, END, CRASH, MU, REST, REALS }; /* references of reals */
enum { BOUNCES, TICKS, PASSAGES, RESETS, REVERSED, WHOLES };               /* of integers; the last is a boolean */
typedef struct { double t, r[REALS], dx[3], next; int i[WHOLES], above, mode, lies; double completed; } State;
typedef struct { State now; double given_up; const fmi2CallbackFunctions *callbacks; } Unit;

#define ALLOWED(modes) \
    Unit *unit = c; State *s = &unit->now; (void)s; \
    if (!(s->mode & (modes))) return complain(unit, "call of a function in a mode that does not allow it");
#ifdef BARE
enum { NX = 0, NZ = 1 };
#else
enum { NX = 3, NZ = 2 };
#endif

static fmi2Status complain(Unit *unit, const char *text) {
    unit->callbacks->logger(unit->callbacks->componentEnvironment, "", fmi2Error, "logStatusError", "%s", text);
    return fmi2Error;
}
const char *fmi2GetTypesPlatform(void) { return "default"; }
const char *fmi2GetVersion(void) { return "2.0"; }
fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String k[]) { return fmi2OK; }
fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String token, fmi2String place,
                              const fmi2CallbackFunctions *callbacks, fmi2Boolean visible, fmi2Boolean logging) {
    if (strcmp(token, "{exchange}") || type != fmi2ModelExchange) return NULL;
    Unit *unit = calloc(1, sizeof *unit);
    double *r = unit->now.r;
    r[K] = 1.0, r[H] = 1.0, r[E] = 0.7, r[PERIOD] = 1e9, r[SAW] = r[LIMIT] = r[END] = r[CRASH] = 1e9;
    unit->now.mode = INSTANTIATED, unit->given_up = -INFINITY, unit->callbacks = callbacks;
    return unit;
}
void fmi2FreeInstance(fmi2Component c) { free(c); }
fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean d, fmi2Real tolerance, fmi2Real t, fmi2Boolean e, fmi2Real stop) {
    ALLOWED(INSTANTIATED) s->t = t;
    if (!d) return complain(unit, "no tolerance");
    return fmi2OK;
}
fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
    ALLOWED(INSTANTIATED) s->mode = INITIALIZATION, s->r[H] = s->r[MU] > 0.0 ? 2.0 : 1.0;
    return fmi2OK;
}
fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    ALLOWED(INITIALIZATION) s->mode = EVENT, s->next = s->r[PERIOD], s->above = s->r[U] > 0.5;
    return fmi2OK;
}
fmi2Status fmi2Terminate(fmi2Component c) { ALLOWED(EVENT | CONTINUOUS) s->mode = OVER; return fmi2OK; }
fmi2Status fmi2Reset(fmi2Component c) { return fmi2Error; }
fmi2Status fmi2EnterEventMode(fmi2Component c) { ALLOWED(CONTINUOUS) s->mode = EVENT; return fmi2OK; }
fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c) {
    ALLOWED(EVENT) s->mode = CONTINUOUS, s->completed = s->t;
    return fmi2OK;
}

fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *info) {
    ALLOWED(EVENT)
    double *r = s->r;
    int changed = 0;
    if (r[MU] == 0.0 && r[H] <= 0.0 && r[V] < 0.0) {
        r[H] = 1e-300, r[V] *= -r[E], s->i[BOUNCES]++, changed = 1;
        if (r[V] < r[REST]) r[V] = 0.0, s->lies = 1;
    }
    if (s->t >= s->next) s->i[TICKS]++, s->next += r[PERIOD];
    if (r[K] < 0.0) changed = 1; /* never at rest */
    if (s->above != (r[U] > 0.5)) s->above = !s->above, s->i[PASSAGES]++;
    if (r[X] > r[SAW]) r[X] = 0.0, s->i[RESETS]++, changed = 1;
    *info = (fmi2EventInfo){changed, s->t >= r[END], fmi2False, changed, s->next < 1e8, s->next};
    return fmi2OK;
}
fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean forget, fmi2Boolean *event, fmi2Boolean *ends) {
    ALLOWED(CONTINUOUS)
    if (s->t < s->completed) return complain(unit, "a completed step that ends before the last one");
    s->completed = s->t;
    if (s->t >= s->r[CRASH]) {
        printf("printed before the end\n");
        complain(unit, "logged before the end");
        *(volatile int *)0 = 0;
    }
    if (forget) unit->given_up = s->t;
    *event = s->r[X] > s->r[SAW], *ends = s->t >= s->r[END];
    return fmi2OK;
}
fmi2Status fmi2SetTime(fmi2Component c, fmi2Real t) { ALLOWED(EVENT | CONTINUOUS) s->t = t; return fmi2OK; }
static const int states[] = {X, H, V};
fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t n) {
    ALLOWED(CONTINUOUS)
    if (n != NX) return complain(unit, "another number of states");
    for (size_t i = 0; i < n; i++) s->r[states[i]] = x[i];
    return fmi2OK;
}
fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t n) {
    ALLOWED(EVENT | CONTINUOUS)
    for (size_t i = 0; i < n; i++) x[i] = s->r[states[i]];
    return fmi2OK;
}
fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real x[], size_t n) {
    ALLOWED(EVENT | CONTINUOUS)
    for (size_t i = 0; i < n; i++) x[i] = 1.0;
    return fmi2OK;
}
fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real dx[], size_t n) {
    ALLOWED(EVENT | CONTINUOUS)
    if (s->r[X] > s->r[LIMIT]) return fmi2Discard;
    if (n) dx[0] = -s->r[K] * s->r[X] + (s->i[REVERSED] ? -s->r[U] : s->r[U]), dx[1] = s->r[V],
        dx[2] = s->r[MU] > 0.0 ? s->r[MU] * (1.0 - s->r[H] * s->r[H]) * s->r[V] - s->r[H] : s->lies ? 0.0 : -9.81;
    return fmi2OK;
}
fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real z[], size_t n) {
    ALLOWED(EVENT | CONTINUOUS | INITIALIZATION)
    if (n != NZ) return complain(unit, "another number of event indicators");
    z[0] = s->r[U] - 0.5;
    if (n > 1) z[1] = s->r[MU] > 0.0 ? 1.0 : s->r[H];
    return fmi2OK;
}
fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference v[], size_t n, fmi2Real value[]) {
    ALLOWED(INITIALIZATION | EVENT | CONTINUOUS) s->r[Y] = s->r[X] + s->r[U];
    for (size_t i = 0; i < n; i++) value[i] = s->r[v[i]];
    return fmi2OK;
}
fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference v[], size_t n, const fmi2Real value[]) {
    ALLOWED(INSTANTIATED | INITIALIZATION | EVENT | CONTINUOUS)
    for (size_t i = 0; i < n; i++) {
        if (v[i] != U && s->mode != INSTANTIATED) return complain(unit, "a parameter set too late");
        s->r[v[i]] = value[i];
    }
    return fmi2OK;
}
fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference v[], size_t n, fmi2Integer value[]) {
    ALLOWED(INITIALIZATION | EVENT | CONTINUOUS)
    for (size_t i = 0; i < n; i++) value[i] = s->i[v[i]];
    return fmi2OK;
}
fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference v[], size_t n, fmi2Boolean value[]) {
    return fmi2GetInteger(c, v, n, value);
}
fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference v[], size_t n, const fmi2Boolean value[]) {
    ALLOWED(INSTANTIATED | INITIALIZATION | EVENT)
    for (size_t i = 0; i < n; i++) s->i[v[i]] = value[i];
    return fmi2OK;
}
fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference z[], size_t nz, const fmi2ValueReference v[],
                                        size_t nv, const fmi2Real dv[], fmi2Real dz[]) {
    ALLOWED(INITIALIZATION | EVENT | CONTINUOUS)
    for (size_t i = 0; i < nz; i++) dz[i] = z[i] == Y && v[0] == U ? dv[0] : 0.0;
    return fmi2OK;
}
fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state) {
    if (!*state) *state = malloc(sizeof(State));
    memcpy(*state, &((Unit *)c)->now, sizeof(State));
    return fmi2OK;
}
fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) {
    Unit *unit = c;
    if (((State *)state)->t < unit->given_up) return complain(unit, "a state that was given up");
    memcpy(&unit->now, state, sizeof(State));
    return fmi2OK;
}
fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state) { free(*state), *state = NULL; return fmi2OK; }
fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *n) { *n = sizeof(State); return fmi2OK; }
fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte b[], size_t n) { memcpy(b, state, n); return fmi2OK; }
fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte b[], size_t n, fmi2FMUstate *state) {
    fmi2GetFMUstate(c, state);
    memcpy(*state, b, n);
    return fmi2OK;
}
fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference v[], size_t n, const fmi2Integer k[]) { return fmi2Error; }
fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference v[], size_t n, fmi2String k[]) { return fmi2Error; }
fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference v[], size_t n, const fmi2String k[]) { return fmi2Error; }
