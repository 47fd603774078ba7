/* Random brakes and inputs, numbers that are none among them: what must hold whatever is given.
 * Compiled with the address and undefined-behaviour sanitizers. Usage: fuzz BRAKES MOVES SEED */

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "layerjam.h"

static unsigned long long seed;

static double share(void)
{
    seed = seed * 6364136223846793005ull + 1442695040888963407ull;
    return (double)(seed >> 11) / 9007199254740992.0;
}

static lj_real spread(double low, double high)
{
    return (lj_real)(low * pow(high / low, share()));
}

static lj_real odd(lj_real plain)
{
    static const double odds[] = {NAN, INFINITY, -INFINITY, 1e300, -1e300,
                                  1e-300, -1, 0, 1e30, -0.0};
    return share() < 0.002 ? (lj_real)odds[(int)(share() * 10)] : plain;
}

static void fail(const char *what, const lj_brake *b, const lj_state *s, int move)
{
    printf("%s at move %d: force %g slip %g heat %g flags %x; brake %g %g %g %g %g %g %g %g\n", what,
           move, (double)s->force, (double)s->slip, (double)s->heat, (unsigned)s->flags,
           (double)b->contact, (double)b->overlap, (double)b->stiffness,
           (double)b->enclosure_stiffness, (double)b->enclosure_contact, (double)b->reach,
           (double)b->exponent, (double)b->test_pressure);
    exit(1);
}

int main(int count, char **words)
{
    int brakes = count > 1 ? atoi(words[1]) : 100, moves = count > 2 ? atoi(words[2]) : 2000, i, j;
    long refused = 0, snapped = 0, parted = 0, overflowed = 0;
    seed = count > 3 ? (unsigned long long)atoll(words[3]) : 1;
    for (i = 0; i < brakes; i++) {
        lj_brake b;
        lj_state s, before;
        lj_real u = 0, vacuum = 0;
        int loops = share() < 0.2; /* ever smaller ones, one inside the other */
        double size = (double)spread(1e-4, 10);
        b.contact = spread(1e-4, 1);
        b.overlap = spread(0.01, 0.2);
        b.stiffness = spread(100, 1e7);
        b.enclosure_stiffness = spread(1e-3, 100);
        b.enclosure_contact = spread(1e-4, 0.1);
        b.reach = spread(0.005, 0.2);
        b.exponent = share() < 0.5 ? 0 : (lj_real)(1.5 * share() - 0.5);
        b.test_pressure = spread(1e3, 1e5);
        if (lj_check(&b))
            fail("a brake refused", &b, &s, 0);
        lj_start(&s, 0);
        for (j = 0; j < moves; j++) {
            double middle = size * (double)b.overlap, swing = pow(0.9, j % 60) * (j % 2 ? 1 : -1);
            lj_real wander = (lj_real)(0.8 * (double)u + middle * (share() - 0.3));
            lj_real given = odd(u = loops ? (lj_real)(middle * (1 + 0.9 * swing)) : wander);
            lj_real compliance = odd(share() < 0.1 ? spread(1e-9, 1e-2) : 0), force;
            if (share() < (loops ? 0.002 : 0.1))
                vacuum = share() < 0.2 ? 0 : (lj_real)(1e5 * share() * share());
            before = s;
            force = lj_move(&b, &s, given, odd(vacuum), compliance);
            if (s.flags & LJ_REFUSED) {
                refused++;
                before.flags |= LJ_REFUSED;
                if (memcmp(&before, &s, sizeof s) || force < s.force || force > s.force)
                    fail("a refused move changed something", &b, &s, j);
                continue;
            }
            if (!(force >= 0) || !isfinite(force))
                fail("force", &b, &s, j);
            if (!(s.slip >= 0) || !isfinite(s.slip))
                fail("slip", &b, &s, j);
            if (lj_state_fault(&s))
                fail(lj_state_fault(&s), &b, &s, j);
            if (!(s.heat >= before.heat))
                fail("heat falls", &b, &s, j);
            if (!isfinite(s.work) || !isfinite(lj_tangent(&b, &s, 0)))
                fail("work or slope", &b, &s, j);
            if (!isfinite(lj_vacuum_tangent(&b, &s, 0)))
                fail("slope over vacuum", &b, &s, j);
        }
        snapped += (s.flags & LJ_SNAPPED) != 0;
        parted += (s.flags & LJ_SEPARATED) != 0;
        overflowed += (s.flags & LJ_OVERFLOW) != 0;
    }
    printf("refused %ld snapped %ld parted %ld overflowed %ld\n", refused, snapped, parted,
           overflowed);
    return 0;
}
