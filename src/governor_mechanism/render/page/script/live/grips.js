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

/** Grips on a picture. What moves only where the motion starts shows that start while it is held, and lets go at the end. */
function makeGrips(page, onChange, motion) {
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
      if (held.grip.starts_motion) motion.letGo();
      held = null;
    });
  }
  const hold = (grip, picture, values, event) => {
    event.preventDefault();
    event.stopPropagation();
    const pixels = picture.getBoundingClientRect().width / picture.viewBox.baseVal.width;
    held = { grip, values, x: event.clientX, y: event.clientY, pixels };
    if (!grip.starts_motion) return;
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
