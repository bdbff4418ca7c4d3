// The elevation of a view: every shape is an element, which a track moves as a whole and modes deform.

const SVG = "http://www.w3.org/2000/svg";

/** An SVG element with attributes. */
function makeElement(name, attributes = {}, parent = null) {
  const element = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  if (parent) parent.append(element);
  return element;
}

/** CSS class of a role. */
function classOf(role) {
  return `role-${role.replaceAll(" ", "-")}`;
}

/** The picture of a view, with a margin of the width of a few strokes. */
function makePicture(view, box, label) {
  const picture = makeElement("svg", { viewBox: box.join(" "), role: "img", "aria-label": label });
  picture.style.setProperty("--stroke", view.stroke);
  return picture;
}

/** Width over height of a picture. */
function aspectOf(picture) {
  const { width, height } = picture.viewBox.baseVal;
  return width / height;
}

/** Let the figure of a picture have its proportions. */
function setAspect(picture) {
  picture.parentElement.style.setProperty("--aspect", aspectOf(picture));
}

/** An empty element for a shape, with its name for those who point at it. */
function makeShapeElement(shape, parent) {
  const tag = { circle: "circle", text: "text" }[shape.kind] || "path";
  const element = makeElement(tag, { class: `${classOf(shape.role)} ${shape.kind}` }, parent);
  if (shape.kind === "text") {
    element.textContent = shape.text;
  } else if (shape.name) {
    element.dataset.name = shape.name;
    element.dataset.sentence = shape.sentence || "";
    makeElement("title", {}, element).textContent = shape.name;
  }
  return element;
}

/** What moves the element of a shape to a place in time, given the poses of all tracks. */
function makeMover(shape, element) {
  if (shape.frames) return makeFrameMover(shape, element);
  const outline = (points) => (shape.kind === "lines" ? polylinePath(points, shape.lengths) : polygonPath(points));
  if (shape.kind === "circle" || shape.kind === "text") {
    const [x, y] = shape.kind === "circle" ? ["cx", "cy"] : ["x", "y"];
    element.setAttribute(x, shape.points[0]);
    element.setAttribute(y, shape.points[1]);
  } else {
    element.setAttribute("d", outline(shape.points));
  }
  return (place, poses) => {
    if (shape.hidden) element.style.display = isHidden(shape, place.k) ? "none" : "";
    if (shape.kind === "circle") element.setAttribute("r", Math.max(smoothValue(shape.radius, place), 0).toFixed(1));
    if (shape.modes.length && shape.kind === "circle") {
      const [x, y] = localPoints(shape, place);
      element.setAttribute("cx", x.toFixed(1));
      element.setAttribute("cy", y.toFixed(1));
    } else if (shape.modes.length) {
      element.setAttribute("d", outline(localPoints(shape, place)));
    }
    if (shape.track !== undefined) {
      const { x, y, angle } = poses[shape.track];
      const degrees = (angle * 180) / Math.PI;
      element.setAttribute("transform", `translate(${x.toFixed(1)} ${y.toFixed(1)}) rotate(${degrees.toFixed(3)})`);
    }
  };
}

/** A mover of a shape whose points are written sample by sample. */
function makeFrameMover(shape, element) {
  let shown = -1;
  return (place) => {
    let index = shape.frames.findIndex(([first]) => first > place.k);
    index = (index < 0 ? shape.frames.length : index) - 1;
    if (index === shown) return;
    shown = index;
    const [, lengths, packedX, packedY] = shape.frames[index];
    const count = lengths.reduce((sum, length) => sum + length, 0);
    const [x, y] = [packedX, packedY].map((packed) =>
      typeof packed === "number" ? new Array(count).fill(packed) : decodeIntegers(packed),
    );
    const points = x.flatMap((value, k) => [value, y[k]]);
    element.setAttribute("d", shape.kind === "lines" ? polylinePath(points, lengths) : polygonPath(points));
  };
}

/** A path over the last second of film before a place. */
function makeTrail(trail, data, parent) {
  const element = makeElement("path", { class: `${classOf(trail.role)} lines` }, parent);
  const x = decodeNumbers(trail.x, 1);
  const y = decodeNumbers(trail.y, 1);
  const { start, stop, count } = data.times;
  const length = Math.ceil((count - 1) / (stop - start) / data.slowDown);
  const valueOf = (values, k) => (typeof values === "number" ? values : values[k]);
  return (place) => {
    const points = [];
    for (let k = Math.max(place.k - length, 0); k <= place.k; k += 1) points.push(valueOf(x, k), valueOf(y, k));
    points.push(smoothValue(x, place), smoothValue(y, place));
    element.setAttribute("d", polylinePath(points, [points.length / 2]));
  };
}

/** The elevation of a view: its picture, and `update(place, poses)`. */
function makeDrawing(view, data) {
  const margin = 2 * view.stroke;
  const box = [-margin, -margin, view.width + 2 * margin, view.height + 2 * margin];
  const picture = makePicture(view, box, view.name ? `drawing of the ${view.name}` : "drawing of the mechanism");
  const movers = [];
  const layer = makeElement("g", {}, picture);
  const addTrails = (role) => {
    for (const trail of view.trails) if (trail.role === role) movers.push(makeTrail(trail, data, layer));
  };
  let isTraceDrawn = false;
  for (const [index, shape] of view.shapes.entries()) {
    const isMoving = shape.track !== undefined || shape.modes.length || shape.hidden || shape.frames || typeof shape.radius !== "number";
    if (isMoving && !isTraceDrawn) {
      addTrails("trace");
      isTraceDrawn = true;
    }
    // The order of the shapes is that of the drawing, from back to front.
    const element = makeShapeElement(shape, layer);
    if (shape.track !== undefined && !shape.modes.length && data.times.count > 1) element.dataset.shape = index;
    const mover = makeMover(shape, element);
    mover({ k: 0, fraction: 0 }, view.tracks.map((track) => poseAt(track, { k: 0, fraction: 0 })));
    if (isMoving) movers.push(mover);
  }
  addTrails("tail");
  const forces = view.forces ? makeForces(view, picture, box, data.times.count) : null;
  const update = (place, poses) => {
    for (const mover of movers) mover(place, poses);
    if (forces) forces.update(place, poses);
  };
  return { picture, update, forces };
}
