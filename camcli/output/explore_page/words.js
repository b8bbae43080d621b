/* ---- words ---- */

const TERMS = termsOf(data);

/* A motion in a sentence. */
function words(m) {
  const constants = Object.entries(m.sets).map(([key, value]) => `with ${key} = ${short(value)}`);
  if (m.origin === "start") {
    const place = `from q = ${short(m.q)} m, v = ${short(m.v)} m/s at the strobe`;
    const end = m.symbols.length > 0 ? `on ${shown(m.label)}` : shown(m.label);
    return `${place}; it ends up ${end}`;
  }
  const unstable = m.stable === false ? "; any real machine leaves it" : "";
  return [...constants, behaviour(m) + unstable].join(", ");
}

function behaviour(m) {
  const partly = `${plural(m.turns, "turn")} shown`;
  if (m.label === "contact") return `the ${TERMS.follower} is always ${TERMS.rests}`;
  if (m.label === "aperiodic") return `it never repeats; ${partly}`;
  if (m.symbols.length === 0) return "the record does not tell what it is";
  const often = m.period === 1 ? "every turn" : `after ${m.period} turns`;
  const rest = "impacts accumulate, then it rests";
  const impacts = m.symbols.reduce((sum, count) => sum + count, 0);
  const what = impacts === Infinity ? `; ${rest}` : `, with ${plural(impacts, "impact")}`;
  return `it repeats ${often}${what}` + (m.loops ? "" : `; ${partly}`);
}

const SOURCES = {
  up: "found on the way up",
  down: "found on the way down",
  solved: "a solved orbit",
  stop: "",
  fixed: "",
  start: "",
  map: "",
};

function name(m) {
  return shown(m.label) + (m.stable === false ? ", unstable" : "");
}

/* How fast two motions that begin nearly alike part. */
function exponent(m) {
  if (m.exponent === null) return "";
  if (m.exponent === -Infinity) return "Lyapunov exponent −∞";
  return `Lyapunov exponent ${fixed(m.exponent, 3)} per turn`;
}

/* The same, with what it means. */
function exponentWords(m) {
  if (m.exponent === null) return "";
  const fate = m.exponent === -Infinity ? "vanish" : m.exponent > 0 ? "grow" : "fade";
  return `${exponent(m)}: differences ${fate}`;
}

function speedWords(rpm) {
  return speedOf(rpm, data);
}

function eventWords(event) {
  const kind = event.kind.replace(/-/g, " ");
  const place = event.kind === "corner-impact" ? ` at ${event.corner}` : "";
  const more = event.classification ? ` (${event.classification.replace(/-/g, " ")})` : "";
  const speed = speedWords(event.rpm).replace(" ", "\u00a0");
  return `${kind}${place} of ${shown(event.label)} at ${speed}${more}`;
}

/* What the machine is, above everything. */
function machineWords() {
  return `${speedsOf(data)}; ${constantsOf(data).join(", ")}. ${data.measured}`.trim();
}

/* How the cam is drawn. */
function drawingWords() {
  const {flat, told, ratio} = data.outline;
  let how = "The cam is drawn under a knife edge, with a base radius chosen for the drawing: " +
    "the scene has none.";
  if (told) how = "The cam is drawn to scale, under a knife edge.";
  if (flat) {
    how = "The cam is drawn as an eccentric circle under a flat face; its radius is only that of the " +
      "drawing.";
  }
  if (ratio === 1) return how;
  return `${how} It is the lobe under a rocker: what runs on it is drawn with lifts and gaps ` +
    `${short(ratio)} times smaller than those of the valve.`;
}
