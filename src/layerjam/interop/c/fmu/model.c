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

int lj_model_set(lj_model *model, unsigned reference, double value, char *text)
{
    if (!(value >= -DBL_MAX && value <= DBL_MAX)) {
        snprintf(text, LJ_MESSAGE, "variable %u: not a finite number", reference);
        return 1;
    }
    if (reference >= LJ_FIRST_PARAMETER && reference < LJ_FIRST_PARAMETER + LJ_PARAMETERS) {
        const char *name = lj_parameters[reference - LJ_FIRST_PARAMETER].name;
        if (model->phase > LJ_INITIALIZING)
            return say(text, name, "a parameter cannot be set while the simulation runs");
        model->parameter[reference - LJ_FIRST_PARAMETER] = value;
        return 0;
    }
    if (reference < LJ_FIRST_INPUT || reference >= LJ_FIRST_INPUT + LJ_INPUTS) {
        snprintf(text, LJ_MESSAGE, "variable %u: neither a parameter nor an input, cannot be set",
                 reference);
        return 1;
    }
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
        return say(text, "elongation or vacuum", "too large to compute with");
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
        snprintf(text, LJ_MESSAGE, "variable %u: no number of this brake", reference);
        return 1;
    }
    return 0;
}

int lj_model_flag(const lj_model *model, unsigned reference, int *value, char *text)
{
    static const uint32_t bit[LJ_FLAGS] = {LJ_SLACK, LJ_SEPARATED, LJ_CLOSED, LJ_SNAPPED,
                                           LJ_OVERFLOW};
    if (reference < LJ_FIRST_FLAG || reference >= LJ_FIRST_FLAG + LJ_FLAGS) {
        snprintf(text, LJ_MESSAGE, "variable %u: no Boolean of this brake", reference);
        return 1;
    }
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
    if (!(end >= -DBL_MAX && end <= DBL_MAX))
        return say(text, "elongation", "velocity times step is too large to compute with");
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
    if (output < LJ_FIRST_OUTPUT || output >= LJ_FIRST_OUTPUT + LJ_OUTPUTS ||
        of < LJ_FIRST_INPUT || of >= LJ_FIRST_INPUT + LJ_INPUTS) {
        snprintf(text, LJ_MESSAGE, "slope of variable %u over %u: an output over an input is due",
                 output, of);
        return 1;
    }
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

int lj_model_unpack(void **kept, const unsigned char *bytes, size_t length, char *text)
{
    lj_model model;
    uint64_t size = 0;
    if (length >= 16)
        memcpy(&size, bytes + 8, sizeof size);
    if (length != LJ_MODEL_BYTES || memcmp(bytes, MAGIC, sizeof MAGIC) != 0 || size != sizeof model)
        return say(text, "state", "these bytes are no state of this FMU");
    memcpy(&model, bytes + 16, sizeof model);
    return lj_model_keep(&model, kept, text);
}
