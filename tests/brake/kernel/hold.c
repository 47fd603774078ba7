/* Ten million calls under a load just below what friction holds: no bit of the memory may change.
 * Prints what was found; test_hold.py reads it. Usage: hold CALLS */

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "layerjam.h"

static const lj_brake brake = {(lj_real)0.0273, (lj_real)0.068, 131000, (lj_real)1.3,
                               (lj_real)0.0104, (lj_real)0.045, 0,      1};
static const lj_real vacuum = 94500;

/* Whether everything is as it was; external work aside, which a load that swings does. */
static const char *compared(const lj_state *now, lj_state before, int swings)
{
    if (swings)
        before.work = now->work;
    return memcmp(now, &before, sizeof before) ? "changed" : "same";
}

/* Call with one input, then swing between it and half of it. */
static void hold(const char *name, lj_state *s, lj_real elongation, lj_real half, int calls)
{
    lj_state before = *s;
    int i;
    for (i = 0; i < calls; i++)
        lj_move(&brake, s, elongation, vacuum, 0);
    printf("%s held %s\n", name, compared(s, before, 0));
    for (i = 0; i < calls; i++) {
        lj_move(&brake, s, half, vacuum, 0);
        lj_move(&brake, s, elongation, vacuum, 0);
    }
    before.motion = s->motion; /* the last move of a swing is none of the brake's */
    printf("%s swung %s\n", name, compared(s, before, 1));
}

int main(int count, char **words)
{
    const lj_real onset = brake.contact * vacuum * brake.overlap / brake.stiffness;
    int calls = count > 1 ? atoi(words[1]) : 1000;
    lj_state s;
    lj_real start;
    lj_start(&s, 0);
    lj_move(&brake, &s, onset * (lj_real)0.999, vacuum, 0);
    hold("rest", &s, onset * (lj_real)0.999, onset / 2, calls);
    printf("rest slip %.17g\n", (double)s.slip);
    lj_move(&brake, &s, onset * (lj_real)1.001, vacuum, 0);
    printf("above slip %.17g\n", (double)s.slip);

    start = (lj_real)0.02; /* after it slid, and came back by a tenth of what it holds */
    lj_move(&brake, &s, start, vacuum, 0);
    hold("slid", &s, start, start - onset / 10, calls);
    return 0;
}
