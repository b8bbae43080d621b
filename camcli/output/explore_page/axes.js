/* ---- drawing ---- */

const SVG = "http://www.w3.org/2000/svg";

function add(parent, tag, attributes = {}, text) {
  const node = document.createElementNS(SVG, tag);
  set(node, attributes);
  if (text !== undefined) node.textContent = text;
  parent.append(node);
  return node;
}

function set(node, attributes) {
  for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
}

/* An element of HTML. */
function make(tag, properties = {}, attributes = {}) {
  const node = Object.assign(document.createElement(tag), properties);
  set(node, attributes);
  return node;
}

function px(length) {
  return length.toFixed(2);
}

function isPrinting() {
  return document.documentElement.classList.contains("printing");
}

/* How many pixels of the screen a unit of a drawing has: letters grow with it. */
let letters = 1;

/* Letters as large as the window, or the room, asks for. */
function fitLetters() {
  const {style} = document.documentElement;
  letters = isPrinting() ? 1 : lettersFor(innerWidth, innerHeight, state.presents);
  style.setProperty("--letters", letters.toFixed(3));
}

/* The size of a panel in units of its drawing, measured once: to measure it again costs a layout
   of the whole page. */
const boxes = new Map();
function boxOf(node) {
  if (!boxes.has(node)) {
    const {width, height} = node.getBoundingClientRect();
    const size = {width: Math.max(200, width / letters), height: Math.max(100, height / letters)};
    boxes.set(node, size);
  }
  return boxes.get(node);
}

/* Where a pointer is in a panel, in units of its drawing. */
function pointerIn(node, event) {
  const {left, top} = node.getBoundingClientRect();
  return [(event.clientX - left) / letters, (event.clientY - top) / letters];
}

/* A panel without what was drawn in it. */
function emptied(id) {
  const svg = typeof id === "string" ? $(id) : id;
  svg.replaceChildren(...[...svg.children].filter(node => node.tagName === "title"));
  const {width, height} = boxOf(svg);
  svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
  return {svg, width, height};
}

/* A pen on a canvas of this size, as fine as the screen, or as paper. */
function penOf(surface, width, height) {
  const ratio = isPrinting() ? 3 : letters * Math.min(3, devicePixelRatio || 1);
  surface.width = Math.round(width * ratio);
  surface.height = Math.round(height * ratio);
  const pen = surface.getContext("2d");
  pen.scale(ratio, ratio);
  return pen;
}

const WIDTH_OF_A_DIGIT = 7.6; // px, at most, in small letters
const BESIDE_AXES = 8; // px: the room that there is right of any axes

/* A rectangle of a panel with a linear scale in x and y. */
class Axes {
  constructor(svg, left, top, right, bottom, x, y) {
    Object.assign(this, {svg, left, top, right, bottom, x, y});
    this.width = right - left;
    this.height = bottom - top;
  }
  X(value) {
    return this.left + (value - this.x[0]) / (this.x[1] - this.x[0]) * this.width;
  }
  Y(value) {
    return this.bottom - (value - this.y[0]) / (this.y[1] - this.y[0]) * this.height;
  }
  fromX(pixel) {
    return this.x[0] + (pixel - this.left) / this.width * (this.x[1] - this.x[0]);
  }
  fromY(pixel) {
    return this.y[0] + (this.bottom - pixel) / this.height * (this.y[1] - this.y[0]);
  }
  holds(x, y) {
    return x >= this.left && x <= this.right && y >= this.top && y <= this.bottom;
  }
  ticksY(most, ticks = ticksOf(...this.y, most)) {
    for (const [value, text] of ticks) {
      const y = this.Y(value);
      add(this.svg, "line", {class: "grid", x1: this.left, x2: this.right, y1: px(y), y2: px(y)});
      const place = {x: this.left - 5, y: px(y + 4), "text-anchor": "end"};
      add(this.svg, "text", {class: "small", ...place}, text);
    }
  }
  ticksX(most, ticks = ticksOf(...this.x, most)) {
    for (const [value, text] of ticks) {
      const x = px(this.X(value)), half = text.length * WIDTH_OF_A_DIGIT / 2;
      const place = {x: px(Math.min(x, this.right + BESIDE_AXES - half)), y: this.bottom + 15};
      add(this.svg, "line", {class: "grid", x1: x, x2: x, y1: this.top, y2: this.bottom});
      add(this.svg, "text", {class: "small", ...place, "text-anchor": "middle"}, text);
    }
  }
  frame() {
    const path = `M${this.left} ${this.top}V${this.bottom}H${this.right}`;
    add(this.svg, "path", {class: "lines axis", d: path});
  }
  /* A group of which only what is inside these axes is seen. */
  clip() {
    const id = `${this.svg.id}-clip${this.top.toFixed(0)}`, path = add(this.svg, "clipPath", {id});
    add(path, "rect", {x: this.left, y: this.top, width: this.width, height: this.height});
    return add(this.svg, "g", {"clip-path": `url(#${id})`});
  }
}
