// The peak of a curve as a handle: dragged up and down, by mouse, finger or arrow keys.

// a chart in the page whose first mark is the peak; the server hears of {force, done}
window.layerjamPeaks = async (node) => {
  const element = node.el, view = node.component.proxy;
  const chart = await layerjamChartOf(node);
  if (!chart) return;
  const handle = document.createElement('div'), said = document.createElement('span');
  handle.className = 'peak-handle';
  handle.append(said);
  handle.tabIndex = 0;
  handle.title = 'Drag the peak up or down';
  const about = {role: 'slider', 'aria-label': 'Peak force', 'aria-orientation': 'vertical',
                 'aria-valuemin': 0, 'data-testid': 'pull-peak-handle'};
  for (const [name, value] of Object.entries(about)) handle.setAttribute(name, value);
  let mark = null, top = 0, held = null, sent = 0, timer = 0;

  const seen = (option) => {
    if (option.series) mark = option.series[0]?.markPoint?.data?.[0]?.coord ?? null;
    const axis = [].concat(option.yAxis ?? [])[0];
    if (axis?.max != null) top = axis.max;
  };
  const set = chart.setOption;
  chart.setOption = (option, how) => { seen(option); return set(option, how); };
  const hide = () => { handle.style.display = 'none'; };
  const place = () => {
    if (!mark) return hide();
    const [x, y] = chart.convertToPixel({gridIndex: 0}, [mark[0], held ?? mark[1]]);
    if (!(held !== null || chart.containPixel({gridIndex: 0}, [x, y + 1]))) return hide();
    handle.style.display = '';
    handle.style.transform = `translate(${x}px, ${y}px)`;
    const now = held ?? mark[1], words = `${now.toPrecision(4)} N`;
    handle.setAttribute('aria-valuenow', now.toPrecision(4));
    handle.setAttribute('aria-valuemax', top);
    handle.setAttribute('aria-valuetext', words);
    said.textContent = held === null ? '' : words;
  };
  // what is asked for while one drags, a few times a second
  const tell = (done) => {
    clearTimeout(timer);
    const wait = done ? 0 : Math.max(0, 80 - (performance.now() - sent));
    timer = setTimeout(() => {
      sent = performance.now();
      view.$emit('peak', {force: held, done});
      if (done) { held = null; setTimeout(place, 400); }
    }, wait);
  };
  const at = (event) => {
    const y = event.clientY - element.getBoundingClientRect().top;
    const force = chart.convertFromPixel({gridIndex: 0}, [0, y])[1];
    held = Math.min(Math.max(force, 0), top * 1.25);
    place();
  };
  handle.addEventListener('pointerdown', e => {
    if (e.button || !mark) return;
    handle.setPointerCapture(e.pointerId);
    handle.toggleAttribute('data-held', true);
    held = mark[1];
    place();
  });
  handle.addEventListener('pointermove', e => {
    if (!handle.hasAttribute('data-held')) return;
    at(e);
    tell(false);
  });
  const let_go = (e) => {
    if (!handle.hasAttribute('data-held')) return;
    handle.removeAttribute('data-held');
    if (e.type === 'pointerup' && held !== mark[1]) tell(true);
    else { clearTimeout(timer); held = null; place(); }
  };
  handle.addEventListener('pointerup', let_go);
  handle.addEventListener('pointercancel', let_go);
  const steps = {ArrowUp: 1, ArrowRight: 1, ArrowDown: -1, ArrowLeft: -1, PageUp: 10, PageDown: -10};
  let keyed = 0;
  handle.addEventListener('keydown', e => {
    if (!steps[e.key] || e.ctrlKey || e.altKey || !mark) return;
    e.preventDefault();
    held = Math.max((held ?? mark[1]) + steps[e.key] * top / 100, 0);
    place();
    clearTimeout(keyed);
    keyed = setTimeout(() => tell(true), 250);
  });
  // the chart below neither pans nor zooms under the handle
  for (const kind of ['mousedown', 'touchstart', 'dblclick', 'mousemove'])
    handle.addEventListener(kind, e => e.stopPropagation(), {passive: true});
  chart.on('rendered', place);
  element.append(handle);
  seen(chart.getOption() ?? {});
  place();
};
