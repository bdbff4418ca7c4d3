// The page: it makes the drawings and the plots, and connects them with the clock and the controls.

/** Arrows that belong to a drawing, on a scale of its own: their role, kind and name. */
const DRAWN_FORCES = [
  ["force", "load", "applied load"],
  ["reaction", "joint", "joint force, own scale"],
];
const FORCE_NAMES = { weight: "weight", centrifugal: "centrifugal force", spring: "spring", damping: "damper", reaction: "joint force" };
const HINT = "Point at a part to see what it is; take it, and it goes along its path.";
/** Width over height of all drawings together from which on the plots stand below them. */
const WIDE_ASPECT = 1.9;
const ARROW_STEP = 1;
const LONG_ARROW_STEP = 10;

/** The element with an id. */
function find(id) {
  return document.getElementById(id);
}

/** Data of a run with all channels of tracks and shapes decoded. */
function decodeData(data) {
  for (const view of data.views) {
    view.tracks = view.tracks.map((track) => decodeTrack(track, data.angleQuantum));
    view.shapes = view.shapes.map((shape) => decodeShape(shape, data.amplitudeQuantum));
  }
  return data;
}

/** A figure with a picture and a caption. */
function addFigure(picture, className, caption) {
  const figure = makeNode("figure", className);
  const words = makeNode("figcaption", "", caption);
  figure.append(picture, words);
  find("stage").append(figure);
  return words;
}

/** Scale bars of a view below its picture. */
function addScales(view, picture, words) {
  for (const scale of view.scales) {
    const bar = makeNode("span", "scale-bar");
    const length = makeNode("i");
    const width = picture.viewBox.baseVal.width;
    const fit = () => {
      const factor = Math.min(picture.clientWidth / width, picture.clientHeight / picture.viewBox.baseVal.height);
      length.style.width = `${(scale.length * factor).toFixed(1)}px`;
    };
    new ResizeObserver(fit).observe(picture);
    bar.append(length, makeNode("span", "", scale.label));
    words.append(bar);
  }
}

/** All pictures of the views, each with `update(place, rate)`. */
function makePictures(data) {
  const pictures = [];
  for (const [k, view] of data.views.entries()) {
    const drawing = view.isPlane ? makeDrawing(view, data) : null;
    const outside = view.spindle === null ? null : makeOutside(view, data);
    const posesAt = (place) => view.tracks.map((track) => poseAt(track, place));
    if (drawing) {
      drawing.picture.dataset.view = k;
      const words = addFigure(drawing.picture, "plane", view.spindle === null ? view.name : "in the turning plane");
      if (view.slowing > 1) words.append(makeNode("span", "", `one turn drawn for ${view.slowing}`));
      addScales(view, drawing.picture, words);
      setAspect(drawing.picture);
    }
    const note = outside ? addFigure(outside.picture, "outside", "from outside") : null;
    if (outside) setAspect(outside.picture);
    const update = (place, rate) => {
      const poses = posesAt(place);
      if (drawing) drawing.update(place, poses);
      if (!outside) return;
      const slowing = spindleSlowing(outside.fastestSpeed * rate);
      outside.update(place, poses, slowing);
      note.textContent = `from outside; ${slowing > 1 ? `one turn of the spindle drawn for ${slowing}` : "the spindle turns as in the run"}`;
    };
    pictures.push({ update, forces: drawing ? drawing.forces : null });
  }
  const aspects = [...document.querySelectorAll("#stage svg")].map(aspectOf);
  find("show").classList.toggle("is-wide", aspects.reduce((sum, aspect) => sum + aspect, 0) > WIDE_ASPECT);
  return pictures;
}

/** Plots beside the drawing and those that wait under a heading; each with `update` and `peek`. */
function makePlots(data, onSeek) {
  const plots = data.plots.map((plot) => {
    const one = makePlot(plot, data, onSeek);
    find(plot.isFirst ? "plots" : "more-plots").append(one.node);
    return one;
  });
  find("more-readings").hidden = data.plots.every((plot) => plot.isFirst);
  return plots;
}

/** Show what a part is, and mark all its shapes. */
function markPart(name, sentence) {
  for (const shape of document.querySelectorAll("#stage [data-name]")) shape.classList.toggle("marked", shape.dataset.name === name);
  for (const button of document.querySelectorAll("#parts button")) button.setAttribute("aria-pressed", String(button.textContent === name));
  find("part-name").textContent = name || HINT;
  find("part-name").classList.toggle("is-hint", !name);
  find("part-sentence").textContent = sentence;
}

/** List the parts of the drawings. */
function listParts() {
  const parts = new Map();
  for (const shape of document.querySelectorAll("#stage [data-sentence]")) {
    if (!parts.has(shape.dataset.name)) parts.set(shape.dataset.name, shape.dataset.sentence);
  }
  for (const [name, sentence] of [...parts].sort(([a], [b]) => a.localeCompare(b))) {
    const button = makeNode("button", "", name);
    button.type = "button";
    button.setAttribute("aria-pressed", "false");
    button.addEventListener("click", () => {
      const isMarked = button.getAttribute("aria-pressed") === "true";
      markPart(isMarked ? "" : name, isMarked ? "" : sentence);
    });
    const item = makeNode("li");
    item.append(button);
    find("parts").append(item);
  }
}

/** Let a pointer name the shapes that it meets. */
function connectParts() {
  const point = (event) => {
    const shape = event.target.closest("[data-name]");
    if (shape) markPart(shape.dataset.name, shape.dataset.sentence || "");
    else if (event.type === "pointerdown") markPart("", "");
  };
  find("stage").addEventListener("pointerover", point);
  find("stage").addEventListener("pointerdown", point);
  find("stage").addEventListener("pointerleave", (event) => {
    if (event.pointerType === "mouse") markPart("", "");
  });
}

/** Arrows of all pictures, and the legend of the forces; the switch is hidden if there are none. */
function listForces(pictures) {
  const groups = pictures.map((picture) => picture.forces).filter(Boolean);
  const drawn = DRAWN_FORCES.filter(([role]) => document.querySelector(`#stage .role-${role}`));
  find("forces-switch").hidden = !groups.length && !drawn.length;
  find("force-legend").replaceChildren();
  const add = (kind, name) => find("force-legend").append(makeNode("span", kind && `key force-${kind}`, name));
  for (const kind of new Set(groups.flatMap((group) => group.kinds))) add(kind, FORCE_NAMES[kind]);
  const largest = Math.max(0, ...groups.map((group) => group.largest));
  if (largest) add("", `longest arrow ${Number(largest.toPrecision(3))} N`);
  for (const [, kind, name] of drawn) add(kind, name);
  // Applied loads belong to the drawing, and forces of joints are requested: they are shown at first.
  return { groups, areShownFirst: drawn.length > 0 || groups.some((group) => group.kinds.includes("reaction")) };
}

/** Show or hide the forces, as their switch stands. */
function showForces(page) {
  find("stage").classList.toggle("with-forces", find("forces").checked);
  page.forces.groups.forEach((group) => group.show(find("forces").checked));
  find("force-legend").hidden = !find("forces").checked;
}

/** The switch between light and dark; at first the page follows the system. */
function connectTheme() {
  const isDark = () =>
    document.documentElement.dataset.theme === "dark" ||
    (!document.documentElement.dataset.theme && matchMedia("(prefers-color-scheme: dark)").matches);
  const write = () => {
    find("theme").setAttribute("aria-pressed", String(isDark()));
    find("theme").textContent = isDark() ? "Light" : "Dark";
  };
  find("theme").addEventListener("click", () => {
    document.documentElement.dataset.theme = isDark() ? "light" : "dark";
    write();
  });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", write);
  write();
}

/** Buttons, sliders and keys of the clock. */
function connectControls(page) {
  const { player } = page;
  const scrub = find("scrub");
  scrub.addEventListener("input", () => {
    const time = Number(scrub.value);
    player.pause();
    player.seek(time);
  });
  find("play").addEventListener("click", player.toggle);
  Object.assign(find("speed"), { min: 0, max: SPEEDS.length - 1, step: 1, value: FIRST_SPEED });
  find("speed").addEventListener("input", () => player.setSpeed(Number(find("speed").value)));
  const move = (steps) => {
    const { start, stop, count } = page.data.times;
    player.pause();
    player.seek(player.time + (count > 1 ? (steps * (stop - start)) / (count - 1) : 0));
  };
  const actions = {
    " ": player.toggle,
    ArrowRight: (event) => move(event.shiftKey ? LONG_ARROW_STEP : ARROW_STEP),
    ArrowLeft: (event) => move(event.shiftKey ? -LONG_ARROW_STEP : -ARROW_STEP),
    Home: () => player.seek(page.span.start),
    End: () => {
      player.pause();
      player.seek(page.span.stop);
    },
    "+": () => player.setSpeed(player.speedIndex + 1),
    "=": () => player.setSpeed(player.speedIndex + 1),
    "-": () => player.setSpeed(player.speedIndex - 1),
    f: () => find("forces").click(),
  };
  // Who goes from button to button by keys presses them by the space bar; after a press of the pointer, it plays.
  let isFocusedByPointer = false;
  document.addEventListener("pointerdown", () => (isFocusedByPointer = true), true);
  document.addEventListener("focusin", (event) => (isFocusedByPointer &&= !event.target.matches(":focus-visible")));
  const isOwnKey = ({ key, target }) =>
    target.closest("input:not(#scrub, [type=checkbox]), select") ||
    (key === " " && !isFocusedByPointer && target.closest("button, summary, input[type=checkbox]"));
  const isForClock = (event) => !event.ctrlKey && !event.metaKey && !event.altKey && !isOwnKey(event) && Boolean(actions[event.key]);
  document.addEventListener("keydown", (event) => {
    if (!isForClock(event)) return;
    event.preventDefault();
    actions[event.key](event);
  });
  // Some browsers press a button when the space bar is let go.
  document.addEventListener("keyup", (event) => event.key === " " && isForClock(event) && event.preventDefault());
}

/** Show what the clock says, in pictures, plots and controls. */
function refresh(page) {
  const { player } = page;
  page.beforeRefresh?.();
  const place = placeOf(player.time, page.data.times);
  page.pictures.forEach((picture) => picture.update(place, player.rate()));
  const placeInPlots = placeOf(player.time, page.plotTimes);
  page.plots.forEach((plot) => plot.node.classList.contains("peeked") || plot.update(placeInPlots));
  const time = formatTime(player.time, page.span);
  find("time").textContent = `${time} s`;
  find("scrub").value = player.time;
  find("scrub").setAttribute("aria-valuetext", `${time} seconds`);
  const rate = describeRate(player.rate());
  find("rate").textContent = rate;
  find("speed").value = player.speedIndex;
  find("speed").setAttribute("aria-valuetext", rate);
  find("play").setAttribute("aria-label", player.isPlaying ? "pause" : "play");
  find("play").classList.toggle("is-playing", player.isPlaying);
}

/** Show the drawings of a run, or of a part of it, in the place of those before. */
function showPictures(page, data) {
  for (const id of ["stage", "parts"]) find(id).replaceChildren();
  page.data = data;
  page.pictures = makePictures(data);
  page.forces = listForces(page.pictures);
  listParts();
  showForces(page);
  page.afterPictures?.();
}

/** Show plots in the place of those before. */
function showPlots(page, data) {
  for (const id of ["plots", "more-plots"]) find(id).replaceChildren();
  page.plotTimes = data.times;
  page.plots = makePlots(data, (time, kind) => {
    const place = kind === "peek" ? placeOf(time, data.times) : null;
    page.plots.forEach((plot) => plot.peek(place));
    find("peeked-time").textContent = place ? `pointer at ${formatTime(time, data.times)} s` : "";
    if (kind === "seek") page.player.seek(time);
    else if (kind === "leave") refresh(page);
  });
}

/** Set the times between which the clock moves; it stays where it is, if that is between them. */
function setSpan(page, start, stop) {
  page.span = { start, stop };
  Object.assign(find("scrub"), { min: start, max: stop, step: "any" });
  page.player.seek(page.player.time);
}

/** Show a run in the place of the one before. */
function showRun(page, data) {
  showPictures(page, data);
  showPlots(page, data);
  setSpan(page, data.times.start, data.times.stop);
}

/** Make the page. */
function startPage() {
  const page = { data: null, span: null, plotTimes: null, pictures: [], plots: [], forces: null, player: null, goesOn: false };
  page.data = decodeData(JSON.parse(find("run-data").textContent));
  page.player = makePlayer(page, () => refresh(page));
  page.player.time = page.data.times.start;
  showRun(page, page.data);
  find("forces").checked = page.forces.areShownFirst;
  find("forces").addEventListener("change", () => showForces(page));
  showForces(page);
  connectParts();
  connectDragging(page);
  connectTheme();
  connectControls(page);
  markPart("", "");
  if (!matchMedia("(prefers-reduced-motion: reduce)").matches) page.player.play();
  return page;
}
