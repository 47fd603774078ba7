// Files dropped anywhere in the window go to the one uploader of the page; a veil says so.

(() => {
  const carries = e => [...(e.dataTransfer?.types ?? [])].includes('Files');
  const uploader = () => {
    const zone = document.querySelector('.files-dropped');
    return zone && getElement(Number(zone.id.slice(1))).$refs.qRef;
  };
  // an input that takes a file of its own, such as a log of the vacuum
  const own = e => e.target.closest?.('.q-uploader:not(.files-dropped)');
  const veil = seen =>
    document.querySelector('.files-veil')?.classList.toggle('files-veil-seen', seen);

  addEventListener('dragover', e => {
    if (!carries(e) || own(e)) return veil(false);
    e.preventDefault();
    e.dataTransfer.dropEffect = 'copy';
    veil(true);
  });
  addEventListener('dragleave', e => { if (e.relatedTarget === null) veil(false); });
  addEventListener('dragend', () => veil(false));
  addEventListener('drop', e => {
    veil(false);
    if (!carries(e) || own(e)) return;
    e.preventDefault();
    uploader()?.addFiles(e.dataTransfer.files);
  }, true);
  window.layerjamPick = () => uploader()?.pickFiles();
})();

window.layerjamRejected = (files) => files.slice(0, 60).map(
  x => [x.failedPropValidation, x.file.name.slice(0, 300), x.file.size]
).concat([['count', '', files.length]]);
window.layerjamFailed = (e) => [
  e.files.map(f => f.name.slice(0, 300)).slice(0, 60), e.xhr ? e.xhr.status : 0
];
