// Messages of the page, carried by the notebook in whose output cell it stands.

/** Pause (ms) after which a notebook that does not answer is taken for one without a running kernel. */
const ANSWER_PAUSE = 10000;

/** A link to the session; `onMessage(answer)` hears its answers, and `onLoss(sentence)` that nothing answers. */
function openLink(onMessage, onLoss) {
  const send = (message) => window.parent.postMessage(JSON.stringify(message), "*");
  let hears = false;
  window.addEventListener("message", (event) => {
    if (event.source !== window.parent) return;
    hears = true;
    onMessage(JSON.parse(event.data));
  });
  send({ action: "hello" });
  setTimeout(() => hears || onLoss("No kernel answers: run the cell again; what is shown is the last state."), ANSWER_PAUSE);
  return { send };
}
