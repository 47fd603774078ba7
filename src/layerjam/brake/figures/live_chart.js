// Charts of a page that computes, with axes and labels at their curves.

// numbers from 0 to `most`, in steps of 1, 2 or 5 times a power of ten
const ticks = (most, count) => {
  const ten = 10 ** Math.floor(Math.log10(most / count));
  const step = ten * [1, 2, 5, 10].find(k => k * ten >= most / count);
  return Array.from({length: Math.floor(most / step + 1e-9) + 1}, (_, i) => i * step);
};

// draw curves and marks over axes {name, unit, most}; return the function that finds a pixel's x
const drawChart = (node, {x, y, curves, marks = [], words}) => {
  const size = canvas(node, width => Math.min(Math.max(0.72 * width, 230), 300));
  if (!size) return null;
  const [width, tall] = size, left = 42, right = width - 12, low = tall - 40;
  const px = value => left + value / x.most * (right - left);
  const py = value => low - value / y.most * (low - 30);
  const add = (...all) => node.appendChild(makeSvg(...all));
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
