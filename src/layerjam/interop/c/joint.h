/* The brake pulled over a joint: the friction of mechanics/joint.py in the moves of layerjam.c.
 *
 * It belongs behind layerjam.c, in one file with it: the enclosure's memory is that of the kernel.
 * The friction is no straight line over the slip, so the slip is searched for where the kernel has a
 * closed form. What sticks does not change any bit. Apache License 2.0. */

#include <math.h>

/* How the brake lies on the joint; a radius or an angle of zero: straight. */
typedef struct {
    lj_real radius; /* [m] */
    lj_real angle;  /* [rad] */
    lj_real sheets; /* number */
    lj_real width;  /* of a sheet [m] */
} lj_joint;

/* One move over the joint, from a state. */
typedef struct {
    const lj_brake *brake;
    const lj_joint *joint;
    const lj_state *from;
    lj_enclosure enclosure;
    lj_real k, elongation, vacuum, direction; /* 1 out, -1 back */
} lj_over;

/* Kinetic friction of the sheets [N]. The outer face of the enclosure covers them with half of its
 * force [N]. */
static lj_real over_joint(const lj_brake *brake, const lj_joint *joint, lj_real slip, lj_real vacuum,
                          lj_real enclosure_force)
{
    lj_real interfaces = joint->sheets - 1, overlap = lj_max(brake->overlap - slip, 0);
    lj_real on_joint = lj_min(joint->radius * joint->angle, overlap);
    lj_real tension = lj_max(enclosure_force, 0) / 2;
    lj_real load = vacuum * joint->width + tension / joint->radius;
    lj_real friction = brake->contact / (interfaces * joint->width), growth, straight, seed;
    if (load > 0 && lj_differ(brake->exponent, 0))
        friction *= lj_pow(load / joint->width / brake->test_pressure, brake->exponent);
    growth = friction * on_joint / joint->radius;
    straight = friction * vacuum * joint->width * (overlap - on_joint) / 2;
    seed = load * joint->radius * (lj_real)expm1(growth);
    seed += straight * (1 + (lj_real)exp(growth));
    if (!(growth > 0))
        return seed * interfaces;
    return seed * (lj_real)(expm1(interfaces * growth) / expm1(growth));
}

/* What drives on past the friction [N] at a slip, with the state and the friction there. */
static lj_real drive_over(const lj_over *over, lj_real slip, lj_state *at, lj_real *hold)
{
    lj_real pull = over->k * (over->elongation - slip);
    *at = *over->from;
    if (lj_differ(slip, at->slip))
        move_strip(at, slip, &over->enclosure);
    *hold = over_joint(over->brake, over->joint, slip, over->vacuum, at->enclosure_force);
    if (over->direction < 0)
        pull = lj_max(pull, 0);
    return over->direction * (pull - at->enclosure_force) - *hold;
}

/* Slip between two where nothing drives on: false position, and halving where that is slow. */
static lj_real rest_over(const lj_over *over, lj_real moving, lj_real still)
{
    lj_state at;
    lj_real hold, high, low, between, drive;
    lj_real least = LJ_NEAR * LJ(1e-6) * over->k * over->brake->overlap;
    int i;
    high = drive_over(over, moving, &at, &hold);
    low = drive_over(over, still, &at, &hold);
    for (i = 0; i < 200; i++) {
        lj_real half = (moving + still) / 2;
        if (!lj_differ(half, moving) || !lj_differ(half, still))
            break;
        between = i % 2 ? moving + (still - moving) * (high / (high - low)) : half;
        if (!lj_differ(between, moving) || !lj_differ(between, still))
            between = half;
        drive = drive_over(over, between, &at, &hold);
        if (drive > 0) {
            moving = between;
            high = drive;
            continue;
        }
        still = between;
        low = drive;
        if (-low < least)
            break;
    }
    return still;
}

/* Slide to where the friction holds; the motion. Beyond the overlap the enclosure alone pulls. */
static unsigned slide_over(const lj_over *over, lj_state *s)
{
    lj_state start = *s, at;
    lj_real first, middle, last, end, far;
    drive_over(over, start.slip, &at, &first);
    far = over->direction > 0 ? lj_min(over->elongation, over->brake->overlap) : 0;
    end = far;
    if (!(drive_over(over, far, &at, &last) > 0))
        end = rest_over(over, start.slip, far);
    if (!(over->direction * (end - start.slip) > 0))
        return LJ_STUCK;
    drive_over(over, (start.slip + end) / 2, &at, &middle);
    drive_over(over, end, s, &last);
    s->heat += lj_abs(end - start.slip) * (first + 4 * middle + last) / 6;
    if (over->direction < 0) {
        if (start.slip - end > LJ(1e-12) * over->brake->overlap)
            s->flags |= LJ_CLOSED;
    } else {
        if (first - last > over->k * (end - start.slip))
            s->flags |= LJ_SNAPPED;
        if (!(end < over->brake->overlap))
            s->flags |= LJ_SEPARATED;
    }
    if (s->count == LJ_PIECES)
        thin(s, &over->enclosure);
    return over->direction > 0 ? LJ_OUTWARD : LJ_INWARD;
}

/* Move at constant vacuum and angle, as move_to of the kernel. */
static void move_over(const lj_brake *brake, const lj_joint *joint, lj_state *s, lj_real elongation,
                      lj_real vacuum, lj_real compliance)
{
    lj_setting at = setting_of(brake, s, vacuum, compliance);
    lj_real trial = at.k * (elongation - s->slip), before = s->force, heat = s->heat;
    lj_real stored = s->enclosure_stored;
    lj_real hold = over_joint(brake, joint, s->slip, vacuum, s->enclosure_force);
    lj_state from = *s;
    lj_over over = {brake, joint, &from, {0, 0, 0, 0, 0}, at.k, elongation, vacuum, 1};
    unsigned motion = LJ_STUCK;
    if (trial > s->enclosure_force + hold || lj_max(trial, 0) < s->enclosure_force - hold) {
        over.enclosure = enclosure_at(brake, vacuum);
        over.direction = trial > s->enclosure_force + hold ? LJ(1) : LJ(-1);
        motion = slide_over(&over, s);
    }
    if (s->flags & LJ_SEPARATED) { /* the rest of the way without the sheets */
        at = setting_of(brake, s, vacuum, compliance);
        at.enclosure = over.enclosure;
        slide_out(s, elongation, &at);
    }
    s->motion = (uint8_t)motion;
    s->force = lj_max(at.k * (elongation - s->slip), 0);
    s->work += s->heat - heat + (s->enclosure_stored - stored);
    s->work += (lj_square(s->force) - lj_square(before)) / (2 * brake->stiffness);
}

/* Another vacuum or angle at a fixed elongation: no work is done, what is released becomes heat. */
static void change_over(const lj_brake *brake, const lj_joint *joint, lj_state *s, lj_real vacuum)
{
    lj_enclosure strip = enclosure_at(brake, vacuum);
    lj_real work = s->work, heat = s->heat, stored = lj_stored(brake, s);
    if (lj_abs(s->slopes[s->count - 1]) > strip.friction)
        relax(s, &strip);
    move_over(brake, joint, s, s->elongation, vacuum, 0);
    s->vacuum = vacuum;
    s->work = work;
    s->heat = heat + lj_max(stored - lj_stored(brake, s), 0);
}

/* Whether the last force is more than the joint holds at its present angle; rounding is no more. */
static int gives_way(const lj_brake *brake, const lj_joint *joint, const lj_state *s)
{
    lj_real hold = over_joint(brake, joint, s->slip, s->vacuum, s->enclosure_force);
    lj_real rounding = LJ_NEAR * LJ(1e-3) * (s->force + hold);
    lj_real more = s->force - s->enclosure_force;
    return more > hold + rounding || -more > hold + rounding;
}

/* As lj_move, over a joint whose angle may change between the calls. */
static lj_real lj_move_over(const lj_brake *brake, const lj_joint *joint, lj_state *s,
                            lj_real elongation, lj_real vacuum, lj_real compliance)
{
    int fine = elongation > -LJ_LIMIT && elongation < LJ_LIMIT;
    fine = fine && vacuum >= 0 && vacuum < LJ_LIMIT && compliance >= 0 && compliance < LJ_LIMIT;
    if (!fine || !(joint->radius > 0 && joint->angle > 0) || s->flags & LJ_SEPARATED)
        return lj_move(brake, s, elongation, vacuum, compliance);
    s->flags &= ~LJ_REFUSED;
    if (lj_differ(vacuum, s->vacuum) || gives_way(brake, joint, s))
        change_over(brake, joint, s, vacuum);
    else if (!lj_differ(elongation - compliance * s->force, s->elongation))
        return s->force;
    move_over(brake, joint, s, elongation, vacuum, compliance);
    s->elongation = elongation - compliance * s->force;
    s->flags &= ~LJ_SLACK;
    if (!(s->force > 0) && elongation < s->slip)
        s->flags |= LJ_SLACK;
    return s->force;
}
