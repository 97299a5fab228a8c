// A transport without a host: frames of recorded clips, played by this page itself. Sliders show, they do not move anything.

import { asBytes } from "./hand3d.js";

// `clips`: [{name, title, seconds, fps, count, frames: ArrayBuffer, track: ArrayBuffer}]; frames as `wire.py` packs them.
export function recorded(scene, clips) {
  const listeners = new Set();
  const tell = (message) => listeners.forEach((listener) => listener(message));
  const state = { clip: clips[0], t: 0, playing: false, speed: 1, loop: false };
  let last = 0;

  const show = () => {
    const { clip, t } = state;
    const size = clip.frames.byteLength / clip.count;
    const k = Math.min(Math.round(t * clip.fps), clip.count - 1);
    const frame = asBytes(clip.frames).slice(k * size, (k + 1) * size);
    const head = new DataView(frame.buffer);
    head.setUint32(4, 4 | (state.playing ? 3 : 0), true);
    head.setFloat32(12, t, true);
    tell(frame.buffer);
  };
  const status = () => tell({
    kind: "status", clip: state.clip.name, seconds: state.clip.seconds, playing: state.playing, speed: state.speed, loop: state.loop, hold: state.clip.hold || [], recording: false,
  });
  const run = (now) => {
    if (!state.playing) return;
    state.t += Math.min((now - last) / 1000, 0.1) * state.speed;
    last = now;
    if (state.t >= state.clip.seconds) {
      if (state.loop && state.clip.seconds > 0) state.t %= state.clip.seconds;
      else { state.t = state.clip.seconds; state.playing = false; status(); }
    }
    show();
    if (state.playing) requestAnimationFrame(run);
  };
  const open = (name) => {
    state.clip = clips.find((clip) => clip.name === name) || state.clip;
    state.t = 0;
    if (state.clip.track) tell({ kind: "track", clip: state.clip.name, data: state.clip.track });
  };
  const acts = {
    play(message) {
      if (message.clip) open(message.clip);
      if (message.speed) state.speed = message.speed;
      if ("loop" in message) state.loop = message.loop;
      if (state.t >= state.clip.seconds) state.t = 0;
      if (!state.playing) { state.playing = state.clip.seconds > 0; last = performance.now(); requestAnimationFrame(run); }
      status();
    },
    pause() { state.playing = false; status(); show(); },
    seek(message) { state.t = Math.min(Math.max(message.t, 0), state.clip.seconds); show(); },
    speed(message) { state.speed = message.speed; status(); },
    reset() { state.playing = false; open(state.clip.name); status(); show(); },
    hello() { open(state.clip.name); status(); show(); },
  };
  return {
    recorded: true,
    scene: Promise.resolve(scene),
    onMessage(listener) { listeners.add(listener); return () => listeners.delete(listener); },
    send(message) {
      if (acts[message.kind]) acts[message.kind](message);
      else tell({ kind: "answer", good: false, text: "This page plays a recording: nothing here computes new motions." });
    },
  };
}
