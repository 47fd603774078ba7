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

/* Cube root of a number above zero by Halley's rule: libraries differ in the last bit. */
static lj_real lj_cbrt(lj_real x)
{
    lj_real scale = 1, y = LJ(1.5);
    int i;
    for (i = 0; i < 400 && x >= 8; i++) {
        x *= LJ(0.125);
        scale *= 2;
    }
    for (i = 0; i < 400 && x < 1; i++) {
        x *= 8;
        scale *= LJ(0.5);
    }
    for (i = 0; i < 6; i++) {
        lj_real cube = y * y * y;
        y = y * (cube + 2 * x) / (2 * cube + x);
    }
    return y * scale;
}

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
    return lj_enclosure_of(brake->enclosure_stiffness, brake->enclosure_contact * vacuum,
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

/* ---- the enclosure's memory ---- */

/* The enclosure has not moved since the vacuum was changed. */
static int is_unmoved(const lj_state *s)
{
    return lj_abs(s->slip - s->base.slip) <= LJ_NEAR * s->slip;
}

/* The whole strip slides back: it rests on the force that friction just fails to hold. */
static int slides_back(const lj_state *s)
{
    return is_unmoved(s) && !(s->down > 0) && s->highs_count == 0 && s->lows_count == 0;
}

/* Remember the present point as a turn, if the direction changes; true if a turn was added. */
static LJ_OFTEN int face(lj_state *s, int loading, const lj_enclosure *e)
{
    lj_turn *turns = loading ? s->lows : s->highs;
    const lj_turn *others = loading ? s->highs : s->lows;
    uint8_t *count = loading ? &s->lows_count : &s->highs_count;
    int number = loading ? s->highs_count : s->lows_count;
    lj_real strength = 2 * e->friction;
    int turned = (s->loading != 0) != loading && (loading || !slides_back(s));
    /* loops inside a loop move against the same change of friction, so that they close where they
     * opened; the outermost knows whether it starts where the vacuum was changed */
    if (number > 0)
        strength = others[number - 1].strength;
    else if (!loading && is_unmoved(s))
        strength = s->down;
    s->loading = (uint8_t)loading;
    if (!turned)
        return 0;
    if (*count == LJ_DEPTH) {
        s->flags |= LJ_OVERFLOW;
        return 0;
    }
    turns[*count].slip = s->slip;
    turns[*count].force = s->enclosure_force;
    turns[*count].strength = strength;
    (*count)++;
    return 1;
}

/* Force of the outermost loading: from the base up to `join`, then the backbone. */
static lj_real first_force(const lj_state *s, lj_real slip, const lj_enclosure *e)
{
    lj_enclosure strip;
    if (!(slip < s->join))
        return lj_backbone(lj_max(slip - s->origin, 0), e);
    strip = lj_branch(s->base.strength, e);
    return s->base.force + lj_backbone(lj_max(slip - s->base.slip, 0), &strip);
}

/* Whether a slip lies inside the outermost loop, where the first loading does not count. */
static int is_inside(const lj_state *s, lj_real slip)
{
    return s->lows_count > 0 && slip < s->highs[0].slip;
}

/* Change of force since a turn, at a distance from it. */
static lj_real branch_force(const lj_turn *turn, lj_real distance, const lj_enclosure *e)
{
    lj_enclosure strip = lj_branch(turn->strength, e);
    return lj_backbone(lj_max(distance, 0), &strip);
}

/* Force at a slip beyond the present one: the lowest of all branches. */
static lj_real loading_force(const lj_state *s, lj_real slip, const lj_enclosure *e)
{
    lj_real lowest = is_inside(s, slip) ? LJ_FAR : first_force(s, slip, e);
    int i;
    for (i = 0; i < s->lows_count; i++) {
        const lj_turn *low = &s->lows[i];
        lowest = lj_min(lowest, low->force + branch_force(low, slip - low->slip, e));
    }
    return lowest;
}

/* Force at a slip below the present one: the highest of all branches. */
static lj_real unloading_force(const lj_state *s, lj_real slip, const lj_enclosure *e)
{
    lj_real highest = -LJ_FAR;
    int i;
    for (i = 0; i < s->highs_count; i++) {
        const lj_turn *high = &s->highs[i];
        highest = lj_max(highest, high->force - branch_force(high, high->slip - slip, e));
    }
    return highest;
}

/* Work and heat of the outermost loading from one slip to another. */
static void add_first(const lj_state *s, lj_real start, lj_real end, const lj_enclosure *e,
                      lj_real *work, lj_real *heat)
{
    lj_real joined = lj_clip(s->join, start, end), a, b;
    if (!(end > start))
        return;
    if (joined > start) {
        lj_enclosure strip = lj_branch(s->base.strength, e);
        a = lj_max(start - s->base.slip, 0);
        b = lj_max(joined - s->base.slip, 0);
        *work += s->base.force * (joined - start);
        *work += lj_backbone_work(b, &strip) - lj_backbone_work(a, &strip);
        *heat += e->friction * (lj_slipped_area(b, &strip) - lj_slipped_area(a, &strip));
    }
    a = lj_max(joined - s->origin, 0);
    b = lj_max(end - s->origin, 0);
    *work += lj_backbone_work(b, e) - lj_backbone_work(a, e);
    *heat += lj_backbone_dissipated(b, e) - lj_backbone_dissipated(a, e);
}

/* Work and heat of a branch from one slip to another, both measured from its turn. */
static void add_branch(const lj_turn *turn, lj_real start, lj_real end, lj_real friction,
                       const lj_enclosure *e, lj_real *work, lj_real *heat)
{
    lj_enclosure strip;
    lj_real a = lj_abs(start - turn->slip), b = lj_abs(end - turn->slip);
    if (!lj_differ(start, end))
        return;
    strip = lj_branch(turn->strength, e);
    *work += turn->force * (end - start);
    *work += lj_backbone_work(b, &strip) - lj_backbone_work(a, &strip);
    *heat += friction * (lj_slipped_area(b, &strip) - lj_slipped_area(a, &strip));
}

/* Stretch to a slip beyond the present one; the state faces loading. */
static void load_to(lj_state *s, lj_real slip, const lj_enclosure *e)
{
    lj_real work = 0, heat = 0, first = s->slip;
    int i, left = 0;
    for (i = s->lows_count - 1; i >= 0; i--) {
        lj_real inner = i + 1 < s->lows_count ? s->highs[i + 1].slip : s->slip;
        lj_real start = lj_clip(inner, s->slip, slip);
        lj_real end = lj_clip(s->highs[i].slip, start, slip);
        add_branch(&s->lows[i], start, end, s->lows[i].strength - e->friction, e, &work, &heat);
    }
    if (s->lows_count > 0)
        first = lj_clip(s->highs[0].slip, s->slip, slip);
    add_first(s, first, slip, e, &work, &heat);
    for (i = 0; i < s->highs_count; i++)
        left += s->highs[i].slip * (1 - LJ_NEAR) > slip;
    s->enclosure_force = loading_force(s, slip, e);
    s->slip = slip;
    s->highs_count = (uint8_t)left;
    if (s->lows_count > left)
        s->lows_count = (uint8_t)left;
    s->enclosure_stored += work - heat;
    s->heat += heat;
}

/* Let a strip that slides back as a whole shrink, and take its base along. */
static void slide_whole(lj_state *s, lj_real slip, const lj_enclosure *e)
{
    lj_real distance = s->slip - slip;
    lj_real force = s->enclosure_force - e->stiffness * distance / e->reach;
    lj_real heat = e->friction * e->reach * distance;
    s->enclosure_stored += -distance * (s->enclosure_force + force) / 2 - heat;
    s->heat += heat;
    s->slip = s->base.slip = slip;
    s->enclosure_force = s->base.force = force;
    s->join = lj_crossing(slip, force, e);
    s->loading = 1;
}

/* Let shrink to a slip below the present one; the state faces unloading. */
static void unload_to(lj_state *s, lj_real slip, const lj_enclosure *e)
{
    lj_real work = 0, heat = 0;
    int i, left = 0;
    if (slides_back(s)) {
        slide_whole(s, slip, e);
        return;
    }
    for (i = s->highs_count - 1; i >= 0; i--) {
        lj_real inner = i < s->lows_count ? s->lows[i].slip : s->slip;
        lj_real start = lj_clip(inner, slip, s->slip);
        lj_real end = lj_clip(i > 0 ? s->lows[i - 1].slip : slip, slip, start);
        add_branch(&s->highs[i], start, end, e->friction, e, &work, &heat);
    }
    for (i = 0; i < s->lows_count; i++)
        left += s->lows[i].slip < slip * (1 - LJ_NEAR);
    s->enclosure_force = unloading_force(s, slip, e);
    s->slip = slip;
    s->lows_count = (uint8_t)left;
    if (s->highs_count > left + 1)
        s->highs_count = (uint8_t)(left + 1);
    s->enclosure_stored += work - heat;
    s->heat += heat;
}

/* The same slip under another vacuum; turns are forgotten. See mechanics/memory.py, at_vacuum. */
static void take_vacuum(lj_state *s, lj_real before, const lj_enclosure *e)
{
    lj_real slip = s->slip, force = s->enclosure_force, stored = s->enclosure_stored;
    lj_real whole = e->stiffness * slip / e->reach, least = whole - e->friction * e->reach;
    lj_real q = before, now = e->friction, origin = 0, join = slip, kept = stored, there;
    int straight = s->highs_count == 0 && s->lows_count == 0;
    int gripped = is_unmoved(s) && straight && s->grip >= 0;
    int raised, known, back, spare, pushes = 0;
    if (gripped)
        q = s->grip;
    raised = now > q;
    known = s->loading && s->lows_count == 0 && slip >= s->join * (1 - LJ_NEAR);
    known = known && lj_abs(s->origin) <= LJ_NEAR * slip;
    /* without friction turns mean nothing, and the strip is stretched evenly */
    known = known || gripped || (!(q > 0) && lj_abs(force - whole) <= LJ_NEAR * whole);
    back = !known && least > LJ_NEAR * whole && force <= least + LJ_NEAR * whole;
    back = back && stored >= lj_slid_back_stored(least, e) * (1 - LJ_NEAR);
    spare = known && raised && slip > LJ_NEAR * e->reach;
    if (known && !raised) {
        force = lj_backbone(slip, e);
        kept = lj_backbone_stored(slip, e);
    } else if (back) {
        force = least;
        kept = lj_slid_back_stored(least, e);
        join = lj_crossing(slip, force, e);
    } else if (!known) {
        pushes = force < -LJ_NEAR * whole;
        if (!raised)
            force = lj_min(lj_min(force, lj_backbone(slip, e)), lj_force_of_stored(stored, e));
        force = lj_max(force, 0);
    }
    there = force;
    if (spare)
        there += 2 * (now - q) * (q > 0 ? lj_min(force / 2 / q, e->reach) : e->reach);
    if (spare || !(known || back))
        there = lj_inverse_backbone(there, e);
    if (spare) {
        join = there;
    } else if (!(known || back)) {
        origin = slip - there;
        if (pushes || !raised)
            kept = pushes ? 0 : lj_backbone_stored(there, e);
    }
    kept = lj_min(kept, stored);
    s->enclosure_force = force;
    s->origin = origin;
    s->base.slip = slip;
    s->base.force = force;
    s->base.strength = spare ? now - q : 2 * now;
    s->join = join;
    s->down = spare ? now + q : back ? 0 : 2 * now;
    s->grip = spare ? q : -1;
    s->highs_count = s->lows_count = 0;
    s->loading = 1;
    s->enclosure_stored = kept;
    s->heat += stored - kept;
}

/* ---- the brake ---- */

/* x >= 0 with spring x + f(x) = drive; LJ_FAR where a spring that softens never meets it. */
static lj_real meet(lj_real drive, lj_real spring, const lj_enclosure *strip)
{
    lj_real push = lj_max(drive, 0), slope = spring + strip->stiffness / strip->reach, linear;
    if (!(spring < 0) || !(push > 0))
        return lj_rising_root(drive, spring, strip);
    if (lj_square(strip->root) + 4 * spring * push >= 0) {
        lj_real near = lj_rising_root(drive, spring, strip);
        if (near < strip->saturation)
            return near;
    }
    linear = push - strip->friction * strip->reach;
    if (!(slope > 0))
        return LJ_FAR;
    return lj_max(linear / slope, strip->saturation);
}

/* Slip where k (u - x) = F_e(x) + F_f(x) on the outermost loading; -LJ_FAR where there is none. */
static lj_real first_slip(const lj_state *s, lj_real elongation, const lj_setting *at)
{
    const lj_enclosure *e = &at->enclosure;
    lj_real onset = at->k * (elongation - s->origin) - at->c * (at->overlap - s->origin);
    lj_real first = s->origin + meet(onset, at->k - at->c, e), drive;
    lj_enclosure strip;
    if (first >= s->join)
        return first;
    drive = at->k * (elongation - s->base.slip) - s->base.force;
    drive -= at->c * (at->overlap - s->base.slip);
    if (!(drive >= 0))
        return -LJ_FAR;
    strip = lj_branch(s->base.strength, e);
    return lj_min(s->base.slip + meet(drive, at->k - at->c, &strip), s->join);
}

/* Slip where k (u - x) = F_e(x) + F_f(x): the farthest root over all loading branches. */
static lj_real outer_slip(const lj_state *s, lj_real elongation, const lj_setting *at)
{
    lj_real far = first_slip(s, elongation, at);
    int i;
    if (is_inside(s, far))
        far = -LJ_FAR;
    for (i = 0; i < s->lows_count; i++) {
        const lj_turn *low = &s->lows[i];
        lj_enclosure strip = lj_branch(low->strength, &at->enclosure);
        lj_real drive = at->k * (elongation - low->slip) - low->force;
        drive -= at->c * (at->overlap - low->slip);
        far = lj_max(far, low->slip + meet(drive, at->k - at->c, &strip));
    }
    return lj_max(far, s->slip);
}

/* Slip where spring (u - x) = F_e(x) - F_f(x): the nearest root over all unloading branches. */
static lj_real inner_slip(const lj_state *s, lj_real elongation, lj_real spring,
                          const lj_setting *at)
{
    const lj_enclosure *e = &at->enclosure;
    lj_real near = LJ_FAR, drive;
    int i;
    for (i = 0; i < s->highs_count; i++) {
        const lj_turn *high = &s->highs[i];
        lj_enclosure strip = lj_branch(high->strength, e);
        drive = high->force - at->c * (at->overlap - high->slip);
        drive -= spring * (elongation - high->slip);
        near = lj_min(near, high->slip - lj_rising_root(drive, spring + at->c, &strip));
    }
    if (s->highs_count == 0) { /* a strip that slides back as a whole falls by EA/l */
        drive = s->enclosure_force - hold_of(s->slip, at) - spring * (elongation - s->slip);
        near = s->slip - lj_max(drive / (spring + at->c + e->stiffness / e->reach), 0);
    }
    return lj_clip(near, 0, s->slip);
}

/* Slide outward as far as the elongation drives; past the overlap the enclosure alone pulls. */
static void slide_out(lj_state *s, lj_real elongation, lj_setting *at)
{
    lj_real far = outer_slip(s, elongation, at), start = s->slip, end;
    if (!(at->k > at->c))
        s->flags |= LJ_SNAPPED;
    end = lj_min(far, at->overlap);
    if (at->c > 0 && end > start)
        s->heat += at->c * (end - start) * (at->overlap - (end + start) / 2);
    if (far >= at->overlap) {
        s->flags |= LJ_SEPARATED;
        at->c = 0;
        far = lj_max(outer_slip(s, elongation, at), lj_max(start, at->overlap));
    }
    if (far > start)
        load_to(s, far, &at->enclosure);
}

/* Slide inward until friction holds the enclosure; slack, without the spring. */
static void slide_in(lj_state *s, lj_real elongation, const lj_setting *at)
{
    lj_real start = s->slip, near = inner_slip(s, elongation, at->k, at);
    if (!(elongation >= near))
        near = inner_slip(s, elongation, 0, at);
    if (!(near < start))
        return;
    if (at->c > 0)
        s->heat += at->c * (start - near) * (at->overlap - (start + near) / 2);
    if (start - near > LJ(1e-12) * at->overlap)
        s->flags |= LJ_CLOSED;
    unload_to(s, near, &at->enclosure);
}

/* Slide one way, and forget the turn again where nothing slid: rounding is no turn. The motion. */
static LJ_SELDOM unsigned slide(lj_state *s, int outward, lj_real elongation, lj_setting *at)
{
    lj_turn *turns = outward ? s->lows : s->highs;
    uint8_t *count = outward ? &s->lows_count : &s->highs_count;
    uint8_t loading = s->loading, place = *count;
    uint32_t flags = s->flags;
    lj_turn kept = turns[place < LJ_DEPTH ? place : 0];
    lj_real start = s->slip;
    int turned = face(s, outward, &at->enclosure);
    if (outward)
        slide_out(s, elongation, at);
    else
        slide_in(s, elongation, at);
    if (lj_differ(s->slip, start))
        return outward ? LJ_OUTWARD : LJ_INWARD;
    s->loading = loading;
    s->flags = flags;
    if (turned) {
        turns[place] = kept;
        *count = place;
    }
    return LJ_STUCK;
}

/* The commonest slide, which `slide` would make too: on along the first loading while part of the
 * strip still rests, and nothing else is remembered. Of the strip's work 2/3 f x half is heat and half
 * is stored. False where it is another slide. */
static LJ_OFTEN int slide_on(lj_state *s, lj_real elongation, const lj_setting *at)
{
    const lj_enclosure *e = &at->enclosure;
    lj_real start = s->slip, from = start - s->origin, onset, to, slip, force, half;
    if (!s->loading || s->highs_count > 0 || s->lows_count > 0 || !(start >= s->join))
        return 0;
    onset = at->k * (elongation - s->origin) - at->c * (at->overlap - s->origin);
    slip = s->origin + lj_rising_root(onset, at->k - at->c, e);
    to = slip - s->origin;
    if (!(at->k > at->c && slip > start && slip < at->overlap && to < e->saturation))
        return 0;
    force = lj_backbone(to, e);
    half = (force * to - s->enclosure_force * from) * (LJ(1) / LJ(3));
    s->enclosure_force = force;
    s->enclosure_stored += half;
    s->heat += at->c * (slip - start) * (at->overlap - (slip + start) / 2) + half;
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
    lj_real friction = brake->enclosure_contact * s->vacuum, now = strip.friction;
    lj_real work = s->work, heat = s->heat, stored = lj_stored(brake, s);
    if (lj_differ(friction, now))
        take_vacuum(s, friction, &strip);
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
    s->base.slip = -1; /* no change of vacuum yet: nowhere */
    s->grip = -1;
    s->loading = 1;
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

/* Slope of a strip's force at a distance from where its branch starts; LJ_FAR at the start. */
static lj_real slope_of(lj_real distance, const lj_enclosure *strip)
{
    if (!(distance < strip->saturation))
        return strip->stiffness / strip->reach;
    return distance > 0 ? strip->root / (2 * lj_sqrt(distance)) : LJ_FAR;
}

/* Slope of the enclosure's force along the branch of the last move. */
static lj_real enclosure_slope(const lj_state *s, const lj_enclosure *e)
{
    int outward = s->motion == LJ_OUTWARD, i;
    const lj_turn *turns = outward ? s->lows : s->highs, *turn = 0;
    int count = outward ? s->lows_count : s->highs_count;
    lj_real best = LJ_FAR, distance = s->slip - s->origin;
    lj_enclosure strip = *e;
    if (outward && !is_inside(s, s->slip)) {
        best = first_force(s, s->slip, e);
        turn = s->slip < s->join ? &s->base : 0;
    } else if (count == 0) {
        return e->stiffness / e->reach;
    }
    for (i = 0; i < count; i++) {
        lj_real change = branch_force(&turns[i], lj_abs(s->slip - turns[i].slip), e);
        lj_real force = outward ? turns[i].force + change : change - turns[i].force;
        if (force < best) {
            best = force;
            turn = &turns[i];
        }
    }
    if (turn) {
        strip = lj_branch(turn->strength, e);
        distance = lj_abs(s->slip - turn->slip);
    }
    return slope_of(distance, &strip);
}

lj_real lj_tangent(const lj_brake *brake, const lj_state *state, lj_real compliance)
{
    lj_setting at = setting_of(brake, state, state->vacuum, compliance);
    lj_real slope;
    if (!(state->force > 0))
        return 0;
    if (state->motion == LJ_STUCK)
        return at.k;
    at.enclosure = enclosure_at(brake, state->vacuum);
    slope = enclosure_slope(state, &at.enclosure);
    slope += state->motion == LJ_OUTWARD ? -at.c : at.c;
    return at.k * slope / (at.k + slope);
}

lj_real lj_vacuum_tangent(const lj_brake *brake, const lj_state *state, lj_real compliance)
{
    lj_setting at = setting_of(brake, state, state->vacuum, compliance);
    lj_enclosure strip = enclosure_at(brake, state->vacuum);
    const lj_enclosure *e = &strip;
    lj_real distance = state->slip - state->origin, slope, change;
    int first = state->lows_count == 0 && !(state->slip < state->join);
    first = first && lj_abs(state->origin) <= LJ_NEAR * state->slip;
    /* on any branch but the first loading a weaker vacuum starts a new one, steep at its start */
    if (!(state->force > 0) || state->motion != LJ_OUTWARD || !first || !(state->vacuum > 0))
        return 0;
    change = hold_of(state->slip, &at) * (1 + brake->exponent);
    change += distance < e->saturation ? lj_backbone(distance, e) / 2 : e->friction * e->reach;
    slope = enclosure_slope(state, e) - at.c;
    return at.k * (change / state->vacuum) / (at.k + slope);
}
