/* ---- controls ---- */

$("play").onclick = () => play(!state.playing);
$("back").onclick = () => step(-1);
$("next").onclick = () => step(1);
$("pace").oninput = () => {
  setPace();
  keepLink();
};
$("sound").onclick = switchSound;
$("close").onclick = () => {
  setClose(!state.close);
  redrawMachine();
  keepLink();
};
$("lens").onchange = () => {
  state.lens = $("lens").value;
  redrawMachine();
  keepLink();
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
  setTall(!host.classList.contains("tall"));
  drawAll();
  $("diagram-panel").scrollIntoView({block: "nearest"});
  keepLink();
};
$("present").onclick = () => present(!state.presents);
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

function setTall(isTall) {
  host.classList.toggle("tall", isTall);
  set($("tall"), {"aria-pressed": isTall});
  boxes.clear();
}

/* ---- for a room: large letters, and only what is looked at ---- */

function setPresents(isForRoom) {
  state.presents = isForRoom;
  document.documentElement.classList.toggle("presenting", isForRoom);
  set($("present"), {"aria-pressed": isForRoom});
  fitLetters();
  boxes.clear();
}

/* Fill the screen where the browser lets a page do so, or only the window. */
async function present(isForRoom) {
  setPresents(isForRoom);
  drawAll();
  keepLink();
  try {
    if (isForRoom) await document.documentElement.requestFullscreen();
    else if (document.fullscreenElement) await document.exitFullscreen();
  } catch (refusal) {
    if (refusal.name !== "TypeError") throw refusal; // not allowed here
  }
}

document.addEventListener("fullscreenchange", () => {
  if (document.fullscreenElement || !state.presents) return;
  setPresents(false);
  drawAll();
  keepLink();
});

function redrawMachine() {
  drawMachine();
  drawTrace();
  drawNow();
}

/* ---- once ---- */

$("title").textContent = titleOf(data);
document.title = `${titleOf(data)}: ${speedsOf(data)}`;
$("intro").textContent = introOf(data);
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
  longer: "longer period", rests: "with rests", contact: `always ${TERMS.rests}`,
  aperiodic: "aperiodic", undecided: "undecided",
};
const seenColours = new Set(motions.filter(m => m.origin !== "stop").map(m => m.colour));
for (const [colour, text] of Object.entries(COLOUR_WORDS)) {
  if (!seenColours.has(colour)) continue;
  const item = make("li"), mark = make("i");
  mark.style.background = `var(--${colour})`;
  item.append(mark, text);
  $("legend").append(item);
}
if (data.branches.length > 0) {
  const ofBifurcations = data.bifurcations.length > 0 ? "; ◇\u00a0bifurcations" : "";
  const words = `lines: solved orbits; dashed: unstable${ofBifurcations}`;
  $("legend").append(make("li", {textContent: words, className: "of-lines"}));
}

const MOST_COLUMNS = 3; // of a list in as many as it has room for
$("events").replaceChildren(...data.bifurcations.map(event => {
  const item = make("li"), title = event.words.join(" ");
  const onclick = () => {
    goTo(event);
    $("diagram-panel").scrollIntoView({block: "nearest"});
  };
  item.append(make("button", {type: "button", textContent: eventWords(event), title, onclick}));
  return item;
}));

$("events").style.columnCount = Math.min(data.bifurcations.length, MOST_COLUMNS);

fitLetters();
reserveWords();
readColours();
follow();
drawPlanes();
addEventListener("hashchange", () => {
  if (document.getElementById(location.hash.slice(1))) return; // a place on the page, as of "Skip to"
  clearTimeout(linkLater); // else the link of the last action would replace this one
  follow();
});
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", drawAll);

/* Draw again what has another size: of the window, or beside a sentence of another length. */
let drawnFor = "";
const observer = new ResizeObserver(() => {
  const panels = PANELS.map($).map(({clientWidth, clientHeight}) => [clientWidth, clientHeight]);
  const size = [innerWidth, innerHeight, ...panels].join(" ");
  if (isPrinting() || size === drawnFor) return;
  drawnFor = size;
  drawAll();
});
const PANELS = ["machine", "time", "phase", "diagram"];
for (const panel of PANELS) observer.observe($(panel));
requestAnimationFrame(frame);
