/* FMI 3.0.2 for co-simulation on top of native.c. What an FMU without clocks, events, structural parameters and continuous states
   does not offer is there for hosts that look all functions up, and refuses. */
#include "fmi3.h"
#include "native.h"

#define C fmi3Instance c
#define REFERENCES const fmi3ValueReference r[], size_t n
#define CALL(name, ...) EXPORT fmi3Status fmi3##name(__VA_ARGS__)
#define UNUSED(x) (void)(x)

static void log3_(const Instance *m, int status, const char *category, const char *text) {
    ((fmi3LogMessageCallback)m->callback)(m->environment, (fmi3Status)status, category, text);
}
static void *refused_instance(fmi3InstanceEnvironment environment, fmi3LogMessageCallback log, const char *why) {
    Instance host = {0};
    host.log = log ? log3_ : NULL;
    host.callback = (void *)log;
    host.environment = environment;
    report(&host, ERROR, "instantiate: %s", why);
    return NULL;
}

EXPORT const char *fmi3GetVersion(void) { return "3.0"; }
CALL(SetDebugLogging, C, fmi3Boolean on, size_t n, const fmi3String categories[]) { return (fmi3Status)set_logging(c, on, n, categories); }
EXPORT fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                                fmi3Boolean logging, fmi3Boolean events, fmi3Boolean early,
                                                const fmi3ValueReference intermediate[], size_t n, fmi3InstanceEnvironment environment,
                                                fmi3LogMessageCallback log, fmi3IntermediateUpdateCallback update) {
    UNUSED(resources), UNUSED(visible), UNUSED(early), UNUSED(intermediate), UNUSED(update);
    if (events) return refused_instance(environment, log, "this FMU has no event mode");
    if (n) return refused_instance(environment, log, "this FMU has no intermediate variables");
    return create(name, token, logging, 1, log3_, environment, (void *)log);
}
EXPORT fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                                 fmi3Boolean logging, fmi3InstanceEnvironment environment, fmi3LogMessageCallback log) {
    UNUSED(name), UNUSED(token), UNUSED(resources), UNUSED(visible), UNUSED(logging);
    return refused_instance(environment, log, "this FMU is one for co-simulation");
}
EXPORT fmi3Instance fmi3InstantiateScheduledExecution(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                                      fmi3Boolean logging, fmi3InstanceEnvironment environment,
                                                      fmi3LogMessageCallback log, fmi3ClockUpdateCallback clock,
                                                      fmi3LockPreemptionCallback lock, fmi3UnlockPreemptionCallback unlock) {
    UNUSED(name), UNUSED(token), UNUSED(resources), UNUSED(visible), UNUSED(logging), UNUSED(clock), UNUSED(lock), UNUSED(unlock);
    return refused_instance(environment, log, "this FMU is one for co-simulation");
}
EXPORT void fmi3FreeInstance(C) { discard_instance(c); }
CALL(EnterInitializationMode, C, fmi3Boolean has_tolerance, fmi3Float64 tolerance, fmi3Float64 start, fmi3Boolean has_stop,
     fmi3Float64 stop) {
    UNUSED(has_tolerance), UNUSED(tolerance);
    if (!allowed(c, INSTANTIATED, "fmi3EnterInitializationMode") || setup(c, start, has_stop, stop)) return fmi3Error;
    return (fmi3Status)enter_initialization(c);
}
CALL(ExitInitializationMode, C) { return (fmi3Status)exit_initialization(c); }
CALL(Terminate, C) { return (fmi3Status)terminate(c); }
CALL(Reset, C) { return (fmi3Status)reset(c); }

#define ACCESS(name, type)                                                                                                       \
    CALL(Get##name, C, REFERENCES, fmi3##name v[], size_t nv) { return (fmi3Status)get_values(c, type, r, n, v, nv); }           \
    CALL(Set##name, C, REFERENCES, const fmi3##name v[], size_t nv) { return (fmi3Status)set_values(c, type, r, n, v, nv); }
ACCESS(Float64, REAL)
ACCESS(Int32, INTEGER)
ACCESS(Boolean, BOOLEAN)
ACCESS(String, STRING)
static fmi3Status none(C, size_t n, const char *type) {
    return c && !n ? fmi3OK : (fmi3Status)report(c, ERROR, "this FMU has no variables of the type %s", type);
}
#define NONE(name)                                                                                                               \
    CALL(Get##name, C, REFERENCES, fmi3##name v[], size_t nv) { UNUSED(r), UNUSED(v), UNUSED(nv); return none(c, n, #name); }    \
    CALL(Set##name, C, REFERENCES, const fmi3##name v[], size_t nv) { UNUSED(r), UNUSED(v), UNUSED(nv); return none(c, n, #name); }
NONE(Float32)
NONE(Int8)
NONE(UInt8)
NONE(Int16)
NONE(UInt16)
NONE(UInt32)
NONE(Int64)
NONE(UInt64)
CALL(GetBinary, C, REFERENCES, size_t sizes[], fmi3Binary v[], size_t nv) {
    UNUSED(r), UNUSED(sizes), UNUSED(v), UNUSED(nv);
    return none(c, n, "Binary");
}
CALL(SetBinary, C, REFERENCES, const size_t sizes[], const fmi3Binary v[], size_t nv) {
    UNUSED(r), UNUSED(sizes), UNUSED(v), UNUSED(nv);
    return none(c, n, "Binary");
}
CALL(GetClock, C, REFERENCES, fmi3Clock v[]) { UNUSED(r), UNUSED(v); return none(c, n, "Clock"); }
CALL(SetClock, C, REFERENCES, const fmi3Clock v[]) { UNUSED(r), UNUSED(v); return none(c, n, "Clock"); }

CALL(GetFMUState, C, fmi3FMUState *s) { return (fmi3Status)get_state(c, s); }
CALL(SetFMUState, C, fmi3FMUState s) { return (fmi3Status)set_state(c, s); }
CALL(FreeFMUState, C, fmi3FMUState *s) { return (fmi3Status)free_state(c, s); }
CALL(SerializedFMUStateSize, C, fmi3FMUState s, size_t *n) { return (fmi3Status)state_size(c, s, n); }
CALL(SerializeFMUState, C, fmi3FMUState s, fmi3Byte b[], size_t n) { return (fmi3Status)serialize(c, s, b, n); }
CALL(DeserializeFMUState, C, const fmi3Byte b[], size_t n, fmi3FMUState *s) { return (fmi3Status)deserialize(c, b, n, s); }
CALL(GetDirectionalDerivative, C, const fmi3ValueReference z[], size_t nz, const fmi3ValueReference v[], size_t nv,
     const fmi3Float64 seed[], size_t ns, fmi3Float64 result[], size_t nr) {
    return (fmi3Status)directional(c, z, nz, v, nv, seed, ns, result, nr);
}
CALL(DoStep, C, fmi3Float64 t, fmi3Float64 h, fmi3Boolean final, fmi3Boolean *event, fmi3Boolean *end, fmi3Boolean *early,
     fmi3Float64 *last) {
    fmi3Status status;
    UNUSED(final);
    if (c && (!event || !end || !early || !last)) return (fmi3Status)report(c, ERROR, "fmi3DoStep: null pointer");
    status = (fmi3Status)do_step(c, t, h);
    if (!c) return status;
    *event = *early = false;
    *end = ((Instance *)c)->discarded;
    *last = ((Instance *)c)->t;
    return status;
}

/* ---- not offered ---- */
#define NO(name, ...) CALL(name, __VA_ARGS__) { return (fmi3Status)refuse(c, "fmi3" #name); }
#define NO1(name, T) CALL(name, C, T a) { UNUSED(a); return (fmi3Status)refuse(c, "fmi3" #name); }
#define NO2(name, T, U) CALL(name, C, T a, U b) { UNUSED(a), UNUSED(b); return (fmi3Status)refuse(c, "fmi3" #name); }
#define NO3(name, T, U, V) CALL(name, C, T a, U b, V d) { UNUSED(a), UNUSED(b), UNUSED(d); return (fmi3Status)refuse(c, "fmi3" #name); }
NO(EnterEventMode, C)
NO(EnterConfigurationMode, C)
NO(ExitConfigurationMode, C)
NO(EvaluateDiscreteStates, C)
NO(EnterStepMode, C)
NO(EnterContinuousTimeMode, C)
NO1(SetTime, fmi3Float64)
NO1(GetNumberOfEventIndicators, size_t *)
NO1(GetNumberOfContinuousStates, size_t *)
NO2(GetNumberOfVariableDependencies, fmi3ValueReference, size_t *)
NO2(ActivateModelPartition, fmi3ValueReference, fmi3Float64)
#define ARRAY(name, T) CALL(name, C, T v[], size_t n) { UNUSED(v), UNUSED(n); return (fmi3Status)refuse(c, "fmi3" #name); }
ARRAY(SetContinuousStates, const fmi3Float64)
ARRAY(GetContinuousStateDerivatives, fmi3Float64)
ARRAY(GetEventIndicators, fmi3Float64)
ARRAY(GetContinuousStates, fmi3Float64)
ARRAY(GetNominalsOfContinuousStates, fmi3Float64)
NO3(CompletedIntegratorStep, fmi3Boolean, fmi3Boolean *, fmi3Boolean *)
#define NOREF(name, ...) CALL(name, C, REFERENCES, __VA_ARGS__) { UNUSED(r), UNUSED(n), UNUSED(a)
#define END(name) ; return (fmi3Status)refuse(c, "fmi3" #name); }
NOREF(GetIntervalDecimal, fmi3Float64 a[], fmi3IntervalQualifier b[]), UNUSED(b) END(GetIntervalDecimal)
NOREF(GetIntervalFraction, fmi3UInt64 a[], fmi3UInt64 b[], fmi3IntervalQualifier d[]), UNUSED(b), UNUSED(d) END(GetIntervalFraction)
NOREF(GetShiftDecimal, fmi3Float64 a[]) END(GetShiftDecimal)
NOREF(GetShiftFraction, fmi3UInt64 a[], fmi3UInt64 b[]), UNUSED(b) END(GetShiftFraction)
NOREF(SetIntervalDecimal, const fmi3Float64 a[]) END(SetIntervalDecimal)
NOREF(SetIntervalFraction, const fmi3UInt64 a[], const fmi3UInt64 b[]), UNUSED(b) END(SetIntervalFraction)
NOREF(SetShiftDecimal, const fmi3Float64 a[]) END(SetShiftDecimal)
NOREF(SetShiftFraction, const fmi3UInt64 a[], const fmi3UInt64 b[]), UNUSED(b) END(SetShiftFraction)
NOREF(GetOutputDerivatives, const fmi3Int32 a[], fmi3Float64 b[], size_t d), UNUSED(b), UNUSED(d) END(GetOutputDerivatives)
CALL(GetVariableDependencies, C, fmi3ValueReference z, size_t a[], fmi3ValueReference r[], size_t b[], fmi3DependencyKind d[], size_t n) {
    UNUSED(z), UNUSED(a), UNUSED(r), UNUSED(b), UNUSED(d), UNUSED(n);
    return (fmi3Status)refuse(c, "fmi3GetVariableDependencies");
}
CALL(GetAdjointDerivative, C, const fmi3ValueReference z[], size_t nz, const fmi3ValueReference v[], size_t nv, const fmi3Float64 seed[],
     size_t ns, fmi3Float64 result[], size_t nr) {
    UNUSED(z), UNUSED(nz), UNUSED(v), UNUSED(nv), UNUSED(seed), UNUSED(ns), UNUSED(result), UNUSED(nr);
    return (fmi3Status)refuse(c, "fmi3GetAdjointDerivative");
}
CALL(UpdateDiscreteStates, C, fmi3Boolean *a, fmi3Boolean *b, fmi3Boolean *d, fmi3Boolean *e, fmi3Boolean *f, fmi3Float64 *t) {
    UNUSED(a), UNUSED(b), UNUSED(d), UNUSED(e), UNUSED(f), UNUSED(t);
    return (fmi3Status)refuse(c, "fmi3UpdateDiscreteStates");
}
