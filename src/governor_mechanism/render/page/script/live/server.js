// Messages of the page, carried by a web socket of the server that sent it.

/** Pause (ms) before a lost connection is tried again. */
const RETRY_PAUSE = 1000;

/** A link to the session; `onMessage(answer)` hears its answers, and `onLoss(sentence)` that nothing answers. */
function openLink(onMessage, onLoss) {
  let socket = null;
  const connect = () => {
    socket = new WebSocket(new URL("live", location.href.replace(/^http/, "ws")));
    socket.addEventListener("message", (event) => onMessage(JSON.parse(event.data)));
    socket.addEventListener("close", () => {
      onLoss("The connection to governor-mechanism is lost; what is shown is the last state.");
      setTimeout(connect, RETRY_PAUSE);
    });
  };
  connect();
  return {
    send: (message) => {
      if (socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify(message));
    },
  };
}
