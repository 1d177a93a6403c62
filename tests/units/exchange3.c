/* The FMU of exchange.c as one of FMI 3.0: the same equations, modes and complaints behind the functions of that version. */
#include "exchange.c"
#include "fmi3Functions.h"

typedef struct { Unit *unit; fmi2CallbackFunctions callbacks; fmi3LogMessageCallback log; fmi3InstanceEnvironment environment; } Unit3;
#define UNIT(c) (((Unit3 *)(c))->unit)
#define STATUS(call) ((fmi3Status)(call))

static void logged(fmi2ComponentEnvironment e, fmi2String name, fmi2Status status, fmi2String category, fmi2String form, ...) {
    va_list rest;
    va_start(rest, form);
    Unit3 *unit = e;
    unit->log(unit->environment, (fmi3Status)status, category, va_arg(rest, const char *));
    va_end(rest);
}
const char *fmi3GetVersion(void) { return "3.0"; }
fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String place, fmi3Boolean visible,
                                          fmi3Boolean logging, fmi3InstanceEnvironment e, fmi3LogMessageCallback log) {
    Unit3 *unit = calloc(1, sizeof *unit);
    unit->callbacks.logger = logged, unit->callbacks.componentEnvironment = unit, unit->log = log, unit->environment = e;
    unit->unit = fmi2Instantiate(name, fmi2ModelExchange, token, place, &unit->callbacks, 0, 0);
    return unit->unit ? unit : NULL;
}
void fmi3FreeInstance(fmi3Instance c) { free(UNIT(c)), free(c); }
fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean d, fmi3Float64 tolerance, fmi3Float64 t, fmi3Boolean e,
                                       fmi3Float64 stop) {
    fmi2Status status = fmi2SetupExperiment(UNIT(c), d, tolerance, t, e, stop);
    return STATUS(status ? status : fmi2EnterInitializationMode(UNIT(c)));
}
#define PASSED(name) fmi3Status fmi3##name(fmi3Instance c) { return STATUS(fmi2##name(UNIT(c))); }
PASSED(ExitInitializationMode) PASSED(EnterEventMode) PASSED(EnterContinuousTimeMode) PASSED(Terminate) PASSED(Reset)
fmi3Status fmi3UpdateDiscreteStates(fmi3Instance c, fmi3Boolean *again, fmi3Boolean *ends, fmi3Boolean *nominals,
                                    fmi3Boolean *states, fmi3Boolean *defined, fmi3Float64 *next) {
    fmi2EventInfo i;
    fmi2Status status = fmi2NewDiscreteStates(UNIT(c), &i);
    *again = i.newDiscreteStatesNeeded, *ends = i.terminateSimulation, *nominals = i.nominalsOfContinuousStatesChanged;
    *states = i.valuesOfContinuousStatesChanged, *defined = i.nextEventTimeDefined, *next = i.nextEventTime;
    return STATUS(status);
}
fmi3Status fmi3CompletedIntegratorStep(fmi3Instance c, fmi3Boolean forget, fmi3Boolean *event, fmi3Boolean *ends) {
    fmi2Boolean both[2] = {0, 0};
    fmi2Status status = fmi2CompletedIntegratorStep(UNIT(c), forget, &both[0], &both[1]);
    *event = both[0], *ends = both[1];
    return STATUS(status);
}
fmi3Status fmi3SetTime(fmi3Instance c, fmi3Float64 t) { return STATUS(fmi2SetTime(UNIT(c), t)); }
fmi3Status fmi3SetContinuousStates(fmi3Instance c, const fmi3Float64 x[], size_t n) {
    return STATUS(fmi2SetContinuousStates(UNIT(c), x, n));
}
#define GIVEN(name, name2) fmi3Status fmi3Get##name(fmi3Instance c, fmi3Float64 x[], size_t n) \
    { return STATUS(fmi2Get##name2(UNIT(c), x, n)); }
GIVEN(ContinuousStates, ContinuousStates) GIVEN(NominalsOfContinuousStates, NominalsOfContinuousStates)
GIVEN(ContinuousStateDerivatives, Derivatives) GIVEN(EventIndicators, EventIndicators)
fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance c, size_t *n) { *n = NX; return fmi3OK; }
fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance c, size_t *n) { *n = NZ; return fmi3OK; }

/* values: wholes have references of their own here, 50 and more, as all variables of an FMU of FMI 3 */
enum { WHOLE = 50, MOST = 32 };
fmi3Status fmi3GetFloat64(fmi3Instance c, const fmi3ValueReference v[], size_t n, fmi3Float64 x[], size_t m) {
    return n == m ? STATUS(fmi2GetReal(UNIT(c), v, n, x)) : fmi3Error;
}
fmi3Status fmi3SetFloat64(fmi3Instance c, const fmi3ValueReference v[], size_t n, const fmi3Float64 x[], size_t m) {
    return n == m ? STATUS(fmi2SetReal(UNIT(c), v, n, x)) : fmi3Error;
}
fmi3Status fmi3GetFloat32(fmi3Instance c, const fmi3ValueReference v[], size_t n, fmi3Float32 x[], size_t m) {
    double value = 0.0;
    fmi2ValueReference u = U;
    fmi2Status status = fmi2GetReal(UNIT(c), &u, 1, &value);
    *x = value;
    return STATUS(status);
}
fmi3Status fmi3SetFloat32(fmi3Instance c, const fmi3ValueReference v[], size_t n, const fmi3Float32 x[], size_t m) {
    double value = *x;
    fmi2ValueReference u = U;
    return STATUS(fmi2SetReal(UNIT(c), &u, 1, &value));
}
fmi3Status fmi3GetInt32(fmi3Instance c, const fmi3ValueReference v[], size_t n, fmi3Int32 k[], size_t m) {
    fmi2ValueReference of[MOST];
    for (size_t i = 0; i < n; i++) of[i] = v[i] - WHOLE;
    return STATUS(fmi2GetInteger(UNIT(c), of, n, k));
}
fmi3Status fmi3GetBoolean(fmi3Instance c, const fmi3ValueReference v[], size_t n, fmi3Boolean k[], size_t m) {
    fmi3Int32 value;
    fmi3Status status = fmi3GetInt32(c, v, 1, &value, 1);
    *k = value;
    return status;
}
fmi3Status fmi3SetBoolean(fmi3Instance c, const fmi3ValueReference v[], size_t n, const fmi3Boolean k[], size_t m) {
    fmi2ValueReference of = *v - WHOLE;
    fmi2Boolean value = *k;
    return STATUS(fmi2SetBoolean(UNIT(c), &of, 1, &value));
}
fmi3Status fmi3GetDirectionalDerivative(fmi3Instance c, const fmi3ValueReference z[], size_t nz, const fmi3ValueReference v[],
                                        size_t nv, const fmi3Float64 dv[], size_t n, fmi3Float64 dz[], size_t m) {
    return STATUS(fmi2GetDirectionalDerivative(UNIT(c), z, nz, v, nv, dv, dz));
}
fmi3Status fmi3GetFMUState(fmi3Instance c, fmi3FMUState *state) { return STATUS(fmi2GetFMUstate(UNIT(c), state)); }
fmi3Status fmi3SetFMUState(fmi3Instance c, fmi3FMUState state) { return STATUS(fmi2SetFMUstate(UNIT(c), state)); }
fmi3Status fmi3FreeFMUState(fmi3Instance c, fmi3FMUState *state) { return STATUS(fmi2FreeFMUstate(UNIT(c), state)); }
fmi3Status fmi3SerializedFMUStateSize(fmi3Instance c, fmi3FMUState state, size_t *n) { *n = sizeof(State); return fmi3OK; }
fmi3Status fmi3SerializeFMUState(fmi3Instance c, fmi3FMUState state, fmi3Byte b[], size_t n) { memcpy(b, state, n); return fmi3OK; }
fmi3Status fmi3DeserializeFMUState(fmi3Instance c, const fmi3Byte b[], size_t n, fmi3FMUState *state) {
    return STATUS(fmi2DeSerializeFMUstate(UNIT(c), (const char *)b, n, state));
}
