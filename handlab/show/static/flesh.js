// Muscles and tendons: surfaces from the segments of a frame and from the motions of the bones, with what `flesh.py` packed once.

// Unit quaternion (w x y z in 1 / 32767) as the columns of a rotation: along the fibre, across, outwards.
function columns(S, at, out) {
  const s = 1 / 32767, w = S[at] * s, x = S[at + 1] * s, y = S[at + 2] * s, z = S[at + 3] * s;
  out[0] = 1 - 2 * (y * y + z * z); out[1] = 2 * (x * y + w * z); out[2] = 2 * (x * z - w * y);
  out[3] = 2 * (x * y - w * z); out[4] = 1 - 2 * (x * x + z * z); out[5] = 2 * (y * z + w * x);
  out[6] = 2 * (x * z + w * y); out[7] = 2 * (y * z - w * x); out[8] = 1 - 2 * (x * x + y * y);
}

const BESIDE = 0.002; // m: a tendon's line is seldom lifted further out of bone

export class Flesh {
  // `layers`: unpacked like a scene; `unit`: metres of one step of a segment's place.
  constructor(layers, unit) {
    this.layers = layers;
    this.unit = unit;
    this.faces = layers.arrays.faces;
    this.tone = layers.arrays.tone;
    const all = this.all = [...layers.muscles, ...layers.tendons];
    const count = all[all.length - 1].end;
    this.points = new Float32Array(3 * count);
    this.own = new Float32Array(count); // which muscle or tendon a point belongs to
    all.forEach((one, k) => this.own.fill(k, one.first, one.end));
    this.segments = layers.muscles.reduce((sum, m) => sum + m.segments * m.fibres, 0);
    this.split = layers.tendons.length ? layers.tendons[0].corner : this.faces.length;
    let along = 0, across = 0;
    this.places = layers.muscles.map((m) => {
      const at = { along, across };
      along += m.stations * (m.segments + 2);
      across += 3 * m.ring * m.fibres;
      return at;
    });
  }

  // Muscles from a frame's segments: ten numbers each (place, quaternion, half-axes).
  layMuscles(segments) {
    this.layers.muscles.forEach((m, k) => this.layMuscle(m, this.places[k], segments));
  }

  layMuscle(m, place, S) {
    const { along, across } = this.layers.arrays, { overlap, tip, half_unit: fine } = this.layers, { unit, points } = this;
    const n = m.segments + 2, f = m.fibres, turn = new Float64Array(9);
    const control = new Float64Array(9 * n * f); // of every fibre and control: centre, half-axis across, half-axis outwards
    for (let fibre = 0; fibre < f; fibre++) {
      for (let j = 0; j < m.segments; j++) {
        const s = 10 * (m.segment + fibre * m.segments + j), o = 9 * (fibre * n + j + 1);
        columns(S, s + 3, turn);
        const a = S[s + 7] * fine / overlap, b = S[s + 8] * fine, c = S[s + 9] * fine;
        for (let x = 0; x < 3; x++) { control[o + x] = S[s + x] * unit; control[o + 3 + x] = turn[3 + x] * b; control[o + 6 + x] = turn[6 + x] * c; }
        const end = j === 0 ? -1 : j === m.segments - 1 ? 1 : 0; // a tip stands half a segment further out, thinner
        for (const e of m.segments === 1 ? [-1, 1] : end ? [end] : []) {
          const t = o + 9 * e;
          for (let x = 0; x < 3; x++) { control[t + x] = control[o + x] + e * turn[x] * a; control[t + 3 + x] = tip * control[o + 3 + x]; control[t + 6 + x] = tip * control[o + 6 + x]; }
        }
      }
    }
    const row = new Float64Array(9 * f);
    let out = 3 * m.first;
    for (let s = 0; s < m.stations; s++) {
      row.fill(0);
      for (let j = 0; j < n; j++) {
        const w = along[place.along + s * n + j];
        if (w === 0) continue;
        for (let fibre = 0; fibre < f; fibre++) for (let x = 0; x < 9; x++) row[9 * fibre + x] += w * control[9 * (fibre * n + j) + x];
      }
      for (let k = 0; k < m.ring; k++) {
        let x = 0, y = 0, z = 0;
        for (let fibre = 0; fibre < f; fibre++) {
          const at = place.across + 3 * f * k + fibre, middle = across[at], side = across[at + f], rise = across[at + 2 * f], r = 9 * fibre;
          x += middle * row[r] + side * row[r + 3] + rise * row[r + 6];
          y += middle * row[r + 1] + side * row[r + 4] + rise * row[r + 7];
          z += middle * row[r + 2] + side * row[r + 5] + rise * row[r + 8];
        }
        points[out++] = x; points[out++] = y; points[out++] = z;
      }
    }
    for (const j of [0, n - 1]) for (let x = 0; x < 3; x++) {
      let sum = 0;
      for (let fibre = 0; fibre < f; fibre++) sum += control[9 * (fibre * n + j) + x];
      points[out++] = sum / f;
    }
  }

  // Tendons where the bones take them, as `tendons.py` lays them.
  // Tendons of the back of the hand are straight where their muscles pull (`tendon_ridges.py`): `bow` says how far they left the bone.
  layTendons(motion, bow = () => 0) {
    for (const tendon of this.layers.tendons) this.layTendon(tendon, motion, tendon.taut ? bow(tendon.taut) : 0);
  }

  layTendon(t, M, bow) {
    const A = this.layers.arrays, via = new Float64Array(3 * t.vias), line = new Float64Array(3 * t.rows), lift = new Float64Array(3);
    const moved = (body, P, p, shift, out, o) => {
      for (let x = 0; x < 3; x++) {
        const m = 12 * body + 4 * x;
        out[o + x] = M[m] * P[p] + M[m + 1] * P[p + 1] + M[m + 2] * P[p + 2] + (shift ? M[m + 3] : 0);
      }
    };
    for (let v = 0; v < t.vias; v++) moved(A.via_body[t.via + v], A.via_point, 3 * (t.via + v), true, via, 3 * v);
    for (let r = 0; r < t.rows; r++) {
      for (let v = 0; v < t.vias; v++) {
        const w = A.spread[t.weight + r * t.vias + v];
        if (w) for (let x = 0; x < 3; x++) line[3 * r + x] += w * via[3 * v + x];
      }
      moved(A.nudge_body[t.row + r], A.nudge, 3 * (t.row + r), false, lift, 0); // off the bones between via points
      for (let x = 0; x < 3; x++) line[3 * r + x] += lift[x];
      if (!bow) continue;
      moved(A.nudge_body[t.row + r], A.taut_way, 3 * (t.row + r), false, lift, 0);
      for (let x = 0; x < 3; x++) line[3 * r + x] += bow * lift[x];
    }
    const centre = new Float64Array(3 * t.joints), axis = new Float64Array(3 * t.joints);
    for (let j = 0; j < t.joints; j++) {
      moved(A.over_body[t.over + j], A.over_centre, 3 * (t.over + j), true, centre, 3 * j);
      moved(A.over_body[t.over + j], A.over_axis, 3 * (t.over + j), false, axis, 3 * j);
    }
    const layOver = () => {
      for (let j = 0; j < t.joints; j++) {
        const reach = A.over_reach[t.over + j], c = 3 * j;
        for (let r = 0; r < line.length; r += 3) {
          let x = line[r] - centre[c], y = line[r + 1] - centre[c + 1], z = line[r + 2] - centre[c + 2];
          const d = x * axis[c] + y * axis[c + 1] + z * axis[c + 2];
          x -= d * axis[c]; y -= d * axis[c + 1]; z -= d * axis[c + 2];
          const far = Math.sqrt(x * x + y * y + z * z);
          if (far >= reach || Math.abs(d) >= reach || far <= 1e-4) continue;
          const g = reach / far - 1;
          line[r] += g * x; line[r + 1] += g * y; line[r + 2] += g * z;
        }
      }
    };
    for (let pass = 0; pass < this.layers.even; pass++) {
      layOver();
      const old = line.slice();
      for (let r = 3; r < line.length - 3; r++) line[r] = 0.5 * old[r] + 0.25 * old[r - 3] + 0.25 * old[r + 3];
    }
    layOver();
    this.liftTendon(t, M, via, line);
    this.tube(t, line);
  }

  // Out of the bone, as `tendon_kernel.lifted` does it.
  liftTendon(t, M, via, line) {
    const A = this.layers.arrays, C = A.ball_centre, half = this.layers.half_unit, unit = this.unit, count = t.rows - 2;
    let near = 0; // balls that the line may touch: what it is lifted by is less than BESIDE
    if (!this.balls || this.balls.length < 6 * t.balls) this.balls = new Float64Array(6 * t.balls);
    const B = this.balls;
    for (let b = 0; b < t.balls; b++) {
      const m = 12 * A.ball_body[t.ball + b], c = 3 * (t.ball + b), p = C[c], q = C[c + 1], w = C[c + 2];
      const x = unit * (M[m] * p + M[m + 1] * q + M[m + 2] * w) + M[m + 3];
      const y = unit * (M[m + 4] * p + M[m + 5] * q + M[m + 6] * w) + M[m + 7];
      const z = unit * (M[m + 8] * p + M[m + 9] * q + M[m + 10] * w) + M[m + 11];
      const reach = A.ball_radius[t.ball + b] * half + t.radius, far = (reach + BESIDE) * (reach + BESIDE);
      const first = 3 * Math.max(A.ball_first[t.ball + b], 1), last = 3 * Math.min(A.ball_last[t.ball + b], count);
      for (let r = first; r <= last; r += 3) {
        const u = line[r] - x, v = line[r + 1] - y, h = line[r + 2] - z;
        if (u * u + v * v + h * h >= far) continue;
        B[near] = x; B[near + 1] = y; B[near + 2] = z; B[near + 3] = reach * reach; B[near + 4] = first; B[near + 5] = last;
        near += 6;
        break;
      }
    }
    if (!near) return;
    const up = new Float64Array(line.length), way = new Float64Array(3);
    for (let v = 0; v < t.vias; v++) {
      const m = 12 * A.via_body[t.via + v], u = 3 * (t.via + v);
      for (let x = 0; x < 3; x++) way[x] = M[m + 4 * x] * A.via_up[u] + M[m + 4 * x + 1] * A.via_up[u + 1] + M[m + 4 * x + 2] * A.via_up[u + 2];
      for (let r = 0; r < t.rows; r++) {
        const g = A.spread[t.weight + r * t.vias + v];
        if (g) for (let x = 0; x < 3; x++) up[3 * r + x] += g * way[x];
      }
    }
    for (let r = 0; r < up.length; r += 3) {
      const s = 1 / Math.sqrt(up[r] * up[r] + up[r + 1] * up[r + 1] + up[r + 2] * up[r + 2]);
      up[r] *= s; up[r + 1] *= s; up[r + 2] *= s;
    }
    const before = line.slice(), moved = new Float64Array(line.length);
    const { lifts } = this.layers;
    for (let turn = 0; turn < lifts; turn++) {
      for (let b = 0; b < near; b += 6) {
        const bx = B[b], by = B[b + 1], bz = B[b + 2], own = B[b + 3], end = B[b + 5];
        for (let r = B[b + 4]; r <= end; r += 3) {
          const x = line[r] - bx, y = line[r + 1] - by, z = line[r + 2] - bz, square = x * x + y * y + z * z;
          if (square >= own) continue;
          let s = 1 / Math.max(Math.sqrt(square), 1e-6);
          const share = 1 + s * (x * up[r] + y * up[r + 1] + z * up[r + 2]);
          const p = s * x + share * up[r], q = s * y + share * up[r + 1], w = s * z + share * up[r + 2];
          s = 1 / Math.sqrt(p * p + q * q + w * w);
          const along = s * (p * x + q * y + w * z), far = s * (Math.sqrt(along * along + own - square) - along);
          line[r] += far * p; line[r + 1] += far * q; line[r + 2] += far * w;
        }
      }
      if (turn === lifts - 1) break;
      for (let r = 0; r < line.length; r++) moved[r] = line[r] - before[r];
      for (let r = 3; r < line.length - 3; r++) line[r] = before[r] + 0.5 * moved[r] + 0.25 * (moved[r - 3] + moved[r + 3]);
    }
  }

  tube(t, line) {
    const { points } = this, round = this.layers.round, stride = this.layers.stride, last = t.rows - 1;
    const at = (k) => 3 * Math.min(k * stride, last);
    let out = 3 * t.first, sx = 0, sy = 0, sz = 0;
    for (let k = 0; k < t.stations; k++) {
      const i = at(k), a = at(Math.max(k - 1, 0)), b = at(k + 1 < t.stations ? k + 1 : k);
      let x = line[b] - line[a], y = line[b + 1] - line[a + 1], z = line[b + 2] - line[a + 2];
      let s = 1 / (Math.hypot(x, y, z) || 1);
      x *= s; y *= s; z *= s;
      if (k === 0) { sx = y + 1e-6; sy = -x + 1e-6; sz = 1e-6; }
      const d = sx * x + sy * y + sz * z; // carried along without twist
      sx -= d * x; sy -= d * y; sz -= d * z;
      s = 1 / (Math.hypot(sx, sy, sz) || 1);
      sx *= s; sy *= s; sz *= s;
      const ux = y * sz - z * sy, uy = z * sx - x * sz, uz = x * sy - y * sx;
      for (let c = 0; c < round; c++) {
        const p = t.radius * Math.cos(2 * Math.PI * c / round), q = t.radius * Math.sin(2 * Math.PI * c / round);
        points[out++] = line[i] + p * sx + q * ux; points[out++] = line[i + 1] + p * sy + q * uy; points[out++] = line[i + 2] + p * sz + q * uz;
      }
    }
    for (const i of [0, 3 * last]) for (let x = 0; x < 3; x++) points[out++] = line[i + x];
  }
}
