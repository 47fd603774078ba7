// What every chart of the page gets once it is made.

// the chart of a component that has just come into the page, which is made a moment later; null
// where it went before
window.layerjamChartOf = async (node) => {
  const view = node.component.proxy;
  for (let turn = 0; !view.chart && turn < 500; turn++) await new Promise(r => setTimeout(r, 10));
  return view.chart && !view.chart.isDisposed() ? view.chart : null;
};

window.layerjamPrepareChart = async (node) => {
  const chart = await layerjamChartOf(node);
  if (!chart) return;
  layerjamZoomed(node.el, chart);
  layerjamNames(node.el, chart, node.component.proxy.options);
};
