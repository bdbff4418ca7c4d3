// The live page: sliders, typed values and grips change the scene; its server answers with the run.

const SLIDER_STEPS = 400;
/** Radius of a grip, in strokes. */
const GRIP_RADIUS = 9;
/** Part of the larger side of the picture by which an arrow key moves a grip. */
const KEY_SHARE = 1 / 200;
/** Pause (ms) before a lost connection is tried again. */
const RETRY_PAUSE = 1000;
const SAVED = { toml: "scene file", gif: "film", html: "page", csv: "table" };

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
  row.show = (value) => {
    if (value < Number(slider.min)) slider.min = value;
    if (value > Number(slider.max)) slider.max = value;
    slider.value = value;
    slider.setAttribute("aria-valuetext", `${value} ${quantity.unit}`);
    if (document.activeElement !== typed) typed.value = value;
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
  typed.addEventListener("change", () => {
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
  const saved = makeNode("p", "saved", "Save as ");
  for (const [ending, words] of Object.entries(SAVED)) {
    const link = makeNode("a", "", words);
    link.href = `saved.${ending}`;
    link.download = "";
    saved.append(link, " ");
  }
  node.append(buttons, status, groups, table, saved);
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

  const show = (state) => {
    const isNew = state.quantities.length !== rows.size || state.quantities.some((one) => rows.get(one.key)?.unit !== one.unit);
    if (isNew) build(state.quantities);
    for (const one of state.quantities) if (!rows.get(one.key).isHeld) rows.get(one.key).show(one.value);
    undo.disabled = !state.canUndo;
    redo.disabled = !state.canRedo;
    reset.disabled = !state.canUndo;
    tell(state.problem || state.accuracy, Boolean(state.problem));
    showReadings(table, state.readings);
  };
  const tell = (text, isProblem) => {
    status.textContent = text;
    status.classList.toggle("is-problem", isProblem);
  };
  return { node, show, tell };
}

/** The readings at the end of the run, with their estimates. */
function showReadings(table, readings) {
  table.replaceChildren();
  const caption = table.createCaption();
  caption.textContent = "At the end of the run";
  for (const one of readings) {
    const row = table.insertRow();
    row.append(makeNode("th", "", one.words), makeNode("td", "", one.text));
    row.lastChild.dataset.reading = one.name;
    row.lastChild.dataset.value = one.value;
    row.append(makeNode("td", "estimate", one.error === null ? "" : `± ${one.error.toPrecision(1)} ${one.unit}`));
  }
}

/** The curve of the equilibria below the drawing, with what it says in words. */
function showEquilibria(equilibria) {
  document.getElementById("equilibria")?.remove();
  if (!equilibria) return;
  const figure = makeNode("figure");
  figure.id = "equilibria";
  // The picture is made by the server from numbers and names that are escaped there.
  figure.innerHTML = equilibria.picture;
  figure.append(makeNode("figcaption", "", equilibria.sentences));
  find("stage").append(figure);
}

/** Names and texts as a list of terms. */
function showFacts(section, facts) {
  const list = section.querySelector("dl");
  if (!list) return;
  list.replaceChildren(
    ...facts.map(([name, text]) => {
      const entry = makeNode("div");
      entry.append(makeNode("dt", "", name), makeNode("dd", "", text));
      return entry;
    }),
  );
}

/** Values of the quantities that follow a grip which has moved by units of the picture. */
function movedValues(grip, values, dx, dy) {
  const moved = grip.effects.map(([key, right, down]) => {
    const step = 2 * Math.hypot(right, down);
    return [key, roundFor(values.get(key) + dx * right + dy * down, step)];
  });
  return Object.fromEntries(moved);
}

/** Grips on a picture. What moves only where the motion starts shows that start while it is held, and lets go at the end. */
function makeGrips(page, onChange) {
  let held = null;
  const drag = (event, isLast) => {
    const [dx, dy] = [event.clientX - held.x, event.clientY - held.y].map((one) => one / held.pixels);
    onChange(movedValues(held.grip, held.values, dx, dy), isLast);
  };
  window.addEventListener("pointermove", (event) => held && drag(event, false));
  for (const kind of ["pointerup", "pointercancel"]) {
    window.addEventListener(kind, (event) => {
      if (!held) return;
      drag(event, true);
      if (held.grip.starts_motion) page.player.play();
      held = null;
    });
  }
  const hold = (grip, picture, values, event) => {
    event.preventDefault();
    event.stopPropagation();
    const pixels = picture.getBoundingClientRect().width / picture.viewBox.baseVal.width;
    held = { grip, values, x: event.clientX, y: event.clientY, pixels };
    if (!grip.starts_motion) return;
    page.player.pause();
    page.player.seek(page.data.times.start);
  };
  const press = (grip, picture, values, event) => {
    const { width, height } = picture.viewBox.baseVal;
    const step = KEY_SHARE * Math.max(width, height);
    const [dx, dy] = { ArrowRight: [step, 0], ArrowLeft: [-step, 0], ArrowUp: [0, -step], ArrowDown: [0, step] }[event.key] || [0, 0];
    if (!dx && !dy) return;
    event.preventDefault();
    event.stopPropagation();
    onChange(movedValues(grip, values, dx, dy), true);
  };
  const show = (state, focused) => {
    const picture = document.querySelector("#stage .plane svg");
    const values = new Map(state.quantities.map((one) => [one.key, one.value]));
    for (const grip of picture ? state.grips : []) {
      const [cx, cy] = grip.place;
      const r = GRIP_RADIUS * Number(picture.style.getPropertyValue("--stroke"));
      const circle = makeElement("circle", { class: "grip", cx, cy, r, tabindex: 0, role: "button" }, picture);
      const words = grip.starts_motion ? `${grip.name}, where the motion starts` : grip.name;
      circle.setAttribute("aria-label", `${words}: drag it, or press an arrow key`);
      circle.dataset.grip = grip.name;
      makeElement("title", {}, circle).textContent = `drag: ${words}`;
      circle.addEventListener("pointerdown", (event) => hold(grip, picture, values, event));
      circle.addEventListener("keydown", (event) => press(grip, picture, values, event));
      if (grip.name === focused) circle.focus();
    }
  };
  return { show };
}

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
