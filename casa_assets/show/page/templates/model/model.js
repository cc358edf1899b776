"use strict";
// Shows a model in 3D in place of its picture once somebody asks for it; the viewer and the model are loaded then.
let viewerLoads = null;
function loadViewer(address) {
  viewerLoads ??= new Promise((resolve, reject) => {
    const script = document.createElement("script");
    script.src = address;
    script.onload = resolve;
    script.onerror = () => {
      script.remove();
      viewerLoads = null; // the next click tries again
      reject(new Error(`${address} cannot be read`));
    };
    document.head.append(script);
  });
  return viewerLoads;
}
// Resolves to the viewer, see casaViewer.mount; null where the model cannot be shown, which the element then says.
async function openModel(box) {
  const { model, name, viewer, title } = box.dataset;
  const button = box.querySelector(".model-open");
  const label = button?.textContent;
  box.querySelector(".failed")?.remove();
  if (button) {
    button.disabled = true;
    button.textContent = "Loading …";
  }
  try {
    await loadViewer(viewer);
    const bytes = await casaViewer.loadModel(model, name);
    const shown = await casaViewer.mount(box, bytes, { title: title || name });
    box.classList.add("model-shown");
    shown.canvas.focus({ preventScroll: true });
    return shown;
  } catch (error) {
    const told = document.createElement("p");
    told.className = "failed";
    told.setAttribute("role", "alert");
    told.textContent = `The model cannot be shown: ${error.message}.`;
    box.append(told);
    if (button) {
      button.disabled = false;
      button.textContent = label;
    }
    return null;
  }
}
// Shows the model of a button in a dialog, which is empty again once it is closed.
async function popUpModel(button) {
  const dialog = document.createElement("dialog");
  dialog.className = "model-dialog";
  dialog.setAttribute("aria-label", `${button.dataset.title} in 3D`);
  const head = document.createElement("div");
  head.className = "model-head";
  const title = document.createElement("strong");
  title.textContent = button.dataset.title;
  const close = document.createElement("button");
  close.type = "button";
  close.className = "quiet";
  close.textContent = "Close";
  close.addEventListener("click", () => dialog.close());
  head.append(title, close);
  const box = document.createElement("div");
  box.className = "model";
  box.textContent = "Loading …";
  Object.assign(box.dataset, button.dataset);
  dialog.append(head, box);
  document.body.append(dialog);
  let shown = null;
  dialog.addEventListener("close", () => {
    shown?.dispose();
    dialog.remove();
    button.focus();
  });
  dialog.showModal();
  shown = await openModel(box);
  if (shown && !dialog.isConnected) shown.dispose();
}
document.addEventListener("click", (event) => {
  const button = event.target.closest(".model-open, .model-popup");
  if (button?.matches(".model-open")) openModel(button.closest(".model"));
  else if (button) popUpModel(button);
});
// A page whose address ends in #3d begins with its first model.
if (location.hash === "#3d") {
  const first = document.querySelector(".model");
  if (first) openModel(first);
}
