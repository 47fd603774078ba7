// Zoom on every chart: Ctrl and the wheel, two fingers, or the buttons; a double click shows all.

window.layerjamZoomed = (element, chart) => {
  const set = chart.setOption.bind(chart), spans = {};
  const SIDES = ['xAxis', 'yAxis'], labels = {xAxis: [], yAxis: []};
  let count = '', zoomed = false, armed = false;

  // one zoom for all x axes, which stand below each other, and one for each y axis
  const zooms = (axes) => axes[1].concat('x').map((_, i, all) => {
    const last = i === all.length - 1, id = last ? 'x' : 'y' + i;
    const [start, end] = spans[id] ?? [0, 100];
    const which = last ? {xAxisIndex: axes[0].map((_, k) => k)} : {yAxisIndex: i};
    return {
      id, type: 'inside', filterMode: 'none', start, end, minSpan: 0.5, ...which,
      zoomOnMouseWheel: 'ctrl', moveOnMouseWheel: false, moveOnMouseMove: zoomed,
      preventDefaultMouseMove: zoomed, throttle: 20,
    };
  });

  // where a zoomed axis ends is no round number: it is not written over the one beside it
  const named = (axes) => Object.fromEntries(SIDES.map((side, k) => [side, axes[k].map((axis, i) => {
    const {showMinLabel = null, showMaxLabel = null, ...label} = labels[side][i] ?? {};
    const ends = zoomed ? {showMinLabel: false, showMaxLabel: false} : {showMinLabel, showMaxLabel};
    return {...axis, axisLabel: {...label, ...ends}};
  })]).filter(([, axes]) => axes.length));

  // a drawing made anew would lose the zoom
  chart.setOption = (option, how) => {
    const axes = SIDES.map(side => [].concat(option[side] ?? []));
    SIDES.forEach((side, k) => axes[k].forEach((axis, i) => {
      if (axis.axisLabel) labels[side][i] = axis.axisLabel;
    }));
    if (zoomed) option = {...option, ...named(axes)};
    const now = axes.map(side => side.length).join();
    const both = axes[0].length && axes[1].length;
    const anew = armed && both && (how?.notMerge || now !== count);
    if (anew) count = now;
    return set(anew ? {...option, dataZoom: zooms(axes)} : option, how);
  };

  const ends = () => (chart.getOption()?.dataZoom ?? []).map(z => [z.id, z.start, z.end]);
  const show = (made) => {
    const batch = made.map(([dataZoomId, start, end]) => ({dataZoomId, start, end}));
    if (batch.length) chart.dispatchAction({type: 'dataZoom', batch});
  };
  const whole = () => show(ends().map(([id]) => [id, 0, 100]));
  const within = ([id, start, end]) => {
    const wide = Math.min(end - start, 100), from = Math.min(Math.max(start, 0), 100 - wide);
    return [id, from, from + wide];
  };
  const nearer = (share) => show(ends().map(([id, start, end]) => {
    const middle = (start + end) / 2, half = Math.max((end - start) / 2 * share, 0.25);
    return within([id, middle - half, middle + half]);
  }));
  const moved = (right, up) => show(ends().map(([id, start, end]) => {
    const way = (id === 'x' ? right : up) * (end - start) / 5;
    return within([id, start + way, end + way]);
  }));

  chart.on('datazoom', () => {
    const now = ends();
    for (const [id, start, end] of now) spans[id] = [start, end];
    const is = now.some(([, start, end]) => end - start < 99.99);
    element.toggleAttribute('data-zoomed', is);
    element.dispatchEvent(new Event('zoomed'));
    if (is === zoomed) return;
    zoomed = is;
    // one finger moves what is zoomed, and the page else
    const zooming = now.map(([id]) => ({id, moveOnMouseMove: is, preventDefaultMouseMove: is}));
    set({dataZoom: zooming, ...named(SIDES.map(side => labels[side].map(() => ({}))))});
  });
  // not by ECharts' own: after a finger it takes no notice of the mouse that the browser plays, and
  // a double tap comes as that alone
  element.addEventListener('dblclick', e => { if (e.target.tagName === 'CANVAS') whole(); });
  // ECharts keeps every wheel to itself, also one without the key: that one is the page's; over the
  // axes, too, key and wheel are not the browser's own zoom
  for (const kind of ['wheel', 'mousewheel']) element.addEventListener(kind, e => {
    if (e.ctrlKey) e.preventDefault(); else e.stopPropagation();
  }, {capture: true, passive: false});

  const tools = document.createElement('div');
  tools.className = 'chart-tools';
  const name = element.getAttribute('aria-label') ?? 'chart';
  const hint = document.createElement('span');
  hint.textContent = 'Ctrl + wheel zooms, double click shows all';
  tools.append(hint);
  const acts = [['+', 'Zoom in', () => nearer(0.6)], ['−', 'Zoom out', () => nearer(1 / 0.6)],
                ['whole', 'Show all', whole]];
  for (const [text, what, act] of acts) {
    const button = document.createElement('button');
    button.type = 'button';
    button.textContent = text;
    button.title = `${what} (arrow keys move what is zoomed)`;
    button.setAttribute('aria-label', `${what}: ${name}`);
    button.addEventListener('click', act);
    tools.append(button);
  }
  const keys = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1]};
  tools.addEventListener('keydown', e => {
    if (!keys[e.key] || e.ctrlKey || e.altKey || e.metaKey || !zoomed) return;
    e.preventDefault();
    moved(...keys[e.key]);
  });
  for (const kind of ['dblclick', 'mousedown', 'touchstart'])
    tools.addEventListener(kind, e => e.stopPropagation(), {passive: true});
  element.append(tools);
  // a chart that nobody points at is drawn without what zooms it, which costs a millisecond
  const arm = () => {
    if (armed) return;
    const {xAxis, yAxis} = chart.getOption() ?? {};
    if (!xAxis?.length) return;
    armed = true;
    chart.setOption({xAxis, yAxis});
  };
  for (const kind of ['pointerenter', 'pointerdown', 'wheel', 'focusin'])
    element.addEventListener(kind, arm, {capture: true, passive: true});
};
