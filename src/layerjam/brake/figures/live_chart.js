// SVG of a page that computes: charts with axes and labels at their curves.

// a node of an SVG with its attributes
const svg = (kind, attributes, text = '') => {
  const node = document.createElementNS('http://www.w3.org/2000/svg', kind);
  for (const name in attributes) node.setAttribute(name, attributes[name]);
  node.textContent = text;
  return node;
};

// a number with four significant digits, and its unit
const say = (value, unit = '', digits = 4) =>
  `${+value.toPrecision(digits)}\u00a0${unit}`.trim().replace('-', '−');

// numbers from 0 to `most`, in steps of 1, 2 or 5 times a power of ten
const ticks = (most, count) => {
  const ten = 10 ** Math.floor(Math.log10(most / count));
  const step = ten * [1, 2, 5, 10].find(k => k * ten >= most / count);
  return Array.from({length: Math.floor(most / step + 1e-9) + 1}, (_, i) => i * step);
};

// a drawing as wide as its place; null if it is not displayed
const canvas = (node, height) => {
  const width = node.clientWidth;
  if (!width) return null;
  const tall = height(width);
  node.setAttribute('viewBox', `0 0 ${width} ${tall}`);
  node.replaceChildren();
  return [width, tall];
};

// draw curves and marks over axes {name, unit, most}; return the function that finds a pixel's x
const drawChart = (node, {x, y, curves, marks = [], words}) => {
  const size = canvas(node, width => Math.min(Math.max(0.72 * width, 230), 300));
  if (!size) return null;
  const [width, tall] = size, left = 42, right = width - 12, low = tall - 40;
  const px = value => left + value / x.most * (right - left);
  const py = value => low - value / y.most * (low - 30);
  const add = (...all) => node.appendChild(svg(...all));
  const text = (kind, u, v, said, anchor) =>
    add('text', {class: kind, x: u, y: v, 'text-anchor': anchor}, said);
  node.setAttribute('aria-label', words);
  for (const value of ticks(y.most, 5)) {
    add('path', {class: 'grid', d: `M${left} ${py(value)}H${right}`});
    text('tick', left - 6, py(value) + 4, say(value), 'end');
  }
  for (const value of ticks(x.most, width < 420 ? 4 : 6)) {
    add('path', {class: 'grid', d: `M${px(value)} ${low}v5`});
    text('tick', px(value), low + 19, say(value), 'middle');
  }
  text('axis', 4, 14, `${y.name} [${y.unit}]`, 'start');
  text('axis', right, tall - 5, `${x.name} [${x.unit}]`, 'end');
  for (const {points, kind} of curves) {
    const d = points.map(([u, v], i) => `${i ? 'L' : 'M'}${px(u).toFixed(1)} ${py(v).toFixed(1)}`);
    add('path', {class: `curve ${kind}`, d: d.join('')});
  }
  for (const {at, kind} of marks)
    add('circle', {class: `mark ${kind}`, cx: px(at[0]), cy: py(at[1]), r: 6});
  for (const {said, at, kind, shift: [dx, dy], anchor} of [...curves, ...marks].filter(c => c.said)) {
    const before = {start: 0, middle: 4, end: 8}[anchor] * said.length;
    const after = 8 * said.length - before;
    const u = Math.min(Math.max(px(at[0]) + dx, left + before), right - after);
    text(`label ${kind}`, u, Math.max(py(at[1]) + dy, 28), said, anchor);
  }
  return pixel => Math.min(Math.max((pixel - left) / (right - left), 0), 1) * x.most;
};

// call `pick` with the x at which the pointer is dragged over a chart; `place` finds it
const onDrag = (node, place, pick) => {
  const drag = event => {
    if (event.type === 'pointerdown') node.setPointerCapture(event.pointerId);
    else if (!node.hasPointerCapture(event.pointerId)) return;
    const find = place();
    if (find) pick(find(event.clientX - node.getBoundingClientRect().left));
  };
  for (const kind of ['pointerdown', 'pointermove']) node.addEventListener(kind, drag);
};

// the brake from the side and from above, pulled out by a slip [mm]; `size` is in mm
const drawBrake = (node, size, slip, vacuum) => {
  const count = Math.min(size.count, 11), sheet = 5, pitch = vacuum > 0 ? 6 : 8;
  const tall = count * 8 + 14, middle = 20 + tall / 2, y = tall + 94;
  const depth = width => Math.min(size.width * (width - 20) / size.total, 80);
  const box = canvas(node, width => y + depth(width) + 6);
  if (!box) return;
  const scale = (box[0] - 20) / size.total, deep = depth(box[0]);
  const px = x => 10 + x * scale;
  const add = (...all) => node.appendChild(svg(...all));
  const rect = (kind, x, top, end, high) => add(
    'rect', {class: kind, x: px(x), y: top, width: Math.max(px(end) - px(x), 0), height: high});
  const text = (kind, x, base, said, anchor) =>
    add('text', {class: kind, x, y: base, 'text-anchor': anchor}, said);
  const {cap, left, overlap, right} = size, edge = cap + left + overlap, moved = cap + left + slip;
  const end = edge + right + slip, line = tall + 30;
  const arrow = (from, to, said, kind, drop) => {
    const [a, b] = [px(from), px(to)];
    const d = `M${a} ${line - 5}v10M${b} ${line - 5}v10M${a} ${line}H${b}`;
    add('path', {class: `size ${kind}`, d});
    text(`label ${kind}`, Math.min((a + b) / 2, box[0] - 45), line + 17 + drop, said, 'middle');
  };
  text('tick', 10, 12, 'From the side: lengths to scale, thickness × '
    + say(sheet / scale / size.thickness, '', 2), 'start');
  rect('skin', cap, middle - count * pitch / 2 - 5, end, count * pitch + 10);
  for (let i = 0; i < count; i++) {
    const top = middle + (i - count / 2) * pitch;
    if (i % 2) rect('sheet-right', moved, top, end, sheet);
    else rect('sheet-left', cap, top, edge, sheet);
  }
  arrow(moved, edge, `overlap ${say(edge - moved, 'mm', 3)}`, '', 0);
  const isNear = px(end - slip / 2) - px((moved + edge) / 2) < 110;
  if (slip > 0) arrow(end - slip, end, `slip ${say(slip, 'mm', 3)}`, 'pulled', isNear ? 15 : 0);
  text('tick', 10, y - 8, `From above: ${deep < 80 ? '' : 'lengths '}to scale, ${size.count} sheets `
    + `${say(size.width)} × ${say(size.thickness)} mm`, 'start');
  rect('skin', cap, y, end, deep);
  rect('sheet-left', cap, y + 2, edge, deep - 4);
  rect('sheet-right', moved, y + 2, end, deep - 4);
  rect('both', moved, y + 2, edge, deep - 4);
  for (const [kind, x] of [['ghost', edge + right + size.end], ['cap', 0], ['cap', end]]) {
    rect(kind, x, middle - tall / 2, x + cap, tall);
    rect(kind, x, y - 2, x + cap, deep + 4);
  }
};
