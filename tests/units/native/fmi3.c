/* A co-simulation FMU of FMI 3.0 of the model in MODEL. It is strict: wrong modes, communication points that are not its
   own, wrong numbers of values and states taken back after they were given up are errors, which its log explains. */
#define FMI 3
#include "model.h"
#include "fmi3Functions.h"

enum { INSTANTIATED = 1, CONFIGURATION = 2, INITIALIZATION = 4, EVENT = 8, STEP = 16, INSIDE = 32, OVER = 64 };
typedef struct { Data data; int mode; double next; } State;
typedef struct {
    State now;
    bool event_mode, early_return;
    double given_up; /* states before this time will not come back */
    fmi3InstanceEnvironment environment;
    fmi3LogMessageCallback log;
    fmi3IntermediateUpdateCallback update;
    bool unwanted; /* an early return was asked for */
} Unit;

static fmi3Status complain(Unit *unit, const char *text) {
    unit->log(unit->environment, fmi3Error, "logStatusError", text);
    return fmi3Error;
}
#define ALLOWED(modes) \
    Unit *unit = instance; \
    if (!(unit->now.mode & (modes))) return complain(unit, "call of a function in a mode that does not allow it");

const char *fmi3GetVersion(void) { return "3.0"; }
fmi3Status fmi3SetDebugLogging(fmi3Instance i, fmi3Boolean on, size_t n, const fmi3String c[]) { return fmi3OK; }

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
        fmi3Boolean logging, fmi3Boolean event_mode, fmi3Boolean early_return, const fmi3ValueReference required[], size_t n,
        fmi3InstanceEnvironment environment, fmi3LogMessageCallback log, fmi3IntermediateUpdateCallback update) {
    if (strcmp(token, "{native}")) {
        log(environment, fmi3Error, "logStatusError", "wrong instantiation token");
        return NULL;
    }
    Unit *unit = calloc(1, sizeof *unit);
    *unit = (Unit){.now = {.mode = INSTANTIATED, .next = INFINITY}, .event_mode = event_mode, .early_return = early_return,
                   .environment = environment, .log = log, .update = update, .given_up = -INFINITY};
    begin(&unit->now.data, resources);
    return unit;
}
void fmi3FreeInstance(fmi3Instance instance) { free(instance); }

fmi3Status fmi3EnterConfigurationMode(fmi3Instance instance) {
    ALLOWED(INSTANTIATED) unit->now.mode = CONFIGURATION;
    return fmi3OK;
}
fmi3Status fmi3ExitConfigurationMode(fmi3Instance instance) {
    ALLOWED(CONFIGURATION) unit->now.mode = INSTANTIATED;
    return fmi3OK;
}
fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, fmi3Boolean d, fmi3Float64 tolerance, fmi3Float64 start,
                                       fmi3Boolean s, fmi3Float64 stop) {
    ALLOWED(INSTANTIATED) unit->now.mode = INITIALIZATION;
#ifdef RESETTING
    enter(&unit->now.data);
#endif
    *clock_of(&unit->now.data) = start;
#ifdef TOLD
    told(&unit->now.data, d, tolerance, start, s, stop);
#endif
#ifdef MOODY
    unit->now.data.tolerance = d ? tolerance : -1.0;
#endif
    return fmi3OK;
}
fmi3Status fmi3ExitInitializationMode(fmi3Instance instance) {
    ALLOWED(INITIALIZATION) unit->now.mode = unit->event_mode ? EVENT : STEP;
    return fmi3OK;
}
fmi3Status fmi3EnterEventMode(fmi3Instance instance) {
    ALLOWED(STEP) unit->now.mode = EVENT;
    return unit->event_mode ? fmi3OK : complain(unit, "event mode was not asked for");
}
fmi3Status fmi3EnterStepMode(fmi3Instance instance) {
    ALLOWED(EVENT) unit->now.mode = STEP;
    return fmi3OK;
}
fmi3Status fmi3Terminate(fmi3Instance instance) {
    ALLOWED(STEP | EVENT) unit->now.mode = OVER;
    return fmi3OK;
}
fmi3Status fmi3Reset(fmi3Instance instance) { return fmi3Error; }

static bool settable(Unit *unit, const Slot *s) {
    bool real = s->type == FLOAT64 || s->type == FLOAT32;
    if (s->when == 's' || unit->now.mode == CONFIGURATION) return s->when == 's' && unit->now.mode == CONFIGURATION;
    if (unit->now.mode == INSIDE) return s->when == 'i';
    return unit->now.mode != STEP || !unit->event_mode || (real && s->when != 'd');
}

#define ACCESS(Name, type, TYPE) \
fmi3Status fmi3Get##Name(fmi3Instance instance, const fmi3ValueReference references[], size_t n, type values[], \
                         size_t total) { \
    ALLOWED(INITIALIZATION | EVENT | STEP) \
    size_t done = 0; \
    outputs(&unit->now.data); \
    for (size_t i = 0; i < n; i++) { \
        const Slot *s = slot(references[i], TYPE); \
        if (!s || done + count(&unit->now.data, s) > total) return complain(unit, "no such " #Name); \
        memcpy(values + done, (char *)&unit->now.data + s->offset, count(&unit->now.data, s) * sizeof(type)); \
        done += count(&unit->now.data, s); \
    } \
    return done == total ? fmi3OK : complain(unit, "too many values of " #Name); \
} \
fmi3Status fmi3Set##Name(fmi3Instance instance, const fmi3ValueReference references[], size_t n, const type values[], \
                         size_t total) { \
    ALLOWED(INSTANTIATED | CONFIGURATION | INITIALIZATION | EVENT | STEP | INSIDE) \
    size_t done = 0; \
    for (size_t i = 0; i < n; i++) { \
        const Slot *s = slot(references[i], TYPE); \
        if (!s || !settable(unit, s) || done + count(&unit->now.data, s) > total) \
            return complain(unit, #Name " cannot be set now"); \
        memcpy((char *)&unit->now.data + s->offset, values + done, count(&unit->now.data, s) * sizeof(type)); \
        done += count(&unit->now.data, s); \
    } \
    return done == total ? fmi3OK : complain(unit, "too many values of " #Name); \
}
ACCESS(Float64, fmi3Float64, FLOAT64) ACCESS(Float32, fmi3Float32, FLOAT32) ACCESS(Int8, fmi3Int8, INT8)
ACCESS(UInt8, fmi3UInt8, UINT8) ACCESS(Int16, fmi3Int16, INT16) ACCESS(UInt16, fmi3UInt16, UINT16)
ACCESS(Int32, fmi3Int32, INT32) ACCESS(UInt32, fmi3UInt32, UINT32) ACCESS(Int64, fmi3Int64, INT64)
ACCESS(UInt64, fmi3UInt64, UINT64) ACCESS(Boolean, fmi3Boolean, BOOLEAN)

fmi3Status fmi3GetString(fmi3Instance instance, const fmi3ValueReference references[], size_t n, fmi3String values[],
                         size_t total) {
    ALLOWED(INITIALIZATION | EVENT | STEP) outputs(&unit->now.data);
    for (size_t i = 0; i < n; i++) {
        const Slot *s = slot(references[i], STRING);
        if (!s) return complain(unit, "no such String");
        values[i] = (char *)&unit->now.data + s->offset;
    }
    return fmi3OK;
}
fmi3Status fmi3SetString(fmi3Instance instance, const fmi3ValueReference references[], size_t n,
                         const fmi3String values[], size_t total) {
    ALLOWED(INSTANTIATED | INITIALIZATION | EVENT | STEP)
    for (size_t i = 0; i < n; i++) {
        const Slot *s = slot(references[i], STRING);
        if (!s || !settable(unit, s)) return complain(unit, "String cannot be set now");
        snprintf((char *)&unit->now.data + s->offset, TEXT, "%s", values[i]);
    }
    return fmi3OK;
}

fmi3Status fmi3GetBinary(fmi3Instance instance, const fmi3ValueReference references[], size_t n, size_t lengths[],
                         fmi3Binary values[], size_t total) {
    ALLOWED(INITIALIZATION | EVENT | STEP) outputs(&unit->now.data);
    for (size_t i = 0; i < n; i++) {
        const Slot *s = slot(references[i], BINARY);
        if (!s) return complain(unit, "no such Binary");
        Octets *octets = (Octets *)((char *)&unit->now.data + s->offset);
        lengths[i] = octets->length, values[i] = octets->octets;
    }
    return fmi3OK;
}
fmi3Status fmi3SetBinary(fmi3Instance instance, const fmi3ValueReference references[], size_t n, const size_t lengths[],
                         const fmi3Binary values[], size_t total) {
    ALLOWED(INSTANTIATED | INITIALIZATION | EVENT | STEP)
    for (size_t i = 0; i < n; i++) {
        const Slot *s = slot(references[i], BINARY);
        if (!s || !settable(unit, s) || lengths[i] > TEXT) return complain(unit, "Binary cannot be set now");
        Octets *octets = (Octets *)((char *)&unit->now.data + s->offset);
        octets->length = lengths[i], memcpy(octets->octets, values[i], lengths[i]);
    }
    return fmi3OK;
}

static Outcome settle_events(Unit *unit) {
    Outcome outcome = {0};
    event(&unit->now.data, &outcome);
    unit->now.next = outcome.announced ? outcome.next : INFINITY;
    return outcome;
}
fmi3Status fmi3UpdateDiscreteStates(fmi3Instance instance, fmi3Boolean *again, fmi3Boolean *ends, fmi3Boolean *nominals,
                                    fmi3Boolean *values, fmi3Boolean *announced, fmi3Float64 *next) {
    ALLOWED(EVENT)
    Outcome outcome = settle_events(unit);
    *again = outcome.again, *ends = outcome.ends, *nominals = false, *values = true;
    *announced = outcome.announced, *next = outcome.next;
    return fmi3OK;
}

static void request(Data *d, double t) {
    Unit *unit = (Unit *)d; /* its first member */
    bool early = true;
    double when = 0.0;
    if (!unit->update) return;
    unit->now.mode = INSIDE;
    unit->update(unit->environment, t, true, false, false, true, &early, &when);
    unit->now.mode = STEP;
    unit->unwanted |= early;
}

fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 t, fmi3Float64 h, fmi3Boolean forget, fmi3Boolean *event_needed,
                      fmi3Boolean *ends, fmi3Boolean *early, fmi3Float64 *reached) {
    ALLOWED(STEP)
    double *clock = clock_of(&unit->now.data), end = t + h;
    *event_needed = *ends = *early = false;
    if (fabs(t - *clock) > 1e-15 * fmax(1.0, t)) return complain(unit, "not the present communication point");
    if (!(h > 0.0)) return complain(unit, "a step must have a length");
    if (forget) unit->given_up = t;
#ifdef MOODY
    if (unit->now.data.discard_at > t && unit->now.data.discard_at <= end) {
        *reached = *clock = unit->now.data.discard_at;
        return fmi3Discard;
    }
    *ends = unit->now.data.end_at <= end;
    if (*ends && unit->event_mode && unit->early_return) { /* without event mode it completes its step */
        *early = unit->now.data.end_at < end;
        *reached = *clock = unit->now.data.end_at;
        return fmi3OK;
    }
#endif
#ifdef TOLD
    if (h > unit->now.data.longest) {
        *reached = t;
        return fmi3Discard;
    }
    char text[80];
    snprintf(text, sizeof text, "step %d: the table was left at %g s", unit->now.data.steps + 1, t);
    for (int k = 0; k < unit->now.data.chatty; k++) unit->log(unit->environment, fmi3Warning, "w", text);
#endif
    for (bool due = true; due && *clock < end;) {
        due = advance(&unit->now.data, end);
        if (due && unit->event_mode) *event_needed = true;
        if (due && !unit->event_mode) *ends |= settle_events(unit).ends;
        if (due && (unit->event_mode || unit->early_return) && *clock < end) *early = true;
        if (due && unit->event_mode && !unit->early_return) return complain(unit, "an event inside the step");
        if (*early) break;
    }
    *reached = *clock;
#ifdef TOLD
    if (unit->now.data.chatty) return fmi3Warning;
#endif
    return unit->unwanted ? complain(unit, "nobody should ask for an early return") : fmi3OK;
}

fmi3Status fmi3GetDirectionalDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[], size_t nu,
        const fmi3ValueReference knowns[], size_t nk, const fmi3Float64 seed[], size_t ns, fmi3Float64 result[], size_t nr) {
    ALLOWED(INITIALIZATION | EVENT | STEP)
    return along(&unit->now.data, unknowns, nu, knowns, nk, seed, result) ? fmi3OK : complain(unit, "no such derivative");
}

fmi3Status fmi3GetFMUState(fmi3Instance instance, fmi3FMUState *state) {
    Unit *unit = instance;
    if (!*state) *state = malloc(sizeof(State));
    memcpy(*state, &unit->now, sizeof(State));
    return fmi3OK;
}
fmi3Status fmi3SetFMUState(fmi3Instance instance, fmi3FMUState state) {
    Unit *unit = instance;
    if (*clock_of(&((State *)state)->data) < unit->given_up) return complain(unit, "a state that was given up");
    memcpy(&unit->now, state, sizeof(State));
    return fmi3OK;
}
fmi3Status fmi3FreeFMUState(fmi3Instance instance, fmi3FMUState *state) {
    free(*state), *state = NULL;
    return fmi3OK;
}
fmi3Status fmi3SerializedFMUStateSize(fmi3Instance instance, fmi3FMUState state, size_t *size) {
    *size = sizeof(State);
    return fmi3OK;
}
fmi3Status fmi3SerializeFMUState(fmi3Instance instance, fmi3FMUState state, fmi3Byte bytes[], size_t size) {
    memcpy(bytes, state, size);
    return fmi3OK;
}
fmi3Status fmi3DeserializeFMUState(fmi3Instance instance, const fmi3Byte bytes[], size_t size, fmi3FMUState *state) {
    fmi3GetFMUState(instance, state);
    memcpy(*state, bytes, size);
    return fmi3OK;
}
