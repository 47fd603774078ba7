"""The control law of a brake's vacuum: one step of a controller with its fault detectors.

This file imports nothing and uses only floats and tuples of floats, so that the same text runs in
CPython, in MicroPython on a microcontroller, and compiled for batches. `settings.py` builds the
tuples; `docs/control.md` states the rules. Vacuum is in pascals, time in samples.

settings = (regulator, watch), state = (drive, memory); each is unpacked below, in this order.
"""

BANG_BANG, PI, SCHEDULED = 0, 1, 2
HEALTHY, NOT_A_NUMBER, OUT_OF_RANGE, STUCK, OFFSET = 0, 1, 2, 3, 4
NO_VACUUM, WEAK_PUMP, BLOCKED, LOST = 5, 6, 7, 8
CLOSE = 0.01
"""Largest distance from a target at which it always counts as reached, as a fraction of it."""
LEAST_ROOM = 0.05
"""Smallest divisor in gain schedule and feed-forward, as a fraction of the pump's vacuum."""


def fresh() -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Return the state at power-up: pump off, vent closed, no history and no fault."""
    long_ago = 1e9
    drive = (0.0, 0.0, 0.0, long_ago, long_ago, 0.0, 0.0, 0.0)
    return drive, (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


def step(
    settings: tuple[tuple[float, ...], tuple[float, ...]],
    state: tuple[tuple[float, ...], tuple[float, ...]],
    value: float,
    target: float,
) -> tuple[tuple[tuple[float, ...], tuple[float, ...]], float, int, int]:
    """Return (state, pump command, vent command, fault code) from a reading and a target [Pa].

    The pump command is 0 to 1 (-1 to 1 with a reversible pump), a vent command of 1 opens. A target
    of zero or less releases the vacuum. A fault stays until the state is replaced by `fresh()`.
    """
    regulator, watch = settings
    drive, memory = state
    fault, reading, memory = detect(watch, memory, drive, value, target)
    if fault == HEALTHY:
        drive = compute_drive(regulator, drive, reading, target)
    else:
        drive = make_safe_drive(regulator, drive)
    return (drive, memory), drive[1], int(drive[2]), int(fault)


def compute_drive(
    regulator: tuple[float, ...], drive: tuple[float, ...], reading: float, target: float
) -> tuple[float, ...]:
    """Return the drive for the next sample, from a healthy reading."""
    (
        kind, gain, integral_gain, band, vent_band, lowest, least, on_steps, off_steps, vent_steps,
        hold, climb, top, fall, _release,
    ) = regulator  # fmt: skip
    integral, pump, vent, pump_age, vent_age, _ons, _opens, last = drive
    error = target - reading
    if target <= 0.0:
        effort, venting, integral = 0.0, 1.0, 0.0
    else:
        venting = 0.0
        if lowest == 0.0 and (error < -vent_band or (vent != 0.0 and error < -band)):
            venting = 1.0
        if vent != venting and vent_age < vent_steps:
            venting = vent
        if venting != 0.0:
            effort = 0.0
        elif kind == BANG_BANG:
            effort = switch_pump(pump, error, band, vent_band, lowest)
        else:
            if -band <= error <= band:
                error = 0.0
            feedforward = top - fall * target
            if feedforward < LEAST_ROOM * top:
                feedforward = LEAST_ROOM * top
            feedforward = (hold * target + climb * (target - last)) / feedforward
            if kind == SCHEDULED:
                room = top - fall * reading
                error *= top / (room if room > LEAST_ROOM * top else LEAST_ROOM * top)
            new_integral = integral + integral_gain * error
            effort = feedforward + gain * error + new_integral
            # conditional integration: the integral is frozen if it would increase saturation
            if effort > 1.0:
                effort = 1.0
                if error < 0.0:
                    integral = new_integral
            elif effort < lowest:
                effort = lowest
                if error > 0.0:
                    integral = new_integral
            else:
                integral = new_integral
            size = effort if effort > 0.0 else -effort
            if size < least:
                # the pump stops at half the minimum command, so that it does not chatter near that
                # command
                still = pump * effort > 0.0 and size > 0.5 * least
                effort = 0.0 if not still else (least if effort > 0.0 else -least)
    if pump * effort < 0.0:
        effort = 0.0
    if effort == 0.0 and pump != 0.0 and pump_age < on_steps:
        effort = least if pump > 0.0 else -least
    elif effort != 0.0 and pump == 0.0 and pump_age < off_steps:
        effort = 0.0
    return move_drive(drive, integral, effort, venting, target)


def is_reached(regulator: tuple[float, ...], reading: float, target: float, noise: float) -> bool:
    """Return whether a reading is as near to its target as the law can bring it, apart from noise.

    In that range neither acts: the law does not pump within its band below the target, and vents
    only beyond its vent band above the target.
    """
    tolerance, band, vent_band = CLOSE * target, regulator[3], regulator[4]
    below = (tolerance if tolerance > band else band) + noise
    above = (tolerance if tolerance > vent_band else vent_band) + noise
    return target - below <= reading <= target + above


def switch_pump(pump: float, error: float, band: float, vent_band: float, lowest: float) -> float:
    """Return the bang-bang command: on below (target - band), off above (target + band)."""
    if error > band:
        return 1.0
    if error < -vent_band and lowest < 0.0:
        return -1.0
    if error < -band:
        return pump if pump < 0.0 else 0.0
    return pump if pump > 0.0 else 0.0


def make_safe_drive(regulator: tuple[float, ...], drive: tuple[float, ...]) -> tuple[float, ...]:
    """Return the safe drive: pump off, and vent open for `release` or closed for `hold`."""
    return move_drive(drive, 0.0, 0.0, regulator[14], drive[7])


def move_drive(
    drive: tuple[float, ...], integral: float, pump: float, vent: float, target: float
) -> tuple[float, ...]:
    """Return the drive with new commands, updated ages and updated counts of switchings."""
    _integral, was, open_, pump_age, vent_age, pump_switches, vent_switches, _last = drive
    if (was == 0.0) != (pump == 0.0):
        pump_age, pump_switches = 0.0, pump_switches + 1.0
    if open_ != vent:
        vent_age, vent_switches = 0.0, vent_switches + 1.0
    pump_age, vent_age = pump_age + 1.0, vent_age + 1.0
    return integral, pump, vent, pump_age, vent_age, pump_switches, vent_switches, target


def detect(
    watch: tuple[float, ...],
    memory: tuple[float, ...],
    drive: tuple[float, ...],
    value: float,
    target: float,
) -> tuple[float, float, tuple[float, ...]]:
    """Return (fault code, reading to use, detectors' memory) from the last drive and a reading."""
    (
        rise, top, fall, leak, lag, low, high, confirm, clear, none, weak, fast, lost_band,
        lost_steps, same_steps, settle_steps, offset, fade_steps, flow_limit, flow_slope, bend,
        sound, jump, zero,
    ) = watch  # fmt: skip
    (
        reading, range_count, same, quiet, rate, owed, risen, surplus, at_target, missing,
        vent_count, off_count, opening, fault,
    ) = memory  # fmt: skip
    if fault != 0.0:
        return fault, reading, memory
    if value != value or target - target != 0.0:
        fault = 1.0 * NOT_A_NUMBER
        value = reading
    elif value < low or value >= high:
        range_count += 1.0
        value = reading
        if range_count >= confirm:
            fault = 1.0 * OUT_OF_RANGE
    else:
        range_count = 0.0
        change = value - reading
        same = same + 1.0 if change == 0.0 and value > low else 0.0
        if same != 0.0 and same >= same_steps:  # a test for 0 saves a quarter of a simulated step
            fault = 1.0 * STUCK
        pump, vent = drive[1], drive[2]
        least, largest, rate = healthy_rises(
            pump, value, zero, rate, lag, rise, top, fall, flow_limit, flow_slope, bend
        )
        # at low vacuum an orifice leaks more than proportionally: assume the loss at half of `top`
        loss = leak * (value if value > 0.5 * top else 0.5 * top)
        # a vent that has just closed still affects the reading of a slow sensor
        pumping = pump > 0.0 and vent == 0.0 and drive[4] > fade_steps
        surplus = update_surplus(surplus + change, largest, loss, fast, sound) if pumping else 0.0
        if surplus > jump:
            fault = 1.0 * BLOCKED
        if pumping and least > 2.0 * loss:
            quiet = quiet + least if change == 0.0 else 0.0
            off_zero = not -offset <= value <= offset
            owed, risen = owed + least - loss, risen + change
            code, owed, risen, quiet = check_pump(owed, risen, quiet, off_zero, clear, none, weak)
            fault = code if fault == 0.0 else fault
        else:
            owed, risen, quiet, surplus = 0.0, 0.0, 0.0, 0.0

        if vent != 0.0 and pump == 0.0:
            code, vent_count, off_count, opening = watch_vent(
                value, vent_count, off_count, opening, settle_steps, offset, confirm
            )
            fault = code if code != 0.0 else fault
        else:
            vent_count, off_count = 0.0, 0.0

        at_target, missing = watch_target(
            target, drive[7], value >= target - lost_band, at_target, missing
        )
        if missing > 0.0 and missing >= lost_steps:
            fault = 1.0 * LOST
    return fault, value, (
        value, range_count, same, quiet, rate, owed, risen, surplus, at_target, missing,
        vent_count, off_count, opening, fault,
    )  # fmt: skip


def healthy_rises(
    pump: float,
    vacuum: float,
    zero: float,
    rate: float,
    lag: float,
    rise: float,
    top: float,
    fall: float,
    flow_limit: float,
    flow_slope: float,
    bend: float,
) -> tuple[float, float, float]:
    """Return a healthy line's (least, largest, lagged largest) rise of the vacuum per sample."""
    high = low = 0.0
    if pump != 0.0:
        # a zero error of the sensor hides how close the pump is to its limit
        high = healthy_rise(pump, vacuum - zero, rise, top, fall, flow_limit, flow_slope, bend)
        low = healthy_rise(pump, vacuum + zero, rise, top, fall, flow_limit, flow_slope, bend)
    # a sensor may be fast or slow: the smaller of the two rises is expected, the larger allowed
    rate += lag * (high - rate)
    least, largest = (rate, high) if rate < high else (high, rate)
    return least - (high - low), largest, rate


def healthy_rise(
    pump: float,
    vacuum: float,
    rise: float,
    top: float,
    fall: float,
    flow_limit: float,
    flow_slope: float,
    bend: float,
) -> float:
    """Return the rise of the vacuum that a healthy pump produces in a sample through the tube."""
    gives = rise * pump * (top - fall * vacuum)
    through = flow_limit - (flow_slope - bend * vacuum) * vacuum
    return gives if gives < through else through


def update_surplus(surplus: float, rate: float, loss: float, fast: float, sound: float) -> float:
    """Return the largest excess over a sound line's rise since any earlier sample, at least 0.

    The history before a blockage therefore cannot hide it. A sound line may have no leak at all.
    """
    allowance = fast * (rate - loss)
    if allowance < sound * rate:
        allowance = sound * rate
    surplus -= allowance
    return surplus if surplus > 0.0 else 0.0


def check_pump(
    owed: float, risen: float, quiet: float, off_zero: bool, clear: float, none: float, weak: float
) -> tuple[float, float, float, float]:
    """Return (fault code, owed, risen, quiet); `quiet` is the rise owed since the last change.

    A sufficient rise resets the count, so that the history before a failure does not hide it.
    """
    if risen >= weak * owed:
        return 0.0, 0.0, 0.0, 0.0
    if weak * (owed - clear) <= risen:
        return 0.0, owed, risen, quiet
    fault = 1.0 * (NO_VACUUM if risen < none * owed else WEAK_PUMP)
    # a reading that never changed means a sensor fault, but at zero it may be a pump fault
    if off_zero and quiet > 0.5 * owed:
        fault = 1.0 * STUCK
    return fault, owed, risen, quiet


def watch_vent(
    value: float,
    vent_count: float,
    off_count: float,
    opening: float,
    settle_steps: float,
    offset: float,
    confirm: float,
) -> tuple[float, float, float, float]:
    """Return (fault code, samples with the vent open, those with an offset, reading at opening)."""
    if vent_count == 0.0:
        opening = value
    vent_count += 1.0
    if vent_count <= settle_steps or -offset <= value <= offset:
        return 0.0, vent_count, 0.0, opening
    off_count += 1.0
    stays = opening > 2.0 * offset and value > 0.5 * opening
    fault = 1.0 * (BLOCKED if stays else OFFSET)
    return fault if off_count >= confirm else 0.0, vent_count, off_count, opening


def watch_target(
    target: float, last: float, is_close: bool, at_target: float, missing: float
) -> tuple[float, float]:
    """Return whether the target has been reached, and for how many samples it has been lost."""
    if target <= 0.0:
        return 0.0, 0.0
    if is_close:
        return 1.0, 0.0
    if target > last or at_target == 0.0:
        return 0.0, 0.0
    return at_target, missing + 1.0


reached, safe, excess = is_reached, make_safe_drive, update_surplus  # former names
command, pump_fault = compute_drive, check_pump  # former names
