// From a photograph to your own hand: the page of the app and the panel of a notebook.
//
//   const api = await fit(element, transport)
//
// transport: { ask(message, bytes) -> Promise of a reply (messages and replies: fit_room.py), store: where clicks and picture outlive
//   a reload (none: the host keeps them), close(): leaves the page (none: there is nowhere to go) }
// All places are pixels of the photograph. The page holds the clicks, sends all of them after every change, and never waits for the answer.

import { draw } from "./drawing.js";
import { make } from "./nodes.js";

const NEAR = 10, NEAR_TOUCH = 22, STILL = 4; // px on the screen: within which a mark is taken hold of; that a click may wander
const LOUPE = 150, LARGER = 3, NUDGE = 0.5;
const STEPS = ["photo", "scale", "points", "hand"];
const CHAPTERS = { photo: "Photograph", scale: "Scale", points: "Points", hand: "Your hand" };
const FINGERS = ["thumb", "index", "middle", "ring", "little"];
const BONES = ["metacarpal", "proximal phalanx", "middle phalanx", "distal phalanx"];
const LARGEST = 120e6; // bytes

const push = (text, onclick, more = {}) => make("button", { type: "button", textContent: text, onclick, ...more });
const empty = () => ({ landmarks: {}, scale: {}, view: null, side: null, camera_mm: null, sure: false, mirror: false, outline: true });
const percent = (share) => `${Math.round(100 * share)} %`;
const line = (places) => `M${places.map(([x, y]) => `${x} ${y}`).join("L")}Z`;

export async function fit(element, transport) {
  if (!document.getElementById("handlab-fit-style")) document.head.append(make("style", { id: "handlab-fit-style", textContent: STYLE }));
  const page = new Page(element, transport);
  await page.begin();
  element.fit = page;
  return page;
}

class Page {
  constructor(element, transport) {
    Object.assign(this, { element, transport, clicks: empty(), history: [], step: "photo", picture: null, told: null, sketch: null, result: null });
    this.view = { s: 1, x: 0, y: 0 };
    this.fingers = new Map();
    this.ruler = []; // the first click, until there is a second
    this.stats = { latency_ms: [], server_ms: [], actions: 0, fit_ms: 0, picture_ms: 0 };
    this.kind = "ruler";
    this.coin = null;
    this.lastMm = 100;
  }

  async begin() {
    this.build();
    this.told = await this.transport.ask({ kind: "hello" });
    if (!this.told.good) { this.say(this.told); return; }
    this.go("photo");
    this.transport.ask({ kind: "drawings" }).then(({ drawings }) => { this.told.drawings = drawings; if (!this.side.querySelector("input[data-mm]")) this.panel(); }); // not while a distance is typed
    this.coin = this.told.coins[this.told.coins.indexOf("2 euro")] ?? this.told.coins[0];
    const kept = this.transport.store ? await this.transport.store.read() : null;
    if (this.told.picture) {
      const same = kept?.clicks && kept.of === this.mark(this.told.picture);
      this.show(this.told.picture, same ? kept.clicks : this.told.clicks);
    } else if (kept?.picture) await this.open(kept.picture, kept.name, kept);
    if (this.picture) this.go(this.due());
  }

  dispose() { this.sizes.disconnect(); this.element.replaceChildren(); }

  // ---- what is where

  build() {
    this.root = make("div", { className: "hf", tabIndex: -1, data: { lmSuppressShortcuts: "true" } });
    this.chapters = make("ol", { className: "hf-steps" }, ...STEPS.map((name, k) => make("li", { data: { step: name } }, push(`${k + 1}  ${CHAPTERS[name]}`, () => this.go(name)))));
    const close = this.transport.close ? push("back to the live hand", () => this.transport.close(), { className: "hf-btn", data: { act: "close" } }) : null;
    this.img = make("img", { alt: "Your photograph", draggable: false });
    this.svg = draw("svg", { "aria-hidden": "true" });
    this.loupe = make("canvas", { className: "hf-loupe", width: 2 * LOUPE, height: 2 * LOUPE, hidden: true });
    this.stage = make("div", { className: "hf-stage", tabIndex: 0, aria: { role: "application", label: "The photograph. Click to set the point that is asked for; drag a point to move it; drag elsewhere to move the picture; wheel, plus and minus to zoom; Backspace to undo; S to skip; arrow keys to move the last point." } }, this.img, this.svg, this.loupe,
      make("div", { className: "hf-zoom" }, push("+", () => this.zoom(1.4), { title: "nearer", aria: { label: "nearer" } }), push("−", () => this.zoom(1 / 1.4), { title: "farther", aria: { label: "farther" } }), push("whole", () => this.whole(), { title: "the whole picture" })));
    this.side = make("aside", { className: "hf-side" });
    this.message = make("div", { className: "hf-say", hidden: true, aria: { role: "status", live: "polite" } });
    this.file = make("input", { type: "file", accept: "image/*,.heic,.heif", hidden: true, onchange: () => { const [one] = this.file.files; this.file.value = ""; if (one) this.open(one, one.name); } });
    this.table = make("input", { type: "file", accept: ".csv,.json", hidden: true, onchange: () => { const [one] = this.table.files; this.table.value = ""; if (one) this.readPoints(one); } });
    this.root.append(make("header", {}, make("h1", { textContent: "Your own hand" }), this.chapters, close), this.stage, this.side, this.file, this.table);
    this.element.replaceChildren(this.root);
    this.listen();
  }

  listen() {
    const { root, stage } = this;
    for (const name of ["dragenter", "dragover"]) root.addEventListener(name, (event) => { event.preventDefault(); root.classList.add("over"); });
    for (const name of ["dragleave", "drop"]) root.addEventListener(name, (event) => { event.preventDefault(); root.classList.remove("over"); });
    root.addEventListener("drop", (event) => this.dropped(event.dataTransfer.files[0]));
    root.addEventListener("paste", (event) => { const [one] = event.clipboardData?.files ?? []; if (one) this.dropped(one); });
    stage.addEventListener("pointerdown", (event) => this.down(event));
    stage.addEventListener("pointermove", (event) => this.move(event));
    stage.addEventListener("pointerup", (event) => this.up(event));
    stage.addEventListener("pointercancel", (event) => { this.fingers.delete(event.pointerId); this.drag = null; this.paint(); });
    stage.addEventListener("contextmenu", (event) => event.preventDefault());
    stage.addEventListener("touchend", (event) => { if (event.cancelable && !event.target.closest(".hf-zoom")) event.preventDefault(); }, { passive: false }); // the mouse that browsers play after a tap takes the focus away
    stage.addEventListener("wheel", (event) => { if (!this.picture) return; event.preventDefault(); this.zoom(Math.exp(-0.0016 * Math.max(-240, Math.min(240, event.deltaY))), this.at(event)); }, { passive: false });
    root.addEventListener("keydown", (event) => this.key(event));
    this.sizes = new ResizeObserver(() => this.resized());
    this.sizes.observe(root);
    this.sizes.observe(stage);
  }

  resized() {
    const { clientWidth: w, clientHeight: h } = this.root;
    this.root.dataset.size = w < 760 ? "small" : w >= 1700 ? "large" : "middle";
    this.root.classList.toggle("low", h < 640);
    if (this.picture && !this.moved) this.whole(); else this.paint();
  }

  go(step) {
    if (step !== "photo" && !this.picture) return;
    if (step === "points" && !this.scaled()) step = "scale";
    if (step === "hand" && !this.result) { this.finish(); return; }
    this.step = step;
    this.root.dataset.step = step;
    this.hush();
    if (step !== "photo") this.stage.focus({ preventScroll: true });
    this.panel();
    this.side.scrollTop = 0;
    if (this.moved) this.paint(); else this.whole(); // the stage has a size only now
  }

  due() { return !this.clicks.view || !this.scaled() ? "scale" : "points"; }
  scaled() { const { scale } = this.clicks; return scale.ruler ? !!scale.mm : !!(scale.coin || scale.card); }
  point(name) { return this.told.points.find((one) => one.name === name); }
  wanted() { return this.step !== "points" ? null : this.asked && !(this.asked in this.clicks.landmarks) ? this.asked : (this.told.points.find(({ name }) => !(name in this.clicks.landmarks))?.name ?? null); }
  placed() { return Object.entries(this.clicks.landmarks).filter(([, at]) => at); }

  // ---- the photograph

  dropped(file) {
    if (!file) return;
    if (/\.(csv|json)$/i.test(file.name)) this.readPoints(file); else this.open(file, file.name);
  }

  async open(blob, name, kept = null) {
    if (blob.size > LARGEST) { this.say({ text: `${name} has ${Math.round(blob.size / 1e6)} MB; up to ${LARGEST / 1e6} MB can be read: save it as JPEG.` }); return; }
    const start = performance.now();
    this.busy("reading the picture ...");
    const reply = await this.transport.ask({ kind: "picture", name }, await blob.arrayBuffer());
    this.busy(null);
    if (!reply.good) { this.say(reply); return; }
    this.stats.picture_ms = performance.now() - start;
    await this.transport.store?.picture(blob, name);
    const clicks = kept?.clicks && kept.of === this.mark(reply.picture) ? kept.clicks : reply.clicks; // a notebook remembers this very picture
    this.result = this.sketch = null;
    this.history = [];
    this.ruler = [];
    this.asked = null;
    this.show(reply.picture, clicks);
    this.go(this.due());
  }

  show(picture, clicks) {
    this.picture = picture;
    this.clicks = { ...empty(), ...clicks };
    this.img.src = picture.image; // drawn when it is there: nothing waits for it
    this.moved = false;
    this.whole();
    this.keep();
    this.update();
  }

  async readPoints(file) {
    if (!this.picture) { this.say({ text: "Open the photograph first, then the points." }); return; }
    const reply = await this.transport.ask({ kind: "read", name: file.name, text: await file.text() });
    if (!reply.good) { this.say(reply); return; }
    const found = reply.clicks, old = this.clicks;
    this.change(() => {
      this.clicks = { ...old, landmarks: found.landmarks, scale: Object.keys(found.scale).length ? found.scale : old.scale, view: found.view ?? old.view, side: found.side ?? old.side };
    });
    this.go(this.due());
  }

  // ---- clicks

  change(act) { // every change can be undone, is kept at once and sent at once
    this.history.push(JSON.stringify({ clicks: this.clicks, ruler: this.ruler }));
    if (this.history.length > 400) this.history.shift();
    act();
    if (this.from === "page") { this.message.hidden = true; this.doubted = null; }
    this.result = null;
    if (this.step === "hand") { this.step = "points"; this.root.dataset.step = "points"; }
    this.keep();
    this.update();
    this.panel();
    this.paint();
  }

  retell(clicks) { // code has changed the clicks
    this.clicks = { ...empty(), ...clicks };
    this.result = null;
    this.go(this.picture ? this.due() : "photo");
    this.update();
  }

  undo() {
    if (!this.history.length) return;
    Object.assign(this, JSON.parse(this.history.pop()), { result: null, asked: null });
    this.hush();
    this.keep();
    this.update();
    if (this.step === "hand" || (this.step === "points" && this.due() === "scale")) this.go(this.due()); else { this.panel(); this.paint(); }
  }

  keep() { if (this.picture) this.transport.store?.clicks(this.clicks, this.mark(this.picture)); }
  mark({ name, width, height }) { return `${name}, ${width} x ${height}`; } // which picture the clicks belong to

  put(place) {
    if (this.step === "scale") this.putScale(place);
    else if (this.step === "points" && this.wanted()) {
      const name = this.wanted();
      this.change(() => { this.clicks.landmarks = { ...this.clicks.landmarks, [name]: place }; this.asked = null; this.last = name; });
      if (!this.wanted()) this.finish();
    }
  }

  putScale(place) {
    if (!this.clicks.view) { this.say({ text: "First: does the picture show the palm or the back?" }); return; }
    if (this.waiting) return; // the coin that was clicked is still looked for
    if (this.kind === "ruler") {
      if (this.ruler.length === 1) this.change(() => { this.clicks.scale = { ruler: [this.ruler[0], place] }; this.ruler = []; this.clicks.sure = false; });
      else this.change(() => { this.ruler = [place]; this.clicks.scale = {}; });
    } else {
      this.change(() => { this.clicks.scale = this.kind === "coin" ? { coin: place, name: this.coin } : { card: place }; this.clicks.sure = false; });
      this.waiting = true; // the coin is looked for: on with the points when it is found
      this.busy(`looking for the ${this.kind} ...`);
    }
  }

  setMm(value) {
    const mm = Number(String(value).replace(",", "."));
    if (!(mm > 0)) { this.say({ text: "Write the distance between the two marks in millimetres, such as 100." }); return; }
    this.lastMm = mm;
    this.change(() => { this.clicks.scale = { ruler: this.clicks.scale.ruler, mm }; this.clicks.sure = false; });
    this.go("points");
  }

  skip() {
    const name = this.wanted();
    if (!name) return;
    this.change(() => { this.clicks.landmarks = { ...this.clicks.landmarks, [name]: null }; this.asked = null; });
    if (!this.wanted()) this.finish();
  }

  again(name) { // this point is asked for next
    this.change(() => { const { [name]: _, ...rest } = this.clicks.landmarks; this.clicks.landmarks = rest; this.asked = name; });
    if (this.step !== "points") this.go("points");
  }

  answer(given) {
    const finishing = this.finishing;
    this.hush();
    if (given.redo) { this.again(given.redo[0]); return; }
    this.change(() => {
      if (given.swap) this.swap(...given.swap);
      else Object.assign(this.clicks, given);
    });
    if (given.view === null) this.go("scale");
    else if (finishing) this.finish();
  }

  swap(a, b) { // two points, or two fingers with all of theirs
    const old = this.clicks.landmarks, other = (name) => {
      if (name === a || name === b) return name === a ? b : a;
      const [joint, digit] = name.split("_");
      return ["tip", "dip", "ip", "pip", "mcp"].includes(joint) && (digit === a || digit === b) ? `${joint}_${digit === a ? b : a}` : name;
    };
    this.clicks.landmarks = Object.fromEntries(Object.entries(old).map(([name, at]) => (other(name) in old ? [name, old[other(name)]] : [name, at])));
  }

  // ---- between page and host: one message on its way at a time, the newest clicks next

  async update() {
    if (!this.picture) return;
    if (this.sending) { this.dirty = true; return; }
    this.sending = true;
    do {
      this.dirty = false;
      const start = performance.now(), sent = this.clicks, count = this.placed().length;
      const reply = await this.ask({ kind: "clicks", clicks: sent });
      if (this.dirty) continue;
      if (count >= 4) { this.stats.latency_ms.push(performance.now() - start); this.stats.server_ms.push(reply.ms); }
      this.heed(reply);
    } while (this.dirty);
    this.sending = false;
  }

  heed(reply) {
    this.scale = reply.scale ?? null;
    this.sketch = reply.sketch ?? (reply.trouble ? this.sketch : null);
    if (this.placed().length < 4) this.sketch = null;
    if (!reply.good || reply.trouble) { this.say(reply.trouble ?? reply, "clicks"); if (!reply.good && this.waiting) this.change(() => { this.clicks.scale = {}; }); }
    else if (this.from === "clicks") this.hush(); // other messages stay until the user does something
    if (this.waiting) this.busy(null);
    if (this.waiting && reply.good && this.scale) { this.waiting = false; this.go("points"); return; }
    this.waiting = false;
    this.live();
    this.paint();
  }

  async ask(message) { // a host that was started anew gets the picture again
    const reply = await this.transport.ask(message);
    if (reply.missing !== "picture" || !this.transport.store) return reply;
    const kept = await this.transport.store.read();
    if (!kept?.picture) return reply;
    const first = await this.transport.ask({ kind: "picture", name: kept.name }, await kept.picture.arrayBuffer());
    return first.good ? this.transport.ask(message) : first;
  }

  async finish() {
    if (!this.picture) return;
    const start = performance.now();
    this.finishing = true;
    this.busy("your hand is being made ...");
    const reply = await this.ask({ kind: "fit", clicks: this.clicks });
    this.busy(null);
    if (!reply.good) { if (this.step === "hand" || this.step === "photo") this.go(this.due()); this.finishing = true; this.say(reply); return; }
    this.finishing = false;
    this.stats.fit_ms = performance.now() - start;
    this.result = reply.result;
    this.go("hand");
  }

  async moveIt() {
    this.busy("the hand goes live ...");
    const reply = await this.ask({ kind: "move", clicks: this.clicks });
    this.busy(null);
    if (reply.good && this.transport.close) this.transport.close();
    else { this.say({ ...reply, text: reply.said ?? reply.text }); this.message.classList.toggle("good", !!reply.good); }
  }

  async guess() { // points are looked for in the outline; a person corrects them
    this.busy("looking for the points ...");
    const reply = await this.ask({ kind: "find", view: this.clicks.view });
    this.busy(null);
    if (!reply.good) { this.say(reply); return; }
    this.change(() => { this.clicks.landmarks = { ...reply.landmarks, ...this.clicks.landmarks }; });
    this.say({ text: "These are guesses. Drag every point to its place, above all the joints; then make the hand." });
  }

  async fetch(what) {
    const reply = await this.ask({ kind: "file", what });
    if (!reply.good) { this.say(reply); return; }
    const { name, mime, data } = reply.file;
    this.download(name, new Blob([Uint8Array.from(atob(data), (c) => c.charCodeAt(0))], { type: mime }));
  }

  savePoints(kind) {
    const stem = this.picture.name.replace(/\.\w+$/, "");
    const rows = Object.entries(this.clicks.landmarks).map(([name, at]) => (at ? `${name},${at[0]},${at[1]}` : `${name},,`));
    const text = kind === "csv" ? `name,x_px,y_px\n${rows.join("\n")}\n` : `${JSON.stringify(this.clicks, null, 1)}\n`;
    this.download(`${stem}-points.${kind}`, new Blob([text], { type: kind === "csv" ? "text/csv" : "application/json" }));
  }

  download(name, blob) {
    const link = make("a", { href: URL.createObjectURL(blob), download: name });
    this.root.append(link);
    link.click();
    link.remove();
    setTimeout(() => URL.revokeObjectURL(link.href), 20000);
  }

  // ---- the picture on the screen

  at(event) { const box = this.stage.getBoundingClientRect(); return [event.clientX - box.left, event.clientY - box.top]; }
  onPhoto([x, y]) { const { view } = this; return [(x - view.x) / view.s, (y - view.y) / view.s]; }
  onScreen([x, y]) { const { view } = this; return [x * view.s + view.x, y * view.s + view.y]; }

  whole() {
    if (!this.picture) return;
    const { clientWidth: w, clientHeight: h } = this.stage, { width, height } = this.picture;
    const s = Math.min((w - 24) / width, (h - 24) / height);
    if (!(s > 0)) return;
    this.view = { s, x: (w - s * width) / 2, y: (h - s * height) / 2 };
    this.moved = false;
    this.paint();
  }

  zoom(factor, around = [this.stage.clientWidth / 2, this.stage.clientHeight / 2]) {
    if (!this.picture) return;
    const { view } = this, least = 0.5 * Math.min(this.stage.clientWidth / this.picture.width, this.stage.clientHeight / this.picture.height);
    const s = Math.min(Math.max(view.s * factor, least), Math.max(12, 4 * least));
    this.view = { s, x: around[0] - (around[0] - view.x) * s / view.s, y: around[1] - (around[1] - view.y) * s / view.s };
    this.moved = true;
    this.paint();
  }

  pan(dx, dy) { this.view.x += dx; this.view.y += dy; this.moved = true; this.paint(); }

  marks() { // what can be dragged: [key, place]
    if (this.step === "scale") {
      const { ruler, coin, card } = this.clicks.scale;
      return [...(ruler ?? this.ruler).map((at, k) => [`ruler ${k}`, at]), ...(coin ? [["coin", coin]] : []), ...(card ? [["card", card]] : [])];
    }
    return this.step === "points" ? this.placed() : [];
  }

  down(event) {
    if (!this.picture || (event.target.closest && event.target.closest(".hf-zoom"))) return;
    this.stage.setPointerCapture(event.pointerId);
    this.stage.focus({ preventScroll: true });
    const place = this.at(event);
    this.fingers.set(event.pointerId, place);
    if (this.fingers.size > 1) { this.drag = null; this.pinched = true; this.hideLoupe(); return; }
    let found = null, best = event.pointerType === "touch" ? NEAR_TOUCH : NEAR;
    for (const [key, at] of event.button === 0 ? this.marks() : []) {
      const [x, y] = this.onScreen(at), far = Math.hypot(x - place[0], y - place[1]);
      if (far < best) { best = far; found = key; }
    }
    this.pinched = false;
    this.drag = { key: found, start: place, before: place, moved: false, click: event.button === 0 };
  }

  move(event) {
    const place = this.at(event), before = this.fingers.get(event.pointerId);
    if (!before) return;
    if (this.fingers.size === 2) {
      const other = [...this.fingers.entries()].find(([id]) => id !== event.pointerId)[1];
      const gap = (one) => Math.hypot(one[0] - other[0], one[1] - other[1]) || 1;
      this.pan((place[0] - before[0]) / 2, (place[1] - before[1]) / 2);
      this.zoom(gap(place) / gap(before), [(place[0] + other[0]) / 2, (place[1] + other[1]) / 2]);
      this.fingers.set(event.pointerId, place);
      return;
    }
    this.fingers.set(event.pointerId, place);
    const { drag } = this;
    if (!drag || (!drag.moved && Math.hypot(place[0] - drag.start[0], place[1] - drag.start[1]) < STILL)) return;
    drag.moved = true;
    if (drag.key) { drag.place = this.inside(this.onPhoto(place)); this.showLoupe(drag.place); this.paint(); }
    else this.pan(place[0] - drag.before[0], place[1] - drag.before[1]);
    drag.before = place;
  }

  up(event) {
    this.fingers.delete(event.pointerId);
    const { drag } = this;
    this.hideLoupe();
    if (!drag || this.pinched) return;
    this.drag = null;
    this.stats.actions += 1;
    if (drag.moved && drag.key) this.shift(drag.key, drag.place);
    else if (!drag.moved && drag.key && this.step === "points") { this.last = drag.key; this.paint(); }
    else if (!drag.moved && drag.click && !drag.key) {
      const at = this.onPhoto(drag.start);
      if (at[0] >= 0 && at[1] >= 0 && at[0] <= this.picture.width && at[1] <= this.picture.height) this.put(at);
      else if (this.step === "points" || this.step === "scale") this.say({ text: "That was beside the picture; nothing was changed." });
    }
  }

  inside([x, y]) { return [Math.min(Math.max(x, 0), this.picture.width), Math.min(Math.max(y, 0), this.picture.height)]; }

  shift(key, place) { // a mark goes elsewhere
    this.change(() => {
      if (key in this.clicks.landmarks) { this.clicks.landmarks = { ...this.clicks.landmarks, [key]: place }; this.last = key; return; }
      const [kind, k] = key.split(" "), { scale } = this.clicks;
      if (kind === "ruler" && scale.ruler) this.clicks.scale = { ...scale, ruler: scale.ruler.map((at, n) => (n === Number(k) ? place : at)) };
      else if (kind === "ruler") this.ruler = [place];
      else this.clicks.scale = { ...scale, [kind]: place };
    });
  }

  key(event) {
    event.stopPropagation(); // a notebook has its own meaning for these keys
    if (event.target.matches("input, select, button") && event.key !== "Escape") return;
    const step = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
    const at = step && this.last && this.clicks.landmarks[this.last];
    if (event.key === "Backspace" || (event.key === "z" && (event.ctrlKey || event.metaKey))) this.undo();
    else if (at && this.step === "points") { const far = NUDGE / this.view.s * (event.shiftKey ? 10 : 2); this.shift(this.last, this.inside([at[0] + far * step[0], at[1] + far * step[1]])); }
    else if (event.key === "s" && this.step === "points" && !event.ctrlKey && !event.metaKey) this.skip();
    else if (event.key === "+" || event.key === "=") this.zoom(1.25);
    else if (event.key === "-") this.zoom(0.8);
    else if (event.key === "0") this.whole();
    else return;
    event.preventDefault();
  }

  showLoupe(place) {
    const { loupe } = this, g = loupe.getContext("2d"), [sx, sy] = this.onScreen(place);
    const shown = this.img.naturalWidth / this.picture.width, wide = 2 * LOUPE * shown / (LARGER * 2 * this.view.s);
    loupe.hidden = false;
    loupe.classList.toggle("right", sx < LOUPE + 60 && sy < LOUPE + 60);
    g.fillStyle = "#10151b";
    g.fillRect(0, 0, loupe.width, loupe.height);
    g.drawImage(this.img, place[0] * shown - wide / 2, place[1] * shown - wide / 2, wide, wide, 0, 0, loupe.width, loupe.height);
    for (const [width, colour] of [[5, "#10151b"], [2, "#fff"]]) {
      g.lineWidth = width;
      g.strokeStyle = colour;
      g.beginPath();
      for (const [dx, dy] of [[1, 0], [-1, 0], [0, 1], [0, -1]]) { g.moveTo(LOUPE + 14 * dx, LOUPE + 14 * dy); g.lineTo(LOUPE + 54 * dx, LOUPE + 54 * dy); }
      g.stroke();
    }
  }

  hideLoupe() { this.loupe.hidden = true; }

  paint() {
    if (this.painting) return;
    this.painting = requestAnimationFrame(() => { this.painting = 0; this.paintNow(); });
  }

  paintNow() {
    const { picture, view, svg, img, clicks, drag } = this;
    svg.replaceChildren();
    img.style.display = picture && this.step !== "photo" ? "" : "none";
    if (!picture || this.step === "photo") return;
    img.style.width = `${picture.width * view.s}px`;
    img.style.height = `${picture.height * view.s}px`;
    img.style.transform = `translate(${view.x}px,${view.y}px)`;
    const outline = this.step === "hand" ? this.result?.outline : this.sketch?.outline;
    if (outline && this.step !== "scale") {
      const d = line(outline.map((at) => this.onScreen(at).map((one) => one.toFixed(1))));
      svg.append(draw("path", { d, class: "casing" }), draw("path", { d, class: "outline" }));
    }
    this.paintScale();
    if (this.step === "points") {
      const due = this.wanted(), guess = due && this.sketch?.places[due];
      if (guess) { const [cx, cy] = this.onScreen(guess); svg.append(draw("circle", { cx, cy, r: 15, class: "guess dark" }), draw("circle", { cx, cy, r: 15, class: "guess" })); }
    }
    if (this.step === "points" || this.step === "hand") {
      for (const [name, place] of this.placed()) this.ring(drag?.moved && drag.key === name ? drag.place : place, this.step === "hand" ? "small" : this.doubted?.includes(name) ? "bad" : name === this.last ? "last" : "", this.doubted?.includes(name) ? this.point(name).text : "");
    }
    if (clicks.landmarks) this.paintDrawing();
  }

  paintScale() {
    const { clicks, drag, svg, picture } = this, strong = this.step === "scale";
    const held = (key, at) => this.onScreen(drag?.moved && drag.key === key ? drag.place : at);
    const ends = (clicks.scale.ruler ?? this.ruler).map((at, k) => held(`ruler ${k}`, at));
    if (ends.length === 2) {
      const [[x1, y1], [x2, y2]] = ends;
      svg.append(draw("line", { x1, y1, x2, y2, class: "ruler dark" }), draw("line", { x1, y1, x2, y2, class: "ruler" }));
      if (clicks.scale.mm) { const left = (x1 + x2) / 2 < this.onScreen([picture.width / 2, 0])[0], text = draw("text", { x: (x1 + x2) / 2 + (left ? -12 : 12), y: (y1 + y2) / 2 + 5, "text-anchor": left ? "end" : "start" }); text.textContent = `${clicks.scale.mm} mm`; svg.append(text); }
    }
    for (const [x, y] of ends) {
      const d = `M${x - 11} ${y}h8m6 0h8M${x} ${y - 11}v8m0 6v8`;
      svg.append(draw("path", { d, class: "cross dark" }), draw("path", { d, class: "cross" }));
      if (strong) svg.append(draw("circle", { cx: x, cy: y, r: 11, class: "cross dark" }), draw("circle", { cx: x, cy: y, r: 11, class: "cross" }));
    }
    const coin = clicks.scale.coin ?? clicks.scale.card;
    if (coin) {
      const [cx, cy] = held(clicks.scale.coin ? "coin" : "card", coin), r = (this.scale?.radius_px ?? 0) * this.view.s || 9;
      svg.append(draw("circle", { cx, cy, r, class: "ruler dark" }), draw("circle", { cx, cy, r, class: "ruler" }));
    }
  }

  ring(place, kind, label) {
    const [cx, cy] = this.onScreen(place), r = kind === "small" ? 3.5 : kind === "last" ? 8 : 6.5;
    this.svg.append(draw("circle", { cx, cy, r: r + 2, class: `mark casing ${kind}` }), draw("circle", { cx, cy, r, class: `mark ring ${kind}` }), draw("circle", { cx, cy, r: 2, class: `mark core ${kind}` }));
    if (label) { const text = draw("text", { x: cx + 14, y: cy + 5, class: "bad" }); text.textContent = label; this.svg.append(text); }
  }

  // ---- the panel beside it

  panel() {
    const { step } = this;
    const done = { photo: !!this.picture, scale: !!this.clicks.view && this.scaled(), points: !!this.result, hand: false };
    for (const one of this.chapters.children) {
      one.className = `${one.dataset.step === step ? "now" : ""} ${done[one.dataset.step] ? "done" : ""}`;
      one.firstChild.disabled = !(one.dataset.step === "photo" || (this.picture && (one.dataset.step === "scale" || (one.dataset.step === "points" && done.scale) || (one.dataset.step === "hand" && this.placed().length >= 4 && done.scale))));
      one.firstChild.setAttribute("aria-current", one.dataset.step === step ? "step" : "false");
    }
    if (!this.told) return;
    const content = { photo: () => this.photoPanel(), scale: () => (this.clicks.view ? this.scalePanel() : this.viewPanel()), points: () => this.pointsPanel(), hand: () => this.handPanel() }[step]();
    this.side.replaceChildren(...content, this.message);
    const mm = this.side.querySelector("input[data-mm]"); // at once: what is typed next must go there, and nowhere else
    mm?.focus();
    mm?.select();
    this.live();
    this.paintDrawing();
  }

  photoPanel() {
    const drawing = this.told.drawings?.palmar;
    const cards = [["A ruler, a coin or a bank card beside the hand", "it lies flat, at the hand's height"], ["Palm or back, fingers apart", "on a plain ground, lighter or darker than skin"], ["The camera straight above", "half a metre or more away"]];
    return [make("div", { className: "hf-drop" },
      drawing ? make("img", { src: drawing.image, alt: "", className: "hf-welcome" }) : null,
      make("div", {}, make("h2", { textContent: "Drop a photograph of your hand here" }),
        push("Choose a photograph ...", () => this.file.click(), { className: "hf-main", data: { act: "choose" } }),
        make("ul", {}, ...cards.map(([head, text]) => make("li", {}, make("b", { textContent: head }), make("span", { textContent: text })))),
        make("p", { className: "faint", textContent: "JPEG, PNG, HEIC and more, up to 64 megapixels. It stays on this computer." }),
        this.transport.reference ? push("move the reference hand again", () => this.transport.reference(), { className: "hf-link" }) : null))];
  }

  viewPanel() {
    const choice = (view, text) => {
      const drawing = this.told.drawings?.[view];
      return make("button", { type: "button", className: "hf-choice", data: { view }, onclick: () => { this.stats.actions += 1; this.change(() => { this.clicks.view = view; }); this.go(this.due()); } }, drawing ? make("img", { src: drawing.image, alt: "" }) : null, make("b", { textContent: text }));
    };
    return [make("h2", { textContent: "What does the picture show?" }), make("div", { className: "hf-choices" }, choice("palmar", "the palm"), choice("dorsal", "the back")),
      make("p", { className: "faint", textContent: "Left or right: the points will tell." })];
  }

  scalePanel() {
    const kinds = { ruler: "Ruler", coin: "Coin", card: "Bank card" };
    const kind = (name) => push(kinds[name], () => { this.kind = name; this.panel(); }, { data: { kind: name }, aria: { pressed: String(this.kind === name) } });
    const head = { ruler: this.clicks.scale.ruler ? "How far apart are they?" : this.ruler.length ? "Click a second mark, far from the first" : "Click a mark on the ruler", coin: "Which coin? Then click on it", card: "Click on the card" }[this.kind];
    const more = [];
    if (this.kind === "ruler" && this.clicks.scale.ruler) {
      const mm = make("input", { type: "text", inputMode: "decimal", value: this.clicks.scale.mm ?? this.lastMm, data: { mm: "" }, aria: { label: "distance in millimetres" } });
      mm.onkeydown = (event) => { if (event.key === "Enter") { this.stats.actions += 1; this.setMm(mm.value); } };
      more.push(make("div", { className: "hf-mm" }, mm, make("span", { textContent: "mm" }), push("OK", () => { this.stats.actions += 1; this.setMm(mm.value); }, { className: "hf-main", data: { act: "mm" } })), make("p", { className: "faint", textContent: "10 cm = 100 mm; 1 inch = 25.4 mm." }));
    } else if (this.kind === "ruler") more.push(make("p", { textContent: "The wheel goes nearer. Far-off marks make the scale exact: 0 and 10 cm are good." }));
    else if (this.kind === "coin") more.push(make("select", { aria: { label: "coin" }, onchange: (event) => { this.coin = event.target.value; if (this.clicks.scale.coin) this.change(() => { this.clicks.scale = { ...this.clicks.scale, name: this.coin }; }); } }, ...this.told.coins.map((name) => make("option", { value: name, textContent: `${name} (${this.told.coin_mm[name]} mm)`, selected: name === this.coin }))));
    else more.push(make("p", { textContent: "Any card of 85.6 by 54 mm that lies flat and whole." }));
    return [make("div", { className: "hf-seg" }, kind("ruler"), kind("coin"), kind("card")), make("h2", { textContent: head }), ...more, this.tools(),
      push(`it is the ${this.clicks.view === "palmar" ? "back" : "palm"}, not the ${this.clicks.view === "palmar" ? "palm" : "back"}`, () => this.change(() => { this.clicks.view = this.clicks.view === "palmar" ? "dorsal" : "palmar"; }), { className: "hf-link" })];
  }

  pointsPanel() {
    const name = this.wanted(), one = name && this.point(name), total = this.told.points.length, placed = this.placed().length;
    this.drawing = draw("svg", { viewBox: "0 0 560 560", class: "hf-drawing", role: "img", "aria-label": one ? `Drawing: ${one.text}` : "Drawing of the hand" });
    this.info = make("div", { className: "hf-info" });
    const enough = this.told.points.filter(({ main, name: own }) => main && this.clicks.landmarks[own]).length;
    const done = push("Make the hand", () => { this.stats.actions += 1; this.finish(); }, { className: name && enough < 16 ? "hf-btn" : "hf-main", disabled: placed < 4, data: { act: "fit" }, title: "16 well chosen points do, 26 are better" });
    return [make("div", { className: "hf-ask" }, this.drawing,
      make("div", { className: "hf-words" }, make("small", { textContent: name ? `${placed + 1} of ${total}` : `${placed} points` }), make("h2", { textContent: one ? one.text : "All points are there" }),
        make("p", { textContent: one ? (this.clicks.view === "palmar" ? one.palm : one.hint) : "Drag a point to correct it." }))),
    make("div", { className: "hf-bar" }, ...this.told.points.map(({ name: own }) => make("i", { className: own === name ? "now" : this.clicks.landmarks[own] ? "done" : own in this.clicks.landmarks ? "skipped" : "" }))),
    this.tools(placed ? null : push("guess all", () => { this.stats.actions += 1; this.guess(); }, { className: "hf-btn", data: { act: "find" }, title: "look for the points in the outline of the hand; you correct them" }), push("skip", () => { this.stats.actions += 1; this.skip(); }, { className: "hf-btn", disabled: !name, data: { act: "skip" }, title: "leave this point out (S)" }), done), this.info, this.files()];
  }

  tools(...more) {
    return make("div", { className: "hf-tools" }, push("undo", () => { this.stats.actions += 1; this.undo(); }, { className: "hf-btn", disabled: !this.history.length, data: { act: "undo" }, title: "take the last change back (Backspace)" }), ...more);
  }

  files() {
    return make("details", { className: "hf-more" }, make("summary", { textContent: "more" }),
      make("div", {}, push("save points (.csv)", () => this.savePoints("csv"), { className: "hf-link", data: { act: "csv" } }), push("save points (.json)", () => this.savePoints("json"), { className: "hf-link", data: { act: "json" } }), push("open points ...", () => this.table.click(), { className: "hf-link" }),
        push("all points anew", () => { this.change(() => { this.clicks.landmarks = {}; this.clicks.sure = false; this.sketch = null; }); this.hush(); }, { className: "hf-link" }),
        push(this.clicks.mirror ? "the picture is not mirrored" : "the picture is mirrored (selfie)", () => this.change(() => { this.clicks.mirror = !this.clicks.mirror; }), { className: "hf-link" }),
        this.cameraField()));
  }

  cameraField(then = () => {}) {
    const { camera_mm: said } = this.clicks, known = said ?? this.result?.camera_mm, scan = said === 0 || (!known && !!this.result);
    const put = (mm) => { this.change(() => { this.clicks.camera_mm = mm; }); then(); };
    const camera = make("input", { type: "text", inputMode: "decimal", value: known ? Math.round(known / 10) : "", placeholder: "?", data: { camera: "" }, aria: { label: "height of the camera above the table in centimetres" } });
    camera.onchange = () => put(camera.value.trim() ? 10 * Number(camera.value.replace(",", ".")) : null);
    return make("div", { className: "hf-camera" }, scan ? make("span", { textContent: "a scan, without perspective" }) : make("label", {}, "camera ", camera, " cm above the table"), push(scan ? "it is a photograph" : "it is a scan", () => put(scan ? 600 : 0), { className: "hf-link" }));
  }

  handPanel() {
    const { result } = this, lengths = new Map(result.lengths.map(([name, own, reference]) => [name, [own, reference]]));
    const cell = ([own, reference]) => make("td", {}, make("b", { textContent: own.toFixed(0) }), make("small", { textContent: reference.toFixed(0) }));
    const rows = FINGERS.map((finger) => make("tr", {}, make("th", { textContent: finger }), ...BONES.map((bone) => (lengths.has(`${finger}, ${bone}`) ? cell(lengths.get(`${finger}, ${bone}`)) : make("td")))));
    const shown = `${result.view === "palmar" ? "palm" : "back"} of a ${result.side} hand`;
    const camera = this.cameraField(() => this.finish());
    return [make("div", { className: "hf-head" }, make("b", { textContent: `${result.hand_mm[0].toFixed(0)} mm` }), make("span", { textContent: `wrist to middle fingertip; the reference hand has ${result.hand_mm[1].toFixed(0)} mm` })),
      make("div", { className: "hf-chips" }, make("span", { textContent: shown }), make("span", { textContent: `${result.points} points${result.outlined ? " and the outline" : ""}` }), result.iou === null ? null : make("span", { className: "iou", textContent: `overlap ${percent(result.iou)}` })),
      push("Move it", () => { this.stats.actions += 1; this.moveIt(); }, { className: "hf-main big", data: { act: "move" } }),
      make("table", {}, make("caption", { textContent: "Bones in mm, the reference hand's below" }), make("thead", {}, make("tr", {}, make("th"), ...["metacarpal", "proximal", "middle", "distal"].map((text) => make("th", { textContent: text })))), make("tbody", {}, ...rows)),
      make("p", { className: "faint", textContent: `Size L = ${result.growth.toFixed(2)}: its muscles pull ${result.laws[1][2].toFixed(2)} times as hard, and its bones resist turning ${result.laws[3][2].toFixed(2)} times as much.` }),
      ...result.notes.map((text) => make("p", { className: "note", textContent: text })),
      result.camera === "assumed" ? make("div", { className: "note" }, make("p", { textContent: "The picture does not say how far the camera was; this is assumed:" }), camera) : camera,
      result.outlined || !this.clicks.outline ? push(result.outlined ? "shape it by the points alone" : "follow the outline in the picture", () => { this.change(() => { this.clicks.outline = !this.clicks.outline; }); this.finish(); }, { className: "hf-link", data: { act: "outline" } }) : null,
      make("div", { className: "hf-tools" }, push("save the hand", () => this.fetch("hand"), { className: "hf-btn", data: { act: "hand" } }), push("save the picture", () => this.fetch("picture"), { className: "hf-btn", data: { act: "picture" } }), push("save the report", () => this.fetch("report"), { className: "hf-btn", data: { act: "report" } }), push("correct points", () => this.go("points"), { className: "hf-btn", data: { act: "correct" } }))];
  }

  live() {
    if (!this.info?.isConnected) return;
    const { sketch } = this;
    if (!sketch) { this.info.replaceChildren(make("span", { textContent: this.placed().length < 4 ? "The outline shows from the fourth point on." : "No outline yet: are all points where they belong?" })); return; }
    this.info.replaceChildren(make("span", { textContent: `${sketch.view === "palmar" ? "palm" : "back"} of a ${sketch.side} hand` }), sketch.iou === null ? make("span", { textContent: "no overlap: the ground looks like skin" }) : make("span", { className: "iou", textContent: `overlap ${percent(sketch.iou)}` }));
  }

  // The drawing lies as the picture does: mirrored for the other hand, turned in quarter turns.
  paintDrawing() {
    if (!this.drawing?.isConnected || this.step !== "points" || !this.told.drawings) return;
    const { image, width, height, places } = this.told.drawings[this.clicks.view ?? "palmar"], wanted = this.wanted();
    const { flip, turn } = this.lie(places, width, height);
    const g = draw("g", { transform: `translate(280 280) rotate(${turn}) scale(${flip ? -1 : 1} 1) translate(${-width / 2} ${-height / 2})` }, draw("image", { href: image, width, height }));
    for (const [name, [u, v]] of Object.entries(places)) {
      const state = name === wanted ? "now" : this.clicks.landmarks[name] ? "done" : name in this.clicks.landmarks ? "skipped" : "due";
      const dot = draw("circle", { cx: u * width, cy: v * height, r: state === "now" ? 17 : state === "due" ? 6 : 9, class: state, "data-point": name });
      if (state === "now") g.append(draw("circle", { cx: u * width, cy: v * height, r: 17, class: "pulse" }));
      dot.append(draw("title"));
      dot.firstChild.textContent = this.point(name).text;
      dot.addEventListener("click", () => { if (name !== this.wanted()) this.again(name); });
      g.append(dot);
    }
    this.drawing.replaceChildren(g);
  }

  lie(places, width, height) {
    const pairs = this.placed().map(([name, at]) => [[places[name][0] * width, places[name][1] * height], at]);
    const other = this.sketch ? (this.sketch.side === "left") !== !!this.clicks.mirror : null;
    if (pairs.length < 3) return { flip: other ?? false, turn: 0 };
    const [plain, mirrored] = [false, true].map((flip) => {
      const a = pairs.map(([[x, y]]) => [flip ? -x : x, y]), b = pairs.map(([, at]) => at), n = pairs.length;
      const mean = (all) => [0, 1].map((k) => all.reduce((sum, one) => sum + one[k], 0) / n), [p, q] = [mean(a), mean(b)];
      let re = 0, im = 0, size = 0;
      a.forEach(([x, y], k) => { const [u, v, s, t] = [x - p[0], y - p[1], b[k][0] - q[0], b[k][1] - q[1]]; re += u * s + v * t; im += u * t - v * s; size += u * u + v * v; });
      return { flip, turn: 90 * Math.round(Math.atan2(im, re) / (Math.PI / 2)), fits: (re * re + im * im) / size };
    });
    return (other ?? mirrored.fits > plain.fits) ? mirrored : plain;
  }

  // ---- words

  say({ text, names = [], choices = [] }, from = "page") {
    this.from = from;
    this.doubted = names;
    this.message.replaceChildren(make("p", { textContent: text }), ...choices.map(({ label, answer }) => push(label, () => { this.stats.actions += 1; this.answer(answer); }, { className: "hf-btn" })));
    this.message.hidden = false;
    this.message.classList.remove("good");
    if (!this.message.isConnected) this.side.append(this.message);
    this.paint();
  }

  hush() { this.message.hidden = true; this.doubted = null; this.finishing = false; }

  busy(text) {
    this.waitBox?.remove();
    this.waitBox = text && make("div", { className: "hf-wait", textContent: text, aria: { role: "status" } });
    if (text) this.root.append(this.waitBox);
  }
}

const STYLE = `
.hf { --ink:#1F2933; --faint:#5b6773; --rule:#D5DBE1; --blue:#0072B2; --sky:#56B4E9; --vermilion:#D55E00;
  position:relative; display:grid; grid-template:auto minmax(0,1fr) / minmax(0,1fr) minmax(330px,27%); width:100%; height:100%; min-height:420px; box-sizing:border-box; overflow:hidden;
  background:#fff; color:var(--ink); font:16px/1.4 system-ui,-apple-system,"Segoe UI","Noto Sans",sans-serif; text-align:left; outline:none; }
.hf[data-size=large] { font-size:20px; }
.hf *, .hf *::before { box-sizing:border-box; } .hf button, .hf input, .hf select { font:inherit; color:inherit; margin:0; }
.hf :focus-visible { outline:3px solid var(--sky); outline-offset:1px; } .hf [hidden] { display:none !important; }
.hf > header { grid-column:1 / -1; display:flex; align-items:center; gap:18px; padding:9px 16px; border-bottom:1px solid var(--rule); min-width:0; }
.hf h1 { font-size:1.25em; font-weight:650; margin:0; padding:0; border:0; white-space:nowrap; color:inherit; } .hf h2 { font-size:1.3em; line-height:1.25; font-weight:650; margin:0; padding:0; border:0; color:inherit; }
.hf p { margin:0; } .hf .faint { color:var(--faint); font-size:.88em; } .hf .note { font-size:.88em; border-left:3px solid #E69F00; padding:1px 0 1px 10px; }
.hf-steps { display:flex; gap:6px; list-style:none; margin:0; padding:0; flex:1; min-width:0; overflow:auto; scrollbar-width:none; }
.hf-steps li { margin:0; } .hf-steps button { border:0; background:none; padding:5px 12px; border-radius:99px; cursor:pointer; color:var(--faint); white-space:nowrap; }
.hf-steps .done button { color:var(--blue); } .hf .hf-steps .now button { background:var(--blue); color:#fff; } .hf-steps button:disabled { cursor:default; opacity:.55; }
.hf-steps li:not(.now) button:not(:disabled):hover { background:#e8f1f8; }
.hf .hf-btn, .hf-seg, .hf-zoom { border:1px solid #b9c2cb; border-radius:8px; background:#fff; } .hf .hf-btn { padding:.35em .75em; cursor:pointer; white-space:nowrap; } .hf .hf-btn:hover:not(:disabled) { background:#e8f1f8; }
.hf .hf-main { border:0; border-radius:8px; padding:.45em 1em; background:var(--blue); color:#fff; font-weight:600; cursor:pointer; } .hf .hf-main:hover:not(:disabled) { background:#005f95; } .hf .hf-main.big { font-size:1.25em; padding:.5em 1em; width:100%; }
.hf .hf-link { border:0; background:none; padding:2px 0; color:var(--blue); cursor:pointer; text-align:left; text-decoration:underline; text-underline-offset:3px; align-self:flex-start; font-size:.92em; }
.hf button:disabled { opacity:.45; cursor:default; }
.hf-seg { display:inline-flex; overflow:hidden; align-self:flex-start; } .hf-seg button { border:0; background:none; padding:.35em .9em; cursor:pointer; } .hf-seg button + button { border-left:1px solid var(--rule); } .hf .hf-seg button[aria-pressed=true] { background:var(--blue); color:#fff; }
.hf-stage { position:relative; overflow:hidden; background:#20262d; touch-action:none; cursor:crosshair; min-height:0; user-select:none; } .hf-stage:focus-visible { outline:2px solid rgba(86,180,233,.55); outline-offset:-2px; }
.hf-stage img { position:absolute; left:0; top:0; transform-origin:0 0; max-width:none; margin:0; pointer-events:none; box-shadow:0 0 0 1px rgba(255,255,255,.25); }
.hf-stage > svg { position:absolute; inset:0; width:100%; height:100%; pointer-events:none; overflow:hidden; }
.hf-stage svg path.casing { fill:none; stroke:#0b141c; stroke-opacity:.75; stroke-width:5.5; stroke-linejoin:round; } .hf-stage svg path.outline { fill:rgba(86,180,233,.05); stroke:var(--sky); stroke-width:2.6; stroke-linejoin:round; }
.hf-stage svg .mark { fill:none; } .hf-stage svg .mark.casing { stroke:#0b141c; stroke-width:2; stroke-opacity:.8; } .hf-stage svg .mark.ring { stroke:#fff; stroke-width:2.4; } .hf-stage svg .mark.core { fill:#fff; stroke:#0b141c; stroke-width:1; }
.hf-stage svg .mark.ring.last { stroke:#F0E442; stroke-width:3; } .hf-stage svg .mark.ring.bad { stroke:#FF7A2F; stroke-width:4; } .hf-stage svg .mark.ring.small { stroke-width:1.6; } .hf-stage svg .mark.core.small { r:0; }
.hf-stage svg .guess { fill:none; stroke:#fff; stroke-width:2; stroke-dasharray:4 5; } .hf-stage svg .guess.dark { stroke:#0b141c; stroke-width:4; stroke-dasharray:none; opacity:.35; }
.hf-stage svg .ruler { fill:none; stroke:#E69F00; stroke-width:2.4; } .hf-stage svg .cross { fill:none; stroke:#E69F00; stroke-width:2.4; } .hf-stage svg .dark:not(.guess) { stroke:#0b141c; stroke-width:5; stroke-opacity:.7; }
.hf-stage svg text { font-size:15px; font-weight:650; fill:#fff; stroke:#0b141c; stroke-width:4; paint-order:stroke; } .hf-stage svg text.bad { fill:#FFB38A; }
.hf-zoom { position:absolute; left:12px; bottom:12px; display:flex; overflow:hidden; } .hf-zoom button { border:0; background:rgba(255,255,255,.92); padding:4px 12px; cursor:pointer; min-width:38px; } .hf-zoom button + button { border-left:1px solid var(--rule); } .hf-zoom button:hover { background:#e8f1f8; }
.hf-loupe { position:absolute; left:12px; top:12px; width:150px; height:150px; border-radius:50%; border:3px solid #fff; box-shadow:0 2px 14px rgba(0,0,0,.5); pointer-events:none; } .hf-loupe.right { left:auto; right:12px; }
.hf-side { display:flex; flex-direction:column; gap:.7em; padding:16px; border-left:1px solid var(--rule); overflow:auto; min-height:0; min-width:0; scrollbar-width:thin; }
.hf-side > * { flex:none; }
.hf[data-step=photo] .hf-stage { display:none; } .hf[data-step=photo] .hf-side { grid-column:1 / -1; border:0; align-items:center; justify-content:safe center; background:#eef2f5; }
.hf-drop { display:flex; align-items:center; gap:36px; background:#fff; border:3px dashed #9fb0bf; border-radius:22px; padding:32px 48px; max-width:min(980px,100%); } .hf.over .hf-drop { border-color:var(--blue); background:#e8f3fa; } .hf.over .hf-stage { box-shadow:inset 0 0 0 5px var(--sky); }
.hf-drop > div { display:flex; flex-direction:column; gap:1em; align-items:flex-start; } .hf-drop h2 { font-size:1.6em; } .hf-welcome { height:min(46vh,430px); } .hf-drop .hf-main { font-size:1.15em; }
.hf-drop ul { list-style:none; padding:0; margin:0; display:grid; gap:.55em; } .hf-drop li { margin:0; padding-left:1.1em; position:relative; } .hf-drop li::before { content:""; position:absolute; left:0; top:.5em; width:.5em; height:.5em; border-radius:50%; background:var(--sky); } .hf-drop li b { display:block; font-weight:600; } .hf-drop li span { color:var(--faint); }
.hf-choices { display:grid; grid-template-columns:1fr 1fr; gap:10px; } .hf .hf-choice { display:flex; flex-direction:column; align-items:center; gap:8px; padding:14px 6px; border:2px solid var(--rule); border-radius:14px; background:#fff; cursor:pointer; } .hf .hf-choice:hover { border-color:var(--blue); background:#f1f8fc; } .hf-choice img { max-width:100%; max-height:34vh; } .hf-choice b { font-size:1.15em; }
.hf-mm { display:flex; gap:8px; align-items:center; } .hf .hf-mm input { width:5.5em; font-size:1.3em; padding:.2em .4em; border:2px solid var(--blue); border-radius:8px; text-align:right; } .hf-side select { padding:.35em; border:1px solid #b9c2cb; border-radius:8px; background:#fff; max-width:100%; }
.hf-ask { display:flex; flex-direction:column; gap:.5em; } .hf-drawing { width:100%; height:min(44vh,420px); background:linear-gradient(#eef2f5,#fff); border-radius:14px; overflow:visible; } .hf-words small { color:var(--faint); font-size:.9em; } .hf-words p { color:var(--faint); } .hf-words { min-height:5.6em; }
.hf-drawing circle { stroke:#fff; stroke-width:2; cursor:pointer; } .hf-drawing .due { fill:rgba(31,41,51,.30); stroke-width:1.5; } .hf-drawing .due:hover, .hf-drawing .done:hover, .hf-drawing .skipped:hover { stroke:var(--vermilion); stroke-width:4; } .hf-drawing .done { fill:var(--blue); } .hf-drawing .skipped { fill:#fff; stroke:var(--faint); stroke-dasharray:3 2; } .hf-drawing .now { fill:var(--vermilion); stroke-width:4; cursor:default; }
.hf-drawing .pulse { fill:none; stroke:var(--vermilion); stroke-width:4; transform-box:fill-box; transform-origin:center; animation:hf-pulse 1.3s ease-out infinite; pointer-events:none; } @keyframes hf-pulse { from { transform:scale(1); opacity:.9; } to { transform:scale(2.6); opacity:0; } }
@media (prefers-reduced-motion:reduce) { .hf-drawing .pulse { animation:none; } }

.hf-camera { display:flex; flex-wrap:wrap; gap:.2em 1em; font-size:.88em; color:var(--faint); } .hf .hf-camera .hf-link { font-size:1em; }
.hf-bar { display:flex; gap:2px; } .hf-bar i { flex:1; height:7px; border-radius:3px; background:#dde3e9; } .hf-bar .done { background:var(--blue); } .hf-bar .now { background:var(--vermilion); } .hf-bar .skipped { background:#aab5bf; }
.hf-tools { display:flex; flex-wrap:wrap; gap:8px; } .hf-info { display:flex; flex-wrap:wrap; gap:.3em 1em; color:var(--faint); min-height:1.4em; } .hf .iou { font-weight:650; color:#006d4f; font-variant-numeric:tabular-nums; }
.hf-more summary { cursor:pointer; color:var(--faint); } .hf-more > div { display:grid; gap:4px; padding:6px 0 0 14px; } .hf-side label input { width:4.2em; padding:.15em .4em; border:1px solid #b9c2cb; border-radius:6px; text-align:right; }
.hf-head b { font-size:2.5em; line-height:1; display:block; } .hf-head span { color:var(--faint); } .hf-chips { display:flex; flex-wrap:wrap; gap:.35em; } .hf-chips span { background:#eef2f5; border-radius:99px; padding:.15em .8em; font-size:.92em; } .hf-chips .iou { background:#e3f4ed; }
.hf table { border-collapse:collapse; width:100%; font-variant-numeric:tabular-nums; margin:0; border:0; } .hf caption { text-align:left; font-weight:600; padding:0 0 4px; caption-side:top; } .hf th { font-weight:400; text-align:left; padding:3px 4px 3px 0; font-size:.92em; background:none; } .hf thead th { text-align:right; color:var(--faint); font-size:.82em; } .hf td { text-align:right; padding:2px 0; border-top:1px solid var(--rule); line-height:1.15; background:none; } .hf tbody th { border-top:1px solid var(--rule); } .hf td b { display:block; font-weight:650; } .hf td small { color:var(--faint); font-size:.78em; }
.hf-say { background:#fff4ea; border:1px solid #f0b58a; border-left:5px solid var(--vermilion); border-radius:8px; padding:.6em .8em; display:flex; flex-direction:column; gap:.5em; align-items:flex-start; order:-1; position:sticky; top:0; z-index:3; box-shadow:0 4px 14px rgba(31,41,51,.14); } .hf-say .hf-btn { white-space:normal; text-align:left; }
.hf-say.good { background:#e8f6ef; border-color:#8fcbb0; border-left-color:#009E73; } .hf[data-step=photo] .hf-say { position:static; max-width:760px; }
.hf-wait { position:absolute; left:50%; top:50%; transform:translate(-50%,-50%); background:#1f2933; color:#fff; padding:.7em 1.4em; border-radius:10px; z-index:9; box-shadow:0 6px 30px rgba(0,0,0,.35); }
.hf[data-size=small] { grid-template:auto minmax(0,1fr) auto / minmax(0,1fr); } .hf[data-size=small] > header { flex-wrap:wrap; gap:4px 10px; padding:6px 10px; } .hf[data-size=small] .hf-steps { order:3; flex-basis:100%; } .hf[data-size=small] .hf-steps button { padding:3px 8px; font-size:.86em; } .hf[data-size=small] h1 { flex:1; font-size:1.1em; }
.hf[data-size=small] .hf-side { border-left:0; border-top:1px solid var(--rule); max-height:48vh; padding:10px; gap:.5em; } .hf[data-size=small][data-step=photo] .hf-side { max-height:none; } .hf[data-size=small] .hf-drop { flex-direction:column; padding:20px; gap:14px; } .hf[data-size=small] .hf-welcome { height:20vh; }
.hf[data-size=small] .hf-ask { flex-direction:row; align-items:center; } .hf[data-size=small] .hf-drawing { width:150px; height:150px; flex:none; } .hf[data-size=small] .hf-words h2 { font-size:1.1em; } .hf[data-size=small] .hf-choice img { max-height:18vh; } .hf[data-size=small][data-step=hand] .hf-side { max-height:60vh; }
.hf.low:not([data-size=small]) .hf-drawing { height:34vh; } .hf[data-size=middle] .hf-side { container-type:size; } .hf[data-size=middle] .hf-drawing { height:min(44vh,420px,max(40cqh,150px)); } .hf.low:not([data-size=small]) .hf-welcome { height:34vh; } .hf.low .hf-drop { padding:18px 28px; }
`;
