/* ---- the forces on the follower ---- */

const LONGEST_ARROW = 46; // px
const ARROWS = [
  {name: "pull", aside: 36, words: pullOf(data.follower)},
  {name: "contact", aside: 50, words: "contact"},
  {name: "inertia", aside: 64, words: "inertia −m·a"},
];

/* Forces (N, up) on the follower: what pulls it to the cam, the contact, and its inertia. */
function forcesOn(m, now) {
  const f = followerOf(m);
  const pull = f.stiffness * now.q + f.preload + f.mass * f.gravity + f.damping * now.v;
  return {pull: -pull, contact: now.force, inertia: pull - now.force};
}

function drawArrows() {
  const m = state.motion;
  let largest = 0;
  for (let k = 0; k <= 720; k++) {
    const forces = forcesOn(m, at(m, m.end * k / 720));
    largest = Math.max(largest, ...Object.values(forces).map(Math.abs));
  }
  machine.perNewton = largest > 0 ? LONGEST_ARROW * machine.size / largest : 0;
  machine.arrows = ARROWS.map(({name}) => add(machine.moving, "path", {class: `arrow ${name}`}));
}

/* An arrow of this length, up or down, from (x, y); none where it would be a dot. Its shaft is
   `thick` pixels wide. */
function arrowPath(x, y, length, thick) {
  if (Math.abs(length) < 2) return "";
  const way = Math.sign(length), head = Math.min(2.4 * thick, Math.abs(length)), end = y - length;
  const half = thick / 2, barb = Math.max(half, 0.7 * head), neck = px(end + way * head);
  const shaft = `M${px(x - half)} ${px(y)}V${neck}`, back = `H${px(x + half)}V${px(y)}Z`;
  return `${shaft}H${px(x - barb)}L${px(x)} ${px(end)}L${px(x + barb)} ${neck}${back}`;
}

function moveArrows(m, now, tip) {
  const {size} = machine, middle = machine.isBall ? RADIUS_OF_BALL : FOLLOWER_HEIGHT - MASS_HEIGHT / 2;
  const forces = forcesOn(m, now), y = tip - middle * size;
  const x = machine.x + (machine.isBall ? besideTheTable() : 0);
  ARROWS.forEach(({name, aside}, k) => {
    const length = forces[name] * machine.perNewton;
    machine.arrows[k].setAttribute("d", arrowPath(x + size * aside, y, length, 3 * size));
  });
}

/* How much further to the right the arrows of a ball are, so that none lies on its table. */
function besideTheTable() {
  return Math.max(0, TABLE_WIDTH / 2 + 12 - machine.size * ARROWS[0].aside);
}

/* What the colours in the drawing mean. */
function drawKey(svg) {
  const key = add(svg, "g", {class: "key"});
  const lines = [["flight", TERMS.pathOfFlight], ["rest", `path ${TERMS.rests}`]];
  const rows = [...(machine.trace ? lines : []), ...ARROWS.map(({name, words}) => [name, words])];
  rows.forEach(([kind, words], k) => {
    const y = 12 + 15 * k, isLine = kind === "flight" || kind === "rest";
    if (isLine) add(key, "path", {class: `lines ${kind}`, d: `M4 ${y - 4}H16`});
    else add(key, "path", {class: `arrow ${kind}`, d: arrowPath(10, y + 1, 11, 3)});
    add(key, "text", {class: "small", x: 21, y}, words);
  });
}
