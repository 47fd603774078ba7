/* The exact stop of layerjam/mechanics/stop.py as one would write it in C, all six answers.

   In w = sqrt(slip) the kinetic energy is a quartic; its first root is found by three steps that
   follow slope and curvature, and polished by one Newton step. The loop has no branch, so that the
   compiler makes vector code of it; the few drops that have not settled are done again, by Newton
   steps kept in their bracket. */
#include <math.h>

#define INLINE static inline __attribute__((always_inline))

enum { STOPPED, NEVER_SLID, BOTTOMED_OUT, SNAPS };
enum { BLOCK = 1024 };

typedef struct {
    double friction;  /* c / vacuum [N/m/Pa] */
    double overlap;   /* L2 [m] */
    double travel;    /* usable travel [m] */
    double stiffness; /* EA of one face of the sleeve [N] */
    double drag;      /* q / vacuum [N/m/Pa] */
    double reach;     /* l [m] */
    double spring;    /* rope and brake in series [N/m] */
    double gravity;   /* [m/s^2] */
} Brake;

typedef struct {
    double a0, a1, a2, a3, a4;
} Quartic;

/* Constants of one stop. */
typedef struct {
    double m, p, v, c, q, k, rise, step, root, saturation, onset, weight, elastic, start, snap;
} Setup;

/* Between which slips the first root lies, and the root in w = sqrt(slip). */
typedef struct {
    Quartic energy;
    double low, high, root;
    int slides, stops, settled;
} Search;

typedef struct {
    double slip, peak, end_speed, heat, stored;
    int outcome;
} Answer;

/* libm's fmin and fmax are calls, too */
INLINE double least(double a, double b) { return a < b ? a : b; }
INLINE double most(double a, double b) { return a > b ? a : b; }

INLINE double value(Quartic p, double w)
{
    return p.a0 + w * (p.a1 + w * (p.a2 + w * (p.a3 + w * p.a4)));
}

INLINE double slope(Quartic p, double w)
{
    return p.a1 + w * (2 * p.a2 + w * (3 * p.a3 + w * 4 * p.a4));
}

INLINE double curvature(Quartic p, double w)
{
    return 2 * p.a2 + w * (6 * p.a3 + w * 12 * p.a4);
}

INLINE double curved(Quartic p, double w, double low, double high)
{
    double now = value(p, w), first = slope(p, w), second = curvature(p, w);
    double down = sqrt(most(first * first - 2 * now * second, 0)) - first;
    return least(most(w + 2 * now / (down > 0 ? down : 1), low), high);
}

static double bracketed(Quartic p, double low, double high)
{
    double w = (low + high) / 2;
    for (int i = 0; i < 100; i++) {
        double now = value(p, w);
        low = now > 0 ? w : low;
        high = now > 0 ? high : w;
        double next = w - now / slope(p, w);
        if (!(next > low && next < high))
            next = (low + high) / 2;
        if (next == w)
            break;
        w = next;
    }
    return w;
}

/* Slip at which the falling force meets the weight, or `travel` if that comes first. */
INLINE double falling_balance(double over, Setup a, double travel)
{
    const double square = a.root * a.root + 4 * a.c * over, fall = a.c - a.rise;
    const double w = (a.root + sqrt(most(square, 0))) / (a.c > 0 ? 2 * a.c : 1), spread = w * w;
    const double whole = (over + a.step) / (fall > 0 ? fall : 1);
    const int falls = a.c > 0 && square >= 0 && (fall > 0 || spread < a.saturation);
    return least(falls ? most(spread < a.saturation ? spread : whole, 0) : travel, travel);
}

INLINE Setup setup(double m, double v, double p, Brake at)
{
    const double c = at.friction * p, q = at.drag * p, k = at.spring, step = q * at.reach;
    const double root = 2 * sqrt(at.stiffness * q), saturation = step * at.reach / at.stiffness;
    const double onset = c * at.overlap, weight = m * at.gravity;
    const double elastic = weight + sqrt(weight * weight + k * m * v * v);
    const double start = m * v * v / 2 + (weight * onset - onset * onset / 2) / k;
    /* on a spring softer than the fall of the force the brake runs on by itself */
    const double wild = root / (c > k ? 2 * (c - k) : 1), snap = c > k ? wild * wild : INFINITY;
    return (Setup){m, p, v, c, q, k, at.stiffness / at.reach, step, root, saturation, onset,
                   weight, elastic, start, snap};
}

INLINE Search search(Setup a, Brake at)
{
    const double over = a.weight - a.onset, fall = a.c - a.rise, k = a.k;
    const Quartic spreads = {
        a.start, over * a.root / k, over - over * a.c / k - a.root * a.root / (2 * k),
        (a.c / k - 2.0 / 3) * a.root, (a.c - a.c * a.c / k) / 2,
    };
    const Quartic whole = {
        a.start + a.step * a.saturation / 6 + (over - a.step / 2) * a.step / k, 0,
        over - a.step + (a.step - over) * fall / k, 0, (fall - fall * fall / k) / 2,
    };
    const double end = least(falling_balance(-over, a, at.travel), a.snap);
    const double edge = least(a.saturation, end), edge_w = sqrt(edge), end_w = sqrt(end);
    const int beyond = value(spreads, edge_w) > 0 && edge < end;
    const Quartic e = {
        beyond ? whole.a0 : spreads.a0, beyond ? whole.a1 : spreads.a1,
        beyond ? whole.a2 : spreads.a2, beyond ? whole.a3 : spreads.a3,
        beyond ? whole.a4 : spreads.a4,
    };
    const double low = beyond ? edge_w : 0, high = beyond ? end_w : edge_w;
    /* from the root without a sleeve */
    const double bend = sqrt(most(e.a2 * e.a2 - 4 * e.a0 * e.a4, 0)) - e.a2;
    const double near = sqrt(most(2 * e.a0 / (bend > 0 ? bend : 1), 0));
    const double first = curved(e, least(most(near, low), high), low, high);
    const double second = curved(e, first, low, high), w = curved(e, second, low, high);
    return (Search){e, low, high, w, a.elastic > a.onset, value(e, high) <= 0,
                    fabs(w - second) <= 1e-5 * high};
}

INLINE Answer answer(Setup a, Search found, Brake at)
{
    const double falls = slope(found.energy, found.root), now = value(found.energy, found.root);
    const double w = most(found.root - (falls < 0 ? now / falls : 0), 0);
    const int slides = found.slides, stops = found.stops;
    const double far = least(at.travel, a.snap), s = slides ? (stops ? w * w : far) : 0;
    const double begin = least(s, a.saturation), begin_w = sqrt(begin), after = s - begin;
    const double third = a.root * begin * begin_w / 3, whole = s > 0 ? a.rise * s + a.step : 0;
    const double pull = s < a.saturation ? a.root * begin_w : whole;
    const double resist = a.onset - a.c * s + pull, more = resist - a.onset;
    const double sheets = a.onset * s - a.c * s * s / 2;
    const double work = sheets + 2 * third + (a.rise * (s + begin) / 2 + a.step) * after;
    const double spring = ((a.weight - a.onset) * more - more * more / 2) / a.k;
    const double left = stops || !slides ? 0 : most(a.start + a.weight * s - work + spring, 0);
    const double top = a.root / (a.c > 0 ? 2 * a.c : 1);
    const double bulge = top * top < begin && a.c > 0 ? a.root * top / 2 : 0;
    const double highest = most(most(resist, a.onset + bulge), a.onset);
    const double face = pull / 2, force = slides ? resist : a.elastic, step = a.step;
    const double full = 2 * at.reach * (face * face - face * step + step * step / 3) / at.stiffness;
    const double sleeve = s < a.saturation ? third : (s > 0 ? full : 0);
    const int fine = a.m > 0 && a.v >= 0 && a.p >= 0;
    return (Answer){
        fine ? s : NAN,
        fine ? (slides ? highest : a.elastic) : NAN,
        fine ? sqrt(2 * left / a.m) : NAN,
        fine ? sheets + third + step * after : NAN,
        fine ? force * force / (2 * a.k) + sleeve : NAN,
        slides ? (stops ? STOPPED : (a.snap < at.travel ? SNAPS : BOTTOMED_OUT)) : NEVER_SLID,
    };
}

INLINE void put(Answer a, long i, double *slip, double *peak, double *end_speed, double *heat,
                double *stored, int *outcome)
{
    slip[i] = a.slip;
    peak[i] = a.peak;
    end_speed[i] = a.end_speed;
    heat[i] = a.heat;
    stored[i] = a.stored;
    outcome[i] = a.outcome;
}

void stop(long n, const double *restrict mass, const double *restrict speed,
          const double *restrict vacuum, const Brake *brake, double *restrict slip,
          double *restrict peak, double *restrict end_speed, double *restrict heat,
          double *restrict stored, int *restrict outcome)
{
    const Brake at = *brake;
#pragma omp parallel for schedule(static) if (n > 4 * BLOCK)
    for (long from = 0; from < n; from += BLOCK) {
        const long to = from + BLOCK < n ? from + BLOCK : n;
        int unsettled = 0;
#pragma omp simd reduction(+ : unsettled)
        for (long i = from; i < to; i++) {
            const Setup a = setup(mass[i], speed[i], vacuum[i], at);
            const Search found = search(a, at);
            unsettled += found.slides & found.stops & !found.settled;
            put(answer(a, found, at), i, slip, peak, end_speed, heat, stored, outcome);
        }
        for (long i = from; unsettled && i < to; i++) {
            const Setup a = setup(mass[i], speed[i], vacuum[i], at);
            Search found = search(a, at);
            if (found.slides && found.stops && !found.settled) {
                found.root = bracketed(found.energy, found.low, found.high);
                put(answer(a, found, at), i, slip, peak, end_speed, heat, stored, outcome);
            }
        }
    }
}
