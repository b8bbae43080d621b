/* ---- controls ---- */

$("play").onclick = () => play(!state.playing);
$("back").onclick = () => step(-1);
$("next").onclick = () => step(1);
$("pace").oninput = setPace;
$("sound").onclick = switchSound;
$("close").onclick = () => {
  state.close = !state.close;
  set($("close"), {"aria-pressed": state.close});
  redrawMachine();
  keepLink();
};
$("lens").onchange = () => {
  state.lens = $("lens").value;
  redrawMachine();
};
$("speed").oninput = () => {
  choose(motionAtSpeed(speeds[$("speed").value]), state.t % 1);
  followChosen();
};
$("quantity").onchange = () => {
  state.quantity = $("quantity").value;
  showWhole();
};
$("in").onclick = () => zoomAboutChosen(0.6);
$("out").onclick = () => zoomAboutChosen(1 / 0.6);
$("whole").onclick = showWhole;
$("tall").onclick = () => {
  const isTall = host.classList.toggle("tall");
  set($("tall"), {"aria-pressed": isTall});
  boxes.clear();
  drawDiagram();
};
$("copy").onclick = () => copy($("command").textContent, "The command is copied.");
$("link").onclick = () => copy(`${location.href.split("#")[0]}#${link()}`, "The link is copied.");
$("save").onclick = save;
$("time").addEventListener("pointerdown", event => {
  $("time").setPointerCapture(event.pointerId);
  seek(event);
});
$("time").addEventListener("pointermove", event => {
  if (event.buttons) seek(event);
});

function redrawMachine() {
  drawMachine();
  drawTrace();
  drawNow();
}

/* ---- once ---- */

$("about").textContent = machineWords();
$("drawn").textContent = drawingWords();
set($("speed"), {min: 0, max: speeds.length - 1, step: 1});

$("constants").replaceChildren(...Object.entries(data.follower).map(([key, value]) => {
  const row = make("tr");
  const head = make("th", {textContent: key}, {scope: "row"});
  row.append(head, make("td", {textContent: `${short(value)} ${data.units[key]}`}));
  return row;
}));

const COLOUR_WORDS = {
  period1: "period 1", period2: "period 2", period3: "period 3", period4: "period 4",
  longer: "longer period", contact: "always on the cam", aperiodic: "aperiodic", undecided: "undecided",
};
const seenColours = new Set(motions.map(m => m.colour));
for (const [colour, text] of Object.entries(COLOUR_WORDS)) {
  if (!seenColours.has(colour)) continue;
  const item = make("li"), mark = make("i");
  mark.style.background = `var(--${colour})`;
  item.append(mark, text);
  $("legend").append(item);
}
if (data.branches.length > 0) {
  $("legend").append(make("li", {textContent: "lines are solved orbits, dashed where unstable"}));
}

$("events").replaceChildren(...data.bifurcations.map(event => {
  const item = make("li"), title = event.words.join(" "), onclick = () => goTo(event);
  item.append(make("button", {type: "button", textContent: eventWords(event), title, onclick}));
  return item;
}));

readColours();
follow();
setPace();
drawPlanes();
addEventListener("hashchange", follow);
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", drawAll);

/* A sentence of another length changes the height of the page, and no panel. */
let drawnFor = "";
new ResizeObserver(() => {
  const size = `${document.body.clientWidth} ${innerHeight}`;
  if (isPrinting() || size === drawnFor) return;
  drawnFor = size;
  drawAll();
}).observe(document.body);
requestAnimationFrame(frame);
