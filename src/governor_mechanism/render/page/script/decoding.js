// Numbers over time, as `packing.py` writes them, and their values between samples.

/** Integers of a text: base 64 of groups of 7 bits, differences of neighbours with their sign in the lowest bit. */
function decodeIntegers(text) {
  const bytes = atob(text);
  const integers = [];
  let last = 0;
  let code = 0;
  let factor = 1;
  for (let k = 0; k < bytes.length; k += 1) {
    const byte = bytes.charCodeAt(k);
    code += (byte & 0x7f) * factor;
    factor *= 128;
    if (byte < 0x80) {
      last += code % 2 ? -(code + 1) / 2 : code / 2;
      integers.push(last);
      code = 0;
      factor = 1;
    }
  }
  return integers;
}

/** Values of a channel: an array, or one number if it is constant. */
function decodeNumbers(packed, quantum) {
  if (typeof packed === "number") return packed * quantum;
  return Float64Array.from(decodeIntegers(packed), (integer) => integer * quantum);
}

/** Value of a channel at a place {k, fraction} between sample k and the next one: a cubic through four samples (Catmull and Rom). */
function smoothValue(values, place) {
  if (typeof values === "number") return values;
  const { k, fraction: f } = place;
  const last = values.length - 1;
  const b = values[k];
  if (f === 0 || k >= last) return b;
  const a = values[Math.max(k - 1, 0)];
  const c = values[k + 1];
  const d = values[Math.min(k + 2, last)];
  return b + 0.5 * f * (c - a + f * (2 * a - 5 * b + 4 * c - d + f * (3 * (b - c) + d - a)));
}

/** Value of a channel at a place, linear between samples. */
function linearValue(values, place) {
  if (typeof values === "number") return values;
  const { k, fraction } = place;
  const next = Math.min(k + 1, values.length - 1);
  return values[k] + fraction * (values[next] - values[k]);
}

/** Place of a time (s) among the samples. */
function placeOf(time, times) {
  if (times.count < 2) return { k: 0, fraction: 0 };
  const steps = ((time - times.start) / (times.stop - times.start)) * (times.count - 1);
  const k = Math.min(Math.max(Math.floor(steps + 1e-9), 0), times.count - 1);
  return { k, fraction: k === times.count - 1 ? 0 : Math.min(Math.max(steps - k, 0), 1) };
}
