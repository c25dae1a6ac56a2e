// A campaign of random drops of what is shown, drawn while it is flown.

import { css, find, fixed, put } from "../main.js";
import { Refused } from "./server.js";

/** Costs are counted in bins this wide; what is beyond the last is in it. */
const BIN = 0.01;
const MOST = 1.5;
const BINS = Math.round(MOST / BIN);
const HEIGHT_PX = 118;
const [LEFT, FOOT] = [2, 17];

/** What the drops of a campaign came to. */
class Tally {
  constructor() {
    Object.assign(this, { flown: 0, failed: 0, interval: null, causes: new Map() });
    this.safe = new Uint32Array(BINS);
    this.unsafe = new Uint32Array(BINS);
  }

  take({ cost, passed, cause }) {
    cost.forEach((j, k) => {
      const bin = j === null ? BINS - 1 : Math.min(BINS - 1, Math.max(0, Math.floor(j / BIN)));
      (passed[k] ? this.safe : this.unsafe)[bin]++;
      if (passed[k]) return;
      this.failed++;
      const why = cause[k] ?? "other";
      this.causes.set(why, (this.causes.get(why) ?? 0) + 1);
    });
    this.flown += cost.length;
  }
}

const percent = (share) => `${fixed(100 * share, share < 0.0995 ? 2 : 1)} %`;

export class Campaign {
  constructor(server, { drops, j_limit }) {
    Object.assign(this, { server, drops, limit: j_limit ?? 1, tally: null, beside: null, dirty: true });
    new ResizeObserver(() => (this.dirty = true)).observe(find("#spread"));
  }

  /** Flies the drops of some changes, in place of those that were flown. */
  async fly(changes) {
    this.stop();
    this.overtaken = false;
    const tally = (this.tally = new Tally());
    const control = (this.control = new AbortController());
    const body = { number: this.server.next(), changes, drops: this.drops };
    try {
      await this.server.lines("campaign", body, control.signal, (line) => {
        if (line.cost) tally.take(line);
        tally.interval = line.interval95 ?? tally.interval;
        this.overtaken = !!line.overtaken;
        this.fault = line.error ?? null;
        this.dirty = true;
      });
    } catch (error) {
      if (error instanceof Refused) this.fault = error.message;
      else if (error.name !== "AbortError") return this.fly(changes);
    }
    this.dirty = true;
  }

  /** Ends what is under way: it is of another variant than the one that is shown. */
  stop() {
    this.control?.abort();
    this.fault = null;
    if (this.tally) this.tally.old = true;
    this.dirty = true;
  }

  draw() {
    if (!this.dirty) return;
    this.dirty = false;
    this.tell();
    const canvas = find("#spread");
    const [width, ratio] = [canvas.clientWidth, window.devicePixelRatio || 1];
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(HEIGHT_PX * ratio);
    const pen = canvas.getContext("2d");
    pen.scale(ratio, ratio);
    pen.font = css("plot-font");
    const x = (j) => LEFT + (Math.min(j, MOST) / MOST) * (width - 2 * LEFT);
    const foot = HEIGHT_PX - FOOT;
    pen.fillStyle = css("soft");
    pen.textAlign = "center";
    for (const j of [0.25, 0.5, 0.75, 1, 1.25]) pen.fillText(fixed(j, 2), x(j), HEIGHT_PX - 4);
    pen.textAlign = "right";
    pen.fillText("J", width - 2, HEIGHT_PX - 4);
    pen.fillStyle = css("line");
    pen.fillRect(0, foot, width, 1);
    const { tally, beside } = this;
    if (tally) this.bars(pen, tally, x, foot);
    if (beside && beside !== tally && beside.flown) this.outline(pen, beside, x, foot);
    pen.strokeStyle = pen.fillStyle = css("limit");
    pen.setLineDash([8, 3]);
    pen.beginPath();
    pen.moveTo(x(this.limit), 0);
    pen.lineTo(x(this.limit), foot);
    pen.stroke();
    pen.textAlign = "left";
    pen.fillText("limit", x(this.limit) + 4, 10);
  }

  bars(pen, tally, x, foot) {
    const most = Math.max(1, ...tally.safe.map((n, k) => n + tally.unsafe[k]));
    const high = (n) => (n / most) * (foot - 14);
    pen.globalAlpha = tally.old ? 0.35 : 1;
    for (let k = 0; k < BINS; k++) {
      const [from, wide] = [x(k * BIN), Math.max(1, x((k + 1) * BIN) - x(k * BIN) - 0.4)];
      const [safe, unsafe] = [high(tally.safe[k]), high(tally.unsafe[k])];
      pen.fillStyle = css("first");
      if (safe) pen.fillRect(from, foot - safe, wide, safe);
      pen.fillStyle = css("limit");
      if (unsafe) pen.fillRect(from, foot - safe - Math.max(1.5, unsafe), wide, Math.max(1.5, unsafe));
    }
    pen.globalAlpha = 1;
  }

  /** The campaign of what is drawn beside, as a line. */
  outline(pen, tally, x, foot) {
    const all = tally.safe.map((n, k) => n + tally.unsafe[k]);
    const most = Math.max(1, ...all);
    pen.strokeStyle = css("other");
    pen.lineWidth = 1.5;
    pen.beginPath();
    all.forEach((n, k) => {
      const y = foot - (n / most) * (foot - 14);
      pen.lineTo(x(k * BIN), y);
      pen.lineTo(x((k + 1) * BIN), y);
    });
    pen.stroke();
    pen.lineWidth = 1;
  }

  tell() {
    const { tally, fault } = this;
    if (fault) return put("#counted", fault);
    if (!tally?.flown) return put("#counted", "random drops of this variant");
    const { flown, failed, interval } = tally;
    const sure = interval ? ` (95 %: ${percent(interval[0])} to ${percent(interval[1])})` : "";
    const text = `${flown.toLocaleString("en")} of ${this.drops.toLocaleString("en")} drops, ${failed} failed: ${percent(failed / flown)}${sure}`;
    put("#counted", text);
    find("#spread").setAttribute("aria-label", `distribution of J_TPF: ${text}`);
    const causes = [...tally.causes].sort((a, b) => b[1] - a[1]).map(([cause, n]) => `${cause} ${n}`);
    put("#causes", causes.length ? `Failed by ${causes.join(", ")}` : "\u00a0");
  }
}
