/* A brake as a functional mock-up unit, whatever the version of the standard. Apache License 2.0.
 *
 * It has no states of its own between two steps but the brake's: asking for a force never changes
 * it, so an importer may set inputs and ask as often as it likes before it commits a step.
 */
#ifndef LAYERJAM_MODEL_H
#define LAYERJAM_MODEL_H

#include <stddef.h>

#include "layerjam.h"
#include "variables.h"

enum { LJ_MADE, LJ_INITIALIZING, LJ_RUNNING, LJ_ENDED };

/* All that one instance is, as plain data. */
typedef struct {
    double parameter[LJ_PARAMETERS];
    double exported[LJ_PARAMETERS]; /* the brake that was exported */
    double input[LJ_INPUTS];
    double time;
    lj_brake brake;
    lj_state state;     /* as last committed */
    uint32_t published; /* flags as an importer may see them between two events */
    int phase;
    int asked; /* an input has been set since the last step was committed */
} lj_model;

/* Messages go to `text`, of LJ_MESSAGE characters; every function returns 0, or 1 with a message. */
#define LJ_MESSAGE 240

int lj_model_make(lj_model *model, const char *folder, char *text);
int lj_model_set(lj_model *model, unsigned reference, double value, char *text);
/* Say that a function is not for a variable. */
int lj_model_mismatch(unsigned reference, const char *function, char *text);

int lj_model_get(const lj_model *model, unsigned reference, double *value, char *text);
int lj_model_flag(const lj_model *model, unsigned reference, int *value, char *text);
int lj_model_enter(lj_model *model, char *text);
int lj_model_start(lj_model *model, char *text);

/* Go to the elongation that the velocity leads to. */
int lj_model_step(lj_model *model, double time, double length, char *text);

/* Accept the inputs as the end of a step; true in `changed` if a flag is another one now. */
int lj_model_commit(lj_model *model, int *changed, char *text);

/* Slope of an output over an input, at the inputs as set. */
int lj_model_slope(const lj_model *model, unsigned output, unsigned input, double *slope,
                   char *text);

void lj_model_reset(lj_model *model);

/* The bytes of a copy, and back; LJ_MODEL_BYTES of them. */
#define LJ_MODEL_BYTES (sizeof(lj_model) + 16)
int lj_model_pack(const void *kept, unsigned char *bytes, size_t length, char *text);
int lj_model_unpack(void **kept, const unsigned char *bytes, size_t length, char *text);

/* A copy in `kept`, in memory of its own where there is none yet. */
int lj_model_keep(const lj_model *model, void **kept, char *text);

#endif
