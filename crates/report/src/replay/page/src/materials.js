// Surfaces and lines. Two small programs of the graphics card draw all of the scene: where a processor does
// its work, making a program takes longer than a frame.

import * as THREE from "three";
import { LineSegmentsGeometry } from "three/examples/jsm/lines/LineSegmentsGeometry.js";
import { css } from "./colors.js";

/** Light from the sky above and the ground below, and a sun; on both sides of a surface. */
const SURFACE = {
  vertexShader: `
    uniform vec3 shade;
    varying vec3 front, back;
    vec3 light(vec3 n) {
      const vec3 sun = normalize(vec3(-2.0, 5.0, 3.0));
      return 0.764 * mix(shade, vec3(1.0), 0.5 + 0.5 * n.y) + 0.509 * max(0.0, dot(n, sun));
    }
    void main() {
      vec3 n = normalize(mat3(modelMatrix) * normal);
      front = light(n);
      back = light(-n);
      gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
    }`,
  fragmentShader: `
    uniform vec3 color;
    uniform float opacity, glow;
    varying vec3 front, back;
    void main() {
      gl_FragColor = vec4(color * mix(gl_FrontFacing ? front : back, vec3(1.0), glow), opacity);
      #include <colorspace_fragment>
    }`,
};

/** Lines as wide as that on the screen [px], their ends round: a line without length is a dot. */
const LINE = {
  vertexShader: `
    uniform float width;
    uniform vec2 resolution;
    attribute vec3 instanceStart, instanceEnd, instanceColorStart, instanceColorEnd;
    varying vec2 at;
    varying vec3 tint;
    void main() {
      bool first = position.y < 0.5;
      at = uv;
      tint = first ? instanceColorStart : instanceColorEnd;
      vec4 from = modelViewMatrix * vec4(instanceStart, 1.0);
      vec4 to = modelViewMatrix * vec4(instanceEnd, 1.0);
      // What lies behind the eye is cut off.
      float near = -0.5 * projectionMatrix[3][2] / projectionMatrix[2][2];
      if (from.z < near && to.z > near) to = mix(from, to, (near - from.z) / (to.z - from.z));
      else if (to.z < near && from.z > near) from = mix(to, from, (near - to.z) / (from.z - to.z));
      from = projectionMatrix * from;
      to = projectionMatrix * to;
      vec2 along = (to.xy / to.w - from.xy / from.w) * resolution;
      along = dot(along, along) > 0.0 ? normalize(along) : vec2(1.0, 0.0);
      vec2 offset = position.x * vec2(along.y, -along.x);
      if (position.y < 0.0) offset -= along;
      else if (position.y > 1.0) offset += along;
      gl_Position = first ? from : to;
      gl_Position.xy += offset * width / resolution * gl_Position.w;
    }`,
  fragmentShader: `
    varying vec2 at;
    varying vec3 tint;
    void main() {
      float beyond = max(0.0, abs(at.y) - 1.0);
      if (beyond > 0.0 && at.x * at.x + beyond * beyond > 1.0) discard;
      gl_FragColor = vec4(tint, 1.0);
      #include <colorspace_fragment>
    }`,
};

function surface(color, opacity, glow, depthWrite) {
  const uniforms = { color: new THREE.Color(color), shade: new THREE.Color(css("shade")), opacity, glow };
  return new THREE.ShaderMaterial({
    ...SURFACE,
    uniforms: Object.fromEntries(Object.entries(uniforms).map(([name, value]) => [name, { value }])),
    transparent: true,
    side: THREE.DoubleSide,
    forceSinglePass: true,
    depthWrite,
  });
}

export function shaded(color) {
  return surface(color, 1, 0, true);
}

export function flat(color, opacity = 1) {
  return surface(color, opacity, 1, opacity === 1);
}

/** Lines between points, two and two: of one colour, or one for each point. */
export class Segments extends THREE.Mesh {
  constructor(points, color, width, depthWrite = true) {
    const geometry = new LineSegmentsGeometry();
    geometry.setPositions(points.flatMap((point) => (Array.isArray(point) ? point : point.toArray())));
    const one = Array.isArray(color) ? null : new THREE.Color(color).toArray();
    geometry.setColors(points.flatMap((_, i) => one ?? color[i]));
    const uniforms = { width: { value: width }, resolution: { value: new THREE.Vector2() } };
    super(geometry, new THREE.ShaderMaterial({ ...LINE, uniforms, depthWrite, side: THREE.DoubleSide }));
    this.viewport = new THREE.Vector4();
  }

  onBeforeRender(renderer) {
    const { z, w } = renderer.getViewport(this.viewport);
    this.material.uniforms.resolution.value.set(z, w);
  }
}

/** A line through points. */
export function lineThrough(points, color, width) {
  const pairs = (all) => all.slice(1).flatMap((next, i) => [all[i], next]);
  return new Segments(pairs(points), Array.isArray(color) ? pairs(color) : color, width, false);
}
