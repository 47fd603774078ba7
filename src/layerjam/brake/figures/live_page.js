// What a reader moves, and what is computed from it. `DATA` comes from live_page.py.

const {full, end, gravity, margin, search, shape} = DATA;
const KPA = 1e3, MM = 1e-3;
const find = name => document.getElementById(`live-${name}`);
const kernel = await openKernel(DATA.module, DATA.numbers);
const stiffness = DATA.numbers[2], holds = kernel.force(0, full);
const last = kernel.force(end, full), farthest = Math.max(holds / stiffness, end + last / stiffness);
// numbers from 0 to `last`, denser near 0
const spread = last => Array.from({length: 121}, (_, i) => last * (i / 120) ** 1.5);
const strongest = 1.15 * Math.max(...spread(end).map(slip => kernel.force(slip, full)));
const round = (value, digits = 2) => +value.toPrecision(digits);

// values in SI; the mass is one that full vacuum stops within half of the usable travel
const mass = [1e3, 100, 10, 1, 0.1, 0.01, 1e-3].flatMap(ten => [5 * ten, 2 * ten, ten])
  .find(m => isStopped(kernel.stop(m, 2.5, full, gravity, end / 2))) ?? 1e-3;
const now = {
  vacuum: Math.round(0.6 * full / 5e3) * 5e3, slip: round(end / 6), elongation: 0,
  mass, speed: 2.5, travel: round(2 / 3 * end), margin,
};
let shown = 'slip', trace = [[0, 0]], pulled = {force: 0, slip: 0, heat: 0}, places = {};

// {quantity: [name, unit, factor to SI, least, most]}
const FIELDS = {
  vacuum: ['Vacuum', 'kPa', KPA, 0, full],
  slip: ['Slip', 'mm', MM, 0, end],
  elongation: ['Elongation', 'mm', MM, 0, farthest],
  mass: ['Mass', 'kg', 1, mass / 20, 10 * mass],
  speed: ['Speed', 'm/s', 1, 0.05, 10],
  travel: ['Travel allowed', 'mm', MM, end / 50, end],
  margin: ['Margin', '%', 0.01, 0, 0.2],
};
const inputs = {};
const mm = (length, digits) => say(length / MM, 'mm', digits);
const kpa = vacuum => say(vacuum / KPA, 'kPa');

// a number and a slider for one quantity, at its place in the page; the browser checks the bounds
const addField = place => {
  const key = place.dataset.field, [name, unit, factor, low, high] = FIELDS[key];
  const bounds = {min: low / factor, max: high / factor, step: 'any', required: true};
  const make = (kind, more) => Object.assign(document.createElement(kind), more);
  const number = make('input', {type: 'number', id: `live-number-${key}`, ...bounds});
  const slider = make('input', {type: 'range', ariaLabel: name, ...bounds});
  const label = make('label', {textContent: `${name} [${unit}]`, htmlFor: number.id});
  const put = value => set(key, Math.min(Math.max(value * factor, low), high));
  slider.addEventListener('input', () =>
    put(+slider.value < slider.max ? round(+slider.value, 3) : +slider.max));
  number.addEventListener('input', () => { if (number.reportValidity()) put(+number.value); });
  number.addEventListener('blur', () => write(key));
  place.append(label, slider, number);
  inputs[key] = {number, slider};
  write(key);
};

const write = key => {
  const [, unit, factor] = FIELDS[key], {number, slider} = inputs[key];
  const text = String(round(now[key] / factor, 6));
  if (document.activeElement !== number) number.value = text;
  slider.value = now[key] / factor;
  slider.setAttribute('aria-valuetext', `${text} ${unit}`);
};

// move the brake of the pull to the present elongation and vacuum, in steps that show its way
const pull = from => {
  const steps = 1 + Math.ceil(Math.abs(now.elongation - from) / farthest * 120);
  for (let i = 1; i <= steps; i++) {
    const elongation = i < steps ? from + (now.elongation - from) * i / steps : now.elongation;
    pulled = kernel.move(elongation, now.vacuum);
    trace.push([elongation / MM, pulled.force]);
  }
  trace = trace.slice(-4000);
};

const restart = () => {
  kernel.start(now.vacuum);
  now.elongation = 0;
  trace = [[0, 0]];
  pull(0);
};

let asked = 0;
const set = (key, value) => {
  const from = now.elongation;
  now[key] = value;
  write(key);
  if (key === 'elongation' || key === 'vacuum') pull(from);
  if (key !== 'vacuum') shown = key === 'slip' || key === 'elongation' ? key : 'stop';
  cancelAnimationFrame(asked);
  asked = requestAnimationFrame(draw);
};

const answer = (name, number, words) => {
  find(`${name}-number`).textContent = number;
  find(`${name}-words`).textContent = words;
};

// the mark of a chart's present point
const markForce = (x, force) =>
  [{at: [x, force], kind: 'main', said: say(force, 'N'), shift: [0, -20], anchor: 'middle'}];

const drawForce = () => {
  const {vacuum, slip} = now, force = kernel.force(slip, vacuum);
  const rises = last > holds, named = (rises ? 0.6 : 0.3) * end;
  const along = p => spread(end).map(s => [s / MM, kernel.force(s, p)]);
  answer('force', say(force, 'N'), `at ${mm(slip)} of slip and ${kpa(vacuum)}`);
  places.force = drawChart(find('force-chart'), {
    words: `Force versus slip at ${kpa(vacuum)}`,
    x: {name: 'Slip', unit: 'mm', most: end / MM}, y: {name: 'Force', unit: 'N', most: strongest},
    curves: [
      {points: along(full), kind: 'faint', said: `full vacuum, ${kpa(full)}`,
       at: [named / MM, kernel.force(named, full)], shift: [rises ? -8 : 8, -6],
       anchor: rises ? 'end' : 'start'},
      {points: along(vacuum), kind: 'main'},
    ],
    marks: markForce(slip / MM, force),
  });
};

const drawPull = () => {
  const {force, slip, heat, snapped} = pulled;
  answer('pull', say(force, 'N'), snapped
    ? 'The friction falls faster than this soft rope can follow: the brake snaps, and may jump.'
    : `at ${mm(now.elongation)}: slip ${mm(slip)}, heat so far `
      + say(heat, 'J', 3) + (slip > end * (1 + 1e-9) ? ', beyond the usable travel' : ''));
  places.pull = drawChart(find('pull-chart'), {
    words: `Force versus elongation since the start: now ${say(force, 'N')}`,
    x: {name: 'Elongation', unit: 'mm', most: farthest / MM},
    y: {name: 'Force', unit: 'N', most: strongest},
    curves: [{points: trace, kind: 'main'}],
    marks: markForce(now.elongation / MM, force),
  });
};

const describeStop = (vacuum, {outcome, slip, peak, endSpeed, heat}) => {
  const start = `At ${kpa(vacuum)}, mass and speed as stated:`;
  const weight = now.mass * gravity || now.mass * 9.80665;
  const numbers = `peak ${say(peak, 'N')} (${say(peak / weight, 'g', 3)}), heat ${say(heat, 'J', 3)}`;
  if (outcome === 'SNAPS') return `${start} the brake snaps, and its force jumps.`;
  if (outcome === 'BOTTOMED_OUT')
    return `${start} the travel of ${mm(end)} is used up at ${say(endSpeed, 'm/s', 3)}.`;
  return `${start} slip ${mm(slip, 3)}, ${numbers}.`;
};

const drawStop = () => {
  const {mass, speed, travel} = now, along = find('falls').checked ? gravity : 0;
  const site = {full, end, search}, load = {mass, speed, travel, gravity: along};
  const [least, safe] = [0, now.margin].map(share => safeVacuum(kernel, load, share, site));
  const stop = (vacuum, share = 0) =>
    kernel.stop(mass * (1 + share), speed * (1 + share), vacuum * (1 - share), along, end);
  const percent = say(100 * now.margin, '%');
  const task = `${say(mass, 'kg')} at ${say(speed, 'm/s')} within ${mm(travel)}`;
  if (safe === null)
    answer('stop', 'none', `No vacuum of this site stops ${task} with a margin of ${percent}`
      + `${least === null ? '' : `; without a margin, ${kpa(least)} does`}.`);
  else
    answer('stop', kpa(safe), `stops ${task}, even if mass, speed and vacuum are each `
      + `${percent} off. Without a margin: ${kpa(least)}.`);
  const vacuum = safe ?? full, exact = stop(vacuum);
  find('stop-more').textContent = describeStop(vacuum, exact);
  const slips = share => spread(full).map(p => [p / KPA, stop(p, share).slip / MM]);
  const [exactly, worst] = [slips(0), slips(now.margin)];
  // the place of a curve's name: where it begins to fall
  const [from, to] = [exactly, worst].map(c => c.find(([, z]) => z < 0.85 * end / MM) ?? c.at(-1));
  drawChart(find('stop-chart'), {
    words: `Slip at the stop versus vacuum: ${find('stop-words').textContent}`,
    x: {name: 'Vacuum', unit: 'kPa', most: full / KPA},
    y: {name: 'Slip at the stop', unit: 'mm', most: 1.15 * end / MM},
    curves: [
      {points: [[0, travel / MM], [full / KPA, travel / MM]], kind: 'faint', at: [0, travel / MM],
       said: `allowed ${mm(travel)}`, shift: [4, 15], anchor: 'start'},
      {points: worst, kind: 'worst', said: `${percent} off`, at: to, shift: [8, 0], anchor: 'start'},
      {points: exactly, kind: 'main', said: 'as stated', at: from, shift: [-8, 8], anchor: 'end'},
    ],
    marks: safe === null ? [] : [{at: [safe / KPA, stop(safe, now.margin).slip / MM], kind: 'worst',
                                  said: 'safe', shift: [9, -7], anchor: 'start'}],
  });
  return exact;
};

const draw = () => {
  drawForce();
  drawPull();
  const stop = drawStop();
  const slip = Math.min({slip: now.slip, elongation: pulled.slip, stop: stop.slip}[shown], end);
  drawBrake(find('brake'), shape, slip / MM, now.vacuum);
  const why = {slip: 'the slip below', elongation: 'the pull', stop: 'the end of the stop'}[shown];
  find('brake-words').textContent = `Drawn at ${mm(slip)} of slip, ${why}. Blue sheets are `
    + 'held left, orange ones right; they overlap where green. Dashed: end of the travel.';
  find('brake').setAttribute('aria-label', find('brake-words').textContent);
};

document.querySelectorAll('[data-field]').forEach(addField);
find('falls').addEventListener('change', draw);
find('out').addEventListener('click', () => set('elongation', farthest));
find('back').addEventListener('click', () => set('elongation', 0));
find('again').addEventListener('click', () => { restart(); write('elongation'); draw(); });
onDrag(find('force-chart'), () => places.force, slip => set('slip', slip * MM));
onDrag(find('pull-chart'), () => places.pull, elongation => set('elongation', elongation * MM));
restart();
for (const share of [0.5, 0.47, 0.7, 0.66, 0.8]) set('elongation', round(share * farthest));
shown = 'slip';
find('missing').remove();
find('parts').hidden = false;
new ResizeObserver(draw).observe(find('parts'));
