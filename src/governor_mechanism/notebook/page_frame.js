// The live page in an output cell: a frame of its own, and what carries messages between it and the kernel.

function render({ model, el }) {
  const frame = document.createElement("iframe");
  frame.title = model.get("title");
  frame.style.cssText = `width: 100%; height: ${model.get("height")}; border: 0`;
  // Its script cannot reach the notebook.
  frame.sandbox = "allow-scripts allow-downloads";
  frame.srcdoc = model.get("page");
  const hear = (event) => {
    if (event.source === frame.contentWindow) model.send(event.data);
  };
  const tell = (text) => frame.contentWindow?.postMessage(text, "*");
  window.addEventListener("message", hear);
  model.on("msg:custom", tell);
  el.append(frame);
  return () => {
    window.removeEventListener("message", hear);
    model.off("msg:custom", tell);
  };
}

export default { render };
