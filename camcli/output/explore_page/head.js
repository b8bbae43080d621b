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

/* What the parts of a machine are called: in an engine the follower is a valve with what moves it. */
function termsOf(machine) {
  if (machine.valve) {
    return {
      follower: "valve train",
      position: "lift of valve train and cam",
      short: "valve train, cam",
      gap: "gap",
      rests: machine.seat ? "on cam or seat" : "on the cam",
      flies: "floating",
      pathOfFlight: "path while floating",
      speed: "camshaft speed (rpm)",
    };
  }
  const isBall = isBallOnTable(machine);
  return {
    follower: isBall ? "ball" : "follower",
    position: isBall ? "position of ball and table" : "position of follower and cam",
    short: isBall ? "ball, table" : "follower, cam",
    gap: "gap q − c",
    rests: isBall ? "on the table" : "on the cam",
    flies: "in flight",
    pathOfFlight: "path in flight",
    speed: "speed (rpm)",
  };
}

/* The speed of a machine's crank, in rpm, at one of its cam. */
function ofCrank(rpm, machine) {
  return short(Number((machine.crank * rpm).toPrecision(6)));
}

/* A speed in rpm; where there is a crank, that of both shafts. */
function speedOf(rpm, machine) {
  if (!machine.crank) return `${short(rpm)} rpm`;
  return `${short(rpm)} rpm of the cam, ${ofCrank(rpm, machine)} of the crank`;
}

/* What the axis of speeds is called, and how fast a crank turns where there is one. */
function speedAxisOf(machine) {
  const name = termsOf(machine).speed;
  return machine.crank ? `${name}; the crank turns ${short(machine.crank)}× as fast` : name;
}

/* The speeds of the page, where there is a crank those of both shafts. */
function speedsOf(machine) {
  const low = Math.min(...machine.speeds.slice(0, 2)), high = Math.max(...machine.speeds.slice(0, 2));
  const ofCam = `${short(low)} to ${short(high)} rpm`;
  if (!machine.crank) return ofCam;
  return `${ofCam} of the cam, ${ofCrank(low, machine)} to ${ofCrank(high, machine)} of the crank`;
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

/* What the motion obeys, one law each: while the follower flies, while it rests, when it strikes. */
function lawsOf(machine) {
  const f = machine.follower;
  const load = [[f.gravity, "m g"], [f.preload, "F₀"]];
  const flight = sumOf([[true, "m q″"], [f.damping, "b q′"], [f.stiffness, "k q"]], "+");
  const push = sumOf([[true, "m c″"], [f.damping, "b c′"], [f.stiffness, "k c"], ...load], "+");
  return {
    flight: `${unbroken(flight)} = ${unbroken(sumOf(load, "−"))}`,
    rest: `q = c, ${unbroken(push)} > 0`,
    impact: "u⁺ = −r u⁻, u = q′ − c′",
  };
}

const PULLS = {spring: "A spring", weight: "Its weight", preload: "A preload"};

/* What pulls a follower to its cam; what there is besides a spring is left out. */
function pullOf({stiffness, gravity, preload}) {
  if (stiffness) return "spring";
  return preload && !gravity ? "preload" : "weight";
}

/* What the machine does, for somebody who has never seen one. */
function introOf(machine) {
  if (isBallOnTable(machine)) {
    return "A ball lies on a shaking table. Too fast, and the ball flies, lands and bounces.";
  }
  if (machine.valve) {
    return "A cam opens a valve against its spring. Too fast, and the valve floats, lands and bounces.";
  }
  const pull = PULLS[pullOf(machine.follower)];
  return `${pull} holds the follower on a turning cam. Too fast, and it flies, lands and bounces.`;
}

/* A formula that no line ends in. */
function unbroken(formula) {
  return formula.replaceAll(" ", "\u00a0");
}
