// The page of one flight: clock, time line, events, the view in space and the panels; another flight may take
// its place, and one may be laid beside it.

import { costCss, css, forgetColors } from "./colors.js";
import { Plots } from "./plots.js";
import { Scene } from "./scene.js";
import { fixed, signed } from "./words.js";

const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 5, 10];
/** The page opens this long before the release [s]. */
const OPENS_BEFORE_S = 1.2;
/** Frames over which the pace of drawing is judged, and the longest that one may take [ms]. */
const [JUDGED_FRAMES, LONGEST_FRAME_MS] = [12, 36];
/** A flight that goes on is followed by about so much [s]; its panels grow by so much at a time [s]. */
const [BEHIND_S, MORE_S] = [0.12, 5];
/** The panels' times stay while what they should show is within this share of them. */
const STEADY_ZOOM = 0.35;

export const find = (selector) => document.querySelector(selector);

export function put(selector, text) {
  const element = find(selector);
  if (element.textContent !== text) element.textContent = text;
}

/** Times since t = 0 that show the manoeuvre: from the release to steady, and a fifth on. */
function manoeuvre({ motion, about, plan }) {
  const { released_s: released, steady_s: steady } = about.times;
  const [first, last] = [motion.start - motion.zero, motion.end - motion.zero];
  if (released === null) return [first, last];
  const from = released - motion.zero;
  const plansEnd = plan ? plan.end - motion.zero : last;
  const to = steady == null ? Math.min(last, plansEnd) : Math.min(last, (steady - motion.zero) * 1.2);
  const margin = 0.06 * Math.max(to - from, 0.5);
  return [Math.max(first, from - margin), Math.max(to, from + 1)];
}

/** Times since t = 0 that the panels show of a flight that goes on: with room for what comes. */
function soFar(run) {
  const [from, to] = manoeuvre(run);
  return [from, from + MORE_S * Math.ceil((to - from) / MORE_S)];
}

export class Player {
  constructor(run) {
    this.still = matchMedia("(prefers-reduced-motion: reduce)").matches;
    Object.assign(this, { playing: false, follows: false, dirty: true, frames: 0, since: 0, drawn: 0, barWidth: 0 });
    this.take(run);
    this.time = run.motion.start;
    const range = manoeuvre(run);
    this.scene = null;
    try {
      this.scene = new Scene(find("#stage"), run, { still: this.still, until: range[1] + run.motion.zero });
      this.scene.onChange = () => (this.dirty = true);
    } catch (error) {
      find("#no-webgl").hidden = false;
      find("#no-webgl").title = String(error);
    }
    this.plots = new Plots(find("#panels"), run, { onSeek: (t) => this.seek(t), range });
    this.wire();
    this.setSpeed(1);
    this.measure();
    this.seek(this.opening);
    requestAnimationFrame((now) => this.frame(now));
  }

  /** What the page has of a run: its time line and events. */
  take(run) {
    const { motion, about } = run;
    Object.assign(this, { run, motion, about, released: about.times.released_s, steady: about.times.steady_s });
    this.opening = Math.max(motion.start, (this.released ?? motion.start) - OPENS_BEFORE_S);
    const slider = find("#time");
    slider.min = String(motion.start);
    slider.max = String(motion.end);
    this.marks = about.marks.filter(({ t_s }) => t_s >= motion.start && t_s <= motion.end);
    find("#ticks").replaceChildren(...this.marks.map((mark) => this.tick(mark)));
    // Buttons that somebody is about to press stay.
    const shown = JSON.stringify([this.marks, motion.zero]);
    if (shown !== this.shownEvents) find("#events").replaceChildren(...this.marks.map((mark) => this.event(mark)));
    this.shownEvents = shown;
  }

  /** Another run in place of this one, at the same time since t = 0; view and panels stay as they are. */
  open(run) {
    const since = this.time - this.motion.zero;
    this.take(run);
    const range = manoeuvre(run);
    this.scene?.open(run, range[1] + run.motion.zero);
    const { range: shown } = this.plots;
    const far = STEADY_ZOOM * (shown[1] - shown[0]);
    const stays = this.plots.zoomed || range.every((t, k) => Math.abs(t - shown[k]) < far);
    this.plots.open(run, stays ? shown : range);
    this.drawStrip();
    this.seek(run.motion.zero + since);
  }

  /** The flight has gone on: this is what there is of it. */
  grow(run) {
    this.take(run);
    this.scene?.grow(run);
    this.plots.open(run, this.plots.zoomed ? this.plots.range : soFar(run));
    this.drawStrip();
    this.dirty = true;
  }

  /** To the newest instant of a flight that goes on, and on with it. */
  follow() {
    this.follows = true;
    if (!this.playing) this.play(true);
  }

  /** Another run beside this one, by a name; none to end that. */
  compare(run, name) {
    this.scene?.compare(run, name);
    this.plots.compare(run);
    this.dirty = true;
  }

  wire() {
    const begun = () => document.body.classList.add("begun");
    const slider = find("#time");
    slider.addEventListener("input", () => {
      this.seek(Number(slider.value));
      begun();
    });
    find("#events").addEventListener("click", begun);
    find("#play").addEventListener("click", () => this.play());
    find("#begin").addEventListener("click", () => this.play(true));
    find("#speed").addEventListener("change", (event) => this.setSpeed(Number(event.target.value)));
    find("#speed").append(...SPEEDS.map((speed) => new Option(`${speed}\u00d7`, String(speed))));
    find("#zoom-manoeuvre").addEventListener("click", () => this.zoomManoeuvre());
    find("#zoom-all").addEventListener("click", () => this.plots.zoom(...this.plots.full));
    for (const button of document.querySelectorAll("[data-view]")) {
      button.addEventListener("click", () => this.look(button.dataset.view));
    }
    addEventListener("resize", () => this.measure());
  }

  seek(t) {
    this.follows = false;
    this.go(t);
  }

  go(t) {
    this.time = Math.min(this.motion.end, Math.max(this.motion.start, t));
    this.dirty = true;
  }

  step(by) {
    this.play(false);
    this.seek(this.time + by);
  }

  play(on = !this.playing) {
    const { goesOn } = this.run;
    if (on && !goesOn && this.time >= this.motion.end - 1e-6) this.seek(this.opening);
    this.follows &&= on && goesOn;
    this.playing = on;
    this.scene?.rest(!on);
    this.frames = 0;
    this.last = null;
    find("#play").setAttribute("aria-label", on ? "pause" : "play");
    document.body.classList.toggle("playing", on);
    document.body.classList.toggle("begun", on || document.body.classList.contains("begun"));
    this.dirty = true;
  }

  setSpeed(speed) {
    this.speed = speed;
    find("#speed").value = String(speed);
  }

  faster(by) {
    this.setSpeed(SPEEDS[Math.min(SPEEDS.length - 1, Math.max(0, SPEEDS.indexOf(this.speed) + by))]);
  }

  nextEvent(direction) {
    const ahead = this.marks.map((m) => m.t_s).filter((t) => (t - this.time) * direction > 1e-6);
    if (ahead.length) this.seek(direction > 0 ? Math.min(...ahead) : Math.max(...ahead));
  }

  look(view, atOnce) {
    if (!this.scene) return;
    this.scene.look(view, atOnce);
    for (const button of document.querySelectorAll("[data-view]")) {
      button.setAttribute("aria-pressed", String(button.dataset.view === view));
    }
  }

  zoomManoeuvre() {
    this.plots.zoom(...manoeuvre(this.run));
    this.plots.zoomed = false;
  }

  /** Draws all in the colours that the style sheet has now. */
  recolor() {
    forgetColors();
    this.scene?.build();
    this.plots.build();
    this.drawStrip();
    this.dirty = true;
  }

  measure() {
    this.barWidth = find(".bar").clientWidth;
    this.drawStrip();
    this.dirty = true;
  }

  // ---- the time line ----

  share(t) {
    const { start, end } = this.motion;
    return end > start ? (t - start) / (end - start) : 0;
  }

  tick({ t_s, text }) {
    const tick = document.createElement("i");
    tick.style.left = `${100 * this.share(t_s)}%`;
    tick.title = text;
    return tick;
  }

  event({ t_s, text, short }) {
    const button = document.createElement("button");
    const time = document.createElement("span");
    time.textContent = `${signed(t_s - this.motion.zero)} s`;
    button.append(time, ` ${short}`);
    button.title = `${text}: go there`;
    button.addEventListener("click", () => this.seek(t_s));
    return button;
  }

  /** J_state over all of the time line as a strip of colour. */
  drawStrip() {
    const { motion, released } = this;
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

  // ---- what is shown of an instant ----

  phaseWords(t) {
    const { motion, about, steady } = this;
    const phase = motion.phase ? motion.phase[motion.index(t)] : 2;
    if (about.standing && phase === 0) return "standing on the ground";
    if (phase === 0) return `hanging under the ${about.balloon ? "balloon" : "parachute"}`;
    if (phase === 1) return "falling, rotors off";
    if (steady != null && t >= steady - 1e-6) return "steady at the target velocity";
    return "flying under power";
  }

  report(t) {
    const { motion, scene } = this;
    const since = t - motion.zero;
    const j = motion.value(motion.j, t);
    const slider = find("#time");
    if (!this.playing || performance.now() - (this.readAt ?? 0) > 60) {
      this.readAt = performance.now();
      put("#clock", `${signed(since)} s`);
      put("#now", fixed(j, 2));
      slider.setAttribute("aria-valuetext", `${fixed(since, 2)} s after the rotors were freed, ${this.phaseWords(t)}`);
    }
    put("#phase", this.phaseWords(t));
    const needle = find("#needle");
    needle.style.transform = `translateX(${Math.min(1, Math.max(0, j)) * this.barWidth}px)`;
    needle.style.visibility = Number.isFinite(j) ? "visible" : "hidden";
    const note = scene && scene.enlarged > 1.05 ? `vehicle drawn ${fixed(scene.enlarged, scene.enlarged < 10 ? 1 : 0)}\u00d7 its size` : "";
    put("#enlarged", note);
    slider.value = String(t);
    find("#passed").style.transform = `scaleX(${this.share(t)})`;
  }

  frame(now) {
    this.onFrame?.();
    const watchedS = this.playing && this.last != null ? Math.min(0.25, (now - this.last) / 1000) : 0;
    if (this.playing) {
      this.judgePace(now);
      this.last = now;
      this.goOn(watchedS);
    }
    if (this.dirty) {
      this.dirty = false;
      const turns = this.scene?.show(this.time, watchedS);
      this.scene?.render();
      this.plots.resting = !this.playing;
      this.plots.show(this.time);
      this.report(this.time);
      this.drawn++;
      if (turns) this.dirty = true;
    }
    requestAnimationFrame((next) => this.frame(next));
  }

  /** Goes on by what was watched: to the end, or after a flight that goes on. */
  goOn(watchedS) {
    const { end } = this.motion;
    if (this.follows) return this.go(this.time + (end - this.time) * Math.min(1, watchedS / BEHIND_S));
    this.go(this.time + watchedS * this.speed);
    if (this.time < end) return;
    if (this.run.goesOn) this.follows = true;
    else this.play(false);
  }

  /** Draws coarser where the machine is too slow. */
  judgePace(now) {
    if (this.frames === 0) this.since = now;
    if (this.frames++ < JUDGED_FRAMES) return;
    const each = (now - this.since) / JUDGED_FRAMES;
    this.frames = 0;
    if (each > LONGEST_FRAME_MS) this.scene?.coarser();
  }

  // ---- for tests ----

  get vehicle() {
    return this.scene?.shownPosition();
  }

  get range() {
    return this.plots.range;
  }

  get pixelRatio() {
    return this.scene?.ratio;
  }
}
