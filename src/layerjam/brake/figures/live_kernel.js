// The C kernel as WebAssembly: one brake, SI units throughout.

// numbers in its memory: eight of `lj_brake`, six of `lj_end`, and the first six of `lj_state`
const OUTCOMES = ['STOPPED', 'NEVER_SLID', 'BOTTOMED_OUT', 'SNAPS'];
const SNAPPED = 16;  // flag of layerjam.h

// the kernel of a brake, from a module in base64 and the eight numbers of `lj_brake`
const openKernel = async (module, numbers) => {
  const bytes = Uint8Array.from(atob(module), letter => letter.charCodeAt(0));
  const {instance} = await WebAssembly.instantiate(bytes, {env: {pow: Math.pow}});
  const c = instance.exports, memory = new Float64Array(c.memory.buffer, c.numbers(), 20);
  memory.set(numbers);
  return {
    start: c.start,
    force: c.force_at,
    move: (elongation, vacuum) => {
      c.move(elongation, vacuum);
      const [force, slip, work, heat] = memory.subarray(16);
      return {force, slip, work, heat, snapped: (c.flags() & SNAPPED) > 0};
    },
    stop: (...load) => {
      c.stop(...load);
      const [slip, peak, endSpeed, heat, stored, outcome] = memory.subarray(8);
      return {slip, peak, endSpeed, heat, stored, outcome: OUTCOMES[outcome]};
    },
  };
};

// the lowest vacuum [Pa] for which `isEnough` holds, on ever finer grids; null if there is none
const leastVacuum = (isEnough, full, {levels, grid}) => {
  let low = 0, high = full;
  for (let level = 0; level < levels; level++) {
    const step = (high - low) / (grid - 1), start = low, end = high;
    const vacuum = i => i < grid - 1 ? start + i * step : end;
    let first = 0;
    while (first < grid && !isEnough(vacuum(first))) first++;
    if (first === grid) return null;
    if (first === 0) return vacuum(0);
    [low, high] = [vacuum(first - 1), vacuum(first)];
  }
  return high;
};

const isStopped = ({outcome}) => outcome === 'STOPPED' || outcome === 'NEVER_SLID';

// the lowest vacuum [Pa] that stops a mass within its travel if mass, speed and vacuum are off by
// `margin`; null if there is none
const safeVacuum = (kernel, {mass, speed, travel, gravity}, margin, {full, end, search}) =>
  leastVacuum(vacuum => {
    const [m, v, p] = [mass * (1 + margin), speed * (1 + margin), vacuum * (1 - margin)];
    const stop = kernel.stop(m, v, p, gravity, end);
    return isStopped(stop) && stop.slip <= travel;
  }, full, search);
