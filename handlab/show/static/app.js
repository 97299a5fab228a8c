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

/** What the viewer talks to: frames are ArrayBuffers, everything else plain objects. */
function transport(session, secret) {
  const listeners = new Set();
  const tell = (message) => listeners.forEach((listener) => listener(message));
  const call = (name, args) => session.call(name, args).catch((error) => tell({ kind: "answer", good: false, text: String(error?.message ?? error) }));
  const headers = { "X-Handlab-Key": secret };

  session.subscribe("handlab.frame", ([bytes]) => {
    tell(bytes instanceof Uint8Array ? bytes.slice().buffer : bytes);
    // The host sends the next frame only after this: a slow page, or one in the background, skips frames and never lags behind.
    requestAnimationFrame(() => call("handlab.ready", []));
  });
  session.subscribe("handlab.note", async ([note]) => tell(note.address ? await fetched(note) : note));

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
    scene: fetch("handlab/data/scene", { headers }).then((answer) => {
      if (!answer.ok) throw new Error(`the hand could not be loaded (${answer.status})`);
      return answer.arrayBuffer();
    }),
    send: (message) => call("handlab.message", [message]),
    onMessage(callback) {
      listeners.add(callback);
      if (listeners.size === 1) call("handlab.ready", [true]);
      return () => listeners.delete(callback);
    },
  };
}

// Beside what trame manages: it replaces its own part of the page when a connection ends, and the hand should stay to be seen.
const element = document.createElement("div");
element.id = "handlab-view";
element.style.cssText = "position:fixed;inset:0;background:#fff";
document.body.append(element);

const client = window.trame.client;
client.onConnectionClose(() => say("The connection to handlab has ended.", () => location.reload()));
window.handlab = await mount(element, transport(client.getConnection().getSession(), sessionStorage.getItem("handlab-key") ?? ""));
