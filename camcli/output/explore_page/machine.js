/* ---- the machine ---- */

function drawMachine() {
  const m = state.motion, {svg, width, height} = emptied("machine");
  const body = data.outline, n = body.x.length;
  let reach = 0, top = -Infinity;
  for (let k = 0; k < n; k++) reach = Math.max(reach, Math.hypot(body.x[k], body.y[k]));
  for (let k = m.row; k < m.row + m.rows; k++) top = Math.max(top, data.rows.q[k]);
  for (let k = 0; k < data.cam.c.length; k++) top = Math.max(top, data.cam.c[k]);
  const ball = body.flat && !data.follower.stiffness;
  const above = ball ? 40 : 120;
  const radius = lift => lift / body.ratio + body.rise; // under the follower: the cam lifts less than a valve behind a rocker
  const whole = (height - 16 - above) / (reach + Math.max(reach, radius(top)));
  const near = Math.min(width - 16, (height - above) / 1.15) / (2 * reach);
  const scale = state.close ? near : Math.min(whole, (width - 16) / (2 * reach));
  const x = width / 2, y = height - 8 - reach * scale;
  machine = {scale, x, y, radius, ball};
  const defs = add(svg, "defs"), shine = add(defs, "radialGradient", {id: "shine", cx: "35%", cy: "30%", r: "80%"});
  add(shine, "stop", {offset: "0", "stop-color": "var(--shine)"});
  add(shine, "stop", {offset: "1", "stop-color": "var(--steel)"});
  const cam = add(svg, "g", {id: "cam"});
  const point = (r, a) => `${px(r * Math.sin(a) * scale)} ${px(-r * Math.cos(a) * scale)}`;
  let d = "";
  for (let k = 0; k < n; k++) d += `${k ? "L" : "M"}${px(body.x[k] * scale)} ${px(-body.y[k] * scale)}`;
  add(cam, "path", {class: "metal", style: "fill: url(#shine)", d: d + "Z"});
  for (const [letter, degrees] of Object.entries(data.corners)) {
    const a = degrees * Math.PI / 180, r = radius(camAt(degrees)[0]);
    add(cam, "path", {class: "lines axis", d: `M${point(r, a)}L${point(r - 9 / scale, a)}`});
    add(cam, "text", {class: "small corner", x: px((r - 18 / scale) * Math.sin(a) * scale), y: px(-(r - 18 / scale) * Math.cos(a) * scale), "text-anchor": "middle", "dominant-baseline": "central"}, letter);
  }
  machine.letters = [...cam.querySelectorAll(".corner")];
  machine.cam = cam;
  if (!body.flat) machine.trace = [add(cam, "path", {class: "lines flight", opacity: .55}), add(cam, "path", {class: "lines rest", opacity: .8})];
  add(cam, "circle", {class: "frame", r: 5});
  add(cam, "path", {class: "lines axis", d: `M0 0V${px(-0.5 * reach * scale)}`});
  const axle = add(svg, "g", {transform: `translate(${x} ${y})`});
  add(axle, "circle", {r: 2.5, fill: "var(--paper)"});
  const follower = add(svg, "g", {id: "follower"});
  machine.follower = follower;
  if (ball) {
    add(follower, "circle", {class: "metal", style: "fill: url(#shine)", cy: -12, r: 12});
    machine.table = add(svg, "path", {class: "lines axis", "stroke-width": 2, d: "M-32 0H32"});
  } else {
    if (body.flat) add(follower, "rect", {class: "metal", x: -24, y: -7, width: 48, height: 7, rx: 1});
    else add(follower, "path", {class: "metal", d: "M0 0L-7 -14V-18H7V-14Z"});
    add(follower, "rect", {class: "metal", x: -7, y: -62, width: 14, height: body.flat ? 55 : 46});
    add(follower, "rect", {class: "metal", style: "fill: url(#shine)", x: -22, y: -82, width: 44, height: 22, rx: 3});
    let spring = "M0 0";
    for (let k = 0; k < 12; k++) spring += `L${k % 2 ? -13 : 13} ${(k + .5) * 100 / 12}`;
    if (data.follower.stiffness) {
      machine.spring = add(svg, "path", {class: "spring", d: spring + "L0 100"});
      add(svg, "rect", {class: "frame", x: x - 30, y: 0, width: 60, height: 5});
    }
  }
  machine.tip = add(follower, "circle", {r: 5, fill: "var(--sticking)"});
  machine.flash = add(svg, "circle", {class: "lines", stroke: "var(--trouble)", "stroke-width": 3});
  machine.angle = add(svg, "text", {class: "small", x: 4, y: height - 6});
  machine.size = add(svg, "text", {class: "small", x: width - 4, y: height - 6, "text-anchor": "end"}, bar(scale));
  const [, length] = barOf(scale);
  add(svg, "path", {class: "lines axis", d: `M${px(width - 4 - length)} ${height - 20}v-5v5H${width - 4}v-5`});
}

/* A round length of some 60 px and its text. */
function barOf(scale) {
  const rough = 60 / scale, power = 10 ** Math.floor(Math.log10(rough));
  const length = [1, 2, 5, 10].map(n => n * power).findLast(s => s <= rough * 1.0001) || power;
  return [length, length * scale];
}
function bar(scale) {
  const [length] = barOf(scale), {unit, factor} = lengths(length);
  return `${short(length * factor)} ${unit}`;
}

/* The path of the tip over the cam, of the turns in sight, in the cam's own frame. */
function drawTrace() {
  if (!machine.trace) return;
  const m = state.motion, [from, to] = time.span, paths = ["", ""];
  let last = -1;
  const steps = Math.ceil((to - from) * 180);
  for (let k = 0; k <= steps; k++) {
    const now = at(m, Math.min(from + (to - from) * k / steps, m.end)), mode = Number(now.rests);
    const r = machine.radius(now.q) * machine.scale, a = now.phase * Math.PI / 180;
    const place = `${px(r * Math.sin(a))} ${px(-r * Math.cos(a))}`;
    if (last >= 0 && mode !== last) paths[last] += "L" + place;
    paths[mode] += (mode === last ? "L" : "M") + place;
    last = mode;
  }
  machine.trace.forEach((path, mode) => path.setAttribute("d", paths[mode]));
}
