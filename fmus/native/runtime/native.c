/* The runtime of native FMUs: life cycle, values, steps, states and derivatives of one instance, whatever version of FMI asks.

   An instance is one piece of memory: its head, and the block that the model's entries work on. Nothing else is kept, so that
   instances share nothing that changes. Each function checks what it gets, and answers with a status and a message. */
#include "native.h"
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define ADDRESS(m) ((int64_t)(intptr_t)(m)->block)
enum { LINE = 64 }; /* bytes of a line of the cache */
static const char *const CATEGORY[] = {"logAll", "logStatusWarning", "logStatusDiscard", "logStatusError"};
static const char *const PHASE[] = {"before initialization", "initialization mode", "step mode", "after a failure", "terminated",
                                    "after a discarded step"};

#if defined(__x86_64__)
#include <cpuid.h>

int32_t model_wide; /* whether the processor and the system have AVX: then the entries take their wide form */
__attribute__((constructor)) static void look(void) {
    unsigned a, b, c, d, enabled = 0, high;
    if (!__get_cpuid(1, &a, &b, &c, &d) || !(c & bit_OSXSAVE) || !(c & bit_AVX)) return;
    __asm__("xgetbv" : "=a"(enabled), "=d"(high) : "c"(0));
    model_wide = (enabled & 6) == 6;
}
#endif

int report(const Instance *m, int status, const char *format, ...) {
    char text[1024];
    va_list values;
    if (!m || !m->log || (status == OK && !m->logging)) return status;
    va_start(values, format);
    vsnprintf(text, sizeof text, format, values);
    va_end(values);
    m->log(m, status, CATEGORY[status], text);
    return status;
}

int allowed(const Instance *m, uint32_t phases, const char *call) {
    int k = 0;
    if (!m) return 0;
    if (m->phase & phases) return 1;
    while (k < 5 && !(m->phase >> k & 1)) k++;
    report(m, ERROR, "%s is not allowed %s%s", call, k == 1 || k == 2 ? "in " : k == 4 ? "when " : "", PHASE[k]);
    return 0;
}

int refuse(const Instance *m, const char *call) { return report(m, ERROR, "%s is not offered by this FMU", call); }

void begin_cells(void *cells, uint32_t first, uint32_t end) {
    const uint64_t *values = model_values;
    memset((uint64_t *)cells + first, 0, 8 * (size_t)(end - first));
    for (uint32_t k = 0; k < model_run_count; values += model_runs[k++].count) {
        const uint32_t from = model_runs[k].first, a = from > first ? from : first;
        const uint32_t to = from + model_runs[k].count, b = to < end ? to : end;
        if (a < b) memcpy((uint64_t *)cells + a, values + (a - from), 8 * (size_t)(b - a));
    }
}
/* The block of the build; inputs and parameters are kept unless the instance begins anew. */
static void fill(Instance *m, int anew) {
    uint32_t k = 0;
    for (uint32_t i = 0; i <= model_given_count; i++) {
        const uint32_t end = anew || i == model_given_count ? model_cells : model_given[i][0];
        if (k < end) begin_cells(m->block, k, end);
        if (anew) break;
        if (i < model_given_count) k = model_given[i][1];
    }
    model_place(ADDRESS(m));
    m->stale = 1;
    m->initialized = 0;
}
static int32_t initialize(Instance *m, double t) {
    fill(m, 0);
    m->initialized = 1;
    m->block[0] = t;
    return model_initialize(t, ADDRESS(m));
}

Instance *create(const char *name, const char *token, int logging, int fmi3, Logger log, void *environment, void *callback) {
    Instance probe = {0}, *m;
    probe.log = callback ? log : NULL;
    probe.environment = environment;
    probe.callback = callback;
    probe.fmi3 = fmi3;
    probe.logging = logging;
    for (size_t k = 0; name && k + 1 < sizeof probe.name && name[k]; k++) probe.name[k] = name[k];
    if (!probe.name[0]) return report(&probe, ERROR, "instantiate: no name of the instance"), NULL;
    if (!token || strcmp(token, model_token))
        return report(&probe, ERROR, "instantiate: the %s is not %s, that of this library; modelDescription.xml belongs to another build",
                      fmi3 ? "instantiationToken" : "GUID", model_token), NULL;
    m = malloc(sizeof *m + LINE + 8 * ((size_t)model_cells + model_variable_count));
    if (!m) return report(&probe, ERROR, "instantiate: no memory"), NULL;
    *m = probe;
    m->block = (double *)(((uintptr_t)(m + 1) + LINE - 1) / LINE * LINE);
    m->kept = m->block + model_cells;
    m->phase = INSTANTIATED;
    m->stop = INFINITY;
    fill(m, 1);
    return m;
}

void discard_instance(void *m) { free(m); }

/* ---- the run ---- */
static const char *reason(const Instance *m, int32_t status, char text[700]) {
    for (uint32_t k = 0; k < model_reason_count; k++) {
        const uint32_t *at = model_reasons[k].cells;
        if (model_reasons[k].status != status) continue;
        snprintf(text, 700, model_reasons[k].text, m->block[at[0]], m->block[at[1]], m->block[at[2]], m->block[at[3]]);
        return text;
    }
    return "an error inside a kernel";
}
static const char *not_finite(const Instance *m) {
    for (uint32_t k = 0; k < model_variable_count; k++)
        if (model_variables[k].role == OUTPUT && !isfinite(m->block[model_variables[k].cell])) return model_variables[k].name;
    return NULL;
}
/* Keep the outputs before a step, or have them again as they were. */
static void swap_outputs(Instance *m, int keep) {
    for (uint32_t k = 0; k < model_variable_count; k++) {
        double *cell = m->block + model_variables[k].cell;
        if (model_variables[k].role != OUTPUT) continue;
        if (keep) m->kept[k] = *cell;
        else *cell = m->kept[k];
    }
}
/* Outputs that belong to the present inputs; before the run the initial state, too. */
static int freshen(Instance *m) {
    int32_t status = 0;
    const char *bad;
    char text[700];
    if (!m->stale) return OK;
    if (m->phase == INITIALIZATION) status = initialize(m, m->t = m->start);
    if (!status) status = model_outputs(m->t, ADDRESS(m));
    if (status) {
        m->phase = FAILED;
        return report(m, ERROR, "at t = %.9g s: %s", m->t, reason(m, status, text));
    }
    if ((bad = not_finite(m))) {
        m->phase = FAILED;
        return report(m, ERROR, "at t = %.9g s: output %s is not finite", m->t, bad);
    }
    m->stale = 0;
    return OK;
}
int setup(Instance *m, double start, int has_stop, double stop) {
    if (!isfinite(start)) return report(m, ERROR, "start time %g", start);
    if (has_stop && !(stop >= start)) return report(m, ERROR, "stop time %g before the start at %g", stop, start);
    m->start = m->t = start;
    m->stop = has_stop ? stop : INFINITY;
    return OK;
}
int enter_initialization(Instance *m) {
    m->phase = INITIALIZATION;
    m->stale = 1;
    return OK;
}
int exit_initialization(Instance *m) {
    if (!allowed(m, INITIALIZATION, "ExitInitializationMode") || freshen(m)) return ERROR;
    m->phase = STEPPING;
    return OK;
}
int terminate(Instance *m) {
    if (!allowed(m, STEPPING | FAILED | DISCARDED, "Terminate")) return ERROR;
    m->phase = TERMINATED;
    return OK;
}
int reset(Instance *m) {
    if (!m) return ERROR;
    fill(m, 1);
    m->phase = INSTANTIATED;
    m->discarded = 0;
    m->t = m->start = 0.0;
    m->stop = INFINITY;
    return OK;
}
int do_step(Instance *m, double t, double h) {
    int32_t status;
    const char *bad;
    char text[700];
    if (!allowed(m, STEPPING, "DoStep")) return ERROR;
    if (!(h > 0.0 && h < INFINITY)) return report(m, ERROR, "DoStep: step size %g, expected more than 0", h);
    if (!(fabs(t - m->t) <= 1e-6 * h + rounding_at(m->t)))
        return report(m, ERROR, "DoStep: from t = %.17g s, but this instance is at %.17g s; restore a state to go back", t, m->t);
    if (t + h > m->stop + 1e-6 * h + rounding_at(m->stop))
        return report(m, ERROR, "DoStep: to %.17g s, beyond the stop time %.17g s", t + h, m->stop);
    swap_outputs(m, 1);
    m->discarded = 0;
    m->block[0] = t;
    status = model_step(t, h, ADDRESS(m));
    bad = status ? NULL : not_finite(m);
    if (status || bad) {
        m->discarded = 1;
        if (!status || status != model_untouched) { /* the last results stay readable; a state can be restored */
            swap_outputs(m, 0);
            m->phase = DISCARDED;
        }
        m->block[0] = m->t;
        return bad ? report(m, DISCARD, "step from t = %.9g s discarded: output %s is not finite", t, bad)
                   : report(m, DISCARD, "step from t = %.9g s discarded: %s", t, reason(m, status, text));
    }
    m->block[0] = m->t = t + h;
    m->stale = 0;
    return OK;
}
int set_logging(Instance *m, int on, size_t n, const char *const *categories) {
    if (!m) return ERROR;
    if (n && !categories) return report(m, ERROR, "SetDebugLogging: null pointer");
    for (size_t i = 0; i < n; i++) {
        int k = 0;
        while (k < 4 && categories[i] && strcmp(categories[i], CATEGORY[k])) k++;
        if (k == 4 || !categories[i]) return report(m, ERROR, "SetDebugLogging: category %u is none of this FMU", (unsigned)i);
    }
    m->logging = on;
    return OK;
}

/* ---- values ---- */
static const Variable *variable(const Instance *m, uint32_t reference, int type, const char *call) {
    static const char *const TYPE[] = {"Real", "Integer", "Boolean", "String"};
    const uint32_t count = model_variable_count + (m->fmi3 ? 1 : 0); /* the last one is the independent variable of FMI 3 */
    const Variable *v = model_variables + reference;
    if (reference < count && v->role != ABSENT && v->type == type && (!m->fmi3 || v->size)) return v;
    report(m, ERROR, "%s: value reference %u is no %s variable of this FMU", call, (unsigned)reference, TYPE[type]);
    return NULL;
}
static double real(const Instance *m, const Variable *v) {
    return v->role == CONSTANT ? v->value : v->role == CLOCK_TIME ? m->t : m->block[v->cell] / v->factor;
}
static size_t elements(const Instance *m, const Variable *v) { return m->fmi3 ? v->size : 1; }

int get_values(Instance *m, int type, const uint32_t *references, size_t n, void *values, size_t room) {
    size_t k = 0;
    if (!allowed(m, INITIALIZATION | STEPPING | TERMINATED | DISCARDED, "get")) return ERROR;
    if (n && (!references || !values)) return report(m, ERROR, "get: null pointer");
    if (m->phase & (INITIALIZATION | STEPPING) && freshen(m)) return ERROR;
    for (size_t i = 0; i < n; i++) {
        const Variable *v = variable(m, references[i], type, "get");
        if (!v) return ERROR;
        for (size_t j = 0; j < elements(m, v); j++, k++) {
            if (k >= room) return report(m, ERROR, "get: room for %u values, more are asked for", (unsigned)room);
            if (type == REAL) ((double *)values)[k] = real(m, v + j);
            else if (type == STRING) ((const char **)values)[k] = v[j].text;
            else if (type == BOOLEAN && m->fmi3) ((bool *)values)[k] = real(m, v + j) != 0.0;
            else ((int32_t *)values)[k] = type == BOOLEAN ? real(m, v + j) != 0.0 : (int32_t)nearbyint(real(m, v + j));
        }
    }
    return k == room ? OK : report(m, ERROR, "get: %u values, room for %u", (unsigned)k, (unsigned)room);
}
int set_values(Instance *m, int type, const uint32_t *references, size_t n, const void *values, size_t room) {
    const double *numbers = values;
    size_t k = 0;
    if (!allowed(m, INSTANTIATED | INITIALIZATION | STEPPING, "set")) return ERROR;
    if (n && (!references || !values)) return report(m, ERROR, "set: null pointer");
    for (size_t i = 0; i < n; i++) { /* nothing is changed unless all can be */
        const Variable *v = variable(m, references[i], type, "set");
        if (!v) return ERROR;
        if (v->role == CONSTANT)
            return report(m, ERROR, "set: %s is a constant of this FMU, fixed at its build; build it with another value", v->name);
        if (v->role == PARAMETER && m->phase == STEPPING && !v->tunable)
            return report(m, ERROR, "set: %s is a fixed parameter; it can be set until the end of initialization mode", v->name);
        if (v->role != PARAMETER && v->role != INPUT && v->role != DERIVATIVE) return report(m, ERROR, "set: %s is no input", v->name);
        for (size_t j = 0; j < elements(m, v); j++, k++) {
            if (k >= room) return report(m, ERROR, "set: %u values, more are expected", (unsigned)room);
            if (!isfinite(numbers[k])) return report(m, ERROR, "set: %s = %g", v[j].name, numbers[k]);
            if (v->role == PARAMETER && !(numbers[k] >= v[j].low && numbers[k] <= v[j].high))
                return report(m, ERROR, "set: %s = %.9g, expected %.9g to %.9g", v[j].name, numbers[k], v[j].low, v[j].high);
        }
    }
    if (k != room) return report(m, ERROR, "set: %u values, %u expected", (unsigned)room, (unsigned)k);
    k = 0;
    for (size_t i = 0; i < n; i++) {
        const Variable *v = model_variables + references[i];
        for (size_t j = 0; j < elements(m, v); j++, k++) m->block[v[j].cell] = numbers[k] * v[j].factor;
    }
    m->stale = 1;
    return OK;
}
int set_slopes(Instance *m, const uint32_t *references, size_t n, const int32_t *orders, const double *values) {
    if (n && !model_row) return refuse(m, "SetRealInputDerivatives");
    if (!allowed(m, INSTANTIATED | INITIALIZATION | STEPPING, "SetRealInputDerivatives")) return ERROR;
    if (n && (!references || !orders || !values)) return report(m, ERROR, "SetRealInputDerivatives: null pointer");
    for (int pass = 0; pass < 2; pass++)
        for (size_t i = 0; i < n; i++) {
            const Variable *v = variable(m, references[i], REAL, "SetRealInputDerivatives");
            if (!v) return ERROR;
            if (v->role != INPUT || orders[i] < 1 || orders[i] > 2 || !isfinite(values[i]))
                return report(m, ERROR, "SetRealInputDerivatives: derivative %d of %s = %g", (int)orders[i], v->name, values[i]);
            if (pass) m->block[v->cell + (uint32_t)orders[i] * model_row] = orders[i] == 2 ? 0.5 * values[i] : values[i];
        }
    m->stale = 1;
    return OK;
}

/* ---- derivatives of outputs after inputs at the present state: exact, on a copy of the block ---- */
static int counted(Instance *m, const uint32_t *references, size_t n, int output, size_t *total) {
    *total = 0;
    for (size_t i = 0; i < n; i++) {
        const Variable *v = variable(m, references[i], REAL, "GetDirectionalDerivative");
        if (!v) return ERROR;
        if (output ? v->role != OUTPUT : v->role != INPUT && v->role != DERIVATIVE)
            return report(m, ERROR, "GetDirectionalDerivative: %s is no %s", v->name, output ? "output" : "input");
        *total += elements(m, v);
    }
    return OK;
}
int directional(Instance *m, const uint32_t *unknowns, size_t n, const uint32_t *knowns, size_t k, const double *seed, size_t seeds,
                double *result, size_t results) {
    const size_t room = model_cells + STACK; /* of the block and of the stack, with their tangents behind */
    size_t total, s = 0;
    double *cells, *tangents;
    int status;
    if (!allowed(m, INITIALIZATION | STEPPING, "GetDirectionalDerivative")) return ERROR;
    if ((n && (!unknowns || !result)) || (k && (!knowns || !seed))) return report(m, ERROR, "GetDirectionalDerivative: null pointer");
    if (freshen(m) || counted(m, unknowns, n, 1, &total)) return ERROR;
    if (total != results) return report(m, ERROR, "GetDirectionalDerivative: room for %u values, %u expected", (unsigned)results, (unsigned)total);
    if (counted(m, knowns, k, 0, &total)) return ERROR;
    if (total != seeds) return report(m, ERROR, "GetDirectionalDerivative: seed of %u values, %u expected", (unsigned)seeds, (unsigned)total);
    if (!(cells = calloc(2 * room, 8))) return report(m, ERROR, "GetDirectionalDerivative: no memory");
    memcpy(cells, m->block, 8 * (size_t)model_cells);
    tangents = cells + room;
    for (size_t i = 0; i < k; i++) {
        const Variable *v = model_variables + knowns[i];
        for (size_t j = 0; j < elements(m, v); j++, s++) {
            if (!isfinite(seed[s])) {
                free(cells);
                return report(m, ERROR, "GetDirectionalDerivative: seed %g for %s", seed[s], v[j].name);
            }
            tangents[v[j].cell] += seed[s] * v[j].factor;
        }
    }
    status = model_slopes(m->t, (int64_t)(intptr_t)cells, (int64_t)(8 * room), (int64_t)(intptr_t)(cells + model_cells), 0);
    s = 0;
    for (size_t i = 0; i < n; i++) {
        const Variable *v = model_variables + unknowns[i];
        for (size_t j = 0; j < elements(m, v); j++, s++) {
            result[s] = tangents[v[j].cell];
            status |= !isfinite(result[s]);
        }
    }
    free(cells);
    return status ? report(m, ERROR, "GetDirectionalDerivative: the derivative is not finite at the present inputs") : OK;
}

/* ---- states: one piece of memory; serialized with the token in front and a sum behind ---- */
typedef struct { uint64_t kind; uint32_t phase, stale; double t, start, stop; double cells[]; } State;
static uint64_t sum(const void *bytes, size_t n) { /* FNV-1a */
    const unsigned char *b = bytes;
    uint64_t value = 14695981039346656037u;
    while (n--) value = (value ^ *b++) * 1099511628211u;
    return value;
}
static size_t token_size(void) { return strlen(model_token) + 1; }
static size_t bytes_of_state(void) { return sizeof(State) + 8 * (size_t)model_saved; }
static const State *known(const Instance *m, const void *state, const char *call) {
    const State *s = state;
    if (s && s->kind == sum(model_token, token_size())) return s;
    report(m, ERROR, "%s: %s", call, s ? "a state of another FMU" : "null pointer");
    return NULL;
}
int get_state(Instance *m, void **state) {
    State *s;
    if (!m) return ERROR;
    if (!state || (*state && !known(m, *state, "GetFMUState"))) return report(m, ERROR, "GetFMUState: no place for a state");
    if (!(s = *state ? *state : malloc(bytes_of_state()))) return report(m, ERROR, "GetFMUState: no memory");
    memset(s, 0, sizeof *s);
    s->kind = sum(model_token, token_size());
    s->phase = m->phase; s->stale = m->stale; s->t = m->t; s->start = m->start; s->stop = m->stop;
    memcpy(s->cells, m->block, 8 * (size_t)model_saved);
    model_forget((uint64_t *)s->cells);
    *state = s;
    return OK;
}
int set_state(Instance *m, const void *state) {
    const State *s;
    if (!m || !(s = known(m, state, "SetFMUState"))) return ERROR;
    if (!model_whole
        && (!m->initialized || memcmp(m->block + model_parameters, s->cells + model_parameters, 8 * (size_t)model_parameters_size))) {
        memcpy(m->block, s->cells, 8 * (size_t)model_saved); /* the parameters, and what follows from them, */
        initialize(m, s->start);
    }
    memcpy(m->block, s->cells, 8 * (size_t)model_saved); /* and the state as it was saved */
    model_place(ADDRESS(m));
    m->initialized |= model_whole;
    m->discarded = 0;
    m->phase = s->phase; m->stale = s->stale; m->t = s->t; m->start = s->start; m->stop = s->stop;
    return OK;
}
int free_state(Instance *m, void **state) {
    if (!m) return ERROR;
    if (!state || !*state) return OK;
    if (!known(m, *state, "FreeFMUState")) return ERROR;
    ((State *)*state)->kind = 0;
    free(*state);
    *state = NULL;
    return OK;
}
int state_size(Instance *m, const void *state, size_t *size) {
    if (!m || !known(m, state, "SerializedFMUStateSize")) return ERROR;
    if (!size) return report(m, ERROR, "SerializedFMUStateSize: null pointer");
    *size = token_size() + bytes_of_state() + 8;
    return OK;
}
int serialize(Instance *m, const void *state, void *bytes, size_t size) {
    const size_t head = token_size(), n = head + bytes_of_state();
    uint64_t check;
    if (!m || !known(m, state, "SerializeFMUState")) return ERROR;
    if (!bytes) return report(m, ERROR, "SerializeFMUState: null pointer");
    if (size < n + 8) return report(m, ERROR, "SerializeFMUState: room for %u bytes, %u expected", (unsigned)size, (unsigned)(n + 8));
    memcpy(bytes, model_token, head);
    memcpy((char *)bytes + head, state, n - head);
    check = sum(bytes, n);
    memcpy((char *)bytes + n, &check, 8);
    return OK;
}
int deserialize(Instance *m, const void *bytes, size_t size, void **state) {
    const size_t head = token_size(), n = head + bytes_of_state();
    uint64_t check;
    if (!m) return ERROR;
    if (!bytes || !state) return report(m, ERROR, "DeserializeFMUState: null pointer");
    if (size != n + 8) return report(m, ERROR, "DeserializeFMUState: %u bytes, %u expected", (unsigned)size, (unsigned)(n + 8));
    memcpy(&check, (const char *)bytes + n, 8);
    if (memcmp(bytes, model_token, head) || check != sum(bytes, n))
        return report(m, ERROR, "DeserializeFMUState: bytes that were changed, or a state of another FMU");
    if (*state && !known(m, *state, "DeserializeFMUState")) return ERROR;
    if (!*state && !(*state = malloc(bytes_of_state()))) return report(m, ERROR, "DeserializeFMUState: no memory");
    memcpy(*state, (const char *)bytes + head, n - head);
    return OK;
}
