// What a software renderer draws while the hand moves: the same points with fewer triangles, because its time goes with their number.

const BONE_CELL = 0.003; // metres: bones seen through skin that moves, on pixels of half a millimetre
const SKIN_CELL = 0.0024;
const CORNERS = [0, 0, 2, 3, 3, 5]; // a tendon's six corners become four
const STRETCHES = [[0.3, 3], [0.5, 2], [1, 1]]; // up to which part of a tendon every how manieth ring stays: it bends in the fingers

// Triangles once every point v has become the point `to[v]`; those that vanish are left out.
export function merged(faces, to) {
  const out = [];
  for (let f = 0; f < faces.length; f += 3) {
    const a = to[faces[f]], b = to[faces[f + 1]], c = to[faces[f + 2]];
    if (a !== b && b !== c && c !== a) out.push(a, b, c);
  }
  return new Uint16Array(out);
}

// For every point the one that stands for all in its cell of a grid: the nearest to their middle. `own` keeps things apart.
function standing(points, own, cell) {
  const cells = new Map(), count = points.length / 3, at = new Uint32Array(count);
  for (let v = 0; v < count; v++) {
    const key = [0, 1, 2].map((x) => Math.floor(points[3 * v + x] / cell)).join() + `,${own(v)}`;
    const one = cells.get(key) || { number: cells.size, members: [] };
    cells.set(key, one);
    one.members.push(v);
    at[v] = one.number;
  }
  const chosen = [...cells.values()].map(({ members }) => {
    const mean = [0, 1, 2].map((x) => members.reduce((sum, v) => sum + points[3 * v + x], 0) / members.length);
    const far = (v) => [0, 1, 2].reduce((sum, x) => sum + (points[3 * v + x] - mean[x]) ** 2, 0);
    return members.reduce((best, v) => (far(v) < far(best) ? v : best));
  });
  return at.map((k) => chosen[k]);
}

export const leanBones = (points, faces, own) => merged(faces, standing(points, own, BONE_CELL));
export const leanSkin = (points, faces) => merged(faces, standing(points, () => 0, SKIN_CELL));

// Every second ring of a muscle, four corners and some rings of a tendon: triangles, and where those of the tendons begin.
export function leanFlesh(layers) {
  const { faces } = layers.arrays, { muscles, tendons } = layers, all = [...muscles, ...tendons];
  const to = new Uint16Array(all[all.length - 1].end).map((_, v) => v);
  for (const m of muscles) {
    for (let s = 1; s < m.stations - 1; s += 2) for (let k = 0; k < m.ring; k++) to[m.first + s * m.ring + k] -= m.ring;
  }
  for (const t of tendons) {
    let kept = 0;
    for (let s = 0; s < t.stations; s++) {
      const every = STRETCHES.find(([part]) => s <= part * t.stations)[1];
      if (s - kept >= every || s === t.stations - 1) kept = s;
      for (let k = 0; k < layers.round; k++) to[t.first + s * layers.round + k] = t.first + kept * layers.round + CORNERS[k];
    }
  }
  const split = tendons.length ? tendons[0].corner : faces.length;
  const bellies = merged(faces.subarray(0, split), to), sinews = merged(faces.subarray(split), to);
  return { faces: joined(bellies, sinews), split: bellies.length };
}

export function joined(a, b) {
  const both = new Uint16Array(a.length + b.length);
  both.set(a);
  both.set(b, a.length);
  return both;
}

// A tone for every even point: the mean of the fine points for which it stands.
export function evenTones(tone, count, cornerOf) {
  const sum = new Float64Array(4 * count), out = new Uint8Array(3 * count).fill(200);
  for (let v = 0; 3 * v < tone.length; v++) {
    const k = 4 * cornerOf(v);
    for (let x = 0; x < 3; x++) sum[k + x] += tone[3 * v + x];
    sum[k + 3] += 1;
  }
  for (let n = 0; n < count; n++) if (sum[4 * n + 3]) for (let x = 0; x < 3; x++) out[3 * n + x] = sum[4 * n + x] / sum[4 * n + 3];
  return out;
}
