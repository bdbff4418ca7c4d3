// Positions of the points of shapes at a place in time.

/** A track with its channels decoded. */
function decodeTrack(track, angleQuantum) {
  return {
    name: track.name || "",
    x: decodeNumbers(track.x, 1),
    y: decodeNumbers(track.y, 1),
    angle: decodeNumbers(track.angle, angleQuantum),
  };
}

/** Pose of a track: position, and clockwise angle in rad. */
function poseAt(track, place) {
  return {
    x: smoothValue(track.x, place),
    y: smoothValue(track.y, place),
    angle: smoothValue(track.angle, place),
  };
}

/** A shape with its channels decoded. */
function decodeShape(shape, amplitudeQuantum) {
  const modes = (shape.modes || []).map(([amplitudes, displacements]) => ({
    amplitudes: decodeNumbers(amplitudes, amplitudeQuantum),
    displacements,
  }));
  const radius = shape.radius === undefined ? 0 : decodeNumbers(shape.radius, 1);
  return { ...shape, modes, radius };
}

/** Points x, y, x, y, ... of a shape in its own axes: its outline with its deformation. */
function localPoints(shape, place) {
  if (!shape.modes.length) return shape.points;
  const points = shape.points.slice();
  for (const mode of shape.modes) {
    const amplitude = smoothValue(mode.amplitudes, place);
    for (let k = 0; k < points.length; k += 1) points[k] += amplitude * mode.displacements[k];
  }
  return points;
}

/** Points of a shape in the picture. */
function placedPoints(shape, poses, place) {
  const points = localPoints(shape, place);
  if (shape.track === undefined) return points;
  const { x, y, angle } = poses[shape.track];
  const c = Math.cos(angle);
  const s = Math.sin(angle);
  const placed = new Array(points.length);
  for (let k = 0; k < points.length; k += 2) {
    placed[k] = x + c * points[k] - s * points[k + 1];
    placed[k + 1] = y + s * points[k] + c * points[k + 1];
  }
  return placed;
}

/** Whether a shape is hidden at a sample. */
function isHidden(shape, k) {
  return (shape.hidden || []).some(([first, end]) => first <= k && k < end);
}

/** Path of polylines with given numbers of points. */
function polylinePath(points, lengths) {
  const pieces = [];
  let index = 0;
  for (const length of lengths) {
    for (let k = 0; k < length; k += 1, index += 2) {
      pieces.push(`${k ? "L" : "M"}${points[index].toFixed(1)} ${points[index + 1].toFixed(1)}`);
    }
  }
  return pieces.join("");
}

/** Path of a closed outline. */
function polygonPath(points) {
  return points.length ? `${polylinePath(points, [points.length / 2])}Z` : "";
}

/** Corners of the convex hull of points x, y, x, y, ... (Andrew's monotone chain). */
function convexHull(points) {
  const order = [];
  for (let k = 0; k < points.length; k += 2) order.push([points[k], points[k + 1]]);
  order.sort((a, b) => a[0] - b[0] || a[1] - b[1]);
  const turnsLeft = (a, b, c) => (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) > 1e-9;
  const halfHull = (chain) => {
    const corners = [];
    for (const point of chain) {
      while (corners.length > 1 && !turnsLeft(corners[corners.length - 2], corners[corners.length - 1], point)) corners.pop();
      corners.push(point);
    }
    return corners.slice(0, -1);
  };
  return [...halfHull(order), ...halfHull(order.reverse())].flat();
}
