// The viewer: the hand in 3D with its muscles, clips, joints and curves.
//
//   const api = await mount(element, transport, options)
//
// transport: { scene: Promise of what wire.scene() packs, send(message), onMessage(callback) }, messages as in session.py; frames and
//   the `data` of messages are bytes. `ticks: "client"`: the host answers {kind: "tick"} and has no clock. `recorded: true`: nothing can be set.
// options: { skin, bones, view, layers: ["muscles", "tendons"], panels: false, embedded: true (a wheel scrolls the page until the hand is clicked), play: clip name }

import { Hand3D, asBytes, unpackFrame, unpackScene } from "./hand3d.js";
import { make } from "./nodes.js";
import { MOST_LINES, Track, drawCurves } from "./plots.js";
import { STYLE } from "./style.js";

const PANEL_MS = 80; // numbers and sliders need not change faster
const CURVE_MS = 100;
const SLOW_MS = 450; // both, where the processor draws everything
const MARK_MS = 100; // there, between two steps of the line that marks the time
const TICK_TIMEOUT_MS = 3000;
const SAY_MS = 6000;
const DEGREES = 180 / Math.PI;
const PLAY = '<svg viewBox="0 0 16 16" aria-hidden="true"><path d="M3 1l11 7-11 7z"/></svg>';
const PAUSE = '<svg viewBox="0 0 16 16" aria-hidden="true"><path d="M2 1h4v14H2zM10 1h4v14h-4z"/></svg>';
const LOCK = '<svg class="open" viewBox="0 0 16 16" aria-hidden="true"><path d="M11 7V4a3 3 0 0 0-6 0h1.5a1.5 1.5 0 0 1 3 0v3H3v8h10V7z"/></svg>'
  + '<svg class="shut" viewBox="0 0 16 16" aria-hidden="true"><path d="M11 7V4.5a3 3 0 0 0-6 0V7H3v8h10V7zM6.5 7V4.5a1.5 1.5 0 0 1 3 0V7z"/></svg>';
const EXPORTS = { png: "Picture (.png)", mp4: "Film (.mp4)", gif: "Moving picture (.gif)", glb: "3D, animated (.glb)", html: "Page that plays (.html)", csv: "Table (.csv)" };

const button = (text, click, properties = {}) => make("button", { type: "button", textContent: text, onclick: click, ...properties });
const capital = (text) => text.charAt(0).toUpperCase() + text.slice(1);
const press = (node, on) => { const text = String(on); if (node.getAttribute("aria-pressed") !== text) node.setAttribute("aria-pressed", text); };

const WEAR = { blend: "bones alone move the skin", springs: "the skin is a net of masses and springs on the bones", "springs and muscles": "and muscles below it lift it when they swell" };
const USED = { both: "both", pseudo: "pseudo", geometric: "geometric" };

export async function mount(element, transport, options = {}) {
  if (!document.getElementById("handlab-style")) document.head.append(make("style", { id: "handlab-style", textContent: STYLE }));
  const root = make("div", { className: "hl", data: { lmSuppressShortcuts: "true", tab: "muscles" } }, make("div", { className: "hl-wait", textContent: "the hand is coming ..." }));
  if (options.panels === false) root.dataset.panels = "none";
  element.replaceChildren(root);
  const early = [];
  let viewer = null;
  const stop = transport.onMessage((message) => (viewer ? viewer.receive(message) : early.push(message)));
  try {
    const given = await transport.scene;
    const scene = given.arrays ? given : unpackScene(given);
    root.replaceChildren();
    viewer = new Viewer(root, scene, transport, options);
    early.forEach((message) => viewer.receive(message));
    viewer.begin();
  } catch (error) {
    root.replaceChildren(make("div", { className: "hl-wait", textContent: `The hand cannot be shown: ${error.message}` }));
    throw error;
  }
  const api = viewer.api(() => { stop?.(); viewer.dispose(); element.replaceChildren(); });
  element.handlab = api;
  return api;
}

class Viewer {
  constructor(root, scene, transport, options) {
    Object.assign(this, { root, scene, transport, options });
    this.status = { clip: "", seconds: 0, playing: false, speed: 1, loop: false, hold: [], recording: false, wear: "blend", muscles: "both", soft: false };
    this.frame = null;
    this.track = new Track(scene.muscles.length + scene.dofs.length);
    this.pinned = { muscle: new Set(), dof: new Set() };
    this.wanted = new Map(); // slider values not yet sent
    this.asked = 0;
    this.sentAt = new Map();
    this.stats = { frames: 0, bytes: 0, latency_ms: [], first_ms: 0 };
    this.held = null; // the slider under the user's finger
    this.build();
    this.listen();
  }

  // ---- building

  build() {
    const { root, scene, options } = this;
    this.canvas = make("canvas", { tabIndex: 0, aria: { label: "The hand in 3D. Arrow keys turn it, plus and minus zoom, digits 1 to 5 choose a view." } });
    this.canvas.setAttribute("role", "img");
    this.stage = make("div", { className: "hl-stage" }, this.canvas);
    root.append(this.muscles(), this.stage, this.player(), this.curves(), this.joints(), this.tabs());
    const asked = options.layers || [];
    this.hand = new Hand3D(this.canvas, scene, { skin: options.skin || "solid", bones: options.bones !== false, view: options.view || "palm", muscles: asked.includes("muscles"), tendons: asked.includes("tendons") });
    this.hand.ondraw = () => this.drawn();
    this.stage.append(this.looks(), this.actions(), (this.tag = make("div", { className: "hl-tag", hidden: true })));
    this.stage.append((this.saying = make("div", { className: "hl-say", hidden: true })));
    this.saying.setAttribute("role", "status");
    this.showLook();
  }

  muscles() {
    const { scene } = this;
    const list = make("div", { className: "hl-list" });
    this.rows = [];
    for (const region of scene.regions) {
      const heading = make("h3", {}, make("i"), capital(region.name));
      heading.firstChild.style.background = region.colour;
      const section = make("section", {}, heading);
      scene.muscles.forEach((muscle, k) => {
        if (muscle.region !== region.name) return;
        const who = button(muscle.short, () => this.pin("muscle", k), { className: "who", title: `${muscle.title}: draw its curve`, aria: { pressed: "false" } });
        const slider = make("input", { type: "range", min: 0, max: 100, step: 1, value: 0, tabIndex: this.transport.recorded ? -1 : 0, aria: { label: `${muscle.title} (${muscle.short}), contraction in percent`, disabled: String(!!this.transport.recorded) }, data: { muscle: muscle.short } });
        slider.oninput = () => this.slide(k);
        slider.onpointerdown = () => { this.held = k; };
        slider.onpointerup = slider.onpointercancel = slider.onchange = () => { this.held = null; };
        const output = make("output", { textContent: "0 %" });
        const row = make("div", { className: "hl-row", data: { muscle: muscle.short } }, who, slider, output);
        row.style.setProperty("--tint", region.colour);
        row.onpointerenter = () => this.about(k);
        row.onfocusin = () => this.about(k);
        this.rows[k] = { row, who, slider, output, shown: 0 };
        section.append(row);
      });
      list.append(section);
    }
    this.none = make("div", { className: "hl-none", hidden: true, textContent: "no muscle of this name" });
    list.append(this.none);
    this.search = make("input", { type: "search", placeholder: "search: FDP2, lumbrical, thumb ...", aria: { label: "Search muscles by name or abbreviation" }, oninput: () => this.filter() });
    this.more = make("div", { className: "hl-more" });
    this.about(-1);
    return make("aside", { className: "hl-side m", aria: { label: "Muscles" } },
      make("header", {}, make("h2", {}, "Muscles", make("small", { textContent: this.transport.recorded ? "recorded" : "contraction" })), this.search), list, this.more);
  }

  joints() {
    const { scene } = this;
    const list = make("div", { className: "hl-list" });
    this.dofRows = [];
    this.locks = new Map();
    let digit = "", section = null;
    for (const joint of [...scene.joints].sort((a, b) => DIGITS.indexOf(a.digit) - DIGITS.indexOf(b.digit))) {
      if (joint.digit !== digit) {
        digit = joint.digit;
        section = make("section", {}, make("h3", { textContent: capital(digit) }));
        list.append(section);
      }
      joint.dofs.forEach((k, n) => {
        const dof = scene.dofs[k];
        const code = joint.name === "wrist" ? "" : `${joint.name.replace(/\d/, "").toUpperCase()} `;
        let first = make("span");
        if (n === 0) {
          first = make("button", { type: "button", className: "hl-lock", innerHTML: LOCK, title: `hold the ${joint.title}`, aria: { pressed: "false", label: `hold ${joint.name}` }, disabled: !!this.transport.recorded, data: { joint: joint.name }, onclick: () => this.hold(joint.name) });
          this.locks.set(joint.name, first);
        }
        const who = button(code + dof.motion, () => this.pin("dof", k), { className: "who", title: `${joint.title}: ${dof.positive} +, ${dof.negative} -; ${Math.round(dof.limits[0] * DEGREES)}° to ${Math.round(dof.limits[1] * DEGREES)}°${dof.driver ? `; follows ${dof.driver}` : ""}. Click: draw its curve`, aria: { pressed: "false" } });
        const bar = make("b"), zero = make("i"), output = make("output", { textContent: "0°" });
        const span = dof.limits[1] - dof.limits[0] || 1;
        zero.style.left = `${Math.min(Math.max(-dof.limits[0] / span, 0), 1) * 100}%`;
        const row = make("div", { className: `hl-row j${dof.driver ? " follows" : ""}`, data: { dof: dof.name } }, first, who, make("div", { className: "hl-range" }, bar, zero), output);
        this.dofRows[k] = { row, who, bar, output, shown: null, low: dof.limits[0], span, zero: Math.min(Math.max(-dof.limits[0] / span, 0), 1) };
        section.append(row);
      });
    }
    return make("aside", { className: "hl-side j", aria: { label: "Joint angles" } },
      make("header", {}, make("h2", {}, "Joint angles", make("small", { textContent: "degrees; lock = hold" }))), list);
  }

  player() {
    this.chips = make("div", { className: "hl-chips" });
    this.chips.setAttribute("role", "group");
    this.chips.setAttribute("aria-label", "Clips");
    this.listClips(this.scene.clips);
    this.go = make("button", { type: "button", className: "go", innerHTML: PLAY, aria: { label: "play" }, onclick: () => this.playOrPause() });
    this.scrub = make("input", { type: "range", min: 0, max: 1, step: 0.001, value: 0, disabled: true, aria: { label: "time in the clip" } });
    this.scrub.oninput = () => this.send({ kind: "seek", t: Number(this.scrub.value) });
    this.clock = make("output", { textContent: "live" });
    this.speed = make("select", { className: "hl-btn", aria: { label: "speed" }, onchange: () => this.send({ kind: "speed", speed: Number(this.speed.value) }) },
      ...[0.1, 0.25, 0.5, 1, 2].map((value) => make("option", { value, textContent: `${value}×`, selected: value === 1 })));
    this.repeat = button("repeat", () => { this.status.loop = !this.status.loop; this.showStatus(); if (this.status.clip) this.send({ kind: "play", loop: this.status.loop }); }, { className: "hl-btn", aria: { pressed: "false" } });
    return make("div", { className: "hl-clips" }, this.chips, make("div", { className: "hl-play" }, this.go, this.scrub, this.clock, this.speed, this.repeat));
  }

  listClips(clips) {
    this.clips = clips;
    this.chips.replaceChildren(...clips.map(({ name, title }) => button(name.replaceAll("-", " "), () => this.send({ kind: "play", clip: name, loop: this.status.loop }), { title, data: { clip: name }, aria: { pressed: String(name === this.status.clip) } })));
  }

  curves() {
    this.lengthCanvas = make("canvas", { aria: { label: "Muscle lengths over time" } });
    this.angleCanvas = make("canvas", { aria: { label: "Joint angles over time" } });
    // The line that marks the time is moved by the compositor: the curves of a clip are drawn once.
    this.marks = [make("i", { hidden: true }), make("i", { hidden: true })];
    return make("div", { className: "hl-curves" }, make("div", {}, this.lengthCanvas, this.marks[0]), make("div", {}, this.angleCanvas, this.marks[1]));
  }

  looks() {
    const views = make("div", { className: "hl-seg" }, ...["palm", "back", "radial", "ulnar", "front"].map((name) => button(name, () => { this.hand.view(name); this.showLook(); }, { data: { view: name } })));
    const skin = make("div", { className: "hl-seg" }, ...["solid", "translucent", "hidden"].map((name) => button(name === "hidden" ? "no skin" : name, () => this.setLook({ skin: name }), { data: { skin: name } })));
    const bones = button("bones", () => this.setLook({ bones: !this.hand.look.bones }), { className: "hl-btn", data: { layer: "bones" } });
    const layer = (name) => button(name, () => this.setLook({ [name]: !this.hand.look[name] }), { className: "hl-btn", data: { layer: name } });
    const given = this.transport.recorded && !this.scene.layers; // a recording without muscles has none to show
    this.lookBar = make("div", { className: "hl-bar top" }, views, make("span", { className: "gap" }), skin, bones, ...(given ? [] : [layer("muscles"), layer("tendons")]));
    if (this.transport.ownHand) this.lookBar.append(button("your own hand ...", () => this.transport.ownHand(), { className: "hl-btn", data: { act: "own-hand" }, title: "make a hand from a photograph" }));
    if (this.transport.paintMuscle) this.lookBar.append(button("paint a muscle ...", () => this.transport.paintMuscle(), { className: "hl-btn", data: { act: "paint-muscle" }, title: "click a grid on the skin: a muscle of your own" }));
    return this.lookBar;
  }

  actions() {
    const bar = make("div", { className: "hl-bar bottom" }, ...(this.transport.recorded ? [] : this.wearing()), make("span", { className: "gap" }));
    const file = make("input", { type: "file", accept: ".json,application/json", hidden: true, onchange: () => this.load(file) });
    this.record = button("record", () => this.send({ kind: "record", on: !this.status.recording }), { className: "hl-btn rec", aria: { pressed: "false" }, title: "record what the sliders do as a clip" });
    const live = !this.transport.recorded;
    const formats = this.transport.recorded ? ["png"] : ["png", ...(this.scene.exports || []).filter((one) => one !== "png")];
    bar.append(
      button("reset", () => { this.hand.view(this.options.view || "palm"); this.showLook(); this.send({ kind: "reset" }); }, { className: "hl-btn", title: "relaxed hand, nothing held" }),
      ...(live ? [this.record, this.menu("keep", [
        ["Save pose", () => this.send({ kind: "save", what: "pose" })], ["Save clip", () => this.send({ kind: "save", what: "clip" })], ["Load pose, clip or muscle ...", () => file.click()],
      ]), file] : []),
      this.menu("export", formats.map((format) => [EXPORTS[format], () => this.export(format), { data: { export: format } }])),
    );
    return bar;
  }

  // How the skin is worn, and which muscles contract: for all who look at this hand.
  wearing() {
    const wear = ["blend", "springs", "springs and muscles"].map((name) => button(name.replace("and", "+"), () => this.send({ kind: "wear", skin: name }), { data: { wear: name }, title: WEAR[name] }));
    this.used = make("select", { className: "hl-btn", aria: { label: "which muscles contract" }, title: "which muscles contract: pseudo muscles turn bones, geometric muscles swell below the skin", onchange: () => this.send({ kind: "wear", muscles: this.used.value }) },
      ...Object.entries(USED).map(([value, textContent]) => make("option", { value, textContent })));
    this.wearBar = make("div", { className: "hl-seg", aria: { label: "how the skin is worn" } }, ...wear);
    this.wearBar.setAttribute("role", "group");
    return [this.wearBar, this.used];
  }

  menu(name, entries) {
    const list = make("div", { hidden: true }, ...entries.map(([text, act, more]) => button(text, () => { close(); act(); }, more || {})));
    list.setAttribute("role", "menu");
    const opener = button(`${name} ▴`, () => { list.hidden = !list.hidden; opener.setAttribute("aria-expanded", String(!list.hidden)); }, { className: "hl-btn", aria: { expanded: "false", haspopup: "menu" }, data: { menu: name } });
    const close = () => { list.hidden = true; opener.setAttribute("aria-expanded", "false"); };
    const whole = make("div", { className: "hl-menu" }, opener, list);
    whole.addEventListener("focusout", (event) => { if (event.relatedTarget && !whole.contains(event.relatedTarget)) close(); });
    whole.addEventListener("keydown", (event) => { if (event.key === "Escape") { close(); opener.focus(); } });
    this.root.addEventListener("pointerdown", (event) => { if (!whole.contains(event.target)) close(); });
    return whole;
  }

  tabs() {
    const tab = (name) => button(capital(name), () => { this.root.dataset.tab = name; this.root.querySelectorAll("[data-to]").forEach((one) => press(one, one.dataset.to === name)); }, { data: { to: name }, aria: { pressed: String(name === "muscles") } });
    return make("div", { className: "hl-tabs" }, make("div", { className: "hl-seg" }, tab("muscles"), tab("joints")));
  }

  // ---- the user's hand

  listen() {
    const { canvas, hand, root } = this;
    const fingers = new Map();
    canvas.addEventListener("pointerdown", (event) => { canvas.setPointerCapture(event.pointerId); fingers.set(event.pointerId, event); this.dragged = 0; this.hideTag(); });
    canvas.addEventListener("pointermove", (event) => {
      const before = fingers.get(event.pointerId);
      if (!before) { this.hover(event); return; }
      const dx = event.clientX - before.clientX, dy = event.clientY - before.clientY;
      this.dragged += Math.abs(dx) + Math.abs(dy);
      if (fingers.size === 2) {
        const other = [...fingers.values()].find((finger) => finger.pointerId !== event.pointerId);
        const gap = (finger) => Math.hypot(finger.clientX - other.clientX, finger.clientY - other.clientY) || 1;
        hand.zoom(gap(before) / gap(event));
        hand.pan(dx / 2, dy / 2);
      } else if (event.shiftKey || event.buttons & 6) hand.pan(dx, dy);
      else hand.orbit(dx * 0.009, dy * 0.009);
      fingers.set(event.pointerId, event);
      this.showLook();
    });
    const lift = (event) => { if (fingers.delete(event.pointerId) && this.dragged < 4 && event.type === "pointerup") { this.pick(event); if (event.pointerType === "touch") this.hover(event); } };
    canvas.addEventListener("pointerup", lift);
    canvas.addEventListener("pointercancel", lift);
    canvas.addEventListener("pointerleave", (event) => { if (event.pointerType !== "touch") this.hideTag(); }); // a finger leaves when it is lifted
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    canvas.addEventListener("dblclick", () => hand.fit());
    canvas.addEventListener("wheel", (event) => {
      if (this.options.embedded && document.activeElement !== canvas) return; // the page scrolls until the hand is clicked
      event.preventDefault();
      hand.zoom(Math.exp(Math.max(-0.25, Math.min(0.25, event.deltaY * 0.0012))));
    }, { passive: false });
    canvas.addEventListener("keydown", (event) => this.key(event));
    canvas.addEventListener("webglcontextlost", (event) => { event.preventDefault(); this.say("the graphics card let go of the picture; it comes back by itself", false); });
    canvas.addEventListener("webglcontextrestored", () => { if (hand.gone) return; hand.setUp(); hand.fresh = true; hand.redraw(); });
    root.addEventListener("keydown", (event) => event.stopPropagation()); // a notebook's own shortcuts stay out
    this.sizes = new ResizeObserver(() => this.resize());
    this.sizes.observe(root);
    this.sizes.observe(this.stage);
    this.resize();
  }

  key(event) {
    const { hand } = this, step = 0.12;
    const turn = { ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, -step], ArrowDown: [0, step] }[event.key];
    const view = ["palm", "back", "radial", "ulnar", "front"]["12345".indexOf(event.key)];
    if (turn && event.shiftKey) hand.pan(turn[0] * 150, turn[1] * 150);
    else if (turn) hand.orbit(...turn);
    else if (event.key === "+" || event.key === "=") hand.zoom(0.9);
    else if (event.key === "-") hand.zoom(1 / 0.9);
    else if (event.key === " ") this.playOrPause();
    else if (view && !event.ctrlKey && !event.metaKey && !event.altKey) hand.view(view);
    else return;
    event.preventDefault();
    this.showLook();
  }

  resize() {
    const { clientWidth: w, clientHeight: h } = this.root;
    this.root.dataset.size = w >= 1080 ? "wide" : w >= 640 ? "narrow" : "tiny";
    this.root.classList.toggle("low", h < 800);
    this.hand.covered = this.lookBar.offsetTop + this.lookBar.offsetHeight;
    if (this.hand.viewName && this.stage.clientWidth) this.hand.fit();
    this.hand.redraw();
    this.curvesDue();
  }

  hover(event) {
    if (this.picking) return;
    this.picking = requestAnimationFrame(() => {
      this.picking = 0;
      const box = this.canvas.getBoundingClientRect(), x = event.clientX - box.left, y = event.clientY - box.top;
      const found = this.hand.pick(x, y);
      this.canvas.style.cursor = found ? "pointer" : "";
      this.heat(found);
      if (!found) { this.tag.hidden = true; return; }
      const bone = found.kind === "bone" ? this.scene.bones[found.index] : null, flesh = found.kind === "flesh" ? this.hand.flesh.all[found.index] : null;
      this.tag.replaceChildren(flesh ? capital(flesh.title) : bone ? capital(bone.title) : `Skin over ${this.scene.bodies[found.index].title}${found.side ? `, ${found.side} side` : ""}`);
      if (flesh) this.tag.append(make("small", { textContent: `driven by ${flesh.drives.map((k) => this.scene.muscles[k].short).join(", ")}` }));
      if (bone) this.tag.append(make("small", { textContent: bone.latin }));
      this.tag.hidden = false;
      const left = Math.min(x + 16, this.stage.clientWidth - this.tag.offsetWidth - 8);
      this.tag.style.left = `${Math.max(left, 4)}px`;
      this.tag.style.top = `${y + 20 + this.tag.offsetHeight > this.stage.clientHeight ? y - this.tag.offsetHeight - 10 : y + 18}px`;
    });
  }

  heat(found) {
    const hot = this.hand.hot, bone = found?.kind === "bone" ? found.index : -1, part = found?.kind === "skin" ? found.index : -1, flesh = found?.kind === "flesh" ? found.index : -1;
    if (hot.bone === bone && hot.part === part && hot.flesh === flesh) return;
    Object.assign(hot, { bone, part, flesh });
    this.hand.redraw();
  }

  hideTag() { this.tag.hidden = true; this.heat(null); }

  // A click names what was hit and marks the muscles that move it.
  pick(event) {
    const box = this.canvas.getBoundingClientRect(), found = this.hand.pick(event.clientX - box.left, event.clientY - box.top);
    if (found?.kind === "flesh") { this.pickFlesh(found); return; }
    const body = found ? this.scene.bodies[found.kind === "bone" ? this.scene.bones[found.index].body : found.index] : null;
    const joint = body && this.scene.joints.find((one) => one.name === body.joint);
    this.picked = found && { ...found, name: found.kind === "bone" ? this.scene.bones[found.index].name : body.name };
    this.scene.muscles.forEach((muscle, k) => this.rows[k].row.classList.toggle("linked", !!joint && muscle.dofs.some((dof) => joint.dofs.includes(dof))));
    this.scene.dofs.forEach((dof, k) => this.dofRows[k].row.classList.toggle("linked", !!joint && joint.dofs.includes(k)));
    if (joint) {
      const movers = this.scene.muscles.filter((muscle) => muscle.dofs.some((dof) => joint.dofs.includes(dof))).map((muscle) => muscle.short);
      this.dofRows[joint.dofs[0]].row.scrollIntoView({ block: "nearest" });
      this.more.replaceChildren(make("strong", { textContent: capital(found.kind === "bone" ? this.scene.bones[found.index].title : body.title) }),
        make("div", { textContent: `turns in the ${joint.title}` }), make("div", { className: "faint", textContent: `moved by ${movers.join(", ")}` }));
    }
  }

  // A click on a muscle or tendon marks the contractions that drive it.
  pickFlesh(found) {
    const one = this.hand.flesh.all[found.index];
    this.picked = { ...found, name: one.name };
    this.scene.muscles.forEach((muscle, k) => this.rows[k].row.classList.toggle("linked", one.drives.includes(k)));
    this.scene.dofs.forEach((dof, k) => this.dofRows[k].row.classList.toggle("linked", one.drives.some((m) => this.scene.muscles[m].dofs.includes(k))));
    this.rows[one.drives[0]].row.scrollIntoView({ block: "nearest" });
    this.about(one.drives[0]);
  }

  slide(k) {
    const { slider } = this.rows[k];
    this.wanted.set(this.scene.muscles[k].name, Number(slider.value) / 100);
    this.showMuscle(k, Number(slider.value));
    if (!this.sending) this.sending = requestAnimationFrame(() => { // of a burst the latest values travel
      this.sending = 0;
      const contraction = Object.fromEntries(this.wanted);
      this.wanted.clear();
      this.send({ kind: "set", contraction });
    });
  }

  send(message) {
    this.asked += 1;
    this.sentAt.set(this.asked, performance.now());
    if (this.sentAt.size > 200) this.sentAt.delete(this.sentAt.keys().next().value);
    this.transport.send({ ...message, n: this.asked });
    this.tick();
  }

  // Where the host has no clock, this page asks for every frame while something moves.
  tick() {
    if (this.transport.ticks !== "client" || this.gone) return;
    const now = performance.now();
    if (this.ticking && now - this.ticking < TICK_TIMEOUT_MS) { this.again = true; return; }
    this.ticking = now;
    this.transport.send({ kind: "tick" });
  }

  playOrPause() {
    if (this.status.playing) this.send({ kind: "pause" });
    else this.send({ kind: "play", loop: this.status.loop, ...(this.status.clip ? {} : { clip: this.clips[0]?.name }) });
  }

  hold(joint) {
    const held = new Set(this.status.hold);
    if (!held.delete(joint)) held.add(joint);
    this.send({ kind: "hold", joints: [...held] });
  }

  pin(kind, k) {
    const set = this.pinned[kind];
    if (!set.delete(k)) { set.add(k); if (set.size > MOST_LINES) set.delete(set.values().next().value); }
    press((kind === "muscle" ? this.rows : this.dofRows)[k].who, set.has(k));
    this.curvesDue(true);
  }

  filter() {
    const words = this.search.value.toLowerCase().split(/[\s_]+/).filter(Boolean);
    let shown = 0;
    for (const section of this.none.parentNode.querySelectorAll("section")) {
      let own = 0;
      for (const row of section.querySelectorAll(".hl-row")) {
        const muscle = this.scene.muscles[this.rows.findIndex((one) => one.row === row)];
        const text = `${muscle.short} ${muscle.title} ${muscle.region} ${muscle.group} ${muscle.nerve}`.toLowerCase();
        row.hidden = !words.every((word) => text.includes(word));
        own += row.hidden ? 0 : 1;
      }
      section.hidden = own === 0;
      shown += own;
    }
    this.none.hidden = shown > 0;
    if (shown === 1) this.about(this.rows.findIndex((one) => !one.row.hidden));
  }

  setLook(change) {
    Object.assign(this.hand.look, change);
    if (change.view) this.hand.view(change.view);
    const { muscles, tendons, skin } = this.hand.look, asked = muscles || tendons;
    if ((change.muscles || change.tendons) && skin === "solid") this.hand.look.skin = "translucent"; // or nobody would see them
    if (asked && !this.hand.flesh && !this.layersAsked) { this.layersAsked = true; this.askLayers(); }
    this.hand.layFlesh();
    this.hand.redraw();
    this.showLook();
  }

  askLayers() {
    if (this.scene.layers) this.hand.takeLayers(this.scene.layers);
    else if (!this.transport.recorded) this.send({ kind: "layers" });
  }

  async export(format) {
    if (format === "png") { this.download("hand.png", await this.hand.png()); return; }
    const { skin, bones, muscles, tendons } = this.hand.look;
    const layers = [...(muscles ? ["muscles"] : []), ...(tendons ? ["tendons"] : [])];
    this.send({ kind: "export", format, look: { skin, bones, layers, view: this.hand.viewName || "palm", camera: this.hand.camera() } });
  }

  async load(input) {
    const file = input.files[0];
    input.value = "";
    if (!file) return;
    if (file.size > 5e6) { this.say(`${file.name} is larger than 5 MB: no pose or clip is`, false); return; }
    this.send({ kind: "load", name: file.name, text: await file.text() });
  }

  download(name, blob) {
    const link = make("a", { href: URL.createObjectURL(blob), download: name });
    this.root.append(link);
    link.click();
    link.remove();
    setTimeout(() => URL.revokeObjectURL(link.href), 20000);
  }

  // ---- what the host says

  begin() {
    if (this.transport.recorded) this.transport.send({ kind: "hello" });
    if (this.options.layers?.length) this.setLook({});
    if (this.options.play) this.send({ kind: "play", clip: this.options.play, loop: !!this.options.loop });
    this.tick();
  }

  receive(message) {
    if (message instanceof ArrayBuffer || ArrayBuffer.isView(message)) { this.take(message); return; }
    if (message.kind === "status") { this.status = { ...this.status, ...message }; if (!message.clip && this.track.whole) this.track.clear(); this.showStatus(); }
    else if (message.kind === "clips") this.listClips(message.clips);
    else if (message.kind === "answer") this.say(message.text, message.good);
    else if (message.kind === "file") this.download(message.name, new Blob([message.text ?? asBytes(message.data)], { type: message.mime }));
    else if (message.kind === "track") this.track.load(new Float32Array(asBytes(message.data).slice().buffer), message.seconds ?? this.seconds(message.clip));
    else if (message.kind === "layers") { this.hand.takeLayers(unpackScene(message.data)); this.showLook(); }
    else if (message.kind === "look") this.setLook(message);
    else if (message.kind === "tock") this.ticked(false);
    if (message.kind === "track") this.curvesDue(true);
  }

  seconds(clip) { return this.clips.find((one) => one.name === clip)?.seconds ?? this.status.seconds; }

  take(data) {
    const frame = this.frame = unpackFrame(data, this.scene);
    this.stats.frames += 1;
    this.stats.bytes += frame.bytes;
    if (frame.moving && this.stats.frames > 1) this.hand.follow(frame); else this.hand.pose(frame);
    if (this.stats.frames === 1 && this.hand.viewName) this.hand.fit();
    if (!frame.clip) {
      const row = new Float32Array(this.track.width);
      row.set(frame.length); row.set(frame.angle, frame.length.length);
      this.track.add(frame.time, row);
    }
    this.panelsDue();
    if (!this.track.whole) this.curvesDue();
    const now = performance.now();
    if (!this.hand.software || !frame.moving || now - (this.markedAt || 0) > MARK_MS) { this.markedAt = now; this.mark(); }
    this.ticked(frame.moving);
  }

  ticked(moving) {
    this.ticking = 0;
    if (this.transport.ticks !== "client" || !(moving || this.again)) return;
    this.again = false;
    requestAnimationFrame(() => this.tick());
  }

  drawn() {
    if (!this.stats.first_ms && this.frame) this.stats.first_ms = performance.now();
    if (!this.frame?.echo) return;
    const sent = this.sentAt.get(this.frame.echo);
    if (sent === undefined) return;
    this.stats.latency_ms.push(performance.now() - sent);
    for (const n of this.sentAt.keys()) if (n <= this.frame.echo) this.sentAt.delete(n);
  }

  // ---- showing

  panelsDue() {
    if (this.panelTimer) return;
    this.panelTimer = setTimeout(() => { this.panelTimer = 0; this.showFrame(); }, Math.max(0, (this.hand.software ? SLOW_MS : PANEL_MS) - (performance.now() - (this.panelAt || 0))));
  }

  showFrame() {
    this.panelAt = performance.now();
    const { frame } = this;
    if (!frame || this.gone) return;
    for (let k = 0; k < this.rows.length; k++) {
      if (k === this.held || this.wanted.has(this.scene.muscles[k].name)) continue;
      const percent = Math.round(frame.contraction[k] * 100);
      if (percent !== this.rows[k].shown) { this.rows[k].slider.value = percent; this.showMuscle(k, percent); }
    }
    for (let k = 0; k < this.dofRows.length; k++) {
      const own = this.dofRows[k];
      if (!own) continue;
      const degrees = Math.round(frame.angle[k] * DEGREES);
      if (degrees === own.shown) continue;
      own.shown = degrees;
      own.output.textContent = `${degrees || 0}°`.replace("-", "−");
      const at = Math.min(Math.max((frame.angle[k] - own.low) / own.span, 0), 1);
      own.bar.style.transform = `translateX(${Math.min(at, own.zero) * 100}%) scaleX(${Math.abs(at - own.zero)})`;
    }
    if (frame.clip) {
      this.scrub.max = frame.seconds;
      this.scrub.value = frame.time;
      this.scrub.style.setProperty("--p", `${100 * frame.time / (frame.seconds || 1)}%`);
      this.clock.textContent = `${frame.time.toFixed(2)} / ${frame.seconds.toFixed(2)} s`;
    } else this.clock.textContent = `live ${frame.time.toFixed(1)} s`;
    this.about(this.told);
  }

  showMuscle(k, percent) {
    const own = this.rows[k];
    own.shown = percent;
    own.slider.style.setProperty("--p", `${percent}%`);
    own.output.textContent = `${percent} %`;
    own.row.classList.toggle("on", percent > 1);
  }

  about(k) {
    this.told = k;
    const muscle = this.scene.muscles[k];
    if (!muscle) { if (!this.more.childElementCount) this.more.append(make("div", { className: "faint", textContent: "Point at a muscle to read about it; click its abbreviation to draw its length. Point at the hand for names." })); return; }
    if (this.more.dataset.muscle !== muscle.short || !this.aboutNumbers?.isConnected) {
      this.more.dataset.muscle = muscle.short;
      this.aboutNumbers = make("div");
      this.more.replaceChildren(make("strong", { textContent: `${capital(muscle.title)}` }), this.aboutNumbers, make("div", { className: "faint", textContent: this.scene.newton_note }),
        make("div", { textContent: `${capital(muscle.action)}; ${muscle.nerve} nerve`.replace("nerve nerve", "nerve") }));
    }
    const length = this.frame ? this.frame.length[k] : muscle.rest_length, force = this.frame ? this.frame.force[k] : 0;
    this.aboutNumbers.textContent = `length ${(length * 1000).toFixed(1)} mm (rest ${(muscle.rest_length * 1000).toFixed(1)}), force ${force.toFixed(0)} of ${muscle.max_force.toFixed(0)} N`;
  }

  curvesDue(now = false) {
    if (now) this.chosenAt = 0;
    if (this.curveTimer || this.gone) return;
    this.curveTimer = setTimeout(() => { this.curveTimer = 0; this.showCurves(); }, Math.max(0, (this.hand.software ? SLOW_MS : CURVE_MS) - (performance.now() - (this.curveAt || 0))));
  }

  showCurves() {
    if (this.gone) return;
    const time = this.curveAt = performance.now();
    const { muscles, dofs } = this.scene, count = muscles.length, now = this.frame?.time ?? 0;
    if (!this.chosenAt || time - this.chosenAt > 1000) { // what changes most, unless the user chose
      this.chosenAt = time;
      this.chosen = {
        muscle: this.pinned.muscle.size ? [...this.pinned.muscle] : this.track.busiest(0, count, 4, now),
        dof: this.pinned.dof.size ? [...this.pinned.dof].map((k) => k + count) : this.track.busiest(count, count + dofs.length, 4, now),
      };
    }
    this.boxes = [drawCurves(this.lengthCanvas, this.track, this.chosen.muscle.map((k) => ({ column: k, label: muscles[k].short, factor: 1000 })), { title: "Muscle length (mm)", now, least: 2 }),
    drawCurves(this.angleCanvas, this.track, this.chosen.dof.map((k) => ({ column: k, label: this.dofLabel(k - count), factor: DEGREES })), { title: "Joint angle (degrees)", now, least: 4 })];
    this.mark();
  }

  mark() {
    this.marks.forEach((mark, k) => {
      const box = this.track.whole && this.frame?.clip ? this.boxes?.[k] : null;
      mark.hidden = !box;
      if (!box) return;
      mark.style.height = `${box.bottom - box.top}px`;
      const share = Math.min(Math.max((this.frame.time - box.start) / (box.end - box.start || 1), 0), 1);
      mark.style.transform = `translate(${box.left + share * (box.right - box.left)}px, ${box.top}px)`;
    });
  }

  dofLabel(k) {
    const { joint, motion } = this.scene.dofs[k];
    return `${joint === "wrist" ? "wrist" : joint.toUpperCase()} ${motion}`;
  }

  showStatus() {
    const { status } = this, loaded = !!status.clip;
    const icon = status.playing ? PAUSE : PLAY;
    if (this.go.dataset.icon !== String(status.playing)) { this.go.innerHTML = icon; this.go.dataset.icon = String(status.playing); this.go.setAttribute("aria-label", status.playing ? "pause" : "play"); }
    for (const chip of this.chips.children) press(chip, chip.dataset.clip === status.clip);
    this.scrub.disabled = !loaded;
    if (!loaded) { this.scrub.value = 0; this.scrub.style.setProperty("--p", "0%"); }
    if (![...this.speed.options].some((one) => Number(one.value) === status.speed)) this.speed.append(make("option", { value: status.speed, textContent: `${status.speed}×` }));
    this.speed.value = String(status.speed);
    press(this.repeat, status.loop);
    press(this.record, status.recording);
    this.record.textContent = status.recording ? "stop" : "record";
    if (this.wearBar) {
      for (const one of this.wearBar.children) { press(one, one.dataset.wear === status.wear); one.classList.toggle("due", !status.soft && one.dataset.wear !== "blend"); }
      this.used.value = status.muscles;
    }
    for (const [joint, lock] of this.locks) press(lock, status.hold.some((one) => one === joint || one.startsWith(`${joint}.`)));
  }

  showLook() {
    const { look } = this.hand;
    for (const one of this.lookBar.querySelectorAll("[data-view]")) press(one, one.dataset.view === this.hand.viewName);
    for (const one of this.lookBar.querySelectorAll("[data-skin]")) press(one, one.dataset.skin === look.skin);
    const bones = this.lookBar.querySelector("[data-layer=bones]");
    press(bones, look.bones);
    for (const name of ["muscles", "tendons"]) { const one = this.lookBar.querySelector(`[data-layer=${name}]`); if (one) press(one, look[name] && look.skin !== "solid"); }
    bones.disabled = look.skin === "solid";
    bones.title = look.skin === "solid" ? "a solid skin hides the bones" : "show the bones";
  }

  say(text, good = true) {
    this.saying.textContent = capital(text);
    this.saying.classList.toggle("bad", !good);
    this.saying.hidden = false;
    clearTimeout(this.sayTimer);
    this.sayTimer = setTimeout(() => { this.saying.hidden = true; }, SAY_MS);
  }

  api(dispose) {
    return {
      root: this.root, scene: this.scene, stats: this.stats, dispose,
      hand: this.hand, send: (message) => this.send(message), set: (look) => this.setLook(look), png: () => this.hand.png(),
      status: () => this.status, frame: () => this.frame, picked: () => this.picked,
    };
  }

  dispose() {
    this.gone = true;
    clearTimeout(this.panelTimer);
    clearTimeout(this.curveTimer);
    this.sizes.disconnect();
    this.hand.dispose();
  }
}

const DIGITS = ["wrist", "thumb", "index", "middle", "ring", "little"];
