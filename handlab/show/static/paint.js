// Painting a muscle: the page of the app and the panel of a notebook.
//
//   const api = await paint(element, transport)
//
// transport: { ask(message) -> Promise of a reply (messages and replies: paint_room.py), store: where points and settings outlive a
//   reload (none: the host keeps them), close(): leaves the page, used(short): the muscle is on the live hand (none: it is shown elsewhere) }
// Points are metres on the skin of the stored posture. The page holds them, sends all of them after every change, and never waits.

import { Hand3D, rayTriangles, unpackScene } from "./hand3d.js";
import { draw } from "./drawing.js";
import { make } from "./nodes.js";
import { STYLE } from "./style.js";

const NEAR = 9, NEAR_TOUCH = 22, STILL = 4; // px: within which a point is taken hold of; that a click may wander
const HIDDEN = 0.002; // metres: what lies deeper behind the skin in front of it is on the far side
const REST_MS = 120; // a hand at rest: what other fingers hide is left out
const MEANT = {
  "driven by": "the muscle of the model that moves it: its slider makes this one swell", "points in a row": "how many you click across the fibres", "divide rows by": "finer rows are laid between yours, on a smooth curve",
  "thickness, mm": "never thinner, never thicker", "skin distance, mm": "how deep below the skin it lies: one number, or one for each row, such as 6, 3, 2", "contract it": "the hand keeps its posture: the belly takes what the ends give",
};
const SKINS = ["translucent", "solid", "mesh"];

const push = (text, onclick, more = {}) => make("button", { type: "button", textContent: text, onclick, className: "hl-btn", ...more });
const opened = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
const spaced = (name) => name.replaceAll("_", " ");
const plural = (count, word) => `${count} ${word}${count === 1 ? "" : "s"}`;

export async function paint(element, transport) {
  for (const [id, text] of [["handlab-style", STYLE], ["handlab-paint-style", PAINT_STYLE]]) if (!document.getElementById(id)) document.head.append(make("style", { id, textContent: text }));
  const page = new PaintPage(element, transport);
  await page.begin();
  element.paint = page;
  return page;
}

class PaintPage {
  constructor(element, transport) {
    Object.assign(this, { element, transport, points: [], settings: null, history: [], told: null, fit: -1, contraction: 0, troubles: {}, back: false });
    this.fingers = new Map();
    this.stats = { latency_ms: [], server_ms: [] };
  }

  async begin() {
    this.root = make("div", { className: "hl hp", tabIndex: -1, data: { lmSuppressShortcuts: "true" } }, make("div", { className: "hl-wait", textContent: "the hand is coming ..." }));
    this.element.replaceChildren(this.root);
    const hello = await this.transport.ask({ kind: "hello" });
    if (!hello.good) { this.root.replaceChildren(make("div", { className: "hl-wait hp-none" }, make("p", { textContent: hello.text }), this.leave())); return; }
    const { scene, ...told } = hello;
    this.scene = unpackScene(opened(scene));
    this.about = told;
    this.build();
    this.take(told);
    const kept = await this.transport.store?.read();
    if (kept?.of === this.mark() && !this.points.length) {
      Object.assign(this, { points: kept.points, settings: { ...this.settings, ...kept.settings } });
      this.update();
    }
    this.heed(told);
  }

  dispose() { this.gone = true; clearTimeout(this.rest); this.sizes?.disconnect(); this.hand?.dispose(); this.element.replaceChildren(); }

  // ---- what is where

  build() {
    const { scene } = this;
    this.canvas = make("canvas");
    this.svg = draw("svg", { "aria-hidden": "true" });
    const views = make("div", { className: "hl-seg" }, ...["palm", "back", "radial", "ulnar"].map((name) => push(name, () => { this.hand.view(name); this.looks(); }, { className: "", data: { view: name } })));
    const skins = make("div", { className: "hl-seg" }, ...SKINS.map((name) => push(name, () => { this.skin = name; this.looks(); }, { className: "", data: { skin: name }, title: `${name} skin` })));
    this.bar = make("div", { className: "hl-bar top" }, views, make("span", { className: "gap" }), skins);
    const near = make("div", { className: "hl-seg hp-zoom" }, push("+", () => this.zoom(0.75), { className: "", aria: { label: "nearer" } }), push("−", () => this.zoom(1 / 0.75), { className: "", aria: { label: "farther" } }));
    this.stage = make("div", { className: "hl-stage hp-stage", tabIndex: 0, aria: { role: "application", label: "The hand to paint on. Click to add a point; drag a point to move it; drag elsewhere or use arrow keys to turn the hand; wheel, plus and minus to zoom; Backspace to undo." } }, this.canvas, this.svg, this.bar, near);
    this.guide = make("p", { className: "hp-guide", aria: { role: "status", live: "polite" } });
    this.root.replaceChildren(make("header", {}, make("h1", { textContent: "Paint a muscle" }), this.guide, this.leave()), this.stage, this.panel());
    this.hand = new Hand3D(this.canvas, scene, { skin: "translucent", bones: true, view: this.about.view, muscles: false, tendons: false });
    this.hand.ondraw = () => this.overlay();
    this.listen();
    this.looks();
  }

  leave() { return this.transport.close ? push("back to the live hand", () => this.transport.close(), { data: { act: "close" } }) : null; }

  panel() {
    const { about } = this, field = (text, ...inputs) => make("label", { className: "hp-field", title: MEANT[text] ?? "" }, make("span", { textContent: text }), ...inputs);
    const change = (name, value) => this.change(() => { this.settings = { ...this.settings, [name]: value() }; });
    const number = (label, more) => make("input", { type: "number", step: 0.5, inputMode: "decimal", aria: { label }, ...more });
    const pick = (label, entries, more = {}) => make("select", { aria: { label }, ...more }, ...entries.map(([value, text]) => make("option", { value, textContent: text })));
    const counts = (from, to) => Array.from({ length: to - from + 1 }, (_, k) => [from + k, String(from + k)]);
    const value = (node) => (node.value.trim() === "" ? null : Number(node.value.replace(",", ".")));
    const F = this.fields = {
      name: make("input", { type: "text", spellcheck: false, onchange: () => change("name", () => F.name.value.trim().replaceAll(" ", "_")) }),
      drive: pick("driven by", about.drives.map(([name, short]) => [name, `${short}  ${spaced(name)}`]), { onchange: () => change("drive", () => F.drive.value) }),
      columns: pick("points in a row", counts(2, about.most_columns), { onchange: () => change("columns", () => Number(F.columns.value)) }),
      finer: pick("divide rows by", counts(1, about.most_finer), { onchange: () => change("finer", () => Number(F.finer.value)) }),
      least: number("least thickness in millimetres"), most: number("greatest thickness in millimetres"),
      skin_distance_mm: make("input", { type: "text", inputMode: "decimal", aria: { label: "skin distance in millimetres" }, onchange: () => change("skin_distance_mm", () => { const all = F.skin_distance_mm.value.split(/[,;\s]+/).filter(Boolean).map(Number); return all.length === 1 ? all[0] : all; }) }),
      contraction: make("input", { type: "range", min: 0, max: 100, value: 0, oninput: () => { this.contraction = F.contraction.value / 100; this.update(); } }),
    };
    for (const one of ["least", "most"]) F[one].onchange = () => change("thickness_mm", () => [value(F.least), value(F.most)]);
    this.ends = ["first", "last"].map((word) => { const box = make("input", { type: "checkbox", onchange: () => change("on_bone", () => this.ends.map((one) => one.checked)) }); box.dataset.end = word; return box; });
    this.bones = make("div", { className: "hp-bones" });
    this.facts = make("div", { className: "hp-facts" });
    this.message = make("div", { className: "hp-say", hidden: true, aria: { role: "alert" } });
    this.folder = about.folder ? make("input", { type: "text", value: about.folder, aria: { label: "folder to save in" } }) : null;
    this.percent = make("output", { textContent: "0 %" });
    return make("aside", { className: "hp-side" }, this.message,
      field("name", F.name), field("driven by", F.drive),
      make("div", { className: "hp-pair" }, field("points in a row", F.columns), field("divide rows by", F.finer)),
      field("thickness, mm", F.least, make("i", { textContent: "to" }), F.most), field("skin distance, mm", F.skin_distance_mm),
      make("div", { className: "hp-ends" }, ...this.ends.map((box) => make("label", { title: "this end is fixed to bone and tapers towards it" }, box, `${box.dataset.end} row on bone`))),
      this.bones, this.facts, make("span", { className: "gap" }),
      field("contract it", F.contraction, this.percent), this.folder && field("save in the folder", this.folder),
      make("div", { className: "hp-tools" }, push("undo", () => this.undo(), { data: { act: "undo" } }), push("clear", () => this.clear(), { data: { act: "clear" } }), make("span", { className: "gap" }),
        push("save", () => this.save(), { data: { act: "save" }, title: "the grid as data (.json)" }), push("use it", () => this.use(), { className: "hl-btn hp-main", data: { act: "use" }, title: "put the muscle on the live hand" })));
  }

  listen() {
    const { root, stage } = this, turn = (event) => ({ ArrowLeft: [-0.12, 0], ArrowRight: [0.12, 0], ArrowUp: [0, -0.12], ArrowDown: [0, 0.12] })[event.key];
    stage.addEventListener("pointerdown", (event) => this.down(event));
    stage.addEventListener("pointermove", (event) => this.move(event));
    stage.addEventListener("pointerup", (event) => this.up(event));
    stage.addEventListener("pointercancel", (event) => { this.fingers.delete(event.pointerId); this.drag = null; this.hand.redraw(); });
    stage.addEventListener("contextmenu", (event) => event.preventDefault());
    stage.addEventListener("wheel", (event) => { event.preventDefault(); this.zoom(Math.exp(Math.max(-0.4, Math.min(0.4, 0.0012 * event.deltaY))), this.at(event)); }, { passive: false });
    this.canvas.addEventListener("webglcontextlost", (event) => event.preventDefault());
    this.canvas.addEventListener("webglcontextrestored", () => { if (!this.gone) { this.hand.setUp(); this.hand.fresh = true; this.hand.layFlesh(); this.hand.redraw(); } });
    root.addEventListener("keydown", (event) => {
      event.stopPropagation(); // a notebook has its own meaning for these keys
      if (event.target.matches("input, select")) return;
      if (event.key === "Backspace" || (event.key === "z" && (event.ctrlKey || event.metaKey))) this.undo();
      else if (turn(event)) { this.hand.orbit(...turn(event)); this.looks(); }
      else if (event.key === "+" || event.key === "=" || event.key === "-") this.zoom(event.key === "-" ? 1.15 : 1 / 1.15);
      else return;
      event.preventDefault();
    });
    this.sizes = new ResizeObserver(() => this.resized());
    this.sizes.observe(root);
    this.sizes.observe(stage);
  }

  resized() {
    const { clientWidth: w } = this.root;
    this.root.dataset.size = w < 800 ? "small" : w >= 1700 ? "large" : "middle";
    this.hand.covered = this.bar.offsetTop + this.bar.offsetHeight;
    if (this.hand.viewName) this.hand.fit(); else this.hand.redraw();
  }

  looks() {
    const { hand, skin } = this, seen = skin === "mesh" ? "hidden" : skin ?? "translucent";
    if (hand.look.skin !== seen) { hand.look.skin = seen; hand.layFlesh(); }
    for (const [list, now] of [["view", hand.viewName], ["skin", skin ?? "translucent"]]) for (const one of this.bar.querySelectorAll(`[data-${list}]`)) one.setAttribute("aria-pressed", String(one.dataset[list] === now));
    hand.redraw();
  }

  // ---- points and settings

  change(act) { // every change of points can be undone; every change is kept at once and sent at once
    const before = this.points;
    this.back = false;
    act();
    if (this.points !== before) { this.history.push(before); if (this.history.length > 400) this.history.shift(); }
    this.hush();
    this.keep();
    this.update();
    this.show();
  }

  undo() {
    if (!this.history.length) return;
    this.points = this.history.pop();
    this.back = true;
    this.hush();
    this.keep();
    this.update();
    this.show();
  }

  clear() { if (this.points.length) this.change(() => { this.points = []; }); }
  mark() { return `${this.scene.hand}, ${this.scene.side}`; } // whose skin the points are on
  keep() { this.transport.store?.write({ of: this.mark(), points: this.points, settings: this.settings }); }

  retell(told) { // code has changed something
    if (JSON.stringify(told.points) !== JSON.stringify(this.points)) this.history.push(this.points);
    if (told.view && told.view !== this.about.view) { this.about.view = told.view; this.hand.view(told.view); }
    this.take(told);
    this.heed(told);
  }

  take(told) { Object.assign(this, { points: told.points, settings: told.settings, contraction: told.contraction, skin: told.skin }); this.looks(); }

  // ---- between page and host: one message on its way at a time, the newest next

  async update() {
    this.updates = (this.updates ?? 0) + 1;
    this.dirty = true;
    if (this.sending) return;
    this.sending = true;
    try {
      while (this.dirty && !this.gone) await this.sent();
    } finally {
      this.sending = false;
    }
    if (!this.gone) this.show();
  }

  async sent() {
    this.dirty = false;
    const start = performance.now();
    const reply = await this.transport.ask({ kind: "paint", points: this.points, settings: this.settings, contraction: this.contraction, have: this.fit, passing: !!this.drag?.moved, back: this.back });
    if (this.gone) return;
    this.stats.latency_ms.push(performance.now() - start);
    this.stats.server_ms.push(reply.ms);
    this.refused = reply.good ? null : reply.text;
    if (this.refused) this.say(this.refused); // what was clicked stays
    else this.heed(reply, this.dirty);
  }

  heed(told, stale = false) {
    const { hand } = this;
    this.told = told;
    this.troubles = told.troubles ?? {};
    if (!stale) {
      const refused = Object.fromEntries(Object.keys(this.troubles).filter((name) => name in this.settings).map((name) => [name, this.settings[name]]));
      this.settings = { ...told.settings, ...refused }; // what was refused stays to be mended
    }
    if (told.layers) { hand.takeLayers(unpackScene(opened(told.layers))); this.fit = told.fit; }
    hand.look.muscles = told.muscle;
    if (told.segments) { const bytes = opened(told.segments); hand.segments = new Int16Array(bytes.buffer); }
    hand.layFlesh();
    const said = Object.values(this.troubles);
    if (said.length) this.say(said.join(" "));
    else if (told.problem) this.say(`${told.problem}. Drag a point, undo, or change a setting; nothing is lost.`);
    else if (this.kind === "bad") this.hush();
    this.show();
  }

  async save() {
    const reply = await this.asked({ kind: "save", folder: this.folder?.value });
    if (!reply.good || !reply.file) { this.say(reply.said ?? reply.text, reply.good ? "good" : "told"); return; }
    const link = make("a", { href: URL.createObjectURL(new Blob([reply.file.text], { type: "application/json" })), download: reply.file.name });
    this.root.append(link);
    link.click();
    link.remove();
    setTimeout(() => URL.revokeObjectURL(link.href), 20000);
    this.say(reply.said, "good");
  }

  async use() {
    const reply = await this.asked({ kind: "use" });
    if (reply.good && this.transport.used) this.transport.used(this.about.drives.find(([name]) => name === this.settings.drive)?.[1]);
    else this.say(reply.said ?? reply.text, reply.good ? "good" : "told");
  }

  async asked(message) { // what was just typed counts; what is changed while that is on its way takes the wish back
    document.activeElement?.blur?.();
    const done = this.update(), mine = this.updates;
    await done;
    while (this.sending) await new Promise((go) => setTimeout(go, 20));
    if (this.updates !== mine) return { good: false, text: "" };
    const text = this.refused ?? Object.values(this.troubles).join(" ");
    if (text) return { good: false, text };
    return this.transport.ask(message);
  }

  // ---- the hand's own words

  say(text, kind = "bad") { if (!text) return; this.kind = kind; this.message.textContent = text; this.message.hidden = false; this.message.classList.toggle("good", kind === "good"); }
  hush() { this.kind = null; this.message.hidden = true; }

  show() {
    const { fields: F, settings: S, told } = this, set = (node, value) => { if (node !== document.activeElement || node.tagName === "SELECT") node.value = value ?? ""; };
    for (const name of ["name", "drive", "columns", "finer"]) set(F[name], S[name]);
    set(F.least, S.thickness_mm[0]);
    set(F.most, S.thickness_mm[1]);
    set(F.skin_distance_mm, [S.skin_distance_mm].flat().join(", "));
    set(F.contraction, Math.round(100 * this.contraction));
    F.contraction.style.setProperty("--p", `${Math.round(100 * this.contraction)}%`);
    this.percent.textContent = `${Math.round(100 * this.contraction)} %`;
    for (const [name, nodes] of Object.entries({ ...F, thickness_mm: null })) for (const node of name === "thickness_mm" ? [F.least, F.most] : [nodes]) if (name !== "least" && name !== "most") node.setAttribute("aria-invalid", String(name in this.troubles));
    this.ends.forEach((box, k) => { box.checked = S.on_bone[k]; });
    this.boneRows();
    this.facts.replaceChildren(...told.facts.map((text) => make("span", { textContent: text })));
    this.guide.textContent = this.next();
    this.hand.redraw();
  }

  next() {
    const count = this.points.length, columns = this.settings.columns, left = columns - (count % columns), row = Math.floor(count / columns) + 1;
    if (!count) return `Click where the muscle begins: ${columns} points across its fibres. Then the next row, towards its end.`;
    if (left < columns) return `Row ${row}: ${plural(left, "more click")}.`;
    if (row < 3) return `Row ${row}: ${plural(columns, "click")}.`;
    return this.told.muscle && !this.sending ? "The muscle is there. Click another row, drag points, or use it." : "Click another row, or drag points.";
  }

  boneRows() { // one choice for every whole row
    const { told, settings: S } = this, rows = told.rows, choices = [...this.bones.querySelectorAll("select")];
    if (choices.length !== rows) {
      this.bones.replaceChildren(...(rows ? [make("b", { textContent: "bones that carry the rows" })] : []), ...Array.from({ length: rows }, (_, k) => make("label", { className: "hp-field" }, make("span", { textContent: `row ${k + 1}` }),
        make("select", { data: { row: k }, onchange: () => this.change(() => { const all = [...this.bones.querySelectorAll("select")]; this.settings = { ...this.settings, bones: all.map((one) => (one.value === "two" ? this.named(one.dataset.row) : one.value || null)) }; }) },
          make("option", { value: "" }), ...this.about.bones.map((name) => make("option", { value: name, textContent: spaced(name) }))))));
    }
    this.bones.querySelectorAll("select").forEach((node, k) => {
      const named = this.named(k), two = named && typeof named === "object";
      node.firstChild.textContent = named ? "nearest" : `nearest: ${(told.carriers[k] ?? []).map(spaced).join(" + ")}`;
      node.querySelector("[value=two]")?.remove();
      if (two) node.append(make("option", { value: "two", textContent: Object.keys(named).map(spaced).join(" + ") }));
      node.value = two ? "two" : named ?? "";
      node.setAttribute("aria-invalid", String("bones" in this.troubles));
    });
  }

  named(k) { const { bones } = this.settings; return bones.length === 1 ? bones[0] : bones[k] ?? null; }

  // ---- the user's hand

  at(event) { const box = this.stage.getBoundingClientRect(); return [event.clientX - box.left, event.clientY - box.top]; }

  ray([x, y]) {
    const { hand, canvas } = this, { clientWidth: w, clientHeight: h } = canvas, reach = Math.tan(this.scene.lens_deg * Math.PI / 360);
    const sx = (2 * x / w - 1) * reach * w / h, sy = (1 - 2 * y / h) * reach;
    return [0, 1, 2].map((k) => sx * hand.right[k] + sy * hand.up[k] - hand.eye[k]);
  }

  seat() { const { focus, distance, eye } = this.hand; return focus.map((value, k) => value + distance * eye[k]); }

  first(from, way) { return rayTriangles(this.hand.coarse, this.scene.arrays.skin_faces, 0, this.scene.arrays.skin_faces.length, from, way, Infinity, {}); }

  touch(place) { // the place on the skin under the pointer, or null beside the hand
    const from = this.seat(), way = this.ray(place), far = this.first(from, way);
    return far === Infinity ? null : from.map((value, k) => value + far * way[k]);
  }

  zoom(factor, [x, y] = [this.canvas.clientWidth / 2, this.canvas.clientHeight / 2]) { // what lies under the pointer stays there
    const { hand } = this, before = hand.distance, way = this.ray([x, y]);
    hand.zoom(factor);
    hand.focus = hand.focus.map((value, k) => value + (before - hand.distance) * (way[k] + hand.eye[k]));
    hand.viewName = "";
    this.looks();
  }

  down(event) {
    if (event.target.closest(".hl-bar, .hp-zoom")) return;
    this.stage.setPointerCapture(event.pointerId);
    this.stage.focus({ preventScroll: true });
    const place = this.at(event);
    this.fingers.set(event.pointerId, place);
    if (this.fingers.size > 1) { this.drag = null; this.pinched = true; this.hand.redraw(); return; }
    let key = -1, best = event.pointerType === "touch" ? NEAR_TOUCH : NEAR;
    if (event.button === 0) this.points.forEach((point, k) => {
      const [x, y] = this.onScreen(point), far = Math.hypot(x - place[0], y - place[1]);
      if (far <= best && this.seen(point)) { best = far; key = k; }
    });
    this.pinched = false;
    this.drag = { key, start: place, before: place, moved: false, click: event.button === 0, from: this.points };
  }

  move(event) {
    const place = this.at(event), before = this.fingers.get(event.pointerId), { drag, hand } = this;
    if (!before) return;
    this.fingers.set(event.pointerId, place);
    const dx = place[0] - before[0], dy = place[1] - before[1];
    if (this.fingers.size === 2) {
      const other = [...this.fingers.entries()].find(([id]) => id !== event.pointerId)[1];
      const gap = (one) => Math.hypot(one[0] - other[0], one[1] - other[1]) || 1;
      hand.pan(dx / 2, dy / 2);
      this.zoom(gap(before) / gap(place), [(place[0] + other[0]) / 2, (place[1] + other[1]) / 2]);
      return;
    }
    if (!drag || (!drag.moved && Math.hypot(place[0] - drag.start[0], place[1] - drag.start[1]) < STILL)) return;
    drag.moved = true;
    if (drag.key >= 0) {
      const there = this.touch(place);
      if (!there) return; // it stays at the edge
      this.points = this.points.map((point, k) => (k === drag.key ? there : point));
      this.update();
      hand.redraw();
    } else if (event.shiftKey || event.buttons & 6) { hand.pan(dx, dy); this.looks(); } else { hand.orbit(dx * 0.009, dy * 0.009); this.looks(); }
  }

  up(event) {
    this.fingers.delete(event.pointerId);
    const { drag } = this;
    if (!drag || this.pinched) return;
    this.drag = null;
    if (drag.moved && drag.key >= 0) { // one step to undo, however long the way
      const { points } = this;
      this.points = drag.from;
      this.change(() => { this.points = points; });
    } else if (!drag.moved && drag.key < 0 && drag.click) {
      const there = this.touch(drag.start);
      if (there) this.change(() => { this.points = [...this.points, there]; });
      else this.say("That was beside the hand; nothing was changed.", "told");
    } else if (!drag.moved && drag.click) this.say(`A point is there already (row ${Math.floor(drag.key / this.settings.columns) + 1}). Drag it to move it; zoom in to set another beside it.`, "told");
  }

  // ---- what is drawn over the hand

  onScreen([x, y, z], m = this.hand.projection()) {
    const w = m[3] * x + m[7] * y + m[11] * z + m[15];
    return [(0.5 + 0.5 * (m[0] * x + m[4] * y + m[8] * z + m[12]) / w) * this.canvas.clientWidth, (0.5 - 0.5 * (m[1] * x + m[5] * y + m[9] * z + m[13]) / w) * this.canvas.clientHeight];
  }

  seen(point, outward = null) { // on the side that is looked at, and no finger before it
    const from = this.seat(), way = point.map((value, k) => value - from[k]);
    if (outward && outward[0] * way[0] + outward[1] * way[1] + outward[2] * way[2] > 0) return false;
    if (outward && !this.still) return true;
    const far = Math.hypot(...way);
    return this.first(from, way) * far > far - HIDDEN;
  }

  overlay() {
    this.still = false;
    this.lay();
    clearTimeout(this.rest);
    this.rest = setTimeout(() => { this.still = true; if (!this.gone) this.lay(); }, REST_MS);
  }

  lay() {
    const { svg, told, hand } = this;
    if (!told) return;
    const m = hand.projection(), to = (point) => this.onScreen(point, m).map((one) => one.toFixed(1)).join(" ");
    const parts = [], size = Math.min(Math.max(0.4 * this.canvas.clientHeight / (560 * hand.distance), 0.55), 1); // a small grid is not hidden by its own marks
    svg.style.setProperty("--size", size.toFixed(2));
    if (this.skin === "mesh") parts.push(draw("path", { class: "wires", d: this.wires(m) }));
    const paths = ["", ""], lines = this.points.length ? told.lines : [];
    lines.forEach((flat, n) => {
      let before = -1;
      for (let p = 0; p < flat.length; p += 3) {
        const at = [flat[p] / 1e3, flat[p + 1] / 1e3, flat[p + 2] / 1e3], side = this.seen(at, told.outward[n].slice(p, p + 3)) ? 0 : 1;
        paths[side] += `${before === side ? "L" : p ? `M${paths.last}L` : "M"}${to(at)}`;
        paths.last = to(at);
        before = side;
      }
    });
    const kind = told.problem ? "bad" : "";
    parts.push(draw("path", { class: `grid far ${kind}`, d: paths[1] }), draw("path", { class: "grid casing", d: paths[0] }), draw("path", { class: `grid ${kind}`, d: paths[0] }));
    const P = hand.coarse, N = hand.coarseNormals, vector = (from, v) => [from[3 * v], from[3 * v + 1], from[3 * v + 2]];
    const dots = told.muscle ? told.influenced.filter((v) => this.seen(vector(P, v), vector(N, v))).map((v) => `M${to(vector(P, v))}h.01`).join("") : "";
    parts.push(draw("path", { class: "dots casing", d: dots }), draw("path", { class: "dots", d: dots }));
    const columns = this.settings.columns, places = this.points.map((point) => this.onScreen(point, m));
    this.points.forEach((point, k) => {
      const front = this.seen(point), [cx, cy] = places[k];
      parts.push(draw("circle", { cx, cy, r: (front ? 6 : 4) * Math.max(size, 0.75), class: `${front ? "" : "far"} ${this.drag?.key === k ? "held" : ""} ${kind}`, "data-point": k }));
      if (k % columns || !front) return; // the first point of every row carries its number, away from the second
      const left = k + 1 < places.length && places[k + 1][0] > cx, text = draw("text", { x: cx + (left ? -12 : 12), y: cy + 5, "text-anchor": left ? "end" : "start", class: kind });
      text.textContent = `row ${k / columns + 1}`;
      parts.push(text);
    });
    svg.replaceChildren(...parts);
  }

  wires(m) { // edges of the even skin that face the eye
    const { skin_faces: faces } = this.scene.arrays, P = this.hand.coarse, at = new Array(P.length / 3);
    for (let v = 0; v < at.length; v++) at[v] = this.onScreen([P[3 * v], P[3 * v + 1], P[3 * v + 2]], m);
    let path = "";
    for (let f = 0; f < faces.length; f += 3) {
      const [a, b, c] = [at[faces[f]], at[faces[f + 1]], at[faces[f + 2]]];
      if ((b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]) >= 0) continue;
      path += `M${a[0].toFixed(1)} ${a[1].toFixed(1)}L${b[0].toFixed(1)} ${b[1].toFixed(1)}L${c[0].toFixed(1)} ${c[1].toFixed(1)}`;
    }
    return path;
  }
}

const PAINT_STYLE = `
.hl.hp { grid-template:auto minmax(0,1fr) / minmax(0,1fr) 396px; min-height:0; font-size:15px; } .hl.hp[data-size=large] { font-size:20px; grid-template-columns:minmax(0,1fr) 530px; }
.hp > header { grid-column:1 / -1; display:flex; align-items:center; gap:8px 18px; padding:8px 16px; border-bottom:1px solid var(--rule); }
.hp h1 { margin:0; font-size:1.25em; font-weight:650; white-space:nowrap; color:var(--ink); } .hp .hp-guide { flex:1; margin:0; font-size:1.08em; color:#005f95; font-weight:600; min-width:0; }
.hp .hp-stage { grid-column:1; grid-row:2; touch-action:none; user-select:none; } .hp .hp-stage canvas, .hp .hp-stage canvas:active { cursor:crosshair; } .hp-stage:focus-visible { outline-offset:-3px; }
.hp-stage > svg { position:absolute; inset:0; width:100%; height:100%; pointer-events:none; overflow:hidden; }
.hp-stage .hp-zoom { position:absolute; left:10px; bottom:10px; } .hp-stage .hp-zoom button { min-width:40px; font-size:1.15em; }
.hp svg path { fill:none; stroke-linejoin:round; stroke-linecap:round; } .hp svg .grid { stroke:var(--blue); stroke-width:2.6; } .hp svg .grid.far { stroke-width:1.4; stroke-dasharray:2 5; opacity:.6; } .hp svg .grid.casing { stroke:#fff; stroke-width:5; opacity:.6; }
.hp svg .grid.bad, .hp svg circle.bad { stroke:var(--vermilion); } .hp svg .dots { stroke:#009E73; stroke-width:calc(8px * var(--size)); } .hp svg .dots.casing { stroke:#fff; stroke-width:calc(10.5px * var(--size)); } .hp svg .wires { stroke:#7B8794; stroke-width:.6; opacity:.8; }
.hp svg circle { fill:#fff; stroke:var(--blue); stroke-width:2.8; } .hp svg circle.far { fill:none; stroke-width:1.6; stroke-dasharray:2 2; } .hp svg circle.held { fill:#F0E442; }
.hp svg text { font-size:.95em; font-weight:650; fill:#00507d; stroke:#fff; stroke-width:4; paint-order:stroke; } .hp svg text.bad { fill:#a33a00; }
.hp .hp-side { grid-column:2; grid-row:2; display:flex; flex-direction:column; gap:8px; padding:14px 16px; border-left:1px solid var(--rule); overflow:auto; min-height:0; scrollbar-width:thin; } .hp-side > * { flex:none; } .hp-side > .gap { flex:1; min-height:0; }
.hp-field { display:grid; grid-template-columns:9.7em minmax(0,1fr); align-items:center; gap:8px; } .hp-field:has(i) { grid-template-columns:9.7em minmax(0,1fr) auto minmax(0,1fr); } .hp-field:has(output) { grid-template-columns:9.7em minmax(0,1fr) 3.2em; } .hp-field i { font-style:normal; color:var(--faint); } .hp-field output { text-align:right; font-variant-numeric:tabular-nums; }
.hp-side :is(input[type=text], input[type=number], select) { width:100%; min-width:0; padding:5px 8px; border:1px solid #b9c2cb; border-radius:8px; background:#fff; } .hp-side :is(input,select)[aria-invalid=true] { border:2px solid var(--vermilion); background:#fff4ea; }
.hp-pair { display:grid; grid-template-columns:1fr 1fr; gap:14px; } .hp-pair .hp-field { grid-template-columns:auto minmax(0,1fr); } .hp-ends { display:flex; flex-wrap:wrap; gap:4px 18px; } .hp-ends label { display:flex; align-items:center; gap:6px; }
.hp-bones { display:grid; gap:6px; } .hp-bones .hp-field { grid-template-columns:4em minmax(0,1fr); } .hp-bones b { font-weight:600; margin-top:4px; }
.hp-facts { display:flex; flex-wrap:wrap; gap:5px; } .hp-facts span { background:#eef2f5; border-radius:99px; padding:2px 11px; font-size:.93em; font-variant-numeric:tabular-nums; }
.hl-wait.hp-none { place-content:center; gap:12px; color:var(--ink); text-align:center; padding:20px; } .hp-say { background:#fff4ea; border:1px solid #f0b58a; border-left:5px solid var(--vermilion); border-radius:8px; padding:8px 12px; position:sticky; top:0; z-index:3; } .hp-say.good { background:#e8f6ef; border-color:#8fcbb0; border-left-color:#009E73; } .hp-say[hidden] { display:none; }
.hp-tools { display:flex; gap:8px; align-items:center; position:sticky; bottom:-14px; background:#fff; padding:8px 0 14px; margin-bottom:-14px; } .hp-tools .gap { flex:1; } .hp-tools .hl-btn { padding:7px 14px; } .hl .hl-btn.hp-main { background:var(--blue); border-color:var(--blue); color:#fff; font-weight:650; } .hl .hl-btn.hp-main:hover { background:#005f95; }
.hl.hp[data-size=small] { grid-template:auto minmax(0,1fr) auto / minmax(0,1fr); } .hp[data-size=small] > header { flex-wrap:wrap; padding:6px 10px; } .hp[data-size=small] h1 { flex:1; } .hp[data-size=small] .hp-guide { order:3; flex-basis:100%; font-size:1em; }
.hp[data-size=small] .hp-side { grid-column:1; grid-row:3; border-left:0; border-top:1px solid var(--rule); max-height:44vh; padding:10px; } .hp[data-size=small] .hp-tools { bottom:-10px; padding-bottom:10px; margin-bottom:-10px; }
`;
