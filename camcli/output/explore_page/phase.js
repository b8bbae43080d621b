/* ---- the phase plane ---- */

const PHASE_ERROR = 0.1; // px

function drawPhase() {
  const m = state.motion, {svg, width, height} = emptied("phase");
  const {far, low, high} = extentOf(m), {unit, factor} = lengths(far);
  const flies = far > 0 && high > low, wide = flies ? far * factor : 1, tall = flies ? high - low : 2;
  const middle = (low + high) / 2, half = 0.55 * tall;
  const x = [-0.05 * wide, 1.06 * wide], y = [middle - half, middle + half];
  phase = new Axes(svg, 46, 24, width - 8, height - 34, x, y);
  phase.factor = factor;
  if (flies) { // else there is nothing to measure
    phase.ticksX(Math.max(2, width / 75));
    phase.ticksY(6);
  }
  const inside = phase.clip(), zero = px(phase.X(0));
  add(inside, "line", {class: "axis", x1: zero, x2: zero, y1: phase.top, y2: phase.bottom});
  const toPixels = (gap, u) => [phase.X(gap * factor), phase.Y(u)];
  const toText = line => "M" + line.map(([left, down]) => `${px(left)} ${px(down)}`).join("L");
  const lines = flightLines(m, toPixels, PHASE_ERROR);
  add(inside, "path", {class: "lines flight", id: "flights", d: lines.map(toText).join("")});
  add(inside, "path", {class: "lines jump", id: "jumps", d: jumpPath(m, zero)});
  phase.frame();
  if (!flies) {
    const place = {x: (phase.left + phase.right) / 2, y: phase.Y(0) - 12, "text-anchor": "middle"};
    add(svg, "text", {class: "small", ...place}, "no flight");
  }
  add(svg, "text", {x: 4, y: 13}, "relative velocity u (m/s)");
  add(svg, "text", {x: width - 8, y: height - 4, "text-anchor": "end"}, `${TERMS.gap} (${unit})`);
  phase.dot = add(svg, "circle", {class: "dot", r: 5});
}

/* Impacts in the phase plane: from the relative velocity before to the one after. */
function jumpPath(m, zero) {
  const {t, v} = data.rows;
  let path = "";
  for (let k = m.row + 1; k < m.row + m.rows; k++) {
    if (t[k] !== t[k - 1]) continue;
    const u = speedOfImpact(m, k);
    path += `M${zero} ${px(phase.Y(u))}V${px(phase.Y(u + v[k] - v[k - 1]))}`;
  }
  return path;
}
