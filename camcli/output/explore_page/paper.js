/* ---- paper: the page as narrow as it is printed, in the colours of light ---- */

function drawAll() {
  fitLetters();
  reserveWords();
  boxes.clear();
  readColours();
  fitSaid();
  drawMotion();
  drawDiagram();
  drawPlanes();
}

function layOutForPaper(on) {
  const {classList} = document.documentElement;
  classList.toggle("printing", on);
  classList.toggle("presenting", state.presents && !on);
  drawAll();
  for (const image of document.querySelectorAll(".on-paper")) image.remove();
  if (on) document.querySelectorAll("canvas").forEach(putImageOver);
}

/* An image of a canvas in its place: browsers print a canvas beside its axes by some pixels. */
function putImageOver(surface) {
  surface.after(make("img", {src: surface.toDataURL("image/png"), className: "on-paper", alt: ""}));
}

addEventListener("beforeprint", () => layOutForPaper(true));
addEventListener("afterprint", () => layOutForPaper(false));
