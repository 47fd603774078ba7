/* A whole history in one call, for Python; no part of the exported kernel. Apache License 2.0. */
#ifndef LAYERJAM_HISTORY_H
#define LAYERJAM_HISTORY_H

#include "layerjam.h"

typedef struct {
    lj_real force, slip, enclosure_force, work, heat, stored;
    uint32_t flags, turns; /* turns: the most remembered in either direction */
} lj_row;

/* Bytes of a state, by which Python's picture of it is checked. */
int lj_state_size(void);

/* lj_state_fault, to be called from Python. */
const char *lj_fault(const lj_state *state);

/* Move through `count` elongations [m] under as many vacuums [Pa]. */
void lj_history(const lj_brake *brake, lj_state *state, int64_t count, const lj_real *elongation,
                const lj_real *vacuum, lj_row *rows);

#endif
