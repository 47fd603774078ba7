// Texts whose contrast with their ground is below WCAG AA: 4.5, or 3 where they are large.
const bad = [];
const walk = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
const root = rgba(getComputedStyle(document.body).backgroundColor);
while (walk.nextNode()) {
  const node = walk.currentNode, text = node.nodeValue.trim(), element = node.parentElement;
  if (!text || !element.checkVisibility({opacityProperty: true, visibilityProperty: true})) continue;
  if (element.closest('[disabled], .disabled, [inert], [aria-hidden=true], .sr-only, script, style, svg')) continue;
  if (element.closest('.nicegui-scene')) continue; // on a light ground of its own
  const range = document.createRange(); range.selectNode(node);
  const box = range.getBoundingClientRect();
  if (box.width < 2 || box.height < 2) continue;
  const layers = []; let fade = 1;
  for (let e = element; e; e = e.parentElement) {
    const style = getComputedStyle(e);
    const back = rgba(style.backgroundColor);
    // what fades the ground fades the words with it: counted for the words alone, the harder case
    fade *= +style.opacity;
    if (back[3] > 0) layers.push(back);
    if (back[3] === 1) break;
  }
  let back = root[3] === 1 ? root : [255, 255, 255, 1];
  for (const layer of layers.reverse()) back = over(layer, back);
  const style = getComputedStyle(element), ink = rgba(style.color);
  const shown = over([ink[0], ink[1], ink[2], ink[3] * fade], back);
  const [a, b] = [light(shown), light(back)].sort((x, y) => y - x);
  const ratio = (a + 0.05) / (b + 0.05);
  const size = parseFloat(style.fontSize), large = size >= 24 || (size >= 18.66 && +style.fontWeight >= 700);
  if (ratio < (large ? 3 : 4.5))
    bad.push({text: text.slice(0, 50), ratio: +ratio.toFixed(2), color: shown.map(Math.round).join(), back: back.map(Math.round).join(), size, at: element.className.slice(0, 60)});
}
return bad;
