"use strict";
const $ = id => document.getElementById(id);
const data = decoded(JSON.parse($("data").textContent));
const still = matchMedia("(prefers-reduced-motion: reduce)");
const KINDS = ["impact", "chatter accumulates", "detachment"];
const QUANTITIES = {
  theta: {name: "impact phase θ", unit: "deg", branch: "theta_deg", points: "theta_deg"},
  u: {name: "velocity at impact u⁻", unit: "m/s", branch: "u", points: "u"},
  q: {name: "position q at the strobe", unit: "m", branch: "q", points: "q"},
};
const TURN = 360;

/* ---- data ---- */

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

const motions = data.motions;
{
  let row = 0, event = 0, impact = 0, strobe = 0;
  motions.forEach((m, k) => {
    m.number = k;
    m.row = row, m.event = event, m.impact = impact, m.strobe = strobe;
    row += m.rows, event += m.events, impact += m.impacts, strobe += m.strobes;
    m.end = Math.min(m.turns, data.rows.t[m.row + m.rows - 1]);
    m.kin = m.stable === false ? m.label + " unstable" : "";
  });
}
const inDiagram = motions.filter(m => !m.place).sort((a, b) => a.rpm - b.rpm || a.number - b.number);

/* The largest k of values[from..to) that is at most x, or from. */
function before(values, from, to, x) {
  let low = from, high = to;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (values[middle] <= x) low = middle; else high = middle;
  }
  return low;
}

/* Value and slope of the cubic through both ends, at the share x of the interval h. */
function cubic(y0, s0, y1, s1, h, x) {
  const rise = y1 - y0, start = h * s0, end = h * s1;
  const square = 3 * rise - 2 * start - end, cube = start + end - 2 * rise;
  return [y0 + x * (start + x * (square + x * cube)), (start + x * (2 * square + 3 * x * cube)) / h];
}

/* c (m) and its slope (m/rad) at a phase in degrees, and the row of the cam's table. */
function camAt(phase) {
  const {theta_deg: theta, c, c1} = data.cam;
  const k = Math.min(before(theta, 0, theta.length, phase), theta.length - 2);
  const degrees = theta[k + 1] - theta[k];
  if (!(degrees > 0)) return [c[k], c1[k], k, 0];
  const h = degrees * Math.PI / 180, x = (phase - theta[k]) / degrees;
  return [...cubic(c[k], c1[k], c[k + 1], c1[k + 1], h, x), k, x];
}

function phaseAt(t) {
  const phase = (data.strobe_deg + TURN * t) % TURN;
  return phase < 0 ? phase + TURN : phase;
}

/* All that is known of a motion at t turns after the strobe. */
function at(m, t) {
  const {t: times, q, v, rest} = data.rows;
  const k = before(times, m.row, m.row + m.rows, t);
  const phase = phaseAt(t), omega = m.rpm * Math.PI / 30, [c, c1, row, x] = camAt(phase);
  const out = {t, phase, c, cDot: c1 * omega, rests: Boolean(rest[k]), force: 0};
  const h = (times[k + 1] - times[k]) * 60 / m.rpm;
  if (rest[k]) {
    out.q = c, out.v = out.cDot;
    out.force = force(m, row, x);
  } else if (k + 1 < m.row + m.rows && h > 0) {
    [out.q, out.v] = cubic(q[k], v[k], q[k + 1], v[k + 1], h, (t - times[k]) / (times[k + 1] - times[k]));
  } else {
    out.q = q[k], out.v = v[k];
  }
  out.gap = Math.max(0, out.q - c), out.u = out.v - out.cDot;
  return out;
}

/* The follower of a motion: that of the scene, but of a map with other constants. */
function followerOf(m) {
  const changed = Object.entries(m.sets).map(([key, value]) => [key.replace("follower.", ""), value]);
  return {...data.follower, ...Object.fromEntries(changed)};
}

/* Force (N) on a follower that rests on the cam: spring, preload, weight, damper and inertia. */
function force(m, k, x) {
  const f = followerOf(m), omega = m.rpm * Math.PI / 30;
  const line = values => values[k] + x * (values[Math.min(k + 1, values.length - 1)] - values[k]);
  return f.mass * f.gravity + f.preload + f.stiffness * line(data.cam.c)
    + omega * (f.damping * line(data.cam.c1) + omega * f.mass * line(data.cam.c2));
}
