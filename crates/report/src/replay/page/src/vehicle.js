// The vehicle as a picture: hub, arms, rotors at their places, in body axes (forward, right, down).

import * as THREE from "three";
import { mergeGeometries } from "three/examples/jsm/utils/BufferGeometryUtils.js";
import { Segments, flat, shaded } from "./materials.js";

const UP = new THREE.Vector3(0, 1, 0);
/** Turns of a rotor at its highest speed, per second that is watched. */
const TURNS_PER_S = 2.4;

/** Distance of the outermost rotor from the centre, and the radius of a rotor that fits beside its
 * neighbours: vehicle files have no radius. Metres. */
export function sizes(rotors) {
  const places = rotors.map(({ position_body_m }) => position_body_m);
  const arm = Math.max(...places.map(([x, y]) => Math.hypot(x, y)), 0.05);
  const apart = [];
  places.forEach((a, i) =>
    places.slice(i + 1).forEach((b) => {
      const distance = Math.hypot(a[0] - b[0], a[1] - b[1]);
      if (distance > 0.15 * arm) apart.push(distance);
    }),
  );
  const blade = Math.min(0.62 * arm, 0.46 * Math.min(...apart, 2 * arm));
  return { arm, blade, reach: arm + blade };
}

function rod(from, to, radius) {
  const along = new THREE.Vector3().subVectors(to, from);
  const turn = new THREE.Quaternion().setFromUnitVectors(UP, along.clone().normalize());
  const rod = new THREE.CylinderGeometry(radius, radius, along.length(), 8).applyQuaternion(turn);
  return rod.translate(...from.clone().addScaledVector(along, 0.5).toArray());
}

/** An arrow whose shaft begins at its origin. */
export class Arrow extends THREE.Group {
  constructor(color, thickness) {
    super();
    const material = flat(color);
    const shaft = new THREE.CylinderGeometry(thickness, thickness, 1, 8).translate(0, 0.5, 0);
    const head = new THREE.ConeGeometry(2.9 * thickness, 7 * thickness, 12);
    this.shaft = new THREE.Mesh(shaft, material);
    this.head = new THREE.Mesh(head, material);
    this.headLength = 7 * thickness;
    this.add(this.shaft, this.head);
  }

  /** Points from the origin along a unit vector. */
  point(direction, length) {
    this.visible = length > 0.3 * this.headLength;
    if (!this.visible) return;
    const head = Math.min(this.headLength, 0.6 * length);
    this.shaft.scale.set(1, Math.max(1e-3, length - head), 1);
    this.head.scale.setScalar(head / this.headLength);
    this.head.position.set(0, length - 0.5 * head, 0);
    this.quaternion.setFromUnitVectors(UP, direction);
  }
}

/** Hub, legs, arms and motors as one surface; nose and rotors apart. */
function shapes(rotors) {
  const { arm, blade } = sizes(rotors);
  const at = (x, y, z) => new THREE.Vector3(x * arm, y * arm, z * arm);
  const hull = [new THREE.CylinderGeometry(0.24 * arm, 0.28 * arm, 0.16 * arm, 20).rotateX(-Math.PI / 2)];
  for (const side of [-1, 1]) {
    hull.push(rod(at(0.2, 0.2 * side, 0.06), at(0.22, 0.3 * side, 0.36), 0.022 * arm));
    hull.push(rod(at(-0.2, 0.2 * side, 0.06), at(-0.22, 0.3 * side, 0.36), 0.022 * arm));
    hull.push(rod(at(0.36, 0.3 * side, 0.36), at(-0.36, 0.3 * side, 0.36), 0.026 * arm));
  }
  const places = rotors.map(({ position_body_m, axis_body, spin }) => {
    const [place, axis] = [new THREE.Vector3(...position_body_m), new THREE.Vector3(...axis_body)];
    if (place.length() > 0.02 * arm) hull.push(rod(at(0, 0, 0), place, 0.032 * arm));
    hull.push(rod(place, place.clone().addScaledVector(axis, 0.1 * arm), 0.055 * arm));
    const middle = place.clone().addScaledVector(axis, 0.12 * arm);
    return { middle, axis, turn: spin === "ccw" ? 1 : -1 };
  });
  const nose = new THREE.ConeGeometry(0.1 * arm, 0.26 * arm, 12).rotateZ(-Math.PI / 2).translate(0.38 * arm, 0, 0);
  // A ring with a blade across turns as one.
  const ring = new THREE.TorusGeometry(blade, 0.014 * arm, 4, 32).rotateX(Math.PI / 2);
  const turning = mergeGeometries([ring, new THREE.BoxGeometry(1.96 * blade, 0.014 * arm, 0.15 * blade)]);
  return { arm, blade, hull: mergeGeometries(hull), nose, places, turning };
}

/** A vehicle seen through, all of one colour. */
export function ghostOf(rotors, color) {
  const { hull, nose, places, turning } = shapes(rotors);
  const rings = places.map(({ middle, axis }) => {
    const turn = new THREE.Quaternion().setFromUnitVectors(UP, axis);
    return turning.clone().applyQuaternion(turn).translate(...middle.toArray());
  });
  return new THREE.Mesh(mergeGeometries([hull, nose, ...rings]), flat(color, 0.38));
}

/** The vehicle with its rotors turning and an arrow of thrust on each. */
export class VehiclePicture extends THREE.Group {
  constructor(rotors, { hull, nose, rotorColors }) {
    super();
    const made = shapes(rotors);
    this.add(new THREE.Mesh(made.hull, shaded(hull)), new THREE.Mesh(made.nose, shaded(nose)));
    const disc = new THREE.CircleGeometry(made.blade, 32).rotateX(-Math.PI / 2);
    this.rotors = made.places.map(({ middle, axis, turn }, i) => {
      const head = new THREE.Group();
      head.position.copy(middle);
      head.quaternion.setFromUnitVectors(UP, axis);
      const turning = new THREE.Mesh(made.turning, flat(rotorColors[i]));
      const arrow = new Arrow(rotorColors[i], 0.028 * made.arm);
      arrow.position.copy(middle);
      head.add(new THREE.Mesh(disc, flat(rotorColors[i], 0.2)), turning);
      this.add(head, arrow);
      return { turning, arrow, axis, turn };
    });
    this.arrowLength = 1.9 * made.arm;
  }

  /** Thrust as a share of the greatest, for each rotor. */
  thrusts(shares) {
    this.rotors.forEach(({ arrow, axis }, i) => {
      const share = shares[i] ?? 0;
      const direction = share < 0 ? axis.clone().negate() : axis;
      arrow.point(direction, Math.min(2, Math.abs(share)) * this.arrowLength);
    });
  }

  /** Turns the blades on by the time that was watched, each as fast as its rotor's share of its top speed. */
  spin(shares, watchedS) {
    this.rotors.forEach(({ turning, turn }, i) => {
      turning.rotation.y += turn * (shares[i] ?? 0) * TURNS_PER_S * 2 * Math.PI * watchedS;
    });
  }
}

/** A canopy with its lines above a vehicle, along the body's axis that points up; or a balloon, whose gores
 * reach to its mouth and whose lines meet there. */
export class Canopy extends THREE.Group {
  constructor(reach, length, balloon) {
    super();
    const radius = 1.15 * reach;
    const [gores, rim] = [8, (balloon ? 0.92 : 0.42) * Math.PI];
    const tall = balloon ? 1.15 : 0.8;
    const cloths = [0xdfe6ec, 0xf08c4a].map((color, odd) => {
      const cloth = Array.from({ length: gores / 2 }, (_, k) => {
        const from = ((2 * k + odd) / gores) * 2 * Math.PI;
        return new THREE.SphereGeometry(radius, 5, balloon ? 16 : 8, from, (2 * Math.PI) / gores, 0, rim);
      });
      return new THREE.Mesh(mergeGeometries(cloth).rotateX(-Math.PI / 2).scale(1, 1, tall), shaded(color));
    });
    const [skirt, skirtZ] = [Math.sin(rim) * radius, -length - tall * Math.cos(rim) * radius];
    const ends = Array.from({ length: 2 * gores }, (_, k) => (k / gores) * Math.PI).flatMap((angle) => [
      new THREE.Vector3(0, 0, -0.08 * reach),
      new THREE.Vector3(skirt * Math.cos(angle), skirt * Math.sin(angle), skirtZ),
    ]);
    cloths.forEach((cloth) => (cloth.position.z = -length));
    this.cloths = cloths;
    this.length = length;
    this.lines = new Segments(ends, 0x888888, 1);
    this.add(...cloths, this.lines);
  }

  fade(opacity) {
    this.visible = opacity > 0.01;
    this.lines.visible = opacity === 1;
    this.cloths.forEach((cloth) => (cloth.material.uniforms.opacity.value = opacity));
  }
}
