/* ---- basins and map: planes with a motion for some of their places ---- */

for (const plane of data.planes) {
  plane.motions = motions.filter(m => m.origin === plane.of);
  const section = document.createElement("section"), title = plane.of + "-title";
  set(section, {class: "panel", "aria-labelledby": title});
  const head = Object.assign(document.createElement("h2"), {id: title, textContent: plane.name});
  const text = Object.assign(document.createElement("p"), {className: "faint", textContent: `${plane.words} Click a place to see its motion.`.trim()});
  const box = Object.assign(document.createElement("div"), {className: "plane", id: plane.of + "-plane", tabIndex: 0});
  set(box, {role: "application", "aria-label": `${plane.name}: arrow keys choose a place`});
  plane.svg = document.createElementNS(SVG, "svg");
  plane.svg.id = plane.of + "-axes";
  set(plane.svg, {"aria-hidden": true});
  box.append(document.createElement("canvas"), plane.svg);
  section.append(head, text, box);
  $("planes").append(section);
  const place = event => { const {left, top} = box.getBoundingClientRect(); return [event.clientX - left, event.clientY - top]; };
  box.addEventListener("click", event => chooseIn(plane, ...place(event)));
  box.addEventListener("pointermove", event => { box.title = kindIn(plane, ...place(event)); });
  box.addEventListener("keydown", event => {
    const way = {ArrowRight: [1, 0], ArrowLeft: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1]}[event.key];
    if (!way) return;
    event.preventDefault();
    const [x, y] = placeIn(plane, state.motion.origin === plane.of ? state.motion : plane.motions[0]);
    const far = ([a, b]) => Math.abs(a - x) + Math.abs(b - y);
    const ahead = plane.motions.map(m => [m, placeIn(plane, m)])
      .filter(([, [a, b]]) => way[0] * (a - x) - way[1] * (b - y) > .5 && Math.abs(way[0] ? b - y : a - x) < .5);
    if (ahead.length) choose(ahead.reduce((best, other) => far(other[1]) < far(best[1]) ? other : best)[0]);
  });
}

const placeIn = ({axes}, m) => [axes.X(m.place[0]), axes.Y(m.place[1])];

function chooseIn(plane, x, y) {
  const far = m => { const [a, b] = placeIn(plane, m); return Math.hypot(a - x, b - y); };
  if (plane.motions.length) choose(plane.motions.reduce((best, m) => far(m) < far(best) ? m : best));
}

/* The motion at a place: of a map its period, as the map has no more. */
function kindIn({axes, cells, codes, labels}, x, y) {
  if (!axes.holds(x, y)) return "";
  const column = Math.floor((x - axes.left) / (axes.right - axes.left) * cells[0]), row = Math.floor((axes.bottom - y) / (axes.bottom - axes.top) * cells[1]);
  const label = labels[codes[Math.min(row, cells[1] - 1) * cells[0] + Math.min(column, cells[0] - 1)]] ?? "below the cam";
  return shown(label);
}

function drawPlane(plane) {
  const picture = $(plane.of + "-plane").querySelector("canvas"), {svg, width, height} = emptied(plane.svg);
  const axes = plane.axes = new Axes(svg, 54, 24, width - 10, height - 34, plane.x, plane.y);
  const [wide, high] = plane.cells, small = document.createElement("canvas"), ratio = Math.min(3, devicePixelRatio || 1);
  small.width = wide, small.height = high;
  const pixels = new ImageData(wide, high), pen = small.getContext("2d", {willReadFrequently: true}), taken = {};
  const rgb = plane.colours.map(name => {
    const colour = colours[name], again = taken[colour] = (taken[colour] || 0) + 1;
    pen.fillStyle = again > 1 && plane.of === "start" ? colours["period" + (again % 3 + 2)] : colour;
    pen.fillRect(0, 0, 1, 1);
    return pen.getImageData(0, 0, 1, 1).data;
  });
  for (let k = 0; k < wide * high; k++) {
    const colour = rgb[plane.codes[k]], row = high - 1 - Math.floor(k / wide);
    if (colour) pixels.data.set([colour[0], colour[1], colour[2], plane.of === "map" || plane.labels[plane.codes[k]] === "undecided" ? 255 : 150], 4 * (row * wide + k % wide));
  }
  pen.putImageData(pixels, 0, 0);
  picture.width = Math.round(width * ratio), picture.height = Math.round(height * ratio);
  const view = picture.getContext("2d");
  view.scale(ratio, ratio);
  view.imageSmoothingEnabled = false;
  view.drawImage(small, axes.left, axes.top, axes.right - axes.left, axes.bottom - axes.top);
  axes.ticksX(Math.max(3, width / 90));
  axes.ticksY(6);
  axes.frame();
  add(svg, "text", {x: 4, y: 13}, plane.names[1]);
  add(svg, "text", {x: width - 10, y: height - 4, "text-anchor": "end"}, plane.names[0]);
  plane.mark = add(svg, "circle", {class: "ring", r: 7});
}

function drawPlanes() {
  data.planes.forEach(drawPlane);
  drawMarks();
}

function drawMarks() {
  for (const plane of data.planes) {
    const m = state.motion, here = m && m.origin === plane.of;
    if (!plane.mark) continue;
    plane.mark.style.display = here ? "" : "none";
    if (here) { const [cx, cy] = placeIn(plane, m); set(plane.mark, {cx: px(cx), cy: px(cy)}); }
  }
}
