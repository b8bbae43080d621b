/* ---- the motions, and what is known of each at any time ---- */

const KINDS = ["impact", "chatter accumulates", "detachment"], IMPACT = 0;
const QUANTITIES = {
  theta: {symbol: "θ", unit: "deg", branch: "theta_deg", points: "theta_deg"},
  u: {symbol: "u⁻", unit: "m/s", branch: "u", points: "u"},
  q: {symbol: "q", unit: "m", branch: "q", points: "q"},
};
const TURN = 360;

const motions = data.motions;
numberMotions();
const inDiagram = motions.filter(isInDiagram).sort((a, b) => a.rpm - b.rpm || a.number - b.number);

/* Where the rows, events and points of each motion begin, and when it ends. */
function numberMotions() {
  let row = 0, event = 0, impact = 0, strobe = 0;
  motions.forEach((m, number) => {
    const end = Math.min(m.turns, data.rows.t[row + m.rows - 1]);
    const kin = m.stable === false ? `${m.label} unstable` : "";
    Object.assign(m, {number, row, event, impact, strobe, end, kin});
    row += m.rows;
    event += m.events;
    impact += m.impacts;
    strobe += m.strobes;
  });
}

/* Those of a plane have a place there, and a stop may be outside the speeds of the diagram. */
function isInDiagram(m) {
  return !m.place && m.origin !== "stop";
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

/* Cam angles (deg) at which the cam's curvature jumps: its table has two rows there. */
const KINKS = [...data.cam.theta_deg].filter((angle, k, angles) => k > 0 && angle === angles[k - 1]);

/* All that is known of a motion at t turns after the strobe. */
function at(m, t) {
  const k = before(data.rows.t, m.row, m.row + m.rows, t);
  if (!data.rows.rest[k]) return inFlight(m, k, t);
  const phase = phaseAt(t), [c, slope, camRow, share] = camAt(phase);
  const cDot = slope * m.rpm * Math.PI / 30;
  const contact = force(m, camRow, share);
  return {t, phase, c, cDot, q: c, v: cDot, gap: 0, u: 0, rests: true, force: contact};
}

/* The same in the flight that row k of the motion begins, both ends included. */
function inFlight(m, k, t) {
  const {t: times, q, v} = data.rows;
  const phase = phaseAt(t), [c, slope] = camAt(phase), cDot = slope * m.rpm * Math.PI / 30;
  const turns = k + 1 < m.row + m.rows ? times[k + 1] - times[k] : 0;
  let position = q[k], velocity = v[k];
  if (turns > 0) {
    const seconds = turns * 60 / m.rpm, share = (t - times[k]) / turns;
    [position, velocity] = cubic(q[k], v[k], q[k + 1], v[k + 1], seconds, share);
  }
  const gap = Math.max(0, position - c), u = velocity - cDot;
  return {t, phase, c, cDot, q: position, v: velocity, gap, u, rests: false, force: 0};
}

/* The times from t0 to t1 at which the cam's curvature jumps, and both ends. */
function smoothParts(t0, t1) {
  const times = [t0];
  for (let turn = Math.floor(t0); turn <= t1; turn++) {
    for (const angle of KINKS) {
      const share = ((angle - data.strobe_deg) / TURN % 1 + 1) % 1;
      if (turn + share > t0 && turn + share < t1) times.push(turn + share);
    }
  }
  return [...times.sort((a, b) => a - b), t1];
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

/* Pieces of a motion from row to row, [t0, t1, rests, row]; none of length zero. */
function* pieces(m, from, to) {
  const times = data.rows.t, last = m.row + m.rows - 1;
  for (let k = before(times, m.row, m.row + m.rows, from); k < last && times[k] < to; k++) {
    if (times[k + 1] > times[k]) yield [times[k], times[k + 1], Boolean(data.rows.rest[k]), k];
  }
}

const BESIDE_A_CORNER = 2e-7; // turns: where a cam with lash opens, its velocity jumps

/* The flights of a motion in the phase plane, as lines of [x, y] that are within `error` of it.
   toPlane(gap, u) says where a state is drawn. */
function flightLines(m, toPlane, error) {
  const lines = [];
  for (const [t0, t1, rests, row] of pieces(m, 0, m.end)) {
    if (rests) continue;
    const place = t => {
      const {gap, u} = inFlight(m, row, t);
      return toPlane(gap, u);
    };
    const times = smoothParts(t0, t1);
    for (let k = 1; k < times.length; k++) { // each ends on its own side of a corner
      const aside = k + 1 < times.length ? BESIDE_A_CORNER : 0;
      const end = Math.max(times[k - 1], times[k] - aside);
      lines.push(smoothLine(place, times[k - 1], end, error));
    }
  }
  return lines;
}

/* The largest gap of a motion, and its least and largest relative velocity. */
const extents = new Map();
function extentOf(m) {
  if (!extents.has(m)) extents.set(m, computedExtent(m));
  return extents.get(m);
}

function computedExtent(m) {
  let far = 0, low = 0, high = 0;
  for (const line of flightLines(m, (gap, u) => [gap, u], Infinity)) {
    for (const [gap, u] of line) {
      far = Math.max(far, gap);
      low = Math.min(low, u);
      high = Math.max(high, u);
    }
  }
  for (let k = m.event; k < m.event + m.events; k++) low = Math.min(low, data.events.u[k]);
  return {far, low, high};
}

/* The relative velocity before the impact of row k, as its event tells; hops at the end of a
   chatter have none. On a corner of a cam with lash the cam's velocity has two values. */
function speedOfImpact(m, k) {
  const {t, v} = data.rows, {t: times, u, kind} = data.events, near = 2e-7; // turns
  const event = before(times, m.event, m.event + m.events, t[k] + near);
  const isTold = m.events > 0 && kind[event] === IMPACT && Math.abs(times[event] - t[k]) < near;
  return isTold ? u[event] : v[k - 1] - inFlight(m, k, t[k]).cDot;
}

function largestImpact(m) {
  let most = 1e-300;
  for (let k = m.event; k < m.event + m.events; k++) most = Math.max(most, Math.abs(data.events.u[k]));
  return most;
}

/* How long ago, in turns, a motion had its last impact; infinity where it has had none. */
function agoStruck(m, t) {
  const k = before(data.events.t, m.event, m.event + m.events, t), age = t - data.events.t[k];
  return m.events > 0 && data.events.kind[k] === IMPACT && age >= 0 ? age : Infinity;
}

/* The least and the largest position of a motion and of the cam under it. */
function positionsOf(m) {
  let low = Infinity, high = -Infinity;
  for (const c of data.cam.c) {
    low = Math.min(low, c);
    high = Math.max(high, c);
  }
  for (let k = m.row; k < m.row + m.rows; k++) {
    low = Math.min(low, data.rows.q[k]);
    high = Math.max(high, data.rows.q[k]);
  }
  return [low, high];
}

function largestForce(m) {
  let largest = 0;
  for (let k = 0; k < data.cam.c.length; k++) largest = Math.max(largest, force(m, k, 0));
  return largest;
}
