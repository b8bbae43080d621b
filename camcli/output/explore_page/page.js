/* ---- what is shown ---- */

const state = {motion: null, t: 0, playing: false, pace: 4, close: false, quantity: "theta", x: null, y: null};
let machine, time, phase, diagram;

function choose(m, t = 0) {
  state.motion = m;
  state.t = Math.min(t, m.end);
  drawMotion();
  drawCursor();
  const wanted = state.wanted;
  const near = wanted !== undefined && Math.abs(wanted - m.rpm) > 1e-9 * m.rpm
    ? ` (computed, nearest to ${short(Number(wanted.toPrecision(6)))})` : "";
  state.wanted = undefined;
  $("said").replaceChildren(strong(`${short(m.rpm)} rpm`), `${near}: `, strong(name(m)), `, ${words(m)}. `, faint([exponent(m), SOURCES[m.origin]].filter(Boolean).join("; ")));
  $("command").textContent = command(m);
  chooseAmong(m);
  keepLink();
}
const strong = text => Object.assign(document.createElement("strong"), {textContent: text});
const faint = text => Object.assign(document.createElement("span"), {textContent: text, className: "faint"});

function command(m) {
  const value = x => x === null ? "null" : String(x);
  const start = `{q: ${value(m.q)}, v: ${value(m.v)}, theta_deg: ${data.strobe_deg}}`;
  const sets = Object.entries(m.sets).map(([key, value]) => `--set ${key}=${value}`);
  return ["cam simulate", data.source, `--rpm ${m.rpm}`, ...sets, `--set run.transient=0 --set run.record=${m.turns}`,
    `--set 'run.start=${start}'`].filter(Boolean).join(" ");
}

/* The motions at about one speed. Of those with one label and stability, these are the ones at the
   nearest speed: others are the same motion a little further on, solved or swept. */
function motionsAt(m) {
  if (m.place) return [];
  const [low, high, count] = data.speeds, step = Math.abs(high - low) / Math.max(1, count - 1);
  const alike = new Map();
  for (const other of inDiagram) {
    const away = Math.abs(other.rpm - m.rpm);
    if (away > 0.51 * step && other !== m) continue;
    const key = [other.label, other.stable].join();
    const known = alike.get(key) ?? [];
    const nearest = known.length ? Math.abs(known[0].rpm - m.rpm) : Infinity;
    if (away < nearest) alike.set(key, [other]);
    else if (other.rpm === known[0]?.rpm) known.push(other);
  }
  return [...alike.values()].flat().sort((a, b) => (a.stable === false) - (b.stable === false) || a.number - b.number);
}

function chooseAmong(m) {
  const all = motionsAt(m);
  $("choices").replaceChildren(...(all.length < 2 ? [] : all.map(other => {
    const button = Object.assign(document.createElement("button"), {type: "button", textContent: name(other), onclick: () => { choose(other); focusChosen(); }});
    button.setAttribute("role", "radio");
    button.setAttribute("aria-checked", other === m);
    button.tabIndex = other === m ? 0 : -1;
    return button;
  })));
}
const focusChosen = () => $("choices").querySelector("[aria-checked=true]")?.focus();

function nextMotion(step) {
  const all = motionsAt(state.motion), k = all.indexOf(state.motion);
  if (all.length > 1) choose(all[(k + step + all.length) % all.length], state.t % 1);
}

function nextSpeed(step) {
  const m = state.motion, way = Math.sign(step);
  let at = m.place ? inDiagram[0] : m;
  for (let n = 0; n < Math.abs(step); n++) {
    const beyond = inDiagram.filter(other => other.kin === at.kin && way * (other.rpm - at.rpm) > 0);
    if (!beyond.length) break;
    const rpm = way > 0 ? beyond[0].rpm : beyond[beyond.length - 1].rpm;
    const here = beyond.filter(other => other.rpm === rpm);
    at = here.find(other => other.label === at.label && other.origin === at.origin) || here.find(other => other.label === at.label)
      || here.find(other => other.origin === "fixed") || here[0];
  }
  choose(at, state.t % 1);
}

/* ---- play ---- */

function pace() {
  state.pace = 0.4 * 10 ** ((100 - $("pace").value) / 50); // seconds per turn: 40 to 0.4
  const slower = state.pace * state.motion.rpm / 60;
  $("slowed").textContent = slower < 0.95 ? `${(1 / slower).toPrecision(2)}× faster` : `${Number(slower.toPrecision(2))}× slower`;
}

let last = null;
function frame(clock) {
  if (state.playing && last !== null) {
    state.t += Math.min(clock - last, 100) / 1000 / state.pace;
    if (state.t >= state.motion.end) state.t = state.motion.end > 0 ? state.t % state.motion.end : 0;
    drawNow();
  }
  last = clock;
  requestAnimationFrame(frame);
}

function play(on) {
  state.playing = on;
  $("play").textContent = on ? "Pause" : "Play";
  if (!on) keepLink();
}

function step(way) {
  const m = state.motion, times = [...data.events.t.subarray(m.event, m.event + m.events)].filter(t => t <= m.end);
  play(false);
  if (!times.length) return;
  const tiny = 1e-6;
  const next = way > 0 ? times.find(t => t > state.t + tiny) : times.findLast(t => t < state.t - tiny);
  state.t = next === undefined ? (way > 0 ? times[0] : times[times.length - 1]) : next;
  drawNow();
  const k = m.event + times.indexOf(state.t), u = data.events.u[k];
  $("copied").textContent = "";
  machine.angle.textContent = `θ ${phaseAt(state.t).toFixed(1)}°: ${KINDS[data.events.kind[k]]}${u ? `, u⁻ ${fixed(u, 3)} m/s` : ""}`;
  keepLink();
}

/* ---- links, commands, pictures ---- */

let linkLater = 0;
function keepLink() {
  clearTimeout(linkLater);
  linkLater = setTimeout(() => history.replaceState(null, "", "#" + link()), 150);
}

function link() {
  const m = state.motion, parts = {rpm: m.rpm, label: m.label, from: m.origin};
  if (!state.playing) parts.t = Number(state.t.toFixed(6));
  if (m.stable === false) parts.unstable = 1;
  if (m.q !== null) parts.q = m.q;
  if (m.place) parts.place = m.place.join("_");
  if (state.quantity !== "theta") parts.show = state.quantity;
  if (state.x) parts.view = [...state.x, ...state.y].map(v => Number(v.toPrecision(8))).join("_");
  if (state.close) parts.close = 1;
  return new URLSearchParams(parts).toString();
}

/* The motion that a fragment names: the nearest speed, then what agrees most. */
function linked(parts) {
  const rpm = Number(parts.get("rpm"));
  if (!parts.has("rpm") || !Number.isFinite(rpm)) return null;
  const plane = data.planes.find(p => p.of === parts.get("from")), pool = plane && plane.motions.length ? plane.motions : inDiagram;
  const place = (parts.get("place") || "").split("_").map(Number);
  const unlike = m => (m.label !== parts.get("label")) + (m.origin !== parts.get("from")) + ((m.stable === false) !== parts.has("unstable"));
  const away = m => [Math.abs(m.rpm - rpm), parts.has("label") ? unlike(m) : 0, parts.has("q") ? Math.abs(m.q - parts.get("q")) : 0, m.place && place.length === 2 ? Math.hypot(m.place[0] - place[0], m.place[1] - place[1]) : 0];
  state.wanted = rpm;
  return pool.map(m => [away(m), m]).sort((a, b) => a[0].map((x, k) => x - b[0][k]).find(Boolean) || 0)[0][1];
}

function follow() {
  const parts = new URLSearchParams(location.hash.slice(1)), m = linked(parts);
  if (parts.get("show") in QUANTITIES) state.quantity = parts.get("show");
  const view = (parts.get("view") || "").split("_").map(Number);
  if (view.length === 4 && view.every(Number.isFinite) && view[1] > view[0] && view[3] > view[2]) state.x = view.slice(0, 2), state.y = view.slice(2);
  state.close = parts.has("close");
  $("quantity").value = state.quantity;
  set($("close"), {"aria-pressed": state.close});
  if (parts.has("t")) play(false);
  drawDiagram();
  choose(m || first(), Number(parts.get("t")) || 0);
}

/* What is shown first: the middle of the speeds, rather a motion that repeats. */
function first() {
  const middle = (data.speeds[0] + data.speeds[1]) / 2, stable = inDiagram.filter(m => m.stable !== false);
  return stable.reduce((best, m) => Math.abs(m.rpm - middle) < Math.abs(best.rpm - middle) ? m : best, stable[0]);
}

async function copy(text, words) {
  try {
    await navigator.clipboard.writeText(text);
  } catch {
    const area = Object.assign(document.createElement("textarea"), {value: text});
    document.body.append(area);
    area.select();
    document.execCommand("copy");
    area.remove();
  }
  $("copied").textContent = words;
}

/* All panels as they stand, in one SVG with the page's style. */
function picture() {
  const panels = [$("machine"), $("time"), $("phase"), overlay], boxes = panels.map(node => node.getBoundingClientRect());
  const left = Math.min(...boxes.map(b => b.left)), top = Math.min(...boxes.map(b => b.top));
  const wide = Math.max(...boxes.map(b => b.right)) - left + 20, high = Math.max(...boxes.map(b => b.bottom)) - top + 60;
  const whole = document.createElementNS(SVG, "svg");
  set(whole, {xmlns: SVG, width: wide, height: high, viewBox: `0 0 ${wide} ${high}`});
  const style = getComputedStyle(document.documentElement), variables = [...document.styleSheets[0].cssRules[0].style].filter(name => name.startsWith("--"));
  const sheet = [...document.styleSheets[0].cssRules].filter(rule => rule.selectorText && /^(svg|\.)/.test(rule.selectorText)).map(rule => rule.cssText).join("\n");
  add(whole, "style", {}, `svg { ${variables.map(name => `${name}: ${style.getPropertyValue(name)};`).join(" ")} overflow: visible; }\n${sheet.replace(/height: 100%;|width: 100%;/g, "")}`);
  add(whole, "rect", {width: wide, height: high, style: "fill: var(--paper)"});
  add(whole, "text", {x: 10, y: 20}, `${short(state.motion.rpm)} rpm: ${name(state.motion)}, θ = ${phaseAt(state.t).toFixed(1)}°`);
  panels.forEach((node, k) => {
    const place = {x: boxes[k].left - left + 10, y: boxes[k].top - top + 40, width: boxes[k].width, height: boxes[k].height};
    if (node === overlay) add(whole, "image", {...place, href: canvas.toDataURL("image/png")});
    const copied = node.cloneNode(true);
    set(copied, place);
    whole.append(copied);
  });
  return new XMLSerializer().serializeToString(whole);
}

$("copy").onclick = () => copy($("command").textContent, "The command is copied.");
$("link").onclick = () => copy(`${location.href.split("#")[0]}#${link()}`, "The link is copied.");
$("save").onclick = () => {
  const anchor = Object.assign(document.createElement("a"), {href: URL.createObjectURL(new Blob([picture()], {type: "image/svg+xml"})), download: `cam-${state.motion.rpm}-rpm.svg`});
  anchor.click();
  setTimeout(() => URL.revokeObjectURL(anchor.href), 1000);
};
$("play").onclick = () => play(!state.playing);
$("back").onclick = () => step(-1);
$("next").onclick = () => step(1);
$("pace").oninput = pace;
$("close").onclick = () => { state.close = !state.close; set($("close"), {"aria-pressed": state.close}); drawMachine(); drawTrace(); drawNow(); keepLink(); };
$("quantity").onchange = () => { state.quantity = $("quantity").value; wholeView(); drawDiagram(); keepLink(); };
$("in").onclick = () => zoom(0.6);
$("out").onclick = () => zoom(1 / 0.6);
$("whole").onclick = whole;

function seek(event, axes) {
  const box = $("time").getBoundingClientRect(), t = time.upper.fromX(event.clientX - box.left);
  play(false);
  state.t = Math.max(time.span[0], Math.min(t, time.span[1], state.motion.end));
  drawNow();
  keepLink();
}
$("time").addEventListener("pointerdown", event => { $("time").setPointerCapture(event.pointerId); seek(event); });
$("time").addEventListener("pointermove", event => { if (event.buttons) seek(event); });

/* ---- once ---- */

{
  const f = data.follower, [low, high, count] = data.speeds;
  $("about").textContent = `${short(Math.min(low, high))} to ${short(Math.max(low, high))} rpm at ${plural(count, "speed")}; ${data.kind.replace("_", " ")} cam, mass ${short(f.mass)} kg, ${f.stiffness ? `spring ${short(f.stiffness)} N/m, ` : ""}restitution ${short(f.restitution)}. Computed by camcli.`;
  $("constants").replaceChildren(...Object.entries(f).map(([key, value]) => {
    const row = document.createElement("tr"), head = Object.assign(document.createElement("th"), {scope: "row", textContent: key});
    row.append(head, Object.assign(document.createElement("td"), {textContent: `${short(value)} ${data.units[key]}`}));
    return row;
  }));
  $("drawn").textContent = data.outline.flat ? "The cam is drawn as an eccentric circle under a flat face; its radius is only that of the drawing." : data.outline.told ? "The cam is drawn to scale, under a knife edge." : "The cam is drawn under a knife edge, with a base radius chosen for the drawing: the scene has none.";
  if (data.measured) $("drawn").textContent += ` ${data.measured}`;
  if (data.outline.ratio !== 1) $("drawn").textContent += ` It is the lobe under a rocker: what runs on it is drawn with lifts and gaps ${short(data.outline.ratio)} times smaller than those of the valve.`;
  const seen = new Map(motions.map(m => [m.colour, 0]));
  const terms = {period1: "period 1", period2: "period 2", period3: "period 3", period4: "period 4", longer: "longer period", contact: "always on the cam", aperiodic: "aperiodic", undecided: "undecided"};
  $("legend").replaceChildren(...Object.entries(terms).filter(([key]) => seen.has(key)).map(([key, text]) => {
    const item = document.createElement("li"), mark = document.createElement("i");
    mark.style.background = `var(--${key})`;
    item.append(mark, text);
    return item;
  }), Object.assign(document.createElement("li"), {textContent: "lines are solved orbits, dashed where unstable"}));
  $("events").replaceChildren(...data.bifurcations.map(event => {
    const item = document.createElement("li"), button = Object.assign(document.createElement("button"), {type: "button", textContent: eventWords(event), onclick: () => goTo(event)});
    button.title = event.words.join(" ");
    item.append(button);
    return item;
  }));
}
readColours();
follow();
pace();
drawPlanes();
if (!still.matches && !location.hash.includes("t=")) play(true);
addEventListener("hashchange", follow);
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { readColours(); drawDiagram(); drawPlanes(); });
new ResizeObserver(() => { drawMotion(); drawDiagram(); drawPlanes(); }).observe(document.body);
requestAnimationFrame(frame);
