// What moves in a drawing, taken by a hand: it goes along its path, and everything else with it. Over the time of the run that turns the clock.

/** Distance (share of the larger side of the picture) from which on a hand hears that the part does not follow it. */
const OUT_OF_REACH = 0.04;
/** Distance (pixels) that a hand moves before it takes anything. */
const FIRST_MOVE = 3;
/** Step of the search along a path, and by what (units of the picture) a place must be nearer than the last one: they are rounded to one. */
const NEARER = 0.5;
const REFINEMENTS = 24;
/** Samples of a path to either side that are drawn, and points for each. */
const DRAWN_SAMPLES = 60;
const DRAWN_POINTS = 3;

/** A path: where a point in the axes of a track is at sample s of n, which is any number; a closed path begins again at its end. */
function makePath(track, local, count, isClosed = false) {
  const last = count - 1;
  const wrap = (s) => (isClosed ? s - last * Math.floor(s / last) : Math.min(Math.max(s, 0), last));
  const at = (s) => {
    const k = Math.min(Math.floor(wrap(s)), last);
    const { x, y, angle } = poseAt(track, { k, fraction: wrap(s) - k });
    const [c, d] = [Math.cos(angle), Math.sin(angle)];
    return [x + c * local[0] - d * local[1], y + d * local[0] + c * local[1]];
  };
  return { at, wrap, last, isClosed };
}

/** The sample of least distance between two of them, by golden sections. */
function leastBetween(distance, low, high) {
  const ratio = (Math.sqrt(5) - 1) / 2;
  let [a, b] = [low, high];
  for (let k = 0; k < REFINEMENTS; k += 1) {
    const [left, right] = [b - ratio * (b - a), a + ratio * (b - a)];
    if (distance(left) < distance(right)) b = right;
    else a = left;
  }
  return [low, high, (a + b) / 2].reduce((best, one) => (distance(one) < distance(best) ? one : best));
}

/**
 * Go along a path from a sample, ever nearer to a hand, and so without a jump to another stretch of it. It goes on in its sense if it can:
 * at a dead centre, where both senses lead back to the hand, the mechanism is carried through. Result: the sample, the sense, the distance.
 */
function followPath(path, start, sense, hand) {
  const distance = (s) => Math.hypot(...path.at(s).map((one, k) => one - hand[k]));
  const limit = (s) => (path.isClosed ? s : path.wrap(s));
  for (const step of [sense, -sense]) {
    let s = start;
    for (let k = 0; k < path.last && distance(limit(s + step)) < distance(s); k += 1) s = limit(s + step);
    s = leastBetween(distance, s === start ? start : limit(s - step), limit(s + step));
    if (distance(s) < distance(start) - NEARER) return { s, sense: step, distance: distance(s) };
  }
  return { s: start, sense, distance: distance(start) };
}

/** The stretch of a path around a sample, as the data of an SVG path. */
function drawPath(path, s) {
  const points = [];
  for (let k = -DRAWN_SAMPLES * DRAWN_POINTS; k <= DRAWN_SAMPLES * DRAWN_POINTS; k += 1) {
    const sample = s + k / DRAWN_POINTS;
    if (path.isClosed || path.wrap(sample) === sample) points.push(...path.at(sample));
  }
  return polylinePath(points, [points.length / 2]);
}

/** Over the run: a part goes where it is at another time. */
function takeOverTime(page, track) {
  const { start, stop, count } = page.data.times;
  const { k, fraction } = placeOf(page.player.time, page.data.times);
  page.player.pause();
  return {
    track,
    count,
    s: k + fraction,
    move: (s) => page.player.seek(start + (s * (stop - start)) / (count - 1)),
    end: () => {},
    ends: ["What was computed begins here.", "What was computed ends here."],
  };
}

/**
 * Let a hand take what moves. Where `page.takeOtherwise(k, index, pose)` returns something, a shape of view k follows it otherwise than over
 * time; `page.hold(event, k, name, take)` begins with something else than a shape, and `page.showTaken()` belongs behind new pictures.
 */
function connectDragging(page) {
  let held = null;
  const stage = find("stage");
  const pictureOf = (k) => document.querySelector(`#stage .plane > svg[data-view="${k}"]`);
  const handAt = (event, picture) => {
    const place = new DOMPoint(event.clientX, event.clientY).matrixTransform(picture.getScreenCTM().inverse());
    return [place.x, place.y];
  };
  page.hold = (event, k, name, take, sentence = "") => {
    if (held || event.button !== 0) return;
    event.preventDefault();
    held = { k, name, take, sentence, pointerId: event.pointerId, x: event.clientX, y: event.clientY, hand: handAt(event, pictureOf(k)) };
  };
  const take = () => {
    const { width, height } = page.data.views[held.k];
    const taken = held.take();
    const k = Math.floor(taken.s);
    const { x, y, angle } = poseAt(taken.track, { k, fraction: taken.s - k });
    const [c, d] = [Math.cos(angle), Math.sin(angle)];
    const [dx, dy] = [held.hand[0] - x, held.hand[1] - y];
    const path = makePath(taken.track, [c * dx + d * dy, c * dy - d * dx], taken.count, taken.isClosed);
    stage.setPointerCapture(held.pointerId);
    stage.classList.add("is-taking");
    Object.assign(held, taken, { path, line: makeElement("path", { class: "taken-path" }), sense: 1, reach: OUT_OF_REACH * Math.max(width, height) });
  };
  const tell = (distance) => {
    const { path, s, ends } = held;
    const isAtEnd = !path.isClosed && (s <= 0 || s >= path.last);
    const sentence = isAtEnd ? ends[s <= 0 ? 0 : 1] : "It cannot get there: it goes along the marked path.";
    markPart(held.name, distance > held.reach ? sentence : held.sentence);
  };
  const drag = (event) => {
    if (!held || event.pointerId !== held.pointerId) return;
    if (!held.path && Math.hypot(event.clientX - held.x, event.clientY - held.y) < FIRST_MOVE) return;
    if (!held.path) take();
    const found = followPath(held.path, held.s, held.sense, handAt(event, pictureOf(held.k)));
    Object.assign(held, { s: found.s, sense: found.sense });
    held.move(held.path.wrap(held.s));
    held.line.setAttribute("d", drawPath(held.path, held.s));
    page.showTaken();
    tell(found.distance);
  };
  page.showTaken = () => {
    if (held?.line && held.line.parentElement !== pictureOf(held.k)) pictureOf(held.k)?.append(held.line);
  };
  stage.addEventListener("pointerdown", (event) => {
    const element = event.target.closest("#stage .plane [data-shape]");
    if (!element) return;
    const { name = "", sentence = "", shape } = element.dataset;
    const k = Number(element.closest("svg").dataset.view);
    const choose = () => {
      const view = page.data.views[k];
      const { track } = view.shapes[shape];
      const pose = poseAt(view.tracks[track], placeOf(page.player.time, page.data.times));
      return page.takeOtherwise?.(k, Number(shape), pose) || takeOverTime(page, view.tracks[track]);
    };
    page.hold(event, k, name, choose, sentence);
  });
  stage.addEventListener("pointermove", drag);
  for (const kind of ["pointerup", "pointercancel"]) {
    stage.addEventListener(kind, (event) => {
      if (!held || event.pointerId !== held.pointerId) return;
      if (held.path) {
        held.end();
        held.line.remove();
        stage.classList.remove("is-taking");
        markPart(held.name, held.sentence);
      }
      held = null;
    });
  }
}
