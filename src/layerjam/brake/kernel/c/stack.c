/* Stacks of sheets, one sheet at a time, for Python; no part of the exported kernel.
 * Apache License 2.0.
 *
 * The loops are printed from Python. Nothing is contracted, so both compute the same bits. */

#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC optimize("O3")
#endif

#include <math.h>
#include <stdint.h>

/* Minimum and maximum as in Python, also for NaN. */
static inline double lj_min(double a, double b) { return b < a ? b : a; }
static inline double lj_max(double a, double b) { return b > a ? b : a; }

#include "stack_loops.h"
