// A walk past the page's controls: each step opens a tab and lights one of them up.
// Escape ends it, Enter and the arrows go on and back; then the focus is on its button again.
window.layerjamTour = (steps) => {
  const at = (ident) => document.querySelector(`[data-testid="${ident}"]`);
  document.querySelector('.tour')?.remove();
  const root = document.createElement('div');
  root.className = 'tour';
  root.innerHTML = `<div class="tour-light"></div>
    <div class="tour-card" role="dialog" aria-modal="true" aria-labelledby="tour-head"
     aria-describedby="tour-text" data-testid="tour">
    <h2 id="tour-head"></h2><p id="tour-text"></p><div class="tour-acts"><span></span>
    <button type="button" data-testid="tour-end">End</button>
    <button type="button" data-testid="tour-back">Back</button>
    <button type="button" class="tour-next" data-testid="tour-next"></button></div></div>`;
  document.body.append(root);
  const [light, card] = root.children, [back, next] = [...root.querySelectorAll('button')].slice(1);
  let step = 0, timer = 0;

  function place() {
    const target = at(steps[step].target), room = 6, edge = 12;
    const seen = target?.checkVisibility() ? target.getBoundingClientRect() : null;
    const wide = innerWidth, tall = innerHeight;
    const box = seen && seen.width ? seen : {left: wide / 2, top: tall / 2, width: 0, height: 0};
    Object.assign(light.style, {left: `${box.left - room}px`, top: `${box.top - room}px`,
      width: `${box.width + 2 * room}px`, height: `${box.height + 2 * room}px`});
    const {offsetWidth: w, offsetHeight: h} = card, inside = (x, most) => Math.max(edge, Math.min(x, most));
    const under = box.top + box.height + 2 * room, over = box.top - h - 2 * room;
    let left = box.left + box.width / 2 - w / 2, top = under;
    if (under + h > tall - edge) top = over;
    if (top < edge) { // neither over nor under it: beside, or on it
      top = box.top + box.height / 2 - h / 2;
      left = box.left + box.width + 2 * room + w < wide ? box.left + box.width + 2 * room : box.left - w - 2 * room;
      if (left < edge) { left = box.left + box.width - w - room; top = box.top + box.height - h - room; }
    }
    card.style.left = `${inside(left, wide - w - edge)}px`;
    card.style.top = `${inside(top, tall - h - edge)}px`;
  }

  function show(number) {
    step = number;
    const {tab, target, title, text} = steps[step];
    root.querySelector('h2').textContent = title;
    root.querySelector('p').textContent = text;
    root.querySelector('span').textContent = `${step + 1} of ${steps.length}`;
    back.disabled = step === 0;
    next.textContent = step === steps.length - 1 ? 'Done' : 'Next';
    if (at(`tab-${tab}`)?.getAttribute('aria-selected') !== 'true') at(`tab-${tab}`)?.click();
    let tries = 0;
    clearInterval(timer);
    timer = setInterval(() => {
      const box = (++tries < 8 || tries % 10 === 0) && at(target)?.getBoundingClientRect();
      if (box && (box.top < 100 || box.bottom > innerHeight - 20)) {
        at(target).scrollIntoView({block: 'center'});
      }
      place();
      if (tries > 100) clearInterval(timer);
    }, 100);
    place();
    next.focus({preventScroll: true});
  }

  function end() {
    clearInterval(timer);
    removeEventListener('keydown', keys, true);
    removeEventListener('resize', place);
    removeEventListener('scroll', place);
    root.remove();
    if (at(`tab-${steps[0].tab}`)?.getAttribute('aria-selected') !== 'true') at(`tab-${steps[0].tab}`)?.click();
    let tries = 0;
    const again = setInterval(() => { // the tab it was on takes a moment to come back
      const there = at('start-tour');
      if (there?.checkVisibility()) there.focus();
      if (++tries > 30 || document.activeElement === there) clearInterval(again);
    }, 100);
  }

  const go = (by) => {
    if (step + by >= steps.length) end(); else if (step + by >= 0) show(step + by);
  };

  function keys(event) {
    const buttons = [...root.querySelectorAll('button:not([disabled])')];
    const here = buttons.indexOf(document.activeElement);
    const acts = {Escape: end, ArrowRight: () => go(1), ArrowLeft: () => go(-1),
      Tab: () => buttons.at((here + (event.shiftKey ? -1 : 1)) % buttons.length).focus()};
    if (event.key === 'Enter' && here < 0) acts.Enter = () => go(1);
    event.stopPropagation();
    if (!acts[event.key]) return;
    event.preventDefault();
    acts[event.key]();
  }

  root.querySelector('[data-testid=tour-end]').onclick = end;
  back.onclick = () => go(-1);
  next.onclick = () => go(1);
  addEventListener('keydown', keys, true);
  addEventListener('resize', place);
  addEventListener('scroll', place);
  show(0);
};
