/* A pull of 40 mm and back at 94.5 kPa, as comma-separated values. Apache License 2.0.
 *
 *     cc -std=c99 -O2 -ffp-contract=off example.c layerjam.c -lm -o example && ./example
 */

#include <stdio.h>

#include "brake.h"

int main(void)
{
    lj_state state;
    int i;
    lj_start(&state, 0);
    printf("elongation_mm,force_N,slip_mm\n");
    for (i = 0; i <= 80; i++) {
        lj_real elongation = (lj_real)(i <= 40 ? i : 80 - i) * (lj_real)1e-3;
        lj_real force = lj_move(&brake, &state, elongation, 94500, 0);
        printf("%.1f,%.4f,%.4f\n", 1e3 * (double)elongation, (double)force,
               1e3 * (double)state.slip);
    }
    return 0;
}
