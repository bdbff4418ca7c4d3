// Numbers over time, as `packing.py` writes them, and their values between samples.

/** How often differences are taken, and bits in a group, by the first letter of a text. */
const FORMATS = { a: [1, 7], b: [2, 7], c: [1, 3], d: [2, 3] };

/** Integers of a text. */
function decodeIntegers(text) {
  const [order, bits] = FORMATS[text[0]];
  const bytes = Array.from(atob(text.slice(1)), (character) => character.charCodeAt(0));
  let integers = joinGroups(bits === 7 ? bytes : bytes.flatMap((byte) => [byte & 0xf, byte >> 4]), bits);
  for (let k = 0; k < order; k += 1) integers = addUp(integers);
  return integers;
}

/** Integers of groups of bits, the lowest first; the bit above tells that another group follows, and the lowest of all is the sign. */
function joinGroups(groups, bits) {
  const follows = 2 ** bits;
  const integers = [];
  let code = 0;
  let factor = 1;
  for (const group of groups) {
    code += (group % follows) * factor;
    factor *= follows;
    if (group < follows) {
      integers.push(code % 2 ? -(code + 1) / 2 : code / 2);
      code = 0;
      factor = 1;
    }
  }
  return integers;
}

/** Sums of the first one, two, three, ... of integers. */
function addUp(integers) {
  let sum = 0;
  return integers.map((integer) => (sum += integer));
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
