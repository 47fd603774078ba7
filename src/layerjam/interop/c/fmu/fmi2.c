/* The functions of FMI 2.0 around model.c. Apache License 2.0. */

#include <stdlib.h>
#include <string.h>

#include "headers/fmi2Functions.h"

#include "model.h"

typedef struct {
    lj_model model;
    fmi2ComponentEnvironment environment;
    fmi2CallbackLogger log;
    char name[80];
    char text[LJ_MESSAGE];
} unit;

#define ANY(x) ((void)(x))

static fmi2Status failed(unit *one)
{
    if (one->log != NULL)
        one->log(one->environment, one->name, fmi2Error, "logStatusError", "%s", one->text);
    return fmi2Error;
}

static fmi2Status refuse(fmi2Component component, const char *text)
{
    unit *one = component;
    strncpy(one->text, text, LJ_MESSAGE - 1);
    one->text[LJ_MESSAGE - 1] = '\0';
    return failed(one);
}

/* ---- instances ---- */

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }

const char *fmi2GetVersion(void) { return fmi2Version; }

fmi2Status fmi2SetDebugLogging(fmi2Component component, fmi2Boolean on, size_t count,
                               const fmi2String categories[])
{
    ANY(component), ANY(on), ANY(count), ANY(categories);
    return fmi2OK;
}

static int digit(char c)
{
    if (c >= '0' && c <= '9')
        return c - '0';
    if (c >= 'a' && c <= 'f')
        return c - 'a' + 10;
    return c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
}

/* The folder of "file:///a%20b/resources"; what is no such address stays as it is. */
static void folder_of(char *folder, size_t size, const char *address)
{
    size_t length = 0;
    folder[0] = '\0';
    if (address == NULL)
        return;
    if (strncmp(address, "file:", 5) == 0) {
        address += 5;
        if (address[0] == '/' && address[1] == '/') {
            address += 2;
            while (*address != '\0' && *address != '/')
                address++; /* a host, such as localhost */
        }
        if (address[0] == '/' && address[1] != '\0' && address[2] == ':')
            address++; /* a drive's letter */
    }
    for (; *address != '\0' && length + 1 < size; address++) {
        int high = address[0] == '%' ? digit(address[1]) : -1;
        int low = high >= 0 ? digit(address[2]) : -1;
        folder[length++] = low >= 0 ? (char)(16 * high + low) : *address;
        if (low >= 0)
            address += 2;
    }
    folder[length] = '\0';
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String token, fmi2String address,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible,
                              fmi2Boolean logging)
{
    char folder[4096];
    unit *one = calloc(1, sizeof *one);
    ANY(type), ANY(visible), ANY(logging);
    if (one == NULL)
        return NULL;
    if (functions != NULL) {
        one->environment = functions->componentEnvironment;
        one->log = functions->logger;
    }
    strncpy(one->name, name == NULL ? "" : name, sizeof one->name - 1);
    folder_of(folder, sizeof folder, address);
    if (token == NULL || strcmp(token, LJ_TOKEN) != 0) {
        refuse(one, "guid: not that of this brake's modelDescription.xml");
    } else if (lj_model_make(&one->model, folder, one->text)) {
        failed(one);
    } else {
        return one;
    }
    free(one);
    return NULL;
}

void fmi2FreeInstance(fmi2Component component) { free(component); }

fmi2Status fmi2SetupExperiment(fmi2Component component, fmi2Boolean tolerance_defined,
                               fmi2Real tolerance, fmi2Real start, fmi2Boolean stop_defined,
                               fmi2Real stop)
{
    unit *one = component;
    ANY(tolerance_defined), ANY(tolerance), ANY(stop_defined), ANY(stop);
    one->model.time = start;
    return fmi2OK;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component component)
{
    unit *one = component;
    return lj_model_enter(&one->model, one->text) ? failed(one) : fmi2OK;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component component)
{
    unit *one = component;
    return lj_model_start(&one->model, one->text) ? failed(one) : fmi2OK;
}

fmi2Status fmi2Terminate(fmi2Component component)
{
    unit *one = component;
    one->model.phase = LJ_ENDED;
    return fmi2OK;
}

fmi2Status fmi2Reset(fmi2Component component)
{
    unit *one = component;
    lj_model_reset(&one->model);
    return fmi2OK;
}

/* ---- variables ---- */

fmi2Status fmi2GetReal(fmi2Component component, const fmi2ValueReference references[], size_t count,
                       fmi2Real values[])
{
    unit *one = component;
    size_t i;
    for (i = 0; i < count; i++)
        if (lj_model_get(&one->model, references[i], &values[i], one->text))
            return failed(one);
    return fmi2OK;
}

fmi2Status fmi2SetReal(fmi2Component component, const fmi2ValueReference references[], size_t count,
                       const fmi2Real values[])
{
    unit *one = component;
    size_t i;
    for (i = 0; i < count; i++)
        if (lj_model_set(&one->model, references[i], values[i], one->text))
            return failed(one);
    return fmi2OK;
}

fmi2Status fmi2GetBoolean(fmi2Component component, const fmi2ValueReference references[],
                          size_t count, fmi2Boolean values[])
{
    unit *one = component;
    size_t i;
    for (i = 0; i < count; i++) {
        int value;
        if (lj_model_flag(&one->model, references[i], &value, one->text))
            return failed(one);
        values[i] = value;
    }
    return fmi2OK;
}

static fmi2Status mismatch(fmi2Component component, const fmi2ValueReference references[],
                           size_t count, const char *function)
{
    unit *one = component;
    if (count == 0)
        return fmi2OK;
    lj_model_mismatch(references[0], function, one->text);
    return failed(one);
}

/* What this brake has no variable of. */
#define NO_GET(Kind)                                                                               \
    fmi2Status fmi2Get##Kind(fmi2Component component, const fmi2ValueReference references[],       \
                             size_t count, fmi2##Kind values[])                                    \
    {                                                                                              \
        ANY(values);                                                                               \
        return mismatch(component, references, count, "fmi2Get" #Kind);                            \
    }

#define NO_SET(Kind)                                                                               \
    fmi2Status fmi2Set##Kind(fmi2Component component, const fmi2ValueReference references[],       \
                             size_t count, const fmi2##Kind values[])                              \
    {                                                                                              \
        ANY(values);                                                                               \
        return mismatch(component, references, count, "fmi2Set" #Kind);                            \
    }

NO_GET(Integer)
NO_GET(String)
NO_SET(Integer)
NO_SET(Boolean)
NO_SET(String)

/* ---- snapshots ---- */

fmi2Status fmi2GetFMUstate(fmi2Component component, fmi2FMUstate *state)
{
    unit *one = component;
    return lj_model_keep(&one->model, state, one->text) ? failed(one) : fmi2OK;
}

fmi2Status fmi2SetFMUstate(fmi2Component component, fmi2FMUstate state)
{
    unit *one = component;
    if (state == NULL)
        return refuse(component, "state: none is given");
    memcpy(&one->model, state, sizeof one->model);
    return fmi2OK;
}

fmi2Status fmi2FreeFMUstate(fmi2Component component, fmi2FMUstate *state)
{
    ANY(component);
    free(*state);
    *state = NULL;
    return fmi2OK;
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component component, fmi2FMUstate state, size_t *size)
{
    ANY(component), ANY(state);
    *size = LJ_MODEL_BYTES;
    return fmi2OK;
}

fmi2Status fmi2SerializeFMUstate(fmi2Component component, fmi2FMUstate state, fmi2Byte bytes[],
                                 size_t size)
{
    unit *one = component;
    return lj_model_pack(state, (unsigned char *)bytes, size, one->text) ? failed(one) : fmi2OK;
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component component, const fmi2Byte bytes[], size_t size,
                                   fmi2FMUstate *state)
{
    unit *one = component;
    return lj_model_unpack(state, (const unsigned char *)bytes, size, one->text) ? failed(one) : fmi2OK;
}

fmi2Status fmi2GetDirectionalDerivative(fmi2Component component,
                                        const fmi2ValueReference unknowns[], size_t n_unknowns,
                                        const fmi2ValueReference knowns[], size_t n_knowns,
                                        const fmi2Real seed[], fmi2Real sensitivity[])
{
    unit *one = component;
    size_t i, j;
    for (i = 0; i < n_unknowns; i++) {
        sensitivity[i] = 0;
        for (j = 0; j < n_knowns; j++) {
            double slope;
            if (lj_model_slope(&one->model, unknowns[i], knowns[j], &slope, one->text))
                return failed(one);
            sensitivity[i] += slope * seed[j];
        }
    }
    return fmi2OK;
}

/* ---- model exchange ---- */

static fmi2Status commit(unit *one, int *changed)
{
    return lj_model_commit(&one->model, changed, one->text) ? failed(one) : fmi2OK;
}

fmi2Status fmi2EnterEventMode(fmi2Component component)
{
    int changed;
    return commit(component, &changed);
}

fmi2Status fmi2NewDiscreteStates(fmi2Component component, fmi2EventInfo *info)
{
    unit *one = component;
    int changed;
    memset(info, 0, sizeof *info);
    if (commit(one, &changed) != fmi2OK)
        return fmi2Error;
    one->model.published = one->model.state.flags;
    return fmi2OK;
}

fmi2Status fmi2EnterContinuousTimeMode(fmi2Component component)
{
    ANY(component);
    return fmi2OK;
}

fmi2Status fmi2CompletedIntegratorStep(fmi2Component component, fmi2Boolean final,
                                       fmi2Boolean *event, fmi2Boolean *terminate)
{
    int changed = 0;
    ANY(final);
    *event = *terminate = fmi2False;
    if (commit(component, &changed) != fmi2OK)
        return fmi2Error;
    *event = changed;
    return fmi2OK;
}

fmi2Status fmi2SetTime(fmi2Component component, fmi2Real time)
{
    unit *one = component;
    one->model.time = time;
    return fmi2OK;
}

static fmi2Status no_states(fmi2Component component, size_t count)
{
    return count ? refuse(component, "there are no continuous states") : fmi2OK;
}

fmi2Status fmi2SetContinuousStates(fmi2Component component, const fmi2Real states[], size_t count)
{
    ANY(states);
    return no_states(component, count);
}

fmi2Status fmi2GetDerivatives(fmi2Component component, fmi2Real derivatives[], size_t count)
{
    ANY(derivatives);
    return no_states(component, count);
}

fmi2Status fmi2GetContinuousStates(fmi2Component component, fmi2Real states[], size_t count)
{
    ANY(states);
    return no_states(component, count);
}

fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component component, fmi2Real nominals[],
                                             size_t count)
{
    ANY(nominals);
    return no_states(component, count);
}

fmi2Status fmi2GetEventIndicators(fmi2Component component, fmi2Real indicators[], size_t count)
{
    unit *one = component;
    if (count != 1)
        return refuse(component, "there is one event indicator");
    return lj_model_get(&one->model, LJ_TURNING, indicators, one->text) ? failed(one) : fmi2OK;
}

/* ---- co-simulation ---- */

fmi2Status fmi2SetRealInputDerivatives(fmi2Component component,
                                       const fmi2ValueReference references[], size_t count,
                                       const fmi2Integer orders[], const fmi2Real values[])
{
    ANY(references), ANY(orders), ANY(values);
    return count ? refuse(component, "derivatives of inputs: give the velocity") : fmi2OK;
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component component,
                                        const fmi2ValueReference references[], size_t count,
                                        const fmi2Integer orders[], fmi2Real values[])
{
    ANY(references), ANY(orders), ANY(values);
    return count ? refuse(component, "derivatives of outputs in time are not offered") : fmi2OK;
}

fmi2Status fmi2DoStep(fmi2Component component, fmi2Real time, fmi2Real length, fmi2Boolean final)
{
    unit *one = component;
    ANY(final);
    return lj_model_step(&one->model, time, length, one->text) ? failed(one) : fmi2OK;
}

fmi2Status fmi2CancelStep(fmi2Component component)
{
    return refuse(component, "a step is never under way when a function returns");
}

fmi2Status fmi2GetStatus(fmi2Component component, const fmi2StatusKind kind, fmi2Status *value)
{
    ANY(component), ANY(kind);
    *value = fmi2OK;
    return fmi2OK;
}

fmi2Status fmi2GetRealStatus(fmi2Component component, const fmi2StatusKind kind, fmi2Real *value)
{
    unit *one = component;
    if (kind != fmi2LastSuccessfulTime)
        return refuse(component, "this status is not offered");
    *value = one->model.time;
    return fmi2OK;
}

fmi2Status fmi2GetIntegerStatus(fmi2Component component, const fmi2StatusKind kind,
                                fmi2Integer *value)
{
    ANY(kind), ANY(value);
    return refuse(component, "this status is not offered");
}

fmi2Status fmi2GetBooleanStatus(fmi2Component component, const fmi2StatusKind kind,
                                fmi2Boolean *value)
{
    if (kind != fmi2Terminated)
        return refuse(component, "this status is not offered");
    *value = fmi2False;
    return fmi2OK;
}

fmi2Status fmi2GetStringStatus(fmi2Component component, const fmi2StatusKind kind,
                               fmi2String *value)
{
    ANY(kind), ANY(value);
    return refuse(component, "this status is not offered");
}
