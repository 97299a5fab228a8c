// Curves over time on a canvas: at most eight lines, told apart by colour and dash, named at their ends.

const COLOURS = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000", "#7a7000"];
const DASHES = [[], [8, 4], [8, 3, 2, 3], [2, 3], [12, 3, 2, 3, 2, 3], [2, 6], [14, 5], [5, 2, 2, 2]];
const INK = "#1F2933", FAINT = "#5b6773", RULE = "#D5DBE1";
const MOST_LIVE = 1200; // moments kept while the hand is live
export const LIVE_SECONDS = 8;
export const MOST_LINES = 8;

// What happened: moments of the live hand (the last seconds), or the whole of a clip.
export class Track {
  constructor(width) { this.width = width; this.clear(); }
  clear() { this.time = []; this.rows = []; this.seconds = 0; this.whole = false; }
  add(time, row) {
    if (this.whole || (this.time.length && time < this.time[this.time.length - 1])) this.clear();
    if (this.time.length && time === this.time[this.time.length - 1]) { this.rows[this.rows.length - 1] = row; return; }
    this.time.push(time); this.rows.push(row);
    if (this.time.length > MOST_LIVE) { this.time.shift(); this.rows.shift(); }
  }
  // A clip's table: per row the time, then `width` values.
  load(table, seconds) {
    this.clear();
    this.whole = true;
    this.seconds = seconds;
    for (let at = 0; at + this.width < table.length; at += this.width + 1) {
      this.time.push(table[at]); this.rows.push(table.subarray(at + 1, at + 1 + this.width));
    }
  }
  span(now) { return this.whole ? [0, this.seconds] : [Math.max(now - LIVE_SECONDS, 0), Math.max(now, LIVE_SECONDS)]; }
  // The columns of `from`..`to` that change most.
  busiest(from, to, count, now) {
    const [start] = this.span(now), ranges = [];
    for (let column = from; column < to; column++) {
      let low = Infinity, high = -Infinity;
      for (let k = 0; k < this.rows.length; k++) {
        if (this.time[k] < start) continue;
        const value = this.rows[k][column];
        if (value < low) low = value;
        if (value > high) high = value;
      }
      ranges.push([high - low, column]);
    }
    return ranges.filter(([range]) => range > 1e-6).sort((a, b) => b[0] - a[0]).slice(0, count).map(([, column]) => column).sort((a, b) => a - b);
  }
}

// Draw `lines` ({column, label, factor}) of a track; where time runs: {left, right, top, bottom} in CSS pixels and {start, end} in seconds.
export function drawCurves(canvas, track, lines, { title, now, least }) {
  const scale = Math.min(window.devicePixelRatio || 1, 2), w = canvas.clientWidth, h = canvas.clientHeight;
  if (!w || !h) return null;
  if (canvas.width !== Math.round(w * scale) || canvas.height !== Math.round(h * scale)) { canvas.width = Math.round(w * scale); canvas.height = Math.round(h * scale); }
  const g = canvas.getContext("2d", { willReadFrequently: true }); // on the processor: cheap next to a software renderer
  g.setTransform(scale, 0, 0, scale, 0, 0);
  g.clearRect(0, 0, w, h);
  g.font = "13px system-ui, sans-serif";
  const names = Math.min(Math.max(70, ...lines.map((line) => g.measureText(line.label).width + 14)), w * 0.36);
  const box = { left: 44, right: w - names, top: 26, bottom: h - 22 };
  const [start, end] = track.span(now);
  let low = Infinity, high = -Infinity;
  for (let k = 0; k < track.rows.length; k++) {
    if (track.time[k] < start) continue;
    for (const { column, factor } of lines) {
      const value = track.rows[k][column] * factor;
      if (value < low) low = value;
      if (value > high) high = value;
    }
  }
  g.fillStyle = INK;
  g.textAlign = "left"; g.textBaseline = "alphabetic";
  g.font = "600 14px system-ui, sans-serif";
  g.fillText(title, 8, 16);
  g.font = "13px system-ui, sans-serif";
  if (!(high >= low)) { g.fillStyle = FAINT; g.fillText("move a muscle or play a clip", box.left, (box.top + box.bottom) / 2); return null; }
  const middle = (low + high) / 2, half = Math.max((high - low) / 2 * 1.08, least / 2);
  low = middle - half; high = middle + half;
  const X = (t) => box.left + (t - start) / (end - start || 1) * (box.right - box.left), Y = (v) => box.bottom - (v - low) / (high - low) * (box.bottom - box.top);
  g.strokeStyle = RULE; g.lineWidth = 1; g.fillStyle = FAINT; g.setLineDash([]);
  const rise = tick((high - low) / 4);
  g.textAlign = "right"; g.textBaseline = "middle";
  for (let v = Math.ceil(low / rise) * rise; v <= high; v += rise) { rule(g, box.left, Y(v), box.right, Y(v)); g.fillText(String(Number(v.toFixed(3))), box.left - 6, Y(v)); }
  g.textAlign = "center"; g.textBaseline = "top";
  const stride = tick((end - start) / 6);
  for (let t = Math.ceil(start / stride) * stride; t <= end + 1e-9; t += stride) g.fillText(`${Number(t.toFixed(2))}${t + stride > end ? " s" : ""}`, X(t), box.bottom + 5);
  g.save();
  g.beginPath(); g.rect(box.left, box.top - 2, box.right - box.left, box.bottom - box.top + 4); g.clip();
  g.lineWidth = 2; g.lineJoin = "round";
  lines.forEach(({ column, factor }, n) => {
    g.strokeStyle = COLOURS[n % COLOURS.length]; g.setLineDash(DASHES[n % DASHES.length]);
    g.beginPath();
    let begun = false;
    for (let k = 0; k < track.rows.length; k++) {
      if (k + 1 < track.time.length && track.time[k + 1] < start) continue;
      const x = X(track.time[k]), y = Y(track.rows[k][column] * factor);
      if (begun) g.lineTo(x, y); else g.moveTo(x, y);
      begun = true;
    }
    g.stroke();
  });
  g.setLineDash([]);
  g.restore();
  // Names at the line's ends, pushed apart.
  const last = track.rows[track.rows.length - 1];
  const ends = lines.map(({ column, factor, label }, n) => ({ n, label, y: Math.min(Math.max(Y(last[column] * factor), box.top + 6), box.bottom - 4) })).sort((a, b) => a.y - b.y);
  for (let k = 1; k < ends.length; k++) ends[k].y = Math.max(ends[k].y, ends[k - 1].y + 15);
  for (let k = ends.length - 1, limit = box.bottom + 6; k >= 0; k--) { ends[k].y = Math.min(ends[k].y, limit); limit = ends[k].y - 15; }
  g.textAlign = "left"; g.textBaseline = "middle"; g.font = "600 13px system-ui, sans-serif";
  for (const { n, label, y } of ends) { g.fillStyle = COLOURS[n % COLOURS.length]; g.fillText(label, box.right + 8, y, names - 10); }
  return { ...box, start, end };
}

function rule(g, x0, y0, x1, y1) { g.beginPath(); g.moveTo(x0, y0); g.lineTo(x1, y1); g.stroke(); }

// 1, 2 or 5 times a power of ten, at least `least`.
function tick(least) {
  const power = 10 ** Math.floor(Math.log10(least || 1));
  return [1, 2, 5, 10].map((k) => k * power).find((value) => value >= least * 0.999);
}
