/* ---- the head of the page: what the machine is; nothing here knows of the page ---- */

const CAM_WORDS = {
  arcs: "cam of circular arcs", law: "cam by laws of motion", eccentric: "eccentric cam",
  table: "measured cam",
};

function isBallOnTable(machine) {
  return machine.outline.flat && !machine.follower.stiffness;
}

/* What moves on this page. */
function titleOf(machine) {
  if (machine.valve) return "A valve train in motion";
  if (isBallOnTable(machine)) return "A ball on a moving table";
  return "A follower on its cam, in motion";
}

function speedsOf(machine) {
  const [first, last] = machine.speeds;
  return `${short(Math.min(first, last))} to ${short(Math.max(first, last))} rpm`;
}

/* The constants of the machine with their symbols; those that are zero are left out. */
function constantsOf(machine) {
  const f = machine.follower, parts = [CAM_WORDS[machine.kind] || `${machine.kind} cam`];
  const tell = (name, value, unit) => parts.push(`${name} ${short(value)} ${unit}`.trim());
  tell("mass m", f.mass, "kg");
  if (f.stiffness && machine.valve) tell("spring k", f.stiffness / 1000, "N/mm");
  else if (f.stiffness) tell("spring k", f.stiffness, "N/m");
  if (f.damping) tell("damping b", f.damping, "N s/m");
  if (f.preload) tell("preload F₀", f.preload, "N");
  if (f.gravity) tell("gravity g", f.gravity, "m/s²");
  tell("restitution r", f.restitution, "");
  if (f.seat_restitution !== undefined) tell("on the seat", f.seat_restitution, "");
  if (machine.lash) tell("lash", 1000 * machine.lash, "mm");
  if (machine.outline.ratio !== 1) tell("rocker", machine.outline.ratio, ": 1");
  return parts;
}

/* The terms of a sum that are there, with the signs between them; 0 where none is. */
function sumOf(terms, sign) {
  const found = terms.filter(([isThere]) => isThere).map(([, text]) => text);
  if (found.length === 0) return "0";
  return (sign === "−" ? "−" : "") + found.join(` ${sign} `);
}

/* What the motion obeys: in flight, at an impact, on the cam. */
function lawsOf(machine) {
  const f = machine.follower;
  const load = [[f.gravity, "m g"], [f.preload, "F₀"]];
  const flight = sumOf([[true, "m q″"], [f.damping, "b q′"], [f.stiffness, "k q"]], "+");
  const push = sumOf([[true, "m c″"], [f.damping, "b c′"], [f.stiffness, "k c"], ...load], "+");
  const formulas = [`${flight} = ${sumOf(load, "−")}`, "u⁺ = −r u⁻", "u = q′ − c′", "q = c", `${push} > 0`];
  const [ofFlight, ofImpact, velocity, ofRest, force] = formulas.map(unbroken);
  return `In flight ${ofFlight}; at an impact ${ofImpact} with ${velocity}; `
    + `on the cam ${ofRest} while ${force}.`;
}

/* A formula that no line ends in. */
function unbroken(formula) {
  return formula.replaceAll(" ", "\u00a0");
}
