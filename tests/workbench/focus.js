// What has the focus, how wide the line around it is, and how that stands out from its ground.
const e = document.activeElement;
if (!e || e === document.body) return null;
const ring = e.closest('.q-field')?.querySelector('.q-field__control') ?? e;
const style = getComputedStyle(ring);
const inside = parseFloat(style.outlineOffset) < 0;
let back = null;
for (let at = inside ? ring : ring.parentElement; at && !back; at = at.parentElement) {
  const color = rgba(getComputedStyle(at).backgroundColor);
  if (color[3] === 1) back = color;
}
const [a, b] = [rgba(style.outlineColor), back ?? [255, 255, 255, 1]].map(light).sort((x, y) => y - x);
return {
  walk: e.dataset.walk, html: e.outerHTML.slice(0, 140),
  wide: style.outlineStyle === 'none' ? 0 : parseFloat(style.outlineWidth),
  contrast: +((a + 0.05) / (b + 0.05)).toFixed(2),
};
