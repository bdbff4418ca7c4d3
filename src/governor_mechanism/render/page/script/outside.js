// The view from outside: the plane of the elevation turned with its spindle about the axis, and seen from the side of the machine.
// What turns is projected and sorted by depth; bodies of revolution and the frame stay as they are in the elevation.

/** Distance of the eye from the axis, relative to the reach of the machine: far, for a slight perspective. */
const EYE_DISTANCE_RATIO = 12;
/** Number of corners that stand for the rim of a pin. */
const PIN_CORNERS = 16;
/** Area of an outline relative to that of its hull below which the outline has dents. */
const DENTED_RATIO = 0.9;
/** Distance from the centre of a pin, relative to its radius, within which the outline of a plate passes that the pin holds. */
const PIN_REACH_RATIO = 2.4;
/** Distance from the centre of a ball, relative to its radius, at which a bar that ends in it is cut off: just inside. */
const SUNK_RATIO = 0.9;
/** Largest turn of the spindle between frames of 1/60 s, in rad, that the eye follows: 24 degrees, 4 turns in a second. */
const FASTEST_TURN = (24 * Math.PI) / 180;
const FRAMES_PER_SECOND = 60;

/** Reach (units) of the machine to both sides of the axis. */
function reachOf(view) {
  return Math.max(view.axis, view.width - view.axis);
}

/** Projection at a spindle angle: from a point of the plane and its distance in front of it to the picture, with depth. */
function makeProjection(view, angle) {
  const c = Math.cos(angle);
  const s = -Math.sin(angle); // anticlockwise from above: what was at the right passes behind first
  const eye = EYE_DISTANCE_RATIO * reachOf(view);
  const middle = view.height / 2;
  return (x, y, thickness) => {
    const radius = x - view.axis;
    const depth = radius * s + thickness * c;
    const size = 1 / (1 - depth / eye);
    return { x: view.axis + (radius * c - thickness * s) * size, y: middle + (y - middle) * size, depth, size };
  };
}

/** Points of the rim of a circle. */
function rimPoints(x, y, radius) {
  const points = [];
  for (let k = 0; k < PIN_CORNERS; k += 1) {
    const angle = (2 * Math.PI * k) / PIN_CORNERS;
    points.push(x + radius * Math.cos(angle), y + radius * Math.sin(angle));
  }
  return points;
}

/** Points of the two faces of a plate, projected: the outline of the plate is their hull. */
function projectFaces(points, thickness, project) {
  const faces = [];
  for (const side of [-thickness, thickness]) {
    for (let k = 0; k < points.length; k += 2) {
      const { x, y } = project(points[k], points[k + 1], side);
      faces.push(x, y);
    }
  }
  return faces;
}

/** Mean depth of points. */
function meanDepth(points, project) {
  let sum = 0;
  for (let k = 0; k < points.length; k += 2) sum += project(points[k], points[k + 1], 0).depth;
  return points.length ? (2 * sum) / points.length : 0;
}

/** Points of a bar that ends in the middle of a ball, cut off at the surface of the ball: what is inside cannot be seen. */
function cutAtSpheres(points, spheres) {
  for (const { x, y, radius } of spheres) {
    const [middleX, middleY] = meanPoint(points);
    const distance = Math.hypot(middleX - x, middleY - y);
    if (distance < radius) continue;
    const [ux, uy] = [(middleX - x) / distance, (middleY - y) / distance];
    points = points.slice();
    for (let k = 0; k < points.length; k += 2) {
      const [dx, dy] = [points[k] - x, points[k + 1] - y];
      if (Math.hypot(dx, dy) > radius) continue;
      const missing = SUNK_RATIO * radius - (dx * ux + dy * uy);
      points[k] += missing * ux;
      points[k + 1] += missing * uy;
    }
  }
  return points;
}

/** Middle of points. */
function meanPoint(points) {
  let [x, y] = [0, 0];
  for (let k = 0; k < points.length; k += 2) {
    x += points[k];
    y += points[k + 1];
  }
  return [(2 * x) / points.length, (2 * y) / points.length];
}

/** Area within a closed outline. */
function areaOf(points) {
  let twice = 0;
  for (let k = 0; k < points.length; k += 2) {
    const next = (k + 2) % points.length;
    twice += points[k] * points[next + 1] - points[next] * points[k + 1];
  }
  return Math.abs(twice) / 2;
}

/** Whether an outline has dents, so that its hull would show what is not there. */
function isDented(points) {
  return areaOf(points) < DENTED_RATIO * areaOf(convexHull(points));
}

/** A shape that turns: its element, and `update`, which returns the depth of its nearest side. */
function makeTurningShape(shape, parent) {
  const isSphere = isBall(shape);
  const isPin = shape.kind === "circle" && !isSphere;
  const isThin = shape.kind === "polygon" && !shape.seenAs && isDented(shape.points);
  const element = makeShapeElement(isPin ? { ...shape, kind: "polygon" } : shape, parent);
  if (isSphere) element.classList.add("sphere");
  const update = (place, poses, project, spheres) => {
    if (shape.hidden) element.style.display = isHidden(shape, place.k) ? "none" : "";
    const points = placedPoints(shape, poses, place);
    const radius = smoothValue(shape.radius, place);
    if (isSphere) return moveSphere(element, project(points[0], points[1], 0), radius);
    if (shape.kind === "lines") {
      const projected = projectFaces(points, 0, project).slice(0, points.length);
      element.setAttribute("d", polylinePath(projected, shape.lengths));
      return meanDepth(points, project);
    }
    const outline = isPin ? rimPoints(points[0], points[1], radius) : isThin ? points : cutAtSpheres(points, spheres);
    const faces = projectFaces(outline, isThin ? 0 : shape.turns, project);
    element.setAttribute("d", polygonPath(isThin ? faces.slice(0, outline.length) : convexHull(faces)));
    return meanDepth(outline, project) + (isThin ? 0 : shape.turns);
  };
  return { element, update, shape, isPin };
}

/** Whether a shape is a ball, which looks round from all sides. */
function isBall(shape) {
  return shape.kind === "circle" && shape.role === "ball";
}

/** Centre and radius of a ball at a place in time. */
function sphereAt(shape, place, poses) {
  const [x, y] = placedPoints(shape, poses, place);
  return { x, y, radius: smoothValue(shape.radius, place) };
}

/** Whether a pin is inside a ball, where it cannot be seen from outside. */
function isInside(shape, spheres, place, poses) {
  if (shape.kind !== "circle" || isBall(shape)) return false;
  const pin = sphereAt(shape, place, poses);
  return spheres.some(({ x, y, radius }) => Math.hypot(pin.x - x, pin.y - y) + pin.radius < radius);
}

/** Move a ball to its projection, and return the depth of its nearest side. */
function moveSphere(element, { x, y, depth, size }, radius) {
  element.setAttribute("cx", x.toFixed(1));
  element.setAttribute("cy", y.toFixed(1));
  element.setAttribute("r", (radius * size).toFixed(1));
  return depth + radius;
}

/** Indices of the plates that each pin holds: a pin is as long as they are thick together, so it is seen in front of them. */
function findPinnedPlates(drawn, place, poses) {
  const outlines = drawn.map((one) => (one.shape && !one.isPin && one.shape.kind === "polygon" ? placedPoints(one.shape, poses, place) : []));
  return drawn.map((one) => {
    if (!one.isPin) return [];
    const [x, y] = placedPoints(one.shape, poses, place);
    const reach = PIN_REACH_RATIO * smoothValue(one.shape.radius, place);
    const isNear = (points) => points.some((value, k) => k % 2 === 0 && Math.hypot(value - x, points[k + 1] - y) < reach);
    return outlines.flatMap((points, index) => (isNear(points) ? [index] : []));
  });
}

/** A shape that looks the same from all sides; it is at the axis. */
function makeRoundShape(shape, parent) {
  const element = makeShapeElement(shape, parent);
  const move = makeMover(shape, element);
  const update = (place, poses) => {
    move(place, poses);
    return 0;
  };
  return { element, update };
}

/** The polylines of a shape as shapes of their own, so that each has its own depth. */
function splitLines(shape) {
  if (shape.kind !== "lines" || shape.turns === undefined || shape.lengths.length < 2) return [shape];
  let start = 0;
  return shape.lengths.map((length) => {
    const part = (points) => points.slice(start, start + 2 * length);
    const modes = shape.modes.map((mode) => ({ ...mode, displacements: part(mode.displacements) }));
    const one = { ...shape, points: part(shape.points), lengths: [length], modes };
    start += 2 * length;
    return one;
  });
}

/** Whole number by which a spindle speed (rad in a second of film) is divided so that the eye can follow. */
function spindleSlowing(speed) {
  return Math.max(Math.ceil(speed / FRAMES_PER_SECOND / FASTEST_TURN - 1e-9), 1);
}

/** Light on spheres, from the upper left. */
function addSphereLight(picture) {
  const attributes = { id: "sphere-light", cx: "0.36", cy: "0.32", r: "0.72" };
  const gradient = makeElement("radialGradient", attributes, makeElement("defs", {}, picture));
  makeElement("stop", { offset: "0", class: "light-centre" }, gradient);
  makeElement("stop", { offset: "0.45", class: "light-body" }, gradient);
  makeElement("stop", { offset: "1", class: "light-edge" }, gradient);
}

/** The view from outside: its picture, and `update(place, poses, slowing)`. */
function makeOutside(view, data) {
  const reach = reachOf(view) * (1 + 1 / EYE_DISTANCE_RATIO);
  const margin = 2 * view.stroke;
  const box = [view.axis - reach - margin, -margin, 2 * (reach + margin), view.height + 2 * margin];
  const picture = makePicture(view, box, "view from outside: the spindle turns");
  addSphereLight(picture);
  const layer = makeElement("g", {}, picture);
  const firstPlace = { k: 0, fraction: 0 };
  const firstPoses = view.tracks.map((track) => poseAt(track, firstPlace));
  const balls = view.shapes.filter((shape) => isBall(shape) && shape.turns !== undefined);
  const spheresAt = (place, poses) => balls.map((shape) => sphereAt(shape, place, poses));
  const firstSpheres = spheresAt(firstPlace, firstPoses);
  const shapes = view.shapes
    .map((shape) => (shape.seenAs ? { ...shape, role: shape.seenAs } : shape))
    .filter((shape) => !shape.isInPlaneOnly && !isInside(shape, firstSpheres, firstPlace, firstPoses))
    .flatMap(splitLines);
  const drawn = shapes.map((shape) => (shape.turns === undefined ? makeRoundShape : makeTurningShape)(shape, layer));
  const angles = decodeNumbers(view.spindle, data.angleQuantum);
  const pinned = findPinnedPlates(drawn, firstPlace, firstPoses);
  let order = drawn.map((_, index) => index);
  const update = (place, poses, slowing) => {
    const project = makeProjection(view, smoothValue(angles, place) / slowing);
    const spheres = spheresAt(place, poses);
    const ownDepths = drawn.map((one) => one.update(place, poses, project, spheres));
    const depths = ownDepths.map((depth, index) => Math.max(depth, ...pinned[index].map((plate) => ownDepths[plate] + 1)));
    const sorted = depths.map((_, index) => index).sort((a, b) => depths[a] - depths[b] || a - b);
    if (sorted.some((index, position) => index !== order[position])) {
      layer.append(...sorted.map((index) => drawn[index].element));
      order = sorted;
    }
  };
  return { picture, update, fastestSpeed: fastestRate(angles, data.times) };
}

/** Largest rate (1/s) of a channel. */
function fastestRate(values, times) {
  if (typeof values === "number" || times.count < 2) return 0;
  const step = (times.stop - times.start) / (times.count - 1);
  let largest = 0;
  for (let k = 1; k < values.length; k += 1) largest = Math.max(largest, Math.abs(values[k] - values[k - 1]) / step);
  return largest;
}
