// Forces as arrows, all to one scale.

const ARROW_HEAD = 130;
const MIN_ARROW = 12;

/** Path of an arrow from a point: shaft and head. */
function arrowPath(x, y, dx, dy) {
  const length = Math.hypot(dx, dy);
  const head = Math.min(ARROW_HEAD, 0.6 * length);
  const [ux, uy] = [dx / length, dy / length];
  const [bx, by] = [x + dx - head * ux, y + dy - head * uy];
  const corner = (side) => `${(bx - side * 0.38 * head * uy).toFixed(1)} ${(by + side * 0.38 * head * ux).toFixed(1)}`;
  const tip = `${(x + dx).toFixed(1)} ${(y + dy).toFixed(1)}`;
  return { shaft: `M${x.toFixed(1)} ${y.toFixed(1)}L${bx.toFixed(1)} ${by.toFixed(1)}`, head: `M${tip}L${corner(1)}L${corner(-1)}Z` };
}

/** Arrows with their channels decoded. */
function decodeArrows(forces) {
  const decode = (packed) => decodeNumbers(packed, forces.quantum * forces.unitsPerNewton);
  return forces.arrows.map((arrow) => ({ ...arrow, x: decode(arrow.x), y: decode(arrow.y) }));
}

/** Start x, y and components dx, dy of an arrow at a place in time. */
function arrowAt(arrow, place, poses) {
  const pose = poses[arrow.track];
  const [px, py] = arrow.point;
  const [c, s] = [Math.cos(pose.angle), Math.sin(pose.angle)];
  const [x, y] = [pose.x + c * px - s * py, pose.y + s * px + c * py];
  return { x, y, dx: smoothValue(arrow.x, place), dy: smoothValue(arrow.y, place) };
}

/** Box around a picture and the ends of all arrows at all samples: left, top, width, height. */
function boxWithArrows(view, arrows, box, count) {
  let [left, top, right, bottom] = [box[0], box[1], box[0] + box[2], box[1] + box[3]];
  for (let k = 0; k < count; k += 1) {
    const place = { k, fraction: 0 };
    const poses = view.tracks.map((track) => poseAt(track, place));
    for (const arrow of arrows) {
      const { x, y, dx, dy } = arrowAt(arrow, place, poses);
      left = Math.min(left, x + dx);
      right = Math.max(right, x + dx);
      top = Math.min(top, y + dy);
      bottom = Math.max(bottom, y + dy);
    }
  }
  return [left, top, right - left, bottom - top];
}

/** One arrow: `update(place, poses)`. */
function makeArrow(arrow, parent) {
  const group = makeElement("g", { class: `force-${arrow.kind}` }, parent);
  group.dataset.name = arrow.name;
  makeElement("title", {}, group).textContent = arrow.name;
  const shaft = makeElement("path", { class: "shaft" }, group);
  const head = makeElement("path", { class: "head" }, group);
  return (place, poses) => {
    const { x, y, dx, dy } = arrowAt(arrow, place, poses);
    const isShown = Math.hypot(dx, dy) > MIN_ARROW;
    group.style.display = isShown ? "" : "none";
    if (!isShown) return;
    const path = arrowPath(x, y, dx, dy);
    shaft.setAttribute("d", path.shaft);
    head.setAttribute("d", path.head);
  };
}

/** The forces of a view: `update(place, poses)`, and `show(isShown)`, which makes room for them. */
function makeForces(view, picture, box, count) {
  const layer = makeElement("g", { class: "forces" }, picture);
  const decoded = decodeArrows(view.forces);
  const arrows = decoded.map((arrow) => makeArrow(arrow, layer));
  const largerBox = boxWithArrows(view, decoded, box, count);
  const show = (isShown) => {
    picture.setAttribute("viewBox", (isShown ? largerBox : box).join(" "));
    setAspect(picture);
  };
  const kinds = [...new Set(view.forces.arrows.map((arrow) => arrow.kind))];
  return { update: (place, poses) => arrows.forEach((move) => move(place, poses)), show, kinds, largest: view.forces.largest };
}
