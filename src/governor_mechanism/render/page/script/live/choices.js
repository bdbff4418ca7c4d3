// Words and switches of the scene: its engine, its effects, and every word of its file.

/** A section with a row for each choice; `show(state)` brings them to a state, `onChoice(key, value)` hears of another one. */
function makeChoices(onChoice) {
  const node = makeNode("details");
  node.append(makeNode("summary", "", "effects, engine and kinds"));
  const list = makeNode("div");
  node.append(list);

  const makeSwitch = (choice) => {
    const input = makeNode("input");
    Object.assign(input, { type: "checkbox", checked: choice.value });
    input.addEventListener("change", () => onChoice(choice.key, input.checked));
    return input;
  };
  const makeWords = (choice) => {
    const input = makeNode("select");
    input.append(...choice.options.map((word) => new Option(word.replaceAll("_", " "), word, false, word === choice.value)));
    input.addEventListener("change", () => onChoice(choice.key, input.value));
    return input;
  };
  const show = (state) => {
    const focused = document.activeElement?.dataset?.choice;
    list.replaceChildren(
      ...state.choices.map((choice) => {
        const label = makeNode("label", "choice");
        const input = choice.options.length ? makeWords(choice) : makeSwitch(choice);
        input.dataset.choice = choice.key;
        label.append(input, ` ${choice.words}`);
        return label;
      }),
    );
    if (focused) list.querySelector(`[data-choice="${focused}"]`)?.focus();
  };
  return { node, show };
}
