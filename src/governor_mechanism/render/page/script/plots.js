// Plots that follow: a curve over the whole run, a marker at the shown time, and numbers under the pointer.

const PLOT_WIDTH = 1000;
const PLOT_HEIGHT = 300;

/** An HTML element with a class and a text. */
function makeNode(tag, className = "", text = "") {
  const node = document.createElement(tag);
  if (className) node.className = className;
  if (text) node.textContent = text;
  return node;
}

/** A number with a true minus sign. */
function formatNumber(value, decimals) {
  const text = value.toFixed(decimals);
  return (Number(text) === 0 ? text.replace("-", "") : text).replace("-", "−");
}

/** Time in s with two decimals, or with more for a short run. */
function formatTime(time, times) {
  const span = times.stop - times.start;
  const decimals = span >= 1 || span <= 0 ? 2 : Math.min(2 + Math.ceil(-Math.log10(span)), 7);
  return formatNumber(time, decimals);
}

/** The values of a channel, which count from the lower end of the axis, by number. */
function decodeValues(packed, quantum, low) {
  const values = decodeNumbers(packed, quantum);
  return (k) => low + (typeof values === "number" ? values : values[k]);
}

/** A curve with its values decoded: value at a place, or null where it has none. */
function decodeCurve(curve, low) {
  const valueOf = decodeValues(curve.values, curve.quantum, low);
  const at = ({ k, fraction }) => {
    const index = k - curve.first;
    if (index < 0 || index > curve.count - 1) return null;
    const next = Math.min(index + 1, curve.count - 1);
    return valueOf(index) + fraction * (valueOf(next) - valueOf(index));
  };
  return { ...curve, at, valueOf };
}

/** Points of a line in a plot, as texts, from their x and values. */
function linePoints(xs, valueOf, [low, high]) {
  return Array.from(xs, (x, k) => `${x.toFixed(1)} ${((PLOT_HEIGHT * (high - valueOf(k))) / (high - low)).toFixed(1)}`);
}

/** Draw a curve over all samples, or its band with the mean, unless that is another curve. */
function drawCurve(curve, plot, times, picture) {
  const series = `series-${curve.series}`;
  const draw = (kind, points) => makeElement("path", { class: `${kind} ${series}`, d: `M${points.join("L")}` }, picture);
  const { band, quantum } = curve;
  if (!band) {
    const xs = Array.from({ length: curve.count }, (_, k) => (PLOT_WIDTH * (curve.first + k)) / Math.max(times.count - 1, 1));
    draw("curve", linePoints(xs, curve.valueOf, plot.limits));
    return;
  }
  const decode = (x, values) => linePoints(decodeNumbers(x, 1), decodeValues(values, quantum, plot.limits[0]), plot.limits);
  const [low, high] = [band.low, band.high].map((values) => decode(band.x, values));
  draw(band.means === undefined ? "band" : "pale band", [...low, ...high.reverse()]);
  if (typeof band.meanX === "string") draw("curve", decode(band.meanX, band.means));
}

/** Heading of a plot: name, names of several curves, and the value with its unit. */
function makeHeading(plot) {
  const heading = makeNode("figcaption");
  const name = makeNode("span", "name", plot.name);
  if (plot.curves.length > 1) {
    plot.curves.forEach((curve) => name.append(makeNode("span", `key series-${curve.series}`, curve.name)));
  }
  const value = makeNode("output", "value");
  value.setAttribute("aria-live", "off");
  heading.append(name, value);
  return { heading, value };
}

/** A plot: its node, and `update(place)`, `peek(place or null)`; of a reading that is only stated, its name and value. */
function makePlot(plot, data, onSeek) {
  const node = makeNode("figure", `plot series-${plot.curves[0].series}`);
  const { heading, value } = makeHeading(plot);
  const curves = plot.curves.map((curve) => decodeCurve(curve, plot.limits[0]));
  const write = (place) => {
    // The mean over a turn begins half a turn after the start; before, the number is that of the next curve.
    const curve = curves.find((one) => one.at(place) !== null) || curves[0];
    const number = curve.at(place) ?? curve.valueOf(0);
    value.textContent = `${formatNumber(number, plot.decimals)}${plot.unit === "°" ? "°" : ` ${plot.unit}`}`;
    return number;
  };
  if (plot.isStated) {
    node.classList.add("is-stated");
    node.append(heading);
    return { node, update: write, peek: (place) => place && write(place) };
  }
  const frame = makeNode("div", "frame");
  frame.append(makeCurves(plot, curves, data.times), ...makeTicks(plot));
  const [marker, dot, ghost] = ["marker", "dot", "ghost"].map((name) => makeNode("span", name));
  frame.append(ghost, marker, dot);
  node.append(heading, frame);
  const axis = makeNode("div", "time-axis");
  const [first, last] = [data.times.start, data.times.stop].map((time) => Number(time.toPrecision(4)));
  axis.append(...[`${first}`, plot.note || "", `${last} s`].map((words) => makeNode("span", "", words)));
  node.append(axis);
  node.setAttribute("aria-label", `${plot.name} over time`);
  makeSeekable(frame, data.times, onSeek);
  const share = ({ k, fraction }) => (100 * (k + fraction)) / Math.max(data.times.count - 1, 1);
  const update = (place) => {
    const number = write(place);
    // The layers are as large as the frame, and a shift in per cent is in their size; the curve below is not drawn again.
    marker.style.transform = `translateX(${share(place)}%)`;
    dot.style.transform = `translate(${share(place)}%, ${(100 * (plot.limits[1] - number)) / (plot.limits[1] - plot.limits[0])}%)`;
  };
  const peek = (place) => {
    ghost.hidden = !place;
    node.classList.toggle("peeked", Boolean(place));
    if (!place) return;
    ghost.style.transform = `translateX(${share(place)}%)`;
    write(place);
  };
  peek(null);
  return { node, update, peek };
}

/** The curves of a plot, the main one in front, with upright lines at its marks, as where a load changes. */
function makeCurves(plot, curves, times) {
  const picture = makeElement("svg", { viewBox: `0 0 ${PLOT_WIDTH} ${PLOT_HEIGHT}`, preserveAspectRatio: "none", "aria-hidden": "true" });
  for (const tick of plot.ticks) {
    const y = PLOT_HEIGHT * (1 - (tick - plot.limits[0]) / (plot.limits[1] - plot.limits[0]));
    makeElement("path", { class: "grid", d: `M0 ${y.toFixed(1)}H${PLOT_WIDTH}` }, picture);
  }
  for (const mark of plot.marks) {
    const x = (PLOT_WIDTH * (mark - times.start)) / (times.stop - times.start);
    makeElement("path", { class: "mark", d: `M${x.toFixed(1)} 0V${PLOT_HEIGHT}` }, picture);
  }
  for (const curve of [...curves].reverse()) drawCurve(curve, plot, times, picture);
  return picture;
}

/** Labels of the ticks of a plot. */
function makeTicks(plot) {
  return plot.ticks.map((tick) => {
    const label = makeNode("span", "tick", String(tick).replace("-", "−"));
    label.style.top = `${(100 * (plot.limits[1] - tick)) / (plot.limits[1] - plot.limits[0])}%`;
    return label;
  });
}

/** Let a press or a drag on a frame set the time, and a pointer above it show the numbers there. */
function makeSeekable(frame, times, onSeek) {
  const timeOf = (event) => {
    const box = frame.getBoundingClientRect();
    const share = Math.min(Math.max((event.clientX - box.left) / box.width, 0), 1);
    return times.start + share * (times.stop - times.start);
  };
  frame.addEventListener("pointerdown", (event) => {
    if (frame.setPointerCapture) frame.setPointerCapture(event.pointerId);
    onSeek(timeOf(event), "seek");
  });
  frame.addEventListener("pointermove", (event) => onSeek(timeOf(event), event.buttons ? "seek" : "peek"));
  frame.addEventListener("pointerleave", () => onSeek(0, "leave"));
}
