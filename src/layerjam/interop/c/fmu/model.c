/* See model.h. Apache License 2.0. */

#include "model.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "values.h"

static const char MAGIC[8] = {'L', 'J', 'B', 'R', 'A', 'K', 'E', '1'};

static int say(char *text, const char *name, const char *what)
{
    snprintf(text, LJ_MESSAGE, "%s: %s", name, what);
    return 1;
}

/* ---- start values ---- */

/* Little-endian on every machine that an FMU is made for. */
static int read_values(double *values, FILE *file)
{
    char magic[8];
    uint32_t count = 0;
    int fine = fread(magic, 1, sizeof magic, file) == sizeof magic;
    fine = fine && memcmp(magic, MAGIC, sizeof magic) == 0;
    fine = fine && fread(&count, sizeof count, 1, file) == 1 && count == LJ_PARAMETERS;
    fine = fine && fread(values, sizeof *values, LJ_PARAMETERS, file) == LJ_PARAMETERS;
    return fine && fgetc(file) == EOF;
}

int lj_model_make(lj_model *model, const char *folder, char *text)
{
    static const double compiled[] = LJ_VALUES;
    char path[4096];
    FILE *file = NULL;
    int length = 0;
    memset(model, 0, sizeof *model);
    if (folder != NULL && folder[0] != '\0')
        length = snprintf(path, sizeof path, "%s/brake.bin", folder);
    if (length > 0 && (size_t)length < sizeof path)
        file = fopen(path, "rb");
    if (file != NULL) {
        int fine = read_values(model->parameter, file);
        fclose(file);
        if (!fine)
            return say(text, "resources/brake.bin", "is damaged; export the brake again");
    } else if (sizeof compiled / sizeof *compiled == LJ_PARAMETERS) {
        memcpy(model->parameter, compiled, sizeof compiled);
    } else {
        return say(text, "resources/brake.bin", "is not found; export the brake again");
    }
    memcpy(model->exported, model->parameter, sizeof model->exported);
    model->phase = LJ_MADE;
    return 0;
}

void lj_model_reset(lj_model *model)
{
    double exported[LJ_PARAMETERS];
    memcpy(exported, model->exported, sizeof exported);
    memset(model, 0, sizeof *model);
    memcpy(model->parameter, exported, sizeof exported);
    memcpy(model->exported, exported, sizeof exported);
}

/* ---- the brake's eight numbers, as mechanics/stiffness.py, friction.py and enclosure.py ---- */

static double stuck_stiffness(const double *p)
{
    double one = p[LJ_FILM_MODULUS] * p[LJ_SHEETS_WIDTH] * p[LJ_SHEETS_THICKNESS];
    double left = ceil(p[LJ_SHEETS_COUNT] / 2), right = floor(p[LJ_SHEETS_COUNT] / 2);
    double soft = p[LJ_SHEETS_FREE_LEFT] / left + p[LJ_SHEETS_OVERLAP] / p[LJ_SHEETS_COUNT];
    return one / (soft + p[LJ_SHEETS_FREE_RIGHT] / right);
}

static void brake_of(lj_brake *brake, const double *p)
{
    double width = p[LJ_SHEETS_WIDTH], k = p[LJ_STIFFNESS_MEASURED];
    double free = p[LJ_SHEETS_FREE_LEFT] + p[LJ_SHEETS_OVERLAP] + p[LJ_SHEETS_FREE_RIGHT];
    if (!(k > 0))
        k = stuck_stiffness(p);
    if (p[LJ_ROPE_STIFFNESS] > 0)
        k = 1 / (1 / k + 1 / p[LJ_ROPE_STIFFNESS]);
    brake->contact = p[LJ_SCALE_FACTOR] * p[LJ_FILM_KINETIC] * (p[LJ_SHEETS_COUNT] - 1);
    brake->contact *= width * p[LJ_VACUUM_SHARE];
    brake->overlap = p[LJ_SHEETS_OVERLAP];
    brake->stiffness = k;
    brake->enclosure_stiffness = p[LJ_ENCLOSURE_MODULUS] * width * p[LJ_ENCLOSURE_WALL];
    brake->enclosure_contact = p[LJ_FILM_FRICTION_ON_SILICONE] * width;
    brake->reach = free / 2;
    brake->exponent = p[LJ_PRESSURE_EXPONENT];
    brake->test_pressure = 1;
    if (brake->exponent < 0 || brake->exponent > 0)
        brake->test_pressure = p[LJ_TEST_PRESSURE] / p[LJ_VACUUM_SHARE];
}

static int is_finite(const double *values, int count)
{
    while (count > 0 && values[count - 1] > -LJ_LIMIT && values[count - 1] < LJ_LIMIT)
        count--;
    return count == 0;
}

static int check_parameters(const lj_model *model, char *text)
{
    int i;
    for (i = 0; i < LJ_PARAMETERS; i++) {
        const lj_variable *one = &lj_parameters[i];
        double value = model->parameter[i];
        int absent = one->optional && !(value < 0) && !(value > 0);
        int fine = value >= one->least && value <= one->most;
        if (one->whole)
            fine = fine && !(value < floor(value)) && !(value > floor(value));
        if (!fine && !absent) {
            snprintf(text, LJ_MESSAGE, "%s: %.9g is not allowed; %sat least %.9g and at most %.9g",
                     one->name, value, one->whole ? "a whole number, " : "", one->least, one->most);
            return 1;
        }
    }
    if ((model->parameter[LJ_PRESSURE_EXPONENT] < 0 || model->parameter[LJ_PRESSURE_EXPONENT] > 0) &&
        !(model->parameter[LJ_TEST_PRESSURE] > 0))
        return say(text, "test_pressure", "0 is not allowed where a pressure_exponent is given");
    return 0;
}

/* ---- inputs and outputs ---- */

/* The name of a variable; null if there is none with this reference. */
static const char *name_of(unsigned reference)
{
    if (reference < LJ_FIRST_PARAMETER)
        return lj_names[reference];
    reference -= LJ_FIRST_PARAMETER;
    return reference < LJ_PARAMETERS ? lj_parameters[reference].name : NULL;
}

static int unknown(unsigned reference, char *text)
{
    snprintf(text, LJ_MESSAGE, "variable %u: this brake has no such variable", reference);
    return 1;
}

int lj_model_mismatch(unsigned reference, const char *function, char *text)
{
    const char *name = name_of(reference);
    if (name == NULL)
        return unknown(reference, text);
    snprintf(text, LJ_MESSAGE, "%s: %s is not for this variable", name, function);
    return 1;
}

int lj_model_set(lj_model *model, unsigned reference, double value, char *text)
{
    const char *name = name_of(reference);
    if (name == NULL)
        return unknown(reference, text);
    if (!is_finite(&value, 1)) {
        snprintf(text, LJ_MESSAGE, "%s: %g is not a number to compute with; expected one below %g",
                 name, value, LJ_LIMIT);
        return 1;
    }
    if (reference >= LJ_FIRST_PARAMETER) {
        if (model->phase > LJ_INITIALIZING)
            return say(text, name, "a parameter cannot be set while the simulation runs");
        model->parameter[reference - LJ_FIRST_PARAMETER] = value;
        return 0;
    }
    if (reference < LJ_FIRST_INPUT || reference >= LJ_FIRST_INPUT + LJ_INPUTS)
        return say(text, name, "neither a parameter nor an input, cannot be set");
    if (reference == LJ_VACUUM && value < 0)
        return say(text, "vacuum", "a negative vacuum is not allowed; zero or more, in Pa");
    model->input[reference - LJ_FIRST_INPUT] = value;
    model->asked = 1;
    return 0;
}

static double input(const lj_model *model, unsigned reference)
{
    return model->input[reference - LJ_FIRST_INPUT];
}

static int move(const lj_model *model, const lj_brake *brake, lj_state *state, double elongation,
                char *text)
{
    lj_move(brake, state, elongation, input(model, LJ_VACUUM), 0);
    if (state->flags & LJ_REFUSED)
        return say(text, "elongation", "too large to compute with");
    return 0;
}

/* The brake as it would stand at the inputs as set. */
static int ask(const lj_model *model, lj_brake *brake, lj_state *state, char *text)
{
    *brake = model->brake;
    *state = model->state;
    if (model->phase < LJ_RUNNING) {
        if (check_parameters(model, text))
            return 1;
        brake_of(brake, model->parameter);
        lj_start(state, input(model, LJ_VACUUM));
    } else if (!model->asked) {
        return 0;
    }
    return move(model, brake, state, input(model, LJ_ELONGATION), text);
}

static double output_of(const lj_brake *brake, const lj_state *state, unsigned reference)
{
    switch (reference) {
    case LJ_FORCE: return state->force;
    case LJ_SLIP: return state->slip;
    case LJ_STIFFNESS: return lj_tangent(brake, state, 0);
    case LJ_WORK: return state->work;
    case LJ_HEAT: return state->heat;
    default: return lj_stored(brake, state);
    }
}

int lj_model_get(const lj_model *model, unsigned reference, double *value, char *text)
{
    lj_brake brake;
    lj_state state;
    if (reference == LJ_TIME)
        *value = model->time;
    else if (reference >= LJ_FIRST_PARAMETER && reference < LJ_FIRST_PARAMETER + LJ_PARAMETERS)
        *value = model->parameter[reference - LJ_FIRST_PARAMETER];
    else if (reference >= LJ_FIRST_INPUT && reference < LJ_FIRST_INPUT + LJ_INPUTS)
        *value = input(model, reference);
    else if (reference == LJ_TURNING)
        *value = input(model, LJ_VELOCITY);
    else if (reference >= LJ_FIRST_OUTPUT && reference < LJ_FIRST_OUTPUT + LJ_OUTPUTS) {
        if (ask(model, &brake, &state, text))
            return 1;
        *value = output_of(&brake, &state, reference);
    } else {
        return lj_model_mismatch(reference, "a function for numbers", text);
    }
    return 0;
}

int lj_model_flag(const lj_model *model, unsigned reference, int *value, char *text)
{
    static const uint32_t bit[LJ_FLAGS] = {LJ_SLACK, LJ_SEPARATED, LJ_CLOSED, LJ_SNAPPED,
                                           LJ_OVERFLOW};
    if (reference < LJ_FIRST_FLAG || reference >= LJ_FIRST_FLAG + LJ_FLAGS)
        return lj_model_mismatch(reference, "a function for Booleans", text);
    *value = (model->published & bit[reference - LJ_FIRST_FLAG]) != 0;
    return 0;
}

/* ---- steps ---- */

int lj_model_enter(lj_model *model, char *text)
{
    if (model->phase != LJ_MADE)
        return say(text, "initialization", "the instance is past it; reset it first");
    model->phase = LJ_INITIALIZING;
    return 0;
}

int lj_model_start(lj_model *model, char *text)
{
    lj_brake brake;
    lj_state state;
    if (model->phase != LJ_INITIALIZING)
        return say(text, "initialization", "it was not entered");
    if (ask(model, &brake, &state, text))
        return 1;
    model->brake = brake;
    model->state = state;
    model->published = state.flags;
    model->phase = LJ_RUNNING;
    model->asked = 0;
    return 0;
}

static int is_running(const lj_model *model, char *text)
{
    if (model->phase != LJ_RUNNING)
        return !say(text, "step", "the instance is not running; initialize it first");
    return 1;
}

int lj_model_step(lj_model *model, double time, double length, char *text)
{
    lj_state state = model->state;
    double end = input(model, LJ_ELONGATION) + input(model, LJ_VELOCITY) * length;
    if (!is_running(model, text))
        return 1;
    if (!(length > 0 && length <= DBL_MAX)) {
        snprintf(text, LJ_MESSAGE, "step: %.9g s is not allowed; above zero and finite", length);
        return 1;
    }
    if (!is_finite(&end, 1))
        return say(text, "velocity", "velocity times step is too large to compute with");
    if (model->asked && move(model, &model->brake, &state, input(model, LJ_ELONGATION), text))
        return 1;
    if (move(model, &model->brake, &state, end, text))
        return 1;
    model->state = state;
    model->published = state.flags;
    model->input[LJ_ELONGATION - LJ_FIRST_INPUT] = end;
    model->time = time + length;
    model->asked = 0;
    return 0;
}

int lj_model_commit(lj_model *model, int *changed, char *text)
{
    lj_brake brake;
    lj_state state;
    if (!is_running(model, text) || ask(model, &brake, &state, text))
        return 1;
    model->state = state;
    model->asked = 0;
    *changed = state.flags != model->published;
    return 0;
}

/* ---- slopes ---- */

int lj_model_slope(const lj_model *model, unsigned output, unsigned of, double *slope, char *text)
{
    lj_brake brake;
    lj_state state, near;
    double steep, step;
    if (output < LJ_FIRST_OUTPUT || output >= LJ_FIRST_OUTPUT + LJ_OUTPUTS)
        return lj_model_mismatch(output, "a slope of an output", text);
    if (of < LJ_FIRST_INPUT || of >= LJ_FIRST_INPUT + LJ_INPUTS)
        return lj_model_mismatch(of, "a slope over an input", text);
    if (ask(model, &brake, &state, text))
        return 1;
    *slope = 0;
    if (of == LJ_VELOCITY)
        return 0;
    steep = of == LJ_ELONGATION ? lj_tangent(&brake, &state, 0)
                                : lj_vacuum_tangent(&brake, &state, 0);
    if (output == LJ_FORCE)
        *slope = steep;
    else if (output == LJ_SLIP && !(state.flags & LJ_SLACK))
        *slope = (of == LJ_ELONGATION ? 1 : 0) - steep / brake.stiffness;
    else if (output == LJ_WORK && of == LJ_ELONGATION)
        *slope = state.force;
    else if (output != LJ_SLIP && output != LJ_WORK) {
        /* the rest by a short step on, or down where the vacuum is meant: no closed form pays */
        near = state;
        step = of == LJ_ELONGATION ? (state.motion == LJ_INWARD ? -1e-7 : 1e-7) : -1.0;
        if (of == LJ_ELONGATION)
            lj_move(&brake, &near, state.elongation + step, state.vacuum, 0);
        else if (state.vacuum > 1)
            lj_move(&brake, &near, state.elongation, state.vacuum + step, 0);
        *slope = (output_of(&brake, &near, output) - output_of(&brake, &state, output)) / step;
    }
    return 0;
}

/* ---- snapshots ---- */

int lj_model_keep(const lj_model *model, void **kept, char *text)
{
    if (*kept == NULL)
        *kept = malloc(sizeof *model);
    if (*kept == NULL)
        return say(text, "state", "no memory left");
    memcpy(*kept, model, sizeof *model);
    return 0;
}

int lj_model_pack(const void *kept, unsigned char *bytes, size_t length, char *text)
{
    uint64_t size = sizeof(lj_model);
    if (length < LJ_MODEL_BYTES)
        return say(text, "state", "more bytes are needed");
    memcpy(bytes, MAGIC, sizeof MAGIC);
    memcpy(bytes + 8, &size, sizeof size);
    memcpy(bytes + 16, kept, sizeof(lj_model));
    return 0;
}

/* Refuse what no instance can have become, and derive what follows from the parameters again. */
static int check_snapshot(lj_model *model, char *text)
{
    static const char damaged[] = "the bytes of the state are damaged";
    const char *fault = lj_state_fault(&model->state);
    unsigned i;
    if (fault == NULL && (model->phase < LJ_MADE || model->phase > LJ_ENDED || (unsigned)model->asked > 1))
        fault = "an unknown phase";
    if (fault != NULL) {
        snprintf(text, LJ_MESSAGE, "state: the bytes are damaged: %s", fault);
        return 1;
    }
    for (i = 0; i < LJ_PARAMETERS; i++)
        if (!is_finite(&model->parameter[i], 1) || !is_finite(&model->exported[i], 1))
            return say(text, lj_parameters[i].name, damaged);
    for (i = 0; i < LJ_INPUTS; i++)
        if (!is_finite(&model->input[i], 1) || model->input[LJ_VACUUM - LJ_FIRST_INPUT] < 0)
            return say(text, lj_names[LJ_FIRST_INPUT + i], damaged);
    if (!is_finite(&model->time, 1))
        return say(text, "time", damaged);
    if (model->phase < LJ_RUNNING)
        return 0;
    if (check_parameters(model, text))
        return 1;
    brake_of(&model->brake, model->parameter);
    return 0;
}

int lj_model_unpack(void **kept, const unsigned char *bytes, size_t length, char *text)
{
    lj_model model;
    uint64_t size = 0;
    if (length >= 16)
        memcpy(&size, bytes + 8, sizeof size);
    if (length != LJ_MODEL_BYTES || memcmp(bytes, MAGIC, sizeof MAGIC) != 0 || size != sizeof model)
        return say(text, "state", "these bytes are not a state of this FMU");
    memcpy(&model, bytes + 16, sizeof model);
    if (check_snapshot(&model, text))
        return 1;
    return lj_model_keep(&model, kept, text);
}
