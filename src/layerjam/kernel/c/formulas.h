/* Printed by layerjam/kernel/formulas.py from the Python laws. Apache License 2.0. */

typedef struct {
    lj_real stiffness;
    lj_real friction;
    lj_real reach;
    lj_real root;
    lj_real saturation;
} lj_enclosure;

static inline lj_enclosure lj_enclosure_of(lj_real stiffness, lj_real friction, lj_real reach)
{
    lj_real root = LJ(2) * lj_sqrt(stiffness * friction);
    return (lj_enclosure){stiffness, friction, reach, root, friction * lj_square(reach) /
        stiffness};
}

static inline lj_enclosure lj_branch(lj_real strength, const lj_enclosure *enclosure)
{
    return lj_enclosure_of(enclosure->stiffness, strength, enclosure->reach);
}

static inline lj_real lj_backbone(lj_real slip, const lj_enclosure *enclosure)
{
    lj_real spread = enclosure->root * lj_sqrt(slip);
    lj_real whole = enclosure->stiffness * slip / enclosure->reach + enclosure->friction *
        enclosure->reach;
    return (slip < enclosure->saturation ? spread : (slip > LJ(0) ? whole : LJ(0.0)));
}

static inline lj_real lj_backbone_work(lj_real slip, const lj_enclosure *enclosure)
{
    lj_real start = lj_min(slip, enclosure->saturation);
    lj_real spread = enclosure->root * start * lj_sqrt(start) * (LJ(2) / LJ(3));
    lj_real beyond = slip - start;
    lj_real whole = enclosure->stiffness * (slip + start) / (LJ(2) * enclosure->reach);
    whole = (whole + enclosure->friction * enclosure->reach) * beyond;
    return spread + whole;
}

static inline lj_real lj_backbone_stored(lj_real slip, const lj_enclosure *enclosure)
{
    lj_real spread = enclosure->root * slip * lj_sqrt(slip) / LJ(3);
    lj_real face = lj_backbone(slip, enclosure) / LJ(2);
    lj_real q = enclosure->friction;
    lj_real reach = enclosure->reach;
    lj_real whole = LJ(2) * reach * (lj_square(face) - face * q * reach + lj_square(q * reach) /
        LJ(3)) / enclosure->stiffness;
    return (slip < enclosure->saturation ? spread : whole);
}

static inline lj_real lj_slipped_area(lj_real slip, const lj_enclosure *enclosure)
{
    lj_real start = lj_min(slip, enclosure->saturation);
    lj_real q = (enclosure->friction > LJ(0) ? enclosure->friction : LJ(1.0));
    return enclosure->root * start * lj_sqrt(start) / (LJ(3) * q) + enclosure->reach * (slip -
        start);
}

static inline lj_real lj_backbone_dissipated(lj_real slip, const lj_enclosure *enclosure)
{
    return enclosure->friction * lj_slipped_area(slip, enclosure);
}

static inline lj_real lj_inverse_backbone(lj_real force, const lj_enclosure *enclosure)
{
    lj_real at_saturation = LJ(2) * enclosure->friction * enclosure->reach;
    lj_real whole = (force - enclosure->friction * enclosure->reach) * enclosure->reach /
        enclosure->stiffness;
    lj_real square = lj_square((enclosure->root > LJ(0) ? enclosure->root : LJ(1.0)));
    return (force < at_saturation ? lj_square(force) / square : whole);
}

static inline lj_real lj_rising_root(lj_real drive, lj_real spring, const lj_enclosure *enclosure)
{
    lj_real push = lj_max(drive, LJ(0.0));
    lj_real below = enclosure->root + lj_sqrt(lj_square(enclosure->root) + LJ(4) * spring * push);
    lj_real root = LJ(2) * push / (below > LJ(0) ? below : LJ(1.0));
    lj_real linear = push - enclosure->friction * enclosure->reach;
    linear = linear / (spring + enclosure->stiffness / enclosure->reach);
    return (lj_square(root) < enclosure->saturation ? lj_square(root) : lj_max(linear, LJ(0.0)));
}

static inline lj_real lj_slid_back_stored(lj_real force, const lj_enclosure *enclosure)
{
    lj_real face = force / LJ(2);
    lj_real full = enclosure->friction * enclosure->reach;
    return LJ(2) * enclosure->reach * (lj_square(face) + face * full + lj_square(full) / LJ(3)) /
        enclosure->stiffness;
}

static inline lj_real lj_crossing(lj_real slip, lj_real force, const lj_enclosure *enclosure)
{
    lj_real root = lj_sqrt(LJ(2.0)) * enclosure->root;
    lj_real slope = enclosure->stiffness / enclosure->reach;
    lj_real short_ = lj_max(slope * slip + enclosure->friction * enclosure->reach - force, LJ(0.0));
    lj_real rest = lj_sqrt(lj_max(lj_square(root) - LJ(4) * slope * short_, LJ(0.0)));
    return slip + lj_square((root - rest) / (LJ(2) * slope));
}

static inline lj_real lj_force_of_stored(lj_real stored, const lj_enclosure *enclosure)
{
    stored = lj_max(stored, LJ(0.0));
    int positive = stored * enclosure->root > LJ(0);
    lj_real spread = lj_cbrt((positive ? LJ(3) * stored * lj_square(enclosure->root) : LJ(1.0)));
    spread = (positive ? spread : LJ(0.0));
    lj_real full = enclosure->friction * enclosure->reach;
    lj_real square = LJ(2) * stored * enclosure->stiffness / enclosure->reach - lj_square(full) /
        LJ(3);
    lj_real whole = full + lj_sqrt(lj_max(square, LJ(0.0)));
    return (spread < LJ(2) * full ? spread : whole);
}
