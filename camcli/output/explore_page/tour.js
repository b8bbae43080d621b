/* ---- the tour: stops that show what a machine can do, one sentence each ---- */

const BEFORE_THE_TOUR = "Take the tour: each stop shows one thing that this machine does. "
  + "Or drag the speed.";

function showStop(stop) {
  const m = motions[stop.motion];
  setClose(stop.close);
  choose(m, stop.t);
  if (isInDiagram(m) && !inView(m.rpm)) followChosen();
  play(!still.matches);
}

/* The number of the stop that shows a motion, or -1. */
function numberOfStop(m) {
  return data.stops.findIndex(stop => stop.motion === m.number);
}

/* The button of the stop that is shown is pressed, its sentence stands below, and the button
   beside it names the next one. */
function markStop(m) {
  const number = numberOfStop(m);
  [...$("stops").children].forEach((button, k) => set(button, {"aria-pressed": k === number}));
  const words = $("stop-words");
  words.className = number < 0 ? "idle" : "";
  if (number >= 0) words.textContent = data.stops[number].words;
  else words.textContent = data.stops.length > 0 ? BEFORE_THE_TOUR : "";
  $("onward").textContent = wordsOfOnward(number);
  if (number >= 0) bringIntoRow($("stops").children[number]);
}

/* On a narrow screen the buttons stand in a row that is longer than the screen. */
function bringIntoRow(button) {
  const row = button.parentElement;
  row.scrollLeft = button.offsetLeft - row.offsetLeft - 8;
}

/* Room for the longest sentence of the tour, so that a shorter one moves nothing. */
function reserveWords() {
  const words = $("stop-words"), shown = words.textContent;
  words.style.minHeight = "0";
  let highest = 0;
  for (const {words: sentence} of isPrinting() ? [] : data.stops) {
    words.textContent = sentence;
    highest = Math.max(highest, words.getBoundingClientRect().height);
  }
  words.textContent = shown;
  words.style.minHeight = `${highest}px`;
}

/* What comes after a stop; before the tour it is its first stop. */
function wordsOfOnward(number) {
  if (number === data.stops.length - 1) return "Now drag the speed ▸";
  return number < 0 ? "Start the tour ▸" : `Next: ${data.stops[number + 1].name} ▸`;
}

/* To the next stop; after the last one to a motion in the diagram, whose speed is to be dragged. */
function goOnward() {
  const next = numberOfStop(state.motion) + 1;
  if (next < data.stops.length) {
    showStop(data.stops[next]);
    return;
  }
  setClose(false);
  choose(first());
  showWhole();
  host.focus({preventScroll: true});
}

$("stops").replaceChildren(...data.stops.map(stop => {
  const properties = {type: "button", textContent: stop.name, onclick: () => showStop(stop)};
  return make("button", properties, {"aria-pressed": false, title: stop.words});
}));
$("onward").hidden = data.stops.length === 0;
$("onward").onclick = goOnward;
