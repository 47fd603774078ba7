// On a narrow chart names beside the curves would take half of its width: they stand below it.
const NARROW = 480, BESIDE = 60, AT_THE_EDGE = 28;

window.layerjamNames = (element, chart, given) => {
  const set = chart.setOption.bind(chart), whole = {};
  const list = document.createElement('ul');
  list.className = 'chart-names';
  list.hidden = true;
  let below = false;

  // each kind of option as it was last given: a narrow chart that is made wide is as it was
  const keep = (option) => {
    for (const part of ['grid', 'series']) if (option[part]) whole[part] = [].concat(option[part]);
  };
  const marked = (one) => one.labelLine?.show;  // a point with its name on a line
  const named = () => (whole.series ?? []).filter(
    one => one.name && (one.endLabel?.show || marked(one)));
  // known from the observer: to ask the element would lay out the page with every move
  let width = element.clientWidth;
  const tooWide = () => width > 0 && width < NARROW
    && (whole.grid ?? []).some(one => one.right > BESIDE);

  const row = (one) => {
    const item = document.createElement('li'), line = document.createElement('span');
    line.style.borderTop = `3px ${one.lineStyle?.type ?? 'solid'} ${one.color}`;
    const said = one.endLabel?.formatter ?? '{a}';
    item.append(line, String(said).replace('{a}', one.name));
    return item;
  };
  const laid = () => {
    below = tooWide();
    const rows = below ? named().map(row) : [];
    list.replaceChildren(...rows);
    list.hidden = !rows.length;
    // below the height that the chart has in any case
    element.style.boxSizing = 'content-box';
    element.style.paddingBottom = `${list.offsetHeight}px`;
    chart.resize();
  };
  const shown = (option) => !below ? option : {
    ...option,
    ...(option.grid && {grid: whole.grid.map(one => ({...one, right: AT_THE_EDGE}))}),
    ...(option.series && {series: whole.series.map(one => one.endLabel
      ? {...one, endLabel: {...one.endLabel, show: false}} : !marked(one) ? one
      : {...one, label: {...one.label, show: false}, labelLine: {show: false}})}),
  };
  const said = () => !tooWide() ? '' : JSON.stringify(named().map(one =>
    [one.name, one.color, one.lineStyle?.type, one.endLabel?.formatter]));

  let last = '';
  chart.setOption = (option, how) => {
    keep(option);
    const now = said(), other = now !== last, was = below;
    if (other) {
      last = now;
      laid();
    }
    return set(shown(was === below ? option : {...option, ...whole}), how);
  };
  new ResizeObserver(() => {
    width = element.clientWidth;
    if (whole.series && tooWide() !== below) chart.setOption({...whole});
  }).observe(element);
  element.append(list);
  keep(given ?? {});
  if (tooWide()) chart.setOption({...whole});
};
