/* A whole history in one call, for Python; no part of the exported kernel. Apache License 2.0. */

#include "history.h"

int lj_state_size(void) { return (int)sizeof(lj_state); }

const char *lj_fault(const lj_state *state) { return lj_state_fault(state); }

void lj_history(const lj_brake *brake, lj_state *state, int64_t count, const lj_real *elongation,
                const lj_real *vacuum, lj_row *rows)
{
    int64_t i;
    for (i = 0; i < count; i++) {
        lj_row *row = &rows[i];
        lj_move(brake, state, elongation[i], vacuum[i], 0);
        row->force = state->force;
        row->slip = state->slip;
        row->enclosure_force = state->enclosure_force;
        row->work = state->work;
        row->heat = state->heat;
        row->stored = lj_stored(brake, state);
        row->flags = state->flags;
        row->turns = (state->count - 1u) / 2;
    }
}
