/* ---- basins and map: planes with a motion for some of their places ---- */

const ARROW_KEYS = {ArrowRight: [1, 0], ArrowLeft: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1]};

function buildPlane(plane) {
  plane.motions = motions.filter(m => m.origin === plane.of);
  const title = `${plane.of}-title`;
  const section = make("section", {className: "panel"}, {"aria-labelledby": title});
  const label = {role: "application", "aria-label": `${plane.name}: arrow keys choose a place`};
  const box = make("div", {className: "plane", id: `${plane.of}-plane`, tabIndex: 0}, label);
  plane.canvas = make("canvas");
  plane.svg = document.createElementNS(SVG, "svg");
  set(plane.svg, {id: `${plane.of}-axes`, "aria-hidden": true});
  box.append(plane.canvas, plane.svg);
  const head = make("h2", {id: title, textContent: plane.name});
  const words = make("p", {className: "faint", textContent: `${plane.words} `});
  words.append(make("span", {className: "on-screen", textContent: "Click a place to see its motion."}));
  section.append(head, words, box);
  $("planes").append(section);
  const placeOfPointer = event => pointerIn(box, event);
  box.addEventListener("click", event => chooseIn(plane, ...placeOfPointer(event)));
  box.addEventListener("pointermove", event => {
    box.title = kindIn(plane, ...placeOfPointer(event));
  });
  box.addEventListener("keydown", event => {
    const way = ARROW_KEYS[event.key];
    if (!way) return;
    event.preventDefault();
    moveIn(plane, way);
  });
}
data.planes.forEach(buildPlane);

function placeIn({axes}, m) {
  return [axes.X(m.place[0]), axes.Y(m.place[1])];
}

/* Choose the motion whose place is nearest. */
function chooseIn(plane, x, y) {
  let best = null, least = Infinity;
  for (const m of plane.motions) {
    const [right, down] = placeIn(plane, m), far = Math.hypot(right - x, down - y);
    if (far >= least) continue;
    least = far;
    best = m;
  }
  if (best) choose(best);
}

/* Choose the next motion to one side: way is (right, up). */
function moveIn(plane, [right, up]) {
  const start = state.motion.origin === plane.of ? state.motion : plane.motions[0];
  const [x, y] = placeIn(plane, start);
  let best = null, least = Infinity;
  for (const m of plane.motions) {
    const [otherX, otherY] = placeIn(plane, m);
    const ahead = right * (otherX - x) - up * (otherY - y);
    const aside = Math.abs(right ? otherY - y : otherX - x);
    if (ahead <= 0.5 || aside >= 0.5 || ahead >= least) continue;
    least = ahead;
    best = m;
  }
  if (best) choose(best);
}

/* The motion at a place: of a map its period, as the map has no more. */
function kindIn({axes, cells, codes, labels}, x, y) {
  if (!axes.holds(x, y)) return "";
  const [columns, rows] = cells;
  const column = Math.min(columns - 1, Math.floor((x - axes.left) / axes.width * columns));
  const row = Math.min(rows - 1, Math.floor((axes.bottom - y) / axes.height * rows));
  const label = labels[codes[row * columns + column]];
  return label === undefined ? "below the cam" : shown(label);
}

/* The colour of each attractor or kind as [red, green, blue]. Attractors of one period in basins
   take the colours of other periods in turn. */
function coloursOfPlane(plane, pen) {
  const taken = {};
  return plane.colours.map(colourName => {
    let colour = colours[plane.of === "map" ? `area-${colourName}` : colourName];
    taken[colour] = (taken[colour] || 0) + 1;
    if (taken[colour] > 1 && plane.of === "start") colour = colours[`period${taken[colour] % 3 + 2}`];
    pen.fillStyle = colour;
    pen.fillRect(0, 0, 1, 1);
    return pen.getImageData(0, 0, 1, 1).data;
  });
}

/* The code that most cells have. */
function widestIn({codes, labels}) {
  const many = labels.map(() => 0);
  for (const code of codes) if (code < many.length) many[code]++;
  return many.indexOf(Math.max(...many));
}

const PALE = 70, STRONG = 180; // opacity of the widest basin, of the others

/* The cells as a picture of one pixel each. */
function cellsOf(plane) {
  const [columns, rows] = plane.cells, small = make("canvas", {width: columns, height: rows});
  const pen = small.getContext("2d", {willReadFrequently: true});
  const pixels = new ImageData(columns, rows), rgb = coloursOfPlane(plane, pen);
  const widest = widestIn(plane);
  for (let k = 0; k < columns * rows; k++) {
    const code = plane.codes[k], colour = rgb[code];
    if (!colour) continue;
    const isFull = plane.of === "map" || plane.labels[code] === "undecided";
    const pale = code === widest ? PALE : STRONG;
    const row = rows - 1 - Math.floor(k / columns), column = k % columns;
    const [red, green, blue] = colour, opacity = isFull ? 255 : pale;
    pixels.data.set([red, green, blue, opacity], 4 * (row * columns + column));
  }
  pen.putImageData(pixels, 0, 0);
  return small;
}

function drawPlane(plane) {
  const {svg, width, height} = emptied(plane.svg);
  const axes = plane.axes = new Axes(svg, 54, 24, width - 10, height - 34, plane.x, plane.y);
  const view = penOf(plane.canvas, width, height);
  view.imageSmoothingEnabled = false;
  view.drawImage(cellsOf(plane), axes.left, axes.top, axes.width, axes.height);
  axes.ticksX(Math.max(4, width / 90));
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

/* A ring at the place of the chosen motion. */
function drawMarks() {
  const m = state.motion;
  for (const plane of data.planes) {
    if (!plane.mark) continue;
    const isHere = m && m.origin === plane.of;
    plane.mark.style.display = isHere ? "" : "none";
    if (!isHere) continue;
    const [cx, cy] = placeIn(plane, m);
    set(plane.mark, {cx: px(cx), cy: px(cy)});
  }
}
