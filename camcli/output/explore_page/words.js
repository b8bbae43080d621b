/* ---- words and numbers ---- */

function words(m) {
  const counts = m.symbols;
  let said;
  if (m.origin === "start") return `from q = ${short(m.q)} m, v = ${short(m.v)} m/s at the strobe; it ends up ${counts.length ? "on " : ""}${shown(m.label)}`;
  if (m.label === "contact") said = "the follower never leaves the cam";
  else if (m.label === "aperiodic") said = `it never repeats; ${plural(m.turns, "turn")} of it are shown`;
  else if (!counts.length) said = "the record does not tell what it is";
  else {
    const often = m.period === 1 ? "every turn" : `after ${m.period} turns`;
    if (counts.includes(Infinity)) said = `it repeats ${often}; impacts accumulate, then the follower rests on the cam`;
    else said = `it repeats ${often}, with ${plural(counts.reduce((a, b) => a + b, 0), "impact")}`;
    if (!m.loops) said += `; ${plural(m.turns, "turn")} of it are shown`;
  }
  if (m.stable === false) said += "; unstable, so a machine leaves it";
  return [...Object.entries(m.sets).map(([key, value]) => `with ${key} = ${short(value)}`), said].join(", ");
}

const SOURCES = {up: "found by carrying the motion up from lower speeds", down: "found by carrying the motion down from higher speeds",
  solved: "a solved orbit", fixed: "", start: "", map: ""};

function name(m) {
  return shown(m.label) + (m.stable === false ? ", unstable" : "");
}

function exponent(m) {
  if (m.exponent === null) return "";
  return m.exponent === -Infinity ? "exponent −∞: a rest forgets everything" : `exponent ${fixed(m.exponent, 3)} per turn`;
}
