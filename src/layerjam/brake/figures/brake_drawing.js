// A brake as SVG, for the page that computes and for the frame of the workbench.

// a node of an SVG with its attributes
const makeSvg = (kind, attributes, text = '') => {
  const node = document.createElementNS('http://www.w3.org/2000/svg', kind);
  for (const name in attributes) node.setAttribute(name, attributes[name]);
  node.textContent = text;
  return node;
};

// a number with four significant digits, and its unit
const say = (value, unit = '', digits = 4) =>
  `${+value.toPrecision(digits)}\u00a0${unit}`.trim().replace('-', '−');

// a drawing as wide as its place; null if it is not displayed
const canvas = (node, height) => {
  const width = node.clientWidth;
  if (!width) return null;
  const tall = height(width);
  node.setAttribute('viewBox', `0 0 ${width} ${tall}`);
  node.replaceChildren();
  return [width, tall];
};

// the brake from the side and from above, pulled out by a slip [mm]; `size` is of device_drawing.py
const drawBrake = (node, size, slip, vacuum) => {
  const {cap, left, overlap, right, travel, sheets: count} = size;
  const total = 2 * cap + left + overlap + right + travel;
  const sheet = 5, pitch = vacuum > 0 ? 6 : 8;
  const tall = count * 8 + 14, middle = 20 + tall / 2, y = tall + 94;
  const depth = width => Math.min(size.width * (width - 20) / total, 80);
  const box = canvas(node, width => y + depth(width) + 6);
  if (!box) return;
  const scale = (box[0] - 20) / total, deep = depth(box[0]);
  const px = x => 10 + x * scale;
  const add = (...all) => node.appendChild(makeSvg(...all));
  const rect = (kind, x, top, end, high) => add(
    'rect', {class: kind, x: px(x), y: top, width: Math.max(px(end) - px(x), 0), height: high});
  const text = (kind, x, base, said, anchor) =>
    add('text', {class: kind, x, y: base, 'text-anchor': anchor}, said);
  const edge = cap + left + overlap, moved = cap + left + slip;
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
  for (const [kind, x] of [['ghost', edge + right + travel], ['cap', 0], ['cap', end]]) {
    rect(kind, x, middle - tall / 2, x + cap, tall);
    rect(kind, x, y - 2, x + cap, deep + 4);
  }
};
