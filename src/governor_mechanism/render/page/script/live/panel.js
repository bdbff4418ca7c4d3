// The panel beside the drawing: sliders and typed values of the quantities, and what can be done with the scene as a whole.

const SLIDER_STEPS = 400;

/** A button with a text. */
function makeButton(text, onClick, title = "") {
  const button = makeNode("button", "", text);
  button.type = "button";
  button.title = title;
  button.addEventListener("click", onClick);
  return button;
}

/** Round a value to the digits that a slider or a grip can mean. */
function roundFor(value, step) {
  return step > 0 ? Number(value.toFixed(Math.min(Math.max(0, 1 - Math.floor(Math.log10(step))), 12))) : value;
}

/** The row of a quantity: slider, typed value and unit. */
function makeRow(quantity, onChange) {
  const node = makeNode("div", "quantity");
  const slider = makeNode("input");
  const typed = makeNode("input", "typed");
  const label = makeNode("label", "", quantity.words);
  typed.id = `value of ${quantity.key}`;
  label.htmlFor = typed.id;
  const step = (quantity.high - quantity.low) / SLIDER_STEPS;
  Object.assign(slider, { type: "range", min: quantity.low, max: quantity.high, step: "any" });
  Object.assign(typed, { type: "number", step: "any", inputMode: "decimal" });
  slider.setAttribute("aria-label", `${quantity.group} ${quantity.words}`);
  const row = { node, key: quantity.key, unit: quantity.unit, isHeld: false };
  let isEdited = false; // a number that somebody writes is left as it is until it is sent
  row.show = (value) => {
    if (value < Number(slider.min)) slider.min = value;
    if (value > Number(slider.max)) slider.max = value;
    slider.value = value;
    slider.setAttribute("aria-valuetext", `${value} ${quantity.unit}`);
    if (!isEdited) typed.value = value;
  };
  const move = (isLast) => {
    const value = roundFor(Number(slider.value), step);
    typed.value = value;
    row.isHeld = !isLast;
    onChange({ [quantity.key]: value }, isLast);
  };
  slider.addEventListener("input", () => move(false));
  slider.addEventListener("change", () => move(true));
  slider.addEventListener("keydown", (event) => {
    const sense = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1 }[event.key];
    if (!sense) return;
    event.preventDefault();
    slider.value = Number(slider.value) + sense * step;
    move(true);
  });
  typed.addEventListener("input", () => (isEdited = true));
  typed.addEventListener("blur", () => (isEdited = false));
  typed.addEventListener("change", () => {
    isEdited = false;
    if (typed.value !== "" && Number.isFinite(typed.valueAsNumber)) onChange({ [quantity.key]: typed.valueAsNumber }, true);
  });
  node.append(label, slider, typed, makeNode("span", "unit", quantity.unit));
  row.show(quantity.value);
  return row;
}

/** The panel beside the drawing; `show(state)` brings its rows to a state. */
function makePanel(onChange, onAction) {
  const node = makeNode("aside");
  node.id = "workbench";
  node.setAttribute("aria-label", "what can be changed");
  const undo = makeButton("Undo", () => onAction("undo"), "Ctrl+Z");
  const redo = makeButton("Redo", () => onAction("redo"), "Ctrl+Y");
  const reset = makeButton("As opened", () => onAction("reset"));
  const buttons = makeNode("div", "buttons");
  buttons.append(undo, redo, reset);
  const status = makeNode("p", "status");
  status.setAttribute("role", "status");
  const groups = makeNode("div");
  const table = makeNode("table");
  node.append(buttons, status, groups, table);
  let rows = new Map();

  const build = (quantities) => {
    const open = new Set([...groups.querySelectorAll("details[open]")].map((one) => one.dataset.group));
    groups.replaceChildren();
    rows = new Map(quantities.map((one) => [one.key, makeRow(one, onChange)]));
    for (const group of new Set(quantities.map((one) => one.group))) {
      const details = makeNode("details");
      details.dataset.group = group;
      details.open = open.size ? open.has(group) : groups.childElementCount === 0;
      details.append(makeNode("summary", "", group.replaceAll("_", " ")));
      details.append(...quantities.filter((one) => one.group === group).map((one) => rows.get(one.key).node));
      groups.append(details);
    }
  };

  const showQuantities = (state) => {
    const isNew = state.quantities.length !== rows.size || state.quantities.some((one) => rows.get(one.key)?.unit !== one.unit);
    if (isNew) build(state.quantities);
    for (const one of state.quantities) if (!rows.get(one.key).isHeld) rows.get(one.key).show(one.value);
    undo.disabled = !state.canUndo;
    redo.disabled = !state.canRedo;
    reset.disabled = !state.canUndo;
  };
  const show = (state) => {
    showQuantities(state);
    tell(state.problem || state.accuracy, Boolean(state.problem));
    showReadings(table, state.readings, state.readingsAt);
  };
  const showMotion = (motion) => {
    tell(motion.note || motion.problem || (motion.isOver ? motion.message : motion.accuracy), Boolean(motion.note || motion.problem));
    showReadings(table, motion.readings, `At t = ${Number(motion.stop.toPrecision(4))} s`);
  };
  const tell = (text, isProblem) => {
    status.textContent = text;
    status.classList.toggle("is-problem", isProblem);
  };
  return { node, buttons, show, showQuantities, showMotion, tell };
}
