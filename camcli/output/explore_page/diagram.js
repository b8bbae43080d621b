/* ---- the diagram ---- */

const host = $("diagram"), canvas = host.querySelector("canvas"), overlay = host.querySelector("svg");
overlay.id = "overlay";
const colours = {};

function readColours() {
  const style = getComputedStyle(document.documentElement);
  for (const name of ["aperiodic", "undecided", "contact", "longer", "period1", "period2", "period3", "period4", "ink", "line", "guide", "paper"])
    colours[name] = style.getPropertyValue("--" + name).trim();
}

/* The points of a motion in the quantity shown: [values, from, to]. */
function pointsOf(m) {
  const values = data.points[QUANTITIES[state.quantity].points];
  return state.quantity === "q" ? [values, m.strobe, m.strobe + m.strobes] : [values, m.impact, m.impact + m.impacts];
}

function wholeView() {
  const [a, b] = [data.speeds[0], data.speeds[1]].sort((p, q) => p - q), room = 0.015 * (b - a) || 0.01 * a;
  state.x = [a - room, b + room];
  if (state.quantity === "theta") { state.y = [0, TURN]; return; }
  let low = Infinity, high = -Infinity;
  for (const m of inDiagram) {
    const [values, from, to] = pointsOf(m);
    for (let k = from; k < to; k++) low = Math.min(low, values[k]), high = Math.max(high, values[k]);
  }
  if (!(high > low)) [low, high] = high === low ? [low - 1, high + 1] : [0, 1];
  state.y = [low - 0.04 * (high - low), high + 0.04 * (high - low)];
}

function drawDiagram() {
  if (!state.x) wholeView();
  const {width, height} = host.getBoundingClientRect(), ratio = Math.min(3, devicePixelRatio || 1);
  canvas.width = Math.round(width * ratio), canvas.height = Math.round(height * ratio);
  const pen = canvas.getContext("2d");
  pen.scale(ratio, ratio);
  const strip = inDiagram.some(m => Number.isFinite(m.exponent)) ? 84 : 0;
  const {svg} = emptied(overlay), quantity = QUANTITIES[state.quantity];
  const lengthy = quantity.unit === "m" ? lengths(state.y[1] - state.y[0]) : {unit: quantity.unit, factor: 1};
  diagram = new Axes(svg, 46, 40, width - 10, height - 34 - strip, state.x, state.y);
  const shown = new Axes(svg, diagram.left, diagram.top, diagram.right, diagram.bottom, state.x, state.y.map(v => v * lengthy.factor));
  const whole = state.quantity === "theta" && state.y[1] - state.y[0] > 180;
  shown.ticksY(7, whole ? [0, 60, 120, 180, 240, 300, 360].filter(a => a >= state.y[0] && a <= state.y[1]).map(a => [a, String(a)]) : undefined);
  if (state.quantity === "theta") for (const [letter, degrees] of Object.entries(data.corners)) {
    if (degrees < state.y[0] || degrees > state.y[1]) continue;
    add(svg, "line", {class: "event", x1: diagram.left, x2: diagram.right, y1: px(diagram.Y(degrees)), y2: px(diagram.Y(degrees))});
    add(svg, "text", {class: "small", x: diagram.right - 4 - 10 * (letter.charCodeAt(0) % 2), y: px(diagram.Y(degrees) - 3), "text-anchor": "end"}, letter);
  }
  pen.save();
  pen.beginPath();
  pen.rect(diagram.left, diagram.top, diagram.right - diagram.left, diagram.bottom - diagram.top);
  pen.clip();
  const column = Math.max(1.2, Math.min(4, 0.9 * (diagram.right - diagram.left) / (state.x[1] - state.x[0]) * Math.abs(data.speeds[1] - data.speeds[0]) / Math.max(1, data.speeds[2] - 1)));
  for (const m of inDiagram) {
    if (m.rpm < state.x[0] || m.rpm > state.x[1] || m.origin === "solved") continue;
    const [values, from, to] = pointsOf(m), few = to - from < 40, high = few ? 2.2 : 1.4, wide = few ? Math.max(2.2, column) : column, x = diagram.X(m.rpm) - wide / 2;
    pen.fillStyle = colours[m.colour];
    pen.globalAlpha = few ? 1 : 0.4;
    for (let k = from; k < to; k++) pen.fillRect(x, diagram.Y(values[k]) - high / 2, wide, high);
  }
  pen.globalAlpha = 1;
  for (const branch of data.branches) drawBranch(pen, branch, quantity.branch);
  pen.restore();
  if (strip) drawStrip(pen, svg, width, height);
  shown.ticksX(Math.max(3, width / 90), strip ? ticksOf(...state.x, Math.max(3, width / 90)).map(([v]) => [v, ""]) : undefined);
  shown.frame();
  add(svg, "text", {x: 4, y: 13}, `${quantity.name} (${lengthy.unit})`);
  add(svg, "text", {x: width - 10, y: height - 4, "text-anchor": "end"}, "speed (rpm)");
  let edge = -Infinity;
  data.bifurcations.forEach((event, k) => {
    if (event.rpm < state.x[0] || event.rpm > state.x[1]) return;
    const x = diagram.X(event.rpm), at = Math.max(x, edge + 17);
    edge = at;
    add(svg, "line", {class: "event", x1: px(x), x2: px(x), y1: diagram.top, y2: height - 34});
    add(svg, "line", {class: "axis", x1: px(x), x2: px(at), y1: diagram.top, y2: diagram.top - 6});
    add(svg, "circle", {cx: px(at), cy: diagram.top - 14, r: 8, fill: "var(--ink)"});
    add(svg, "text", {x: px(at), y: diagram.top - 10, "text-anchor": "middle", style: "fill: var(--paper); font-size: 11px; font-weight: 600"}, k + 1);
    event.at = at;
    for (const value of event[quantity.branch] || [])
      if (value >= state.y[0] && value <= state.y[1])
        add(svg, "path", {class: "lines", stroke: "var(--trouble)", "stroke-width": 2, d: `M${px(x - 5)} ${px(diagram.Y(value))}l5 -5l5 5l-5 5z`});
  });
  diagram.cursor = add(svg, "g", {class: "chosen"});
  drawCursor();
}

/* A solved branch: stable parts solid, unstable ones dashed. */
function drawBranch(pen, branch, quantity) {
  const jump = quantity === "theta_deg" ? 40 : Infinity;
  for (const stable of [1, 0]) {
    pen.beginPath();
    for (const values of branch[quantity]) {
      let open = false;
      for (let k = 1; k < branch.rpm.length; k++) {
        const joined = branch.stable[k] === stable && branch.label[k] === branch.label[k - 1] && Math.abs(values[k] - values[k - 1]) < jump;
        if (joined && !open) pen.moveTo(diagram.X(branch.rpm[k - 1]), diagram.Y(values[k - 1]));
        if (joined) pen.lineTo(diagram.X(branch.rpm[k]), diagram.Y(values[k]));
        open = joined;
      }
    }
    pen.setLineDash(stable ? [] : [5, 4]);
    pen.lineWidth = stable ? 2 : 1.5;
    pen.strokeStyle = colours[branch.colour];
    pen.stroke();
  }
  pen.setLineDash([]);
}

/* The largest exponent below, positive in the colour of what never repeats. */
function drawStrip(pen, svg, width, height) {
  let low = -0.05, high = 0.05;
  for (const m of inDiagram) if (Number.isFinite(m.exponent)) low = Math.min(low, m.exponent), high = Math.max(high, m.exponent);
  low = Math.max(low, -1.5);
  const axes = new Axes(svg, 46, height - 34 - 64, width - 10, height - 34, state.x, [low - 0.1 * (high - low), high + 0.1 * (high - low)]);
  axes.ticksY(2);
  axes.ticksX(Math.max(3, width / 90));
  for (const m of inDiagram) {
    if (m.exponent === null || m.rpm < state.x[0] || m.rpm > state.x[1]) continue;
    pen.fillStyle = colours[m.colour];
    pen.fillRect(axes.X(m.rpm) - 1, m.exponent < low ? axes.bottom - 5 : axes.Y(m.exponent) - 1, 2, m.exponent < low ? 5 : 2);
  }
  add(svg, "line", {class: "axis", x1: axes.left, x2: axes.right, y1: px(axes.Y(0)), y2: px(axes.Y(0))});
  axes.frame();
  add(svg, "text", {x: 4, y: axes.top - 5}, "largest exponent per turn");
}

function drawCursor() {
  const m = state.motion;
  if (!diagram || !m) return;
  diagram.cursor.replaceChildren();
  const x = diagram.X(m.rpm);
  if (x >= diagram.left && x <= diagram.right && !m.place) {
    add(diagram.cursor, "line", {class: "cursor", x1: px(x), x2: px(x), y1: diagram.top, y2: diagram.bottom});
    let [values, from, to] = pointsOf(m);
    if (m.origin === "solved" || from === to) [values, from, to] = solvedPoints(m);
    for (let k = from; k < to && to - from <= 32; k++)
      if (values[k] >= state.y[0] && values[k] <= state.y[1]) add(diagram.cursor, "circle", {class: "ring", cx: px(x), cy: px(diagram.Y(values[k])), r: 6});
  }
  const lowest = inDiagram[0], highest = inDiagram[inDiagram.length - 1];
  set(host, {"aria-valuemin": lowest.rpm, "aria-valuemax": highest.rpm, "aria-valuenow": m.rpm, "aria-valuetext": `${short(m.rpm)} rpm, ${name(m)}`});
  drawMarks();
}

/* Points of a motion as its own simulation has them. */
function solvedPoints(m) {
  if (state.quantity === "q") return [data.rows.q, m.row, m.row + 1];
  const values = [];
  for (let k = m.event; k < m.event + m.events; k++) if (data.events.kind[k] === 0 && data.events.t[k] < m.turns)
    values.push(state.quantity === "u" ? data.events.u[k] : phaseAt(data.events.t[k]));
  return [values, 0, values.length];
}

/* The motion nearest to a place in the diagram; far: how many pixels away. */
function nearest(x, y) {
  const wanted = diagram.fromX(x);
  let best = null, far = Infinity, closest = Infinity;
  for (const m of inDiagram) closest = Math.min(closest, Math.abs(m.rpm - wanted));
  const reach = Math.max(closest * 1.0001, 5 * (state.x[1] - state.x[0]) / (diagram.right - diagram.left));
  for (const m of inDiagram) {
    const aside = Math.abs(m.rpm - wanted);
    if (aside > reach) continue;
    const [values, from, to] = m.origin === "solved" ? solvedPoints(m) : pointsOf(m);
    let above = from === to ? 60 : Infinity;
    for (let k = from; k < to; k++) above = Math.min(above, Math.abs(diagram.Y(values[k]) - y));
    const distance = Math.hypot(aside / reach * 5, above);
    if (distance < far) far = distance, best = m;
  }
  return best;
}

function zoom(factor, x = (diagram.left + diagram.right) / 2, y = (diagram.top + diagram.bottom) / 2) {
  const at = [diagram.fromX(x), diagram.fromY(y)];
  state.x = state.x.map(v => at[0] + (v - at[0]) * factor);
  state.y = state.y.map(v => at[1] + (v - at[1]) * factor);
  view();
}

function pan(dx, dy) {
  const wide = (state.x[1] - state.x[0]) / (diagram.right - diagram.left), high = (state.y[1] - state.y[0]) / (diagram.bottom - diagram.top);
  state.x = state.x.map(v => v - dx * wide), state.y = state.y.map(v => v + dy * high);
  view();
}

let waiting = false;
function view() {
  if (waiting) return;
  waiting = true;
  requestAnimationFrame(() => { waiting = false; drawDiagram(); keepLink(); });
}

const pointers = new Map();
let moved = 0;
const place = event => { const box = host.getBoundingClientRect(); return [event.clientX - box.left, event.clientY - box.top]; };
host.addEventListener("pointerdown", event => { pointers.set(event.pointerId, place(event)); moved = 0; host.setPointerCapture(event.pointerId); });
host.addEventListener("pointermove", event => {
  const [x, y] = place(event), from = pointers.get(event.pointerId);
  if (!from) return hover(x, y);
  $("hint").hidden = true;
  moved += Math.hypot(x - from[0], y - from[1]);
  if (pointers.size === 2) {
    const [other] = [...pointers.entries()].filter(([id]) => id !== event.pointerId).map(([, at]) => at);
    const before = Math.hypot(from[0] - other[0], from[1] - other[1]), after = Math.hypot(x - other[0], y - other[1]);
    if (before > 0 && after > 0) zoom(before / after, other[0], other[1]);
  } else if (moved > 4) pan(x - from[0], event.pointerType === "touch" ? 0 : y - from[1]);
  pointers.set(event.pointerId, [x, y]);
});
host.addEventListener("pointerup", event => {
  const [x, y] = place(event), alone = pointers.size === 1;
  pointers.delete(event.pointerId);
  if (!alone || moved > 4) return;
  const event_ = numberAt(x, y);
  if (event_) return goTo(event_);
  const m = nearest(x, y);
  if (m) { state.wanted = diagram.fromX(Math.max(diagram.left, Math.min(diagram.right, x))); choose(m); }
});
host.addEventListener("pointercancel", event => pointers.delete(event.pointerId));
host.addEventListener("pointerleave", () => { $("hint").hidden = true; });
host.addEventListener("dblclick", event => zoom(0.5, ...place(event)));
host.addEventListener("wheel", event => {
  if (!event.ctrlKey && !event.metaKey && document.activeElement !== host) return;
  event.preventDefault();
  zoom(Math.exp(event.deltaY * 0.0015), ...place(event));
}, {passive: false});

const numberAt = (x, y) => Math.abs(y - diagram.top + 14) < 12 ? data.bifurcations.find(event => event.at !== undefined && Math.abs(event.at - x) < 9 && event.rpm >= state.x[0] && event.rpm <= state.x[1]) : undefined;

function hover(x, y) {
  const event = numberAt(x, y), m = event ? null : diagram.holds(x, y) && nearest(x, y), hint = $("hint");
  hint.hidden = !event && !m;
  if (hint.hidden) return;
  hint.textContent = event ? eventWords(event) : `${short(m.rpm)} rpm: ${name(m)}${exponent(m) ? "; " + exponent(m) : ""}`;
  const {width} = host.getBoundingClientRect(), box = hint.getBoundingClientRect();
  hint.style.left = `${Math.max(0, Math.min(x + 14, width - box.width))}px`;
  hint.style.top = `${Math.max(0, y - box.height - 12)}px`;
}

function eventWords(event) {
  const kind = event.kind.replace(/-/g, " ").replace("corner impact", `corner impact at ${event.corner}`);
  const more = event.classification ? ` (${event.classification.replace(/-/g, " ")})` : "";
  return `${kind} of ${shown(event.label)} at ${short(event.rpm)} rpm${more}`;
}

function goTo(event) {
  let best = inDiagram[0];
  for (const m of inDiagram) {
    const closer = Math.abs(m.rpm - event.rpm) - Math.abs(best.rpm - event.rpm);
    if (closer < 0 || (closer === 0 && m.label === event.label)) best = m;
  }
  state.wanted = event.rpm;
  choose(best);
}

host.addEventListener("keydown", event => {
  const actions = {
    ArrowLeft: () => nextSpeed(event.shiftKey ? -10 : -1), ArrowRight: () => nextSpeed(event.shiftKey ? 10 : 1),
    ArrowUp: () => nextMotion(1), ArrowDown: () => nextMotion(-1),
    "+": () => zoom(0.6), "=": () => zoom(0.6), "-": () => zoom(1 / 0.6), "0": whole,
  };
  if (!actions[event.key] || event.ctrlKey || event.metaKey) return;
  event.preventDefault();
  actions[event.key]();
});
$("choices").addEventListener("keydown", event => {
  const way = {ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1}[event.key];
  if (!way) return;
  event.preventDefault();
  nextMotion(way);
  focusChosen();
});
document.addEventListener("keydown", event => {
  if (event.target.closest("input, select, summary, a") || event.ctrlKey || event.metaKey || event.altKey) return;
  if (event.key === " " && !event.target.closest("button")) { event.preventDefault(); play(!state.playing); }
  if (event.key === ",") step(-1);
  if (event.key === ".") step(1);
});

function whole() { wholeView(); view(); }
