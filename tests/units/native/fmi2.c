/* A co-simulation FMU of FMI 2.0 of the model in MODEL. It is strict: wrong modes, communication points that are not its
   own and states taken back after they were given up are errors, which its log explains. */
#define FMI 2
#include "model.h"
#include "fmi2Functions.h"

enum { INSTANTIATED = 1, INITIALIZATION = 2, STEP = 4, FAILED = 8, OVER = 16 };
typedef struct { Data data; int mode; } State;
typedef struct {
    State now;
    double given_up; /* states before this time will not come back */
    bool ends;
    int looks; /* at a step that goes on in the background */
    const fmi2CallbackFunctions *callbacks;
} Unit;

static fmi2Status complain(Unit *unit, const char *text) {
    unit->callbacks->logger(unit->callbacks->componentEnvironment, "", fmi2Error, "logStatusError", "%s", text);
    return fmi2Error;
}
#define ALLOWED(modes) \
    Unit *unit = instance; \
    if (!(unit->now.mode & (modes))) return complain(unit, "call of a function in a mode that does not allow it");

const char *fmi2GetTypesPlatform(void) { return "default"; }
const char *fmi2GetVersion(void) { return "2.0"; }
fmi2Status fmi2SetDebugLogging(fmi2Component i, fmi2Boolean on, size_t n, const fmi2String c[]) { return fmi2OK; }

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String token, fmi2String resources,
                              const fmi2CallbackFunctions *callbacks, fmi2Boolean visible, fmi2Boolean logging) {
    if (strcmp(token, "{native}") || type != fmi2CoSimulation) {
        callbacks->logger(callbacks->componentEnvironment, name, fmi2Error, "logStatusError", "wrong instantiation token");
        return NULL;
    }
    Unit *unit = calloc(1, sizeof *unit);
    *unit = (Unit){.now = {.mode = INSTANTIATED}, .callbacks = callbacks, .given_up = -INFINITY};
    begin(&unit->now.data, resources);
    return unit;
}
void fmi2FreeInstance(fmi2Component instance) { free(instance); }

fmi2Status fmi2SetupExperiment(fmi2Component instance, fmi2Boolean d, fmi2Real tolerance, fmi2Real start, fmi2Boolean s,
                               fmi2Real stop) {
    ALLOWED(INSTANTIATED)
#ifdef RESETTING
    set_up(&unit->now.data);
#endif
    *clock_of(&unit->now.data) = start;
#ifdef MOODY
    unit->now.data.tolerance = d ? tolerance : -1.0;
#endif
#ifdef TOLD
    told(&unit->now.data, d, tolerance, start, s, stop);
#endif
    return fmi2OK;
}
fmi2Status fmi2EnterInitializationMode(fmi2Component instance) {
    ALLOWED(INSTANTIATED) unit->now.mode = INITIALIZATION;
#ifdef RESETTING
    enter(&unit->now.data);
#endif
    return fmi2OK;
}
fmi2Status fmi2ExitInitializationMode(fmi2Component instance) {
    ALLOWED(INITIALIZATION) unit->now.mode = STEP;
    return fmi2OK;
}
fmi2Status fmi2Terminate(fmi2Component instance) {
    ALLOWED(STEP | FAILED) unit->now.mode = OVER;
    return fmi2OK;
}
fmi2Status fmi2Reset(fmi2Component instance) { return fmi2Error; }

#define ACCESS(Name, type, TYPE) \
fmi2Status fmi2Get##Name(fmi2Component instance, const fmi2ValueReference references[], size_t n, type values[]) { \
    ALLOWED(INITIALIZATION | STEP | FAILED) outputs(&unit->now.data); \
    for (size_t i = 0; i < n; i++) { \
        const Slot *s = slot(references[i], TYPE); \
        if (!s) return complain(unit, "no such " #Name); \
        values[i] = *(type *)((char *)&unit->now.data + s->offset); \
    } \
    return fmi2OK; \
} \
fmi2Status fmi2Set##Name(fmi2Component instance, const fmi2ValueReference references[], size_t n, const type values[]) { \
    ALLOWED(INSTANTIATED | INITIALIZATION | STEP) \
    for (size_t i = 0; i < n; i++) { \
        const Slot *s = slot(references[i], TYPE); \
        if (!s) return complain(unit, "no such " #Name); \
        *(type *)((char *)&unit->now.data + s->offset) = values[i]; \
    } \
    return fmi2OK; \
}
ACCESS(Real, fmi2Real, FLOAT64) ACCESS(Integer, fmi2Integer, INT32) ACCESS(Boolean, fmi2Boolean, BOOLEAN)

fmi2Status fmi2GetString(fmi2Component instance, const fmi2ValueReference references[], size_t n, fmi2String values[]) {
    ALLOWED(INITIALIZATION | STEP | FAILED) outputs(&unit->now.data);
    for (size_t i = 0; i < n; i++) {
        const Slot *s = slot(references[i], STRING);
        if (!s) return complain(unit, "no such String");
        values[i] = (char *)&unit->now.data + s->offset;
    }
    return fmi2OK;
}
fmi2Status fmi2SetString(fmi2Component instance, const fmi2ValueReference references[], size_t n, const fmi2String values[]) {
    ALLOWED(INSTANTIATED | INITIALIZATION | STEP)
    for (size_t i = 0; i < n; i++) {
        const Slot *s = slot(references[i], STRING);
        if (!s) return complain(unit, "no such String");
        snprintf((char *)&unit->now.data + s->offset, TEXT, "%s", values[i]);
    }
    return fmi2OK;
}

static void request(Data *d, double t) { (void)d, (void)t; }

fmi2Status fmi2DoStep(fmi2Component instance, fmi2Real t, fmi2Real h, fmi2Boolean forget) {
    ALLOWED(STEP)
    double *clock = clock_of(&unit->now.data), end = t + h;
    Outcome outcome = {0};
    if (fabs(t - *clock) > 1e-15 * fmax(1.0, t)) return complain(unit, "not the present communication point");
    if (!(h > 0.0)) return complain(unit, "a step must have a length");
    if (forget) unit->given_up = t;
#ifdef MOODY
    unit->ends = unit->now.data.end_at <= end;
    if (unit->ends || (unit->now.data.discard_at > t && unit->now.data.discard_at <= end)) {
        *clock = unit->ends ? unit->now.data.end_at : unit->now.data.discard_at;
        unit->now.mode = FAILED;
        return fmi2Discard;
    }
#endif
#ifdef TOLD
    if (h > unit->now.data.longest) {
        if (unit->now.data.strict) unit->now.data.steps = 1000, unit->now.mode = FAILED;
        return fmi2Discard;
    }
    const char *name = "told", *text = "step %d: the table was left at %g s";
    for (int k = 0; k < unit->now.data.chatty; k++)
        unit->callbacks->logger(unit->callbacks->componentEnvironment, name, fmi2Warning, "w", text, unit->now.data.steps + 1, t);
#endif
    for (bool due = true; due && (due = advance(&unit->now.data, end));)
        do event(&unit->now.data, &outcome); while (outcome.again);
#ifdef MOODY
    if (unit->now.data.pause > 0.0) {
        unit->looks = 3;
        return fmi2Pending;
    }
#endif
#ifdef TOLD
    if (unit->now.data.chatty) return fmi2Warning;
#endif
    return fmi2OK;
}
fmi2Status fmi2GetStatus(fmi2Component instance, const fmi2StatusKind kind, fmi2Status *value) {
    Unit *unit = instance;
    *value = unit->looks-- > 0 ? fmi2Pending : fmi2OK;
    return fmi2OK;
}
fmi2Status fmi2GetRealStatus(fmi2Component instance, const fmi2StatusKind kind, fmi2Real *value) {
    Unit *unit = instance;
#ifdef TOLD
    if (unit->now.data.strict) return fmi2Discard;
#endif
    if (kind == fmi2LastSuccessfulTime) *value = *clock_of(&unit->now.data);
    return kind == fmi2LastSuccessfulTime ? fmi2OK : fmi2Discard;
}
fmi2Status fmi2GetBooleanStatus(fmi2Component instance, const fmi2StatusKind kind, fmi2Boolean *value) {
    Unit *unit = instance;
    if (kind == fmi2Terminated) *value = unit->ends;
    return kind == fmi2Terminated ? fmi2OK : fmi2Discard;
}

fmi2Status fmi2GetDirectionalDerivative(fmi2Component instance, const fmi2ValueReference unknowns[], size_t nu,
        const fmi2ValueReference knowns[], size_t nk, const fmi2Real seed[], fmi2Real result[]) {
    ALLOWED(INITIALIZATION | STEP)
    return along(&unit->now.data, unknowns, nu, knowns, nk, seed, result) ? fmi2OK : complain(unit, "no such derivative");
}

fmi2Status fmi2GetFMUstate(fmi2Component instance, fmi2FMUstate *state) {
    Unit *unit = instance;
    if (!*state) *state = malloc(sizeof(State));
    memcpy(*state, &unit->now, sizeof(State));
    return fmi2OK;
}
fmi2Status fmi2SetFMUstate(fmi2Component instance, fmi2FMUstate state) {
    Unit *unit = instance;
    if (*clock_of(&((State *)state)->data) < unit->given_up) return complain(unit, "a state that was given up");
    memcpy(&unit->now, state, sizeof(State));
    return fmi2OK;
}
fmi2Status fmi2FreeFMUstate(fmi2Component instance, fmi2FMUstate *state) {
    free(*state), *state = NULL;
    return fmi2OK;
}
fmi2Status fmi2SerializedFMUstateSize(fmi2Component instance, fmi2FMUstate state, size_t *size) {
    *size = sizeof(State);
    return fmi2OK;
}
fmi2Status fmi2SerializeFMUstate(fmi2Component instance, fmi2FMUstate state, fmi2Byte bytes[], size_t size) {
    memcpy(bytes, state, size);
    return fmi2OK;
}
fmi2Status fmi2DeSerializeFMUstate(fmi2Component instance, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state) {
    fmi2GetFMUstate(instance, state);
    memcpy(*state, bytes, size);
    return fmi2OK;
}
fmi2Status fmi2SetRealInputDerivatives(fmi2Component instance, const fmi2ValueReference r[], size_t n, const fmi2Integer o[],
                                       const fmi2Real v[]) {
    return complain(instance, "no interpolation of inputs");
}
