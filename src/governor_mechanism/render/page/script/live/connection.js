// The connection of the page with its server, which answers each change with the run.

/** Connect the page with its server. */
function startWorkbench(page) {
  const send = (message) => link.send(message);
  // A hand moves faster than the screen: one message for each picture is enough.
  let waiting = null;
  const change = (values, isLast) => {
    const isFirst = waiting === null;
    waiting = { action: "change", values: { ...(waiting?.values || {}), ...values }, isLast, time: resting ?? page.player.time };
    const sendWaiting = () => {
      if (!waiting) return;
      send(waiting);
      waiting = null;
      motion.change();
    };
    if (isLast) sendWaiting();
    else if (isFirst) requestAnimationFrame(sendWaiting);
  };
  const act = (message) => {
    send(message);
    motion.change();
  };
  const panel = makePanel(change, (action) => act({ action }));
  const motion = makeMotion(page, send, {
    hear: (piece) => (piece.refused ? panel.tell(piece.refused, true) : panel.showMotion(piece)),
    showFrames: (frames) => ghost.showFrames(frames),
  });
  const goOn = makeButton("Let it move", () => (motion.isOn ? showWholeRun() : motion.start(page.player.time)));
  goOn.title = "the motion goes on from what is shown, and what you change acts at once";
  panel.buttons.append(goOn);
  const showGoing = () => {
    goOn.textContent = motion.isOn ? "Back to the run" : "Let it move";
  };
  let whole = null; // the last answer with a whole run
  let wasPlaying = false; // before only one moment was shown
  let resting = null; // time at which the clock waits meanwhile, where the run of a moment does not go so far
  const showWholeRun = () => {
    motion.stop();
    showGoing();
    if (whole) receive(whole);
  };
  const letMove = { pull: () => motion.isOn && showWholeRun(), letGo: () => motion.start(page.span.start) };
  const pulling = makePulling(page, send, change, letMove);
  const grips = makeGrips(page, change, letMove, pulling);
  const saving = makeSaving(send);
  const sections = [makeValveSection(send), makeAssemblySection(send)];
  const choices = makeChoices((key, value) => act({ action: "choose", key, value }));
  const ghost = makeGhost(page, () => motion.isOn);
  const address = makeAddress(change);
  const voice = makeVoice();
  panel.node.querySelector("table").before(choices.node);
  panel.node.append(voice.node, ghost.node, saving.node);
  find("more-readings").before(...sections.map((one) => one.node));
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
      act({ action });
    },
    true,
  );
  const receive = (state) => {
    if (state.refused) {
      panel.tell(state.refused, true);
      return;
    }
    if (state.motion) {
      motion.hear(state.motion);
      showGoing();
      return;
    }
    if (!("number" in state)) {
      for (const one of [saving, pulling, ...sections]) one.hear(state);
      return;
    }
    find("stage").classList.toggle("is-past", Boolean(state.problem));
    if (motion.isOn) resting = null;
    else if (!state.problem) showState(state);
    if (!motion.isOn) panel.show(state);
    else panel.showQuantities(state);
    ghost.show(state);
    showLocks(state);
    if (state.facts) {
      for (const one of [saving, choices, ...sections, address, voice]) one.show(state);
      whole = state;
      pulling.ask();
      if (!state.problem && motion.isOn) showEquilibria(state.equilibria);
      for (const [id, facts] of Object.entries(state.facts)) showFacts(find(id), facts);
      document.documentElement.dataset.number = state.number;
    }
    document.documentElement.dataset.picture = state.number;
  };
  const showState = (state) => {
    const focused = document.activeElement?.dataset?.grip;
    if (state.moment) {
      // The run of the last values is not yet here: one moment of it is shown, and the clock waits.
      wasPlaying ||= page.player.isPlaying;
      page.player.pause();
      resting ??= page.player.time;
      showPictures(page, decodeData(state.moment));
      showEquilibria(state.equilibria);
      page.player.seek(state.moment.times.start);
    } else {
      page.player.time = resting ?? page.player.time;
      resting = null;
      showRun(page, state.isDecoded ? state.data : decodeData(state.data));
      state.isDecoded = true;
      showEquilibria(state.equilibria);
      if (wasPlaying) page.player.play();
      wasPlaying = false;
    }
    grips.show(state, focused);
  };
  const link = openLink(receive, (sentence) => panel.tell(sentence, true));
}

startWorkbench(startPage());
