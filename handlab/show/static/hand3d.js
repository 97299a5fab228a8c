// The hand in WebGL2: skin blended from bone motions, bones, two-pass translucency, camera, picking. No libraries.

import { Flesh } from "./flesh.js";
import { evenTones, joined, leanBones, leanFlesh, leanSkin } from "./lean.js";

const FLOATS = { f4: Float32Array, i2: Int16Array, u4: Uint32Array, u2: Uint16Array, u1: Uint8Array };

// A scene as `wire.py` packs it: {names and numbers..., arrays: {name: typed array}}.
export function unpackScene(buffer) {
  const bytes = asBytes(buffer);
  const size = new DataView(bytes.buffer, bytes.byteOffset).getUint32(0, true);
  const scene = JSON.parse(new TextDecoder().decode(bytes.subarray(4, 4 + size)));
  const arrays = {};
  for (const [name, [kind, shape, offset]] of Object.entries(scene.arrays)) {
    const Kind = FLOATS[kind];
    const length = shape.reduce((a, b) => a * b, 1);
    const start = 4 + size + offset;
    arrays[name] = new Kind(bytes.slice(start, start + length * Kind.BYTES_PER_ELEMENT).buffer);
  }
  return { ...scene, arrays };
}

export function asBytes(data) {
  if (data instanceof Uint8Array) return data;
  if (ArrayBuffer.isView(data)) return new Uint8Array(data.buffer, data.byteOffset, data.byteLength);
  return new Uint8Array(data);
}

// A frame as `wire.py` packs it.
export function unpackFrame(data, scene) {
  let bytes = asBytes(data);
  if (bytes.byteOffset % 4) bytes = bytes.slice();
  const head = new Uint32Array(bytes.buffer, bytes.byteOffset, 3);
  const words = new Float32Array(bytes.buffer, bytes.byteOffset, bytes.byteLength >> 2);
  const m = scene.muscles.length, d = scene.dofs.length, b = scene.bodies.length;
  let at = 5;
  const take = (count) => words.subarray(at, (at += count));
  const kind = head[0], whole = (count) => {
    const taken = new Int16Array(bytes.buffer, bytes.byteOffset + 4 * at, count);
    at += (count + 1) >> 1;
    return taken;
  };
  const ridges = () => {
    const count = new Uint32Array(bytes.buffer, bytes.byteOffset + 4 * at, 1)[0];
    at += 1;
    const points = new Uint16Array(bytes.buffer, bytes.byteOffset + 4 * at, count);
    at += (count + 1) >> 1;
    const lifts = new Uint8Array(bytes.buffer, bytes.byteOffset + 4 * at, count);
    at += (count + 3) >> 2;
    return { points, lifts };
  };
  return {
    moving: (head[1] & 1) !== 0, playing: (head[1] & 2) !== 0, clip: (head[1] & 4) !== 0, echo: head[2],
    time: words[3], seconds: words[4], bytes: bytes.byteLength,
    contraction: take(m), angle: take(d), length: take(m), force: take(m), motion: take(12 * b),
    skin: kind & 2 ? whole(scene.arrays.skin_points.length) : null,
    ridges: kind & 8 ? ridges() : null,
    segments: kind & 4 ? whole((bytes.byteLength >> 1) - 2 * at) : null,
  };
}

// The light is the one of the stills (look.py): sums in the camera's frame, constants instead of powers.
const STUDIO = `
vec3 studio(vec3 N, vec3 tone, vec3 spread, vec3 low, vec2 gloss) {
  float up = 0.5 + 0.5 * N.y;
  float edge = 1.0 - clamp(N.z, 0.0, 1.0);
  float k = dot(N, vec3(-0.4480, 0.6471, 0.6170));
  vec3 wrapped = clamp((vec3(k) + spread) / (vec3(1.0) + spread), 0.0, 1.0);
  float fill = clamp((dot(N, vec3(0.8053, 0.0537, 0.5905)) + 0.3) * 0.7692, 0.0, 1.0);
  vec3 lit = tone * (mix(low, vec3(0.45, 0.46, 0.48), up) + wrapped * vec3(0.60, 0.585, 0.564) + fill * vec3(0.176, 0.186, 0.20));
  float s2 = max(dot(N, vec3(-0.2491, 0.3599, 0.8992)), 0.0); s2 *= s2;
  float s8 = s2 * s2; s8 *= s8;
  float s16 = s8 * s8;
  float s64 = s16 * s16; s64 *= s64;
  return lit + (gloss.x * s16 + gloss.y * s64) * vec3(1.0, 0.97, 0.93) + (0.09 * edge * edge * edge * up) * vec3(1.0, 0.88, 0.80);
}`;
const SKIN_VERTEX = `#version 300 es
layout(location=0) in vec3 point; layout(location=1) in vec3 normal; layout(location=2) in vec3 tone; layout(location=3) in float part;
uniform mat4 project; uniform mat3 turn; uniform float hot;
out vec3 n; out vec3 c;
void main() {
  gl_Position = project * vec4(point, 1.0); n = turn * normal;
  c = abs(part - hot) < 0.5 ? mix(tone, vec3(0.98, 0.72, 0.42), 0.22) : tone;
}`;
const SKIN_FRAGMENT = `#version 300 es
precision highp float;
in vec3 n; in vec3 c; uniform vec2 density; out vec4 pixel;
${STUDIO}
void main() {
  vec3 N = normalize(gl_FrontFacing ? n : -n);
  float edge = 1.0 - clamp(N.z, 0.0, 1.0);
  pixel = vec4(studio(N, c, vec3(0.42, 0.20, 0.14), vec3(0.40, 0.325, 0.305), vec2(0.085, 0.05)), density.x + (density.y - density.x) * edge * edge);
}`;
const BONE_VERTEX = `#version 300 es
layout(location=0) in vec3 point; layout(location=1) in vec3 normal; layout(location=2) in vec2 own;
uniform mat4 project; uniform mat3 turn; uniform vec4 motion[57]; uniform float hot;
out vec3 n; out vec3 c;
void main() {
  int k = 3 * int(own.x + 0.5);
  vec4 p = vec4(point, 1.0);
  vec3 world = vec3(dot(motion[k], p), dot(motion[k + 1], p), dot(motion[k + 2], p));
  n = turn * vec3(dot(motion[k].xyz, normal), dot(motion[k + 1].xyz, normal), dot(motion[k + 2].xyz, normal));
  gl_Position = project * vec4(world, 1.0);
  c = abs(own.y - hot) < 0.5 ? vec3(0.902, 0.624, 0.0) : vec3(0.937, 0.894, 0.796);
}`;
const BONE_FRAGMENT = `#version 300 es
precision highp float;
in vec3 n; in vec3 c; out vec4 pixel;
${STUDIO}
void main() { pixel = vec4(studio(normalize(n), c, vec3(0.30, 0.24, 0.18), vec3(0.38, 0.34, 0.30), vec2(0.07, 0.08)), 1.0); }`;
const FLESH_FRAGMENT = `#version 300 es
precision highp float;
in vec3 n; in vec3 c; out vec4 pixel;
${STUDIO}
void main() {
  bool sinew = c.b > c.r; // bluish white, as in look.py's stills
  vec3 N = normalize(n);
  pixel = vec4(sinew ? studio(N, c, vec3(0.30, 0.27, 0.25), vec3(0.40, 0.42, 0.44), vec2(0.16, 0.22))
    : studio(N, c, vec3(0.34, 0.16, 0.12), vec3(0.36, 0.28, 0.26), vec2(0.10, 0.16)), 1.0);
}`;
const SKY_VERTEX = `#version 300 es
out float h;
void main() { vec2 p = vec2(float((gl_VertexID << 1) & 2), float(gl_VertexID & 2)); h = p.y; gl_Position = vec4(p * 2.0 - 1.0, 0.9999, 1.0); }`;
const SKY_FRAGMENT = `#version 300 es
precision highp float;
in float h; out vec4 pixel;
void main() { pixel = vec4(mix(vec3(1.0), vec3(0.890, 0.910, 0.929), h), 1.0); }`;

const FAR_SIDE = [0.10, 0.34], NEAR_SIDE = [0.20, 0.86], SOLID = [1, 1];
const LIFT_UNIT = 2e-5; // metres, as in `wire.py`
const SLOW_PACE_MS = 26, FAST_PACE_MS = 17.5; // between pictures of a software renderer: beyond the first it draws fewer pixels
const LEAN_PIXEL = 0.0003; // metres: seen from nearer, fewer triangles would show
const STILL_AFTER_MS = 180; // a hand at rest is drawn once more, with smooth outlines

// Vertex normals, weighted by area, into `out`; `points` and `out` are flat.
function normalsInto(points, faces, out) {
  out.fill(0);
  for (let f = 0; f < faces.length; f += 3) {
    const i = 3 * faces[f], j = 3 * faces[f + 1], k = 3 * faces[f + 2];
    const px = points[i], py = points[i + 1], pz = points[i + 2];
    const ax = points[j] - px, ay = points[j + 1] - py, az = points[j + 2] - pz;
    const bx = points[k] - px, by = points[k + 1] - py, bz = points[k + 2] - pz;
    const x = ay * bz - az * by, y = az * bx - ax * bz, z = ax * by - ay * bx;
    out[i] += x; out[i + 1] += y; out[i + 2] += z;
    out[j] += x; out[j + 1] += y; out[j + 2] += z;
    out[k] += x; out[k + 1] += y; out[k + 2] += z;
  }
  for (let v = 0; v < out.length; v += 3) {
    const s = 1 / (Math.sqrt(out[v] * out[v] + out[v + 1] * out[v + 1] + out[v + 2] * out[v + 2]) || 1);
    out[v] *= s; out[v + 1] *= s; out[v + 2] *= s;
  }
}

// Unit dual quaternions (w x y z, then the dual part) of rigid 3x4 transforms, as in skin_kernel.py.
function dualQuaternions(motion, out) {
  for (let b = 0; b < out.length / 8; b++) {
    const t = motion, o = 12 * b;
    const m00 = t[o], m01 = t[o + 1], m02 = t[o + 2], m10 = t[o + 4], m11 = t[o + 5], m12 = t[o + 6], m20 = t[o + 8], m21 = t[o + 9], m22 = t[o + 10];
    const trace = m00 + m11 + m22;
    let w, x, y, z, s;
    if (trace > 0) {
      s = 2 * Math.sqrt(trace + 1); w = s / 4; x = (m21 - m12) / s; y = (m02 - m20) / s; z = (m10 - m01) / s;
    } else if (m00 > m11 && m00 > m22) {
      s = 2 * Math.sqrt(1 + m00 - m11 - m22); w = (m21 - m12) / s; x = s / 4; y = (m01 + m10) / s; z = (m02 + m20) / s;
    } else if (m11 > m22) {
      s = 2 * Math.sqrt(1 + m11 - m00 - m22); w = (m02 - m20) / s; x = (m01 + m10) / s; y = s / 4; z = (m12 + m21) / s;
    } else {
      s = 2 * Math.sqrt(1 + m22 - m00 - m11); w = (m10 - m01) / s; x = (m02 + m20) / s; y = (m12 + m21) / s; z = s / 4;
    }
    const p = t[o + 3] / 2, q = t[o + 7] / 2, r = t[o + 11] / 2, d = 8 * b;
    out[d] = w; out[d + 1] = x; out[d + 2] = y; out[d + 3] = z;
    out[d + 4] = -p * x - q * y - r * z;
    out[d + 5] = p * w + q * z - r * y;
    out[d + 6] = q * w + r * x - p * z;
    out[d + 7] = r * w + p * y - q * x;
  }
}

function blendInto(points, bodies, weights, dual, out) {
  for (let n = 0, k4 = 0; n < points.length; n += 3, k4 += 4) {
    const f = 8 * bodies[k4];
    const w0 = dual[f], x0 = dual[f + 1], y0 = dual[f + 2], z0 = dual[f + 3];
    let w = 0, x = 0, y = 0, z = 0, dw = 0, dx = 0, dy = 0, dz = 0;
    for (let k = k4; k < k4 + 4; k++) {
      let g = weights[k];
      if (g === 0) break;
      const b = 8 * bodies[k];
      if (w0 * dual[b] + x0 * dual[b + 1] + y0 * dual[b + 2] + z0 * dual[b + 3] < 0) g = -g; // the shorter turn
      w += g * dual[b]; x += g * dual[b + 1]; y += g * dual[b + 2]; z += g * dual[b + 3];
      dw += g * dual[b + 4]; dx += g * dual[b + 5]; dy += g * dual[b + 6]; dz += g * dual[b + 7];
    }
    const s = 2 / (w * w + x * x + y * y + z * z);
    const p = points[n], q = points[n + 1], r = points[n + 2];
    const a = y * r - z * q + w * p, b = z * p - x * r + w * q, c = x * q - y * p + w * r;
    out[n] = p + s * (y * c - z * b + w * dx - dw * x + y * dz - z * dy);
    out[n + 1] = q + s * (z * a - x * c + w * dy - dw * y + z * dx - x * dz);
    out[n + 2] = r + s * (x * b - y * a + w * dz - dw * z + x * dy - y * dx);
  }
}

const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const unit = (a) => { const s = 1 / Math.hypot(...a); return a.map((v) => v * s); };
const about = (v, axis, angle) => { // Rodrigues
  const c = Math.cos(angle), s = Math.sin(angle), d = dot(axis, v) * (1 - c), x = cross(axis, v);
  return v.map((value, i) => value * c + x[i] * s + axis[i] * d);
};

// Nearest hit of a ray with triangles `from`..`to` of `faces`: distance, or Infinity. `hit.face` is set.
export function rayTriangles(points, faces, from, to, o, d, nearest, hit) {
  for (let f = from; f < to; f += 3) {
    const i = 3 * faces[f], j = 3 * faces[f + 1], k = 3 * faces[f + 2];
    const ax = points[j] - points[i], ay = points[j + 1] - points[i + 1], az = points[j + 2] - points[i + 2];
    const bx = points[k] - points[i], by = points[k + 1] - points[i + 1], bz = points[k + 2] - points[i + 2];
    const px = d[1] * bz - d[2] * by, py = d[2] * bx - d[0] * bz, pz = d[0] * by - d[1] * bx;
    const det = ax * px + ay * py + az * pz;
    if (det > -1e-12 && det < 1e-12) continue;
    const inv = 1 / det, tx = o[0] - points[i], ty = o[1] - points[i + 1], tz = o[2] - points[i + 2];
    const u = (tx * px + ty * py + tz * pz) * inv;
    if (u < 0 || u > 1) continue;
    const qx = ty * az - tz * ay, qy = tz * ax - tx * az, qz = tx * ay - ty * ax;
    const v = (d[0] * qx + d[1] * qy + d[2] * qz) * inv;
    if (v < 0 || u + v > 1) continue;
    const t = (bx * qx + by * qy + bz * qz) * inv;
    if (t > 0 && t < nearest) { nearest = t; hit.face = f; }
  }
  return nearest;
}

export class Hand3D {
  constructor(canvas, scene, look = {}) {
    this.canvas = canvas;
    this.scene = scene;
    this.look = { skin: "solid", bones: true, view: "palm", muscles: false, tendons: false, ...look };
    this.hot = { bone: -1, part: -1, flesh: -1 };
    this.flesh = null;
    this.segments = null; // the newest that came
    this.drawn = 0;
    const A = scene.arrays;
    this.coarse = new Float32Array(A.skin_points);
    this.coarseNormals = new Float32Array(this.coarse.length);
    const fine = A.fine_triangle.length;
    this.points = new Float32Array(3 * fine);
    this.normals = new Float32Array(3 * fine);
    this.raised = new Float32Array(fine); // by tendons
    this.dual = new Float32Array(8 * scene.bodies.length);
    this.motion = new Float32Array(12 * scene.bodies.length);
    for (let b = 0; b < scene.bodies.length; b++) this.motion.set([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0], 12 * b);
    this.boneNormals = new Float32Array(A.bone_points.length);
    normalsInto(A.bone_points, A.bone_faces, this.boneNormals);
    this.boneFaceStarts = boneFaceStarts(scene);
    this.setUp();
    this.pose(null);
    this.view(this.look.view);
  }

  setUp() {
    const gl = this.gl = this.canvas.getContext("webgl2", { antialias: false, alpha: false, powerPreference: "high-performance" });
    if (!gl) { this.paper = this.canvas.getContext("2d"); return; }
    const info = gl.getExtension("WEBGL_debug_renderer_info");
    this.renderer = info ? gl.getParameter(info.UNMASKED_RENDERER_WEBGL) : "unknown";
    this.software = /swiftshader|llvmpipe|software/i.test(this.renderer);
    this.programs = {
      skin: program(gl, SKIN_VERTEX, SKIN_FRAGMENT), bone: program(gl, BONE_VERTEX, BONE_FRAGMENT), sky: program(gl, SKY_VERTEX, SKY_FRAGMENT),
      flesh: program(gl, SKIN_VERTEX, FLESH_FRAGMENT),
    };
    const { arrays: A, bones } = this.scene;
    const part = new Float32Array(A.fine_triangle.length);
    for (let v = 0; v < part.length; v++) part[v] = A.skin_bodies[4 * this.cornerOf(v)];
    this.skinArray = gl.createVertexArray();
    gl.bindVertexArray(this.skinArray);
    this.pointBuffer = attribute(gl, 0, 3, this.points, gl.DYNAMIC_DRAW);
    this.normalBuffer = attribute(gl, 1, 3, this.normals, gl.DYNAMIC_DRAW);
    attribute(gl, 2, 3, A.fine_tone, gl.STATIC_DRAW, gl.UNSIGNED_BYTE);
    attribute(gl, 3, 1, part, gl.STATIC_DRAW);
    this.leanSkin = this.software ? leanSkin(this.restingFine(), A.fine_faces) : A.fine_faces.subarray(0, 0);
    indices(gl, joined(A.fine_faces, this.leanSkin));
    if (this.software) this.setUpFar();
    const own = new Float32Array(2 * A.bone_points.length / 3);
    bones.forEach((bone, k) => {
      for (let v = A.bone_starts[k]; v < A.bone_starts[k + 1]; v++) { own[2 * v] = bone.body; own[2 * v + 1] = k; }
    });
    this.boneArray = gl.createVertexArray();
    gl.bindVertexArray(this.boneArray);
    attribute(gl, 0, 3, A.bone_points, gl.STATIC_DRAW);
    attribute(gl, 1, 3, this.boneNormals, gl.STATIC_DRAW);
    attribute(gl, 2, 2, own, gl.STATIC_DRAW);
    this.leanBones = this.software ? leanBones(A.bone_points, A.bone_faces, (v) => own[2 * v + 1]) : A.bone_faces.subarray(0, 0);
    indices(gl, joined(A.bone_faces, this.leanBones));
    gl.bindVertexArray(null);
    this.fleshArray = null;
    if (this.flesh) this.setUpFlesh();
    gl.enable(gl.DEPTH_TEST);
    gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
  }

  // The far side of translucent skin, for a software renderer that moves: the even skin, a fifth of the triangles.
  setUpFar() {
    const gl = this.gl, A = this.scene.arrays, count = this.coarse.length / 3;
    const part = new Float32Array(count).map((_, v) => A.skin_bodies[4 * v]);
    this.farArray = gl.createVertexArray();
    gl.bindVertexArray(this.farArray);
    this.farPointBuffer = attribute(gl, 0, 3, this.coarse, gl.DYNAMIC_DRAW);
    this.farNormalBuffer = attribute(gl, 1, 3, this.coarseNormals, gl.DYNAMIC_DRAW);
    attribute(gl, 2, 3, evenTones(A.fine_tone, count, (v) => this.cornerOf(v)), gl.STATIC_DRAW, gl.UNSIGNED_BYTE);
    attribute(gl, 3, 1, part, gl.STATIC_DRAW);
    indices(gl, A.skin_faces);
  }

  // Muscles and tendons, once: `layers` as `flesh.py` packs them.
  takeLayers(layers) {
    this.flesh = new Flesh(layers, this.scene.unit);
    this.fleshNormals = new Float32Array(this.flesh.points.length);
    if (this.gl) this.setUpFlesh();
    this.layFlesh();
  }

  setUpFlesh() {
    const gl = this.gl;
    this.fleshArray = gl.createVertexArray();
    gl.bindVertexArray(this.fleshArray);
    this.fleshPointBuffer = attribute(gl, 0, 3, this.flesh.points, gl.DYNAMIC_DRAW);
    this.fleshNormalBuffer = attribute(gl, 1, 3, this.fleshNormals, gl.DYNAMIC_DRAW);
    attribute(gl, 2, 3, this.flesh.tone, gl.STATIC_DRAW, gl.UNSIGNED_BYTE);
    attribute(gl, 3, 1, this.flesh.own, gl.STATIC_DRAW);
    this.leanFlesh = this.software ? leanFlesh(this.flesh.layers) : { faces: new Uint16Array(0), split: 0 };
    indices(gl, joined(this.flesh.faces, this.leanFlesh.faces));
    gl.bindVertexArray(null);
  }

  // Which corners of the flesh's triangles are drawn: muscles stand before tendons.
  fleshShown() {
    const { muscles, tendons, skin } = this.look;
    if (!this.flesh || skin === "solid") return [0, 0];
    const some = muscles && this.segments?.length === 10 * this.flesh.segments; // a frame may be older than the muscles
    return [some ? 0 : this.flesh.split, tendons ? this.flesh.faces.length : this.flesh.split];
  }

  // How far a tendon has left the bone over its knuckle.
  bow({ muscle, knuckle, reach }) {
    if (!this.force) return 0;
    const { straight, most_bow: most } = this.flesh.layers, share = this.force[muscle] / (straight * this.scene.muscles[muscle].max_force);
    return Math.min(Math.max(share, 0), 1) * Math.min(Math.max(Math.sin(-this.angle[knuckle]), 0) * reach, most);
  }

  // Only what is seen is computed.
  layFlesh() {
    const [from, to] = this.fleshShown();
    if (from >= to) return;
    if (from === 0) this.flesh.layMuscles(this.segments);
    if (to > this.flesh.split) this.flesh.layTendons(this.motion, (taut) => this.bow(taut));
    normalsInto(this.flesh.points, this.flesh.faces.subarray(from, to), this.fleshNormals);
    this.fleshFresh = true;
    this.redraw();
  }

  // The fine skin of the stored posture.
  restingFine() {
    const normals = new Float32Array(this.coarse.length), { skin_points: P, skin_faces: F } = this.scene.arrays, out = new Float32Array(this.points.length);
    normalsInto(P, F, normals);
    this.fineInto(P, normals, out);
    return out;
  }

  fineInto(P, N, out) {
    const A = this.scene.arrays, D = new Float64Array(P.length / 3);
    for (let v = 0, i = 0; i < P.length; v++, i += 3) D[v] = P[i] * N[i] + P[i + 1] * N[i + 1] + P[i + 2] * N[i + 2];
    for (let v = 0, o = 0; v < A.fine_triangle.length; v++, o += 3) {
      const t = 3 * A.fine_triangle[v], I = A.skin_faces[t], J = A.skin_faces[t + 1], K = A.skin_faces[t + 2], i = 3 * I, j = 3 * J, k = 3 * K;
      const a = A.fine_barycentric[2 * v], b = A.fine_barycentric[2 * v + 1], c = 1 - a - b;
      const x = a * P[i] + b * P[j] + c * P[k], y = a * P[i + 1] + b * P[j + 1] + c * P[k + 1], z = a * P[i + 2] + b * P[j + 2] + c * P[k + 2];
      const p = a * N[i] + b * N[j] + c * N[k], q = a * N[i + 1] + b * N[j + 1] + c * N[k + 1], r = a * N[i + 2] + b * N[j + 2] + c * N[k + 2];
      // how far the even skin, as curved as its normals say, rises over its triangle (`skin_kernel.sagitta`)
      const sag = 0.5 * (a * D[I] + b * D[J] + c * D[K] - x * p - y * q - z * r), h = A.fine_height[v] + this.raised[v] + sag;
      out[o] = x + h * p; out[o + 1] = y + h * q; out[o + 2] = z + h * r;
    }
  }

  cornerOf(v) { // the even skin's point that bears most of fine point v
    const A = this.scene.arrays, u = A.fine_barycentric[2 * v], w = A.fine_barycentric[2 * v + 1], t = 3 * A.fine_triangle[v];
    const last = 1 - u - w;
    return A.skin_faces[t + (u >= w && u >= last ? 0 : w >= last ? 1 : 2)];
  }

  // A frame of a motion: of several that come before the next picture, only the last is laid.
  follow(frame) {
    this.coming = frame;
    this.redraw();
  }

  lay() { if (this.coming) this.pose(this.coming); }

  // Take a frame (or null: the stored meshes) and lay the fine skin on it.
  pose(frame) {
    const A = this.scene.arrays;
    this.coming = null;
    if (frame) this.motion.set(frame.motion);
    this.raised.fill(0);
    if (frame?.ridges) frame.ridges.points.forEach((v, k) => { this.raised[v] = frame.ridges.lifts[k] * LIFT_UNIT; });
    if (frame?.force) { this.force = frame.force.slice(); this.angle = frame.angle.slice(); }
    if (frame) this.segments = frame.segments ? frame.segments.slice() : null;
    if (frame && frame.skin) for (let v = 0; v < this.coarse.length; v++) this.coarse[v] = frame.skin[v] * this.scene.unit;
    else {
      dualQuaternions(this.motion, this.dual);
      blendInto(A.skin_points, A.skin_bodies, A.skin_weights, this.dual, this.coarse);
    }
    normalsInto(this.coarse, A.skin_faces, this.coarseNormals);
    this.fineInto(this.coarse, this.coarseNormals, this.points);
    normalsInto(this.points, A.fine_faces, this.normals);
    this.fresh = true;
    this.layFlesh();
    this.redraw();
  }

  // ---- camera: `eye` (to the camera), `up`, `right` are unit vectors, `focus` a point, `distance` in metres

  view(name) {
    const [toEye, up] = this.scene.views[name] || this.scene.views.palm;
    this.viewName = name;
    this.eye = unit(toEye);
    this.right = unit(cross(up, this.eye));
    this.up = cross(this.eye, this.right);
    this.fit();
  }

  // Let the whole hand stand in the picture, below the buttons that cover its upper edge.
  fit(margin = 0.93) {
    this.lay();
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity], axes = [this.right, this.up, this.eye];
    for (const P of [this.coarse, this.scene.arrays.skin_points]) { // the stored posture is open: a hand that opens stays in view
      for (let v = 0; v < P.length; v += 3) {
        for (let x = 0; x < 3; x++) {
          const s = P[v] * axes[x][0] + P[v + 1] * axes[x][1] + P[v + 2] * axes[x][2];
          if (s < low[x]) low[x] = s;
          if (s > high[x]) high[x] = s;
        }
      }
    }
    const mid = low.map((value, x) => (value + high[x]) / 2);
    this.focus = [0, 1, 2].map((x) => mid[0] * axes[0][x] + mid[1] * axes[1][x] + mid[2] * axes[2][x]);
    const reach = Math.tan(this.scene.lens_deg * Math.PI / 360) * margin;
    const w = Math.max(this.canvas.clientWidth, 1), h = Math.max(this.canvas.clientHeight, 1), covered = Math.min(this.covered || 0, h / 3);
    this.distance = Math.max((high[0] - mid[0]) / (reach * w / h), (high[1] - mid[1]) / (reach * (1 - covered / h))) + (high[2] - mid[2]) / 2;
    const shift = covered / h * this.distance * Math.tan(this.scene.lens_deg * Math.PI / 360);
    this.focus = this.focus.map((value, x) => value + shift * axes[1][x]);
    this.redraw();
  }

  orbit(dx, dy) {
    for (const [axis, angle] of [[this.up, -dx], [this.right, -dy]]) {
      this.eye = about(this.eye, axis, angle);
      this.up = about(this.up, axis, angle);
    }
    this.eye = unit(this.eye);
    this.right = unit(cross(this.up, this.eye));
    this.up = cross(this.eye, this.right);
    this.viewName = "";
    this.redraw();
  }

  pan(dx, dy) { // in CSS pixels
    const scale = 2 * this.distance * Math.tan(this.scene.lens_deg * Math.PI / 360) / this.canvas.clientHeight;
    this.focus = this.focus.map((value, x) => value - scale * (dx * this.right[x] - dy * this.up[x]));
    this.viewName = "";
    this.redraw();
  }

  zoom(factor) {
    this.distance = Math.min(Math.max(this.distance * factor, 0.12), 6);
    this.redraw();
  }

  camera() {
    return { eye: this.eye, up: this.up, right: this.right, focus: this.focus, distance: this.distance };
  }

  projection() {
    const near = Math.max(this.distance - 0.35, 0.02), far = this.distance + 0.35;
    const f = 1 / Math.tan(this.scene.lens_deg * Math.PI / 360), aspect = this.canvas.width / this.canvas.height;
    const a = (near + far) / (near - far), b = 2 * near * far / (near - far);
    const p = this.focus.map((value, x) => value + this.distance * this.eye[x]);
    const R = this.right, U = this.up, E = this.eye;
    const tr = -dot(R, p), tu = -dot(U, p), te = -dot(E, p);
    const out = new Float32Array(16); // column-major
    for (let x = 0; x < 3; x++) {
      out[4 * x] = f / aspect * R[x]; out[4 * x + 1] = f * U[x]; out[4 * x + 2] = a * E[x]; out[4 * x + 3] = -E[x];
    }
    out[12] = f / aspect * tr; out[13] = f * tu; out[14] = a * te + b; out[15] = -te;
    return out;
  }

  // ---- drawing

  redraw() {
    if (this.pending) return;
    this.pending = requestAnimationFrame(() => {
      try { this.lay(); } finally { this.pending = 0; }
      this.draw();
    });
  }

  // Pixels of the canvas per CSS pixel: fewer while a software renderer moves, more at rest.
  density(still) {
    const screen = Math.min(window.devicePixelRatio || 1, 2);
    return !this.software || still ? Math.max(screen, 2) : this.coarser ? 0.7 : 1;
  }

  draw(still = false) {
    const { clientWidth: w, clientHeight: h } = this.canvas;
    if (!w || !h || this.gone) return;
    const now = performance.now(), gap = now - (this.drawnAt || 0);
    this.drawnAt = now;
    if (!still && gap < 250) this.pace = 0.9 * (this.pace || 16) + 0.1 * gap;
    if (this.pace > SLOW_PACE_MS) this.coarser = true;
    else if (this.pace < FAST_PACE_MS) this.coarser = false;
    const scale = this.density(still), width = Math.round(w * scale), height = Math.round(h * scale);
    if (this.canvas.width !== width || this.canvas.height !== height) { this.canvas.width = width; this.canvas.height = height; }
    this.lean = this.software && !still && 2 * this.distance * Math.tan(this.scene.lens_deg * Math.PI / 360) > LEAN_PIXEL * height;
    if (!this.gl) this.drawFlat(); else this.drawGL();
    this.drawn += 1;
    if (this.ondraw) this.ondraw();
    clearTimeout(this.rest);
    if (!still && this.software) this.rest = setTimeout(() => { if (!this.pending) this.draw(true); }, STILL_AFTER_MS);
  }

  drawGL() {
    const gl = this.gl, A = this.scene.arrays, { skin, bones } = this.look;
    if (gl.isContextLost()) return;
    gl.viewport(0, 0, this.canvas.width, this.canvas.height);
    gl.clear(gl.DEPTH_BUFFER_BIT | gl.COLOR_BUFFER_BIT);
    const project = this.projection();
    const turn = new Float32Array([0, 1, 2].flatMap((x) => [this.right[x], this.up[x], this.eye[x]]));
    if (this.fresh) {
      gl.bindBuffer(gl.ARRAY_BUFFER, this.pointBuffer); gl.bufferSubData(gl.ARRAY_BUFFER, 0, this.points);
      gl.bindBuffer(gl.ARRAY_BUFFER, this.normalBuffer); gl.bufferSubData(gl.ARRAY_BUFFER, 0, this.normals);
      if (this.farArray) {
        gl.bindBuffer(gl.ARRAY_BUFFER, this.farPointBuffer); gl.bufferSubData(gl.ARRAY_BUFFER, 0, this.coarse);
        gl.bindBuffer(gl.ARRAY_BUFFER, this.farNormalBuffer); gl.bufferSubData(gl.ARRAY_BUFFER, 0, this.coarseNormals);
      }
      this.fresh = false;
    }
    gl.enable(gl.CULL_FACE);
    if (bones && skin !== "solid") {
      const use = this.begin("bone", project, turn, this.hot.bone);
      gl.uniform4fv(use("motion"), this.motion);
      gl.bindVertexArray(this.boneArray);
      gl.cullFace(gl.BACK);
      this.drawPart(A.bone_faces.length, this.leanBones.length);
    }
    this.drawFlesh(project, turn);
    if (skin === "solid") this.drawSkin(project, turn, SOLID, gl.BACK);
    gl.useProgram(this.programs.sky.program); // behind everything opaque: pixels that the hand covers are not filled twice
    gl.disable(gl.CULL_FACE);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    if (skin === "translucent") {
      gl.enable(gl.CULL_FACE);
      gl.enable(gl.BLEND);
      gl.depthMask(false);
      this.drawSkin(project, turn, FAR_SIDE, gl.FRONT);
      this.drawSkin(project, turn, NEAR_SIDE, gl.BACK);
      gl.depthMask(true);
      gl.disable(gl.BLEND);
    }
    gl.bindVertexArray(null);
  }

  drawFlesh(project, turn) {
    const gl = this.gl, [from, to] = this.fleshShown();
    if (from >= to || !this.fleshArray) return;
    if (this.fleshFresh) {
      gl.bindBuffer(gl.ARRAY_BUFFER, this.fleshPointBuffer); gl.bufferSubData(gl.ARRAY_BUFFER, 0, this.flesh.points);
      gl.bindBuffer(gl.ARRAY_BUFFER, this.fleshNormalBuffer); gl.bufferSubData(gl.ARRAY_BUFFER, 0, this.fleshNormals);
      this.fleshFresh = false;
    }
    this.begin("flesh", project, turn, this.hot.flesh);
    gl.bindVertexArray(this.fleshArray);
    gl.cullFace(gl.BACK);
    if (!this.lean) { gl.drawElements(gl.TRIANGLES, to - from, gl.UNSIGNED_SHORT, 2 * from); return; }
    const { faces, split } = this.leanFlesh, begin = from ? split : 0, end = to > this.flesh.split ? faces.length : split;
    gl.drawElements(gl.TRIANGLES, end - begin, gl.UNSIGNED_SHORT, 2 * (this.flesh.faces.length + begin));
  }

  begin(name, project, turn, hot) {
    const gl = this.gl, { program: p, places } = this.programs[name];
    const use = (uniform) => places[uniform] ?? (places[uniform] = gl.getUniformLocation(p, uniform));
    gl.useProgram(p);
    gl.uniformMatrix4fv(use("project"), false, project);
    gl.uniformMatrix3fv(use("turn"), false, turn);
    gl.uniform1f(use("hot"), hot);
    return use;
  }

  drawSkin(project, turn, density, cull) {
    const gl = this.gl, use = this.begin("skin", project, turn, this.hot.part);
    gl.uniform2fv(use("density"), density);
    gl.cullFace(cull);
    if (this.lean && density === FAR_SIDE) {
      gl.bindVertexArray(this.farArray);
      gl.drawElements(gl.TRIANGLES, this.scene.arrays.skin_faces.length, gl.UNSIGNED_SHORT, 0);
      return;
    }
    gl.bindVertexArray(this.skinArray);
    this.drawPart(this.scene.arrays.fine_faces.length, this.leanSkin.length);
  }

  // Of a list of corners that has the lean triangles behind the whole ones: those that are due.
  drawPart(whole, lean) {
    const { gl } = this;
    gl.drawElements(gl.TRIANGLES, this.lean ? lean : whole, gl.UNSIGNED_SHORT, this.lean ? 2 * whole : 0);
  }

  // Without WebGL2: the even skin (or the bones' points moved) as flat triangles, far ones first. Plain, but never blank.
  drawFlat() {
    const g = this.paper, { width, height } = this.canvas, A = this.scene.arrays, m = this.projection();
    const sky = g.createLinearGradient(0, 0, 0, height);
    sky.addColorStop(0, "#e3e8ed"); sky.addColorStop(1, "#ffffff");
    g.fillStyle = sky;
    g.fillRect(0, 0, width, height);
    const bare = this.look.skin === "hidden";
    const P = bare ? this.movedBones() : this.coarse, F = bare ? A.bone_faces : A.skin_faces, tone = bare ? [239, 228, 203] : [228, 188, 167];
    const screen = new Float32Array(P.length);
    for (let v = 0; v < P.length; v += 3) {
      const w = m[3] * P[v] + m[7] * P[v + 1] + m[11] * P[v + 2] + m[15];
      screen[v] = (0.5 + 0.5 * (m[0] * P[v] + m[4] * P[v + 1] + m[8] * P[v + 2] + m[12]) / w) * width;
      screen[v + 1] = (0.5 - 0.5 * (m[1] * P[v] + m[5] * P[v + 1] + m[9] * P[v + 2] + m[13]) / w) * height;
      screen[v + 2] = w;
    }
    const seen = [];
    for (let f = 0; f < F.length; f += 3) {
      const [i, j, k] = [3 * F[f], 3 * F[f + 1], 3 * F[f + 2]];
      const turned = (screen[j] - screen[i]) * (screen[k + 1] - screen[i + 1]) - (screen[k] - screen[i]) * (screen[j + 1] - screen[i + 1]);
      if (turned < 0) seen.push([screen[i + 2] + screen[j + 2] + screen[k + 2], i, j, k]);
    }
    seen.sort((a, b) => b[0] - a[0]);
    for (const [, i, j, k] of seen) {
      const a = [0, 1, 2].map((x) => P[j + x] - P[i + x]), b = [0, 1, 2].map((x) => P[k + x] - P[i + x]), n = unit(cross(a, b));
      const light = 0.45 + 0.4 * Math.max(dot(n, this.eye), 0) + 0.2 * Math.max(dot(n, this.up) - 0.4 * dot(n, this.right), 0);
      g.fillStyle = g.strokeStyle = `rgb(${tone.map((c) => Math.round(c * light)).join()})`;
      g.beginPath(); g.moveTo(screen[i], screen[i + 1]); g.lineTo(screen[j], screen[j + 1]); g.lineTo(screen[k], screen[k + 1]); g.closePath();
      g.fill(); g.stroke();
    }
  }

  movedBones() {
    const A = this.scene.arrays, out = new Float32Array(A.bone_points.length), M = this.motion, P = A.bone_points;
    this.scene.bones.forEach((bone, k) => {
      for (let v = 3 * A.bone_starts[k]; v < 3 * A.bone_starts[k + 1]; v += 3) {
        for (let x = 0; x < 3; x++) {
          const o = 12 * bone.body + 4 * x;
          out[v + x] = M[o] * P[v] + M[o + 1] * P[v + 1] + M[o + 2] * P[v + 2] + M[o + 3];
        }
      }
    });
    return out;
  }

  // ---- picking: {kind: "bone" | "flesh" | "skin", index} at CSS pixels from the canvas's corner, or null

  pick(x, y) {
    this.lay();
    const { clientWidth: w, clientHeight: h } = this.canvas, A = this.scene.arrays;
    const reach = Math.tan(this.scene.lens_deg * Math.PI / 360), sx = (2 * x / w - 1) * reach * w / h, sy = (1 - 2 * y / h) * reach;
    const d = unit([0, 1, 2].map((k) => sx * this.right[k] + sy * this.up[k] - this.eye[k]));
    const o = this.focus.map((value, k) => value + this.distance * this.eye[k]);
    const hit = { face: -1 };
    const [from, to] = this.fleshShown();
    const touched = from < to ? rayTriangles(this.flesh.points, this.flesh.faces, from, to, o, d, Infinity, hit) : Infinity;
    const flesh = touched < Infinity ? { kind: "flesh", index: this.flesh.own[this.flesh.faces[hit.face]] } : null;
    if (this.look.bones && this.look.skin !== "solid") {
      let nearest = touched, found = -1;
      this.scene.bones.forEach((bone, k) => { // the ray in the bone's own frame
        const m = this.motion, b = 12 * bone.body;
        const back = (v, shift) => [0, 1, 2].map((c) => [0, 1, 2].reduce((sum, r) => sum + m[b + 4 * r + c] * (v[r] - (shift ? m[b + 4 * r + 3] : 0)), 0));
        const t = rayTriangles(A.bone_points, A.bone_faces, this.boneFaceStarts[k], this.boneFaceStarts[k + 1], back(o, true), back(d, false), nearest, hit);
        if (t < nearest) { nearest = t; found = k; }
      });
      if (found >= 0) return { kind: "bone", index: found };
    }
    if (flesh || this.look.skin === "hidden") return flesh;
    if (rayTriangles(this.coarse, A.skin_faces, 0, A.skin_faces.length, o, d, Infinity, hit) === Infinity) return null;
    const v = A.skin_faces[hit.face];
    const normal = [0, 1, 2].map((k) => this.coarseNormals[3 * v + k]);
    const body = A.skin_bodies[4 * v], m = this.motion, b = 12 * body;
    const palmar = [0, 1, 2].reduce((sum, r) => sum + m[b + 4 * r + 1] * normal[r], 0); // the normal's y in the stored posture
    return { kind: "skin", index: body, side: palmar > 0.35 ? "palmar" : palmar < -0.35 ? "dorsal" : "" };
  }

  // A PNG of what is seen, as a Blob.
  png() {
    this.lay();
    this.draw(true);
    return new Promise((done) => this.canvas.toBlob(done, "image/png"));
  }

  dispose() {
    this.gone = true;
    cancelAnimationFrame(this.pending);
    clearTimeout(this.rest);
    this.gl?.getExtension("WEBGL_lose_context")?.loseContext();
  }
}

function boneFaceStarts(scene) {
  const { bone_faces: F, bone_starts: S } = scene.arrays, starts = [];
  let k = 0;
  for (let f = 0; f < F.length; f += 3) while (k < scene.bones.length && F[f] >= S[k]) { starts.push(f); k += 1; }
  starts.push(F.length);
  return starts;
}

function program(gl, vertex, fragment) {
  const p = gl.createProgram();
  for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    gl.attachShader(p, shader);
  }
  gl.linkProgram(p);
  if (!gl.getProgramParameter(p, gl.LINK_STATUS) && !gl.isContextLost()) throw new Error(`shader: ${gl.getProgramInfoLog(p)} ${gl.getAttachedShaders(p).map((s) => gl.getShaderInfoLog(s)).join(" ")}`);
  return { program: p, places: {} };
}

function attribute(gl, place, width, data, usage, kind = gl.FLOAT) {
  const buffer = gl.createBuffer();
  gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
  gl.bufferData(gl.ARRAY_BUFFER, data, usage);
  gl.enableVertexAttribArray(place);
  gl.vertexAttribPointer(place, width, kind, kind !== gl.FLOAT, 0, 0);
  return buffer;
}

function indices(gl, data) {
  gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
  gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, data, gl.STATIC_DRAW);
}
