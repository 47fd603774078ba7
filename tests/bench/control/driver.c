/* Parts of the printed loops, for tests. */

#include "loops.c"

void lj_test_step(const double *settings, const double *state, double value, double target,
                  double *out)
{
    lj_step(settings, state, value, target, out);
}

void lj_test_factors(const lj_rates *plant, double pump, double vent, double dt, double lag,
                     double left, double *out)
{
    lj_step_factors(plant, pump, vent, dt, lag, left, out);
}

void lj_test_noise(uint64_t key, int64_t first, int64_t count, const double *edges,
                   const double *inner, double *out)
{
    lj_layers layers = {edges, inner};
    for (int64_t i = 0; i < count; i++) {
        out[i] = lj_normal(key, first + i, &layers);
    }
}

uint64_t lj_test_mix(uint64_t word) { return lj_mix_bits(word); }
