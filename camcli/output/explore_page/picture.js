/* ---- the panels as a picture ---- */

/* Rules of the page's style that are about drawings, with the colours of now written out. */
function styleOfPictures() {
  const rules = [];
  for (const rule of document.styleSheets[0].cssRules) {
    if (rule.selectorText && /^(svg|\.)/.test(rule.selectorText)) rules.push(rule.cssText);
  }
  return rules.join("\n").replace(/height: 100%;|width: 100%;/g, "");
}

/* A text with each var(--name) replaced by what the page's style says of it. */
function withLiteralColours(text) {
  const style = getComputedStyle(document.documentElement);
  const literal = (_, colour) => style.getPropertyValue(`--${colour}`).trim();
  return text.replace(/var\(--([a-z0-9-]+)\)/g, literal);
}

const NOT_IN_PICTURES = ".handle, .grip, .drag-me, .label { display: none; }"; // to be dragged

/* All panels as they stand, in one SVG that needs no style from elsewhere. */
function picture() {
  const panels = [$("machine"), $("time"), $("phase"), overlay];
  const places = panels.map(node => node.getBoundingClientRect());
  const left = Math.min(...places.map(box => box.left));
  const top = Math.min(...places.map(box => box.top));
  const wide = Math.max(...places.map(box => box.right)) - left + 20;
  const high = Math.max(...places.map(box => box.bottom)) - top + 90;
  const whole = document.createElementNS(SVG, "svg");
  set(whole, {xmlns: SVG, width: wide, height: high, viewBox: `0 0 ${wide} ${high}`});
  add(whole, "style", {}, `svg { overflow: visible; }\n${NOT_IN_PICTURES}\n${styleOfPictures()}`);
  add(whole, "rect", {width: wide, height: high, fill: "var(--paper)"});
  const m = state.motion, angle = phaseAt(state.t).toFixed(1);
  add(whole, "text", {x: 10, y: 20}, `${short(m.rpm)} rpm: ${name(m)}, θ = ${angle}°`);
  panels.forEach((node, k) => {
    const box = places[k], {width, height} = box;
    const place = {x: box.left - left + 10, y: box.top - top + 40, width, height};
    if (node === overlay) add(whole, "image", {...place, href: canvas.toDataURL("image/png")});
    const copied = node.cloneNode(true);
    set(copied, place);
    whole.append(copied);
  });
  drawLegend(whole, 10, high - 22);
  return withLiteralColours(new XMLSerializer().serializeToString(whole));
}

/* The legend of the diagram in a row, as part of a picture. */
function drawLegend(svg, x, y) {
  let left = x;
  for (const item of $("legend").querySelectorAll("li")) {
    const mark = item.querySelector("i"), words = item.textContent;
    const square = {x: left, y: y - 9, width: 10, height: 10, rx: 2};
    if (mark) add(svg, "rect", {...square, fill: mark.style.background});
    add(svg, "text", {x: left + (mark ? 15 : 0), y}, words);
    left += 7 * words.length + 30;
  }
}

function save() {
  const file = new Blob([picture()], {type: "image/svg+xml"});
  const href = URL.createObjectURL(file);
  const anchor = make("a", {href, download: `cam-${state.motion.rpm}-rpm.svg`});
  anchor.click();
  setTimeout(() => URL.revokeObjectURL(anchor.href), 1000);
}
