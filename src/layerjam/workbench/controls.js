// What the keyboard and a narrow window need of the controls.

// Home and End on a slider; Quasar's own keys are the arrows and Page up and down
addEventListener('keydown', event => {
  const bar = event.target.closest?.('.q-slider');
  if (!bar || !['Home', 'End'].includes(event.key) || event.ctrlKey || event.altKey) return;
  const slider = getElement(+bar.id.slice(1));
  if (!slider || slider.disable) return;
  event.preventDefault();
  slider.$emit('update:modelValue', event.key === 'Home' ? slider.min : slider.max);
});

// the controls that a narrow window hides at first
window.layerjamFold = (button) => {
  const open = button.closest('.page').toggleAttribute('data-open');
  button.setAttribute('aria-expanded', open);
};

// Quasar's line along the top while something loads says nothing that the page does not say
new MutationObserver((_, watching) => {
  const line = document.getElementById('q-loading-bar');
  if (!line) return;
  line.setAttribute('aria-hidden', 'true');
  watching.disconnect();
}).observe(document.body, {childList: true});
