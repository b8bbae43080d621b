/* ---- time response and phase plane ---- */

const MOST_TURNS = 3;

function windowOf(m, t) {
  if (m.turns <= MOST_TURNS) return [0, m.turns];
  const first = Math.min(Math.floor(t / MOST_TURNS) * MOST_TURNS, m.turns - MOST_TURNS);
  return [first, first + MOST_TURNS];
}

/* Pieces of a motion from row to row, [t0, t1, rests, row]; none of length zero. */
function* pieces(m, from, to) {
  const times = data.rows.t, last = m.row + m.rows - 1;
  for (let k = before(times, m.row, m.row + m.rows, from); k < last && times[k] < to; k++) {
    if (times[k + 1] > times[k]) yield [times[k], times[k + 1], Boolean(data.rows.rest[k]), k];
  }
}

/* The cam from time to time as a path of the time response; closed down to the axis if asked. */
function camPath(axes, from, to, factor, close) {
  const steps = Math.max(1, Math.ceil((to - from) * 240)), places = [];
  for (let k = 0; k <= steps; k++) {
    const t = from + (to - from) * k / steps;
    const isEndOfTurn = k === steps && t % 1 === 0; // not yet the next turn's first angle
    const [c] = camAt(phaseAt(isEndOfTurn ? t - 1e-9 : t));
    places.push(`${px(axes.X(t))} ${px(axes.Y(c * factor))}`);
  }
  const path = `M${places.join("L")}`;
  return close ? `${path}V${axes.bottom}H${px(axes.X(from))}Z` : path;
}

/* Ticks of the cam angle over the turns in sight: [t, degrees]. */
function angleTicks([from, to], width) {
  const most = width / 34, degrees = (to - from) * TURN;
  const step = [30, 60, 90, 180, 360].find(one => degrees / one <= most) || 360;
  const first = Math.ceil((data.strobe_deg + TURN * from) / step) * step, ticks = [];
  for (let angle = first; angle <= data.strobe_deg + TURN * to; angle += step) {
    ticks.push([(angle - data.strobe_deg) / TURN, String(angle % TURN)]);
  }
  return ticks;
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

function drawTime() {
  const m = state.motion, {svg, width, height} = emptied("time"), span = windowOf(m, state.t);
  const [low, high] = positionsOf(m), {unit, factor} = lengths(high - low);
  const room = 0.08 * (high - low), split = height - Math.min(118, 0.48 * height);
  const positions = [(low - room) * factor, (high + room) * factor];
  const forces = [0, 1.08 * largestForce(m) || 1];
  const upper = new Axes(svg, 46, 24, width - 8, split, span, positions);
  const lower = new Axes(svg, 46, split + 30, width - 8, height - 34, span, forces);
  time = {upper, lower, span, factor};
  const degrees = angleTicks(span, upper.width);
  upper.ticksX(0, degrees.map(([t]) => [t, ""]));
  upper.ticksY(Math.max(2, upper.height / 40));
  lower.ticksX(0, degrees);
  lower.ticksY(3);
  const inside = upper.clip();
  add(inside, "path", {class: "under", d: camPath(upper, ...span, factor, true)});
  add(inside, "path", {class: "lines camline", d: camPath(upper, ...span, factor, false)});
  drawPieces(m, inside);
  drawEventsInTime(m, inside);
  upper.frame();
  lower.frame();
  const isNarrow = width < 430, position = isNarrow ? TERMS.short : TERMS.position;
  add(svg, "text", {x: 4, y: 13}, `${position} (${unit})`);
  drawKindsOfEvents(m, svg, width - 8, 13);
  add(svg, "text", {x: 4, y: split + 22}, "contact force (N); impacts as lines");
  add(svg, "text", {x: width - 8, y: height - 4, "text-anchor": "end"}, "cam angle θ (deg)");
  const lineOver = ({top, bottom}) => add(svg, "line", {class: "cursor", y1: top, y2: bottom});
  time.cursor = [upper, lower].map(lineOver);
  time.dot = add(svg, "circle", {class: "dot", r: 5});
  const turns = m.turns > MOST_TURNS ? `turns ${span[0] + 1} to ${span[1]} of ${m.turns}` : "";
  add(svg, "text", {class: "small", x: width - 8, y: split + 22, "text-anchor": "end"}, turns);
}

/* What the dots mean, up to `right`: the kinds of event that this motion has. */
function drawKindsOfEvents(m, svg, right, y) {
  const kinds = new Set(data.events.kind.subarray(m.event, m.event + m.events));
  const line = add(svg, "text", {class: "small", x: right, y, "text-anchor": "end"});
  for (const kind of [...kinds].sort()) {
    add(line, "tspan", {class: `kind${kind}`}, "\u00a0\u00a0●\u00a0");
    add(line, "tspan", {}, DOTS[kind]);
  }
}
const DOTS = ["impact", "chatter ends", "lift-off"]; // in the order of KINDS

/* Flights, rests and the contact force of the turns in sight. */
function drawPieces(m, inside) {
  const {upper, lower, span, factor} = time, {q, v} = data.rows;
  const secondsPerTurn = 60 / m.rpm;
  let flight = "", rests = "", forces = "", end = null;
  for (const [t0, t1, isRest, k] of pieces(m, ...span)) {
    if (isRest) {
      rests += camPath(upper, t0, t1, factor, false);
      forces += forcePath(m, lower, t0, t1);
      end = null;
      continue;
    }
    const third = (t1 - t0) / 3; // a cubic through position and velocity at both ends, as Bezier
    const place = (t, position) => `${px(upper.X(t))} ${px(upper.Y(position * factor))}`;
    const start = place(t0, q[k]), stop = place(t1, q[k + 1]);
    const leaving = place(t0 + third, q[k] + v[k] * secondsPerTurn * third);
    const arriving = place(t1 - third, q[k + 1] - v[k + 1] * secondsPerTurn * third);
    flight += `${t0 === end ? "" : `M${start}`}C${leaving} ${arriving} ${stop}`;
    forces += `M${px(lower.X(t0))} ${lower.bottom}H${px(lower.X(t1))}`;
    end = t1;
  }
  add(inside, "path", {class: "lines flight", d: flight});
  add(inside, "path", {class: "lines rest", d: rests});
  add(lower.clip(), "path", {class: "lines force", d: forces});
}

function drawEventsInTime(m, inside) {
  const {upper, lower, span, factor} = time, hardest = largestImpact(m);
  for (let k = m.event; k < m.event + m.events; k++) {
    const t = data.events.t[k], kind = data.events.kind[k];
    if (t < span[0] || t > span[1]) continue;
    const [c] = camAt(phaseAt(t)), x = px(upper.X(t));
    add(inside, "circle", {class: `kind${kind}`, cx: x, cy: px(upper.Y(c * factor)), r: 3});
    if (kind !== IMPACT) continue;
    const length = lower.height * Math.abs(data.events.u[k]) / hardest;
    const path = `M${px(lower.X(t))} ${lower.bottom}v${px(-length)}`;
    add(lower.svg, "path", {class: "lines struck", d: path});
  }
}

function forcePath(m, axes, t0, t1) {
  const steps = Math.max(1, Math.ceil((t1 - t0) * 720)), places = [];
  for (let k = 0; k <= steps; k++) {
    const t = t0 + (t1 - t0) * k / steps, [, , row, share] = camAt(phaseAt(t));
    places.push(`${px(axes.X(t))} ${px(axes.Y(force(m, row, share)))}`);
  }
  return `M${places.join("L")}`;
}

function largestImpact(m) {
  let most = 1e-300;
  for (let k = m.event; k < m.event + m.events; k++) most = Math.max(most, Math.abs(data.events.u[k]));
  return most;
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

const PHASE_ERROR = 0.1; // px

function drawPhase() {
  const m = state.motion, {svg, width, height} = emptied("phase");
  const {far, low, high} = extentOf(m), {unit, factor} = lengths(far);
  const flies = far > 0 && high > low, wide = flies ? far * factor : 1, tall = flies ? high - low : 2;
  const middle = (low + high) / 2, half = 0.55 * tall;
  const x = [-0.05 * wide, 1.06 * wide], y = [middle - half, middle + half];
  phase = new Axes(svg, 46, 24, width - 8, height - 34, x, y);
  phase.factor = factor;
  phase.ticksX(Math.max(2, width / 75));
  phase.ticksY(6);
  const inside = phase.clip(), zero = px(phase.X(0));
  add(inside, "line", {class: "axis", x1: zero, x2: zero, y1: phase.top, y2: phase.bottom});
  const toPixels = (gap, u) => [phase.X(gap * factor), phase.Y(u)];
  const toText = line => "M" + line.map(([left, down]) => `${px(left)} ${px(down)}`).join("L");
  const lines = flightLines(m, toPixels, PHASE_ERROR);
  add(inside, "path", {class: "lines flight", id: "flights", d: lines.map(toText).join("")});
  add(inside, "path", {class: "lines jump", id: "jumps", d: jumpPath(m, zero)});
  phase.frame();
  if (!flies) {
    const place = {x: (phase.left + phase.right) / 2, y: phase.Y(0) - 12, "text-anchor": "middle"};
    add(svg, "text", {class: "small", ...place}, "no flight");
  }
  add(svg, "text", {x: 4, y: 13}, "relative velocity u (m/s)");
  add(svg, "text", {x: width - 8, y: height - 4, "text-anchor": "end"}, `${TERMS.gap} (${unit})`);
  phase.dot = add(svg, "circle", {class: "dot", r: 5});
}

/* Impacts in the phase plane: from the relative velocity before to the one after. */
function jumpPath(m, zero) {
  const {t, v} = data.rows;
  let path = "";
  for (let k = m.row + 1; k < m.row + m.rows; k++) {
    if (t[k] !== t[k - 1]) continue;
    const u = speedOfImpact(m, k);
    path += `M${zero} ${px(phase.Y(u))}V${px(phase.Y(u + v[k] - v[k - 1]))}`;
  }
  return path;
}

/* The relative velocity before the impact of row k, as its event tells; hops at the end of a
   chatter have none. On a corner of a cam with lash the cam's velocity has two values. */
function speedOfImpact(m, k) {
  const {t, v} = data.rows, {t: times, u, kind} = data.events, near = 2e-7; // turns
  const event = before(times, m.event, m.event + m.events, t[k] + near);
  const isTold = m.events > 0 && kind[event] === IMPACT && Math.abs(times[event] - t[k]) < near;
  return isTold ? u[event] : v[k - 1] - inFlight(m, k, t[k]).cDot;
}

function drawMotion() {
  drawTime();
  drawPhase();
  drawMachine();
  drawTrace();
  drawNow();
}

/* ---- what holds now: the law in force, and the numbers ---- */

const LAWS = lawsOf(data);
const LAW_NAMES = {flight: TERMS.flies, rest: TERMS.rests, impact: "at an impact"};
const LAW_COLOURS = {flight: "flight", rest: "sticking", impact: "trouble"};
const lawRows = {};
for (const [law, formula] of Object.entries(LAWS)) {
  const row = lawRows[law] = make("div");
  row.style.setProperty("--own", `var(--${LAW_COLOURS[law]})`);
  row.append(make("dt", {textContent: LAW_NAMES[law]}), make("dd", {textContent: formula}));
  $("laws").append(row);
}

/* Mark the law that a motion obeys now. */
function markLaw(m, now) {
  const struck = agoStruck(m, state.t) < FADE;
  const holds = {flight: !now.rests, rest: now.rests, impact: struck};
  for (const law of Object.keys(LAWS)) lawRows[law].classList.toggle("holds", holds[law]);
}

const NOW = ["position q", TERMS.gap, "velocity u", "force"];
$("now").replaceChildren(...NOW.map(term => {
  const row = make("div");
  row.append(make("dt", {textContent: term}), make("dd"));
  return row;
}));
const cells = [...$("now").querySelectorAll("dd")];

/* One frame: only what moves. */
function drawNow() {
  const m = state.motion, now = at(m, state.t), [from, to] = windowOf(m, state.t);
  if (from !== time.span[0] || to !== time.span[1]) {
    drawTime();
    drawTrace();
  }
  moveMachine(m, now);
  markLaw(m, now);
  const x = px(time.upper.X(state.t)), u = now.rests ? 0 : now.u;
  for (const line of time.cursor) set(line, {x1: x, x2: x});
  set(time.dot, {cx: x, cy: px(time.upper.Y(now.q * time.factor))});
  set(phase.dot, {cx: px(phase.X(now.gap * phase.factor)), cy: px(phase.Y(u))});
  const clear = clearness(m, state.t);
  for (const node of [machine.moving, time.dot, phase.dot]) node.style.opacity = clear;
  const {unit, factor} = lengths(Math.max(Math.abs(now.q), Math.abs(now.c)));
  const texts = [
    `${fixed(now.q * factor, 3)} ${unit}`,
    `${fixed(now.gap * factor, 3)} ${unit}`,
    `${fixed(u, 3)} m/s`,
    `${fixed(now.force, time.lower.y[1] < 10 ? 3 : 1)} N`,
  ];
  texts.forEach((text, k) => { cells[k].textContent = text; });
}

const END = 0.15; // turns in which a record that does not repeat fades

/* From 0 to 1: a record whose end is not its beginning fades out, and in again. */
function clearness(m, t) {
  if (m.loops || !state.playing) return 1;
  return Math.max(0, Math.min(1, (m.end - t) / END, t / END + 0.05));
}
