// The connection of the page with its server, which answers each change with the run.

/** Connect the page with its server. */
function startWorkbench(page) {
  const send = (message) => link.send(message);
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
  const saving = makeSaving(send);
  const sections = [makeValveSection(send), makeAssemblySection(send)];
  const ghost = makeGhost(page);
  const address = makeAddress(change);
  panel.node.append(ghost.node, ...sections.map((one) => one.node), saving.node);
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
    if (!("number" in state)) {
      for (const one of [saving, ...sections]) one.hear(state);
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
    for (const one of [saving, ...sections, ghost, address]) one.show(state);
    showLocks(state);
    for (const [id, facts] of Object.entries(state.facts)) showFacts(find(id), facts);
    document.documentElement.dataset.number = state.number;
  };
  const link = openLink(receive, (sentence) => panel.tell(sentence, true));
}

startWorkbench(startPage());
