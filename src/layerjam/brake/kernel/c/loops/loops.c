/* Printed by tests/c_printers/c_program.py from the Python sources. Apache License 2.0. */

#include <math.h>
#include <stdint.h>
#include <string.h>

#define LJ_WITHIN static inline __attribute__((always_inline))
#define LJ_APART static __attribute__((noinline))

LJ_WITHIN double lj_max(double a, double b) { return b > a ? b : a; }

LJ_WITHIN double lj_min(double a, double b) { return b < a ? b : a; }

LJ_WITHIN void lj_copy(double *to, const double *from, int count)
{
    memcpy(to, from, (size_t)count * sizeof(double));
}

typedef struct {
    double rate;
    double top;
    double weight;
    double leak;
    double vent;
    double backwards;
    double side;
    double passes;
    double atmosphere;
} lj_rates;

typedef struct {
    const double *edges;
    const double *inner;
} lj_layers;

typedef struct {
    double highest;
    double lowest;
    double noise;
    double step;
    double offset;
} lj_chain;

typedef struct {
    double dt;
    double lag;
    int64_t samples;
    int64_t stages;
    const int64_t *ends;
    const double *levels;
    int64_t onset;
    int64_t sensor;
    double shown;
    int64_t steady;
} lj_course;

LJ_WITHIN void lj_fresh(double *out)
{
    double long_ago;
    double drive[8];
    long_ago = 1000000000.0;
    drive[0] = 0.0;
    drive[1] = 0.0;
    drive[2] = 0.0;
    drive[3] = long_ago;
    drive[4] = long_ago;
    drive[5] = 0.0;
    drive[6] = 0.0;
    drive[7] = 0.0;
    lj_copy(out + 0, drive, 8);
    out[8] = 0.0;
    out[9] = 0.0;
    out[10] = 0.0;
    out[11] = 0.0;
    out[12] = 0.0;
    out[13] = 0.0;
    out[14] = 0.0;
    out[15] = 0.0;
    out[16] = 0.0;
    out[17] = 0.0;
    out[18] = 0.0;
    out[19] = 0.0;
    out[20] = 0.0;
    out[21] = 0.0;
}

LJ_WITHIN void lj_move_drive(const double *drive, double integral, double pump, double vent, double
        target, double *out)
{
    double was, open_, pump_age, vent_age, pump_switches, vent_switches;
    was = drive[1];
    open_ = drive[2];
    pump_age = drive[3];
    vent_age = drive[4];
    pump_switches = drive[5];
    vent_switches = drive[6];
    if ((was == 0.0) != (pump == 0.0)) {
        pump_age = 0.0;
        pump_switches = pump_switches + 1.0;
    }
    if (open_ != vent) {
        vent_age = 0.0;
        vent_switches = vent_switches + 1.0;
    }
    pump_age = pump_age + 1.0;
    vent_age = vent_age + 1.0;
    out[0] = integral;
    out[1] = pump;
    out[2] = vent;
    out[3] = pump_age;
    out[4] = vent_age;
    out[5] = pump_switches;
    out[6] = vent_switches;
    out[7] = target;
}

LJ_WITHIN double lj_switch_pump(double pump, double error, double band, double vent_band, double
        lowest)
{
    if (error > band) {
        return 1.0;
    }
    if (error < -vent_band && lowest < 0.0) {
        return -1.0;
    }
    if (error < -band) {
        return (pump < 0.0 ? pump : 0.0);
    }
    return (pump > 0.0 ? pump : 0.0);
}

LJ_WITHIN void lj_make_safe_drive(const double *regulator, const double *drive, double *out)
{
    lj_move_drive(drive, 0.0, 0.0, regulator[14], drive[7], out);
}

LJ_WITHIN void lj_compute_drive(const double *regulator, const double *drive, double reading, double
        target, double *out)
{
    double kind, gain, integral_gain, band, vent_band, lowest, least, on_steps, off_steps,
        vent_steps, hold, climb, top, fall, integral, pump, vent, pump_age, vent_age, last, error,
        effort, venting, feedforward, room, new_integral, size;
    int still;
    kind = regulator[0];
    gain = regulator[1];
    integral_gain = regulator[2];
    band = regulator[3];
    vent_band = regulator[4];
    lowest = regulator[5];
    least = regulator[6];
    on_steps = regulator[7];
    off_steps = regulator[8];
    vent_steps = regulator[9];
    hold = regulator[10];
    climb = regulator[11];
    top = regulator[12];
    fall = regulator[13];
    integral = drive[0];
    pump = drive[1];
    vent = drive[2];
    pump_age = drive[3];
    vent_age = drive[4];
    last = drive[7];
    error = target - reading;
    if (target <= 0.0) {
        effort = 0.0;
        venting = 1.0;
        integral = 0.0;
    } else {
        venting = 0.0;
        if (lowest == 0.0 && (error < -vent_band || (vent != 0.0 && error < -band))) {
            venting = 1.0;
        }
        if (vent != venting && vent_age < vent_steps) {
            venting = vent;
        }
        if (venting != 0.0) {
            effort = 0.0;
        } else if (kind == 0) {
            effort = lj_switch_pump(pump, error, band, vent_band, lowest);
        } else {
            if (-band <= error && error <= band) {
                error = 0.0;
            }
            feedforward = top - fall * target;
            if (feedforward < 0.05 * top) {
                feedforward = 0.05 * top;
            }
            feedforward = (hold * target + climb * (target - last)) / feedforward;
            if (kind == 2) {
                room = top - fall * reading;
                error *= top / (room > 0.05 * top ? room : 0.05 * top);
            }
            new_integral = integral + integral_gain * error;
            effort = feedforward + gain * error + new_integral;
            if (effort > 1.0) {
                effort = 1.0;
                if (error < 0.0) {
                    integral = new_integral;
                }
            } else if (effort < lowest) {
                effort = lowest;
                if (error > 0.0) {
                    integral = new_integral;
                }
            } else {
                integral = new_integral;
            }
            size = (effort > 0.0 ? effort : -effort);
            if (size < least) {
                still = pump * effort > 0.0 && size > 0.5 * least;
                effort = (!still ? 0.0 : (effort > 0.0 ? least : -least));
            }
        }
    }
    if (pump * effort < 0.0) {
        effort = 0.0;
    }
    if (effort == 0.0 && pump != 0.0 && pump_age < on_steps) {
        effort = (pump > 0.0 ? least : -least);
    } else if (effort != 0.0 && pump == 0.0 && pump_age < off_steps) {
        effort = 0.0;
    }
    lj_move_drive(drive, integral, effort, venting, target, out);
}

LJ_WITHIN double lj_healthy_rise(double pump, double vacuum, double rise, double top, double fall,
        double flow_limit, double flow_slope, double bend)
{
    double gives, through;
    gives = rise * pump * (top - fall * vacuum);
    through = flow_limit - (flow_slope - bend * vacuum) * vacuum;
    return (gives < through ? gives : through);
}

LJ_WITHIN void lj_healthy_rises(double pump, double vacuum, double zero, double rate, double lag,
        double rise, double top, double fall, double flow_limit, double flow_slope, double bend,
        double *out)
{
    double high, low, least, largest;
    high = 0.0;
    low = 0.0;
    if (pump != 0.0) {
        high = lj_healthy_rise(pump, vacuum - zero, rise, top, fall, flow_limit, flow_slope, bend);
        low = lj_healthy_rise(pump, vacuum + zero, rise, top, fall, flow_limit, flow_slope, bend);
    }
    rate += lag * (high - rate);
    if (rate < high) { least = rate; largest = high; } else { least = high; largest = rate; }
    out[0] = least - (high - low);
    out[1] = largest;
    out[2] = rate;
}

LJ_WITHIN double lj_update_surplus(double surplus, double rate, double loss, double fast, double
        sound)
{
    double allowance;
    allowance = fast * (rate - loss);
    if (allowance < sound * rate) {
        allowance = sound * rate;
    }
    surplus -= allowance;
    return (surplus > 0.0 ? surplus : 0.0);
}

LJ_WITHIN void lj_check_pump(double owed, double risen, double quiet, int off_zero, double clear,
        double none, double weak, double *out)
{
    double fault;
    if (risen >= weak * owed) {
        out[0] = 0.0;
        out[1] = 0.0;
        out[2] = 0.0;
        out[3] = 0.0;
        return;
    }
    if (weak * (owed - clear) <= risen) {
        out[0] = 0.0;
        out[1] = owed;
        out[2] = risen;
        out[3] = quiet;
        return;
    }
    fault = 1.0 * (risen < none * owed ? 5 : 6);
    if (off_zero && quiet > 0.5 * owed) {
        fault = 1.0 * 3;
    }
    out[0] = fault;
    out[1] = owed;
    out[2] = risen;
    out[3] = quiet;
}

LJ_WITHIN void lj_watch_vent(double value, double vent_count, double off_count, double opening,
        double settle_steps, double offset, double confirm, double *out)
{
    int stays;
    double fault;
    if (vent_count == 0.0) {
        opening = value;
    }
    vent_count += 1.0;
    if (vent_count <= settle_steps || (-offset <= value && value <= offset)) {
        out[0] = 0.0;
        out[1] = vent_count;
        out[2] = 0.0;
        out[3] = opening;
        return;
    }
    off_count += 1.0;
    stays = opening > 2.0 * offset && value > 0.5 * opening;
    fault = 1.0 * (stays ? 7 : 4);
    out[0] = (off_count >= confirm ? fault : 0.0);
    out[1] = vent_count;
    out[2] = off_count;
    out[3] = opening;
}

LJ_WITHIN void lj_watch_target(double target, double last, int is_close, double at_target, double
        missing, double *out)
{
    if (target <= 0.0) {
        out[0] = 0.0;
        out[1] = 0.0;
        return;
    }
    if (is_close) {
        out[0] = 1.0;
        out[1] = 0.0;
        return;
    }
    if (target > last || at_target == 0.0) {
        out[0] = 0.0;
        out[1] = 0.0;
        return;
    }
    out[0] = at_target;
    out[1] = missing + 1.0;
}

LJ_WITHIN void lj_detect(const double *watch, const double *memory, const double *drive, double
        value, double target, double *out)
{
    double rise, top, fall, leak, lag, low, high, confirm, clear, none, weak, fast, lost_band,
        lost_steps, same_steps, settle_steps, offset, fade_steps, flow_limit, flow_slope, bend,
        sound, jump, zero, reading, range_count, same, quiet, rate, owed, risen, surplus, at_target,
        missing, vent_count, off_count, opening, fault, change, pump, vent, least, largest, loss,
        code;
    double r0[3];
    int pumping, off_zero;
    double r1[4];
    double r2[4];
    double r3[2];
    rise = watch[0];
    top = watch[1];
    fall = watch[2];
    leak = watch[3];
    lag = watch[4];
    low = watch[5];
    high = watch[6];
    confirm = watch[7];
    clear = watch[8];
    none = watch[9];
    weak = watch[10];
    fast = watch[11];
    lost_band = watch[12];
    lost_steps = watch[13];
    same_steps = watch[14];
    settle_steps = watch[15];
    offset = watch[16];
    fade_steps = watch[17];
    flow_limit = watch[18];
    flow_slope = watch[19];
    bend = watch[20];
    sound = watch[21];
    jump = watch[22];
    zero = watch[23];
    reading = memory[0];
    range_count = memory[1];
    same = memory[2];
    quiet = memory[3];
    rate = memory[4];
    owed = memory[5];
    risen = memory[6];
    surplus = memory[7];
    at_target = memory[8];
    missing = memory[9];
    vent_count = memory[10];
    off_count = memory[11];
    opening = memory[12];
    fault = memory[13];
    if (fault != 0.0) {
        out[0] = fault;
        out[1] = reading;
        lj_copy(out + 2, memory, 14);
        return;
    }
    if (value != value || target - target != 0.0) {
        fault = 1.0 * 1;
        value = reading;
    } else if (value < low || value >= high) {
        range_count += 1.0;
        value = reading;
        if (range_count >= confirm) {
            fault = 1.0 * 2;
        }
    } else {
        range_count = 0.0;
        change = value - reading;
        same = (change == 0.0 && value > low ? same + 1.0 : 0.0);
        if (same != 0.0 && same >= same_steps) {
            fault = 1.0 * 3;
        }
        pump = drive[1];
        vent = drive[2];
        lj_healthy_rises(pump, value, zero, rate, lag, rise, top, fall, flow_limit, flow_slope,
            bend, r0);
        least = r0[0];
        largest = r0[1];
        rate = r0[2];
        loss = leak * (value > 0.5 * top ? value : 0.5 * top);
        pumping = pump > 0.0 && vent == 0.0 && drive[4] > fade_steps;
        surplus = (pumping ? lj_update_surplus(surplus + change, largest, loss, fast, sound) : 0.0);
        if (surplus > jump) {
            fault = 1.0 * 7;
        }
        if (pumping && least > 2.0 * loss) {
            quiet = (change == 0.0 ? quiet + least : 0.0);
            off_zero = !(-offset <= value && value <= offset);
            owed = owed + least - loss;
            risen = risen + change;
            lj_check_pump(owed, risen, quiet, off_zero, clear, none, weak, r1);
            code = r1[0];
            owed = r1[1];
            risen = r1[2];
            quiet = r1[3];
            fault = (fault == 0.0 ? code : fault);
        } else {
            owed = 0.0;
            risen = 0.0;
            quiet = 0.0;
            surplus = 0.0;
        }
        if (vent != 0.0 && pump == 0.0) {
            lj_watch_vent(value, vent_count, off_count, opening, settle_steps, offset, confirm, r2);
            code = r2[0];
            vent_count = r2[1];
            off_count = r2[2];
            opening = r2[3];
            fault = (code != 0.0 ? code : fault);
        } else {
            vent_count = 0.0;
            off_count = 0.0;
        }
        lj_watch_target(target, drive[7], value >= target - lost_band, at_target, missing, r3);
        at_target = r3[0];
        missing = r3[1];
        if (missing > 0.0 && missing >= lost_steps) {
            fault = 1.0 * 8;
        }
    }
    out[0] = fault;
    out[1] = value;
    out[2] = value;
    out[3] = range_count;
    out[4] = same;
    out[5] = quiet;
    out[6] = rate;
    out[7] = owed;
    out[8] = risen;
    out[9] = surplus;
    out[10] = at_target;
    out[11] = missing;
    out[12] = vent_count;
    out[13] = off_count;
    out[14] = opening;
    out[15] = fault;
}

LJ_WITHIN void lj_step(const double *settings, const double *state, double value, double target,
        double *out)
{
    const double *regulator;
    const double *watch;
    double drive[8];
    double memory[14];
    double r0[16];
    double fault, reading;
    double r1[8];
    double r2[8];
    regulator = settings + 0;
    watch = settings + 15;
    lj_copy(drive, state + 0, 8);
    lj_copy(memory, state + 8, 14);
    lj_detect(watch, memory, drive, value, target, r0);
    fault = r0[0];
    reading = r0[1];
    lj_copy(memory, r0 + 2, 14);
    if (fault == 0) {
        lj_compute_drive(regulator, drive, reading, target, r1);
        lj_copy(drive, r1, 8);
    } else {
        lj_make_safe_drive(regulator, drive, r2);
        lj_copy(drive, r2, 8);
    }
    lj_copy(out + 0, drive, 8);
    lj_copy(out + 8, memory, 14);
    out[22] = drive[1];
    out[23] = (int64_t)drive[2];
    out[24] = (int64_t)fault;
}

LJ_WITHIN uint64_t lj_mix_bits(uint64_t word)
{
    word = ((word ^ (word >> 30)) * UINT64_C(13787848793156543929)) &
        UINT64_C(18446744073709551615);
    word = ((word ^ (word >> 27)) * UINT64_C(10723151780598845931)) &
        UINT64_C(18446744073709551615);
    return word ^ (word >> 31);
}

LJ_WITHIN double lj_uniform(uint64_t word)
{
    return ((double)(int64_t)(word >> 11) + 0.5) * 1.1102230246251565e-16;
}

LJ_APART double lj_draw_from_tail(uint64_t word, const lj_layers *layers)
{
    uint64_t layer;
    double place, edge, x, excess, next_edge, high, low;
    for (;;) {
        layer = word & 255;
        place = 2.0 * lj_uniform(word) - 1.0;
        edge = layers->edges[layer];
        x = place * edge;
        if (fabs(place) < layers->inner[layer]) {
            return x;
        }
        if (layer == 0) {
            for (;;) {
                word = lj_mix_bits((word + UINT64_C(11400714819323198485)) &
                    UINT64_C(18446744073709551615));
                excess = -log(lj_uniform(word)) / 3.654152885361009;
                word = lj_mix_bits((word + UINT64_C(11400714819323198485)) &
                    UINT64_C(18446744073709551615));
                if (-2.0 * log(lj_uniform(word)) >= excess * excess) {
                    return (place > 0.0 ? 3.654152885361009 + excess : -3.654152885361009 - excess);
                }
            }
        }
        word = lj_mix_bits((word + UINT64_C(11400714819323198485)) &
            UINT64_C(18446744073709551615));
        next_edge = layers->edges[layer + 1];
        high = exp(-0.5 * (edge * edge - x * x));
        low = exp(-0.5 * (next_edge * next_edge - x * x));
        if (low + lj_uniform(word) * (high - low) < 1.0) {
            return x;
        }
        word = lj_mix_bits((word + UINT64_C(11400714819323198485)) &
            UINT64_C(18446744073709551615));
    }
}

LJ_WITHIN double lj_normal(uint64_t key, int64_t count, const lj_layers *layers)
{
    uint64_t word, layer;
    double place;
    word = lj_mix_bits((key + count * UINT64_C(11400714819323198485)) &
        UINT64_C(18446744073709551615));
    layer = word & 255;
    place = 2.0 * lj_uniform(word) - 1.0;
    if (fabs(place) < layers->inner[layer]) {
        return place * layers->edges[layer];
    }
    return lj_draw_from_tail(word, layers);
}

LJ_WITHIN void lj_step_factors(const lj_rates *plant, double pump, double vent, double dt, double
        lag, double left, double *out)
{
    double a, b, x, series, gain, ratio, d, phi;
    a = (pump > 0.0 ? plant->rate * pump * plant->top : plant->backwards * pump);
    b = plant->leak + plant->rate * plant->weight * lj_max(pump, 0.0) + plant->vent * vent;
    x = b * dt;
    series = 1.0 / 24.0 - x * (1.0 / 120.0 - x * (1.0 / 720.0));
    series = 1.0 - x * (1.0 / 2.0 - x * (1.0 / 6.0 - x * series));
    gain = dt * (x < 0.01 ? series : -expm1(-x) / x);
    if (lag == 0.0) {
        out[0] = a;
        out[1] = b;
        out[2] = gain;
        out[3] = gain;
        return;
    }
    ratio = dt / lag;
    d = ratio - x;
    if (fabs(d) > 0.001) {
        out[0] = a;
        out[1] = b;
        out[2] = gain;
        out[3] = (ratio * gain - dt * left) / d;
        return;
    }
    phi = (1.0 - left) * ratio * (1.0 + d * (0.5 + d * (1.0 / 6.0 + d * (1.0 / 24.0))));
    out[0] = a;
    out[1] = b;
    out[2] = gain;
    out[3] = (b > 0.0 ? (left - phi) / b : dt - lag * left);
}

LJ_WITHIN void lj_slopes(double v, double w, double a, double b, const lj_rates *plant, double *out)
{
    double p, s, flow;
    p = plant->atmosphere - v;
    s = plant->atmosphere - w;
    flow = plant->passes * (p * p - s * s);
    out[0] = flow - plant->leak * v;
    out[1] = (a - b * w - flow) / plant->side;
}

LJ_APART void lj_advance(double v, double w, double display, double a, double b, const lj_rates
        *plant, double dt, double lag, double *out)
{
    double time_left, h, side, f, g, p, s, dp, ds, m11, m12, m21, m22, det, k1v, k1w, f1, g1, rv,
        rw, k2v, k2w, v1, w1, f2, g2, k3v, k3w, error, delay, fades;
    double r0[2];
    double r1[2];
    double r2[2];
    time_left = dt;
    h = dt;
    side = plant->side;
    while (time_left > 0.0) {
        h = lj_min(h, time_left);
        lj_slopes(v, w, a, b, plant, r0);
        f = r0[0];
        g = r0[1];
        p = plant->atmosphere - v;
        s = plant->atmosphere - w;
        dp = 2.0 * plant->passes * p;
        ds = 2.0 * plant->passes * s;
        m11 = 1.0 + h * 0.2928932188134525 * (dp + plant->leak);
        m12 = -h * 0.2928932188134525 * ds;
        m21 = -h * 0.2928932188134525 * dp / side;
        m22 = 1.0 + h * 0.2928932188134525 * (ds + b) / side;
        det = m11 * m22 - m12 * m21;
        k1v = (m22 * f - m12 * g) / det;
        k1w = (m11 * g - m21 * f) / det;
        lj_slopes(v + 0.5 * h * k1v, w + 0.5 * h * k1w, a, b, plant, r1);
        f1 = r1[0];
        g1 = r1[1];
        rv = f1 - k1v;
        rw = g1 - k1w;
        k2v = (m22 * rv - m12 * rw) / det + k1v;
        k2w = (m11 * rw - m21 * rv) / det + k1w;
        v1 = v + h * k2v;
        w1 = w + h * k2w;
        lj_slopes(v1, w1, a, b, plant, r2);
        f2 = r2[0];
        g2 = r2[1];
        rv = f2 - 7.414213562373095 * (k2v - f1) - 2.0 * (k1v - f);
        rw = g2 - 7.414213562373095 * (k2w - g1) - 2.0 * (k1w - g);
        k3v = (m22 * rv - m12 * rw) / det;
        k3w = (m11 * rw - m21 * rv) / det;
        error = h / 6.0 * lj_max(fabs(k1v - 2.0 * k2v + k3v), fabs(k1w - 2.0 * k2w + k3w));
        error /= 1e-07 * plant->atmosphere;
        if (!(error > 1.0) || h <= 1e-09 * dt) {
            if (lag > 0.0) {
                delay = (v1 - v) / h * lag;
                fades = exp(-h / lag);
                display = v1 - delay + (display - v + delay) * fades;
            } else {
                display = v1;
            }
            v = v1;
            w = w1;
            time_left = time_left - h;
        }
        h *= (error > 0.0 ? lj_min(lj_max(0.8 * pow(error, -1.0 / 3.0), 0.2), 5.0) : 5.0);
    }
    out[0] = v;
    out[1] = w;
    out[2] = display;
}

LJ_WITHIN void lj_advance_plant(double vacuum, double side, double gauge, const double *factors,
        const lj_rates *plant, double dt, double lag, double left, double *out)
{
    double a, b, gain, effect, slope, vacuum_after, shown;
    a = factors[0];
    b = factors[1];
    gain = factors[2];
    effect = factors[3];
    if (plant->side > 0.0) {
        lj_advance(vacuum, side, gauge, a, b - plant->leak, plant, dt, lag, out);
        return;
    }
    slope = a - b * vacuum;
    vacuum_after = vacuum + slope * gain;
    if (vacuum_after > plant->top) {
        vacuum_after = plant->top;
        slope = (plant->top - vacuum) / gain;
    }
    shown = (lag > 0.0 ? gauge + left * (vacuum - gauge) + slope * effect : vacuum_after);
    out[0] = vacuum_after;
    out[1] = side;
    out[2] = shown;
}

LJ_WITHIN double lj_read_sensor(double value, double noise, const lj_chain *chain)
{
    double y;
    y = value + chain->offset + chain->noise * noise;
    if (chain->step > 0.0) {
        y = rint(y / chain->step) * chain->step;
    }
    return lj_min(lj_max(y, chain->lowest), chain->highest);
}

LJ_WITHIN double lj_find_crossing(int64_t sample, double level, double before, double after)
{
    double rise;
    rise = after - before;
    return (rise != 0.0 ? sample + (level - before) / rise : NAN);
}

void lj_run_loop(uint64_t key, const double *settings, const lj_rates *plants, const lj_chain
        *chains, const lj_course *course, const lj_layers *layers, double *out, int64_t rows, double
        *history)
{
    double dt, lag, lag_gain, vacuum, side, gauge, reading, total, pump_time, lowest, highest,
        overshoot, fault_time, low, high, target, noise, pump, vent, fault, vacuum_after;
    int64_t phase, stage, case_, does;
    double state[22];
    double r0[22];
    const lj_chain *chain;
    double r1[25];
    double factors[4];
    double r2[4];
    double r3[3];
    const double *drive;
    const double *memory;
    dt = course->dt;
    lag = course->lag;
    lag_gain = (lag > 0.0 ? -expm1(-dt / lag) : 1.0);
    vacuum = 0.0;
    side = 0.0;
    gauge = 0.0;
    reading = 0.0;
    total = 0.0;
    pump_time = 0.0;
    lowest = INFINITY;
    highest = -INFINITY;
    overshoot = -INFINITY;
    fault_time = NAN;
    low = NAN;
    high = NAN;
    phase = 0;
    stage = 0;
    target = course->levels[0];
    lj_fresh(r0);
    lj_copy(state, r0, 22);
    for (int64_t n = 0; n < course->samples; n++) {
        case_ = (n >= course->onset ? 1 : 0);
        does = (case_ == 1 ? course->sensor : 0);
        if (does == 0) {
            chain = &chains[case_];
            noise = (chain->noise > 0.0 ? lj_normal(key, n, layers) : 0.0);
            reading = lj_read_sensor(gauge, noise, chain);
        } else if (does == 2) {
            reading = course->shown;
        }
        lj_step(settings, state, reading, target, r1);
        lj_copy(state, r1 + 0, 22);
        pump = r1[22];
        vent = r1[23];
        fault = r1[24];
        if (n < rows) {
            history[6 * n] = vacuum;
            history[6 * n + 1] = reading;
            history[6 * n + 2] = target;
            history[6 * n + 3] = pump;
            history[6 * n + 4] = vent;
            history[6 * n + 5] = fault;
        }
        pump_time += fabs(pump);
        if (fault != 0 && fault_time != fault_time) {
            fault_time = n * dt;
        }
        if (n >= course->steady) {
            total += vacuum - target;
            lowest = lj_min(lowest, vacuum);
            highest = lj_max(highest, vacuum);
        }
        lj_step_factors(&plants[case_], pump, (double)vent, dt, lag, lag_gain, r2);
        lj_copy(factors, r2, 4);
        lj_advance_plant(vacuum, side, gauge, factors, &plants[case_], dt, lag, lag_gain, r3);
        vacuum_after = r3[0];
        side = r3[1];
        gauge = r3[2];
        if (n < course->ends[0]) {
            if (low != low && vacuum_after >= 0.1 * target) {
                low = lj_find_crossing(n, 0.1 * target, vacuum, vacuum_after);
            }
            if (high != high && vacuum_after >= 0.9 * target) {
                high = lj_find_crossing(n, 0.9 * target, vacuum, vacuum_after);
            }
            overshoot = lj_max(overshoot, vacuum_after - target);
        }
        vacuum = vacuum_after;
        phase += 1;
        if (phase >= course->ends[stage]) {
            stage += 1;
            if (stage == course->stages) {
                phase = 0;
                stage = 0;
            }
            target = course->levels[stage];
        }
    }
    drive = state + 0;
    memory = state + 8;
    out[0] = (high - low) * dt;
    out[1] = overshoot;
    out[2] = total / lj_max(course->samples - course->steady, 1);
    out[3] = highest - lowest;
    out[4] = pump_time * dt;
    out[5] = drive[5];
    out[6] = drive[6];
    out[7] = memory[13];
    out[8] = fault_time;
}

void lj_run_trial(const lj_rates *plant, const double *watch, const double *memory_before, double
        vacuum, double side, double gauge, double dt, double lag, int64_t steps, double offset,
        double *out)
{
    double memory[14];
    double drive[8];
    double lag_gain, fault;
    double factors[4];
    double r0[4];
    double r1[3];
    double r2[16];
    lj_copy(memory, memory_before, 14);
    drive[0] = 0.0;
    drive[1] = 1.0;
    drive[2] = 0.0;
    drive[3] = 1000000000.0;
    drive[4] = 1000000000.0;
    drive[5] = 0.0;
    drive[6] = 0.0;
    drive[7] = 0.0;
    lag_gain = (lag > 0.0 ? -expm1(-dt / lag) : 1.0);
    lj_step_factors(plant, 1.0, 0.0, dt, lag, lag_gain, r0);
    lj_copy(factors, r0, 4);
    for (int64_t n = 0; n < steps; n++) {
        lj_advance_plant(vacuum, side, gauge, factors, plant, dt, lag, lag_gain, r1);
        vacuum = r1[0];
        side = r1[1];
        gauge = r1[2];
        lj_detect(watch, memory, drive, gauge + offset, 0.0, r2);
        fault = r2[0];
        lj_copy(memory, r2 + 2, 14);
        if (fault != 0.0) {
            out[0] = n + 1.0;
            out[1] = fault;
            return;
        }
    }
    out[0] = 0.0;
    out[1] = 0.0;
}
