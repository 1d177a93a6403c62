/* FMI 2.0.4 for co-simulation on top of native.c. Functions of model exchange are there for hosts that look all of them up. */
#include "fmi2.h"
#include "native.h"
#include <string.h>

#define C fmi2Component c
#define REFERENCES const fmi2ValueReference r[], size_t n
#define CALL(name, ...) EXPORT fmi2Status fmi2##name(__VA_ARGS__)
#define UNUSED(x) (void)(x)

/* A message is the host's format: a sign of percent is written twice. */
static void log2_(const Instance *m, int status, const char *category, const char *text) {
    char format[2048];
    size_t k = 0;
    for (; *text && k + 3 < sizeof format; text++) {
        if (*text == '%') format[k++] = '%';
        format[k++] = *text;
    }
    format[k] = 0;
    ((fmi2CallbackLogger)m->callback)(m->environment, m->name, (fmi2Status)status, category, format);
}

EXPORT const char *fmi2GetTypesPlatform(void) { return "default"; }
EXPORT const char *fmi2GetVersion(void) { return "2.0"; }
CALL(SetDebugLogging, C, fmi2Boolean on, size_t n, const fmi2String categories[]) { return (fmi2Status)set_logging(c, on, n, categories); }
EXPORT fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                                     const fmi2CallbackFunctions *functions, fmi2Boolean visible, fmi2Boolean logging) {
    UNUSED(resources), UNUSED(visible);
    Instance host = {0};
    if (!functions) return NULL;
    if (type != fmi2CoSimulation) {
        host.log = functions->logger ? log2_ : NULL;
        host.callback = (void *)functions->logger;
        host.environment = functions->componentEnvironment;
        report(&host, ERROR, "fmi2Instantiate: this FMU is one for co-simulation");
        return NULL;
    }
    return create(name, guid, logging, 0, log2_, functions->componentEnvironment, (void *)functions->logger);
}
EXPORT void fmi2FreeInstance(C) { discard_instance(c); }
CALL(SetupExperiment, C, fmi2Boolean has_tolerance, fmi2Real tolerance, fmi2Real start, fmi2Boolean has_stop, fmi2Real stop) {
    UNUSED(has_tolerance), UNUSED(tolerance);
    return allowed(c, INSTANTIATED, "fmi2SetupExperiment") ? (fmi2Status)setup(c, start, has_stop, stop) : fmi2Error;
}
CALL(EnterInitializationMode, C) {
    return allowed(c, INSTANTIATED, "fmi2EnterInitializationMode") ? (fmi2Status)enter_initialization(c) : fmi2Error;
}
CALL(ExitInitializationMode, C) { return (fmi2Status)exit_initialization(c); }
CALL(Terminate, C) { return (fmi2Status)terminate(c); }
CALL(Reset, C) { return (fmi2Status)reset(c); }

CALL(GetReal, C, REFERENCES, fmi2Real v[]) { return (fmi2Status)get_values(c, REAL, r, n, v, n); }
CALL(GetInteger, C, REFERENCES, fmi2Integer v[]) { return (fmi2Status)get_values(c, INTEGER, r, n, v, n); }
CALL(GetBoolean, C, REFERENCES, fmi2Boolean v[]) { return (fmi2Status)get_values(c, BOOLEAN, r, n, v, n); }
CALL(GetString, C, REFERENCES, fmi2String v[]) { return (fmi2Status)get_values(c, STRING, r, n, v, n); }
CALL(SetReal, C, REFERENCES, const fmi2Real v[]) { return (fmi2Status)set_values(c, REAL, r, n, v, n); }
CALL(SetInteger, C, REFERENCES, const fmi2Integer v[]) { return (fmi2Status)set_values(c, INTEGER, r, n, v, n); }
CALL(SetBoolean, C, REFERENCES, const fmi2Boolean v[]) { return (fmi2Status)set_values(c, BOOLEAN, r, n, v, n); }
CALL(SetString, C, REFERENCES, const fmi2String v[]) { return (fmi2Status)set_values(c, STRING, r, n, v, n); }

CALL(GetFMUstate, C, fmi2FMUstate *s) { return (fmi2Status)get_state(c, s); }
CALL(SetFMUstate, C, fmi2FMUstate s) { return (fmi2Status)set_state(c, s); }
CALL(FreeFMUstate, C, fmi2FMUstate *s) { return (fmi2Status)free_state(c, s); }
CALL(SerializedFMUstateSize, C, fmi2FMUstate s, size_t *n) { return (fmi2Status)state_size(c, s, n); }
CALL(SerializeFMUstate, C, fmi2FMUstate s, fmi2Byte b[], size_t n) { return (fmi2Status)serialize(c, s, b, n); }
CALL(DeSerializeFMUstate, C, const fmi2Byte b[], size_t n, fmi2FMUstate *s) { return (fmi2Status)deserialize(c, b, n, s); }
CALL(GetDirectionalDerivative, C, const fmi2ValueReference z[], size_t nz, const fmi2ValueReference v[], size_t nv, const fmi2Real dv[],
     fmi2Real dz[]) {
    return (fmi2Status)directional(c, z, nz, v, nv, dv, nv, dz, nz);
}

CALL(SetRealInputDerivatives, C, REFERENCES, const fmi2Integer order[], const fmi2Real v[]) { return (fmi2Status)set_slopes(c, r, n, order, v); }
CALL(GetRealOutputDerivatives, C, REFERENCES, const fmi2Integer order[], fmi2Real v[]) {
    UNUSED(r), UNUSED(n), UNUSED(order), UNUSED(v);
    return (fmi2Status)refuse(c, "fmi2GetRealOutputDerivatives");
}
CALL(DoStep, C, fmi2Real t, fmi2Real h, fmi2Boolean final) {
    UNUSED(final);
    return (fmi2Status)do_step(c, t, h);
}
CALL(CancelStep, C) { return (fmi2Status)report(c, ERROR, "fmi2CancelStep: no step is under way"); }
CALL(GetStatus, C, const fmi2StatusKind kind, fmi2Status *value) {
    UNUSED(kind), UNUSED(value);
    return c ? (fmi2Status)report(c, DISCARD, "fmi2GetStatus: no step is ever pending") : fmi2Error;
}
CALL(GetRealStatus, C, const fmi2StatusKind kind, fmi2Real *value) {
    if (!c) return fmi2Error;
    if (!value || kind != fmi2LastSuccessfulTime) return (fmi2Status)report(c, DISCARD, "fmi2GetRealStatus: only fmi2LastSuccessfulTime");
    *value = ((Instance *)c)->t;
    return fmi2OK;
}
CALL(GetIntegerStatus, C, const fmi2StatusKind kind, fmi2Integer *value) {
    UNUSED(kind), UNUSED(value);
    return c ? (fmi2Status)report(c, DISCARD, "fmi2GetIntegerStatus: there is none") : fmi2Error;
}
CALL(GetBooleanStatus, C, const fmi2StatusKind kind, fmi2Boolean *value) {
    if (!c) return fmi2Error;
    if (!value || kind != fmi2Terminated) return (fmi2Status)report(c, DISCARD, "fmi2GetBooleanStatus: only fmi2Terminated");
    *value = ((Instance *)c)->discarded; /* else FMPy would try the same step for ever */
    return fmi2OK;
}
CALL(GetStringStatus, C, const fmi2StatusKind kind, fmi2String *value) {
    UNUSED(kind), UNUSED(value);
    return c ? (fmi2Status)report(c, DISCARD, "fmi2GetStringStatus: no step is ever pending") : fmi2Error;
}

/* ---- model exchange ---- */
CALL(EnterEventMode, C) { return (fmi2Status)refuse(c, "fmi2EnterEventMode"); }
CALL(NewDiscreteStates, C, fmi2EventInfo *info) { UNUSED(info); return (fmi2Status)refuse(c, "fmi2NewDiscreteStates"); }
CALL(EnterContinuousTimeMode, C) { return (fmi2Status)refuse(c, "fmi2EnterContinuousTimeMode"); }
CALL(CompletedIntegratorStep, C, fmi2Boolean a, fmi2Boolean *b, fmi2Boolean *d) {
    UNUSED(a), UNUSED(b), UNUSED(d);
    return (fmi2Status)refuse(c, "fmi2CompletedIntegratorStep");
}
CALL(SetTime, C, fmi2Real t) { UNUSED(t); return (fmi2Status)refuse(c, "fmi2SetTime"); }
#define ARRAY(name, T) CALL(name, C, T v[], size_t n) { UNUSED(v), UNUSED(n); return (fmi2Status)refuse(c, "fmi2" #name); }
ARRAY(SetContinuousStates, const fmi2Real)
ARRAY(GetDerivatives, fmi2Real)
ARRAY(GetEventIndicators, fmi2Real)
ARRAY(GetContinuousStates, fmi2Real)
ARRAY(GetNominalsOfContinuousStates, fmi2Real)
