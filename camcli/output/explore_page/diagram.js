/* ---- the diagram: what is drawn ---- */

const host = $("diagram"), canvas = host.querySelector("canvas"), overlay = host.querySelector("svg");
overlay.id = "overlay";
const colours = {};
const AREAS = ["aperiodic", "undecided", "contact", "longer", "rests", "period1", "period2",
  "period3", "period4"]; // paler in a map
const COLOUR_NAMES = [...AREAS, "ink", "line", "guide", "paper"];

/* The colours of the style, for what is drawn on a canvas. */
function readColours() {
  const style = getComputedStyle(document.documentElement);
  const read = name => { colours[name] = style.getPropertyValue("--" + name).trim(); };
  COLOUR_NAMES.forEach(read);
  AREAS.map(name => `area-${name}`).forEach(read);
}

/* The points of a motion in the quantity shown: [values, from, to]. */
function pointsOf(m) {
  const values = data.points[QUANTITIES[state.quantity].points];
  if (state.quantity === "q") return [values, m.strobe, m.strobe + m.strobes];
  return [values, m.impact, m.impact + m.impacts];
}

/* The same of a motion that no sweep recorded: as its own simulation has them. */
function simulatedPoints(m) {
  if (state.quantity === "q") return [data.rows.q, m.row, m.row + 1];
  const values = [];
  for (let k = m.event; k < m.event + m.events; k++) {
    const happensInside = data.events.kind[k] === IMPACT && data.events.t[k] < m.turns;
    if (!happensInside) continue;
    values.push(state.quantity === "u" ? data.events.u[k] : phaseAt(data.events.t[k]));
  }
  return [values, 0, values.length];
}

/* The view of all speeds and all values of the quantity shown. */
function wholeView() {
  const [low, high] = [data.speeds[0], data.speeds[1]].sort((a, b) => a - b);
  const room = 0.015 * (high - low) || 0.01 * low;
  return {x: [low - room, high + room], y: [...wholeOf(state.quantity)]};
}

/* The range of a quantity over all motions, looked for once. */
const ranges = {};
function wholeOf(quantity) {
  ranges[quantity] ??= quantity === "theta" ? rangeOfPhases() : rangeOfValues();
  return ranges[quantity];
}

const NARROW_PHASES = 150; // deg: impacts that keep within so much have a diagram of their own

/* The whole turn, or the part of it, in steps of 30 degrees, in which all impacts are. */
function rangeOfPhases() {
  const [low, high] = rangeOfValues();
  const hasImpacts = inDiagram.some(m => m.impacts > 0);
  if (!hasImpacts || high - low > NARROW_PHASES) return [0, TURN];
  return [Math.max(0, 30 * Math.floor(low / 30)), Math.min(TURN, 30 * Math.ceil(high / 30))];
}

function rangeOfValues() {
  let low = Infinity, high = -Infinity;
  for (const m of inDiagram) {
    const [values, from, to] = pointsOf(m);
    for (let k = from; k < to; k++) {
      low = Math.min(low, values[k]);
      high = Math.max(high, values[k]);
    }
  }
  if (low === Infinity) return [0, 1];
  const least = state.quantity === "q" ? 0.1 * liftOfCam() : 0;
  if (high - low <= 1e-5 * least || low === high) { // all alike: a line in the middle
    const half = least || 1;
    return [low - half, high + half];
  }
  return [low - 0.04 * (high - low), high + 0.04 * (high - low)];
}

function liftOfCam() {
  let low = Infinity, high = -Infinity;
  for (const lift of data.cam.c) {
    low = Math.min(low, lift);
    high = Math.max(high, lift);
  }
  return high - low;
}

function inView(x) {
  return x >= state.x[0] && x <= state.x[1];
}

const TALL_DIAGRAM = 400; // px: one that has room for a strip of exponents below
const STRIP = 84; // px

function drawDiagram() {
  if (!state.x) Object.assign(state, wholeView());
  const {width, height} = boxOf(host);
  const pen = penOf(canvas, width, height);
  const hasExponents = inDiagram.some(m => Number.isFinite(m.exponent));
  const strip = hasExponents && height > TALL_DIAGRAM ? STRIP : 0;
  const {svg} = emptied(overlay);
  const hasLetters = state.quantity === "theta" && Object.keys(data.corners).length > 0;
  const right = width - (hasLetters ? ROOM_OF_LETTERS : 10);
  diagram = new Axes(svg, 46, 28, right, height - 34 - strip, state.x, state.y);
  drawAxesOfDiagram(width, height, strip);
  pen.save();
  pen.beginPath();
  pen.rect(diagram.left, diagram.top, diagram.width, diagram.height);
  pen.clip();
  drawPoints(pen);
  for (const branch of data.branches) drawBranch(pen, branch, QUANTITIES[state.quantity].branch);
  pen.restore();
  if (strip) drawStrip(pen, svg, width, height, right);
  drawEvents(svg, height);
  diagram.cursor = add(svg, "g", {class: "chosen"});
  drawCursor();
}

function drawAxesOfDiagram(width, height, strip) {
  const {svg} = diagram, quantity = QUANTITIES[state.quantity];
  let scale = {unit: quantity.unit, factor: 1};
  if (quantity.unit === "m") scale = lengths(state.y[1] - state.y[0]);
  const values = state.y.map(value => value * scale.factor);
  const {left, top, right, bottom} = diagram;
  const shown = new Axes(svg, left, top, right, bottom, state.x, values);
  const showsWholeTurn = state.quantity === "theta" && state.y[1] - state.y[0] > 180;
  const angles = diagram.height < 150 ? [0, 90, 180, 270, 360] : [0, 60, 120, 180, 240, 300, 360];
  const seen = angles.filter(angle => angle >= state.y[0] && angle <= state.y[1]);
  const most = Math.max(2, diagram.height / 30);
  shown.ticksY(most, showsWholeTurn ? seen.map(angle => [angle, String(angle)]) : undefined);
  if (state.quantity === "theta") drawCorners(svg);
  const count = Math.max(3, width / 90), ticks = ticksOf(...state.x, count);
  shown.ticksX(count, strip ? ticks.map(([value]) => [value, ""]) : ticks);
  shown.frame();
  const symbol = add(svg, "text", {x: 2, y: 13}, `${quantity.symbol} (${scale.unit})`);
  diagram.endOfSymbol = 2 + symbol.getComputedTextLength();
  const end = {x: right, y: height - 4, "text-anchor": "end"};
  const name = add(svg, "text", end, speedAxisOf(data));
  if (name.getComputedTextLength() > right) name.textContent = TERMS.speed; // the crank's left out
}

const LETTER = 10; // px: a letter's height, and the room that it takes in a row
const ROOM_OF_LETTERS = 48; // px, beside the diagram

/* Dotted lines at the phases of the cam's corners; letters of neighbours stand side by side. */
function drawCorners(svg) {
  const seen = Object.entries(data.corners)
    .filter(([, degrees]) => degrees >= state.y[0] && degrees <= state.y[1])
    .map(([letter, degrees]) => ({letter, y: diagram.Y(degrees)}))
    .sort((a, b) => a.y - b.y);
  let above = -Infinity, place = 0;
  for (const {letter, y} of seen) {
    place = y - above < LETTER ? place + 1 : 0;
    above = y;
    const x = diagram.right + 5 + LETTER * place;
    add(svg, "line", {class: "event", x1: diagram.left, x2: x - 2, y1: px(y), y2: px(y)});
    add(svg, "text", {class: "small over", x, y: px(y + 3)}, letter);
  }
}

const FEW_POINTS = 40; // of a motion: each of them a mark of its own
const CLOUD = 1.4; // px: the height of a point in a cloud
const LAYERS = 1.3; // of points, spread over all values, that a cloud is as dark as

/* How opaque a point of a cloud is, so that it is equally dark with few turns and with many. */
function opacityOf(points) {
  const whole = wholeOf(state.quantity), view = state.y[1] - state.y[0];
  const height = diagram.height * (whole[1] - whole[0]) / view;
  return Math.min(0.6, LAYERS * height / (points * CLOUD));
}

function drawPoints(pen) {
  const [first, last, count] = data.speeds;
  const perRpm = diagram.width / (state.x[1] - state.x[0]);
  const perSpeed = perRpm * Math.abs(last - first) / Math.max(1, count - 1);
  const column = Math.max(1.2, Math.min(4, 0.9 * perSpeed));
  const dash = perSpeed < 5 ? perSpeed + SEAM : 4; // so close that a line is one
  for (const m of inDiagram) {
    if (!inView(m.rpm) || m.origin === "solved") continue;
    const [values, from, to] = pointsOf(m), few = to - from < FEW_POINTS;
    const high = few ? 2.2 : CLOUD, wide = few ? Math.max(2.2, dash) : column;
    pen.fillStyle = colours[m.colour];
    pen.globalAlpha = few ? 1 : opacityOf(to - from);
    const left = diagram.X(m.rpm) - wide / 2;
    for (let k = from; k < to; k++) pen.fillRect(left, diagram.Y(values[k]) - high / 2, wide, high);
  }
  pen.globalAlpha = 1;
  drawContact(pen, perSpeed);
}

/* A bar on the axis at the speeds at which the follower never leaves the cam. */
function drawContact(pen, perSpeed) {
  pen.fillStyle = colours.contact;
  for (const m of inDiagram) {
    if (m.label !== "contact" || !inView(m.rpm)) continue;
    const wide = perSpeed + SEAM;
    pen.fillRect(diagram.X(m.rpm) - wide / 2, diagram.bottom - BAR, wide, BAR);
  }
}
const BAR = 5, SEAM = 1; // px: its height, and what hides the seam between neighbours

/* Calls line(x0, y0, x1, y1) for every piece of a solved branch that is stable, or not. */
function forEachPiece(branch, quantity, stable, line) {
  const jump = quantity === "theta_deg" ? 40 : Infinity;
  for (const values of branch[quantity]) {
    for (let k = 1; k < branch.rpm.length; k++) {
      const alike = branch.stable[k] === stable && branch.label[k] === branch.label[k - 1];
      if (!alike || !(Math.abs(values[k] - values[k - 1]) < jump)) continue;
      const start = [diagram.X(branch.rpm[k - 1]), diagram.Y(values[k - 1])];
      line(...start, diagram.X(branch.rpm[k]), diagram.Y(values[k]), k);
    }
  }
}

/* A solved branch: stable parts solid, unstable ones dashed. */
function drawBranch(pen, branch, quantity) {
  for (const stable of [1, 0]) {
    pen.beginPath();
    let endX = NaN, endY = NaN;
    forEachPiece(branch, quantity, stable, (x0, y0, x1, y1) => {
      if (x0 !== endX || y0 !== endY) pen.moveTo(x0, y0);
      pen.lineTo(x1, y1);
      endX = x1;
      endY = y1;
    });
    pen.setLineDash(stable ? [] : [5, 4]);
    pen.lineWidth = stable ? 2 : 1.5;
    pen.strokeStyle = colours[branch.colour];
    pen.stroke();
  }
  pen.setLineDash([]);
}

/* The largest exponent below, positive in the colour of what never repeats. */
function drawStrip(pen, svg, width, height, right) {
  let low = -0.05, high = 0.05;
  for (const m of inDiagram) {
    if (!Number.isFinite(m.exponent)) continue;
    low = Math.min(low, m.exponent);
    high = Math.max(high, m.exponent);
  }
  low = Math.max(low, -1.5);
  const room = 0.1 * (high - low), exponents = [low - room, high + room];
  const axes = new Axes(svg, 46, height - 34 - 64, right, height - 34, state.x, exponents);
  axes.ticksY(2);
  axes.ticksX(Math.max(3, width / 90));
  for (const m of inDiagram) {
    if (m.exponent === null || !inView(m.rpm)) continue;
    pen.fillStyle = colours[m.colour];
    const x = axes.X(m.rpm) - 1;
    if (m.exponent < low) pen.fillRect(x, axes.bottom - 5, 2, 5);
    else pen.fillRect(x, axes.Y(m.exponent) - 1, 2, 2);
  }
  const zero = px(axes.Y(0));
  add(svg, "line", {class: "axis", x1: axes.left, x2: axes.right, y1: zero, y2: zero});
  axes.frame();
  add(svg, "text", {x: 4, y: axes.top - 5}, "largest exponent per turn");
}

const NUMBER_RADIUS = 8, BETWEEN_NUMBERS = 17; // px: of the discs, and from one to the next

/* Bifurcations: numbers above the diagram, a line down, a diamond where the orbit is. The numbers
   stand in a row right of the axis's symbol. */
function drawEvents(svg, height) {
  let edge = diagram.endOfSymbol + NUMBER_RADIUS + 3 - BETWEEN_NUMBERS;
  data.bifurcations.forEach((event, k) => {
    if (!inView(event.rpm)) return;
    const x = diagram.X(event.rpm), y = diagram.top - 14;
    event.at = edge = Math.max(x, edge + BETWEEN_NUMBERS);
    add(svg, "line", {class: "event", x1: px(x), x2: px(x), y1: diagram.top, y2: height - 34});
    add(svg, "line", {class: "axis", x1: px(x), x2: px(edge), y1: diagram.top, y2: diagram.top - 6});
    add(svg, "circle", {class: "number", cx: px(edge), cy: y, r: NUMBER_RADIUS});
    add(svg, "text", {class: "in-number", x: px(edge), y: y + 4, "text-anchor": "middle"}, k + 1);
    for (const value of event[QUANTITIES[state.quantity].branch] || []) {
      if (value < state.y[0] || value > state.y[1]) continue;
      add(svg, "path", {class: "diamond", d: `M${px(x - 5)} ${px(diagram.Y(value))}l5 -5l5 5l-5 5z`});
    }
  });
}

/* The chosen speed: a line with a handle, and rings around the points of its motion. */
function drawCursor() {
  const m = state.motion;
  if (!diagram || !m) return;
  const {cursor} = diagram, x = diagram.X(m.rpm);
  cursor.replaceChildren();
  if (x >= diagram.left && x <= diagram.right && isInDiagram(m)) {
    add(cursor, "line", {class: "cursor", x1: px(x), x2: px(x), y1: diagram.top, y2: diagram.bottom});
    const [values, from, to] = drawnPoints(m);
    for (let k = from; k < to && to - from <= 32; k++) {
      if (values[k] < state.y[0] || values[k] > state.y[1]) continue;
      add(cursor, "circle", {class: "ring", cx: px(x), cy: px(diagram.Y(values[k])), r: 6});
    }
    drawHandle(cursor, x);
  } else {
    drawAside(cursor, m.rpm);
  }
  tellSpeed(m);
  showSpeed(m);
  drawMarks();
}

/* The speed for those who do not see it; of a stop outside the diagram its value is the nearest. */
function tellSpeed(m) {
  const low = inDiagram[0].rpm, high = inDiagram[inDiagram.length - 1].rpm;
  const inside = Math.max(low, Math.min(high, m.rpm));
  set(host, {"aria-valuemin": low, "aria-valuemax": high, "aria-valuenow": inside,
    "aria-valuetext": `${speedWords(m.rpm)}, ${name(m)}`});
}

/* A speed outside the view: an arrow at that edge. */
function drawAside(cursor, rpm) {
  const isLower = rpm < state.x[0], isHigher = rpm > state.x[1];
  if (!isLower && !isHigher) return;
  const x = isLower ? diagram.left + 6 : diagram.right - 6, y = diagram.top + diagram.height / 2;
  const words = isLower ? `◂ now at ${short(rpm)} rpm` : `now at ${short(rpm)} rpm ▸`;
  drawLabel(cursor, words, x, y, isLower ? "start" : "end");
}

/* Words on a label, from x on or up to it. */
function drawLabel(parent, words, x, y, anchor) {
  const back = add(parent, "rect", {class: "label", y: px(y - 12), height: 17, rx: 3});
  const place = {x: px(x), y: px(y), "text-anchor": anchor};
  const text = add(parent, "text", {class: "drag-me", ...place}, words);
  const wide = text.getComputedTextLength() + 8;
  set(back, {x: px(anchor === "start" ? x - 4 : x - wide + 4), width: px(wide)});
}

function drawHandle(cursor, x) {
  const y = diagram.bottom;
  add(cursor, "circle", {class: "handle", cx: px(x), cy: px(y), r: 8});
  add(cursor, "path", {class: "grip", d: `M${px(x - 2)} ${px(y - 3)}v6M${px(x + 2)} ${px(y - 3)}v6`});
  if (state.dragged) return;
  const isAtTheRight = x > diagram.left + 0.8 * diagram.width;
  const anchor = isAtTheRight ? "end" : "start", aside = isAtTheRight ? -13 : 13;
  drawLabel(cursor, "◂ drag me ▸", x + aside, y - 6, anchor);
}

/* The points of a motion as rings show them. */
function drawnPoints(m) {
  const points = pointsOf(m);
  return m.origin === "solved" || points[1] === points[2] ? simulatedPoints(m) : points;
}
