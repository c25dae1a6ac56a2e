// The page of a drop: clock, slider, keys, comparison; the view in space and the panels follow.

import { costCss, css } from "./colors.js";
import { Plots } from "./plots.js";
import { Run } from "./run.js";
import { Scene, VIEWS } from "./scene.js";
import { fixed, signed } from "./words.js";

const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 5, 10];
/** The page opens this long before the release [s]. */
const OPENS_BEFORE_S = 1.2;
/** Frames over which the pace of drawing is judged, and the longest that one may take [ms]. */
const [JUDGED_FRAMES, LONGEST_FRAME_MS] = [12, 36];

const find = (selector) => document.querySelector(selector);
const run = Run.fromObject(JSON.parse(find("#drop").textContent));
const { motion, about } = run;
const still = matchMedia("(prefers-reduced-motion: reduce)").matches;
const state = { t: motion.start, playing: false, speed: 1, dirty: true, frames: 0, since: 0 };

const released = about.times.released_s;
const opening = Math.max(motion.start, (released ?? motion.start) - OPENS_BEFORE_S);
const steady = about.times.steady_s;

/** Times since t = 0 that show the manoeuvre: from the release to steady, and a fifth on. */
function manoeuvre() {
  const [first, last] = [motion.start - motion.zero, motion.end - motion.zero];
  if (released === null) return [first, last];
  const from = released - motion.zero;
  const plansEnd = run.plan ? run.plan.end - motion.zero : last;
  const to = steady == null ? Math.min(last, plansEnd) : Math.min(last, (steady - motion.zero) * 1.2);
  const margin = 0.06 * Math.max(to - from, 0.5);
  return [Math.max(first, from - margin), Math.max(to, from + 1)];
}

function seek(t) {
  state.t = Math.min(motion.end, Math.max(motion.start, t));
  state.dirty = true;
}

function play(on = !state.playing) {
  if (on && state.t >= motion.end - 1e-6) seek(opening);
  state.playing = on;
  scene?.rest(!on);
  state.frames = 0;
  state.last = null;
  find("#play").setAttribute("aria-label", on ? "pause" : "play");
  document.body.classList.toggle("playing", on);
  document.body.classList.toggle("begun", on || document.body.classList.contains("begun"));
  state.dirty = true;
}

function setSpeed(speed) {
  state.speed = speed;
  find("#speed").value = String(speed);
}

// ---- the view in space ----

let scene = null;
try {
  scene = new Scene(find("#stage"), run, { still, until: manoeuvre()[1] + motion.zero });
  scene.onChange = () => (state.dirty = true);
} catch (error) {
  find("#no-webgl").hidden = false;
  find("#no-webgl").title = String(error);
}

function look(view) {
  if (!scene) return;
  scene.look(view);
  for (const button of document.querySelectorAll("[data-view]")) {
    button.setAttribute("aria-pressed", String(button.dataset.view === view));
  }
}

// ---- the panels ----

const plots = new Plots(find("#panels"), run, { onSeek: seek, range: manoeuvre() });
find("#zoom-manoeuvre").addEventListener("click", () => plots.zoom(...manoeuvre()));
find("#zoom-all").addEventListener("click", () => plots.zoom(...plots.full));

// ---- the time line ----

const slider = find("#time");
slider.min = String(motion.start);
slider.max = String(motion.end);
slider.addEventListener("input", () => {
  seek(Number(slider.value));
  document.body.classList.add("begun");
});
find("#play").addEventListener("click", () => play());
find("#begin").addEventListener("click", () => play(true));
find("#speed").addEventListener("change", (event) => setSpeed(Number(event.target.value)));
for (const speed of SPEEDS) {
  const option = new Option(`${speed}\u00d7`, String(speed));
  find("#speed").append(option);
}

/** J_state over all of the time line as a strip of colour. */
function drawStrip() {
  const canvas = find("#strip");
  const width = Math.max(1, Math.round(canvas.clientWidth * (window.devicePixelRatio || 1)));
  canvas.width = width;
  canvas.height = 1;
  const pen = canvas.getContext("2d");
  for (let x = 0; x < width; x++) {
    const t = motion.start + ((x + 0.5) / width) * (motion.end - motion.start);
    const judged = released !== null && t >= released;
    pen.fillStyle = judged ? costCss(motion.j[motion.index(t)]) : css("edge");
    pen.fillRect(x, 0, 1, 1);
  }
}

const share = (t) => (motion.end > motion.start ? (t - motion.start) / (motion.end - motion.start) : 0);
const marks = about.marks.filter(({ t_s }) => t_s >= motion.start && t_s <= motion.end);
for (const { t_s, text, short } of marks) {
  const tick = document.createElement("i");
  tick.style.left = `${100 * share(t_s)}%`;
  tick.title = text;
  find("#ticks").append(tick);
  const button = document.createElement("button");
  const time = document.createElement("span");
  time.textContent = `${signed(t_s - motion.zero)} s`;
  button.append(time, ` ${short}`);
  button.title = `${text}: go there`;
  button.addEventListener("click", () => {
    seek(t_s);
    document.body.classList.add("begun");
  });
  find("#events").append(button);
}

function nextEvent(direction) {
  const ahead = marks.map((m) => m.t_s).filter((t) => (t - state.t) * direction > 1e-6);
  if (ahead.length) seek(direction > 0 ? Math.min(...ahead) : Math.max(...ahead));
}

// ---- what is shown of an instant ----

function phaseWords(t) {
  const phase = motion.phase ? motion.phase[motion.index(t)] : 2;
  if (about.standing && phase === 0) return "standing on the ground";
  if (phase === 0) return "hanging under the parachute";
  if (phase === 1) return "falling, rotors off";
  if (steady != null && t >= steady - 1e-6) return "steady at the target velocity";
  return "flying under power";
}

function put(selector, text) {
  const element = find(selector);
  if (element.textContent !== text) element.textContent = text;
}

function report(t) {
  const since = t - motion.zero;
  const j = motion.value(motion.j, t);
  if (!state.playing || performance.now() - (state.readAt ?? 0) > 60) {
    state.readAt = performance.now();
    put("#clock", `${signed(since)} s`);
    put("#now", fixed(j, 2));
    slider.setAttribute("aria-valuetext", `${fixed(since, 2)} s after the rotors were freed, ${phaseWords(t)}`);
  }
  put("#phase", phaseWords(t));
  const needle = find("#needle");
  needle.style.transform = `translateX(${Math.min(1, Math.max(0, j)) * barWidth}px)`;
  needle.style.visibility = Number.isFinite(j) ? "visible" : "hidden";
  const note = scene && scene.enlarged > 1.05 ? `vehicle drawn ${fixed(scene.enlarged, scene.enlarged < 10 ? 1 : 0)}\u00d7 its size` : "";
  put("#enlarged", note);
  slider.value = String(t);
  find("#passed").style.transform = `scaleX(${share(t)})`;
}

function frame(now) {
  const watchedS = state.playing && state.last != null ? Math.min(0.25, (now - state.last) / 1000) : 0;
  if (state.playing) {
    judgePace(now);
    state.last = now;
    seek(state.t + watchedS * state.speed);
    if (state.t >= motion.end) play(false);
  }
  if (state.dirty) {
    state.dirty = false;
    const turns = scene?.show(state.t, watchedS);
    scene?.render();
    plots.resting = !state.playing;
    plots.show(state.t);
    report(state.t);
    state.drawn = (state.drawn ?? 0) + 1;
    if (turns) state.dirty = true;
  }
  requestAnimationFrame(frame);
}

/** Draws coarser where the machine is too slow. */
function judgePace(now) {
  if (state.frames === 0) state.since = now;
  if (state.frames++ < JUDGED_FRAMES) return;
  const each = (now - state.since) / JUDGED_FRAMES;
  state.frames = 0;
  if (each > LONGEST_FRAME_MS) scene?.coarser();
}

// ---- another run beside this one ----

async function compare(file) {
  const chip = find("#comparison");
  try {
    const text = await file.text();
    const other = /^\s*</.test(text) ? Run.fromHtml(text) : Run.fromCsv(text, file.name);
    scene?.compare(other);
    plots.compare(other);
    const theirs = other.about.verdict?.j_tpf;
    const mine = about.verdict?.j_tpf;
    const gains = other.about.gains ? `, gains ${other.about.gains}` : "";
    const costs = theirs == null || mine == null ? "" : `: J_TPF ${fixed(theirs, 3)} there, ${fixed(mine, 3)} here`;
    put("#comparison-text", `compared with ${file.name} (${other.about.mission}${gains})${costs}`);
    chip.classList.remove("failed");
  } catch (error) {
    put("#comparison-text", `${file.name} cannot be compared: ${error.message}`);
    chip.classList.add("failed");
  }
  chip.hidden = false;
  state.dirty = true;
}

function compareNo() {
  find("#comparison").hidden = true;
  scene?.compare(null);
  plots.compare(null);
  state.dirty = true;
}

find("#compare").addEventListener("click", () => find("#file").click());
find("#file").addEventListener("change", (event) => {
  if (event.target.files[0]) compare(event.target.files[0]);
  event.target.value = "";
});
find("#comparison-end").addEventListener("click", compareNo);
let over = 0;
addEventListener("dragenter", (event) => {
  if (![...(event.dataTransfer?.types ?? [])].includes("Files")) return;
  over++;
  find("#drop-here").hidden = false;
});
addEventListener("dragleave", () => {
  over = Math.max(0, over - 1);
  if (over === 0) find("#drop-here").hidden = true;
});
addEventListener("dragover", (event) => event.preventDefault());
addEventListener("drop", (event) => {
  event.preventDefault();
  over = 0;
  find("#drop-here").hidden = true;
  const file = event.dataTransfer?.files[0];
  if (file) compare(file);
});

// ---- light and dark ----

const darkSystem = matchMedia("(prefers-color-scheme: dark)");
const isDark = () => (document.documentElement.dataset.theme ?? (darkSystem.matches ? "dark" : "light")) === "dark";

function recolor() {
  find("#theme").setAttribute("aria-pressed", String(isDark()));
  scene?.build();
  plots.build();
  drawStrip();
  state.dirty = true;
}

function toggleTheme() {
  document.documentElement.dataset.theme = isDark() ? "light" : "dark";
  recolor();
}

find("#theme").addEventListener("click", toggleTheme);
darkSystem.addEventListener("change", recolor);

// ---- keys ----

const help = find("#help");
find("#help-open").addEventListener("click", () => help.showModal());
find("#help-close").addEventListener("click", () => help.close());

const step = (by) => {
  play(false);
  seek(state.t + by);
};
const faster = (by) => setSpeed(SPEEDS[Math.min(SPEEDS.length - 1, Math.max(0, SPEEDS.indexOf(state.speed) + by))]);
const KEYS = {
  " ": () => play(),
  ArrowLeft: (event) => step(event.shiftKey ? -1 : -0.1),
  ArrowRight: (event) => step(event.shiftKey ? 1 : 0.1),
  Home: () => seek(motion.start),
  End: () => seek(motion.end),
  n: () => nextEvent(1),
  p: () => nextEvent(-1),
  "[": () => faster(-1),
  "]": () => faster(1),
  "+": () => plots.zoomBy(0.5),
  "-": () => plots.zoomBy(2),
  0: () => plots.zoom(...plots.full),
  m: () => plots.zoom(...manoeuvre()),
  c: () => find("#file").click(),
  d: toggleTheme,
  "?": () => help.showModal(),
  ...Object.fromEntries(VIEWS.map((view, i) => [String(i + 1), () => look(view)])),
};

addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.metaKey || event.altKey || help.open) return;
  const { target } = event;
  if (target.tagName === "SELECT" || (target.tagName === "BUTTON" && event.key === " ")) return;
  const act = KEYS[event.key];
  if (!act) return;
  event.preventDefault();
  act(event);
  if (["ArrowLeft", "ArrowRight", "Home", "End"].includes(event.key)) document.body.classList.add("begun");
});

for (const button of document.querySelectorAll("[data-view]")) {
  button.addEventListener("click", () => look(button.dataset.view));
}
let barWidth = 0;
function measure() {
  barWidth = find(".bar").clientWidth;
  drawStrip();
  state.dirty = true;
}
addEventListener("resize", measure);

setSpeed(1);
measure();
const asked = Number(new URLSearchParams(location.hash.slice(1)).get("t"));
seek(Number.isFinite(asked) && location.hash.includes("t=") ? asked : opening);
requestAnimationFrame(frame);

/** For tests: what is shown. */
window.replay = {
  get time() {
    return state.t;
  },
  get playing() {
    return state.playing;
  },
  get drawn() {
    return state.drawn ?? 0;
  },
  get vehicle() {
    return scene?.shownPosition();
  },
  get range() {
    return plots.range;
  },
  parts: { scene, plots },
  get pixelRatio() {
    return scene?.ratio;
  },
  seek,
};
