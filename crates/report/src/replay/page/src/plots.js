// Panels over time, tied to the playhead: velocity, attitude, rates, thrusts, bus, J_state; limits and plan beside.
// Dragging zooms all of them, a double click shows all again, a click goes there.

import uPlot from "uplot";
import { costCss, css, rotorColor } from "./colors.js";
import "./soft.js";
import { fixed, rotorNames } from "./words.js";

/** A limit is drawn when the flight comes within this share of it. */
const NEAR_LIMIT = 0.3;
const AXIS_PX = 46;
const LEAST_SPAN_S = 0.05;
const READ_EVERY_MS = 90;
/** Most rows of a curve that are drawn: few panels have more pixels. */
const MOST_ROWS = 1400;

/** Rows of a motion that show these times since t = 0, and a little beyond. */
function rows(motion, [from, to]) {
  const aside = 0.1 * (to - from);
  const first = motion.index(from - aside + motion.zero);
  const last = Math.min(motion.count - 1, motion.index(to + aside + motion.zero) + 1);
  const stride = Math.max(1, Math.ceil((last - first) / MOST_ROWS));
  const chosen = [];
  for (let i = first; i < last; i += stride) chosen.push(i);
  return [...chosen, last];
}

const finite = (x) => (Number.isFinite(x) && Math.abs(x) < 1e7 ? x : null);

export class Plots {
  constructor(holder, run, { onSeek, range }) {
    Object.assign(this, { holder, onSeek, other: null, t: 0, made: [] });
    this.open(run, range);
    new ResizeObserver(() => this.resize()).observe(holder);
  }

  /** Shows a run between two times since t = 0. */
  open(run, range) {
    Object.assign(this, { run, range, zoomed: this.zoomed ?? false });
    this.full = [run.motion.start - run.motion.zero, run.motion.end - run.motion.zero];
    this.renew();
  }

  /** Each panel: title, lines (name, colour, curve of a motion), limit, target. */
  panels() {
    const { motion, about } = this.run;
    const moves = (curve, least) => curve && curve.some((x) => Math.abs(x) > least);
    const rolls = moves(motion.roll, 0.005) || moves(motion.rates[0], 0.005);
    const turns = moves(motion.rates[2], 0.05);
    const [north, east, down] = about.target_v_ned_m_s;
    const line = (name, color, of, target) => ({ name, color, of, target });
    const velocity = [line("north", "first", (m) => m.v[0], north), line("down", "second", (m) => m.v[2], down)];
    if (east !== 0 || moves(motion.v[1], 0.005)) velocity.push(line("east", "third", (m) => m.v[1], east));
    const attitude = [line("pitch", "first", (m) => m.pitch)];
    const rates = [line("pitch", "first", (m) => m.rates[1])];
    if (rolls) {
      attitude.push(line("roll", "second", (m) => m.roll));
      rates.push(line("roll", "second", (m) => m.rates[0]));
    }
    if (turns) rates.push(line("yaw", "third", (m) => m.rates[2]));
    const names = rotorNames(about.rotors);
    const thrust = names.map((name, i) => ({ name, color: i, of: (m) => m.thrust[i] }));
    const { limits } = about;
    const supply = [line("current", "first", (m) => m.pack), line("voltage", "second", (m) => m.bus)];
    return [
      { title: "velocity", unit: "m/s", lines: velocity, digits: 2 },
      { title: rolls ? "pitch and roll" : "pitch", unit: "deg", lines: attitude, limit: limits.pitch_deg, both: true, digits: 1 },
      { title: rolls || turns ? "body rates" : "pitch rate", unit: "deg/s", lines: rates, limit: limits.pitch_rate_deg_s, both: true, digits: 1 },
      ...(motion.thrust.length ? [{ title: "thrust", unit: "N", lines: thrust, limit: limits.thrust_n, digits: limits.thrust_n < 100 ? 1 : 0, limitName: "plan's limit" }] : []),
      ...(motion.bus ? [{ title: "pack current, bus voltage", unit: "A, V", lines: supply, limit: limits.pack_current_a, digits: 1, limitName: "limit of the current" }] : []),
      { title: "share of the safety limit, J", sub: "state", unit: "", lines: [{ name: "", color: "cost", of: (m) => m.j }], limit: 1, always: true, digits: 3 },
    ];
  }

  /** A panel's rows: time since t = 0, then each line, each line of the plan, each line of the other run. */
  data(panel) {
    const { motion, plan } = this.run;
    const chosen = this.chosen;
    const onGrid = (source, of, shift) => {
      const curve = source && of(source);
      if (!curve) return chosen.map(() => null);
      return chosen.map((i) => {
        const t = motion.t[i] + shift;
        return t < source.start - 1e-9 || t > source.end + 1e-9 ? null : finite(source.value(curve, t));
      });
    };
    const { other } = this;
    const shift = other ? other.motion.zero - motion.zero : 0;
    return [
      chosen.map((i) => motion.t[i] - motion.zero),
      ...panel.lines.map(({ of }) => chosen.map((i) => finite(of(motion)?.[i]))),
      ...(plan ? panel.lines.map(({ of }) => onGrid(plan, of, 0)) : []),
      ...(other ? panel.lines.map(({ of }) => onGrid(other.motion, of, shift)) : []),
    ];
  }

  /** Makes all panels; again when the colours change. */
  build() {
    for (const { plot } of this.made) plot.destroy();
    this.holder.replaceChildren();
    this.chosen = rows(this.run.motion, this.range);
    const panels = this.panels();
    this.looks = this.look(panels);
    this.made = panels.map((panel, k) => this.panel(panel, k === panels.length - 1));
    this.resize();
  }

  /** What of the panels makes them others, as text: numbers do not. */
  look(panels) {
    const has = [!!this.run.plan, !!this.other];
    return JSON.stringify([has, panels.map(({ title, lines }) => [title, lines.map(({ name, color }) => [name, color])])]);
  }

  /** Shows other numbers: in the panels that are there, where they are the same. */
  renew() {
    const panels = this.panels();
    if (this.look(panels) !== this.looks) return this.build();
    this.made.forEach((made, k) => Object.assign(made.panel, panels[k]));
    this.redraw();
  }

  redraw() {
    this.chosen = rows(this.run.motion, this.range);
    const [min, max] = this.range;
    for (const { plot, panel } of this.made) {
      plot.batch(() => {
        plot.setData(this.data(panel), false);
        plot.setScale("x", { min, max });
      });
    }
    this.show(this.t);
  }

  color(line) {
    if (typeof line.color === "number") return rotorColor(line.color);
    return line.color === "cost" ? css("ink") : css(line.color);
  }

  panel(panel, last) {
    const box = document.createElement("figure");
    box.className = "panel";
    const caption = document.createElement("figcaption");
    const title = document.createElement("span");
    title.className = "title";
    title.append(panel.title);
    if (panel.sub) {
      const sub = document.createElement("sub");
      sub.textContent = panel.sub;
      title.append(sub);
    }
    if (panel.unit) title.append(` [${panel.unit}]`);
    caption.append(title);
    const values = panel.lines.map((line) => {
      const item = document.createElement("span");
      item.className = "value";
      item.style.color = this.color(line);
      const number = document.createElement("b");
      item.append(line.name ? `${line.name} ` : "", number);
      caption.append(item);
      return number;
    });
    box.append(caption);
    this.holder.append(box);
    const plot = new uPlot(this.options(panel, last), this.data(panel), box);
    const head = document.createElement("div");
    head.className = "playhead";
    plot.over.append(head);
    plot.over.addEventListener("click", (event) => this.clicked(plot, event));
    plot.over.addEventListener("pointerdown", (event) => (this.pressed = event.clientX));
    plot.over.addEventListener("dblclick", () => this.zoom(...this.full));
    return { panel, plot, head, values, box, caption };
  }

  clicked(plot, event) {
    if (Math.abs(event.clientX - (this.pressed ?? event.clientX)) > 4) return;
    const x = event.clientX - plot.over.getBoundingClientRect().left;
    this.onSeek(plot.posToVal(x, "x") + this.run.motion.zero);
  }

  options(panel, last) {
    const { plan } = this.run;
    const soft = css("soft");
    const cost = panel.lines[0].color === "cost";
    const series = [{}];
    for (const line of panel.lines) {
      series.push({ stroke: cost ? costStroke : this.color(line), width: cost ? 2.4 : 1.8, points: { show: false } });
    }
    if (plan) {
      for (const _ of panel.lines) series.push({ stroke: css("ink"), width: 1, dash: [5, 4], points: { show: false } });
    }
    if (this.other) {
      for (const line of panel.lines) {
        const stroke = panel.lines.length === 1 ? css("other") : this.color(line);
        series.push({ stroke, width: 1.2, dash: [2, 2], points: { show: false } });
      }
    }
    const axis = { stroke: soft, grid: { stroke: css("line"), width: 1 }, ticks: { show: false }, font: css("plot-font") };
    return {
      width: 400,
      height: 110,
      padding: [6, 8, last ? 0 : 4, 0],
      legend: { show: false },
      cursor: { points: { show: false }, y: false, sync: { key: "replay" }, drag: { x: true, y: false, setScale: false } },
      scales: {
        x: { time: false, range: () => this.range },
        y: { range: (_, low, high) => this.span(panel, low, high) },
      },
      axes: [
        { ...axis, size: last ? 26 : 0, show: last, gap: 2, values: (_, all) => all.map((x) => fixed(x, decimals(all))) },
        { ...axis, size: AXIS_PX, gap: 4, space: 26, values: (_, all) => all.map((x) => fixed(x, decimals(all))) },
      ],
      series,
      hooks: {
        drawClear: [(plot) => this.behind(plot)],
        draw: [(plot) => this.inFront(plot, panel)],
        setSelect: [(plot) => this.selected(plot)],
      },
    };
  }

  selected(plot) {
    const { left, width } = plot.select;
    if (width < 5) return;
    plot.setSelect({ left: 0, width: 0, top: 0, height: 0 }, false);
    this.zoom(plot.posToVal(left, "x"), plot.posToVal(left + width, "x"));
  }

  /** Least and greatest number that are drawn. */
  span(panel, low, high) {
    const { limit } = panel;
    if (low == null || high == null) [low, high] = [0, 1];
    for (const { target } of panel.lines) {
      if (target !== undefined) [low, high] = [Math.min(low, target), Math.max(high, target)];
    }
    if (panel.always) return [0, 1.1 * Math.max(high, limit)];
    if (limit && high >= NEAR_LIMIT * limit) high = Math.max(high, limit);
    if (limit && panel.both && low <= -NEAR_LIMIT * limit) low = Math.min(low, -limit);
    const least = 0.02 * (limit ?? 10);
    const margin = Math.max(0.08 * (high - low), 0.5 * (least - (high - low)));
    return [low - margin, high + margin];
  }

  /** The time between release and t = 0 as a band, the plan's end as a line. */
  behind(plot) {
    const { motion, plan, about } = this.run;
    const { ctx, bbox } = plot;
    const x = (t) => plot.valToPos(Math.min(Math.max(t, plot.scales.x.min), plot.scales.x.max), "x", true);
    if (about.times.released_s !== null && about.times.free_s !== null) {
      const from = x(about.times.released_s - motion.zero);
      ctx.fillStyle = css("band");
      ctx.fillRect(from, bbox.top, x(0) - from, bbox.height);
    }
    if (plan) upright(plot, plan.end - motion.zero, css("edge"));
    if (about.times.steady_s != null) upright(plot, about.times.steady_s - motion.zero, css("edge"), [2, 3]);
  }

  inFront(plot, panel) {
    const level = (value, color, dash, text) => {
      const { min, max } = plot.scales.y;
      if (value < min || value > max) return;
      const { ctx, bbox } = plot;
      const y = plot.valToPos(value, "y", true);
      ctx.save();
      ctx.strokeStyle = ctx.fillStyle = color;
      ctx.lineWidth = uPlot.pxRatio;
      ctx.setLineDash(dash.map((d) => d * uPlot.pxRatio));
      ctx.beginPath();
      ctx.moveTo(bbox.left, y);
      ctx.lineTo(bbox.left + bbox.width, y);
      ctx.stroke();
      if (text) {
        ctx.font = `${11 * uPlot.pxRatio}px system-ui, sans-serif`;
        ctx.textAlign = "right";
        ctx.textBaseline = value < 0 ? "bottom" : "top";
        const at = [bbox.left + bbox.width - 3 * uPlot.pxRatio, y + (value < 0 ? -2 : 2) * uPlot.pxRatio];
        // Curves pass behind the letters.
        Object.assign(ctx, { strokeStyle: css("panel"), lineWidth: 4 * uPlot.pxRatio, lineJoin: "round" });
        ctx.setLineDash([]);
        ctx.strokeText(text, ...at);
        ctx.fillText(text, ...at);
      }
      ctx.restore();
    };
    for (const { target } of panel.lines) {
      if (target !== undefined) level(target, css("soft"), [1, 3]);
    }
    if (!panel.limit) return;
    const name = `${panel.limitName ?? "limit"} ${fixed(panel.limit, Number.isInteger(panel.limit) ? 0 : 1)}`;
    level(panel.limit, css("limit"), [8, 3], name);
    if (panel.both) level(-panel.limit, css("limit"), [8, 3], name.replace("limit ", "limit \u2212"));
  }

  resize() {
    const width = this.holder.clientWidth;
    if (!width || !this.made) return;
    // Beside the view the panels share its height; below it each has its own.
    const room = this.holder.clientHeight;
    const tall = getComputedStyle(this.holder).getPropertyValue("--fill").trim() === "1";
    const captions = this.made.reduce((sum, { caption }) => sum + caption.offsetHeight, 0);
    const each = tall ? Math.max(62, Math.floor((room - captions - 26 - 2) / this.made.length)) : 120;
    this.made.forEach(({ plot }, k) => {
      const height = each + (k === this.made.length - 1 ? 26 : 0);
      if (plot.width !== width || plot.height !== height) plot.setSize({ width, height });
    });
    this.show(this.t);
  }

  /** Shows these times since t = 0 [s]. */
  zoom(from, to) {
    const [first, last] = this.full;
    let [low, high] = [Math.max(first, Math.min(from, to)), Math.min(last, Math.max(from, to))];
    if (high - low < LEAST_SPAN_S) {
      const middle = Math.min(last, Math.max(first, 0.5 * (low + high)));
      [low, high] = [middle - LEAST_SPAN_S / 2, middle + LEAST_SPAN_S / 2];
    }
    Object.assign(this, { range: [low, high], zoomed: true });
    this.redraw();
  }

  /** Zooms about the playhead. */
  zoomBy(factor) {
    const now = this.t - this.run.motion.zero;
    const [low, high] = this.range;
    const about = now >= low && now <= high ? now : 0.5 * (low + high);
    this.zoom(about - (about - low) * factor, about + (high - about) * factor);
  }

  show(t) {
    this.t = t;
    const { motion } = this.run;
    const now = t - motion.zero;
    // Figures that change faster cannot be read.
    const clock = performance.now();
    const read = !(clock - this.readAt < READ_EVERY_MS) || this.resting;
    if (read) this.readAt = clock;
    for (const { panel, plot, head, values } of this.made) {
      const x = plot.valToPos(now, "x");
      const inside = x >= -0.5 && x <= plot.bbox.width / uPlot.pxRatio + 0.5;
      head.style.visibility = inside ? "visible" : "hidden";
      if (inside) head.style.transform = `translateX(${x.toFixed(1)}px)`;
      if (!read) continue;
      panel.lines.forEach(({ of }, k) => {
        const curve = of(motion);
        const text = curve ? fixed(motion.value(curve, t), panel.digits) : "";
        if (values[k].textContent !== text) values[k].textContent = text;
      });
    }
  }

  compare(other) {
    this.other = other;
    this.renew();
  }
}

function upright(plot, t, color, dash = []) {
  const { ctx, bbox } = plot;
  if (t < plot.scales.x.min || t > plot.scales.x.max) return;
  const x = plot.valToPos(t, "x", true);
  ctx.save();
  ctx.strokeStyle = color;
  ctx.lineWidth = uPlot.pxRatio;
  ctx.setLineDash(dash.map((d) => d * uPlot.pxRatio));
  ctx.beginPath();
  ctx.moveTo(x, bbox.top);
  ctx.lineTo(x, bbox.top + bbox.height);
  ctx.stroke();
  ctx.restore();
}

/** Viridis from 0 to the limit, by height. */
function costStroke(plot) {
  const { min, max } = plot.scales.y;
  if (min == null || !(max > min)) return "#888";
  const gradient = plot.ctx.createLinearGradient(0, plot.valToPos(min, "y", true), 0, plot.valToPos(max, "y", true));
  for (let k = 0; k <= 20; k++) {
    const j = (k / 20) * Math.min(1, max);
    gradient.addColorStop(Math.min(1, Math.max(0, (j - min) / (max - min))), costCss(j));
  }
  if (max > 1) {
    gradient.addColorStop((1 - min) / (max - min), costCss(2));
    gradient.addColorStop(1, costCss(2));
  }
  return gradient;
}

/** Decimals that numbers a step apart need. */
function decimals(all) {
  const numbers = all.filter((x) => x != null);
  const step = numbers.length > 1 ? Math.abs(numbers[1] - numbers[0]) : 1;
  const exact = (digits) => numbers.every((x) => Math.abs(x - Number(x.toFixed(digits))) < 1e-3 * step);
  return [0, 1, 2, 3, 4, 5].find(exact) ?? 6;
}
