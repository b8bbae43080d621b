/* ---- a lens on the gap ---- */

const LENS = 46, SMALL_LENS = 36, NARROW = 330; // px: radii, and the width that asks for the small
const ENLARGED = [1000, 100, 10];

function lensRadius() {
  return machine.width < NARROW ? SMALL_LENS : LENS;
}

/* How much the lens enlarges; 0 where there is none. */
function enlargement(m) {
  if (state.lens === "off") return 0;
  if (state.lens !== "auto") return Number(state.lens);
  const largest = extentOf(m).far / data.outline.ratio * machine.scale;
  if (largest === 0 || largest > lensRadius() / 2) return 0;
  return ENLARGED.find(times => largest * times <= 1.4 * lensRadius()) || 10;
}

function drawLens(svg) {
  const times = enlargement(state.motion);
  machine.lens = null;
  if (times === 0) return;
  const r = lensRadius(), x = machine.width - r - 6, y = r + 6, ground = y + 0.55 * r;
  const clip = add(svg, "clipPath", {id: "lens-clip"});
  add(clip, "circle", {cx: x, cy: y, r});
  add(svg, "circle", {class: "lens-glass", cx: x, cy: y, r});
  const inside = add(svg, "g", {"clip-path": "url(#lens-clip)"});
  const surface = add(inside, "path", {class: "metal", id: "lens-surface"});
  const tip = add(inside, "path", {class: "metal shining", d: tipInLens(times)});
  add(svg, "circle", {class: "lens-rim", cx: x, cy: y, r});
  add(svg, "text", {class: "small", x, y: y + r + 14, "text-anchor": "middle"}, `gap × ${times}`);
  machine.lens = {tip, surface, x, ground, times};
}

/* The end of the follower: a ball as large as it looks through the lens, a face, or an edge. */
function tipInLens(times) {
  const r = RADIUS_OF_BALL * machine.size * times;
  if (machine.isBall) return `M0 0A${r} ${r} 0 0 0 0 ${-2 * r}A${r} ${r} 0 0 0 0 0Z`;
  return data.outline.flat ? "M-60 0H60V-8H12V-120H-12V-8H-60Z" : "M0 0L-24 -40V-120H24V-40Z";
}

/* The cam as the lens shows it, from where it is touched: its slope and its bend are its own. */
function surfaceInLens(now) {
  const {x, ground, times} = machine.lens, size = machine.scale * times, steps = 12;
  const here = machine.radius(now.c), points = [];
  for (let k = -steps; k <= steps; k++) {
    let across = 1.1 * LENS * k / steps, up;
    if (machine.isBall) { // it falls on a table
      up = 0;
    } else if (data.outline.flat) { // a circle, touched at its top
      up = -across * across / (2 * radiusOfDisk() * size);
    } else {
      const angle = across / (size * here);
      const r = machine.radius(camAt((now.phase + angle * 180 / Math.PI + TURN) % TURN)[0]);
      across = r * Math.sin(angle) * size;
      up = (r * Math.cos(angle) - here) * size;
    }
    points.push(`${px(x + across)} ${px(ground - up)}`);
  }
  return `M${points.join("L")}V${px(ground + 3 * LENS)}H${px(x - 1.2 * LENS)}Z`;
}

/* The radius of the circle that a flat face runs on. */
function radiusOfDisk() {
  const {x} = data.outline;
  let least = Infinity, most = -Infinity;
  for (const place of x) {
    least = Math.min(least, place);
    most = Math.max(most, place);
  }
  return (most - least) / 2;
}

function moveLens(now) {
  if (!machine.lens) return;
  const {tip, surface, x, ground, times} = machine.lens;
  set(surface, {d: surfaceInLens(now)});
  const gap = now.gap / data.outline.ratio * machine.scale * times;
  set(tip, {transform: `translate(${px(x)} ${px(ground - gap)})`});
}
