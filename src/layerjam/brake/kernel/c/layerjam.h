/* layerjam: the force of a soft layer-jamming brake, move by move.
 *
 * The sheets stick at a stiffness and slide at their friction, the enclosure remembers the tension
 * along its strips. Only the path counts, never the time: a move may have any
 * length and is taken as straight, and a held load is held, bit for bit. SI units throughout.
 *
 *     lj_state state;
 *     lj_start(&state, 0);
 *     force = lj_move(&brake, &state, elongation, vacuum, 0);
 *
 * C99; no allocation, no global data, no input or output. What it needs from outside is sqrt, pow
 * (with a pressure exponent only) and memcpy. Define LJ_SINGLE for float in place of double.
 * Compile with -ffp-contract=off for the same bits on every processor.
 *
 * Part of layerjam. Apache License 2.0.
 */
#ifndef LAYERJAM_H
#define LAYERJAM_H

#include <stddef.h>
#include <stdint.h>

/* What is not below LJ_LIMIT is refused: the square of an input must be a number. */
#ifdef LJ_SINGLE
typedef float lj_real;
#define LJ_LIMIT ((lj_real)1e9)
#else
typedef double lj_real;
#define LJ_LIMIT 1e30
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* Turning points remembered in either direction, nested loops one inside the other. */
#define LJ_DEPTH 16
/* Pieces of the enclosure's tension: 2 LJ_DEPTH + 5. */
#define LJ_PIECES 37
/* Number of this layout of lj_state; a state of another layout is refused. */
#define LJ_LAYOUT 2

/* The brake: eight numbers. */
typedef struct {
    lj_real contact;             /* friction of the sheets per vacuum and overlap, a mu_k (n-1) W [m] */
    lj_real overlap;             /* overlap at rest [m] */
    lj_real stiffness;           /* of brake, mount and rope in series [N/m] */
    lj_real enclosure_stiffness; /* EA of one face of the enclosure [N] */
    lj_real enclosure_contact;   /* friction of one face per vacuum and length, mu_e W [m] */
    lj_real reach;               /* half the free length of the enclosure [m] */
    lj_real exponent;            /* of the friction over pressure, 0: proportional */
    lj_real test_pressure;       /* the pressure that the exponent refers to [Pa] */
} lj_brake;

/* What state.flags holds. LJ_REFUSED and LJ_SLACK are of the last call, the others stay. */
#define LJ_REFUSED 1u    /* an input was no number that is allowed: nothing else changed */
#define LJ_SLACK 2u      /* the brake is longer than the elongation, and carries nothing */
#define LJ_SEPARATED 4u  /* the overlap was used up: the enclosure alone pulls from there on */
#define LJ_CLOSED 8u     /* the enclosure has pulled the brake back */
#define LJ_SNAPPED 16u   /* it slid on a stiffness below its friction's slope, and may have jumped */
#define LJ_OVERFLOW 32u  /* more than LJ_DEPTH nested turns: the force goes on without the last */

/* What state.motion holds: the last move. */
#define LJ_STUCK 0u
#define LJ_OUTWARD 1u
#define LJ_INWARD 2u

/* The brake between two moves: plain data. A copy is a snapshot, its bytes are a file. This is the
 * only place that lists its members: numbers first, `flags` after the last of them. */
typedef struct {
    lj_real elongation; /* [m] */
    lj_real vacuum;     /* [Pa] */
    lj_real force;      /* [N], never negative */
    lj_real slip;       /* [m] */
    lj_real work;       /* external work done on the brake so far [J] */
    lj_real heat;       /* energy dissipated so far [J], summed on its own */
    /* the enclosure */
    lj_real enclosure_force;  /* [N] */
    lj_real enclosure_stored; /* its elastic energy [J] */
    /* its tension along half a face, in straight pieces, the innermost first */
    lj_real ends[LJ_PIECES];   /* how far each reaches from the driven end, over half the length */
    lj_real slopes[LJ_PIECES]; /* slope of the tension over that distance [N/m] */
    uint32_t flags;
    uint8_t count, motion, layout, unused;
} lj_state;

/* Which of the eight numbers is not allowed, 1 to 8 in their order; 0 if all are fine. */
int lj_check(const lj_brake *brake);

/* What is wrong with a state that was read from a file or from another program: a sentence, or null
 * if nothing is. Every function here expects a state without such a fault. A chip that reads no
 * states spends nothing on it. */
static inline const char *lj_state_fault(const lj_state *s)
{
    const lj_real *numbers = (const lj_real *)(const void *)s;
    size_t i;
    if (s->layout != LJ_LAYOUT)
        return "a state of another version";
    if (s->count < 2 || s->count >= LJ_PIECES)
        return "more turning points than are remembered";
    if (s->motion > LJ_INWARD || s->flags > (LJ_OVERFLOW << 1) - 1)
        return "an unknown direction, motion or flag";
    for (i = 0; i < offsetof(lj_state, flags) / sizeof *numbers; i++)
        if (!(numbers[i] > -LJ_LIMIT && numbers[i] < LJ_LIMIT))
            return "a number that is not finite";
    if (!(s->vacuum >= 0 && s->force >= 0 && s->slip >= 0))
        return "a vacuum, force or slip below zero";
    for (i = 0; i < s->count; i++)
        if (!(s->ends[i] >= 0 && s->ends[i] <= (i < 2 ? 1 : s->ends[i - 1])))
            return "pieces of tension in disorder";
    return 0;
}

/* A brake at rest: no slip, no force, no elongation, under a vacuum [Pa]. */
void lj_start(lj_state *state, lj_real vacuum);

/* Take a vacuum [Pa] at the elongation of the last call, then move to an elongation [m]; the force
 * [N]. An elongation below the brake's length is slack. A compliance [m/N] in series, 0 for none, is
 * for solvers: the elongation is then the one that would be reached without any force, and what
 * the brake itself gets is less by compliance times force. A vacuum below zero, NaN, infinite and
 * absurdly large numbers are refused: LJ_REFUSED, and the last force. */
lj_real lj_move(const lj_brake *brake, lj_state *state, lj_real elongation, lj_real vacuum,
                lj_real compliance);

/* The force [N] that lj_move would return; the state stays as it is. */
lj_real lj_peek(const lj_brake *brake, const lj_state *state, lj_real elongation, lj_real vacuum,
                lj_real compliance);

/* Slope of the force over the elongation [N/m], going on as in the last move. */
lj_real lj_tangent(const lj_brake *brake, const lj_state *state, lj_real compliance);

/* Slope of the force over a falling vacuum [N/Pa]; a rising one changes no force at rest. */
lj_real lj_vacuum_tangent(const lj_brake *brake, const lj_state *state, lj_real compliance);

/* Elastic energy [J] in enclosure, sheets, mount and rope; work - heat of a brake from rest. */
lj_real lj_stored(const lj_brake *brake, const lj_state *state);

#ifdef __cplusplus
}
#endif

#endif
