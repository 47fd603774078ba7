/* Printed from the Python laws by tests/c_printers/formulas.py. Apache License 2.0. */

typedef struct {
    lj_real stiffness;
    lj_real friction;
    lj_real reach;
    lj_real root;
    lj_real saturation;
} lj_enclosure;

static inline lj_enclosure lj_make_enclosure(lj_real stiffness, lj_real friction, lj_real reach)
{
    lj_real root = LJ(2) * lj_sqrt(stiffness * friction);
    return (lj_enclosure){stiffness, friction, reach, root, friction * lj_square(reach) /
        stiffness};
}

static inline lj_enclosure lj_branch(lj_real strength, const lj_enclosure *enclosure)
{
    return lj_make_enclosure(enclosure->stiffness, strength, enclosure->reach);
}

static inline lj_real lj_spread_root(lj_real drive, lj_real spring, const lj_enclosure *enclosure)
{
    lj_real push = lj_max(drive, LJ(0.0));
    lj_real divisor = enclosure->root + lj_sqrt(lj_square(enclosure->root) + LJ(4) * spring * push);
    return LJ(2) * push / (divisor > LJ(0) ? divisor : LJ(1.0));
}
