/* ---- the diagram: how it is used ---- */

const LINE_REACH = 6; // px: so near to the line of a stable branch, the branch is what is meant

/* The motion at a place in the diagram: of the stable branch whose line is there, or else the one
   that has a point nearest to it. */
function motionNear(x, y) {
  const m = nearestTo(x, y, motionOfLine(stableLineNear(x, y)));
  return m || nearestTo(x, y, () => true);
}

/* The label of the stable branch that goes through a place, or null. */
function stableLineNear(x, y) {
  let label = null, nearest = LINE_REACH;
  for (const branch of data.branches) {
    forEachPiece(branch, QUANTITIES[state.quantity].branch, 1, (x0, y0, x1, y1, k) => {
      const far = distanceToLine([x, y], [x0, y0], [x1, y1]);
      if (far < nearest) {
        nearest = far;
        label = branch.label[k];
      }
    });
  }
  return label;
}

function motionOfLine(label) {
  return m => m.label === label && m.stable !== false;
}

/* The motion with a point nearest to a place, of those at about its speed that are `wanted`. */
function nearestTo(x, y, wanted) {
  const rpm = diagram.fromX(x), pool = inDiagram.filter(wanted);
  let closest = Infinity;
  for (const m of pool) closest = Math.min(closest, Math.abs(m.rpm - rpm));
  const pixels = (state.x[1] - state.x[0]) / diagram.width;
  const reach = Math.max(closest * 1.0001, 5 * pixels);
  let best = null, least = Infinity;
  for (const m of pool) {
    const aside = Math.abs(m.rpm - rpm);
    if (aside > reach) continue;
    const [values, from, to] = m.origin === "solved" ? simulatedPoints(m) : pointsOf(m);
    let above = from === to ? 60 : Infinity;
    for (let k = from; k < to; k++) above = Math.min(above, Math.abs(diagram.Y(values[k]) - y));
    const distance = Math.hypot(aside / reach * 5, above);
    if (distance < least) {
      least = distance;
      best = m;
    }
  }
  return best;
}

/* Zoom about a place in pixels. */
function zoom(factor, x, y) {
  const speed = diagram.fromX(x), value = diagram.fromY(y);
  state.x = state.x.map(v => speed + (v - speed) * factor);
  state.y = state.y.map(v => value + (v - value) * factor);
  changeView();
}

/* Zoom about the chosen motion, or about the middle where it is out of sight. */
function zoomAboutChosen(factor) {
  const m = state.motion, middle = (diagram.top + diagram.bottom) / 2;
  if (!isInDiagram(m) || !inView(m.rpm)) {
    zoom(factor, (diagram.left + diagram.right) / 2, middle);
    return;
  }
  const [values, from, to] = drawnPoints(m), seen = [];
  for (let k = from; k < to; k++) {
    if (values[k] >= state.y[0] && values[k] <= state.y[1]) seen.push(diagram.Y(values[k]));
  }
  seen.sort((a, b) => Math.abs(a - middle) - Math.abs(b - middle));
  zoom(factor, diagram.X(m.rpm), seen.length > 0 ? seen[0] : middle);
}

function pan(dx, dy) {
  const wide = (state.x[1] - state.x[0]) / diagram.width;
  const high = (state.y[1] - state.y[0]) / diagram.height;
  state.x = state.x.map(v => v - dx * wide);
  state.y = state.y.map(v => v + dy * high);
  changeView();
}

/* Move the view along the speeds until it holds the chosen one. */
function followChosen() {
  const m = state.motion;
  if (!isInDiagram(m) || inView(m.rpm)) return;
  const half = (state.x[1] - state.x[0]) / 2;
  state.x = [m.rpm - half, m.rpm + half];
  changeView();
}

function showWhole() {
  Object.assign(state, wholeView());
  changeView();
}

let drawsSoon = false;
function changeView() {
  hideHint();
  if (drawsSoon) return;
  drawsSoon = true;
  requestAnimationFrame(() => {
    drawsSoon = false;
    drawDiagram();
    keepLink();
  });
}

function hideHint() {
  $("hint").hidden = true;
}

/* ---- pointers ---- */

const pointers = new Map(); // those that are down: the place of each
const grasp = {moved: 0, scrubs: false};
const CLICK = 4; // px: what moves less is a click

const FINGER = matchMedia("(pointer: coarse)").matches ? 20 : 9; // px: what a number is hit by

function showsAllSpeeds() {
  const whole = wholeView().x;
  return state.x[0] <= whole[0] + 1e-9 && state.x[1] >= whole[1] - 1e-9;
}

/* Choose the speed at a place, and there the motion that goes on from the chosen one. */
function scrub(x, y) {
  state.dragged = true;
  const wanted = diagram.fromX(Math.max(diagram.left, Math.min(diagram.right, x)));
  const m = motionAtSpeed(wanted);
  if (m !== state.motion) choose(m, state.t % 1);
}

function startPointer(event) {
  const [x, y] = pointerIn(host, event);
  pointers.set(event.pointerId, [x, y]);
  host.setPointerCapture(event.pointerId);
  grasp.moved = 0;
  const m = state.motion, isOnCursor = isInDiagram(m) && Math.abs(diagram.X(m.rpm) - x) < 12;
  grasp.scrubs = isOnCursor || showsAllSpeeds();
}

function movePointer(event) {
  const [x, y] = pointerIn(host, event), from = pointers.get(event.pointerId);
  if (!from) {
    showHint(x, y);
    return;
  }
  hideHint();
  grasp.moved += Math.hypot(x - from[0], y - from[1]);
  pointers.set(event.pointerId, [x, y]);
  if (pointers.size === 2) pinch(event.pointerId, from, [x, y]);
  else if (grasp.moved > CLICK && grasp.scrubs) scrub(x, y);
  else if (grasp.moved > CLICK) pan(x - from[0], event.pointerType === "touch" ? 0 : y - from[1]);
}

function pinch(moving, from, to) {
  const [fixed] = [...pointers].filter(([id]) => id !== moving).map(([, place]) => place);
  const wasApart = Math.hypot(from[0] - fixed[0], from[1] - fixed[1]);
  const isApart = Math.hypot(to[0] - fixed[0], to[1] - fixed[1]);
  if (wasApart > 0 && isApart > 0) zoom(wasApart / isApart, fixed[0], fixed[1]);
}

function endPointer(event) {
  const [x, y] = pointerIn(host, event), isClick = pointers.size === 1 && grasp.moved <= CLICK;
  pointers.delete(event.pointerId);
  if (!isClick) return;
  const numbered = numberAt(x, y);
  if (numbered) {
    goTo(numbered);
    return;
  }
  const m = motionNear(x, y);
  if (!m) return;
  state.wanted = diagram.fromX(Math.max(diagram.left, Math.min(diagram.right, x)));
  choose(m);
}

host.addEventListener("pointerdown", startPointer);
host.addEventListener("pointermove", movePointer);
host.addEventListener("pointerup", endPointer);
host.addEventListener("pointercancel", event => pointers.delete(event.pointerId));
host.addEventListener("pointerleave", hideHint);
host.addEventListener("dblclick", event => zoom(0.5, ...pointerIn(host, event)));
host.addEventListener("wheel", event => {
  if (!event.ctrlKey && !event.metaKey && document.activeElement !== host) return;
  event.preventDefault();
  zoom(Math.exp(event.deltaY * 0.0015), ...pointerIn(host, event));
}, {passive: false});

/* The bifurcation whose number is at a place. */
function numberAt(x, y) {
  if (Math.abs(y - diagram.top + 14) >= FINGER + 3) return undefined;
  const seen = data.bifurcations.filter(event => inView(event.rpm));
  const away = event => Math.abs(event.at - x);
  return seen.filter(event => away(event) < FINGER).sort((a, b) => away(a) - away(b))[0];
}

function showHint(x, y) {
  const hint = $("hint"), event = numberAt(x, y);
  const m = !event && diagram.holds(x, y) ? motionNear(x, y) : null;
  hint.hidden = !event && !m;
  if (hint.hidden) return;
  if (event) {
    hint.textContent = eventWords(event);
  } else {
    hint.textContent = [`${speedWords(m.rpm)}: ${name(m)}`, exponent(m)].filter(Boolean).join("; ");
  }
  hint.style.left = 0; // else its lines break as where it stood before
  const box = hint.getBoundingClientRect(), most = boxOf(host).width * letters - box.width;
  hint.style.left = `${Math.max(0, Math.min(letters * x + 14, most))}px`;
  hint.style.top = `${Math.max(0, letters * y - box.height - 12)}px`;
}

/* Choose the motion nearest to a bifurcation, and show what is around it. */
function goTo(event) {
  let best = inDiagram[0];
  for (const m of inDiagram) {
    const closer = Math.abs(m.rpm - event.rpm) - Math.abs(best.rpm - event.rpm);
    if (closer < 0 || (closer === 0 && m.label === event.label)) best = m;
  }
  state.wanted = event.rpm;
  choose(best);
  zoomTo(event);
}

/* A twelfth of all speeds around a bifurcation, and a quarter of all values. */
function zoomTo(event) {
  const whole = wholeView(), values = event[QUANTITIES[state.quantity].branch] || [];
  const half = (whole.x[1] - whole.x[0]) / 24;
  state.x = [event.rpm - half, event.rpm + half];
  state.y = whole.y;
  if (values.length > 0) {
    const low = Math.min(...values), high = Math.max(...values);
    const room = Math.max((whole.y[1] - whole.y[0]) / 4 - (high - low), 0.2 * (high - low)) / 2;
    state.y = [low - room, high + room];
  }
  changeView();
}

/* ---- keys ---- */

host.addEventListener("keydown", event => {
  const actions = {
    ArrowLeft: () => nextSpeed(event.shiftKey ? -10 : -1),
    ArrowRight: () => nextSpeed(event.shiftKey ? 10 : 1),
    ArrowUp: () => nextMotion(1),
    ArrowDown: () => nextMotion(-1),
    "+": () => zoomAboutChosen(0.6),
    "=": () => zoomAboutChosen(0.6),
    "-": () => zoomAboutChosen(1 / 0.6),
    "0": showWhole,
  };
  if (!actions[event.key] || event.ctrlKey || event.metaKey) return;
  event.preventDefault();
  hideHint();
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
  const typesElsewhere = event.target.closest("input, select, summary, a");
  if (typesElsewhere || event.ctrlKey || event.metaKey || event.altKey) return;
  if (event.key === " " && !event.target.closest("button")) {
    event.preventDefault();
    play(!state.playing);
  }
  if (event.key === "n" && !$("onward").hidden) goOnward();
  if (event.key === "f") present(!state.presents);
  if (event.key === ",") step(-1);
  if (event.key === ".") step(1);
});
