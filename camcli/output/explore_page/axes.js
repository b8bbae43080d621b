/* ---- drawing ---- */

const SVG = "http://www.w3.org/2000/svg";
function add(parent, tag, attributes = {}, text) {
  const node = document.createElementNS(SVG, tag);
  for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
  if (text !== undefined) node.textContent = text;
  parent.append(node);
  return node;
}
const set = (node, attributes) => { for (const key in attributes) node.setAttribute(key, attributes[key]); };
const px = x => x.toFixed(2);

function emptied(id) {
  const svg = typeof id === "string" ? $(id) : id;
  svg.replaceChildren(...[...svg.children].filter(node => node.tagName === "title"));
  const box = svg.getBoundingClientRect(), width = Math.max(200, box.width), height = Math.max(200, box.height);
  svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
  return {svg, width, height};
}

/* A rectangle of a panel with a linear scale in x and y. */
class Axes {
  constructor(svg, left, top, right, bottom, x, y) {
    Object.assign(this, {svg, left, top, right, bottom, x, y});
  }
  X(value) { return this.left + (value - this.x[0]) / (this.x[1] - this.x[0]) * (this.right - this.left); }
  Y(value) { return this.bottom - (value - this.y[0]) / (this.y[1] - this.y[0]) * (this.bottom - this.top); }
  fromX(pixel) { return this.x[0] + (pixel - this.left) / (this.right - this.left) * (this.x[1] - this.x[0]); }
  fromY(pixel) { return this.y[0] + (this.bottom - pixel) / (this.bottom - this.top) * (this.y[1] - this.y[0]); }
  holds(x, y) { return x >= this.left && x <= this.right && y >= this.top && y <= this.bottom; }
  ticksY(most, ticks = ticksOf(...this.y, most)) {
    for (const [value, text] of ticks) {
      add(this.svg, "line", {class: "grid", x1: this.left, x2: this.right, y1: px(this.Y(value)), y2: px(this.Y(value))});
      add(this.svg, "text", {class: "small", x: this.left - 5, y: px(this.Y(value) + 4), "text-anchor": "end"}, text);
    }
  }
  ticksX(most, ticks = ticksOf(...this.x, most)) {
    for (const [value, text] of ticks) {
      add(this.svg, "line", {class: "grid", x1: px(this.X(value)), x2: px(this.X(value)), y1: this.top, y2: this.bottom});
      add(this.svg, "text", {class: "small", x: px(this.X(value)), y: this.bottom + 15, "text-anchor": "middle"}, text);
    }
  }
  frame() {
    add(this.svg, "path", {class: "lines axis", d: `M${this.left} ${this.top}V${this.bottom}H${this.right}`});
  }
  clip() {
    const id = this.svg.id + "-clip" + this.top.toFixed(0);
    const path = add(this.svg, "clipPath", {id});
    add(path, "rect", {x: this.left, y: this.top, width: this.right - this.left, height: this.bottom - this.top});
    return add(this.svg, "g", {"clip-path": `url(#${id})`});
  }
}
