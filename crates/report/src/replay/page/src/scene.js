// The view in space: paths, vehicle, ghosts, arrows, grids, labels, cameras.
//
// The scene is y up; what is in `ned` has north, east, down for its axes.

import * as THREE from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { costColor, css, rotorColor } from "./colors.js";
import { Segments, flat, lineThrough } from "./materials.js";
import { IS_SOFT } from "./soft.js";
import { Arrow, Canopy, VehiclePicture, ghostOf, sizes } from "./vehicle.js";
import { fixed, roundStep } from "./words.js";

export const VIEWS = ["follow", "path", "side", "top"];
/** Share of the view's height below which the vehicle is drawn larger than it is. */
const LEAST_SHARE = 0.085;
/** Arrows of velocity and wind: times the vehicle's reach at the limit of speed. */
const ARROW_REACH = 3.2;
const CANOPY_FADES_S = 1.5;
const TURN_MS = 450;
/** Room around the path of a flight that goes on, as a share of it. */
const ROOM = 0.4;
/** Longest step along a drawn path, as a share of all of it. */
const FINENESS = 1 / 300;

/** A point of the scene for north, east, down. */
function point([north, east, down], out = new THREE.Vector3()) {
  return out.set(east, -down, -north);
}

/** A line of length one, down. */
const UNIT = [[0, 0, 0], [0, 0, 1]];

let lines = 0;

/** A line as wide as that [px], of one colour or one for each point. */
function line(points, color, width) {
  const made = lineThrough(points, color, width);
  // Lines along one another are drawn one over the other, whatever their depths round to.
  made.renderOrder = ++lines;
  return made;
}

/** A thin dashed line. */
function dashed(points, color, dash) {
  const ends = [];
  let way = 0;
  for (let i = 1; i < points.length; i++) {
    const [from, to] = [new THREE.Vector3(...points[i - 1]), new THREE.Vector3(...points[i])];
    const length = from.distanceTo(to);
    for (let passed = 0; passed < length - 1e-9; ) {
      const phase = (way + passed) % (1.8 * dash);
      const left = Math.min(length - passed, Math.max((phase < dash ? dash : 1.8 * dash) - phase, 1e-3 * dash));
      if (phase < dash) ends.push(from.clone().lerp(to, passed / length), from.clone().lerp(to, (passed + left) / length));
      passed += left;
    }
    way += length;
  }
  return new Segments(ends, color, 1);
}

/** Gives back what the graphics card holds of an object. */
function dispose({ geometry, material }) {
  geometry?.dispose();
  material?.dispose();
}

/** Rows of a motion that draw it: none closer together than a share of the path, the last one included. */
function drawnRows({ p: [north, east, down], count }, from) {
  const finite = (i) => Math.hypot(north[i], east[i], down[i]) < 1e7;
  const apart = (i, k) => Math.hypot(north[i] - north[k], east[i] - east[k], down[i] - down[k]);
  const first = Math.min(from, count - 1);
  let end = first;
  let length = 0;
  for (; end < count && finite(end); end++) if (end > first) length += apart(end, end - 1);
  const rows = [];
  for (let i = first; i < end; i++) {
    const last = rows[rows.length - 1];
    if (last === undefined || i === count - 1 || apart(i, last) >= length * FINENESS) rows.push(i);
  }
  return rows;
}

export class Scene {
  /** `stage` is the element with the canvas and the overlay of labels; views frame the path up to `until`. */
  constructor(stage, run, { still, until }) {
    Object.assign(this, { stage, still, view: "follow", other: null, moves: null, retired: [] });
    this.canvas = stage.querySelector("canvas");
    this.labelLayer = stage.querySelector(".labels");
    const antialias = !IS_SOFT;
    this.renderer = new THREE.WebGLRenderer({ canvas: this.canvas, antialias, powerPreference: "low-power" });
    // Points for each pixel of the page: while it moves, at rest, and now.
    this.ratio = this.fullRatio = this.shownRatio = Math.min(window.devicePixelRatio || 1, 2);
    this.camera = new THREE.PerspectiveCamera(38, 1, 0.05, 1e5);
    this.controls = new OrbitControls(this.camera, this.canvas);
    this.controls.enableDamping = false;
    this.controls.addEventListener("change", () => this.onChange?.());
    this.controls.addEventListener("start", () => (this.moves = null));
    this.open(run, until);
    new ResizeObserver(() => this.resize()).observe(stage);
    this.resize();
  }

  /** Shows a run; the camera stays where it is unless the run is out of its sight. */
  open(run, until) {
    Object.assign(this, { run, until, size: sizes(run.about.rotors) });
    this.extents();
    this.build();
    if (this.placed && this.isAskew()) this.look(this.view);
  }

  /** The flight has gone on: its path is longer, and all is made anew where it has left what is drawn around
   * it, or more than its path has changed. */
  grow(run) {
    const { motion, about } = run;
    const before = this.run.about;
    const [north, east, down] = motion.position(motion.end);
    const [n, e] = this.ahead;
    const places = [north * n + east * e, east * n - north * e, down];
    const isNear = [this.u, this.w, this.d].every(([low, high], k) => !(places[k] < low || places[k] > high));
    const isSame = about.marks.length === before.marks.length && about.times.released_s === before.times.released_s;
    if (!isNear || !isSame || !run.plan !== !this.run.plan) return this.open(run, motion.end);
    Object.assign(this, { run, until: motion.end });
    this.trace();
    this.ned.remove(this.way);
    this.retired.push(this.way);
    this.path();
  }

  /** Whether a view of the whole path does not show it, or shows it small. */
  isAskew() {
    if (this.view === "follow" || this.moves) return false;
    this.camera.updateMatrixWorld();
    const seen = this.points.map((p) => p.clone().project(this.camera));
    const reach = Math.max(...seen.map(({ x, y }) => Math.max(Math.abs(x), Math.abs(y))));
    return !(reach < 0.95 && reach > 0.4);
  }

  /** The points of the path that are drawn, which are returned, and of those what the views show: the
   * manoeuvre; the path goes on. */
  trace() {
    const { motion, about } = this.run;
    const released = about.times.released_s;
    this.first = released === null ? 0 : motion.index(Math.max(motion.start, released - 1));
    this.rows = drawnRows(motion, this.first);
    const at = (i) => motion.p.map((p) => p[i]);
    const points = this.rows.map(at);
    this.points = this.rows.filter((i) => motion.t[i] <= this.until).map((i) => point(at(i)));
    if (this.points.length === 0) this.points.push(point(points[0] ?? [0, 0, 0]));
    return points;
  }

  /** Box of the path, its heading, the steps of the grids. */
  extents() {
    const { motion, plan, about } = this.run;
    const released = about.times.released_s;
    const at = (m, i) => m.p.map((p) => p[i]);
    const points = this.trace();
    if (plan) drawnRows(plan, 0).forEach((i) => points.push(at(plan, i)));
    if (points.length === 0) points.push([0, 0, 0]);
    const last = points[this.rows.length - 1] ?? points[0];
    const across = [last[0] - points[0][0], last[1] - points[0][1]];
    const far = Math.hypot(...across);
    const [n, e] = far > 2 * this.size.reach ? across.map((x) => x / far) : [1, 0];
    this.ahead = [n, e];
    // Seen from the side, ahead is to the right.
    this.aside = [-e, n];
    const range = (of) => {
      const all = points.map(of);
      return [all.reduce((a, b) => Math.min(a, b)), all.reduce((a, b) => Math.max(a, b))];
    };
    // A flight that goes on has room for a while.
    const pad = ([low, high]) => Math.max(3 * this.size.reach, this.run.goesOn ? ROOM * (high - low) : 0);
    const padded = (span) => [span[0] - pad(span), span[1] + pad(span)];
    this.u = padded(range((p) => p[0] * n + p[1] * e));
    this.w = padded(range((p) => -p[0] * e + p[1] * n));
    this.d = padded(range((p) => p[2]));
    this.origin = released === null ? points[0] : motion.position(released);
    if (about.ground_down_m != null) this.d[1] = about.ground_down_m;
    this.extent = Math.max(this.u[1] - this.u[0], this.d[1] - this.d[0], this.w[1] - this.w[0]);
    this.step = roundStep(this.extent / 9);
  }

  horizontal(u, w) {
    const [n, e] = this.ahead;
    return [u * n - w * e, u * e + w * n];
  }

  /** Makes all that is seen; again when the colours change. */
  build() {
    const { run } = this;
    this.retired.push(this.scene);
    this.labelLayer.replaceChildren();
    this.labels = [];
    this.scene = new THREE.Scene();
    this.scene.background = new THREE.Color(css("stage"));
    this.ned = new THREE.Group();
    this.ned.matrixAutoUpdate = false;
    this.ned.matrix.set(0, 1, 0, 0, 0, 0, -1, 0, -1, 0, 0, 0, 0, 0, 0, 1);
    this.scene.add(this.ned);
    this.grids();
    this.path();
    this.events();
    const rotorColors = run.about.rotors.map((_, i) => rotorColor(i));
    const colors = { hull: css("hull"), nose: css("second"), rotorColors };
    this.craft = new THREE.Group();
    this.vehicle = new VehiclePicture(run.about.rotors, colors);
    this.craft.add(this.vehicle);
    this.ned.add(this.craft);
    this.canopy = new Canopy(this.size.reach, 2.2 * this.size.reach, run.about.balloon);
    this.ned.add(this.canopy);
    this.riser = new Segments(UNIT, 0x888888, 1);
    this.riser.visible = false;
    this.ned.add(this.riser);
    this.ghost = run.plan ? this.ghostOf(css("ghost")) : null;
    this.otherGhost = this.other ? this.ghostOf(css("other")) : null;
    const thickness = 0.028 * this.size.reach;
    this.velocity = new Arrow(css("velocity"), thickness);
    this.craft.add(this.velocity);
    this.wind = new Arrow(css("wind"), thickness);
    this.craft.add(this.wind);
    this.label("velocity", () => this.tip(this.velocity), "velocity", 3);
    this.label("wind", () => this.tip(this.wind), "wind", 2);
    if (run.plan) {
      this.label("plan", () => this.apart(this.ghost, 0.6), "ghost", 1, "plan");
    }
    if (this.other) this.label("other", () => this.apart(this.otherGhost, 0.6), "other", 2, this.otherName);
  }

  ghostOf(color) {
    const ghost = ghostOf(this.run.about.rotors, color);
    this.ned.add(ghost);
    return ghost;
  }

  /** A wall behind the path and a floor below it, ruled. */
  grids() {
    const { step } = this;
    const round = ([low, high], from = 0) => [
      from + Math.floor((low - from) / step) * step,
      from + Math.ceil((high - from) / step) * step,
    ];
    const ground = this.run.about.ground_down_m;
    const u = round(this.u);
    const w = round([this.w[0], Math.max(this.w[1], this.w[0] + 2 * step)]);
    const d = round(this.d, this.origin[2]);
    const floor = ground ?? d[1];
    if (ground != null) d[1] = ground;
    const behind = w[0];
    this.wall = new THREE.Group();
    this.ned.add(this.wall);
    const lines = { coarse: [], fine: [], floor: [] };
    const ruled = (low, high, kind, spacing, draw) => {
      for (let x = low; x <= high + 1e-6; x += spacing) lines[kind].push(...draw(Math.min(x, high)));
    };
    const at = (x, y, z) => new THREE.Vector3(...this.horizontal(x, y), z);
    for (const [kind, spacing] of [["coarse", step], ["fine", step / 2]]) {
      ruled(...u, kind, spacing, (x) => [at(x, behind, d[0]), at(x, behind, floor)]);
      ruled(...d, kind, spacing, (z) => [at(u[0], behind, z), at(u[1], behind, z)]);
    }
    ruled(...u, "floor", step, (x) => [at(x, w[0], floor), at(x, w[1], floor)]);
    ruled(...w, "floor", step, (y) => [at(u[0], y, floor), at(u[1], y, floor)]);
    for (const kind of ["coarse", "fine"]) {
      this.wall.add(new Segments(lines[kind], css(`grid-${kind}`), 1));
    }
    this.ned.add(new Segments(lines.floor, css("grid-coarse"), 1));
    if (ground != null) {
      const plane = new THREE.PlaneGeometry(u[1] - u[0], w[1] - w[0]);
      const mesh = new THREE.Mesh(plane, flat(css("ground")));
      const [n, e] = this.horizontal(0.5 * (u[0] + u[1]), 0.5 * (w[0] + w[1]));
      mesh.position.set(n, e, floor + 0.01);
      mesh.rotation.z = Math.atan2(this.ahead[1], this.ahead[0]);
      this.ned.add(mesh);
    }
    for (let z = d[0]; z <= floor + 1e-6; z += step) {
      const below = z - this.origin[2];
      const text = Math.abs(below) < 1e-6 ? (this.run.about.standing ? "start" : "release") : below > 0 ? `${fixed(below, step < 1 ? 1 : 0)} m below` : "";
      const place = this.fixedAt([...this.horizontal(u[0], behind), z]);
      if (text) this.label(`altitude ${below}`, () => (this.wall.visible ? place() : null), "rule", 0, text);
    }
    // North, on the floor.
    const length = 1.2 * step;
    const north = new Arrow(css("soft"), 0.02 * step);
    const [n0, e0] = this.horizontal(u[0], w[1]);
    north.position.set(n0, e0, floor);
    north.point(new THREE.Vector3(1, 0, 0), length);
    this.ned.add(north);
    this.label("north", this.fixedAt([n0 + 1.25 * length, e0, floor]), "rule", 0, "N");
    this.floor = floor;
    this.plumb = new Segments(UNIT, css("grid-coarse"), 1);
    this.ned.add(this.plumb);
  }

  /** The path, thin where it is still to be flown; the plan's, dashed; a dot each second. */
  path() {
    const { motion, plan, about } = this.run;
    this.way = new THREE.Group();
    this.ned.add(this.way);
    const free = about.times.released_s ?? motion.start;
    const point = (m, i) => m.p.map((p) => p[i]);
    const hang = this.rows.filter((i) => motion.t[i] <= free + 1e-9);
    const flown = this.rows.filter((i) => motion.t[i] >= free - 1e-9);
    const dash = this.step / 24;
    this.way.add(dashed(hang.map((i) => point(motion, i)), css("soft"), dash));
    this.flown = null;
    if (flown.length > 1) {
      const points = flown.map((i) => point(motion, i));
      const colors = flown.map((i) => new THREE.Color(...costColor(motion.j[i]).map((c) => c / 255)).convertSRGBToLinear().toArray());
      // A rim parts both ends of the map from the ground.
      this.way.add(line(points, css("rim"), 4.5));
      this.way.add(line(points, colors, 3));
      this.flown = line(points, colors, 7);
      this.flown.rows = flown;
      this.way.add(this.flown);
    }
    if (plan) this.way.add(dashed(drawnRows(plan, 0).map((i) => point(plan, i)), css("ghost"), dash));
    if (this.other) {
      const released = this.other.about.times.released_s;
      const rows = drawnRows(this.other.motion, released === null ? 0 : this.other.motion.index(released));
      const shift = this.shiftOfOther();
      const points = rows.map((i) => point(this.other.motion, i).map((x, k) => x + shift[k]));
      if (points.length > 1) this.way.add(line(points, css("other"), 2.4));
    }
    const seconds = [];
    const spacing = roundStep(Math.max(motion.end - motion.zero, 1) / 40);
    for (let t = motion.zero; t <= motion.end; t += spacing) {
      const at = motion.position(t);
      if (t >= free && at.every(Number.isFinite)) seconds.push(at, at);
    }
    for (const [size, color] of [[8, css("ink")], [5.5, css("stage")]]) {
      const drawn = new Segments(seconds, color, size);
      drawn.renderOrder = ++lines;
      this.way.add(drawn);
    }
    this.dotSpacing = spacing;
  }

  /** A label for each event. */
  events() {
    const { motion, about } = this.run;
    const free = about.times.released_s ?? motion.start;
    for (const { t_s, short } of about.marks) {
      if (t_s < free - 1e-9 || t_s > motion.end) continue;
      this.label(`event ${t_s} ${short}`, this.fixedAt(motion.position(t_s)), "event", 1, short);
    }
  }

  /** The other run is laid over this one at t = 0. */
  shiftOfOther() {
    const start = ({ motion }) => motion.position(Math.min(Math.max(motion.zero, motion.start), motion.end));
    const [mine, others] = [start(this.run), start(this.other)];
    return mine.map((x, k) => x - others[k]);
  }

  label(name, place, kind, rank, text = "") {
    const element = document.createElement("span");
    element.className = `label ${kind}`;
    element.textContent = text;
    this.labelLayer.append(element);
    this.labels.push({ name, element, place, rank, text, width: 0 });
  }

  fixedAt(ned) {
    const at = point(ned);
    return () => at;
  }

  tip(arrow) {
    if (!arrow.visible) return null;
    return arrow.head.getWorldPosition(new THREE.Vector3());
  }

  apart(group, share) {
    if (!group?.visible) return null;
    const at = group.getWorldPosition(new THREE.Vector3());
    const away = at.distanceTo(this.craft.getWorldPosition(new THREE.Vector3()));
    if (away < share * this.size.reach * this.enlarged) return null;
    at.y += 0.5 * this.size.reach * this.enlarged;
    return at;
  }

  text(name, text) {
    const label = this.labels.find((l) => l.name === name);
    if (label && label.text !== text) {
      label.text = text;
      label.element.textContent = text;
      label.width = 0;
    }
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.stage;
    if (!width || !height) return;
    this.renderer.setPixelRatio(this.shownRatio);
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    if (!this.placed) {
      this.placed = true;
      this.look("follow", true);
    }
    this.onChange?.();
  }

  /** Draws with fewer points: where frames take too long. */
  coarser() {
    if (this.ratio <= 0.5) return;
    this.ratio = Math.max(0.5, 0.75 * this.ratio);
    this.rest(false);
  }

  /** Draws sharply at rest, and as sharply as the machine can while it moves. */
  rest(resting) {
    const ratio = resting ? this.fullRatio : this.ratio;
    if (ratio === this.shownRatio) return;
    this.shownRatio = ratio;
    this.resize();
  }

  /** Goes to a view: `follow` keeps the vehicle in the middle. */
  look(view, atOnce = this.still) {
    this.view = view;
    const aspect = this.camera.aspect;
    const [an, ae] = this.aside;
    const target = new THREE.Vector3();
    const eye = new THREE.Vector3();
    if (view === "follow") {
      this.vehicleAt(target);
      const far = (aspect < 1 ? 11.5 : 9) * this.size.reach;
      point([0.82 * an - 0.35 * this.ahead[0], 0.82 * ae - 0.35 * this.ahead[1], -0.34], eye);
      eye.normalize().multiplyScalar(far).add(target);
    } else if (view === "top") {
      // North is up; a hair off the plumb line, where a camera that orbits has no heading.
      this.fit(point([-1e-3, 0, -1], eye), target);
    } else {
      const along = view === "path" ? -0.75 : 0;
      this.fit(point([an + along * this.ahead[0], ae + along * this.ahead[1], along * 0.55], eye), target);
    }
    this.moves = null;
    if (atOnce) {
      this.controls.target.copy(target);
      this.camera.position.copy(eye);
    } else {
      const from = { eye: this.camera.position.clone(), target: this.controls.target.clone() };
      this.moves = { from, to: { eye, target }, since: performance.now() };
    }
    this.followed = this.vehicleAt(new THREE.Vector3());
    this.controls.update();
    this.onChange?.();
  }

  /** Moves `target` and `eye`, at first the direction from which is seen, so that all of the path is in view
   * with a margin around it. */
  fit(eye, target) {
    const back = eye.clone().normalize();
    const right = new THREE.Vector3(0, 1, 0).cross(back).normalize();
    const up = back.clone().cross(right);
    const tan = Math.tan((this.camera.fov / 2) * (Math.PI / 180));
    const [wide, high] = [0.74 * tan * this.camera.aspect, 0.74 * tan];
    const box = new THREE.Box3().setFromPoints(this.points.map((p) => new THREE.Vector3(p.dot(right), p.dot(up), p.dot(back))));
    const middle = box.getCenter(new THREE.Vector3());
    const reach = 2 * this.size.reach;
    let far = 0;
    for (const p of this.points) {
      const [x, y] = [Math.abs(p.dot(right) - middle.x) + reach, Math.abs(p.dot(up) - middle.y) + reach];
      far = Math.max(far, p.dot(back) - middle.z + Math.max(x / wide, y / high));
    }
    target.set(0, 0, 0).addScaledVector(right, middle.x).addScaledVector(up, middle.y).addScaledVector(back, middle.z);
    eye.copy(target).addScaledVector(back, far);
  }

  vehicleAt(out) {
    return point(this.shown ?? this.origin, out);
  }

  /** Position of the drawn vehicle: north, east, down [m]. */
  shownPosition() {
    return this.craft.position.toArray();
  }

  /** Moves the camera: with the vehicle, or on its way to a view. */
  moveCamera() {
    const now = this.vehicleAt(new THREE.Vector3());
    if (this.view === "follow" && this.followed && Number.isFinite(now.x + now.y + now.z)) {
      const step = now.clone().sub(this.followed);
      this.camera.position.add(step);
      this.controls.target.add(step);
      if (this.moves) {
        for (const end of [this.moves.from, this.moves.to]) for (const p of Object.values(end)) p.add(step);
      }
    }
    this.followed = now;
    if (this.moves) {
      const share = Math.min(1, (performance.now() - this.moves.since) / TURN_MS);
      const eased = share * share * (3 - 2 * share);
      this.camera.position.lerpVectors(this.moves.from.eye, this.moves.to.eye, eased);
      this.controls.target.lerpVectors(this.moves.from.target, this.moves.to.target, eased);
      if (share >= 1) this.moves = null;
    }
    this.controls.update();
    return this.moves !== null;
  }

  /** Shows an instant. `watchedS` is how long it was watched since the last one. Whether the camera is still
   * on its way. */
  show(t, watchedS) {
    const { motion, plan, about } = this.run;
    const at = motion.position(t);
    if (at.every(Number.isFinite)) this.shown = at;
    this.craft.position.set(...(this.shown ?? this.origin));
    const turns = this.moveCamera();
    this.wall.visible = this.view !== "top";
    const tan = Math.tan((this.camera.fov / 2) * (Math.PI / 180));
    const distance = this.camera.position.distanceTo(this.vehicleAt(new THREE.Vector3()));
    this.enlarged = Math.max(1, (LEAST_SHARE * distance * tan) / this.size.reach);
    const scale = this.enlarged;
    this.camera.near = Math.max(0.01, 0.02 * distance);
    this.camera.far = distance + 20 * this.extent + 1000;
    this.camera.updateProjectionMatrix();
    const [q0, q1, q2, q3] = motion.attitude(t);
    this.vehicle.quaternion.set(q1, q2, q3, q0);
    this.craft.scale.setScalar(scale);
    const thrust = motion.thrust.map((c) => motion.value(c, t) / about.limits.thrust_n);
    this.vehicle.thrusts(thrust);
    if (!this.still) this.vehicle.spin(motion.rotorSpeed.map((c) => motion.value(c, t) / about.limits.rotor_rad_s), watchedS);
    const wind = motion.wind.length === 3 ? motion.wind.map((column) => motion.value(column, t)) : this.run.about.wind_ned_m_s;
    this.showArrows(motion.velocity(t), wind);
    this.showCanopy(t, scale);
    this.showGhost(this.ghost, plan, t, [0, 0, 0]);
    if (this.other) {
      const shift = this.shiftOfOther();
      this.showGhost(this.otherGhost, this.other.motion, t - motion.zero + this.other.motion.zero, shift);
    }
    if (this.flown) {
      const passed = this.flown.rows.filter((i) => motion.t[i] <= t).length;
      this.flown.geometry.instanceCount = Math.max(0, passed - 1);
    }
    const [n, e, d] = this.shown ?? this.origin;
    this.plumb.position.set(n, e, d);
    this.plumb.scale.set(1, 1, Math.max(1e-6, this.floor - d));
    return turns;
  }

  showArrows(v, windNed) {
    const perSpeed = (ARROW_REACH * this.size.reach) / this.run.about.limits.speed_m_s;
    const speed = Math.hypot(...v);
    const unit = (vector, norm) => new THREE.Vector3(...vector).divideScalar(norm || 1);
    this.velocity.point(unit(v, speed), Math.min(speed * perSpeed, 2 * ARROW_REACH * this.size.reach));
    this.text("velocity", `velocity ${fixed(speed, 1)} m/s`);
    const windSpeed = Math.hypot(...windNed);
    const along = unit(windNed, windSpeed);
    const length = windSpeed > 0 ? Math.max(windSpeed * perSpeed, 0.7 * this.size.reach) : 0;
    this.wind.point(along, length);
    this.wind.position.copy(along).multiplyScalar(-length - 1.5 * this.size.reach);
    this.text("wind", `wind ${fixed(windSpeed, 1)} m/s`);
  }

  /** The canopy where the flight has it, its riser taut or away; of a flight without one of its own it holds
   * the vehicle until the release, then sinks on where it is, and fades: how it flies on is not simulated. */
  showCanopy(t, scale) {
    const { motion, about } = this.run;
    if (about.standing) return this.canopy.fade(0);
    if (motion.canopy.length === 3) return this.showOwnCanopy(t, scale);
    const released = about.times.released_s ?? Infinity;
    const since = Math.max(0, t - released);
    const then = Math.min(t, released);
    const at = motion.position(then);
    const v = motion.velocity(then);
    this.canopy.position.set(...at.map((x, k) => x + (since > 0 ? v[k] * since : 0)));
    const [q0, q1, q2, q3] = motion.attitude(then);
    this.canopy.quaternion.set(q1, q2, q3, q0);
    this.canopy.scale.setScalar(scale);
    this.canopy.fade(Math.max(0, 1 - since / CANOPY_FADES_S));
  }

  showOwnCanopy(t, scale) {
    const { motion } = this.run;
    const vehicle = new THREE.Vector3(...motion.position(t));
    const cloth = new THREE.Vector3(...motion.canopy.map((column) => motion.value(column, t)));
    const held = motion.value(motion.tension, t) > 0;
    // Its lines end above the vehicle while they hold it, and hang down when they do not.
    const down = held ? vehicle.clone().sub(cloth) : new THREE.Vector3(0, 0, 1);
    const distance = down.length();
    const lines = scale * this.canopy.length;
    const knot = cloth.clone().addScaledVector(down.normalize(), held ? Math.min(lines, distance) : lines);
    this.canopy.position.copy(knot);
    this.canopy.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), down);
    this.canopy.scale.setScalar(scale);
    this.canopy.fade(1);
    this.riser.visible = held;
    this.riser.position.copy(knot);
    this.riser.scale.z = Math.max(1e-6, knot.distanceTo(vehicle));
    this.riser.quaternion.copy(this.canopy.quaternion);
  }

  showGhost(ghost, motion, t, shift) {
    if (!ghost) return;
    const at = t >= motion.start - 1e-9 && t <= motion.end + 1e-9 ? motion.position(t) : [NaN];
    ghost.visible = at.every(Number.isFinite);
    if (!ghost.visible) return;
    ghost.position.set(...at.map((x, k) => x + shift[k]));
    const [q0, q1, q2, q3] = motion.attitude(t);
    ghost.quaternion.set(q1, q2, q3, q0);
    ghost.scale.setScalar(this.enlarged);
  }

  render() {
    this.renderer.render(this.scene, this.camera);
    // After what takes their place is drawn: so its shaders are theirs and are not made again.
    for (const scene of this.retired.splice(0)) scene?.traverse(dispose);
    this.placeLabels();
  }

  /** Labels beside what they name; of two that overlap the more important one is shown. */
  placeLabels() {
    const { clientWidth: width, clientHeight: height } = this.stage;
    const taken = [];
    const projected = new THREE.Vector3();
    for (const label of [...this.labels].sort((a, b) => b.rank - a.rank)) {
      const at = label.place();
      let shown = false;
      if (at && label.text) {
        projected.copy(at).project(this.camera);
        const [x, y] = [(0.5 + 0.5 * projected.x) * width, (0.5 - 0.5 * projected.y) * height];
        if (!label.width) label.width = label.element.offsetWidth;
        const box = [x + 6, y - 9, x + 8 + label.width, y + 9];
        const inside = projected.z < 1 && x > 0 && box[2] < width && y > 9 && y < height - 9;
        shown = inside && !taken.some((o) => box[0] < o[2] && o[0] < box[2] && box[1] < o[3] && o[1] < box[3]);
        if (shown) {
          taken.push(box);
          label.element.style.transform = `translate(${Math.round(x + 7)}px, ${Math.round(y - 9)}px)`;
        }
      }
      label.element.style.visibility = shown ? "visible" : "hidden";
    }
  }

  /** Lays another run beside this one, by a name. */
  compare(other, name) {
    Object.assign(this, { other, otherName: name });
    this.build();
  }
}
