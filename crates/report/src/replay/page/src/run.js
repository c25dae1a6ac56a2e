// A flight over time: what the page was given, or what was dropped on it.
//
// Vectors are north, east, down [m, m/s]; quaternions turn body (forward, right, down) into NED, scalar first.

const DEG = 180 / Math.PI;
/** Lateral parts of a quaternion below this are rounding: the pitch of a flight in the plane counts through
 * the vertical, as frames.rs has it. */
const PLANAR = 2e-6;
/** The phase in which the rotors are free. */
const POWERED = 2;

/** Numbers of a channel: second differences of whole steps, as varints in base64. */
function decode({ data, step, gaps }, count) {
  const text = atob(data);
  const values = new Float64Array(count);
  let at = 0;
  const varint = () => {
    let value = 0;
    for (let weight = 1; ; weight *= 128) {
      const byte = text.charCodeAt(at++);
      value += (byte & 127) * weight;
      if (byte < 128) return value;
    }
  };
  let [steps, difference, zeros] = [0, 0, 0];
  for (let i = 0; i < count; i++) {
    if (zeros > 0) {
      zeros--;
    } else {
      const token = varint();
      if (token === 0) zeros = varint();
      else difference += token % 2 === 1 ? -(token + 1) / 2 : token / 2;
    }
    steps += difference;
    values[i] = steps * step;
  }
  for (const [from, to] of gaps) values.fill(NaN, from, to);
  return values;
}

function decodeAll({ count, channels }) {
  return Object.fromEntries(channels.map((channel) => [channel.name, decode(channel, count)]));
}

export function pitchDeg([q0, q1, q2, q3]) {
  if (Math.max(Math.abs(q1), Math.abs(q3)) < PLANAR) return 2 * Math.atan2(q2, q0) * DEG;
  return Math.asin(Math.min(1, Math.max(-1, 2 * (q0 * q2 - q3 * q1)))) * DEG;
}

export function rollDeg([q0, q1, q2, q3]) {
  if (Math.max(Math.abs(q1), Math.abs(q3)) < PLANAR) return 0;
  return Math.atan2(2 * (q0 * q1 + q2 * q3), 1 - 2 * (q1 * q1 + q2 * q2)) * DEG;
}

/** A motion over time with columns; `zero` is the time of t = 0, the instant at which the rotors are freed. */
export class Motion {
  constructor(columns, rotors, zero) {
    this.t = columns.t_s;
    this.count = this.t.length;
    this.zero = zero;
    this.rotors = rotors;
    const of = (names) => names.map((name) => columns[name]).filter(Boolean);
    this.p = of(["north_m", "east_m", "down_m"]);
    this.q = of(["q0", "q1", "q2", "q3"]);
    this.v = of(["vn_m_s", "ve_m_s", "vd_m_s"]);
    this.sp = of(["vn_sp_m_s", "ve_sp_m_s", "vd_sp_m_s"]);
    this.rates = of(["p_rad_s", "q_rad_s", "r_rad_s"]).map((c) => c.map((x) => x * DEG));
    this.j = columns.j_state;
    this.phase = columns.phase;
    const each = Array.from({ length: rotors }, (_, i) => i + 1);
    this.thrust = of(each.map((i) => `thrust_${i}_n`));
    this.wind = of(["wind_n_m_s", "wind_e_m_s", "wind_d_m_s"]);
    this.canopy = of(["canopy_north_m", "canopy_east_m", "canopy_down_m"]);
    this.tension = columns.riser_tension_n;
    this.bus = columns.bus_v;
    this.pack = columns.pack_current_a;
    this.rotorSpeed = of(each.map((i) => `rotor_speed_${i}_rad_s`));
    const [q0, q1, q2, q3] = this.q;
    const attitude = (i) => [q0[i], q1[i], q2[i], q3[i]];
    this.pitch = Float64Array.from(this.t, (_, i) => pitchDeg(attitude(i)));
    this.roll = Float64Array.from(this.t, (_, i) => rollDeg(attitude(i)));
  }

  get start() {
    return this.t[0];
  }

  get end() {
    return this.t[this.count - 1];
  }

  /** Index of the last row at or before a time. */
  index(t) {
    let [low, high] = [0, this.count - 1];
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (this.t[middle] <= t + 1e-9) low = middle;
      else high = middle - 1;
    }
    return low;
  }

  /** Row and the share of the step after it that has passed. */
  place(t) {
    const i = this.index(t);
    if (i + 1 >= this.count) return [i, i, 0, 0];
    const h = this.t[i + 1] - this.t[i];
    return [i, i + 1, Math.min(1, Math.max(0, (t - this.t[i]) / h)), h];
  }

  /** A column at a time, linear between rows. */
  value(column, t) {
    const [i, k, s] = this.place(t);
    return s === 0 ? column[i] : column[i] + (column[k] - column[i]) * s;
  }

  /** Position at a time: the cubic that has the rows' positions and velocities. */
  position(t) {
    const [i, k, s, h] = this.place(t);
    return this.p.map((p, axis) => {
      if (s === 0) return p[i];
      const [a, b] = [this.v[axis][i] * h, this.v[axis][k] * h];
      const [s2, s3] = [s * s, s * s * s];
      return p[i] * (2 * s3 - 3 * s2 + 1) + a * (s3 - 2 * s2 + s) + p[k] * (3 * s2 - 2 * s3) + b * (s3 - s2);
    });
  }

  velocity(t) {
    return this.v.map((c) => this.value(c, t));
  }

  attitude(t) {
    const [i, k, s] = this.place(t);
    const [a, b] = [this.q.map((c) => c[i]), this.q.map((c) => c[k])];
    const sign = a.reduce((sum, x, n) => sum + x * b[n], 0) < 0 ? -1 : 1;
    const mixed = a.map((x, n) => x + (sign * b[n] - x) * s);
    const norm = Math.hypot(...mixed) || 1;
    return mixed.map((x) => x / norm);
  }
}

/** The motion along a plan that begins at a time, as far away as that from where it says. */
function planned(plan, rotors, zero, away = [0, 0, 0]) {
  const columns = decodeAll(plan);
  const moved = (name, by) => (columns[name] = columns[name].map((x) => x + by));
  moved("t_s", zero);
  ["north_m", "east_m", "down_m"].forEach((name, axis) => moved(name, away[axis]));
  return new Motion(columns, rotors, zero);
}

/** A drop: its motion, its plan and what is known about it; `goesOn`: it is not at its end yet. */
export class Run {
  constructor(about, motion, plan) {
    Object.assign(this, { about, motion, plan, goesOn: false });
  }

  static fromObject(about) {
    const rotors = about.rotors.length;
    const zero = about.times.free_s ?? 0;
    const motion = new Motion(decodeAll(about.flight), rotors, zero);
    return new Run(about, motion, about.plan && planned(about.plan, rotors, zero));
  }

  /** A flight that goes on: what was known of it beforehand, what has happened, its rows so far as columns. */
  static soFar(beforehand, marks, columns) {
    const { t_s, t_powered_s, phase } = columns;
    const rotors = beforehand.rotors.length;
    const last = t_s.length - 1;
    const free = Number.isNaN(t_powered_s[last]) ? null : t_s[last] - t_powered_s[last];
    const released = phase.findIndex((p) => p > 0);
    const times = { free_s: free, released_s: released < 0 ? null : t_s[released], steady_s: null };
    const motion = new Motion(columns, rotors, free ?? 0);
    const begins = beforehand.plan && phase[last] === POWERED;
    const plan = begins ? planned(beforehand.plan, rotors, free, motion.position(free)) : null;
    const about = { ...beforehand, times, marks, verdict: null };
    return Object.assign(new Run(about, motion, plan), { goesOn: true });
  }

  /** The run of a `drop.html`. The document is read, its scripts are not run. */
  static fromHtml(text) {
    const block = new DOMParser().parseFromString(text, "text/html").getElementById("drop");
    if (!block) throw new Error("this page holds no drop");
    return Run.fromObject(JSON.parse(block.textContent));
  }

  /** The run of a `flight.csv`. */
  static fromCsv(text, name) {
    const lines = text.split(/\r?\n/).filter((line) => line && !line.startsWith("#"));
    const head = (lines.shift() ?? "").split(",");
    const columns = Object.fromEntries(head.map((column) => [column, new Float64Array(lines.length)]));
    const missing = ["t_s", "t_powered_s", "phase", "north_m", "q0", "vn_m_s", "j_state"].filter((c) => !columns[c]);
    if (missing.length || lines.length === 0) {
      throw new Error(`a flight.csv is expected; ${missing.length ? `without column ${missing[0]}` : "no rows"}`);
    }
    const phases = { hanging: 0, falling: 1, powered: 2 };
    lines.forEach((line, row) => {
      line.split(",").forEach((field, k) => {
        const value = head[k] === "phase" ? phases[field] : field === "" ? NaN : Number(field);
        columns[head[k]][row] = value ?? NaN;
      });
    });
    const powered = columns.t_powered_s.findIndex((t) => !Number.isNaN(t));
    const zero = powered < 0 ? null : columns.t_s[powered] - columns.t_powered_s[powered];
    const rotors = head.filter((column) => /^thrust_\d+_n$/.test(column)).length;
    const released = columns.phase.findIndex((phase) => phase > 0);
    const times = { free_s: zero, released_s: released < 0 ? null : columns.t_s[released] };
    const judged = columns.j_state.filter((_, i) => released >= 0 && i >= released);
    const worst = judged.reduce((a, b) => Math.max(a, b), -Infinity);
    const verdict = Number.isFinite(worst) ? { j_tpf: worst } : null;
    const about = { mission: name, gains: null, rotors: { length: rotors }, times, verdict };
    return new Run(about, new Motion(columns, rotors, zero ?? 0), null);
  }
}
