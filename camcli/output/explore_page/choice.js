/* ---- which motion is shown ---- */

const state = {
  motion: null, t: 0, // turns after the strobe
  playing: false, pace: 4, // seconds per turn
  close: false, lens: "auto", sound: false, presents: false,
  quantity: "theta", x: null, y: null, // the view of the diagram
  wanted: undefined, // rpm that was asked for, where the nearest computed one is shown
  dragged: false,
};
let machine, time, phase, diagram;

function choose(m, t = 0) {
  state.motion = m;
  state.t = Math.min(t, m.end);
  drawMotion();
  drawCursor();
  sayWhatIsShown(m);
  showPace();
  $("command").textContent = command(m);
  chooseAmong(m);
  markStop(m);
  keepLink();
}

/* Whether the cam fills the machine's panel; else the whole motion is seen. */
function setClose(isClose) {
  state.close = isClose;
  set($("close"), {"aria-pressed": isClose});
}

function sayWhatIsShown(m) {
  const {wanted} = state, isNear = wanted !== undefined && Math.abs(wanted - m.rpm) > 1e-9 * m.rpm;
  const near = isNear ? `computed, nearest to ${speedWords(Number(wanted.toPrecision(6)))}` : "";
  state.wanted = undefined;
  const strong = text => make("strong", {textContent: text});
  const value = exponent(m), source = SOURCES[m.origin];
  const endings = [[near, exponentWords(m), source], [near, value, source], [near, value], [near]];
  tails = endings.map(parts => parts.filter(Boolean).join("; "));
  const faint = make("span", {textContent: tails[0], className: "faint"});
  const [number, ...unit] = speedWords(m.rpm).split(" "), label = strong(name(m));
  const speed = strong(number);
  $("said").replaceChildren(speed, ` ${unit.join(" ")}: `, label, `, ${words(m)}. `, faint);
  $("said").title = $("said").textContent;
  fitSaid();
}

let tails = [""]; // what may follow the sentence on the motion, from the longest to the shortest

/* As much behind that sentence as its line has room for. */
function fitSaid() {
  const said = $("said"), faint = said.querySelector(".faint");
  said.classList.remove("long");
  for (const tail of faint ? tails : []) {
    faint.textContent = tail;
    if (said.scrollWidth <= said.clientWidth) return;
  }
  said.classList.add("long");
}

/* The motions at about one speed. Of those with one label and stability, these are the ones at the
   nearest speed: others are the same motion a little further on, solved or swept. */
function motionsAt(m) {
  if (!isInDiagram(m)) return [];
  const [first, last, count] = data.speeds, step = Math.abs(last - first) / Math.max(1, count - 1);
  const alike = new Map();
  for (const other of inDiagram) {
    const away = Math.abs(other.rpm - m.rpm);
    if (away > 0.51 * step && other !== m) continue;
    const key = `${other.label} ${other.stable}`, known = alike.get(key) || [];
    const nearest = known.length > 0 ? Math.abs(known[0].rpm - m.rpm) : Infinity;
    if (away < nearest) alike.set(key, [other]);
    else if (other.rpm === known[0].rpm) known.push(other);
  }
  const isUnstable = other => Number(other.stable === false);
  const inOrder = (a, b) => isUnstable(a) - isUnstable(b) || a.number - b.number;
  return [...alike.values()].flat().sort(inOrder);
}

function chooseAmong(m) {
  const all = motionsAt(m);
  const buttons = all.map(other => {
    const chooseOther = () => {
      choose(other, state.t % 1);
      focusChosen();
    };
    const isChosen = other === m, tabIndex = isChosen ? 0 : -1;
    const properties = {type: "button", textContent: name(other), onclick: chooseOther, tabIndex};
    return make("button", properties, {role: "radio", "aria-checked": isChosen});
  });
  const alone = make("span", {textContent: "no other motion on this page", className: "faint"});
  $("choices").replaceChildren(...(all.length > 1 ? buttons : [alone]));
}

function focusChosen() {
  const button = $("choices").querySelector("[aria-checked=true]");
  if (button) button.focus();
}

function nextMotion(step) {
  const all = motionsAt(state.motion), k = all.indexOf(state.motion);
  if (all.length > 1) choose(all[(k + step + all.length) % all.length], state.t % 1);
}

/* Of motions at one speed, the one that goes on from another. */
function goesOn(from, there) {
  return there.find(m => m.label === from.label && m.origin === from.origin)
    || there.find(m => m.label === from.label)
    || there.find(m => m.origin === "fixed")
    || there[0];
}

function nextSpeed(step) {
  const way = Math.sign(step);
  let m = state.motion;
  for (let n = 0; n < Math.abs(step); n++) {
    const beyond = inDiagram.filter(other => other.kin === m.kin && way * (other.rpm - m.rpm) > 0);
    if (beyond.length === 0) break;
    const rpm = way > 0 ? beyond[0].rpm : beyond[beyond.length - 1].rpm;
    m = goesOn(m, beyond.filter(other => other.rpm === rpm));
  }
  if (!isInDiagram(m)) m = motionAtSpeed(m.rpm);
  choose(m, state.t % 1);
  followChosen();
}

/* Speeds that sweeps have computed, for the slider. */
const speeds = [...new Set(inDiagram.filter(m => m.origin !== "solved").map(m => m.rpm))];
if (speeds.length === 0) speeds.push(...new Set(inDiagram.map(m => m.rpm)));

function nearestSpeed(rpm) {
  let best = 0;
  speeds.forEach((speed, k) => {
    if (Math.abs(speed - rpm) < Math.abs(speeds[best] - rpm)) best = k;
  });
  return best;
}

/* The motion at the computed speed that is nearest, going on from the chosen one. */
function motionAtSpeed(rpm) {
  const speed = speeds[nearestSpeed(rpm)], there = inDiagram.filter(m => m.rpm === speed);
  const stable = there.filter(m => m.stable !== false);
  return goesOn(state.motion, stable.length > 0 ? stable : there);
}

function showSpeed(m) {
  const slider = $("speed");
  slider.value = nearestSpeed(m.rpm);
  set(slider, {"aria-valuetext": speedWords(m.rpm)});
  const ofCrankToo = data.crank ? `, crank ${ofCrank(m.rpm, data)}` : "";
  $("rpm").textContent = `${short(m.rpm)} rpm${ofCrankToo}`;
}

/* What is shown first: the middle of the speeds, rather a motion that is not unstable. */
function first() {
  const middle = (data.speeds[0] + data.speeds[1]) / 2;
  const stable = inDiagram.filter(m => m.stable !== false);
  const pool = stable.length > 0 ? stable : inDiagram;
  const nearer = (best, m) => Math.abs(m.rpm - middle) < Math.abs(best.rpm - middle) ? m : best;
  return pool.reduce(nearer, pool[0]);
}
