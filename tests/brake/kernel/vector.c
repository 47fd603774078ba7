/* Four thousand moves with changing vacuum; prints a checksum of every double of every state. */

#include <stdio.h>
#include <string.h>

#include "layerjam.h"

static uint32_t seed = 2018;

static lj_real random_share(void)
{
    seed = seed * 1664525u + 1013904223u;
    return (lj_real)(seed >> 8) / (lj_real)16777216;
}

int main(void)
{
    const lj_brake brake = {(lj_real)0.0273, (lj_real)0.068, 131000, (lj_real)1.3, (lj_real)0.0104,
                            (lj_real)0.045, 0, 1};
    lj_state state;
    uint32_t sum = 2166136261u;
    lj_real vacuum = 0;
    int i;
    size_t j;
    lj_start(&state, 0);
    for (i = 0; i < 4000; i++) {
        unsigned char bytes[sizeof state];
        lj_real elongation = (lj_real)0.06 * random_share();
        if (random_share() < (lj_real)0.2)
            vacuum = 94500 * random_share() * random_share();
        lj_move(&brake, &state, elongation, vacuum, 0);
        memcpy(bytes, &state, sizeof bytes);
        for (j = 0; j < sizeof bytes; j++)
            sum = (sum ^ bytes[j]) * 16777619u;
        if (i % 800 == 799)
            printf("%d %08lx\n", i, (unsigned long)sum);
    }
    printf("%.17g N %.17g mm\n", (double)state.force, 1e3 * (double)state.slip);
    return 0;
}
