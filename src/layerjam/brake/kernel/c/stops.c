/* Millions of exact stops in vector code, for Python; no part of the exported kernel.
 * Apache License 2.0.
 *
 * A block of drops goes through short loops without branches, one for each part of the printed
 * algebra. In one long loop each step depends on the one before, and processors cannot look far
 * enough ahead to start the next drops. Nothing is contracted, so all processors give the same
 * bits. */

#if defined(__clang__)
#define LJ_LOOP _Pragma("clang loop vectorize(assume_safety)")
#elif defined(__GNUC__)
#pragma GCC optimize("O3", "no-trapping-math")
#define LJ_LOOP _Pragma("GCC ivdep")
#else
#define LJ_LOOP
#endif
#if defined(__GNUC__)
#define LJ_INLINE static inline __attribute__((always_inline))
#else
#define LJ_INLINE static inline
#endif
/* GCC for Windows does not align the wide registers that it spills. */
#if defined(__x86_64__) && (defined(__clang__) || (defined(__GNUC__) && !defined(_WIN32)))
#include <cpuid.h>
#define LJ_X86
#endif

#include <stdint.h>

#define LJ(number) ((lj_real)(number))
#define LJ_INFINITY (1.0 / 0.0)

typedef double lj_real;
double sqrt(double);
#define lj_sqrt sqrt

LJ_INLINE lj_real lj_max(lj_real a, lj_real b) { return a > b ? a : b; }
LJ_INLINE lj_real lj_min(lj_real a, lj_real b) { return a < b ? a : b; }

#define inline inline __attribute__((always_inline))
#include "stop_formulas.h"
#undef inline

#define SETTLED 1e-5 /* share of the bracket; after so short a step the next one has no effect */
enum { BLOCK = 256, ROW = BLOCK + 8, STEPS = 3, MORE_STEPS = 5, INPUTS = 5, OUTPUTS = 6 };
enum { MASS, SPEED, VACUUM, SPRING, GRAVITY };
/* Of the brake: friction and drag of the enclosure per pascal [N/m/Pa]; the others in SI. */
enum { FRICTION, DRAG, OVERLAP, TRAVEL, STIFFNESS, REACH };

/* Rows of a block: the drops, where their results go, and values between the loops. A distance of
 * a power of two would leave the rows few lines of the cache. */
typedef struct {
    const double *in[INPUTS];
    double *out[OUTPUTS];
    double root[ROW], a0[ROW], a1[ROW], a2[ROW], a3[ROW], a4[ROW], low[ROW], high[ROW], stops[ROW];
    double limit[ROW], snaps[ROW], w[ROW], step[ROW];
} lj_block;

LJ_INLINE lj_case case_of(const lj_block *block, int i, const double *brake)
{
    double vacuum = block->in[VACUUM][i], stiffness = brake[STIFFNESS], reach = brake[REACH];
    lj_enclosure enclosure = {stiffness, brake[DRAG] * vacuum, reach, block->root[i],
                              brake[DRAG] * reach * reach / stiffness * vacuum};
    return lj_make_setup(block->in[MASS][i], block->in[SPEED][i], brake[FRICTION] * vacuum,
                         brake[OVERLAP], &enclosure, block->in[SPRING][i], block->in[GRAVITY][i]);
}

LJ_INLINE lj_bracket bracket_of(const lj_block *block, int i)
{
    lj_energy energy = {block->a0[i], block->a1[i], block->a2[i], block->a3[i], block->a4[i]};
    return (lj_bracket){energy, block->low[i], block->high[i], block->stops[i], block->limit[i],
                        block->snaps[i]};
}

/* Find the bracket of the root, and the quartic. */
LJ_INLINE void open_drop(lj_block *block, int i, const double *brake)
{
    lj_case drop;
    lj_bracket bracket;
    block->root[i] = 2 * sqrt(brake[STIFFNESS] * brake[DRAG] * block->in[VACUUM][i]);
    drop = case_of(block, i, brake);
    bracket = lj_bracket_root(&drop, brake[TRAVEL]);
    block->a0[i] = bracket.energy.a0;
    block->a1[i] = bracket.energy.a1;
    block->a2[i] = bracket.energy.a2;
    block->a3[i] = bracket.energy.a3;
    block->a4[i] = bracket.energy.a4;
    block->low[i] = bracket.low;
    block->high[i] = bracket.high;
    block->stops[i] = bracket.stops;
    block->limit[i] = bracket.limit;
    block->snaps[i] = bracket.snaps;
}

LJ_INLINE void guess_root(lj_block *block, int i)
{
    lj_bracket bracket = bracket_of(block, i);
    block->w[i] = lj_guess_root(&bracket.energy, bracket.low, bracket.high);
}

/* Step towards the root. */
LJ_INLINE void step_on(lj_block *block, int i)
{
    lj_bracket bracket = bracket_of(block, i);
    double before = block->w[i];
    double after = lj_curvature_step(&bracket.energy, before, bracket.low, bracket.high);
    block->w[i] = after;
    block->step[i] = lj_max(after - before, before - after);
}

/* The same unless the drop has settled: it never changes then, whatever else is in the block. */
LJ_INLINE void step_unless_settled(lj_block *block, int i)
{
    double before = block->w[i], length = block->step[i];
    step_on(block, i);
    block->w[i] = length > SETTLED * block->high[i] ? block->w[i] : before;
    block->step[i] = length > SETTLED * block->high[i] ? block->step[i] : length;
}

/* Take the last Newton step and write the results; NaN outside the domain. */
LJ_INLINE void end_drop(lj_block *block, int i, const double *brake)
{
    const double nan = 0 * LJ_INFINITY;
    lj_case drop = case_of(block, i, brake);
    lj_bracket bracket = bracket_of(block, i);
    double slope = lj_quartic_slope(&bracket.energy, block->w[i]), bad;
    lj_end end = lj_make_stop(&drop, &bracket, lj_polish_root(&bracket.energy, block->w[i], slope));
    bad = drop.mass > 0 ? 0 * drop.kinetic : nan; /* NaN if it is infinite */
    bad = block->in[SPEED][i] >= 0 ? bad : nan;
    bad = block->in[VACUUM][i] >= 0 ? bad : nan;
    bad = block->in[SPRING][i] > 0 ? bad : nan;
    bad = block->in[GRAVITY][i] >= 0 ? bad : nan;
    bad = drop.onset + block->root[i] >= 0 ? bad : nan;
    block->out[0][i] = end.slip + bad;
    block->out[1][i] = end.peak_force + bad;
    block->out[2][i] = end.end_speed + bad;
    block->out[3][i] = end.heat + bad;
    block->out[4][i] = end.stored + bad;
    block->out[5][i] = bad < 1 ? end.outcome : -1;
}

LJ_INLINE int count_unsettled(const lj_block *block, int size)
{
    int i, count = 0;
    for (i = 0; i < size; i++)
        count += block->step[i] > SETTLED * block->high[i];
    return count;
}

/* Solve all drops of a block; return the number of roots that have not settled. */
LJ_INLINE int solve(lj_block *block, int size, const double *brake)
{
    int i, n;
    LJ_LOOP
    for (i = 0; i < size; i++)
        open_drop(block, i, brake);
    LJ_LOOP
    for (i = 0; i < size; i++)
        guess_root(block, i);
    for (n = 0; n < STEPS; n++) {
        LJ_LOOP
        for (i = 0; i < size; i++)
            step_on(block, i);
    }
    for (n = 0; n < MORE_STEPS && count_unsettled(block, size); n++) {
        LJ_LOOP
        for (i = 0; i < size; i++)
            step_unless_settled(block, i);
    }
    LJ_LOOP
    for (i = 0; i < size; i++)
        end_drop(block, i, brake);
    return count_unsettled(block, size);
}

typedef int lj_solver(lj_block *block, int size, const double *brake);

static int solve_anywhere(lj_block *block, int size, const double *brake)
{
    return solve(block, size, brake);
}

#ifdef LJ_X86
__attribute__((target("avx2"))) static int solve_avx2(lj_block *block, int size,
                                                      const double *brake)
{
    return solve(block, size, brake);
}

__attribute__((target("avx2,avx512f,avx512dq,avx512bw,avx512vl"))) static int
solve_avx512(lj_block *block, int size, const double *brake)
{
    return solve(block, size, brake);
}
#endif

/* The solver for the widest registers that processor and system keep (Intel's manual, volume 1,
 * 14.7.1 and 15.2). */
static lj_solver *best_solver(void)
{
#ifdef LJ_X86
    const unsigned wide = bit_AVX512F | bit_AVX512DQ | bit_AVX512BW | bit_AVX512VL;
    unsigned a, b, c, d, kept, rest;
    if (!__get_cpuid(1, &a, &b, &c, &d) || !(c & bit_OSXSAVE))
        return solve_anywhere;
    __asm__("xgetbv" : "=a"(kept), "=d"(rest) : "c"(0));
    if ((kept & 6) != 6 || !__get_cpuid_count(7, 0, &a, &b, &c, &d) || !(b & bit_AVX2))
        return solve_anywhere;
    return (kept & 0xe6) == 0xe6 && (b & wide) == wide ? solve_avx512 : solve_avx2;
#else
    return solve_anywhere;
#endif
}

/* The values of an axis over `size` drops from `first` on: in place, or copied into a row. */
static const double *read_axis(double *row, const double *values, int64_t length, int64_t stride,
                               int64_t first, int size)
{
    int64_t place = first / stride % length, used = first % stride;
    int i = 0;
    if (stride == 1 && place + size <= length)
        return values + place;
    while (i < size) {
        int64_t left = length == 1 ? size : stride - used;
        int end = left < size - i ? i + (int)left : size;
        double value = values[place];
        for (; i < end; i++)
            row[i] = value;
        used = 0;
        place = place + 1 < length ? place + 1 : 0;
    }
    return row;
}

/* Solve `count` drops of a grid from drop `first` on. Of axis k, drop i has
 * values[k][i / strides[k] % lengths[k]]. Results go into the arrays of `out` that are not null;
 * `missed` is set to 1 where the root was not found. Return the number of such drops. */
int64_t lj_stops(int64_t first, int64_t count, const double *const *values, const int64_t *lengths,
                 const int64_t *strides, const double *brake, double *const *out, uint8_t *missed);

int64_t lj_stops(int64_t first, int64_t count, const double *const *values, const int64_t *lengths,
                 const int64_t *strides, const double *brake, double *const *out, uint8_t *missed)
{
    double rows[INPUTS][ROW], unused[ROW];
    lj_solver *solver = best_solver();
    lj_block block;
    int64_t start, lost = 0;
    int i, k;
    for (start = 0; start < count; start += BLOCK) {
        int size = count - start < BLOCK ? (int)(count - start) : BLOCK;
        for (k = 0; k < INPUTS; k++)
            block.in[k] = read_axis(rows[k], values[k], lengths[k], strides[k], first + start,
                                    size);
        for (k = 0; k < OUTPUTS; k++)
            block.out[k] = out[k] ? out[k] + start : unused;
        if (solver(&block, size, brake))
            for (i = 0; i < size; i++)
                if (block.step[i] > SETTLED * block.high[i]) {
                    missed[start + i] = 1;
                    lost++;
                }
    }
    return lost;
}
