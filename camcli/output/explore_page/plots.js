/* ---- time response and phase plane ---- */

const MOST_TURNS = 3;

function windowOf(m, t) {
  if (m.turns <= MOST_TURNS) return [0, m.turns];
  const first = Math.min(Math.floor(t / MOST_TURNS) * MOST_TURNS, m.turns - MOST_TURNS);
  return [first, first + MOST_TURNS];
}

/* Pieces of a motion from row to row, [t0, t1, rests]; none of length zero. */
function* pieces(m, from, to) {
  const times = data.rows.t, last = m.row + m.rows - 1;
  for (let k = before(times, m.row, m.row + m.rows, from); k < last && times[k] < to; k++)
    if (times[k + 1] > times[k]) yield [times[k], times[k + 1], Boolean(data.rows.rest[k]), k];
}

/* A curve f(t) as Bezier pieces, or as a polyline on the cam. */
function camPath(axes, from, to, factor, close) {
  let d = "";
  const steps = Math.ceil((to - from) * 240);
  for (let k = 0; k <= steps; k++) {
    const t = from + (to - from) * k / steps;
    const c = camAt(k === steps && t % 1 === 0 && from < to ? phaseAt(t - 1e-9) : phaseAt(t))[0];
    d += `${k ? "L" : "M"}${px(axes.X(t))} ${px(axes.Y(c * factor))}`;
  }
  return close ? `${d}V${axes.bottom}H${px(axes.X(from))}Z` : d;
}

function drawTime() {
  const m = state.motion, {svg, width, height} = emptied("time"), span = windowOf(m, state.t);
  const own = [Infinity, -Infinity], hit = [0, 0];
  for (let k = 0; k < data.cam.c.length; k++) own[0] = Math.min(own[0], data.cam.c[k]), own[1] = Math.max(own[1], data.cam.c[k]);
  for (let k = m.row; k < m.row + m.rows; k++) own[1] = Math.max(own[1], data.rows.q[k]);
  for (let k = 0; k < data.cam.c.length; k++) hit[1] = Math.max(hit[1], force(m, k, 0));
  const {unit, factor} = lengths(own[1] - own[0]);
  const room = 0.08 * (own[1] - own[0]), split = height - 118;
  const upper = new Axes(svg, 46, 24, width - 8, split, span, [(own[0] - room) * factor, (own[1] + room) * factor]);
  const lower = new Axes(svg, 46, split + 30, width - 8, height - 34, span, [0, 1.08 * hit[1] || 1]);
  time = {upper, lower, span, factor};
  const degrees = [];
  const most = (width - 54) / 34, step = [30, 60, 90, 180, 360].find(s => (span[1] - span[0]) * TURN / s <= most) || 360;
  for (let a = Math.ceil((data.strobe_deg + TURN * span[0]) / step) * step; a <= data.strobe_deg + TURN * span[1]; a += step)
    degrees.push([(a - data.strobe_deg) / TURN, String(a % TURN)]);
  upper.ticksX(0, degrees.map(([t]) => [t, ""]));
  upper.ticksY(6);
  lower.ticksX(0, degrees);
  lower.ticksY(2);
  const inside = upper.clip();
  add(inside, "path", {class: "under", d: camPath(upper, ...span, factor, true)});
  add(inside, "path", {class: "lines camline", d: camPath(upper, ...span, factor)});
  let flight = "", rests = "", forces = "", end = null;
  for (const [t0, t1, rest, k] of pieces(m, ...span)) {
    if (rest) {
      rests += camPath(upper, t0, t1, factor);
      forces += forcePath(m, lower, t0, t1);
    } else {
      const {q, v} = data.rows, third = (t1 - t0) / 3, slope = 60 / m.rpm;
      const p = (t, y) => `${px(upper.X(t))} ${px(upper.Y(y * factor))}`;
      flight += (t0 === end ? "" : `M${p(t0, q[k])}`) + `C${p(t0 + third, q[k] + v[k] * slope * third)} ${p(t1 - third, q[k + 1] - v[k + 1] * slope * third)} ${p(t1, q[k + 1])}`;
      forces += `M${px(lower.X(t0))} ${lower.bottom}H${px(lower.X(t1))}`;
    }
    end = rest ? null : t1;
  }
  add(inside, "path", {class: "lines flight", d: flight});
  add(inside, "path", {class: "lines rest", d: rests});
  add(lower.clip(), "path", {class: "lines force", d: forces});
  const hardest = largestImpact(m);
  for (let k = m.event; k < m.event + m.events; k++) {
    const t = data.events.t[k], kind = data.events.kind[k];
    if (t < span[0] || t > span[1]) continue;
    add(inside, "circle", {class: "kind" + kind, cx: px(upper.X(t)), cy: px(upper.Y(camAt(phaseAt(t))[0] * factor)), r: 3});
    if (kind === 0) add(lower.svg, "path", {class: "lines jump", "stroke-width": 1.5, d: `M${px(lower.X(t))} ${lower.bottom}v${px(-(lower.bottom - lower.top) * Math.abs(data.events.u[k]) / hardest)}`});
  }
  upper.frame(), lower.frame();
  add(svg, "text", {x: 4, y: 13}, `position of follower and cam (${unit})`);
  add(svg, "text", {x: 4, y: split + 22}, "contact force (N); impacts as lines");
  add(svg, "text", {x: width - 8, y: height - 4, "text-anchor": "end"}, "cam angle θ (deg)");
  time.cursor = [upper, lower].map(axes => add(svg, "line", {class: "cursor", y1: axes.top, y2: axes.bottom}));
  time.dot = add(svg, "circle", {class: "dot", r: 5, fill: "var(--accent)"});
  time.turn = add(svg, "text", {class: "small", x: width - 8, y: 13, "text-anchor": "end"}, m.turns > MOST_TURNS ? `turns ${span[0] + 1} to ${span[1]} of ${m.turns}` : "");
}

function forcePath(m, axes, t0, t1) {
  let d = "";
  const steps = Math.max(1, Math.ceil((t1 - t0) * 720));
  for (let k = 0; k <= steps; k++) {
    const t = t0 + (t1 - t0) * k / steps, [, , row, x] = camAt(phaseAt(t));
    d += `${k ? "L" : "M"}${px(axes.X(t))} ${px(axes.Y(force(m, row, x)))}`;
  }
  return d;
}

function largestImpact(m) {
  let most = 1e-300;
  for (let k = m.event; k < m.event + m.events; k++) most = Math.max(most, Math.abs(data.events.u[k]));
  return most;
}

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
    for (let k = 1; k < times.length; k++) {
      lines.push(smoothLine(place, times[k - 1], times[k], error));
    }
  }
  return lines;
}

/* The largest gap of a motion, and its least and largest relative velocity. */
function extentOf(m) {
  let far = 0, low = 0, high = 0;
  for (const line of flightLines(m, (gap, u) => [gap, u], Infinity)) {
    for (const [gap, u] of line) {
      far = Math.max(far, gap);
      low = Math.min(low, u);
      high = Math.max(high, u);
    }
  }
  return {far, low, high};
}

const PHASE_ERROR = 0.1; // px

function drawPhase() {
  const m = state.motion, {svg, width, height} = emptied("phase");
  const {far, low, high} = extentOf(m), {unit, factor} = lengths(far);
  const wide = far * factor || 20, tall = Math.max(high - low, 1e-12);
  const x = [-0.05 * wide, 1.06 * wide], y = [low - 0.05 * tall, high + 0.05 * tall];
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
  add(inside, "path", {class: "lines jump", d: jumpPath(m, zero)});
  phase.frame();
  add(svg, "text", {x: 4, y: 13}, "relative velocity u (m/s)");
  add(svg, "text", {x: width - 8, y: height - 4, "text-anchor": "end"}, `gap q − c (${unit})`);
  phase.dot = add(svg, "circle", {class: "dot", r: 5, fill: "var(--accent)"});
}

/* Impacts in the phase plane: from the relative velocity before to the one after. */
function jumpPath(m, zero) {
  const {t, v} = data.rows;
  let path = "";
  for (let k = m.row + 1; k < m.row + m.rows; k++) {
    if (t[k] !== t[k - 1]) continue;
    const {cDot} = inFlight(m, k, t[k]);
    path += `M${zero} ${px(phase.Y(v[k - 1] - cDot))}V${px(phase.Y(v[k] - cDot))}`;
  }
  return path;
}

function drawMotion() {
  drawTime();
  drawPhase();
  drawMachine();
  drawTrace();
  drawNow();
}

const NOW = ["angle θ", "position q", "gap q − c", "velocity u", "force", "contact"];
$("now").replaceChildren(...NOW.map(term => {
  const row = document.createElement("div");
  row.append(Object.assign(document.createElement("dt"), {textContent: term}), document.createElement("dd"));
  return row;
}));
const cells = [...$("now").querySelectorAll("dd")];

/* One frame: only what moves. */
function drawNow() {
  const m = state.motion, now = at(m, state.t);
  const [from, to] = windowOf(m, state.t);
  if (from !== time.span[0] || to !== time.span[1]) { drawTime(); drawTrace(); }
  const {x, y, scale, radius} = machine, tip = y - radius(now.q) * scale;
  set(machine.cam, {transform: `translate(${px(x)} ${px(y)}) rotate(${(-now.phase).toFixed(4)})`});
  for (const letter of machine.letters) set(letter, {transform: `rotate(${now.phase.toFixed(2)} ${letter.getAttribute("x")} ${letter.getAttribute("y")})`});
  set(machine.follower, {transform: `translate(${px(x)} ${px(tip)})`});
  if (machine.table) set(machine.table, {transform: `translate(${px(x)} ${px(y - radius(now.c) * scale)})`});
  if (machine.spring) set(machine.spring, {transform: `translate(${px(x)} 5) scale(1 ${Math.max(.02, (tip - 87) / 100).toFixed(5)})`});
  machine.tip.style.display = now.rests ? "" : "none";
  drawFlash(m, now, x, y - radius(now.c) * scale);
  machine.angle.textContent = `θ ${now.phase.toFixed(1)}°`;
  for (const line of time.cursor) set(line, {x1: px(time.upper.X(state.t)), x2: px(time.upper.X(state.t))});
  set(time.dot, {cx: px(time.upper.X(state.t)), cy: px(time.upper.Y(now.q * time.factor))});
  set(phase.dot, {cx: px(phase.X(now.gap * phase.factor)), cy: px(phase.Y(now.rests ? 0 : now.u))});
  const {unit, factor} = lengths(Math.max(Math.abs(now.q), Math.abs(now.c)));
  [`${now.phase.toFixed(1)}° (turn ${Math.min(Math.floor(state.t) + 1, m.turns)})`, `${fixed(now.q * factor, 3)} ${unit}`, `${fixed(now.gap * factor, 3)} ${unit}`,
    `${fixed(now.rests ? 0 : now.u, 3)} m/s`, `${fixed(now.force, 1)} N`, now.rests ? "sticking" : "flight"].forEach((text, k) => { cells[k].textContent = text; });
}

/* A ring where the follower has just struck, larger after a harder impact. */
const FADE = 0.06; // turns
function drawFlash(m, now, x, y) {
  const k = before(data.events.t, m.event, m.event + m.events, state.t), age = (state.t - data.events.t[k]) / FADE;
  const seen = m.events && data.events.kind[k] === 0 && age >= 0 && age < 1;
  machine.flash.style.display = seen ? "" : "none";
  if (seen) set(machine.flash, {cx: px(x), cy: px(y), r: px(4 + (6 + 22 * Math.sqrt(Math.abs(data.events.u[k]) / largestImpact(m))) * age), opacity: px(1 - age)});
}
