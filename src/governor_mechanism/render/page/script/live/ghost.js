// Before and after: a kept state behind the present one, to the same scale.

/** A ghost: `show(state)` hears of a new state, `showFrames(frames)` that the pictures have others, and it stands behind new pictures. */
function makeGhost(page, isMoving) {
  let kept = null; // number, decoded data and frames
  let present = null;
  let frames = null; // those of the shown pictures
  const keep = (state) => {
    kept = { number: state.number, data: state.data, frames: state.frames };
  };
  const node = makeNode("span", "ghost-controls");
  const label = makeNode("label");
  const box = makeNode("input");
  Object.assign(box, { type: "checkbox", checked: true });
  label.append(box, " ghost");
  label.title = "the state as it was opened, or kept, behind the present one";
  const button = makeButton("Keep as ghost", () => {
    if (!present?.data) return;
    keep(present);
    attach();
  });
  box.addEventListener("change", () => attach());
  node.append(button, label);

  /** What maps the kept picture of a view to the present one. */
  const mapOf = (k) => {
    const [[before, left, top], [after, newLeft, newTop]] = [kept.frames[k], frames[k]];
    return `translate(${after * (left - newLeft)} ${after * (newTop - top)}) scale(${after / before})`;
  };
  const attach = () => {
    document.querySelectorAll(".ghost-layer").forEach((one) => one.remove());
    page.pictures = page.pictures.filter((one) => !one.isGhost);
    if (!box.checked || !kept || !present || kept.number === present.number) return;
    const planes = [...document.querySelectorAll("#stage .plane > svg")];
    for (const [k, view] of kept.data.views.entries()) {
      const plane = view.isPlane && frames[k] ? planes.shift() : null;
      if (!plane) continue;
      const layer = makeElement("g", { class: "ghost-layer", transform: mapOf(k), "aria-hidden": "true" });
      const drawing = makeDrawing({ ...view, forces: null }, kept.data);
      layer.append(...drawing.picture.children);
      layer.querySelectorAll("[data-name]").forEach((one) => one.removeAttribute("data-name"));
      layer.querySelectorAll("title").forEach((one) => one.remove());
      plane.prepend(layer);
      const update = () => {
        const place = placeOf(page.player.time, kept.data.times);
        drawing.update(place, view.tracks.map((track) => poseAt(track, place)));
      };
      page.pictures.push({ update, forces: null, isGhost: true });
      update();
    }
  };
  const show = (state) => {
    if (state.problem) return;
    present = state;
    if (!isMoving() || !frames) frames = state.frames;
    if (!kept && state.data) keep(state);
    if (!isMoving()) attach();
  };
  const showFrames = (shown) => {
    frames = shown;
  };
  page.afterPictures = () => isMoving() && attach();
  return { node, show, showFrames };
}
