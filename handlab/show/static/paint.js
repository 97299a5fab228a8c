// The picture of the paint panel: clicks are numbered, shown at once and sent at once; the kernel answers with a picture.
// While a picture is on its way, turning and zooming are added up, so that a slow kernel slows the motion and nothing piles up.

const NEAR = 11; // pixels within which a point is taken hold of
const STILL = 4; // pixels that a click may wander
const BLUE = "#0072B2", WHITE = "#FFFFFF";
const SVG = "http://www.w3.org/2000/svg";

function render({ model, el }) {
  const page = Math.random().toString(36).slice(2);
  const box = document.createElement("div");
  box.className = "hl-paint";
  box.tabIndex = 0;
  box.setAttribute("role", "application");
  box.setAttribute("aria-label", "Hand to paint a muscle on. Click to add a point; drag a point to move it; drag elsewhere or use arrow "
    + "keys to turn the hand; wheel or plus and minus to zoom; Backspace to undo.");
  box.style.cssText = `position:relative;width:${model.get("width")}px;max-width:100%;aspect-ratio:${model.get("width")}/`
    + `${model.get("height")};touch-action:none;user-select:none;cursor:crosshair;border-radius:6px;overflow:hidden;flex:none`;
  const img = document.createElement("img");
  img.alt = "The hand with the painted grid";
  img.draggable = false;
  img.style.cssText = "width:100%;height:100%;display:block;margin:0;max-width:none;pointer-events:none";
  const svg = document.createElementNS(SVG, "svg");
  svg.style.cssText = "position:absolute;inset:0;width:100%;height:100%;pointer-events:none";
  box.append(img, svg);
  el.append(box);

  let shown = 0, marks = [], columns = 3, sent = 0, pending = [], drag = null, waiting = false, later = null, old = null;

  const size = () => box.getBoundingClientRect();
  const at = (event) => { const r = size(); return { x: (event.clientX - r.left) / r.width, y: (event.clientY - r.top) / r.height }; };
  const circle = (x, y, front, label, colour, left) => {
    const r = size(), dot = document.createElementNS(SVG, "circle");
    const set = (node, what) => { for (const [k, v] of Object.entries(what)) node.setAttribute(k, v); };
    set(dot, { cx: x * r.width, cy: y * r.height, r: front ? 5 : 3.5, fill: front && colour ? colour : "none", stroke: BLUE, "stroke-width": 2 });
    if (!front) dot.setAttribute("stroke-dasharray", "2 2");
    svg.append(dot);
    if (!label) return;
    const text = document.createElementNS(SVG, "text");
    set(text, { x: x * r.width + (left ? -10 : 10), y: y * r.height + 4, "text-anchor": left ? "end" : "start", fill: BLUE, stroke: WHITE, "stroke-width": 3, "paint-order": "stroke",
      "font-size": 12, "font-weight": 600, "font-family": "system-ui, sans-serif" });
    text.textContent = label;
    svg.append(text);
  };
  const draw = () => {
    svg.replaceChildren();
    marks.forEach(([x, y, front], k) => {
      const held = drag && drag.mark === k && drag.moved;
      const row = Math.floor(k / columns) + 1; // the first point of every row carries its number, away from the second
      const left = k % columns === 0 && marks.length > k + 1 && marks[k + 1][0] > x;
      circle(held ? drag.x : x, held ? drag.y : y, front, k % columns === 0 && front ? `row ${row}` : "", WHITE, left);
    });
    pending.forEach(({ x, y }) => circle(x, y, true, "", "")); // on their way: hollow
  };

  const tell = (message) => model.send({ page, n: ++sent, picture: shown, ...message });
  const click = (place) => { pending.push({ ...place, n: sent + 1 }); tell({ kind: "click", ...place }); draw(); };
  const swing = (change) => { // turning and zooming wait for the picture before
    if (waiting) { later = later ? joined(later, change) : change; return; }
    waiting = true;
    tell(change);
  };
  const joined = (a, b) => (a.kind !== b.kind ? b
    : a.kind === "turn" ? { ...b, dx: a.dx + b.dx, dy: a.dy + b.dy } : { ...b, by: a.by * b.by });

  box.addEventListener("pointerdown", (event) => {
    if (event.button !== 0) return;
    box.focus({ preventScroll: true });
    box.setPointerCapture(event.pointerId);
    const { x, y } = at(event), r = size();
    let mark = -1, best = NEAR;
    marks.forEach((m, k) => {
      const far = Math.hypot((m[0] - x) * r.width, (m[1] - y) * r.height);
      if (m[2] && far <= best) { best = far; mark = k; }
    });
    drag = { x, y, x0: x, y0: y, mark, moved: false };
  });
  box.addEventListener("pointermove", (event) => {
    if (!drag) return;
    const { x, y } = at(event), r = size();
    if (!drag.moved && Math.hypot((x - drag.x0) * r.width, (y - drag.y0) * r.height) < STILL) return;
    if (drag.mark < 0) swing({ kind: "turn", dx: x - drag.x, dy: y - drag.y });
    Object.assign(drag, { x, y, moved: true });
    if (drag.mark >= 0) draw();
  });
  box.addEventListener("pointerup", () => {
    const done = drag;
    drag = null;
    if (!done) return;
    if (!done.moved && done.mark < 0) click({ x: done.x0, y: done.y0 });
    else if (done.moved && done.mark >= 0) {
      marks[done.mark] = [done.x, done.y, true];
      tell({ kind: "move", mark: done.mark, x: done.x, y: done.y });
    }
    draw();
  });
  box.addEventListener("pointercancel", () => { drag = null; draw(); });
  box.addEventListener("wheel", (event) => {
    event.preventDefault();
    swing({ kind: "zoom", by: Math.exp(-0.0015 * event.deltaY), ...at(event) });
  }, { passive: false });
  box.addEventListener("keydown", (event) => {
    const turns = { ArrowLeft: [-0.03, 0], ArrowRight: [0.03, 0], ArrowUp: [0, -0.03], ArrowDown: [0, 0.03] }[event.key];
    if (turns) swing({ kind: "turn", dx: turns[0], dy: turns[1] });
    else if (event.key === "+" || event.key === "-") swing({ kind: "zoom", by: event.key === "+" ? 1.15 : 1 / 1.15, x: 0.5, y: 0.5 });
    else if (event.key === "Backspace" || (event.key === "z" && (event.ctrlKey || event.metaKey))) tell({ kind: "undo" });
    else return;
    event.preventDefault();
    event.stopPropagation(); // a notebook has its own meaning for these keys
  });

  const hear = (message, buffers) => {
    if (message.kind !== "picture") return;
    const buffer = buffers[0];
    const url = URL.createObjectURL(new Blob([buffer], { type: "image/jpeg" }));
    img.src = url;
    if (old) URL.revokeObjectURL(old);
    old = url;
    shown = message.picture;
    marks = message.marks;
    columns = message.columns;
    const answered = message.answered[page] || 0;
    pending = pending.filter((one) => one.n > answered);
    waiting = false;
    draw();
    if (later) { const next = later; later = null; swing(next); }
  };
  model.on("msg:custom", hear);
  const resized = new ResizeObserver(draw);
  resized.observe(box);
  model.send({ kind: "hello" });
  return () => { model.off("msg:custom", hear); resized.disconnect(); if (old) URL.revokeObjectURL(old); };
}

export default { render };
