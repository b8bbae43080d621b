/* ---- numbers: nothing here knows of the page ---- */

/* Data as it was: infinities, and columns from base64. */
function decoded(value) {
  if (Array.isArray(value)) return value.map(decoded);
  if (value === "inf") return Infinity;
  if (value === "-inf") return -Infinity;
  if (value === null || typeof value !== "object") return value;
  const [key] = Object.keys(value);
  if (key === "f4" || key === "u1") {
    const bytes = Uint8Array.from(atob(value[key]), c => c.charCodeAt(0));
    return key === "u1" ? bytes : new Float32Array(bytes.buffer);
  }
  return Object.fromEntries(Object.entries(value).map(([k, v]) => [k, decoded(v)]));
}

/* The largest k of values[from..to) that is at most x, or from. */
function before(values, from, to, x) {
  let low = from, high = to;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (values[middle] <= x) low = middle;
    else high = middle;
  }
  return low;
}

/* Value and slope of the cubic through both ends, at the share x of the interval h. */
function cubic(y0, s0, y1, s1, h, x) {
  const rise = y1 - y0, start = h * s0, end = h * s1;
  const square = 3 * rise - 2 * start - end, cube = start + end - 2 * rise;
  return [y0 + x * (start + x * (square + x * cube)), (start + x * (2 * square + 3 * x * cube)) / h];
}

/* Round numbers from low to high, at most about so many, and two at least: [number, text]. */
function ticksOf(low, high, most) {
  const rough = (high - low) / most, power = 10 ** Math.floor(Math.log10(rough));
  const steps = [0.1, 0.2, 0.5, 1, 2, 5, 10].map(n => n * power);
  const countOf = step => Math.floor(high / step + 1e-9) - Math.ceil(low / step - 1e-9) + 1;
  const coarsest = steps.findIndex(step => step >= rough);
  const step = steps.slice(0, coarsest + 1).findLast(one => countOf(one) >= 2);
  const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  const ticks = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) {
    ticks.push([k * step, fixed(k * step, digits)]);
  }
  return ticks;
}

/* Lengths in m, or in mm where they are small. */
function lengths(largest) {
  return largest < 0.1 ? {unit: "mm", factor: 1000} : {unit: "m", factor: 1};
}

/* Points of a curve from parameter `from` to `to`, so close that straight lines between them are
   within `error` of it. point(t) gives [x, y]; it is smooth between both ends. */
function smoothLine(point, from, to, error) {
  const line = [point(from)];
  const halve = (t0, first, t1, last, depth) => {
    const middle = (t0 + t1) / 2, between = point(middle);
    if (depth > 0 && distanceToLine(between, first, last) > error) {
      halve(t0, first, middle, between, depth - 1);
      halve(middle, between, t1, last, depth - 1);
    } else {
      line.push(between, last);
    }
  };
  const parts = 4; // a curve like an S may cross its chord in the middle
  for (let k = 0; k < parts; k++) {
    const t0 = from + (to - from) * k / parts, t1 = from + (to - from) * (k + 1) / parts;
    halve(t0, line[line.length - 1], t1, point(t1), 10);
  }
  return line;
}

/* How far a point is from the line between two others. */
function distanceToLine([x, y], [x0, y0], [x1, y1]) {
  const dx = x1 - x0, dy = y1 - y0, square = dx * dx + dy * dy;
  const share = square > 0 ? ((x - x0) * dx + (y - y0) * dy) / square : 0;
  const nearest = Math.max(0, Math.min(1, share));
  return Math.hypot(x - x0 - nearest * dx, y - y0 - nearest * dy);
}

/* Ten digits of a number, with a true minus. */
function short(x) {
  return Number(x.toPrecision(10)).toString().replace("-", "−");
}

/* A number with so many digits after its point; never a zero with a minus. */
function fixed(x, digits) {
  const rounded = Math.abs(x) < 0.5 * 10 ** -digits ? 0 : x;
  return rounded.toFixed(digits).replace("-", "−");
}

/* Digits after the point of numbers up to a largest one: all have about as many digits. */
function decimalsOf(largest) {
  if (largest < 10) return 3;
  return largest < 100 ? 2 : 1;
}

function plural(count, word) {
  return count === 1 ? `1 ${word}` : `${count} ${word}s`;
}

const LONGEST_LABEL = 32; // letters

/* A label as it is printed: P(1;∞), long ones cut. */
function shown(label) {
  const text = label.replace(/inf/g, "∞");
  if (text.length <= LONGEST_LABEL) return text;
  return `${text.slice(0, LONGEST_LABEL - 2).replace(/[:;]+$/, "")}…)`;
}

/* How much larger than on a laptop letters and lines are: in a large window, and for a room. */
function lettersFor(width, height, isForRoom) {
  if (isForRoom) return Math.max(1, Math.min(width / 1180, height / 690));
  return Math.max(1, Math.min(width / 1600, height / 900));
}
