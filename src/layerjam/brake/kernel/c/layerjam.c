/* The brake of layerjam.h: bookkeeping of turning points around formulas.h. Apache License 2.0. */

#include "layerjam.h"

#define LJ(number) ((lj_real)(number))

/* For speed, what every move needs stands in one piece and the rest out of its way; for size (-Os)
 * nothing stands there twice. */
#if !defined(__GNUC__) || !defined(__OPTIMIZE__)
#define LJ_OFTEN
#define LJ_SELDOM
#elif defined(__OPTIMIZE_SIZE__)
#define LJ_OFTEN __attribute__((noinline))
#define LJ_SELDOM
#else
#define LJ_OFTEN inline __attribute__((always_inline))
#define LJ_SELDOM __attribute__((noinline))
#endif

#ifdef LJ_SINGLE
float sqrtf(float);
float powf(float, float);
#define lj_sqrt sqrtf
#define lj_pow powf
#define LJ_NEAR LJ(1e-4) /* share within which two numbers count as equal */
#define LJ_FAR LJ(1e12)  /* a slip beyond everything */
#else
double sqrt(double);
double pow(double, double);
#define lj_sqrt sqrt
#define lj_pow pow
#define LJ_NEAR LJ(1e-9)
#define LJ_FAR LJ(1e40)
#endif

static lj_real lj_max(lj_real a, lj_real b) { return a > b ? a : b; }

static lj_real lj_min(lj_real a, lj_real b) { return a < b ? a : b; }

static lj_real lj_clip(lj_real x, lj_real low, lj_real high) { return lj_min(lj_max(x, low), high); }

static lj_real lj_abs(lj_real x) { return x < 0 ? -x : x; }

static lj_real lj_square(lj_real x) { return x * x; }

static int lj_differ(lj_real a, lj_real b) { return a < b || a > b; }

#include "formulas.h"

/* What resists during one move. */
typedef struct {
    lj_real c; /* friction of the sheets per overlap [N/m] */
    lj_real k; /* stiffness in front of it [N/m] */
    lj_real overlap, vacuum;
    lj_enclosure enclosure; /* only where something slides: its constants take a square root */
} lj_setting;

static LJ_OFTEN lj_enclosure enclosure_at(const lj_brake *brake, lj_real vacuum)
{
    return lj_make_enclosure(brake->enclosure_stiffness, brake->enclosure_contact * vacuum,
                             brake->reach);
}

static LJ_OFTEN lj_setting setting_of(const lj_brake *brake, const lj_state *state,
                                      lj_real vacuum, lj_real compliance)
{
    lj_setting at;
    at.c = state->flags & LJ_SEPARATED ? 0 : brake->contact * vacuum;
    if (at.c > 0 && lj_differ(brake->exponent, 0))
        at.c *= lj_pow(vacuum / brake->test_pressure, brake->exponent);
    at.k = brake->stiffness;
    if (compliance > 0)
        at.k /= 1 + brake->stiffness * compliance;
    at.overlap = brake->overlap;
    at.vacuum = vacuum;
    return at;
}

static LJ_OFTEN lj_real hold_of(lj_real slip, const lj_setting *at)
{
    return at->c * lj_max(at->overlap - slip, 0);
}

/* ---- the enclosure's memory: see mechanics/memory.py ---- */

/* The branch over one piece, in a move in one direction. */
typedef struct {
    lj_real direction; /* 1 out, -1 back */
    int place;         /* of the piece */
    lj_real near;      /* where the front enters it, a share of the length */
    lj_real start, force; /* where the branch would start, had the whole way been over this piece */
    lj_real strength;  /* change of friction that it moves against [N/m] */
    lj_real whole, full; /* slip [m] and change of force [N] over the whole length */
    lj_real end, end_force; /* with the front at the piece's far end; nowhere past the middle */
} lj_branch_over;

/* Over the piece at a place, with the front at its near end and slip and force there. */
static LJ_OFTEN void enter(lj_branch_over *over, const lj_state *s, lj_real slip, lj_real force,
                           const lj_enclosure *e)
{
    lj_real d = over->direction, near = over->near, far = s->ends[over->place];
    over->strength = over->place > 0 ? lj_abs(d * e->friction + s->slopes[over->place]) : 0;
    over->whole = over->strength * lj_square(e->reach) / e->stiffness;
    over->full = 2 * over->strength * e->reach;
    over->start = slip - d * over->whole * lj_square(near);
    over->force = force - d * over->full * near;
    over->end = over->start + d * over->whole * lj_square(far);
    over->end_force = over->force + d * over->full * far;
}

static LJ_OFTEN lj_branch_over first_branch(const lj_state *s, lj_real direction,
                                            const lj_enclosure *e)
{
    lj_branch_over over;
    int last = s->count - 1, goes_on = !lj_differ(s->slopes[last], -direction * e->friction);
    over.direction = direction;
    over.place = goes_on ? last - 1 : last;
    over.near = goes_on ? s->ends[last] : 0;
    enter(&over, s, s->slip, s->enclosure_force, e);
    return over;
}

static LJ_OFTEN void next_branch(lj_branch_over *over, const lj_state *s, const lj_enclosure *e)
{
    over->near = s->ends[over->place];
    over->place--;
    enter(over, s, over->end, over->end_force, e);
}

/* Stretch or let back to a slip, with work and heat. */
static void move_strip(lj_state *s, lj_real slip, const lj_enclosure *e)
{
    lj_real d = slip < s->slip ? LJ(-1) : LJ(1), at = s->slip, work = 0, area = 0, force, spread;
    lj_real share = 1;
    lj_branch_over over = first_branch(s, d, e);
    while (over.place > 0) {
        /* a loop that closes but for rounding is closed */
        lj_real short_of = d * (over.end - slip), rounding = LJ_NEAR * d * (over.end - over.start);
        int passes = short_of <= rounding || !(over.whole > 0);
        lj_real to = short_of > 0 ? slip : over.end;
        share = s->ends[over.place];
        if (short_of > 0 && over.whole > 0)
            share = lj_clip(lj_sqrt(lj_max(d * (to - over.start), 0) / over.whole), over.near, share);
        /* slipped area and work rise with the third power of the share */
        spread = over.whole * (share * share * share - over.near * over.near * over.near);
        spread *= LJ(1) / LJ(3);
        work += over.force * (to - at) + 2 * over.full * spread;
        area += 2 * e->reach * spread;
        at = to;
        if (!passes)
            break;
        next_branch(&over, s, e);
    }
    force = over.force + d * over.full * share;
    if (over.place == 0) { /* the whole strip moves */
        force = over.force + e->stiffness * (slip - at) / e->reach;
        work += (over.force + force) / 2 * (slip - at);
        area += e->reach * d * (slip - at);
        share = 1;
    }
    area *= e->friction;
    s->slip = slip;
    s->enclosure_force = force;
    s->ends[over.place + 1] = share;
    s->slopes[over.place + 1] = -d * e->friction;
    s->count = (uint8_t)(over.place + 2);
    s->enclosure_stored += work - area;
    s->heat += area;
}

/* Length of a piece; its near end is the far end of the next one. */
static lj_real length_of(const lj_state *s, int place, const lj_enclosure *e)
{
    lj_real near = place < s->count - 1 ? s->ends[place + 1] : 0;
    return (s->ends[place] - near) * e->reach;
}

/* Elastic energy of the pieces. */
static lj_real strip_energy(const lj_state *s, const lj_enclosure *e)
{
    lj_real near = s->enclosure_force, energy = 0;
    int i;
    for (i = s->count - 1; i > 0; i--) {
        lj_real length = length_of(s, i, e), rise = 2 * s->slopes[i] * length;
        energy += length * (lj_square(near) + near * rise + lj_square(rise) / 3);
        near += rise;
    }
    return energy / (2 * e->stiffness);
}

/* Book what new pieces store less than the old ones as heat. */
static void settle(lj_state *s, lj_real before, const lj_enclosure *e)
{
    lj_real lost = lj_max(before - strip_energy(s, e), 0);
    s->enclosure_stored -= lost;
    s->heat += lost;
}

/* Of turns only, which are no bow, the last loop is forgotten: as if the slip had come straight. */
static void forget(lj_state *s, const lj_enclosure *e)
{
    lj_real slip = s->slip, stored = s->enclosure_stored, heat = s->heat;
    int i;
    for (i = 0; i < 2; i++) {
        int last = s->count - 1;
        lj_real rise = s->slopes[last - 1] - s->slopes[last], end = s->ends[last] * e->reach;
        s->slip -= rise * lj_square(end) / e->stiffness;
        s->enclosure_force -= 2 * rise * end;
        s->count--;
    }
    move_strip(s, slip, e);
    s->enclosure_stored = stored;
    s->heat = heat;
    s->flags |= LJ_OVERFLOW;
}

/* One piece less, for the next turn: where that changes least, two of a bow become one. */
static LJ_SELDOM void thin(lj_state *s, const lj_enclosure *e)
{
    lj_real before = strip_energy(s, e), least = LJ_FAR, a, b, first, second, bend, drawn;
    int i, place = 0;
    for (i = 1; i < s->count - 2; i++) {
        const lj_real *m = &s->slopes[i], *far = &s->ends[i];
        lj_real cost = (far[1] - far[2]) * (far[0] - far[1]) * lj_abs(m[0] - m[1]);
        if ((m[1] - m[2]) * (m[0] - m[1]) >= 0 && m[0] * m[2] >= 0 && cost < least) {
            least = cost;
            place = i;
        }
    }
    if (place == 0) {
        forget(s, e);
        return;
    }
    s->count--;
    a = s->ends[place + 1] - s->ends[place + 2];
    b = s->ends[place] - s->ends[place + 1];
    first = s->slopes[place + 1] - s->slopes[place + 2];
    second = s->slopes[place] - s->slopes[place + 1];
    bend = first * a + (second + first) * b;
    drawn = lj_differ(bend, 0) ? a * b * second / bend : 0;
    if (a + b - drawn > 0)
        s->slopes[place] = (s->slopes[place + 1] * a + s->slopes[place] * b -
                            s->slopes[place + 2] * drawn) / (a + b - drawn);
    for (i = place + 1; i < s->count; i++) {
        s->ends[i] = s->ends[i + 1];
        s->slopes[i] = s->slopes[i + 1];
    }
    s->ends[place + 1] += drawn;
    settle(s, before, e);
}

/* What is steeper than a lower friction holds slides, run by run from the innermost. */
static LJ_SELDOM void relax(lj_state *s, const lj_enclosure *e)
{
    lj_real near[LJ_PIECES], stretch[LJ_PIECES], slopes[LJ_PIECES], q = e->friction, at;
    lj_real before = strip_energy(s, e), slip = s->slip, stored = s->enclosure_stored, heat = s->heat;
    int i, j, count = s->count, first = count;
    /* until the end, slip and force are those beyond a place of the strip */
    for (i = count - 1; i > 0 && lj_abs(s->slopes[i]) > q; i--) {
        lj_real length = length_of(s, i, e), rise = 2 * s->slopes[i] * length;
        near[i] = i < count - 1 ? s->ends[i + 1] : 0;
        stretch[i] = s->slip;
        slopes[i] = s->slopes[i];
        s->slip -= length * (s->enclosure_force + rise / 2) / e->stiffness;
        s->enclosure_force += rise;
        first = i;
    }
    at = s->ends[first];
    s->slopes[1] = lj_clip(s->slopes[1], -q, q);
    s->count = (uint8_t)(first > 2 ? first : 2);
    for (i = first; i < count; i++) {
        lj_real left = 1 - near[i], more = (at - near[i]) * e->reach, slope;
        lj_enclosure strip = *e;
        if ((i < count - 1 && slopes[i + 1] * slopes[i] > 0) || !(left > 0))
            continue;
        slope = s->slopes[s->count - 1];
        s->slip += (s->enclosure_force - slope * more) * more / e->stiffness;
        s->enclosure_force -= 2 * slope * more;
        strip.reach = e->reach * left;
        for (j = 0; near[i] > 0 && j < s->count; j++)
            s->ends[j] = (s->ends[j] - near[i]) / left;
        if (lj_differ(s->slip, stretch[i]))
            move_strip(s, stretch[i], &strip);
        for (j = 0; near[i] > 0 && j < s->count; j++)
            s->ends[j] = near[i] + left * s->ends[j];
        at = near[i];
    }
    s->slip = slip;
    s->enclosure_stored = stored;
    s->heat = heat;
    settle(s, before, e);
}

/* ---- the brake ---- */

/* x >= 0 with spring x + f(x) = drive; LJ_FAR where a spring that softens never meets it. A strip
 * without friction slides as a whole; on any other one the front stays within its piece. */
static lj_real meet(lj_real drive, lj_real spring, const lj_enclosure *strip)
{
    lj_real slope = spring + strip->stiffness / strip->reach;
    if (strip->friction > 0) {
        if (spring < 0) /* by rounding only is it more */
            drive = lj_min(drive, lj_square(strip->root) / (-4 * spring));
        return lj_square(lj_spread_root(drive, spring, strip));
    }
    if (!(drive > 0))
        return 0;
    return slope > 0 ? drive / slope : LJ_FAR;
}

/* What drives on past the friction, at a slip and a force of the enclosure. */
static lj_real drive_of(lj_real elongation, lj_real spring, lj_real direction, lj_real slip,
                        lj_real force, const lj_setting *at)
{
    lj_real pull = direction * (spring * (elongation - slip) - force);
    return pull - at->c * (at->overlap - slip);
}

/* Slip where spring (u - x) = F_e(x) + F_f(x), or - F_f(x) on the way back. */
static lj_real balance(const lj_state *s, lj_real elongation, lj_real spring, lj_real direction,
                       const lj_setting *at)
{
    lj_branch_over over = first_branch(s, direction, &at->enclosure);
    lj_enclosure strip;
    lj_real drive, slip;
    while (over.place > 0 &&
           (direction * (over.end - s->slip) <= 0 ||
            drive_of(elongation, spring, direction, over.end, over.end_force, at) > 0))
        next_branch(&over, s, &at->enclosure);
    drive = drive_of(elongation, spring, direction, over.start, over.force, at);
    strip = lj_branch(over.strength, &at->enclosure);
    slip = over.start + direction * meet(drive, spring - direction * at->c, &strip);
    return direction * (slip - s->slip) > 0 ? lj_max(slip, 0) : s->slip;
}

/* Slide outward as far as the elongation drives; past the overlap the enclosure alone pulls. */
static void slide_out(lj_state *s, lj_real elongation, lj_setting *at)
{
    lj_real far = balance(s, elongation, at->k, 1, at), start = s->slip, end;
    if (!(at->k > at->c))
        s->flags |= LJ_SNAPPED;
    end = lj_min(far, at->overlap);
    if (at->c > 0 && end > start)
        s->heat += at->c * (end - start) * (at->overlap - (end + start) / 2);
    if (far >= at->overlap) {
        s->flags |= LJ_SEPARATED;
        at->c = 0;
        far = lj_max(balance(s, elongation, at->k, 1, at), lj_max(start, at->overlap));
    }
    if (far > start)
        move_strip(s, far, &at->enclosure);
}

/* Slide inward until friction holds the enclosure; slack, without the spring. */
static void slide_in(lj_state *s, lj_real elongation, const lj_setting *at)
{
    lj_real start = s->slip, near = balance(s, elongation, at->k, -1, at);
    if (!(elongation >= near))
        near = balance(s, elongation, 0, -1, at);
    if (!(near < start))
        return;
    if (at->c > 0)
        s->heat += at->c * (start - near) * (at->overlap - (start + near) / 2);
    if (start - near > LJ(1e-12) * at->overlap)
        s->flags |= LJ_CLOSED;
    move_strip(s, near, &at->enclosure);
}

/* Slide one way; the motion. Where nothing slid nothing is remembered: rounding is no turn. */
static LJ_SELDOM unsigned slide(lj_state *s, int outward, lj_real elongation, lj_setting *at)
{
    uint32_t flags = s->flags;
    lj_real start = s->slip;
    if (outward)
        slide_out(s, elongation, at);
    else
        slide_in(s, elongation, at);
    if (s->count == LJ_PIECES)
        thin(s, &at->enclosure);
    if (lj_differ(s->slip, start))
        return outward ? LJ_OUTWARD : LJ_INWARD;
    s->flags = flags;
    return LJ_STUCK;
}

/* The commonest slide, which `slide` would make too: further out over one piece, whose far end is not
 * reached. False where it is another slide. */
static LJ_OFTEN int slide_on(lj_state *s, lj_real elongation, const lj_setting *at)
{
    const lj_enclosure *e = &at->enclosure;
    int last = s->count - 1;
    lj_real end = s->ends[last], strength, full, spread, start, force, slip, far, root, lost;
    lj_enclosure strip;
    if (lj_differ(s->slopes[last], -e->friction) || last < 2 || !(at->k > at->c))
        return 0;
    strength = e->friction + s->slopes[last - 1];
    if (!(strength > 0))
        return 0;
    strip = lj_branch(strength, e);
    full = 2 * strength * e->reach; /* change of force per share of the length */
    start = s->slip - strip.saturation * lj_square(end);
    force = s->enclosure_force - full * end;
    root = lj_spread_root(drive_of(elongation, at->k, 1, start, force, at), at->k - at->c, &strip);
    slip = start + lj_square(root);
    far = strip.root * root / full;
    if (!(slip > s->slip && slip < at->overlap && far < s->ends[last - 1]))
        return 0;
    /* slipped area and work rise with the third power of the share */
    spread = strip.saturation * (far * far * far - end * end * end) * (LJ(1) / LJ(3));
    lost = 2 * e->friction * e->reach * spread;
    s->heat += at->c * (slip - s->slip) * (at->overlap - (slip + s->slip) / 2) + lost;
    s->enclosure_stored += force * (slip - s->slip) + 2 * full * spread - lost;
    s->enclosure_force = force + full * far;
    s->ends[last] = far;
    s->slip = slip;
    return 1;
}

/* Move at constant vacuum; work and heat are exact. */
static LJ_OFTEN void move_to(const lj_brake *brake, lj_state *s, lj_real elongation,
                             lj_setting *at)
{
    lj_real trial = at->k * (elongation - s->slip), hold = hold_of(s->slip, at);
    lj_real before = s->force, heat = s->heat, stored = s->enclosure_stored;
    int outward = trial > s->enclosure_force + hold;
    unsigned motion = LJ_STUCK;
    if (outward || lj_max(trial, 0) < s->enclosure_force - hold) {
        at->enclosure = enclosure_at(brake, at->vacuum);
        motion = LJ_OUTWARD;
        if (!outward || !slide_on(s, elongation, at))
            motion = slide(s, outward, elongation, at);
    }
    s->motion = (uint8_t)motion;
    s->force = lj_max(at->k * (elongation - s->slip), 0);
    s->work += s->heat - heat + (s->enclosure_stored - stored);
    s->work += (lj_square(s->force) - lj_square(before)) / (2 * brake->stiffness);
}

/* Another vacuum at a fixed elongation: no work is done, what is released becomes heat. */
static LJ_SELDOM void change_vacuum(const lj_brake *brake, lj_state *s, lj_real vacuum)
{
    lj_setting at = setting_of(brake, s, vacuum, 0);
    lj_enclosure strip = enclosure_at(brake, vacuum);
    lj_real work = s->work, heat = s->heat, stored = lj_stored(brake, s);
    if (lj_abs(s->slopes[s->count - 1]) > strip.friction)
        relax(s, &strip);
    move_to(brake, s, s->elongation, &at);
    s->vacuum = vacuum;
    s->work = work;
    s->heat = heat + lj_max(stored - lj_stored(brake, s), 0);
}

lj_real lj_move(const lj_brake *brake, lj_state *s, lj_real elongation, lj_real vacuum,
                lj_real compliance)
{
    lj_setting at;
    int fine = elongation > -LJ_LIMIT && elongation < LJ_LIMIT;
    fine = fine && vacuum >= 0 && vacuum < LJ_LIMIT && compliance >= 0 && compliance < LJ_LIMIT;
    if (!fine) {
        s->flags |= LJ_REFUSED;
        return s->force;
    }
    s->flags &= ~LJ_REFUSED;
    if (lj_differ(vacuum, s->vacuum))
        change_vacuum(brake, s, vacuum);
    else if (!lj_differ(elongation - compliance * s->force, s->elongation))
        return s->force; /* nothing is asked for: every bit stays */
    at = setting_of(brake, s, vacuum, compliance);
    move_to(brake, s, elongation, &at);
    s->elongation = elongation - compliance * s->force;
    s->flags &= ~LJ_SLACK;
    if (!(s->force > 0) && elongation < s->slip)
        s->flags |= LJ_SLACK;
    return s->force;
}

lj_real lj_peek(const lj_brake *brake, const lj_state *state, lj_real elongation, lj_real vacuum,
                lj_real compliance)
{
    lj_state copy = *state;
    return lj_move(brake, &copy, elongation, vacuum, compliance);
}

void lj_start(lj_state *s, lj_real vacuum)
{
    *s = (lj_state){0};
    s->vacuum = vacuum;
    s->ends[0] = s->ends[1] = 1; /* the middle, and the whole strip relaxed */
    s->count = 2;
    s->layout = LJ_LAYOUT;
}

int lj_check(const lj_brake *brake)
{
    const lj_real numbers[8] = {
        brake->contact,           brake->overlap, brake->stiffness, brake->enclosure_stiffness,
        brake->enclosure_contact, brake->reach,   brake->exponent,  brake->test_pressure,
    };
    int i;
    for (i = 0; i < 8; i++) {
        lj_real least = i == 6 ? -1 : 0;
        if (!(numbers[i] > least && numbers[i] < LJ_LIMIT))
            return i + 1;
    }
    return 0;
}

lj_real lj_stored(const lj_brake *brake, const lj_state *state)
{
    return state->enclosure_stored + lj_square(state->force) / (2 * brake->stiffness);
}

/* ---- slopes ---- */

/* Slope of the enclosure's force over the slip, where the last move goes on. */
static lj_real enclosure_slope(const lj_brake *brake, const lj_state *s)
{
    lj_real end = s->ends[s->count - 1];
    return end > 0 ? brake->enclosure_stiffness / (brake->reach * end) : LJ_FAR;
}

lj_real lj_tangent(const lj_brake *brake, const lj_state *state, lj_real compliance)
{
    lj_setting at = setting_of(brake, state, state->vacuum, compliance);
    lj_real slope;
    if (!(state->force > 0))
        return 0;
    if (state->motion == LJ_STUCK)
        return at.k;
    slope = enclosure_slope(brake, state);
    slope += state->motion == LJ_OUTWARD ? -at.c : at.c;
    return at.k * slope / (at.k + slope);
}

lj_real lj_vacuum_tangent(const lj_brake *brake, const lj_state *state, lj_real compliance)
{
    lj_setting at = setting_of(brake, state, state->vacuum, compliance);
    lj_real friction = brake->enclosure_contact * state->vacuum, slope, change;
    int last = state->count - 1;
    if (!(state->force > 0) || state->motion != LJ_OUTWARD || !(state->vacuum > 0))
        return 0;
    change = hold_of(state->slip, &at) * (1 + brake->exponent);
    if (!lj_differ(state->slopes[last], -friction)) /* what slides turns about its middle */
        change += friction * brake->reach * state->ends[last];
    slope = enclosure_slope(brake, state) - at.c;
    return at.k * (change / state->vacuum) / (at.k + slope);
}
