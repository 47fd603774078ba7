/* layerjam.brake: a MuJoCo actuator on a tendon whose control is the vacuum [Pa].
 *
 * The force is that of layerjam.c, along the tendon's path; a held load stays bit for bit. With the
 * number and width of the sheets, the brake lies over the geom that the tendon wraps: joint.h has the
 * friction, the path of the tendon the angle. compute asks, advance commits: mj_forward changes
 * nothing. The brake's memory is in plugin_state, so that mj_getState, copies and threads work as
 * with any other state. Compile this file alone: it includes the kernel. Apache License 2.0. */

#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <mujoco/mujoco.h>
#include <mujoco/mjplugin.h>

#ifdef mjUSESINGLE
#define LJ_SINGLE
#endif
#include "layerjam.c"

#include "joint.h"

#define NUMBERS 8
#define REALS (offsetof(lj_state, flags) / sizeof(lj_real))
#define REST (sizeof(lj_state) - offsetof(lj_state, flags))
#define STATE (REALS + REST) /* the bytes after the numbers each as a number: all of it is finite */

enum { LIMITED, EXPLICIT, IMPLICIT };
static const char *const COUPLINGS[] = {"limited", "explicit", "implicit"};

static const char *const ATTRIBUTES[] = {
    "contact", "overlap",  "stiffness",     "enclosure_stiffness", "enclosure_contact",
    "reach",   "exponent", "test_pressure", "rest_length",         "coupling",
    "sheets",  "width",
};

/* One plugin instance in one mjData. */
typedef struct {
    lj_brake brake;
    lj_joint joint;      /* a radius of zero: the brake lies straight */
    lj_state next;       /* what advance commits */
    mjtNum rest_length;  /* length of the tendon at zero elongation [m] */
    int has_rest_length; /* otherwise that at qpos0 */
    int coupling;
    int actuator;
    int tendon, geom; /* what the actuator pulls, and what that wraps */
    int asked; /* whether next holds an answer */
} instance_data;

static void pack(mjtNum *numbers, const lj_state *state)
{
    const unsigned char *rest = (const unsigned char *)state + offsetof(lj_state, flags);
    size_t i;
    memcpy(numbers, state, REALS * sizeof(lj_real));
    for (i = 0; i < REST; i++)
        numbers[REALS + i] = rest[i];
}

/* What is wrong with the numbers, which a program may have set; null if nothing is. */
static const char *unpack(lj_state *state, const mjtNum *numbers)
{
    unsigned char *rest = (unsigned char *)state + offsetof(lj_state, flags);
    size_t i;
    memcpy(state, numbers, REALS * sizeof(lj_real));
    for (i = 0; i < REST; i++) {
        if (!(numbers[REALS + i] >= 0 && numbers[REALS + i] <= 255))
            return "a byte out of range";
        rest[i] = (unsigned char)numbers[REALS + i];
    }
    return lj_state_fault(state);
}

static int state_size(const mjModel *m, int instance)
{
    (void)m;
    (void)instance;
    return (int)STATE;
}

/* The number of an attribute; 0 where there is none, -1 where it is no number. A comma that the
 * process takes for the decimal point is refused, not misread. */
static int number_of(const mjModel *m, int instance, const char *name, lj_real *number)
{
    const char *text = mj_getPluginConfig(m, instance, name);
    char *end;
    double found;
    if (!text || !text[0])
        return 0;
    found = strtod(text, &end);
    if (end == text || *end || !isfinite(found))
        return -1;
    *number = (lj_real)found;
    return 1;
}

static int read_brake(const mjModel *m, int instance, instance_data *made)
{
    lj_real numbers[NUMBERS] = {0, 0, 0, 0, 0, 0, 0, 1}; /* exponent 0, at 1 Pa */
    int i, wrong;
    for (i = 0; i < NUMBERS; i++) {
        int found = number_of(m, instance, ATTRIBUTES[i], &numbers[i]);
        if (found < 0 || (found == 0 && i < 6)) {
            mju_warning("layerjam.brake: %s is %s; layerjam export mujoco writes it",
                        ATTRIBUTES[i], found ? "no number" : "missing");
            return 0;
        }
    }
    made->brake.contact = numbers[0];
    made->brake.overlap = numbers[1];
    made->brake.stiffness = numbers[2];
    made->brake.enclosure_stiffness = numbers[3];
    made->brake.enclosure_contact = numbers[4];
    made->brake.reach = numbers[5];
    made->brake.exponent = numbers[6];
    made->brake.test_pressure = numbers[7];
    wrong = lj_check(&made->brake);
    if (wrong)
        mju_warning("layerjam.brake: %s must be above %s", ATTRIBUTES[wrong - 1],
                    wrong == 7 ? "-1" : "zero");
    return !wrong;
}

static int read_coupling(const mjModel *m, int instance, instance_data *made)
{
    const char *text = mj_getPluginConfig(m, instance, "coupling");
    int i;
    made->coupling = LIMITED;
    if (!text || !text[0])
        return 1;
    for (i = LIMITED; i <= IMPLICIT; i++) {
        if (!strcmp(text, COUPLINGS[i])) {
            made->coupling = i;
            return 1;
        }
    }
    mju_warning("layerjam.brake: coupling is '%s'; limited, explicit and implicit are known", text);
    return 0;
}

/* The one actuator that an instance drives; a second one would share its memory. */
static int read_actuator(const mjModel *m, int instance, instance_data *made)
{
    int i, out;
    made->actuator = -1;
    for (i = 0; i < m->nactuator; i++) {
        if (m->actuator_plugin[i] != instance)
            continue;
        if (made->actuator >= 0) {
            mju_warning("layerjam.brake: two actuators share one instance; each needs its own");
            return 0;
        }
        made->actuator = i;
    }
    if (made->actuator < 0)
        return 1;
    out = m->actuator_outadr[made->actuator];
    if (m->actuator_trntype[made->actuator] != mjTRN_TENDON || m->actuator_gear[6 * out] != 1) {
        mju_warning("layerjam.brake: a brake pulls on a tendon, with gear 1");
        return 0;
    }
    made->tendon = m->actuator_trnid[2 * made->actuator];
    return 1;
}

/* The joint, where sheets and width are given: the one cylinder or sphere that the tendon wraps. */
static int read_joint(const mjModel *m, int instance, instance_data *made)
{
    int sheets = number_of(m, instance, "sheets", &made->joint.sheets), start, i, count = 0;
    int width = number_of(m, instance, "width", &made->joint.width);
    if ((sheets == 0 && width == 0) || made->actuator < 0)
        return 1;
    if (sheets != 1 || width != 1 || !(made->joint.sheets >= 2 && made->joint.width > 0)) {
        mju_warning("layerjam.brake: over a joint, sheets of at least 2 and a width above zero are "
                    "needed, both");
        return 0;
    }
    start = m->tendon_adr[made->tendon];
    for (i = start; i < start + m->tendon_num[made->tendon]; i++) {
        if (m->wrap_type[i] != mjWRAP_CYLINDER && m->wrap_type[i] != mjWRAP_SPHERE)
            continue;
        made->geom = m->wrap_objid[i];
        count++;
    }
    if (count != 1) {
        mju_warning("layerjam.brake: over a joint, the tendon wraps one cylinder or sphere; this one "
                    "wraps %d", count);
        return 0;
    }
    made->joint.radius = (lj_real)m->geom_size[3 * made->geom];
    return 1;
}

/* The angle [rad] over which the tendon lies on the geom, from its two points there. The path before
 * them tells which way round: more than half a turn is possible. */
static lj_real wrap_angle(const mjModel *m, const mjData *d, const instance_data *made)
{
    int start = d->ten_wrapadr[made->tendon], i;
    const mjtNum *centre = d->geom_xpos + 3 * made->geom, *turn = d->geom_xmat + 9 * made->geom;
    mjtNum first[3], last[3], along[3], axis[3], cross[3], angle;
    for (i = start + 1; i < start + d->ten_wrapnum[made->tendon] - 1; i++)
        if (d->wrap_obj[i] == made->geom && d->wrap_obj[i + 1] == made->geom)
            break;
    if (i >= start + d->ten_wrapnum[made->tendon] - 1)
        return 0;
    mju_sub3(first, d->wrap_xpos + 3 * i, centre);
    mju_sub3(last, d->wrap_xpos + 3 * (i + 1), centre);
    mju_sub3(along, d->wrap_xpos + 3 * i, d->wrap_xpos + 3 * (i - 1));
    mju_cross(axis, first, along);
    if (m->geom_type[made->geom] == mjGEOM_CYLINDER || m->geom_type[made->geom] == mjGEOM_CAPSULE) {
        mjtNum of_geom[3] = {turn[2], turn[5], turn[8]};
        mju_scl3(of_geom, of_geom, mju_dot3(of_geom, axis) < 0 ? -1 : 1);
        mju_addToScl3(first, of_geom, -mju_dot3(first, of_geom));
        mju_addToScl3(last, of_geom, -mju_dot3(last, of_geom));
        mju_copy3(axis, of_geom);
    }
    mju_normalize3(axis);
    mju_cross(cross, first, last);
    angle = atan2(mju_dot3(axis, cross), mju_dot3(first, last));
    if (angle < -1e-3)
        angle += 2 * mjPI;
    return angle > 0 ? (lj_real)angle : 0; /* where the path just touches, rounding is no turn */
}

static int init(const mjModel *m, mjData *d, int instance)
{
    instance_data *made = calloc(1, sizeof *made);
    lj_real rest = 0;
    int found;
    if (!made)
        return -1;
    found = number_of(m, instance, "rest_length", &rest);
    if (found < 0)
        mju_warning("layerjam.brake: rest_length is no number");
    if (found < 0 || !read_brake(m, instance, made) || !read_coupling(m, instance, made) ||
        !read_actuator(m, instance, made) || !read_joint(m, instance, made)) {
        free(made);
        return -1;
    }
    made->rest_length = rest;
    made->has_rest_length = found;
    d->plugin_data[instance] = (uintptr_t)made;
    return 0;
}

static void destroy(mjData *d, int instance)
{
    free((void *)d->plugin_data[instance]);
    d->plugin_data[instance] = 0;
}

static void copy(mjData *dest, const mjModel *m, const mjData *src, int instance)
{
    (void)m;
    memcpy((void *)dest->plugin_data[instance], (const void *)src->plugin_data[instance],
           sizeof(instance_data));
}

static void reset(const mjModel *m, mjtNum *plugin_state, void *plugin_data, int instance)
{
    lj_state state;
    (void)m;
    (void)instance;
    lj_start(&state, 0);
    pack(plugin_state, &state);
    if (plugin_data)
        ((instance_data *)plugin_data)->asked = 0;
}

/* The vacuum [Pa]: the activation where there is one, otherwise the control within its range; the
 * last good one where that is no number or negative. */
static lj_real vacuum_of(const mjModel *m, const mjData *d, int actuator, const lj_state *state)
{
    mjtNum given;
    if (m->actuator_actnum[actuator] > 0) {
        given = d->act[m->actuator_actadr[actuator] + m->actuator_actnum[actuator] - 1];
    } else {
        int at = m->actuator_ctrladr[actuator];
        given = d->ctrl[at];
        if (m->actuator_delay[actuator] > 0) {
            const mjtNum *past = mj_readCtrl(m, d, actuator, d->time, &given, -1);
            given = past ? *past : given;
        }
        if (m->actuator_ctrllimited[at] && !(m->opt.disableflags & mjDSBL_CLAMPCTRL)) {
            given = given < m->actuator_ctrlrange[2 * at] ? m->actuator_ctrlrange[2 * at] : given;
            given = given > m->actuator_ctrlrange[2 * at + 1] ? m->actuator_ctrlrange[2 * at + 1]
                                                              : given;
        }
    }
    return given >= 0 && given < mjMAXVAL ? (lj_real)given : state->vacuum;
}

/* A = J M^-1 J^T of the tendon [1/kg]. */
static mjtNum mobility(const mjModel *m, mjData *d, int out)
{
    int start = d->moment_rowadr[out], count = d->moment_rownnz[out], i;
    mjtNum *pull, *answer, sum = 0;
    mj_markStack(d);
    pull = mj_stackAllocNum(d, (size_t)m->nv);
    answer = mj_stackAllocNum(d, (size_t)m->nv);
    memset(pull, 0, (size_t)m->nv * sizeof *pull);
    for (i = start; i < start + count; i++)
        pull[d->moment_colind[i]] = d->actuator_moment[i];
    mj_solveM(m, d, answer, pull, 1);
    for (i = start; i < start + count; i++)
        sum += d->actuator_moment[i] * answer[d->moment_colind[i]];
    mj_freeStack(d);
    return sum;
}

/* Compliance in series: limited softens the spring only where the step could not carry it. */
static lj_real compliance_of(const mjModel *m, mjData *d, const instance_data *made, int out)
{
    mjtNum step = m->opt.timestep, whole;
    if (made->coupling == EXPLICIT)
        return 0;
    whole = step * step * mobility(m, d, out);
    if (made->coupling == LIMITED)
        whole -= 1 / made->brake.stiffness;
    return whole > 0 ? (lj_real)whole : 0;
}

static void compute(const mjModel *m, mjData *d, int instance, int capability)
{
    instance_data *made = (instance_data *)d->plugin_data[instance];
    int actuator = made->actuator, out;
    const char *fault;
    mjtNum elongation;
    lj_real compliance;
    (void)capability;
    made->asked = 0;
    if (actuator < 0)
        return;
    out = m->actuator_outadr[actuator];
    d->actuator_force[out] = 0;
    if (m->actuator_group[actuator] >= 0 && m->actuator_group[actuator] < 31 &&
        m->opt.disableactuator & (1 << m->actuator_group[actuator]))
        return;
    fault = unpack(&made->next, d->plugin_state + m->plugin_stateadr[instance]);
    if (fault) { /* no force is right: MuJoCo notices a NaN, and resets the simulation */
        mju_warning("layerjam.brake: plugin_state is damaged: %s", fault);
        d->actuator_force[out] = NAN;
        return;
    }
    elongation = d->actuator_length[out];
    elongation -= made->has_rest_length ? made->rest_length : m->actuator_length0[out];
    compliance = compliance_of(m, d, made, out);
    if (made->coupling == IMPLICIT)
        elongation += m->opt.timestep * d->actuator_velocity[out];
    if (made->joint.radius > 0)
        made->joint.angle = wrap_angle(m, d, made);
    d->actuator_force[out] = -lj_move_over(&made->brake, &made->joint, &made->next,
                                           (lj_real)elongation,
                                           vacuum_of(m, d, actuator, &made->next), compliance);
    made->asked = 1;
}

static void advance(const mjModel *m, mjData *d, int instance)
{
    instance_data *made = (instance_data *)d->plugin_data[instance];
    if (made->asked)
        pack(d->plugin_state + m->plugin_stateadr[instance], &made->next);
    made->asked = 0;
}

/* Registered when the library is loaded: mjPLUGIN_LIB_INIT differs between versions. */
__attribute__((constructor)) static void layerjam_register(void)
{
    mjpPlugin plugin;
    int slot;
    if (mj_version() != mjVERSION_HEADER) {
        fprintf(stderr,
                "layerjam.brake was built for MuJoCo %d and this is %d: run layerjam export mujoco "
                "again\n",
                mjVERSION_HEADER, mj_version());
        return;
    }
    /* MuJoCo ends the program for a name that it has already: a second copy of this library is fine */
    if (mjp_getPlugin("layerjam.brake", &slot))
        return;
    mjp_defaultPlugin(&plugin);
    plugin.name = "layerjam.brake";
    plugin.nattribute = (int)(sizeof ATTRIBUTES / sizeof *ATTRIBUTES);
    plugin.attributes = ATTRIBUTES;
    plugin.capabilityflags |= mjPLUGIN_ACTUATOR;
    plugin.nstate = state_size;
    plugin.init = init;
    plugin.destroy = destroy;
    plugin.copy = copy;
    plugin.reset = reset;
    plugin.compute = compute;
    plugin.advance = advance;
    mjp_registerPlugin(&plugin);
}
