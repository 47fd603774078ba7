// The cursor over a pull sheet by sheet: the stack below the chart shows what happens there.

// where the pointer stands over a chart, told to a slider's element at most 25 times a second
window.layerjamPointing = (chart, bar, tries = 100) => {
  const drawn = getElement(chart)?.chart;
  if (!drawn) {
    if (tries) setTimeout(() => layerjamPointing(chart, bar, tries - 1), 100);
    return;
  }
  let point = null, timer = null;
  const tell = () => {
    timer = null;
    const slider = getElement(bar);
    if (point && slider?.$el?.checkVisibility?.()) slider.$emit('pointed', point);
  };
  drawn.getZr().on('mousemove', event => {
    const pixel = [event.offsetX, event.offsetY];
    if (!drawn.containPixel({gridIndex: 0}, pixel)) return;
    point = drawn.convertFromPixel({gridIndex: 0}, pixel);
    timer ??= setTimeout(tell, 40);
  });
};

// a slider moved from afar, past Vue
window.layerjamAlong = (bar, value) => {
  const slider = getElement(bar);
  const raw = Vue.toRaw(Vue.toRaw(mounted_app.elements)[bar]);
  if (raw) raw.props['model-value'] = value;
  if (slider) slider.$.props.modelValue = value;
};

// the chart's cursor at a point in the units of its axes, and away again
window.layerjamMark = (chart, x, y) => {
  const drawn = getElement(chart)?.chart;
  const at = drawn?.convertToPixel({gridIndex: 0}, [x, y]);
  if (at) drawn.dispatchAction({type: 'showTip', x: at[0], y: at[1]});
};
window.layerjamUnmark = (chart) => {
  const drawn = getElement(chart)?.chart;
  drawn?.dispatchAction({type: 'hideTip'});
  drawn?.dispatchAction({type: 'updateAxisPointer', currTrigger: 'leave'});
};
