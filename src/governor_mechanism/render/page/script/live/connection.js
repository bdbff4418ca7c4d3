// The connection of the page with its server, which answers each change with the run.

/** Pause (ms) before a lost connection is tried again. */
const RETRY_PAUSE = 1000;

/** Connect the page with its server. */
function startWorkbench(page) {
  let connection = null;
  const send = (message) => {
    if (connection?.readyState === WebSocket.OPEN) connection.send(JSON.stringify(message));
  };
  // A hand moves faster than the screen: one message for each picture is enough.
  let waiting = null;
  const change = (values, isLast) => {
    const isFirst = waiting === null;
    waiting = { action: "change", values: { ...(waiting?.values || {}), ...values }, isLast };
    if (isLast) {
      send(waiting);
      waiting = null;
    } else if (isFirst) {
      requestAnimationFrame(() => {
        if (waiting) send(waiting);
        waiting = null;
      });
    }
  };
  const panel = makePanel(change, (action) => send({ action }));
  const grips = makeGrips(page, change);
  document.querySelector("main").classList.add("is-live");
  find("controls").after(panel.node);
  document.addEventListener(
    "keydown",
    (event) => {
      if (!(event.ctrlKey || event.metaKey) || event.altKey) return;
      const key = event.key.toLowerCase();
      const action = key === "y" || (key === "z" && event.shiftKey) ? "redo" : key === "z" ? "undo" : "";
      if (!action) return;
      event.preventDefault();
      send({ action });
    },
    true,
  );
  const receive = (state) => {
    if (state.refused) {
      panel.tell(state.refused, true);
      return;
    }
    const focused = document.activeElement?.dataset?.grip;
    find("stage").classList.toggle("is-past", Boolean(state.problem));
    if (!state.problem) {
      showRun(page, decodeData(state.data));
      showEquilibria(state.equilibria);
      grips.show(state, focused);
    }
    panel.show(state);
    for (const [id, facts] of Object.entries(state.facts)) showFacts(find(id), facts);
    document.documentElement.dataset.number = state.number;
  };
  const connect = () => {
    connection = new WebSocket(new URL("live", location.href.replace(/^http/, "ws")));
    connection.addEventListener("message", (event) => receive(JSON.parse(event.data)));
    connection.addEventListener("close", () => {
      panel.tell("The connection to governor-mechanism is lost; what is shown is the last state.", true);
      setTimeout(connect, RETRY_PAUSE);
    });
  };
  connect();
}

startWorkbench(startPage());
