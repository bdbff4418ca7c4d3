// What a screen reader hears of an answer: the readings at its end, once a hand rests.

/** A region that is heard and not seen: `show(state)`. */
function makeVoice() {
  const node = makeNode("p", "unseen");
  node.setAttribute("role", "status");
  node.setAttribute("aria-label", "readings");
  const show = (state) => {
    if (!state.readings || !state.facts || state.problem) return;
    node.textContent = state.readings.map((one) => `${one.words} ${one.text}`).join(", ");
  };
  return { node, show };
}
