/* ---- the command, and links ---- */

function command(m) {
  const value = x => x === null ? "null" : String(x);
  const start = `{q: ${value(m.q)}, v: ${value(m.v)}, theta_deg: ${data.strobe_deg}}`;
  const sets = Object.entries(m.sets).map(([key, x]) => `--set ${key}=${x}`);
  const turns = `--set run.transient=0 --set run.record=${m.turns}`;
  return ["cam simulate", data.source, `--rpm ${m.rpm}`, ...sets, turns, `--set 'run.start=${start}'`]
    .filter(Boolean).join(" ");
}

let linkLater = 0;
function keepLink() {
  clearTimeout(linkLater);
  linkLater = setTimeout(writeLink, 150);
}

/* Write the link into the address. A page inside another one may have no address of its own. */
function writeLink() {
  try {
    history.replaceState(null, "", `#${link()}`);
  } catch (refusal) {
    if (refusal.name !== "SecurityError") throw refusal;
  }
}

function link() {
  const m = state.motion, parts = {rpm: m.rpm, label: m.label, from: m.origin};
  if (!state.playing) parts.t = Number(state.t.toFixed(6));
  if (m.stable === false) parts.unstable = 1;
  if (m.q !== null) parts.q = m.q;
  if (m.place) parts.place = m.place.join("_");
  if (state.quantity !== "theta") parts.show = state.quantity;
  if (state.x) parts.view = [...state.x, ...state.y].map(v => Number(v.toPrecision(8))).join("_");
  if (state.close) parts.close = 1;
  if (state.lens !== "auto") parts.lens = state.lens;
  if ($("pace").value !== "50") parts.pace = $("pace").value;
  if (host.classList.contains("tall")) parts.tall = 1;
  if (state.presents) parts.present = 1;
  return new URLSearchParams(parts).toString();
}

const LENSES = [...$("lens").options].map(option => option.value);

/* The motion that a fragment names: the nearest speed, then what agrees most. */
function linked(parts) {
  const rpm = Number(parts.get("rpm"));
  if (!parts.has("rpm") || !Number.isFinite(rpm)) return null;
  state.wanted = rpm;
  const plane = data.planes.find(one => one.of === parts.get("from"));
  let pool = plane && plane.motions.length > 0 ? plane.motions : inDiagram;
  if (parts.get("from") === "stop") pool = motions.filter(m => m.origin === "stop");
  if (pool.length === 0) pool = inDiagram;
  const place = (parts.get("place") || "").split("_").map(Number);
  const awayFrom = m => { // in this order
    const unlike = Number(m.label !== parts.get("label")) + Number(m.origin !== parts.get("from"))
      + Number((m.stable === false) !== parts.has("unstable"));
    const start = parts.has("q") && m.q !== null ? Math.abs(m.q - parts.get("q")) : 0;
    let aside = 0;
    if (m.place && place.length === 2) aside = Math.hypot(m.place[0] - place[0], m.place[1] - place[1]);
    return [Math.abs(m.rpm - rpm), parts.has("label") ? unlike : 0, start, aside];
  };
  const ranked = pool.map(m => [awayFrom(m), m]);
  ranked.sort(([a], [b]) => a.map((x, k) => x - b[k]).find(Boolean) || 0);
  return ranked[0][1];
}

/* Show what the fragment of the address names. */
function follow() {
  const parts = new URLSearchParams(location.hash.slice(1)), m = linked(parts);
  if (parts.get("show") in QUANTITIES) state.quantity = parts.get("show");
  const view = (parts.get("view") || "").split("_").map(Number);
  if (view.length === 4 && view.every(Number.isFinite) && view[1] > view[0] && view[3] > view[2]) {
    state.x = view.slice(0, 2);
    state.y = view.slice(2);
  }
  state.lens = LENSES.includes(parts.get("lens")) ? parts.get("lens") : "auto";
  const pace = parts.has("pace") ? Number(parts.get("pace")) : 50;
  $("pace").value = Number.isFinite(pace) ? pace : 50;
  $("quantity").value = state.quantity;
  $("lens").value = state.lens;
  setClose(parts.has("close"));
  setTall(parts.has("tall"));
  setPresents(parts.has("present"));
  state.playing = false;
  drawDiagram();
  if (m === null && data.stops.length > 0) showStop(data.stops[0]);
  else choose(m || first(), Number(parts.get("t")) || 0);
  setPace();
  play(!parts.has("t") && !still.matches);
}

async function copy(text, words) {
  try {
    await navigator.clipboard.writeText(text);
  } catch {
    const area = make("textarea", {value: text});
    document.body.append(area);
    area.select();
    document.execCommand("copy");
    area.remove();
  }
  $("copied").textContent = words;
}
