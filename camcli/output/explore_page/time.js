/* ---- the time response ---- */

const MOST_TURNS = 3;

function windowOf(m, t) {
  if (m.turns <= MOST_TURNS) return [0, m.turns];
  const first = Math.min(Math.floor(t / MOST_TURNS) * MOST_TURNS, m.turns - MOST_TURNS);
  return [first, first + MOST_TURNS];
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

function drawTime() {
  const m = state.motion, {svg, width, height} = emptied("time");
  time = axesOfTime(m, svg, width, height);
  const {upper, lower} = time;
  drawGridOfTime();
  const inside = upper.clip();
  drawCamInTime(inside);
  drawPieces(m, inside);
  drawEventsInTime(m, inside);
  upper.frame();
  lower.frame();
  drawWordsOfTime(m, svg, width, height);
  const lineOver = ({top, bottom}) => add(svg, "line", {class: "cursor", y1: top, y2: bottom});
  time.cursor = [upper, lower].map(lineOver);
  time.dot = add(svg, "circle", {class: "dot", r: 5});
}

/* Axes of position above and of force below, over the turns in sight. */
function axesOfTime(m, svg, width, height) {
  const span = windowOf(m, state.t), [low, high] = positionsOf(m);
  const {unit, factor} = lengths(high - low), room = 0.08 * (high - low);
  const split = height - Math.min(118, 0.48 * height);
  const positions = [(low - room) * factor, (high + room) * factor];
  const forces = [0, 1.08 * largestForce(m) || 1];
  const upper = new Axes(svg, 46, 24, width - 8, split, span, positions);
  const lower = new Axes(svg, 46, split + 30, width - 8, height - 34, span, forces);
  return {upper, lower, span, unit, factor};
}

function drawGridOfTime() {
  const {upper, lower, span} = time, degrees = angleTicks(span, upper.width);
  upper.ticksX(0, degrees.map(([t]) => [t, ""]));
  upper.ticksY(Math.max(3, upper.height / 40));
  lower.ticksX(0, degrees);
  lower.ticksY(lower.height < 30 ? 2 : 3);
}

function drawCamInTime(inside) {
  const {upper, span, factor} = time;
  add(inside, "path", {class: "under", d: camPath(upper, ...span, factor, true)});
  add(inside, "path", {class: "lines camline", d: camPath(upper, ...span, factor, false)});
}

function drawWordsOfTime(m, svg, width, height) {
  const {upper, span, unit} = time, right = width - 8, below = upper.bottom + 22;
  const free = right - drawKindsOfEvents(m, svg, right, 13) - 8;
  const title = add(svg, "text", {x: 4, y: 13});
  for (const what of [TERMS.position, TERMS.short, "q, c"]) { // the longest that there is room for
    title.textContent = `${what} (${unit})`;
    if (title.getComputedTextLength() <= free) break;
  }
  add(svg, "text", {x: 4, y: below}, "contact force (N); impacts as lines");
  if (m.turns > MOST_TURNS) {
    const turns = `turns ${span[0] + 1} to ${span[1]} of ${m.turns}`;
    add(svg, "text", {class: "small", x: right, y: below, "text-anchor": "end"}, turns);
  }
  add(svg, "text", {x: right, y: height - 4, "text-anchor": "end"}, "cam angle θ (deg)");
}

/* What the dots mean, up to `right`: the kinds of event that this motion has. How wide it is. */
function drawKindsOfEvents(m, svg, right, y) {
  const kinds = new Set(data.events.kind.subarray(m.event, m.event + m.events));
  const line = add(svg, "text", {class: "small", x: right, y, "text-anchor": "end"});
  for (const kind of [...kinds].sort()) {
    add(line, "tspan", {class: `kind${kind}`}, "\u00a0\u00a0●\u00a0");
    add(line, "tspan", {}, DOTS[kind]);
  }
  return line.getComputedTextLength();
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
