// Grips: points of the drawing that a person drags.

const GRIP_RADIUS = 9;
/** Part of the larger side of the picture by which an arrow key moves a grip. */
const KEY_SHARE = 1 / 200;

/** Values of the quantities that follow a grip which has moved by units of the picture. */
function movedValues(grip, values, dx, dy) {
  const moved = freeEffects(grip).map(([key, right, down]) => {
    const step = 2 * Math.hypot(right, down);
    return [key, roundFor(values.get(key) + dx * right + dy * down, step)];
  });
  return Object.fromEntries(moved);
}

/** Largest distance (units of the picture) between what is shown and a posture of the travel, for the one to be the other. */
const SAME_POSTURE = 60;
/** Steps of a travel's samples to which a start is rounded. */
const START_STEPS = 20;

/** Distance between two poses, units of the picture; a radian counts as a tenth of its larger side. */
function poseDistance(one, other) {
  return Math.hypot(one.x - other.x, one.y - other.y, 2000 * Math.sin((one.angle - other.angle) / 2));
}

/** The track of a travel that the shape of a view follows: that of its body, or of the shape of the same role and order. */
function travelTrackOf(travel, view, index) {
  const shape = view.shapes[index];
  const named = travel.tracks.find((one) => one.name && one.name === view.tracks[shape.track].name);
  const alike = view.shapes.filter((one) => one.role === shape.role);
  const others = travel.shapes.filter(([role]) => role === shape.role);
  const [, track] = others.length === alike.length ? others[alike.indexOf(shape)] : [];
  return named || travel.tracks[track ?? -1] || null;
}

/** What is free, pulled to where the motion starts: `ask()` for its travel, `hear(answer)`; `takeByName` for what has a ring. */
function makePulling(page, send, onChange, motion) {
  let travel = null;
  let isStale = true;
  const stage = find("stage");
  const request = () => {
    isStale = false;
    send({ action: "travel" });
  };
  stage.addEventListener("pointerenter", () => isStale && request());
  const countOf = (track) => Math.max(...[track.x, track.y, track.angle].map((one) => one.length || 1));
  const pull = (track, s) => {
    const [low, high] = travel.values;
    const { key, isClosed, ends } = travel;
    const count = travel.count;
    const valueAt = (one) => roundFor(low + (one * (high - low)) / (count - 1), (high - low) / (count - 1) / START_STEPS);
    let last = null;
    motion.pull();
    page.player.pause();
    page.player.time = page.span.start; // shown as soon as the run from the new start is there
    const move = (one) => {
      last = valueAt(one);
      onChange({ [key]: last }, false);
    };
    const end = () => {
      onChange({ [key]: last }, true);
      motion.letGo();
    };
    return { track, s, count, isClosed, ends, move, end };
  };
  page.takeOtherwise = (k, index, pose) => {
    if (k !== 0 || !travel || locked.has(travel.key)) return null;
    const track = travelTrackOf(travel, page.data.views[0], index);
    if (!track) return null;
    const distances = Array.from({ length: travel.count }, (_, s) => poseDistance(poseAt(track, { k: s, fraction: 0 }), pose));
    const s = distances.indexOf(Math.min(...distances));
    return distances[s] < SAME_POSTURE + Math.abs(distances[Math.max(s - 1, 0)] - distances[s]) ? pull(track, s) : null;
  };
  return {
    /** The state is another one: ask at once if a pointer is there, or if it can only come by a touch. */
    ask: () => {
      isStale = true;
      if (stage.matches(":hover") || matchMedia("(hover: none)").matches) request();
    },
    hear: (answer) => {
      if (!("travel" in answer)) return;
      travel = answer.travel && { ...answer.travel, isClosed: answer.travel.is_closed, tracks: answer.travel.tracks.map((one) => decodeTrack(one, page.data.angleQuantum)) };
      if (travel) travel.count = Math.max(...travel.tracks.map(countOf));
      document.documentElement.dataset.travel = travel?.key || "";
    },
    /** Begin to pull the body of a ring whose start has a value; false if its travel is not known. */
    takeByName: (event, name, value) => {
      const track = travel?.tracks.find((one) => one.name.replaceAll("_", " ") === name);
      if (!track || locked.has(travel.key)) return false;
      const [low, high] = travel.values;
      const s = Math.min(Math.max(((value - low) / (high - low)) * (travel.count - 1), 0), travel.count - 1);
      page.hold(event, 0, name, () => pull(track, s));
      return true;
    },
  };
}

/** Grips on a picture. What moves only where the motion starts shows that start while it is held, and lets go at the end. */
function makeGrips(page, onChange, motion, pulling) {
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
      if (held.grip.start !== null) motion.letGo();
      held = null;
    });
  }
  const hold = (grip, picture, values, event) => {
    event.stopPropagation();
    const [[key]] = grip.effects;
    if (grip.start !== null && pulling.takeByName(event, grip.name, values.get(key))) return;
    event.preventDefault();
    const pixels = picture.getBoundingClientRect().width / picture.viewBox.baseVal.width;
    held = { grip, values, x: event.clientX, y: event.clientY, pixels };
    if (grip.start === null) return;
    motion.pull();
    page.player.pause();
    page.player.seek(page.span.start);
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
    const starts = state.grips.filter((one) => one.start !== null).map((one) => [one.effects[0][0], one.start]);
    const values = new Map([...starts, ...state.quantities.map((one) => [one.key, one.value])]);
    for (const grip of picture ? state.grips : []) {
      const [cx, cy] = grip.place;
      const r = GRIP_RADIUS * Number(picture.style.getPropertyValue("--stroke"));
      const circle = makeElement("circle", { class: "grip", cx, cy, r, tabindex: 0, role: "button" }, picture);
      const words = grip.start !== null ? `${grip.name}, where the motion starts` : grip.name;
      circle.setAttribute("aria-label", `${words}: drag it, or press an arrow key`);
      circle.dataset.grip = grip.name;
      makeElement("title", {}, circle).textContent = `drag: ${words}`;
      circle.addEventListener("pointerdown", (event) => hold(grip, picture, values, event));
      circle.addEventListener("keydown", (event) => press(grip, picture, values, event));
      if (grip.name === focused) circle.focus();
    }
    page.showTaken();
  };
  return { show };
}
