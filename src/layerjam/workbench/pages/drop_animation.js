// The drop in slow motion: draws what was computed and sent, computes nothing but where between two
// samples a moment lies. One object for each stage; `load` takes the time series.
window.layerjamStage = window.layerjamStage || (() => {
  const NS = "http://www.w3.org/2000/svg";
  const REST = {anchor: 16, sheets: 150, overlap: 130, rope: 46, mass: 46};
  const REACH = 120; // pixels of the drawing that the greatest travel takes
  let root, data, chart = null, now = 0, playing = false, last = 0, keep = 0;
  const part = (name) => root.querySelector(`[data-part=${name}]`);
  const round = (value, digits = 3) => Number(value.toPrecision(digits)).toString();

  function at(column, time) {
    const t = data.time;
    let low = 0, high = t.length - 1;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (t[middle] <= time) low = middle; else high = middle;
    }
    const span = t[high] - t[low];
    const share = span > 0 ? Math.min(Math.max((time - t[low]) / span, 0), 1) : 0;
    return column[low] + share * (column[high] - column[low]);
  }

  function shape(name, attributes) {
    const made = document.createElementNS(NS, name);
    for (const key in attributes) made.setAttribute(key, attributes[key]);
    return made;
  }

  function scene() {
    const svg = part("stage");
    svg.replaceChildren();
    const flat = data.horizontal;
    svg.setAttribute("viewBox", flat ? "0 0 420 190" : "0 0 250 420");
    svg.style.maxHeight = flat ? "190px" : "330px";
    const all = shape("g", flat ? {transform: "translate(0,190) rotate(-90)"} : {transform: "translate(30,0)"});
    svg.append(all);
    const put = (name, attributes) => { const s = shape(name, attributes); all.append(s); return s; };
    put("rect", {x: 40, y: 6, width: 110, height: 10, fill: "currentColor", opacity: 0.6});
    const made = {flat, still: [], moving: []};
    if (data.brake) {
      made.enclosure = put("rect", {x: 62, width: 66, rx: 8, fill: "#56B4E9", opacity: 0.18});
      for (let i = 0; i < 7; i++) {
        const moving = i % 2 === 1;
        const sheet = put("rect", {x: 69 + 8 * i, width: 4, fill: moving ? "#E69F00" : "#0072B2"});
        (moving ? made.moving : made.still).push(sheet);
      }
      made.bar = put("rect", {x: 66, width: 58, height: 7, fill: "currentColor", opacity: 0.6});
    }
    made.rope = put("line", {x1: 95, x2: 95, stroke: "#56646f", "stroke-linecap": "round"});
    made.mass = put("rect", {x: 69, width: 52, height: REST.mass, rx: 4, fill: "#56646f"});
    made.words = shape("text", {"text-anchor": "middle", fill: "#fff", "font-size": 13});
    made.words.textContent = data.mass;
    svg.append(made.words);
    if (data.crash !== null) {
      made.bang = shape("text", {"text-anchor": "middle", fill: "#D55E00", "font-size": 15, "font-weight": 700});
      made.bang.textContent = "crash";
      svg.append(made.bang);
    }
    const bar = ruler();
    put("path", {d: `M166 ${zero()} h10 M171 ${zero()} v${bar.pixels} m-5 0 h10`, stroke: "currentColor", fill: "none"});
    const text = shape("text", {fill: "currentColor", "font-size": 12});
    text.textContent = bar.text;
    const middle = zero() + bar.pixels / 2;
    text.setAttribute("x", flat ? middle : 210);
    text.setAttribute("y", flat ? 12 : middle + 4);
    text.setAttribute("text-anchor", flat ? "middle" : "start");
    if (!flat) text.setAttribute("x", 210);
    svg.append(text);
    data.drawn = made;
  }

  const zero = () => REST.anchor + REST.sheets + 20 + REST.rope + REST.mass;

  function ruler() {
    const scale = REACH / data.most;
    for (const power of [-3, -2, -1, 0, 1, 2, 3]) for (const step of [1, 2, 5]) {
      const length = step * 10 ** power;
      if (length * scale >= 30) return {pixels: length * scale, text: `${round(length)} mm`};
    }
    return {pixels: REACH, text: `${round(data.most)} mm`};
  }

  function set(element, values) { for (const key in values) element.setAttribute(key, values[key]); }

  function draw() {
    if (!data) return;
    const d = data.drawn, scale = REACH / data.most;
    const travel = at(data.travel, now) * scale, force = at(data.force, now);
    const slip = data.brake ? at(data.slip, now) * scale : 0;
    const share = data.top > 0 ? Math.max(force / data.top, 0) : 0;
    let end = REST.anchor;
    if (data.brake) {
      for (const s of d.still) set(s, {y: REST.anchor, height: REST.sheets - 10});
      for (const s of d.moving) set(s, {y: REST.anchor + 10 + slip, height: REST.sheets});
      set(d.bar, {y: REST.anchor + 10 + REST.sheets + slip});
      set(d.enclosure, {y: REST.anchor, height: REST.sheets + 14 + slip});
      end = REST.anchor + 17 + REST.sheets + slip;
    }
    const top = zero() - REST.mass + travel;
    set(d.rope, {y1: end, y2: top, "stroke-width": 1.5 + 3 * share, stroke: share > 0.02 ? "#B3261E" : "#56646f", "stroke-opacity": share > 0.02 ? 0.35 + 0.65 * share : 1});
    const crashed = data.crash !== null && now >= data.crash - 1e-9;
    set(d.mass, {y: top, fill: crashed ? "#B3261E" : "#56646f"});
    if (d.bang) {
      set(d.bang, d.flat ? {x: top + REST.mass / 2, y: 60} : {x: 125, y: top + REST.mass + 18});
      d.bang.style.display = crashed ? "" : "none";
    }
    set(d.words, d.flat ? {x: top + REST.mass / 2, y: 99} : {x: 125, y: top + REST.mass / 2 + 5});
    const clock = `${round(now)} ms${crashed ? ", crash" : ""}`;
    part("clock").textContent = clock;
    part("force").textContent = `${round(force)} N`;
    part("travel").textContent = `${round(at(data.travel, now))} mm`;
    part("deceleration").textContent = `${round(at(data.deceleration, now))} m/s²`;
    const bar = part("scrub");
    if (document.activeElement !== bar || playing) bar.value = now / data.last * 1000;
    bar.setAttribute("aria-valuetext", `${clock}, ${round(force)} N`);
    cursor();
  }

  function cursor() {
    const line = document.getElementById(data.cursor);
    if (!line) return;
    const made = chart && chart.chart;
    const x = made ? made.convertToPixel({xAxisIndex: 0}, now) : null;
    // what is zoomed away has no cursor; a tenth down is in the uppermost chart
    const seen = Number.isFinite(x) && made.containPixel({gridIndex: 0}, [x, made.getHeight() / 10]);
    line.style.display = seen ? "block" : "none";
    if (seen) line.style.transform = `translateX(${x}px)`;
  }

  function tick(moment) {
    if (!playing) return;
    now += (moment - last) / data.slow;
    last = moment;
    if (now >= data.last) { now = data.last; stop(); }
    draw();
    if (playing) requestAnimationFrame(tick);
  }

  function label() {
    const button = part("play");
    button.textContent = playing ? "❚❚ Pause" : "▶ Drop";
    button.setAttribute("aria-pressed", playing);
  }

  function stop() { playing = false; label(); }

  function toggle() {
    if (!data) return;
    if (playing) { stop(); return; }
    if (now >= data.last) now = 0;
    playing = true;
    last = performance.now();
    label();
    requestAnimationFrame(tick);
  }

  function play() { if (data) { now = 0; stop(); toggle(); } }

  function load(id, series, element) {
    const found = document.getElementById(id);
    if (!found) return;
    if (found !== root) {
      root = found;
      part("play").addEventListener("click", toggle);
      part("scrub").addEventListener("input", (event) => {
        stop();
        if (data) { now = event.target.value / 1000 * data.last; draw(); }
      });
      window.addEventListener("resize", () => setTimeout(draw, 200));
      if (element?.$el) element.$el.addEventListener("zoomed", () => { if (data) cursor(); });
    }
    const share = data ? now / data.last : 0;
    data = series;
    chart = element;
    root.style.visibility = data ? "visible" : "hidden";
    if (!data) { playing = false; return; }
    now = share * data.last;
    part("slow").textContent = `${round(data.slow)} times slower than life`;
    scene();
    label();
    draw();
    setTimeout(draw, 60); // the chart has laid out its new axes by then
  }

  return {load, play, toggle, time: () => now, playing: () => playing};
});
window.layerjamDrops = window.layerjamDrops || {};
// the stage of an element; the one that was loaded last is the one that is seen
window.layerjamDropAt = (id) => {
  window.layerjamDrop = window.layerjamDrops[id] = window.layerjamDrops[id] || layerjamStage();
  return window.layerjamDrop;
};

