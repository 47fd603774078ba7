/* Printed from the Python loops by tests/c_printers/loop_printer.py. Apache License 2.0. */

typedef struct {
    double *place;
    double *slope;
    double *level;
    double *low;
    double *high;
} Knots;

/* Find z minimising 1/2 sum d (z - b)^2 + sum c |z_{i+1} - z_i|, exactly, for n sheets. */
static void fused_lasso(int64_t n, double *d, double *b, double *c, double *z, Knots *knots)
{
    double bound, first_level, first_slope, last_level, last_slope;
    double *high, *level, *low, *slope, *x;
    int64_t i, j, left, right;
    x = knots->place;
    slope = knots->slope;
    level = knots->level;
    low = knots->low;
    high = knots->high;
    left = n - 1;
    right = n;
    low[0] = b[0] - c[0] / d[0];
    high[0] = b[0] + c[0] / d[0];
    x[left] = low[0];
    x[right] = high[0];
    slope[left] = d[0];
    level[left] = -d[0] * b[0] + c[0];
    slope[right] = -d[0];
    level[right] = d[0] * b[0] + c[0];
    for (int64_t k = 1; k < n; k++) {
        first_slope = d[k];
        first_level = -d[k] * b[k] - c[k - 1];
        last_slope = -d[k];
        last_level = d[k] * b[k] - c[k - 1];
        bound = k < n - 1 ? c[k] : 0.0;
        i = left;
        while (i <= right && first_slope * x[i] + first_level <= -bound) {
            first_slope += slope[i];
            first_level += level[i];
            i += 1;
        }
        if (k == n - 1) {
            z[k] = -first_level / first_slope;
            break;
        }
        j = right;
        while (j >= i && -last_slope * x[j] - last_level >= bound) {
            last_slope += slope[j];
            last_level += level[j];
            j -= 1;
        }
        low[k] = (-bound - first_level) / first_slope;
        high[k] = -(bound + last_level) / last_slope;
        left = i - 1;
        right = j + 1;
        x[left] = low[k];
        slope[left] = first_slope;
        level[left] = first_level + bound;
        x[right] = high[k];
        slope[right] = last_slope;
        level[right] = last_level + bound;
    }
    for (int64_t k = n - 2; k > -1; k--) {
        z[k] = lj_min(lj_max(z[k + 1], low[k]), high[k]);
    }
}

typedef struct {
    double (*gaps)[64];
    double (*pushes)[64];
    int64_t *counts;
    int64_t *heading;
    double *gap;
    double *push;
    double *energy;
} Faces;

typedef struct { double v0; double v1; } ResultDD;

/* Return the gap at which first loading carries `force`, and its slope. */
static ResultDD first_gap(double force, double *face)
{
    double q, reach, stiff;
    stiff = face[0];
    q = face[1];
    reach = face[2];
    if (force < q * reach) {
        return (ResultDD){force * force / (stiff * q), 2 * force / (stiff * q)};
    }
    return (ResultDD){(force - q * reach / 2) * 2 * reach / stiff, 2 * reach / stiff};
}

/* Return work and heat of first loading to `gap` [J], one face. */
static ResultDD first_work(double gap, double *face)
{
    double linear_gap, linear_work, q, reach, root, start, stiff;
    stiff = face[0];
    q = face[1];
    reach = face[2];
    start = lj_min(gap, q * reach * reach / stiff);
    root = (sqrt(stiff * q * start)) * start / 3;
    linear_gap = gap - start;
    linear_work = (stiff * (gap + start) / (4 * reach) + q * reach / 2) * linear_gap;
    return (ResultDD){2 * root + linear_work, root + q * reach * linear_gap / 2};
}

/* Return the gap at which face `e` carries `push`, and its slope, by Masing's rule. */
static ResultDD face_gap(double push, int64_t e, Faces *faces, double *face)
{
    double force, gap, half, slope;
    double *gaps, *pushes;
    int64_t close, direction, first, origin;
    direction = push >= faces->push[e] ? 1 : -1;
    gaps = faces->gaps[e];
    pushes = faces->pushes[e];
    origin = faces->counts[e] - 1;
    close = faces->counts[e] - 2;
    gap = 0.0;
    force = 0.0;
    first = origin < 0;
    if (direction == faces->heading[e]) {
        if (!first) {
            gap = gaps[origin];
            force = pushes[origin];
        }
    } else {
        gap = faces->gap[e];
        force = faces->push[e];
        first = 0;
        close = close + 1;
    }
    while (close >= 0 && direction * (push - pushes[close]) >= 0) {
        first = close == 0;
        if (!first) {
            gap = gaps[close - 1];
            force = pushes[close - 1];
        }
        close -= 2;
    }
    if (first) {
        return first_gap(push, face);
    }
    ResultDD result1 = first_gap(direction * (push - force) / 2, face);
    half = result1.v0;
    slope = result1.v1;
    return (ResultDD){gap + direction * 2 * half, slope};
}

typedef struct { double v0; double v1; int64_t v2; } ResultDDI;

/* Move face `e` to `push` and return work and heat [J]. */
static ResultDDI move_face(double push, int64_t e, Faces *faces, double *face)
{
    ResultDD after, before;
    double end, force, gap, goal, half, heat, work;
    double *gaps, *pushes;
    int64_t closes, count, direction;
    work = 0.0;
    heat = 0.0;
    if (push == faces->push[e]) {
        return (ResultDDI){work, heat, 0};
    }
    direction = push > faces->push[e] ? 1 : -1;
    gaps = faces->gaps[e];
    pushes = faces->pushes[e];
    if (direction != faces->heading[e]) {
        if (faces->counts[e] == 64) {
            return (ResultDDI){work, heat, 2};
        }
        gaps[faces->counts[e]] = faces->gap[e];
        pushes[faces->counts[e]] = faces->push[e];
        faces->counts[e] += 1;
        faces->heading[e] = direction;
    }
    while (faces->push[e] != push) {
        count = faces->counts[e];
        closes = count >= 2 && direction * (push - pushes[count - 2]) >= 0;
        end = closes ? gaps[count - 2] : 0.0;
        goal = closes ? pushes[count - 2] : push;
        if (count == 0) {
            ResultDD result1 = first_gap(push, face);
            end = result1.v0;
            after = first_work(end, face);
            before = first_work(faces->gap[e], face);
            work += after.v0 - before.v0;
            heat += after.v1 - before.v1;
        } else {
            gap = gaps[count - 1];
            force = pushes[count - 1];
            if (!closes) {
                ResultDD result2 = first_gap(direction * (push - force) / 2, face);
                half = result2.v0;
                end = gap + direction * 2 * half;
            }
            after = first_work(direction * (end - gap) / 2, face);
            before = first_work(direction * (faces->gap[e] - gap) / 2, face);
            work += force * (end - faces->gap[e]) + 4 * (after.v0 - before.v0);
            heat += 2 * (after.v1 - before.v1);
        }
        faces->gap[e] = end;
        faces->push[e] = goal;
        if (closes) {
            faces->counts[e] -= 2;
        }
    }
    return (ResultDDI){work, heat, 0};
}

typedef struct {
    double *springs;
    uint8_t *right;
    double *friction;
    double *ratio;
    double *length;
    double mount;
    int64_t *ends;
    double *face;
    int64_t one_by_one;
    int64_t sheet_count;
} Stack;

typedef struct {
    double *past;
    int64_t *slides;
    uint8_t *moving;
    double *sheets;
    double *interface;
    double *values;
    Faces faces;
} State;

typedef struct {
    int64_t *slides;
    double *z;
    double *sheets;
    double *force;
    double *slip;
    double *push;
    double *pull;
    double *values;
    double *offset;
    double *bound;
    double *centre;
    int64_t *group;
    double *diagonal;
    double *couple;
    double (*terms)[4];
    Knots knots;
    uint8_t *marks;
} Trial;

/* Return the kinetic friction of interface i at w_{i+1} - w_i = slip [N]. */
static double bound(int64_t i, double slip, Stack *stack)
{
    double forward;
    forward = stack->right[i] ? -slip : slip;
    return lj_max(stack->friction[i] * (1.0 - forward / stack->length[i]), 0.0);
}

/* Return the sum of all anchor springs [N/m]. */
static double stiffness_sum(Stack *stack)
{
    double stiff;
    stiff = 0.0;
    for (int64_t i = 0; i < stack->sheet_count; i++) {
        stiff += stack->springs[i];
    }
    return stiff;
}

/* Return the tolerance [N] within which the force of interface i counts as its bound. */
static double margin(int64_t i, double reach, double stiff, Stack *stack)
{
    return 1e-11 * stack->friction[i] + 4e-16 * stiff * reach;
}

/* Return whether interface i rests on static friction that exceeds kinetic friction. */
static int64_t is_held(int64_t i, Stack *stack, State *state)
{
    return stack->ratio[i] > 1.0 && !state->moving[i] && bound(i, state->past[i], stack) > 0.0;
}

/* Compute how groups of stuck sheets follow cap and faces, for the pattern of `t`. */
static void compute_response(Stack *stack, State *state, Trial *t)
{
    double couple, d, diagonal, factor, hold, sign, soft, total;
    int64_t end, j, last, n;
    n = stack->sheet_count;
    t->offset[0] = 0.0;
    for (int64_t i = 0; i < n - 1; i++) {
        t->offset[i + 1] = t->offset[i] + state->past[i];
    }
    j = 0;
    total = 0.0;
    for (int64_t m = 0; m < 4; m++) {
        t->terms[0][m] = 0.0;
    }
    for (int64_t i = 0; i < n; i++) {
        d = stack->springs[i];
        total += d;
        t->group[i] = j;
        t->terms[j][0] -= d * t->offset[i];
        if (stack->right[i]) {
            t->terms[j][1] += d;
        }
        last = i == n - 1;
        if (last || t->slides[i] != 0) {
            t->diagonal[j] = total + (j > 0 ? t->diagonal[j] : 0.0);
            if (!last) {
                sign = stack->right[i] ? -1.0 : 1.0;
                hold = 0.0;
                soft = 0.0;
                if (sign * t->slip[i] < stack->length[i]) {
                    soft = t->slides[i] * sign * stack->friction[i] / stack->length[i];
                    hold = t->slides[i] * stack->friction[i] - soft * state->past[i];
                }
                t->couple[j] = soft;
                t->diagonal[j] -= soft;
                t->diagonal[j + 1] = -soft;
                t->terms[j][0] += hold;
                t->terms[j + 1][0] = -hold;
                for (int64_t m = 1; m < 4; m++) {
                    t->terms[j + 1][m] = 0.0;
                }
                j = j + 1;
                total = 0.0;
            }
        }
    }
    for (int64_t e = 0; e < 2; e++) {
        end = stack->ends[e];
        t->terms[t->group[end]][2 + e] = stack->right[end] ? -1.0 : 1.0;
    }
    diagonal = t->diagonal[0];
    for (int64_t k = 1; k < j + 1; k++) {
        factor = t->couple[k - 1] / diagonal;
        diagonal = t->diagonal[k] - factor * t->couple[k - 1];
        t->diagonal[k] = diagonal;
        for (int64_t m = 0; m < 4; m++) {
            t->terms[k][m] -= factor * t->terms[k - 1][m];
        }
    }
    for (int64_t m = 0; m < 4; m++) {
        t->terms[j][m] /= diagonal;
    }
    for (int64_t k = j - 1; k > -1; k--) {
        couple = t->couple[k];
        diagonal = t->diagonal[k];
        for (int64_t m = 0; m < 4; m++) {
            t->terms[k][m] = (t->terms[k][m] - couple * t->terms[k + 1][m]) / diagonal;
        }
    }
}

/* Compute sheets, forces and slips of the pattern of `t` from its cap and faces. */
static void lay_out_sheets(Stack *stack, State *state, Trial *t)
{
    double cap, force, p0, p1, stretch, total;
    int64_t j, n;
    n = stack->sheet_count;
    cap = t->values[0];
    p0 = t->push[0];
    p1 = t->push[1];
    total = 0.0;
    force = 0.0;
    for (int64_t i = 0; i < n; i++) {
        j = t->group[i];
        t->z[i] = t->terms[j][0] + t->terms[j][1] * cap + t->terms[j][2] * p0 + t->terms[j][3] * p1;
        t->sheets[i] = t->z[i] + t->offset[i];
        stretch = t->sheets[i] - (stack->right[i] ? cap : 0.0);
        force += stack->springs[i] * stretch;
        for (int64_t e = 0; e < 2; e++) {
            if (i == stack->ends[e]) {
                force += stack->right[i] ? t->push[e] : -t->push[e];
                total += stack->right[i] ? 0.0 : t->push[e];
            }
        }
        if (stack->right[i]) {
            total -= stack->springs[i] * stretch;
        }
        if (i < n - 1) {
            t->force[i] = force;
        }
    }
    t->values[1] = total;
    for (int64_t i = 0; i < n - 1; i++) {
        t->slip[i] = state->past[i] + (t->slides[i] != 0 ? t->z[i + 1] - t->z[i] : 0.0);
    }
}

/* Compute cap, faces, sheets and forces of the pattern; SNAPPED if the mount is too soft. */
static int64_t place_sheets(double target, double slack, Stack *stack, State *state, Trial *t)
{
    double at0, at1, b00, b01, b10, b11, cap, d, d0, d1, determinant, f0, fa, fb, fu, g0, g1, h0,
            h1, m00, m11, p0, p1, r0, r1, s0, s1, slope0, slope1, spring, u0, ua, ub;
    double *a, *b;
    int64_t first, j, last, n;
    n = stack->sheet_count;
    compute_response(stack, state, t);
    f0 = 0.0;
    fu = 0.0;
    fa = 0.0;
    fb = 0.0;
    for (int64_t i = 0; i < n; i++) {
        if (stack->right[i]) {
            d = stack->springs[i];
            j = t->group[i];
            f0 -= d * (t->offset[i] + t->terms[j][0]);
            fu += d * (1.0 - t->terms[j][1]);
            fa -= d * t->terms[j][2];
            fb -= d * t->terms[j][3];
        }
    }
    first = stack->ends[0];
    last = stack->ends[1];
    fa += stack->right[first] ? 0.0 : 1.0;
    fb += stack->right[last] ? 0.0 : 1.0;
    u0 = target;
    ua = 0.0;
    ub = 0.0;
    if (slack > 0.0 || !isinf(stack->mount)) {
        spring = fu + (slack > 0.0 ? 0.0 : stack->mount);
        if (spring <= 0.0) {
            return 1;
        }
        u0 = ((slack > 0.0 ? 0.0 : stack->mount * target) - f0) / spring;
        ua = -fa / spring;
        ub = -fb / spring;
    }
    p0 = 0.0;
    p1 = 0.0;
    if (stack->face[0] > 0.0) {
        s0 = stack->right[first] ? -1.0 : 1.0;
        s1 = stack->right[last] ? -1.0 : 1.0;
        a = t->terms[t->group[first]];
        b = t->terms[t->group[last]];
        h0 = (stack->right[first] ? 0.0 : 1.0) - s0 * a[1];
        h1 = (stack->right[last] ? 0.0 : 1.0) - s1 * b[1];
        g0 = h0 * u0 - s0 * (a[0] + t->offset[first]);
        g1 = h1 * u0 - s1 * (b[0] + t->offset[last]);
        b00 = h0 * ua - s0 * a[2];
        b01 = h0 * ub - s0 * a[3];
        b10 = h1 * ua - s1 * b[2];
        b11 = h1 * ub - s1 * b[3];
        p0 = state->faces.push[0];
        p1 = state->faces.push[1];
        for (int64_t _ = 0; _ < 150; _++) {
            ResultDD result1 = face_gap(p0, 0, &state->faces, stack->face);
            at0 = result1.v0;
            slope0 = result1.v1;
            ResultDD result2 = face_gap(p1, 1, &state->faces, stack->face);
            at1 = result2.v0;
            slope1 = result2.v1;
            slope0 = lj_max(slope0, -1e-06 * b00);
            slope1 = lj_max(slope1, -1e-06 * b11);
            r0 = g0 + b00 * p0 + b01 * p1 - at0;
            r1 = g1 + b10 * p0 + b11 * p1 - at1;
            m00 = slope0 - b00;
            m11 = slope1 - b11;
            determinant = m00 * m11 - b01 * b10;
            d0 = (m11 * r0 + b01 * r1) / determinant;
            d1 = (m00 * r1 + b10 * r0) / determinant;
            p0 = p0 + d0;
            p1 = p1 + d1;
            if (fabs(d0) <= 1e-14 * fabs(p0) + 1e-15 && fabs(d1) <= 1e-14 * fabs(p1) + 1e-15) {
                break;
            }
        }
    }
    cap = u0 + ua * p0 + ub * p1;
    t->push[0] = p0;
    t->push[1] = p1;
    t->values[0] = cap;
    lay_out_sheets(stack, state, t);
    return 0;
}

/* Solve the increment to `target`, or to zero force; static interfaces stay at rest. */
static int64_t solve_increment(double target, double slack, Stack *stack, State *state, Trial *t)
{
    double before, cap, highest, hold, jump, lowest, part, progress, pull, reach, stiff, tight;
    int64_t code, fine, n, snaps;
    n = stack->sheet_count;
    for (int64_t i = 0; i < n - 1; i++) {
        t->slides[i] = state->slides[i];
        t->slip[i] = state->past[i];
        if (is_held(i, stack, state)) {
            t->slides[i] = 0;
        }
    }
    cap = state->values[0];
    stiff = stiffness_sum(stack);
    before = cap;
    snaps = 0;
    t->pull[0] = state->faces.push[0];
    t->pull[1] = state->faces.push[1];
    for (int64_t turn = 0; turn < 150; turn++) {
        code = place_sheets(target, slack, stack, state, t);
        fine = code == 0;
        reach = fabs(t->values[0]) + fabs(target);
        for (int64_t i = 0; i < n - 1; i++) {
            tight = margin(i, reach, stiff, stack);
            if (t->slides[i] != 0) {
                progress = t->slides[i] * (t->slip[i] - state->past[i]);
                fine &= progress >= -tight / stack->springs[i];
                hold = t->slides[i] * bound(i, t->slip[i], stack);
                fine &= fabs(t->force[i] - hold) <= 1000.0 * tight;
            } else {
                if (!is_held(i, stack, state)) {
                    fine &= fabs(t->force[i]) <= bound(i, t->slip[i], stack) + tight;
                }
            }
        }
        if (fine) {
            return 0;
        }
        if (code != 0) {
            snaps += 1;
            if (snaps > 40) {
                return code;
            }
            cap = (cap + before) / 2;
            for (int64_t i = 0; i < n - 1; i++) {
                t->slides[i] = 0;
                t->slip[i] = state->past[i];
            }
            if (turn == 0) {
                continue;
            }
        }
        part = turn < 5 ? 1.0 : turn < 25 ? 0.5 : 12.0 / turn;
        if (code == 0) {
            before = cap;
            cap += part * (t->values[0] - cap);
            for (int64_t e = 0; e < 2; e++) {
                t->pull[e] += part * (t->push[e] - t->pull[e]);
            }
        }
        lowest = INFINITY;
        highest = -INFINITY;
        for (int64_t i = 0; i < n; i++) {
            t->centre[i] = (stack->right[i] ? cap : 0.0) - t->offset[i];
            for (int64_t e = 0; e < 2; e++) {
                if (i == stack->ends[e]) {
                    pull = stack->right[i] ? -t->pull[e] : t->pull[e];
                    t->centre[i] += pull / stack->springs[i];
                }
            }
            lowest = lj_min(lowest, t->centre[i]);
            highest = lj_max(highest, t->centre[i]);
        }
        for (int64_t i = 0; i < n - 1; i++) {
            t->bound[i] = bound(i, t->slip[i], stack);
            if (is_held(i, stack, state)) {
                t->bound[i] = stiff * (highest - lowest);
            }
        }
        fused_lasso(n, stack->springs, t->centre, t->bound, t->z, &t->knots);
        for (int64_t i = 0; i < n - 1; i++) {
            jump = t->z[i + 1] - t->z[i];
            t->slides[i] = jump > 0.0 ? 1 : jump < 0.0 ? -1 : 0;
            if (t->slides[i] != 0) {
                t->slip[i] = state->past[i] + jump;
            }
        }
    }
    return 4;
}

/* Return the largest relative excess over a static bound; mark those > `level`. */
static double largest_overload(double level, Stack *stack, State *state, Trial *t)
{
    double excess, limit, reach, stiff, worst;
    worst = -1.0;
    stiff = stiffness_sum(stack);
    reach = 2 * fabs(t->values[0]) + fabs(state->values[2]);
    for (int64_t i = 0; i < stack->sheet_count - 1; i++) {
        if (is_held(i, stack, state)) {
            limit = stack->ratio[i] * bound(i, state->past[i], stack);
            excess = (fabs(t->force[i]) - margin(i, reach, stiff, stack)) / limit - 1.0;
            worst = lj_max(worst, excess);
            t->marks[i] = excess > level;
        } else {
            t->marks[i] = 0;
        }
    }
    return worst;
}

/* Accept the trial as the new state, with its work and heat. */
static int64_t accept_trial(double target, double jump, Stack *stack, State *state, Trial *t)
{
    double elastic, face_heat, face_work, friction_heat, heat, least, new, old, slid, slip, stretch,
            total, work;
    double *face_energy, *values;
    int64_t code, first, last, n;
    n = stack->sheet_count;
    values = state->values;
    face_energy = state->faces.energy;
    friction_heat = 0.0;
    work = face_energy[0] + face_energy[1] - values[5];
    elastic = 0.0;
    for (int64_t i = 0; i < n - 1; i++) {
        if (t->slides[i] != 0) {
            slid = fabs(t->slip[i] - state->past[i]);
            old = bound(i, state->past[i], stack);
            new = bound(i, t->slip[i], stack);
            if (old + new > 0.0 && (old == 0.0 || new == 0.0)) {
                slid = lj_min(slid, lj_max(old, new) * stack->length[i] / stack->friction[i]);
            }
            friction_heat += slid * (old + new) / 2;
        }
    }
    heat = friction_heat;
    for (int64_t e = 0; e < 2; e++) {
        ResultDDI result1 = move_face(t->push[e], e, &state->faces, stack->face);
        face_work = result1.v0;
        face_heat = result1.v1;
        code = result1.v2;
        if (code != 0) {
            return code;
        }
        work += face_work;
        heat += face_heat;
        face_energy[e] += face_work - face_heat;
    }
    for (int64_t i = 0; i < n; i++) {
        stretch = t->sheets[i] - (stack->right[i] ? t->values[0] : 0.0);
        elastic += stack->springs[i] * stretch * stretch / 2;
    }
    if (!isinf(stack->mount)) {
        elastic += t->values[1] * t->values[1] / (2 * stack->mount);
    }
    total = elastic + face_energy[0] + face_energy[1];
    values[4] += jump > 0.0 ? values[5] - total : heat;
    values[3] += jump > 0.0 ? 0.0 : friction_heat + work + elastic;
    values[5] = total;
    values[0] = t->values[0];
    values[1] = t->values[1];
    values[2] = target;
    for (int64_t i = 0; i < n; i++) {
        state->sheets[i] = t->sheets[i];
    }
    for (int64_t i = 0; i < n - 1; i++) {
        state->past[i] = t->slip[i];
        state->slides[i] = t->slides[i];
        state->interface[i] = t->force[i];
        if (t->slides[i] != 0) {
            state->moving[i] = 1;
        } else {
            if (state->moving[i]) {
                least = (1.0 + -1e-09) * bound(i, t->slip[i], stack);
                state->moving[i] = fabs(t->force[i]) >= least;
            }
        }
    }
    if (values[1] > values[7]) {
        values[7] = values[1];
        values[8] = target;
        first = stack->ends[0];
        last = stack->ends[1];
        slip = 0.0;
        for (int64_t i = first; i < last; i++) {
            slip += stack->right[i] ? -t->slip[i] : t->slip[i];
        }
        values[9] = slip / (last - first);
    }
    return 0;
}

/* Solve in tension only: a brake that would be in compression rests without force. */
static int64_t solve_tension(double target, Stack *stack, State *state, Trial *t)
{
    int64_t code;
    code = solve_increment(target, 0.0, stack, state, t);
    state->values[6] = 0.0;
    if (code == 0 && t->values[1] < 0.0) {
        code = solve_increment(target, 1.0, stack, state, t);
        t->values[1] = 0.0;
        state->values[6] = 1.0;
    }
    return code;
}

typedef struct { int64_t v0; double v1; } ResultID;

/* Return the point before `target`, the first interface reaches its static bound (Illinois). */
static ResultID find_break(double target, Stack *stack, State *state, Trial *t)
{
    double above, below, excess, high, low, point;
    int64_t code, side;
    low = state->values[2];
    high = target;
    above = largest_overload(-1e-09, stack, state, t);
    for (int64_t i = 0; i < stack->sheet_count - 1; i++) {
        t->force[i] = state->interface[i];
    }
    below = largest_overload(-1e-09, stack, state, t);
    side = 0;
    point = target;
    for (int64_t _ = 0; _ < 100; _++) {
        if (below >= 0.0 || above == below) {
            point = low;
        } else {
            point = (low * above - high * below) / (above - below);
        }
        code = solve_tension(point, stack, state, t);
        excess = largest_overload(-1e-09, stack, state, t);
        if (code != 0 || (excess <= 0.0 && excess > -1e-11) || (point == low || point == high)) {
            largest_overload(lj_min(excess, 0.0) - 1e-09, stack, state, t);
            return (ResultID){code, point};
        }
        if (excess > 0.0) {
            high = point;
            above = excess;
            below = side == 1 ? below / 2 : below;
            side = 1;
        } else {
            low = point;
            below = excess;
            above = side == -1 ? above / 2 : above;
            side = -1;
        }
    }
    return (ResultID){4, point};
}

/* Assign kinetic friction to interfaces that have reached their static bound. */
static void release_interfaces(Stack *stack, State *state, Trial *t)
{
    for (int64_t i = 0; i < stack->sheet_count - 1; i++) {
        if (t->marks[i]) {
            state->moving[i] = 1;
        }
    }
}

/* Move the crosshead to `target`, stopping at each break of static friction. */
static int64_t advance(double target, Stack *stack, State *state, Trial *t)
{
    double excess, goal, jump;
    double *values;
    int64_t brittle, code, short_;
    values = state->values;
    if (target == values[2] || (values[6] > 0.0 && target <= values[0])) {
        values[2] = target;
        return 0;
    }
    goal = target;
    jump = 0.0;
    brittle = 0;
    for (int64_t i = 0; i < stack->sheet_count - 1; i++) {
        brittle |= stack->ratio[i] > 1.0;
    }
    for (int64_t _ = 0; _ < 500 * stack->sheet_count; _++) {
        code = solve_tension(goal, stack, state, t);
        short_ = fabs(goal - values[2]) <= 1e-12 * fabs(goal);
        if ((code == 4 || code == 1) && jump == 0.0 && !short_) {
            goal = values[2] + (goal - values[2]) / 2;
            continue;
        }
        if (code != 0) {
            return code;
        }
        excess = brittle ? largest_overload(-1e-09, stack, state, t) : -1.0;
        if (excess > 0.0 && jump > 0.0) {
            if (stack->one_by_one) {
                largest_overload(excess + -1e-09, stack, state, t);
                code = accept_trial(goal, jump, stack, state, t);
                if (code != 0) {
                    return code;
                }
            }
            release_interfaces(stack, state, t);
            continue;
        }
        if (excess > 0.0) {
            ResultID result1 = find_break(target, stack, state, t);
            code = result1.v0;
            goal = result1.v1;
            code = code != 0 ? code : accept_trial(goal, jump, stack, state, t);
            if (code != 0) {
                return code;
            }
            release_interfaces(stack, state, t);
            jump = 1.0;
            continue;
        }
        code = accept_trial(goal, jump, stack, state, t);
        if (code != 0 || goal == target) {
            return code;
        }
        goal = target;
        jump = 0.0;
    }
    return 3;
}

/* Return whether all interfaces that can lose their overlap have lost it. */
static int64_t is_separated(Stack *stack, State *state)
{
    double slip;
    int64_t can_separate;
    can_separate = 0;
    for (int64_t i = 0; i < stack->sheet_count - 1; i++) {
        if (!isinf(stack->length[i])) {
            can_separate = 1;
            slip = stack->right[i] ? -state->past[i] : state->past[i];
            if (slip < stack->length[i]) {
                return 0;
            }
        }
    }
    return can_separate;
}

typedef struct {
    double *force;
    double *cap;
    double *sheets;
    double *interface;
    double *slip;
    uint8_t *sliding;
    double *faces;
    double *work;
    double *heat;
    double *stored;
    uint8_t *slack;
    int64_t snapped;
} StackPull;

/* Follow a path from point `first` to before `last`; return the first point not reached. */
int64_t lj_follow_path(int64_t first, int64_t last, double *path, Stack *stack, State *state,
        Trial *t, StackPull *motion, int64_t *codes);
int64_t lj_follow_path(int64_t first, int64_t last, double *path, Stack *stack, State *state,
        Trial *t, StackPull *motion, int64_t *codes)
{
    double *values;
    int64_t n, place;
    n = stack->sheet_count;
    values = state->values;
    for (int64_t step = first; step < last; step++) {
        codes[0] = advance(path[step], stack, state, t);
        if (codes[0] != 0) {
            return step;
        }
        motion->force[step] = values[1];
        motion->cap[step] = values[0];
        motion->work[step] = values[3];
        motion->heat[step] = values[4];
        motion->stored[step] = values[5];
        motion->slack[step] = values[6] > 0.0;
        for (int64_t e = 0; e < 2; e++) {
            motion->faces[2 * step + e] = state->faces.push[e];
        }
        for (int64_t i = 0; i < n; i++) {
            motion->sheets[n * step + i] = state->sheets[i];
        }
        for (int64_t i = 0; i < n - 1; i++) {
            place = (n - 1) * step + i;
            motion->interface[place] = state->interface[i];
            motion->slip[place] = stack->right[i] ? -state->past[i] : state->past[i];
            motion->sliding[place] = state->slides[i] != 0;
        }
        if (is_separated(stack, state)) {
            return step + 1;
        }
    }
    return last;
}

typedef struct {
    double *elongation;
    double *force;
} Curve;

/* Bring a state back to rest. */
static void reset_state(int64_t n, State *state)
{
    for (int64_t i = 0; i < n - 1; i++) {
        state->past[i] = 0.0;
        state->slides[i] = 0;
        state->moving[i] = 0;
        state->interface[i] = 0.0;
    }
    for (int64_t i = 0; i < n; i++) {
        state->sheets[i] = 0.0;
    }
    for (int64_t i = 0; i < 10; i++) {
        state->values[i] = 0.0;
    }
    for (int64_t e = 0; e < 2; e++) {
        state->faces.counts[e] = 0;
        state->faces.heading[e] = 1;
        state->faces.gap[e] = 0.0;
        state->faces.push[e] = 0.0;
        state->faces.energy[e] = 0.0;
    }
}

/* Copy `old` into `new` without turning points, because a pull has none. */
static void copy_state(int64_t n, State *new, State *old)
{
    for (int64_t i = 0; i < n - 1; i++) {
        new->past[i] = old->past[i];
        new->slides[i] = old->slides[i];
        new->moving[i] = old->moving[i];
        new->interface[i] = old->interface[i];
    }
    for (int64_t i = 0; i < n; i++) {
        new->sheets[i] = old->sheets[i];
    }
    for (int64_t i = 0; i < 10; i++) {
        new->values[i] = old->values[i];
    }
    for (int64_t e = 0; e < 2; e++) {
        new->faces.gap[e] = old->faces.gap[e];
        new->faces.push[e] = old->faces.push[e];
        new->faces.energy[e] = old->faces.energy[e];
    }
}

/* Return the factor on the load at which the first interface slips, if all forces scale. */
static double onset_factor(Stack *stack, State *state)
{
    double limit, share;
    share = INFINITY;
    for (int64_t i = 0; i < stack->sheet_count - 1; i++) {
        if (state->interface[i] != 0.0) {
            limit = stack->ratio[i] * stack->friction[i];
            share = lj_min(share, limit / fabs(state->interface[i]));
        }
    }
    return share;
}

/* Return the elongation at which a track first carries `force`, interpolated linearly. */
static double elongation(double force, Curve *track, int64_t points)
{
    double part;
    int64_t k;
    k = 1;
    while (track->force[k] < force && k < points) {
        k += 1;
    }
    part = (force - track->force[k - 1]) / (track->force[k] - track->force[k - 1]);
    return (track->elongation[k - 1] + part * (track->elongation[k] - track->elongation[k - 1]));
}

/* Pull one stack to its peak; `probe` is a small elongation, `end` the last one. */
static int64_t pull_to_peak(double probe, double end, Stack *stack, State *state, State *last,
        State *before, Trial *t, Curve *track, int64_t place, double *out)
{
    double goal, high, low, onset, step, strength, target, top, unit, wide;
    int64_t code, falling, n, past, points;
    n = stack->sheet_count;
    code = advance(probe, stack, state, t);
    onset = probe * onset_factor(stack, state);
    for (int64_t i = 0; i < n - 1; i++) {
        onset = state->slides[i] != 0 ? 0.0 : onset;
    }
    if (onset > 0.0 && code == 0) {
        code = advance(lj_max(0.9 * onset, probe), stack, state, t);
        out[place + 4] = state->values[1] * onset_factor(stack, state);
    }
    if (code != 0) {
        return code;
    }
    strength = 0.0;
    for (int64_t i = 0; i < stack->sheet_count - 1; i++) {
        strength += stack->ratio[i] * stack->friction[i];
    }
    unit = strength * state->values[2] / state->values[1];
    step = unit / 16;
    falling = 0;
    top = 0.0;
    copy_state(n, before, state);
    wide = step;
    points = 1;
    track->elongation[0] = 0.0;
    track->force[0] = 0.0;
    for (int64_t _ = 0; _ < 200; _++) {
        copy_state(n, last, state);
        track->elongation[points] = state->values[2];
        track->force[points] = state->values[1];
        points += 1;
        target = lj_min(state->values[2] + step, end);
        code = advance(target, stack, state, t);
        if (code != 0) {
            return code;
        }
        if (state->values[7] > top) {
            top = state->values[7];
            falling = 0;
            wide = 2 * step;
            copy_state(n, before, last);
        } else {
            falling += 1;
        }
        past = state->values[2] > 1.1 * unit;
        if (target == end || (falling >= 2 && past)) {
            break;
        }
        step *= past ? 1.2 : 1.0;
    }
    for (int64_t _ = 0; _ < 3; _++) {
        copy_state(n, state, before);
        goal = lj_min(before->values[2] + wide, end);
        step = (goal - before->values[2]) / 6;
        top = state->values[7];
        for (int64_t part = 0; part < 6; part++) {
            copy_state(n, last, state);
            code = advance(goal - (6 - 1 - part) * step, stack, state, t);
            if (code != 0) {
                return code;
            }
            if (state->values[7] > top) {
                top = state->values[7];
                copy_state(n, before, last);
                out[place] = top;
                out[place + 1] = state->values[8];
                out[place + 2] = state->values[9];
            }
        }
        wide = 2 * step;
    }
    track->elongation[points] = before->values[2];
    track->force[points] = before->values[1];
    low = elongation(0.2 * top, track, points);
    high = elongation(0.8 * top, track, points);
    out[place + 3] = 0.6 * top / (high - low);
    return code;
}

/* Pull stacks `first` to before `last` to their peak, with RESULTS numbers each in `out`. */
void lj_follow_peaks(int64_t first, int64_t last, double probe, double end, double *friction,
        double *length, Stack *stack, State *state, State *earlier, State *before, Trial *t,
        Curve *track, double *out);
void lj_follow_peaks(int64_t first, int64_t last, double probe, double end, double *friction,
        double *length, Stack *stack, State *state, State *earlier, State *before, Trial *t,
        Curve *track, double *out)
{
    int64_t code, n;
    n = stack->sheet_count;
    for (int64_t j = first; j < last; j++) {
        for (int64_t i = 0; i < n - 1; i++) {
            stack->friction[i] = friction[(n - 1) * j + i];
            stack->length[i] = length[(n - 1) * j + i];
        }
        for (int64_t k = 0; k < 5; k++) {
            out[5 * j + k] = NAN;
        }
        reset_state(n, state);
        reset_state(n, earlier);
        reset_state(n, before);
        code = pull_to_peak(probe, end, stack, state, earlier, before, t, track, 5 * j, out);
        if (code != 0) {
            for (int64_t k = 0; k < 5; k++) {
                out[5 * j + k] = code == 1 || code == 3 ? NAN : -1.0;
            }
        }
    }
}
