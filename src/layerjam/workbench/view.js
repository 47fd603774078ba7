// Views in 3-D: drawn only when they look different, and fitted to what they show.

// NiceGUI draws a scene twenty times a second, seen or not: here only when it looks different
window.layerjamStill = (view) => {
  const draw = view.renderer.render.bind(view.renderer);
  const write = view.text_renderer.render.bind(view.text_renderer);
  const size = view.renderer.setSize.bind(view.renderer);
  let seen = '', changed = true;
  const looks = (scene, camera) => [
    ...[...camera.position, ...camera.quaternion].map(x => Number(x).toFixed(4)),
    camera.aspect, view.ground,
    view.renderer.domElement.width, view.renderer.domElement.height,
    ...scene.children.flatMap(c => [c.id, c.children.length, ...c.position, ...c.scale]),
  ].join();
  view.renderer.render = (scene, camera) => {
    const now = view.$el.isConnected && !document.hidden ? looks(scene, camera) : '';
    changed = now !== seen && now !== '';
    seen = now;
    if (changed) draw(scene, camera);
  };
  view.text_renderer.render = (...all) => { if (changed) write(...all); };
  // a canvas that is given a size is empty, be it the same size; one that is not seen has none
  view.renderer.setSize = (...all) => { size(...all); seen = ''; };
  new ResizeObserver(() => {
    if (!view.$el.clientWidth || !view.$el.clientHeight) return;
    view.resize();
    view.fit?.(0);
  }).observe(view.$el);
  view.controls.addEventListener('start', () => { view.fit = null; });
};

// the camera as near as a box [low, high] is seen whole, from a direction; again after each resize
// until the view is turned by hand
window.layerjamFit = (view, low, high, from, time) => {
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const unit = (a) => a.map(x => x / Math.hypot(...a));
  const toward = unit(from), right = unit([-toward[1], toward[0], 0]);
  const up = [toward[1] * right[2] - toward[2] * right[1], toward[2] * right[0] - toward[0] * right[2],
              toward[0] * right[1] - toward[1] * right[0]];
  const middle = low.map((x, i) => (x + high[i]) / 2);
  const corners = [0, 1, 2, 3, 4, 5, 6, 7].map(n => {
    const corner = middle.map((x, i) => ((n >> i) & 1 ? high[i] : low[i]) - x);
    return [dot(corner, right), dot(corner, up), dot(corner, toward)];
  });
  view.fit = (duration) => {
    const {clientWidth: wide, clientHeight: tall} = view.$el;
    if (!wide || !tall) return;
    // room for words at the edges
    const slope = Math.tan(view.camera.fov * Math.PI / 360) / tall;
    const half = [slope * (wide - Math.min(110, 0.25 * wide)), slope * (tall - Math.min(56, 0.2 * tall))];
    let far = 4 * Math.max(...corners.flat()), aim = [0, 0];
    for (let turn = 0; turn < 30; turn++) {
      let share = 0;
      for (const axis of [0, 1]) {
        const seen = corners.map(c => (c[axis] - aim[axis]) / (far - c[2]));
        const [least, most] = [Math.min(...seen), Math.max(...seen)];
        aim[axis] += (most + least) / 2 * far;
        share = Math.max(share, (most - least) / 2 / half[axis]);
      }
      const nearest = Math.max(...corners.map(c => c[2]));
      far = Math.max(nearest + (far - nearest) * share, 1.02 * nearest);
    }
    const target = middle.map((x, i) => x + aim[0] * right[i] + aim[1] * up[i]);
    view.move_camera(...target.map((x, i) => x + far * toward[i]), ...target, 0, 0, 1, duration);
  };
  view.fit(time);
};
