/* ---- the machine ---- */

const RADIUS_OF_BALL = 12; // px
const FOLLOWER_HEIGHT = 82; // px, from its tip to its top, in a drawing of usual height
const ROOM_ABOVE = 120, ROOM_OF_A_BALL = 40; // px above the highest place of the tip
const MASS_WIDTH = 44, MASS_HEIGHT = 22; // px
const TABLE_WIDTH = 120; // px, under a ball
const USUAL_HEIGHT = 300, USUAL_WIDTH = 330; // px
const LARGEST = 1.6; // a follower grows with its drawing, up to so much

function drawMachine() {
  const m = state.motion, {svg, width, height} = emptied("machine");
  const body = data.outline, isBall = body.flat && !data.follower.stiffness;
  // a cam lifts less than a valve behind a rocker
  const radius = lift => lift / body.ratio + body.rise;
  const size = Math.max(1, Math.min(LARGEST, height / USUAL_HEIGHT, width / USUAL_WIDTH));
  const scale = scaleOf(m, width, height - size * (isBall ? ROOM_OF_A_BALL : ROOM_ABOVE), radius);
  const reach = reachOfCam(), y = height - 8 - reach * scale;
  machine = {scale, x: width / 2, y, radius, isBall, width, height, size};
  const centre = {cx: "35%", cy: "30%", r: "80%"};
  const shine = add(add(svg, "defs"), "radialGradient", {id: "shine", ...centre});
  add(shine, "stop", {offset: "0", "stop-color": "var(--shine)"});
  add(shine, "stop", {offset: "1", "stop-color": "var(--steel)"});
  machine.moving = add(svg, "g");
  drawGuide(svg);
  drawCam(reach);
  drawFollower(svg);
  machine.flash = add(svg, "circle", {class: "flash"});
  machine.angle = add(svg, "text", {class: "small", x: 4, y: height - 6});
  drawScaleBar(svg);
  drawArrows();
  drawKey(svg);
  drawLens(svg);
}

function reachOfCam() {
  const {x, y} = data.outline;
  let reach = 0;
  for (let k = 0; k < x.length; k++) reach = Math.max(reach, Math.hypot(x[k], y[k]));
  return reach;
}

/* Pixels per metre, so that the whole motion is seen, or the cam alone in a close-up. */
function scaleOf(m, width, height, radius) {
  const reach = reachOfCam();
  if (state.close) return Math.min(width - 16, height / 1.15) / (2 * reach);
  let top = -Infinity;
  for (let k = m.row; k < m.row + m.rows; k++) top = Math.max(top, data.rows.q[k]);
  for (const lift of data.cam.c) top = Math.max(top, lift);
  const whole = (height - 16) / (reach + Math.max(reach, radius(top)));
  return Math.min(whole, (width - 16) / (2 * reach));
}

function drawCam(reach) {
  const {scale, radius, x, y} = machine, body = data.outline;
  const cam = machine.cam = add(machine.moving, "g", {id: "cam"});
  const point = (r, angle) => `${px(r * Math.sin(angle) * scale)} ${px(-r * Math.cos(angle) * scale)}`;
  const outline = [...body.x].map((across, k) => `${px(across * scale)} ${px(-body.y[k] * scale)}`);
  add(cam, "path", {class: "metal shining", d: `M${outline.join("L")}Z`});
  machine.letters = Object.entries(isSmall() ? {} : data.corners).map(([letter, degrees]) => {
    const angle = degrees * Math.PI / 180, r = radius(camAt(degrees)[0]);
    const inside = r - LETTER_INSIDE / scale;
    add(cam, "path", {class: "lines on-metal", d: `M${point(r, angle)}L${point(r - 9 / scale, angle)}`});
    const place = {x: px(inside * Math.sin(angle) * scale), y: px(-inside * Math.cos(angle) * scale)};
    const centred = {"text-anchor": "middle", "dominant-baseline": "central"};
    return add(cam, "text", {class: "corner", ...place, ...centred}, letter);
  });
  machine.trace = null;
  if (!body.flat) {
    const kinds = ["flight", "rest"];
    machine.trace = kinds.map(kind => add(cam, "path", {class: `lines ${kind} trace`}));
  }
  add(cam, "path", {class: "lines on-metal", d: `M0 0V${px(-0.5 * reach * scale)}`});
  add(cam, "circle", {class: "frame", r: px(Math.max(5, Math.min(11, 0.07 * reach * scale)))});
  const axle = add(machine.moving, "g", {transform: `translate(${px(x)} ${px(y)})`});
  add(axle, "circle", {r: 2.5, fill: "var(--paper)"});
  drawRotation(axle, radiusOfRotation(reach));
}

const LETTER_INSIDE = 18; // px from a corner of the cam to the middle of its letter
const LARGEST_ROTATION = 34, LEAST_ROTATION = 16, BESIDE_A_LETTER = 14; // px

/* The radius of the arrow around the axle: within the letters on the cam, or outside the cam. */
function radiusOfRotation(reach) {
  const {scale, radius} = machine, outside = reach * scale + 9;
  if (isSmall()) return outside;
  let inside = Math.min(LARGEST_ROTATION, 0.45 * reach * scale);
  for (const degrees of Object.values(data.corners)) {
    const letter = radius(camAt(degrees)[0]) * scale - LETTER_INSIDE;
    inside = Math.min(inside, letter - BESIDE_A_LETTER);
  }
  return inside < LEAST_ROTATION ? outside : inside;
}

/* Whether the cam is drawn so small that letters on it would cover each other. */
function isSmall() {
  return reachOfCam() * machine.scale < 80;
}

/* An arrow around the axle, the way the cam turns: against the clock. */
function drawRotation(axle, r) {
  const place = degrees => {
    const angle = degrees * Math.PI / 180;
    return `${px(r * Math.cos(angle))} ${px(-r * Math.sin(angle))}`;
  };
  const start = place(-50), end = place(50), turned = `translate(${end}) rotate(-45)`;
  add(axle, "path", {class: "lines turning", d: `M${start}A${px(r)} ${px(r)} 0 0 0 ${end}`});
  add(axle, "path", {class: "turning-head", d: "M0 -9L4 3L-4 3Z", transform: turned});
}

/* What does not move: two walls in which the follower's mass slides, and the spring's end above.
   A ball has neither. */
function drawGuide(svg) {
  if (machine.isBall) return;
  const {x, y, scale, radius, size} = machine, guide = add(svg, "g", {class: "guide"});
  let least = Infinity;
  for (const c of data.cam.c) least = Math.min(least, c);
  const bottom = y - radius(least) * scale - (FOLLOWER_HEIGHT - MASS_HEIGHT - 6) * size;
  for (const side of [-1, 1]) {
    const wall = x + side * (MASS_WIDTH / 2 * size + 3);
    let path = `M${px(wall)} 0V${px(bottom)}`;
    for (let down = 6; down < bottom; down += 7) path += `M${px(wall)} ${down}l${6 * side} -6`;
    add(guide, "path", {class: "lines axis", d: path});
  }
  const half = MASS_WIDTH / 2 * size + 3;
  add(guide, "rect", {class: "frame", x: px(x - half), y: 0, width: px(2 * half), height: 5});
}

function drawFollower(svg) {
  const {isBall} = machine, body = data.outline;
  const follower = machine.follower = add(machine.moving, "g", {id: "follower"});
  if (isBall) {
    add(follower, "circle", {class: "metal shining", cy: -RADIUS_OF_BALL, r: RADIUS_OF_BALL});
    const table = {x: -TABLE_WIDTH / 2, width: TABLE_WIDTH, height: 9, rx: 2};
    machine.table = add(machine.moving, "rect", {class: "metal", ...table});
  } else {
    if (body.flat) add(follower, "rect", {class: "metal", x: -20, y: -7, width: 40, height: 7, rx: 1});
    else add(follower, "path", {class: "metal", d: "M0 0L-7 -14V-18H7V-14Z"});
    add(follower, "rect", {class: "metal", x: -7, y: -62, width: 14, height: body.flat ? 55 : 46});
    const mass = {x: -MASS_WIDTH / 2, y: -FOLLOWER_HEIGHT, width: MASS_WIDTH, height: MASS_HEIGHT};
    add(follower, "rect", {class: "metal shining", ...mass, rx: 3});
  }
  if (data.follower.stiffness) {
    let spring = "M0 0";
    for (let k = 0; k < 12; k++) spring += `L${k % 2 ? -13 : 13} ${(k + 0.5) * 100 / 12}`;
    machine.spring = add(machine.moving, "path", {class: "spring", d: `${spring}L0 100`});
  }
  machine.tip = add(follower, "circle", {class: "tip", r: 5});
}

/* A round length of some 60 px, with its text. */
function drawScaleBar(svg) {
  const {scale, width, height} = machine, rough = 60 / scale;
  const power = 10 ** Math.floor(Math.log10(rough));
  const length = [1, 2, 5, 10].map(n => n * power).findLast(round => round <= rough * 1.0001) || power;
  const {unit, factor} = lengths(length), words = `${short(length * factor)} ${unit}`;
  add(svg, "text", {class: "small", x: width - 4, y: height - 6, "text-anchor": "end"}, words);
  const left = px(width - 4 - length * scale);
  add(svg, "path", {class: "lines axis", d: `M${left} ${height - 20}v-5v5H${width - 4}v-5`});
}

function moveMachine(m, now) {
  const {x, y, scale, radius, size} = machine, tip = y - radius(now.q) * scale;
  const surface = y - radius(now.c) * scale;
  set(machine.cam, {transform: `translate(${px(x)} ${px(y)}) rotate(${(-now.phase).toFixed(4)})`});
  for (const letter of machine.letters) { // they stay upright
    const place = `${letter.getAttribute("x")} ${letter.getAttribute("y")}`;
    set(letter, {transform: `rotate(${now.phase.toFixed(2)} ${place})`});
  }
  set(machine.follower, {transform: `translate(${px(x)} ${px(tip)}) scale(${size})`});
  if (machine.table) set(machine.table, {transform: `translate(${px(x)} ${px(surface)})`});
  if (machine.spring) {
    const stretch = Math.max(0.02, (tip - FOLLOWER_HEIGHT * size - 5) / 100);
    const scaled = `scale(${size} ${stretch.toFixed(5)})`;
    set(machine.spring, {transform: `translate(${px(x)} 5) ${scaled}`});
  }
  machine.tip.style.display = now.rests ? "" : "none";
  machine.angle.textContent = angleWords(m, now.phase);
  moveArrows(m, now, tip);
  moveLens(now);
  drawFlash(m, x, surface);
}

/* The path of the tip over the cam, of the turns in sight, in the cam's own frame. */
function drawTrace() {
  if (!machine.trace) return;
  const m = state.motion, [from, to] = time.span, paths = ["", ""];
  const steps = Math.ceil((to - from) * 180);
  let last = -1;
  for (let k = 0; k <= steps; k++) {
    const now = at(m, Math.min(from + (to - from) * k / steps, m.end)), mode = Number(now.rests);
    const r = machine.radius(now.q) * machine.scale, angle = now.phase * Math.PI / 180;
    const place = `${px(r * Math.sin(angle))} ${px(-r * Math.cos(angle))}`;
    if (last >= 0 && mode !== last) paths[last] += `L${place}`;
    paths[mode] += (mode === last ? "L" : "M") + place;
    last = mode;
  }
  machine.trace.forEach((path, mode) => path.setAttribute("d", paths[mode]));
}

/* The cam's angle, and the turn of a motion that has several. */
function angleWords(m, phase) {
  const turn = Math.min(Math.floor(state.t) + 1, m.turns);
  return `θ ${phase.toFixed(1)}°` + (m.turns > 1 ? `, turn ${turn} of ${m.turns}` : "");
}

/* A ring where the follower has just struck, larger after a harder impact. */
const FADE = 0.06; // turns
function drawFlash(m, x, y) {
  const age = agoStruck(m, state.t) / FADE;
  machine.flash.style.display = age < 1 ? "" : "none";
  if (!(age < 1)) return;
  const k = before(data.events.t, m.event, m.event + m.events, state.t);
  const hardness = Math.sqrt(Math.abs(data.events.u[k]) / largestImpact(m));
  const r = px(4 + (6 + 22 * hardness) * age);
  set(machine.flash, {cx: px(x), cy: px(y), r, opacity: px(1 - age)});
}
