/* ---- play ---- */

/* The slider's pace: from 40 to 0.4 seconds per turn. */
function setPace() {
  state.pace = 0.4 * 10 ** ((100 - $("pace").value) / 50);
  showPace();
}

/* How much slower than the machine it is; that changes with the speed. */
function showPace() {
  const slower = state.pace * state.motion.rpm / 60;
  let words = `${Number(slower.toPrecision(2))}× slower`;
  if (slower < 0.95) words = `${(1 / slower).toPrecision(2)}× faster`;
  $("slowed").textContent = words;
}

let lastClock = null;
function frame(clock) {
  if (state.playing && lastClock !== null) {
    const from = state.t, {end} = state.motion;
    state.t += Math.min(clock - lastClock, 100) / 1000 / state.pace;
    soundImpacts(from, Math.min(state.t, end));
    if (state.t >= end) state.t = end > 0 ? state.t % end : 0;
    drawNow();
  }
  lastClock = clock;
  requestAnimationFrame(frame);
}

function play(on) {
  state.playing = on;
  $("play").textContent = on ? "Pause" : "Play";
  if (on) return;
  drawNow();
  keepLink();
}

/* To the next event, or the one before. */
function step(way) {
  const m = state.motion, {t, kind, u} = data.events;
  const times = [...t.subarray(m.event, m.event + m.events)].filter(time => time <= m.end);
  play(false);
  if (times.length === 0) return;
  const tiny = 1e-6;
  const ahead = times.find(time => time > state.t + tiny);
  const behind = times.findLast(time => time < state.t - tiny);
  if (way > 0) state.t = ahead === undefined ? times[0] : ahead;
  else state.t = behind === undefined ? times[times.length - 1] : behind;
  drawNow();
  const k = m.event + times.indexOf(state.t);
  const speed = u[k] ? `, u⁻ ${fixed(u[k], 3)} m/s` : "";
  machine.angle.textContent = `θ ${phaseAt(state.t).toFixed(1)}°: ${KINDS[kind[k]]}${speed}`;
  $("copied").textContent = "";
  keepLink();
}

/* Move along the time response. */
function seek(event) {
  const [x] = pointerIn($("time"), event), t = time.upper.fromX(x);
  play(false);
  state.t = Math.max(time.span[0], Math.min(t, time.span[1], state.motion.end));
  drawNow();
  keepLink();
}

/* ---- sound: a click for each impact, off until it is asked for ---- */

const MOST_CLICKS = 4; // of one frame
let speaker = null;

function switchSound() {
  state.sound = !state.sound;
  if (state.sound && speaker === null) speaker = new AudioContext();
  set($("sound"), {"aria-pressed": state.sound});
}

/* Clicks of the impacts from time to time; harder ones are louder. */
function soundImpacts(from, to) {
  if (!state.sound) return;
  const m = state.motion, {t, kind, u} = data.events, hardest = largestImpact(m);
  let clicks = 0;
  for (let k = m.event; k < m.event + m.events && clicks < MOST_CLICKS; k++) {
    if (kind[k] !== IMPACT || t[k] <= from || t[k] > to) continue;
    click(Math.abs(u[k]) / hardest);
    clicks += 1;
  }
}

function click(loudness) {
  const tone = speaker.createOscillator(), volume = speaker.createGain(), now = speaker.currentTime;
  tone.frequency.value = 180 + 500 * loudness;
  volume.gain.setValueAtTime(0.25 * loudness ** 0.6, now);
  volume.gain.exponentialRampToValueAtTime(1e-4, now + 0.07);
  tone.connect(volume).connect(speaker.destination);
  tone.start(now);
  tone.stop(now + 0.08);
}
