// The live hand inside the page that trame serves: connects the viewer with the session of `handlab`.
import { mount } from "./viewer.js";

/** One sentence over everything else, with a button that tries again. */
function say(sentence, again) {
  document.getElementById("handlab-notice")?.remove();
  const box = document.createElement("div");
  box.id = "handlab-notice";
  box.setAttribute("role", "alert");
  box.style.cssText =
    "position:fixed;left:50%;top:12px;transform:translateX(-50%);z-index:1000;background:#1f2933;color:#fff;" +
    "font:16px/1.4 system-ui,sans-serif;padding:10px 16px;border-radius:6px;max-width:90vw";
  box.textContent = sentence;
  const button = document.createElement("button");
  button.textContent = "Try again";
  button.style.cssText = "font:inherit;margin-left:12px";
  button.onclick = again;
  box.append(button);
  document.body.append(box);
}

const ended = () => say("The connection to handlab has ended.", () => location.reload());

/** What the viewer talks to: frames are ArrayBuffers, everything else plain objects. */
function transport(session, secret, own, painter) {
  const listeners = new Set();
  const tell = (message) => listeners.forEach((listener) => listener(message));
  const call = (name, args) => session.call(name, args).catch((error) => tell({ kind: "answer", good: false, text: String(error?.message ?? error) }));
  const headers = { "X-Handlab-Key": secret };
  let frames = null;

  /** Frames on a socket of their own, as long as someone listens. */
  function look() {
    const address = new URL(`handlab/data/frames?secret=${encodeURIComponent(secret)}`, location.href);
    address.protocol = address.protocol.replace("http", "ws");
    const socket = new WebSocket(address);
    socket.binaryType = "arraybuffer";
    socket.onmessage = ({ data }) => {
      if (socket !== frames) return; // of the hand before
      tell(data);
      // The host sends the next frame only after this: a slow page, or one in the background, skips frames and never lags behind.
      requestAnimationFrame(() => socket.readyState === WebSocket.OPEN && socket.send("drawn"));
    };
    socket.onclose = ({ wasClean }) => { if (!wasClean && socket === frames) ended(); };
    return socket;
  }

  session.subscribe("handlab.note", async ([note]) => (note.kind === "hand" ? show() : tell(note.address ? await fetched(note) : note)));

  /** A file reply with its content: big files come by another road than the frames, which must not wait for them. */
  async function fetched({ address, ...reply }) {
    try {
      const answer = await fetch(address, { headers });
      if (!answer.ok) throw new Error(await answer.text());
      return { ...reply, data: await answer.arrayBuffer() };
    } catch (error) {
      return { kind: "answer", good: false, text: `${reply.name} did not arrive: ${error.message ?? error}` };
    }
  }

  return {
    get scene() {
      return fetch("handlab/data/scene", { headers }).then((answer) => {
        if (!answer.ok) throw new Error(`the hand could not be loaded (${answer.status})`);
        return answer.arrayBuffer();
      });
    },
    send: (message) => call("handlab.message", [message]),
    ownHand: () => own.open(),
    paintMuscle: () => painter.open(),
    onMessage(callback) {
      listeners.add(callback);
      frames ??= look();
      return () => {
        listeners.delete(callback);
        if (listeners.size) return;
        frames.close();
        frames = null;
      };
    },
  };
}

/** The word of this tab's room on the host. */
function room(name) {
  const word = sessionStorage.getItem(name) ?? Array.from(crypto.getRandomValues(new Uint8Array(16)), (byte) => byte.toString(16).padStart(2, "0")).join("");
  sessionStorage.setItem(name, word);
  return word;
}

/** An element over the whole live hand. */
function over(id) {
  const box = document.createElement("div");
  box.id = id;
  box.style.cssText = "position:fixed;inset:0;z-index:20;background:#fff";
  return box;
}

/** Ask a room of the host: JSON, or bytes with a name; every trouble is a reply too. */
const asking = (what, secret, word) => async (message, bytes) => {
  const address = `handlab/data/${what}/${word}${bytes ? `?name=${encodeURIComponent(message.name)}` : ""}`;
  const headers = { "X-Handlab-Key": secret, "Content-Type": bytes ? "application/octet-stream" : "application/json" };
  try {
    const answer = await fetch(address, { method: "POST", headers, body: bytes ?? JSON.stringify(message) });
    if (answer.ok) return await answer.json();
    return { good: false, text: (await answer.text()).replace(/^handlab: /, "") || `the host answers ${answer.status}` };
  } catch {
    return { good: false, text: "The connection to handlab has ended. Your clicks are kept in this browser: start handlab again and reload this page." };
  }
};

/** The page "Paint a muscle" over the live hand; points and settings outlive a reload of the tab. */
function painter(secret) {
  const ask = asking("paint", secret, room("handlab-paint-room")), box = over("handlab-paint"), name = "handlab-paint";
  let page = null;
  const store = {
    read() { try { return JSON.parse(sessionStorage.getItem(name) ?? "null"); } catch { return null; } },
    write(kept) { try { sessionStorage.setItem(name, JSON.stringify(kept)); } catch { /* no room: the page goes on */ } },
  };
  const self = {
    async open() {
      document.body.append(box);
      const { paint } = await import("./paint.js");
      page?.dispose(); // the hand may be another one
      page = window.handlabPaint = await paint(box, { ask, store, close: self.close, used: self.used });
    },
    close() {
      page?.dispose();
      page = null;
      box.remove();
    },
    used(short) { // seen at once: its slider in view, the skin clear
      self.close();
      window.handlab.set({ muscles: true, skin: "translucent" });
      document.querySelector(`#handlab-view .hl-row[data-muscle="${short}"]`)?.scrollIntoView({ block: "center" });
    },
  };
  return self;
}

/** The page "Your own hand" over the live hand; clicks and picture stay in this browser, so that a reload loses nothing. */
function ownHand(secret) {
  const given = sessionStorage.getItem("handlab-fit"); // the command was given a picture, which waits in this room
  const ask = asking("fit", secret, given ?? room("handlab-room"));
  if (given) sessionStorage.setItem("handlab-room", given);
  const box = over("handlab-fit");
  let page = null;

  const own = {
    async open() {
      document.body.append(box);
      if (page) { page.resized(); return; }
      const { fit } = await import("./fit.js");
      page = await fit(box, { ask, store: await store(given ? room : ""), close: own.close, async reference() { await ask({ kind: "reference" }); own.close(); } });
      window.handlabFit = page;
    },
    close() {
      sessionStorage.removeItem("handlab-fit");
      box.remove();
    },
  };
  if (given) own.open();
  return own;
}

/** Where clicks (text) and the photograph (large) outlive a reload. Without it (a private window) the page works as well, and forgets. */
async function store(word) {
  const name = `handlab-fit${word}`;
  const base = await new Promise((done) => {
    const wish = indexedDB.open("handlab", 1);
    wish.onupgradeneeded = () => wish.result.createObjectStore("pictures");
    wish.onsuccess = () => done(wish.result);
    wish.onerror = () => done(null);
  }).catch(() => null);
  const run = (mode, act) => base && new Promise((done) => {
    const wish = act(base.transaction("pictures", mode).objectStore("pictures"));
    wish.onsuccess = () => done(wish.result);
    wish.onerror = () => done(null);
  });
  return {
    async read() {
      try {
        const clicks = JSON.parse(localStorage.getItem(name) ?? "null"), picture = await run("readonly", (all) => all.get(name));
        return { clicks: clicks?.clicks, of: clicks?.of, picture: picture?.blob ?? null, name: picture?.name };
      } catch { return null; }
    },
    clicks(clicks, of) { try { localStorage.setItem(name, JSON.stringify({ clicks, of })); } catch { /* a full disk: the page goes on */ } },
    picture: (blob, file) => run("readwrite", (all) => all.put({ blob, name: file }, name)),
  };
}

// Beside what trame manages: it replaces its own part of the page when a connection ends, and the hand should stay to be seen.
const element = document.createElement("div");
element.id = "handlab-view";
element.style.cssText = "position:fixed;inset:0;background:#fff";
document.body.append(element);

const client = window.trame.client;
client.onConnectionClose(ended);
const secret = sessionStorage.getItem("handlab-key") ?? "";
const host = transport(client.getConnection().getSession(), secret, ownHand(secret), painter(secret));

/** Show the hand; again, when the host has another one. */
async function show() {
  window.handlab?.dispose();
  window.handlab = await mount(element, host);
}

await show();
