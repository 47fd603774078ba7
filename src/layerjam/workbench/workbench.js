// What the server cannot do from afar. Loaded once, at the end of the page's body.

// texts, HTML and charts that change with every move, past Vue (live.py)
window.layerjamLive = (texts, contents, charts, spoken, spaces, fields) => {
  const raw = (id) => Vue.toRaw(Vue.toRaw(mounted_app.elements)[id]);
  for (const id in texts) {
    if (raw(id)) raw(id).text = texts[id];
    const node = document.getElementById('c' + id)?.firstChild;
    if (node) node.nodeValue = texts[id];
  }
  for (const id in contents) {
    if (raw(id)) raw(id).props.innerHTML = contents[id];
    const element = document.getElementById('c' + id);
    if (element) element.innerHTML = contents[id];
  }
  for (const id in charts) {
    if (raw(id)) Object.assign(Vue.toRaw(raw(id).props.options), charts[id]);
    getElement(id)?.chart?.setOption(charts[id]);
  }
  for (const id in spoken) {
    if (raw(id)) raw(id).props['aria-label'] = spoken[id];
    document.getElementById('c' + id)?.setAttribute('aria-label', spoken[id]);
  }
  for (const id in fields) {
    if (raw(id)) raw(id).props.value = fields[id];
    const field = getElement(id);
    if (!field) continue;
    // the server knows this text
    field.emitting = false;
    field.inputValue = fields[id];
    field.$nextTick(() => { field.emitting = true; });
  }
  // what is seen in space comes after the frame that shows the charts
  const views = Object.keys(spaces).map(id => [getElement(id), spaces[id]]);
  if (views.length) requestAnimationFrame(() => requestAnimationFrame(() => {
    for (const [view, calls] of views) view?.run_methods?.(calls);
  }));
};

// what is dragged, written into the field beside the slider
window.layerjamSlid = (bar, field, value) => {
  const digits = document.getElementById('c' + bar).dataset.digits;
  getElement(field).inputValue = String(+(+value.toFixed(digits)).toPrecision(6));
  // the slider reports nothing where it comes back to what it takes for its value
  getElement(bar).$.props.modelValue = value;
  Vue.toRaw(Vue.toRaw(mounted_app.elements)[bar]).props['model-value'] = value;
};

// whether the text is in the clipboard: outside https and this machine browsers have none
window.layerjamCopied = async (text) => {
  try {
    await navigator.clipboard.writeText(text);
    return true;
  } catch {
    const field = document.createElement('textarea');
    field.value = text;
    (document.querySelector('dialog[open], .q-dialog') ?? document.body).append(field);
    field.select();
    const copied = document.execCommand('copy');
    field.remove();
    return copied;
  }
};

// only these keys come to the server; in a field that is typed into they are the field's own
addEventListener('keydown', e => {
  const typing = e.target.matches('input:not([type=range]), textarea, select');
  if (e.repeat || typing || !(e.ctrlKey || e.metaKey) || e.key.toLowerCase() !== 'z') return;
  e.preventDefault();
  emitEvent(e.shiftKey ? 'layerjam_redo' : 'layerjam_undo');
});

// a change of tab is a step of the browser's history; Back turns to the tab before
window.layerjamPage = (page) => {
  scrollTo(0, 0);  // how far down one reads is a page's own
  const last = history.state?.layerjam;
  if (last !== page) history[last ? 'pushState' : 'replaceState']({layerjam: page}, '');
};
addEventListener('popstate', e => {
  if (e.state?.layerjam) emitEvent('layerjam_page', e.state.layerjam);
});

// charts and the view in space are 2 MB of script: read while the server loads what it computes with
addEventListener('DOMContentLoaded', () => {
  for (const part of ['nicegui-echart', 'nicegui-scene']) import(part).catch(() => {});
});
