/* The functions of FMI 3.0 around model.c. Apache License 2.0. */

#include <stdlib.h>
#include <string.h>

#include "headers/fmi3Functions.h"

#include "model.h"

typedef struct {
    lj_model model;
    fmi3InstanceEnvironment environment;
    fmi3LogMessageCallback log;
    int exchange; /* model exchange, not co-simulation */
    char text[LJ_MESSAGE];
} unit;

#define ANY(x) ((void)(x))

static fmi3Status failed(unit *one)
{
    if (one->log != NULL)
        one->log(one->environment, fmi3Error, "logStatusError", one->text);
    return fmi3Error;
}

static fmi3Status refuse(fmi3Instance instance, const char *text)
{
    unit *one = instance;
    if (one == NULL)
        return fmi3Error;
    strncpy(one->text, text, LJ_MESSAGE - 1);
    one->text[LJ_MESSAGE - 1] = '\0';
    return failed(one);
}

/* ---- instances ---- */

const char *fmi3GetVersion(void) { return fmi3Version; }

fmi3Status fmi3SetDebugLogging(fmi3Instance instance, fmi3Boolean on, size_t count,
                               const fmi3String categories[])
{
    ANY(instance), ANY(on), ANY(count), ANY(categories);
    return fmi3OK;
}

static fmi3Instance make(fmi3String token, fmi3String folder, fmi3InstanceEnvironment environment,
                         fmi3LogMessageCallback log, int exchange)
{
    unit *one = calloc(1, sizeof *one);
    if (one == NULL)
        return NULL;
    one->environment = environment;
    one->log = log;
    one->exchange = exchange;
    if (token == NULL || strcmp(token, LJ_TOKEN) != 0) {
        refuse(one, "instantiationToken: not that of this brake's modelDescription.xml");
    } else if (lj_model_make(&one->model, folder, one->text)) {
        failed(one);
    } else {
        return one;
    }
    free(one);
    return NULL;
}

fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String folder,
                                          fmi3Boolean visible, fmi3Boolean logging,
                                          fmi3InstanceEnvironment environment,
                                          fmi3LogMessageCallback log)
{
    ANY(name), ANY(visible), ANY(logging);
    return make(token, folder, environment, log, 1);
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String folder,
                                         fmi3Boolean visible, fmi3Boolean logging,
                                         fmi3Boolean events, fmi3Boolean early,
                                         const fmi3ValueReference required[], size_t count,
                                         fmi3InstanceEnvironment environment,
                                         fmi3LogMessageCallback log,
                                         fmi3IntermediateUpdateCallback update)
{
    ANY(name), ANY(visible), ANY(logging), ANY(events), ANY(early);
    ANY(required), ANY(count), ANY(update);
    return make(token, folder, environment, log, 0);
}

fmi3Instance fmi3InstantiateScheduledExecution(
    fmi3String name, fmi3String token, fmi3String folder, fmi3Boolean visible, fmi3Boolean logging,
    fmi3InstanceEnvironment environment, fmi3LogMessageCallback log, fmi3ClockUpdateCallback clock,
    fmi3LockPreemptionCallback lock, fmi3UnlockPreemptionCallback unlock)
{
    ANY(name), ANY(token), ANY(folder), ANY(visible), ANY(logging), ANY(clock), ANY(lock);
    ANY(unlock);
    if (log != NULL)
        log(environment, fmi3Error, "logStatusError", "scheduled execution is not offered");
    return NULL;
}

void fmi3FreeInstance(fmi3Instance instance) { free(instance); }

fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, fmi3Boolean tolerance_defined,
                                       fmi3Float64 tolerance, fmi3Float64 start,
                                       fmi3Boolean stop_defined, fmi3Float64 stop)
{
    unit *one = instance;
    ANY(tolerance_defined), ANY(tolerance), ANY(stop_defined), ANY(stop);
    one->model.time = start;
    return lj_model_enter(&one->model, one->text) ? failed(one) : fmi3OK;
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance instance)
{
    unit *one = instance;
    return lj_model_start(&one->model, one->text) ? failed(one) : fmi3OK;
}

fmi3Status fmi3EnterEventMode(fmi3Instance instance)
{
    unit *one = instance;
    int changed;
    if (!one->exchange)
        return fmi3OK;
    return lj_model_commit(&one->model, &changed, one->text) ? failed(one) : fmi3OK;
}

fmi3Status fmi3Terminate(fmi3Instance instance)
{
    unit *one = instance;
    one->model.phase = LJ_ENDED;
    return fmi3OK;
}

fmi3Status fmi3Reset(fmi3Instance instance)
{
    unit *one = instance;
    lj_model_reset(&one->model);
    return fmi3OK;
}

/* ---- variables ---- */

fmi3Status fmi3GetFloat64(fmi3Instance instance, const fmi3ValueReference references[],
                          size_t count, fmi3Float64 values[], size_t size)
{
    unit *one = instance;
    size_t i;
    if (size != count)
        return refuse(instance, "fmi3GetFloat64: a value for each variable is due");
    for (i = 0; i < count; i++)
        if (lj_model_get(&one->model, references[i], &values[i], one->text))
            return failed(one);
    return fmi3OK;
}

fmi3Status fmi3SetFloat64(fmi3Instance instance, const fmi3ValueReference references[],
                          size_t count, const fmi3Float64 values[], size_t size)
{
    unit *one = instance;
    size_t i;
    if (size != count)
        return refuse(instance, "fmi3SetFloat64: a value for each variable is due");
    for (i = 0; i < count; i++)
        if (lj_model_set(&one->model, references[i], values[i], one->text))
            return failed(one);
    return fmi3OK;
}

fmi3Status fmi3GetBoolean(fmi3Instance instance, const fmi3ValueReference references[],
                          size_t count, fmi3Boolean values[], size_t size)
{
    unit *one = instance;
    size_t i;
    if (size != count)
        return refuse(instance, "fmi3GetBoolean: a value for each variable is due");
    for (i = 0; i < count; i++) {
        int value;
        if (lj_model_flag(&one->model, references[i], &value, one->text))
            return failed(one);
        values[i] = value != 0;
    }
    return fmi3OK;
}

static fmi3Status mismatch(fmi3Instance instance, const fmi3ValueReference references[],
                           size_t count, const char *function)
{
    unit *one = instance;
    if (count == 0)
        return fmi3OK;
    lj_model_mismatch(references[0], function, one->text);
    return failed(one);
}

/* What this brake has no variable of. */
#define NONE(Kind)                                                                                 \
    fmi3Status fmi3Get##Kind(fmi3Instance instance, const fmi3ValueReference references[],         \
                             size_t count, fmi3##Kind values[], size_t size)                       \
    {                                                                                              \
        ANY(values), ANY(size);                                                                    \
        return mismatch(instance, references, count, "fmi3Get" #Kind);                             \
    }                                                                                              \
    NO_SET(Kind)

#define NO_SET(Kind)                                                                               \
    fmi3Status fmi3Set##Kind(fmi3Instance instance, const fmi3ValueReference references[],         \
                             size_t count, const fmi3##Kind values[], size_t size)                 \
    {                                                                                              \
        ANY(values), ANY(size);                                                                    \
        return mismatch(instance, references, count, "fmi3Set" #Kind);                             \
    }

NONE(Float32)
NONE(Int8)
NONE(UInt8)
NONE(Int16)
NONE(UInt16)
NONE(Int32)
NONE(UInt32)
NONE(Int64)
NONE(UInt64)
NONE(String)
NO_SET(Boolean)

fmi3Status fmi3GetBinary(fmi3Instance instance, const fmi3ValueReference references[],
                         size_t count, size_t sizes[], fmi3Binary values[], size_t size)
{
    ANY(sizes), ANY(values), ANY(size);
    return mismatch(instance, references, count, "fmi3GetBinary");
}

fmi3Status fmi3SetBinary(fmi3Instance instance, const fmi3ValueReference references[],
                         size_t count, const size_t sizes[], const fmi3Binary values[], size_t size)
{
    ANY(sizes), ANY(values), ANY(size);
    return mismatch(instance, references, count, "fmi3SetBinary");
}

fmi3Status fmi3GetClock(fmi3Instance instance, const fmi3ValueReference references[], size_t count,
                        fmi3Clock values[])
{
    ANY(values);
    return mismatch(instance, references, count, "fmi3GetClock");
}

fmi3Status fmi3SetClock(fmi3Instance instance, const fmi3ValueReference references[], size_t count,
                        const fmi3Clock values[])
{
    ANY(values);
    return mismatch(instance, references, count, "fmi3SetClock");
}

fmi3Status fmi3GetNumberOfVariableDependencies(fmi3Instance instance, fmi3ValueReference reference,
                                               size_t *count)
{
    ANY(reference), ANY(count);
    return refuse(instance, "dependencies of single elements are not offered");
}

fmi3Status fmi3GetVariableDependencies(fmi3Instance instance, fmi3ValueReference dependent,
                                       size_t elements[], fmi3ValueReference independents[],
                                       size_t others[], fmi3DependencyKind kinds[], size_t count)
{
    ANY(dependent), ANY(elements), ANY(independents), ANY(others), ANY(kinds), ANY(count);
    return refuse(instance, "dependencies of single elements are not offered");
}

/* ---- snapshots ---- */

fmi3Status fmi3GetFMUState(fmi3Instance instance, fmi3FMUState *state)
{
    unit *one = instance;
    return lj_model_keep(&one->model, state, one->text) ? failed(one) : fmi3OK;
}

fmi3Status fmi3SetFMUState(fmi3Instance instance, fmi3FMUState state)
{
    unit *one = instance;
    if (state == NULL)
        return refuse(instance, "state: none is given");
    memcpy(&one->model, state, sizeof one->model);
    return fmi3OK;
}

fmi3Status fmi3FreeFMUState(fmi3Instance instance, fmi3FMUState *state)
{
    ANY(instance);
    free(*state);
    *state = NULL;
    return fmi3OK;
}

fmi3Status fmi3SerializedFMUStateSize(fmi3Instance instance, fmi3FMUState state, size_t *size)
{
    ANY(instance), ANY(state);
    *size = LJ_MODEL_BYTES;
    return fmi3OK;
}

fmi3Status fmi3SerializeFMUState(fmi3Instance instance, fmi3FMUState state, fmi3Byte bytes[],
                                 size_t size)
{
    unit *one = instance;
    return lj_model_pack(state, bytes, size, one->text) ? failed(one) : fmi3OK;
}

fmi3Status fmi3DeserializeFMUState(fmi3Instance instance, const fmi3Byte bytes[], size_t size,
                                   fmi3FMUState *state)
{
    unit *one = instance;
    return lj_model_unpack(state, bytes, size, one->text) ? failed(one) : fmi3OK;
}

/* ---- slopes ---- */

static fmi3Status slopes(unit *one, const fmi3ValueReference unknowns[], size_t n_unknowns,
                         const fmi3ValueReference knowns[], size_t n_knowns,
                         const fmi3Float64 seed[], fmi3Float64 sensitivity[], int adjoint)
{
    size_t i, j, results = adjoint ? n_knowns : n_unknowns;
    for (i = 0; i < results; i++)
        sensitivity[i] = 0;
    for (i = 0; i < n_unknowns; i++)
        for (j = 0; j < n_knowns; j++) {
            double slope;
            if (lj_model_slope(&one->model, unknowns[i], knowns[j], &slope, one->text))
                return failed(one);
            sensitivity[adjoint ? j : i] += slope * seed[adjoint ? i : j];
        }
    return fmi3OK;
}

fmi3Status fmi3GetDirectionalDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[],
                                        size_t n_unknowns, const fmi3ValueReference knowns[],
                                        size_t n_knowns, const fmi3Float64 seed[], size_t n_seed,
                                        fmi3Float64 sensitivity[], size_t n_sensitivity)
{
    if (n_seed != n_knowns || n_sensitivity != n_unknowns)
        return refuse(instance, "fmi3GetDirectionalDerivative: sizes do not match");
    return slopes(instance, unknowns, n_unknowns, knowns, n_knowns, seed, sensitivity, 0);
}

fmi3Status fmi3GetAdjointDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[],
                                    size_t n_unknowns, const fmi3ValueReference knowns[],
                                    size_t n_knowns, const fmi3Float64 seed[], size_t n_seed,
                                    fmi3Float64 sensitivity[], size_t n_sensitivity)
{
    if (n_seed != n_unknowns || n_sensitivity != n_knowns)
        return refuse(instance, "fmi3GetAdjointDerivative: sizes do not match");
    return slopes(instance, unknowns, n_unknowns, knowns, n_knowns, seed, sensitivity, 1);
}

/* ---- modes and clocks that the brake has nothing to do in ---- */

fmi3Status fmi3EnterConfigurationMode(fmi3Instance instance)
{
    return refuse(instance, "there are no structural parameters to configure");
}

fmi3Status fmi3ExitConfigurationMode(fmi3Instance instance)
{
    return refuse(instance, "there are no structural parameters to configure");
}

static fmi3Status no_clock(fmi3Instance instance, size_t count)
{
    return count ? refuse(instance, "there are no clocks") : fmi3OK;
}

fmi3Status fmi3GetIntervalDecimal(fmi3Instance instance, const fmi3ValueReference references[],
                                  size_t count, fmi3Float64 intervals[],
                                  fmi3IntervalQualifier qualifiers[])
{
    ANY(references), ANY(intervals), ANY(qualifiers);
    return no_clock(instance, count);
}

fmi3Status fmi3GetIntervalFraction(fmi3Instance instance, const fmi3ValueReference references[],
                                   size_t count, fmi3UInt64 counters[], fmi3UInt64 resolutions[],
                                   fmi3IntervalQualifier qualifiers[])
{
    ANY(references), ANY(counters), ANY(resolutions), ANY(qualifiers);
    return no_clock(instance, count);
}

fmi3Status fmi3GetShiftDecimal(fmi3Instance instance, const fmi3ValueReference references[],
                               size_t count, fmi3Float64 shifts[])
{
    ANY(references), ANY(shifts);
    return no_clock(instance, count);
}

fmi3Status fmi3GetShiftFraction(fmi3Instance instance, const fmi3ValueReference references[],
                                size_t count, fmi3UInt64 counters[], fmi3UInt64 resolutions[])
{
    ANY(references), ANY(counters), ANY(resolutions);
    return no_clock(instance, count);
}

fmi3Status fmi3SetIntervalDecimal(fmi3Instance instance, const fmi3ValueReference references[],
                                  size_t count, const fmi3Float64 intervals[])
{
    ANY(references), ANY(intervals);
    return no_clock(instance, count);
}

fmi3Status fmi3SetIntervalFraction(fmi3Instance instance, const fmi3ValueReference references[],
                                   size_t count, const fmi3UInt64 counters[],
                                   const fmi3UInt64 resolutions[])
{
    ANY(references), ANY(counters), ANY(resolutions);
    return no_clock(instance, count);
}

fmi3Status fmi3SetShiftDecimal(fmi3Instance instance, const fmi3ValueReference references[],
                               size_t count, const fmi3Float64 shifts[])
{
    ANY(references), ANY(shifts);
    return no_clock(instance, count);
}

fmi3Status fmi3SetShiftFraction(fmi3Instance instance, const fmi3ValueReference references[],
                                size_t count, const fmi3UInt64 counters[],
                                const fmi3UInt64 resolutions[])
{
    ANY(references), ANY(counters), ANY(resolutions);
    return no_clock(instance, count);
}

fmi3Status fmi3ActivateModelPartition(fmi3Instance instance, fmi3ValueReference clock,
                                      fmi3Float64 time)
{
    ANY(clock), ANY(time);
    return refuse(instance, "scheduled execution is not offered");
}

fmi3Status fmi3EvaluateDiscreteStates(fmi3Instance instance)
{
    ANY(instance);
    return fmi3OK;
}

fmi3Status fmi3UpdateDiscreteStates(fmi3Instance instance, fmi3Boolean *again,
                                    fmi3Boolean *terminate, fmi3Boolean *nominals,
                                    fmi3Boolean *states, fmi3Boolean *event_defined,
                                    fmi3Float64 *event)
{
    unit *one = instance;
    int changed;
    *again = *terminate = *nominals = *states = *event_defined = fmi3False;
    *event = 0;
    if (one->exchange) {
        if (lj_model_commit(&one->model, &changed, one->text))
            return failed(one);
        one->model.published = one->model.state.flags;
    }
    return fmi3OK;
}

/* ---- model exchange ---- */

fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance instance)
{
    ANY(instance);
    return fmi3OK;
}

fmi3Status fmi3CompletedIntegratorStep(fmi3Instance instance, fmi3Boolean final,
                                       fmi3Boolean *event, fmi3Boolean *terminate)
{
    unit *one = instance;
    int changed = 0;
    ANY(final);
    *event = *terminate = fmi3False;
    if (lj_model_commit(&one->model, &changed, one->text))
        return failed(one);
    *event = changed != 0;
    return fmi3OK;
}

fmi3Status fmi3SetTime(fmi3Instance instance, fmi3Float64 time)
{
    unit *one = instance;
    one->model.time = time;
    return fmi3OK;
}

static fmi3Status no_states(fmi3Instance instance, size_t count)
{
    return count ? refuse(instance, "there are no continuous states") : fmi3OK;
}

fmi3Status fmi3SetContinuousStates(fmi3Instance instance, const fmi3Float64 states[], size_t count)
{
    ANY(states);
    return no_states(instance, count);
}

fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance instance, fmi3Float64 derivatives[],
                                             size_t count)
{
    ANY(derivatives);
    return no_states(instance, count);
}

fmi3Status fmi3GetContinuousStates(fmi3Instance instance, fmi3Float64 states[], size_t count)
{
    ANY(states);
    return no_states(instance, count);
}

fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance instance, fmi3Float64 nominals[],
                                             size_t count)
{
    ANY(nominals);
    return no_states(instance, count);
}

fmi3Status fmi3GetEventIndicators(fmi3Instance instance, fmi3Float64 indicators[], size_t count)
{
    unit *one = instance;
    if (count != 1)
        return refuse(instance, "there is one event indicator");
    return lj_model_get(&one->model, LJ_TURNING, indicators, one->text) ? failed(one) : fmi3OK;
}

fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance instance, size_t *count)
{
    ANY(instance);
    *count = 1;
    return fmi3OK;
}

fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance instance, size_t *count)
{
    ANY(instance);
    *count = 0;
    return fmi3OK;
}

/* ---- co-simulation ---- */

fmi3Status fmi3EnterStepMode(fmi3Instance instance)
{
    ANY(instance);
    return fmi3OK;
}

fmi3Status fmi3GetOutputDerivatives(fmi3Instance instance, const fmi3ValueReference references[],
                                    size_t count, const fmi3Int32 orders[], fmi3Float64 values[],
                                    size_t size)
{
    ANY(references), ANY(orders), ANY(values), ANY(size);
    return count ? refuse(instance, "derivatives of outputs in time are not offered") : fmi3OK;
}

fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 time, fmi3Float64 length,
                      fmi3Boolean final, fmi3Boolean *event, fmi3Boolean *terminate,
                      fmi3Boolean *early, fmi3Float64 *last)
{
    unit *one = instance;
    ANY(final);
    *event = *terminate = *early = fmi3False;
    *last = time;
    if (lj_model_step(&one->model, time, length, one->text))
        return failed(one);
    *last = one->model.time;
    return fmi3OK;
}
