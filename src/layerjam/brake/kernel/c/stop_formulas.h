/* Printed from the Python laws by tests/c_printers/formulas.py. Apache License 2.0. */

typedef struct {
    lj_real stiffness;
    lj_real friction;
    lj_real reach;
    lj_real root;
    lj_real saturation;
} lj_enclosure;

typedef struct {
    lj_real mass;
    lj_real arriving;
    lj_real weight;
    lj_real c;
    lj_real onset;
    lj_real k;
    lj_real compliance;
    lj_enclosure enclosure;
    lj_real kinetic;
} lj_case;

typedef struct {
    lj_real a0;
    lj_real a1;
    lj_real a2;
    lj_real a3;
    lj_real a4;
} lj_energy;

typedef struct {
    lj_energy energy;
    lj_real low;
    lj_real high;
    lj_real stops;
    lj_real limit;
    lj_real snaps;
} lj_bracket;

typedef struct {
    lj_real slip;
    lj_real peak_force;
    lj_real end_speed;
    lj_real heat;
    lj_real stored;
    lj_real outcome;
} lj_end;

static inline lj_case lj_make_setup(lj_real mass, lj_real speed, lj_real c, lj_real overlap, const
        lj_enclosure *enclosure, lj_real spring, lj_real gravity)
{
    lj_real weight = mass * gravity;
    lj_real onset = c * overlap;
    lj_real arriving = mass * speed * speed / LJ(2);
    lj_real compliance = LJ(1) / spring;
    lj_real kinetic = arriving + (weight * onset - onset * onset / LJ(2)) * compliance;
    return (lj_case){mass, arriving, weight, c, onset, spring, compliance, *enclosure, kinetic};
}

static inline lj_real lj_positive_root(lj_real square)
{
    int positive = square > LJ(0);
    return (positive ? lj_sqrt((positive ? square : LJ(1.0))) : LJ(0.0));
}

static inline lj_real lj_balance_root(const lj_case *case_, lj_real limit)
{
    lj_real margin = case_->onset - case_->weight;
    lj_real slope = case_->c - case_->enclosure.stiffness / case_->enclosure.reach;
    lj_real linear = margin + case_->enclosure.friction * case_->enclosure.reach;
    int is_falling = slope > LJ(0);
    int spreads = is_falling && slope * case_->enclosure.saturation > linear;
    lj_real square = case_->enclosure.root * case_->enclosure.root + LJ(4) * case_->c * margin;
    lj_real radicand = (spreads ? square : slope * linear);
    lj_real root = (spreads ? case_->enclosure.root : LJ(0.0)) + lj_positive_root(radicand);
    root = root / (spreads ? LJ(2) * case_->c : (is_falling ? slope : LJ(1.0)));
    return lj_min((is_falling && radicand >= LJ(0) ? root : limit), limit);
}

static inline lj_energy lj_quartic(const lj_case *case_, lj_real linear)
{
    lj_real c = case_->c;
    lj_real e = case_->enclosure.root;
    lj_real compliance = case_->compliance;
    lj_real excess = case_->weight - case_->onset;
    lj_real slope = case_->enclosure.stiffness / case_->enclosure.reach;
    lj_real step = case_->enclosure.friction * case_->enclosure.reach;
    lj_real fall = c - slope;
    lj_real sixth = case_->enclosure.saturation * (LJ(1) / LJ(6));
    lj_real base = case_->kinetic + step * sixth + (excess - step / LJ(2)) * step * compliance;
    lj_real bend = excess - step + (step - excess) * fall * compliance;
    return (lj_energy){(linear ? base : case_->kinetic), (linear ? LJ(0.0) : excess * e *
        compliance), (linear ? bend : excess - excess * c * compliance - e * e * compliance /
        LJ(2)), (linear ? LJ(0.0) : (c * compliance - LJ(2) / LJ(3)) * e), (linear ? fall - fall *
        fall * compliance : c - c * c * compliance) / LJ(2)};
}

static inline lj_real lj_quartic_value(const lj_energy *p, lj_real w)
{
    return p->a0 + w * (p->a1 + w * (p->a2 + w * (p->a3 + w * p->a4)));
}

static inline lj_real lj_quartic_slope(const lj_energy *p, lj_real w)
{
    return p->a1 + w * (LJ(2) * p->a2 + w * (LJ(3) * p->a3 + w * LJ(4) * p->a4));
}

static inline lj_real lj_snap_root(lj_real soft, const lj_enclosure *enclosure)
{
    int runs = soft > enclosure->stiffness / enclosure->reach;
    return (runs ? enclosure->root / (LJ(2) * (runs ? soft : LJ(1.0))) : LJ_INFINITY);
}

static inline lj_bracket lj_bracket_root(const lj_case *case_, lj_real travel)
{
    lj_real all_of_it = lj_positive_root(travel);
    lj_real snap = lj_snap_root(case_->c - case_->k, &case_->enclosure);
    lj_real saturation = case_->enclosure.root * (case_->enclosure.reach / (LJ(2) *
        case_->enclosure.stiffness));
    lj_real end = lj_min(lj_balance_root(case_, all_of_it), snap);
    lj_real edge = lj_min(saturation, end);
    lj_energy start = lj_quartic(case_, case_->c < LJ(0));
    int linear = (edge < end ? lj_quartic_value(&start, edge) : LJ(-1.0)) >= LJ(0);
    lj_energy energy = lj_quartic(case_, linear);
    lj_real low = (linear ? edge : LJ(0.0));
    lj_real high = (linear ? end : edge);
    lj_real limit = lj_min(all_of_it, snap);
    return (lj_bracket){energy, low, high, lj_quartic_value(&energy, high) <= LJ(0), limit, snap <
        all_of_it};
}

static inline lj_real lj_guess_root(const lj_energy *p, lj_real low, lj_real high)
{
    lj_real down = lj_positive_root(p->a2 * p->a2 - LJ(4) * p->a0 * p->a4) - p->a2;
    int is_falling = down > LJ(0);
    lj_real guess = lj_positive_root(LJ(2) * p->a0 / (is_falling ? down : LJ(1.0)));
    return lj_min(lj_max((is_falling ? guess : high), low), high);
}

static inline lj_real lj_curvature_step(const lj_energy *p, lj_real w, lj_real low, lj_real high)
{
    lj_real first = lj_quartic_slope(p, w);
    lj_real second = LJ(2) * p->a2 + w * (LJ(6) * p->a3 + w * LJ(12) * p->a4);
    lj_real energy = lj_quartic_value(p, w);
    lj_real down = lj_positive_root(first * first - LJ(2) * energy * second) - first;
    int is_falling = down > LJ(0);
    lj_real new = (is_falling ? w + LJ(2) * energy / (is_falling ? down : LJ(1.0)) : high);
    return lj_min(lj_max(new, low), high);
}

static inline lj_real lj_polish_root(const lj_energy *p, lj_real root, lj_real slope)
{
    int down = slope < LJ(0);
    lj_real step = (down ? lj_quartic_value(p, root) / (down ? slope : LJ(-1.0)) : LJ(0.0));
    return lj_max(root - step, LJ(0.0));
}

static inline lj_end lj_make_stop(const lj_case *case_, const lj_bracket *bracket, lj_real root)
{
    lj_real mass = case_->mass;
    lj_enclosure enclosure = case_->enclosure;
    lj_real swing = case_->weight * case_->weight + LJ(2) * case_->k * case_->arriving;
    lj_real lack = case_->onset - case_->weight;
    int is_sliding = lack < LJ(0) || swing > lack * lack;
    lj_real is_stopped = bracket->stops;
    lj_real w = (is_sliding ? (is_stopped ? root : bracket->limit) : LJ(0.0));
    lj_real slip = w * w;
    lj_real outcome = (is_stopped ? LJ(0) : (bracket->snaps ? LJ(3) : LJ(2)));
    outcome = (is_sliding ? outcome : LJ(1));
    int linear = slip >= enclosure.saturation;
    lj_real push = enclosure.friction * enclosure.reach;
    lj_real line = enclosure.stiffness / enclosure.reach * slip + push;
    lj_real pull = (linear ? line : enclosure.root * w);
    lj_real resist = case_->onset - case_->c * slip + pull;
    int is_falling = case_->c > LJ(0);
    lj_real ratio = enclosure.root / (LJ(2) * (is_falling ? case_->c : LJ(1.0)));
    int is_passed = is_falling && ratio * ratio < lj_min(slip, enclosure.saturation);
    lj_real top = case_->onset + enclosure.root * (is_passed ? ratio : LJ(0.0)) / LJ(2);
    lj_real highest = lj_max(lj_max(resist, top), case_->onset);
    lj_real spread = enclosure.root * slip * w * (LJ(1) / LJ(3));
    lj_real linear_heat = push * (slip - enclosure.saturation) + LJ(2) * push * enclosure.saturation
        * (LJ(1) / LJ(3));
    lj_real face = line / LJ(2);
    lj_real linear_energy = face * face - face * push + push * push * (LJ(1) / LJ(3));
    linear_energy = LJ(2) * enclosure.reach / enclosure.stiffness * linear_energy;
    lj_real heat = case_->onset * slip - case_->c * slip * slip / LJ(2) + (linear ? linear_heat :
        spread);
    lj_real energy = resist * resist * case_->compliance / LJ(2) + (linear ? linear_energy :
        spread);
    lj_real energy_left = case_->arriving + case_->weight * (slip + resist * case_->compliance) -
        heat - energy;
    lj_real pace = lj_positive_root((is_sliding ? (is_stopped ? LJ(0.0) : LJ(2) * energy_left /
        mass) : swing));
    lj_real elastic = case_->weight + pace;
    return (lj_end){slip, (is_sliding ? highest : elastic), (is_sliding ? pace : LJ(0.0)), heat,
        (is_sliding ? energy : elastic * elastic * case_->compliance / LJ(2)), outcome};
}

static inline lj_real lj_first_loading(lj_real slip, const lj_enclosure *enclosure)
{
    lj_real spread = enclosure->root * lj_sqrt(slip);
    lj_real linear = enclosure->stiffness * slip / enclosure->reach + enclosure->friction *
        enclosure->reach;
    return (slip < enclosure->saturation ? spread : (slip > LJ(0) ? linear : LJ(0.0)));
}
