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

function drawMotion() {
  drawTime();
  drawPhase();
  drawMachine();
  drawTrace();
  drawNow();
}

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
    `${fixed(u, decimalsOf(largestImpact(m)))} m/s`,
    `${fixed(now.force, decimalsOf(time.lower.y[1]))} N`,
  ];
  texts.forEach((text, k) => { cells[k].textContent = text; });
}

const END = 0.15; // turns in which a record that does not repeat fades

/* From 0 to 1: a record whose end is not its beginning fades out, and in again. */
function clearness(m, t) {
  if (m.loops || !state.playing) return 1;
  return Math.max(0, Math.min(1, (m.end - t) / END, t / END + 0.05));
}
