// The stick that steers the nose: a pad and a lever on the screen, held keys, and a gamepad. What they push is sent
// through a websocket; the answer says whether somebody steers, and what to show beside the stick.
"use strict";
(() => {
  const PAD = 132, KNOB = 44, DEAD_ZONE = 0.12;
  const OFTEN = 33, IDLE = 400, BEAT = 100, AGAIN = 1000; // ms
  const KEYS = { i: [1, 1], k: [1, -1], l: [0, 1], j: [0, -1], r: [2, 1], f: [2, -1] }; // axis and direction

  const style = document.createElement("style");
  style.textContent = `
    #hognose-stick { position: fixed; left: 16px; bottom: 16px; z-index: 50; display: none; gap: 12px;
      align-items: flex-end; font: 13px/1.35 system-ui, sans-serif; color: #f4f4f2; user-select: none; }
    #hognose-stick .well { position: relative; width: ${PAD}px; height: ${PAD}px; border-radius: 50%;
      background: rgba(28, 33, 38, .72); border: 1px solid rgba(255, 255, 255, .35); touch-action: none; cursor: grab; }
    #hognose-stick .lever { width: ${KNOB + 8}px; border-radius: ${KNOB}px; }
    #hognose-stick .knob { position: absolute; left: 50%; top: 50%; width: ${KNOB}px; height: ${KNOB}px;
      margin: ${-KNOB / 2}px; border-radius: 50%; background: #e8a33d; pointer-events: none; }
    #hognose-stick .said { max-width: 330px; padding: 8px 10px; border-radius: 6px; background: rgba(28, 33, 38, .72); }
    #hognose-stick .warning { color: #ffb3a6; font-weight: 600; }
    #hognose-stick .keys { opacity: .75; }`;
  document.head.append(style);

  const make = (name, parent) => {
    const made = document.createElement("div");
    made.className = name;
    parent.append(made);
    return made;
  };
  const root = make("", document.body);
  root.id = "hognose-stick";
  const pad = make("well", root), lever = make("well lever", root), said = make("said", root);
  pad.setAttribute("role", "application");
  pad.setAttribute("aria-label", "stick: turns the nose, as seen looking out of it");
  lever.setAttribute("role", "application");
  lever.setAttribute("aria-label", "lever: up drives the nose on, down back");
  const padKnob = make("knob", pad), leverKnob = make("knob", lever);
  const words = make("words", said), warning = make("warning", said), keys = make("keys", said);

  const hand = [0, 0, 0]; // right, up, on: what the pointers push
  const pressed = new Map(); // what keys mean, by where they are: with Alt held, letting go says another letter
  let steering = false, socket = null, sent = "", sentAt = 0, openedAt = -Infinity;

  const pulled = (well, move) => {
    const span = (PAD - KNOB) / 2;
    const follow = (event) => {
      const box = well.getBoundingClientRect();
      const right = (event.clientX - box.left - box.width / 2) / span;
      const up = (box.top + box.height / 2 - event.clientY) / span;
      move(right, up, Math.max(1, Math.hypot(right, up)));
    };
    well.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      event.preventDefault();
      well.setPointerCapture(event.pointerId);
      follow(event);
    });
    well.addEventListener("pointermove", (event) => {
      if (well.hasPointerCapture(event.pointerId)) follow(event);
    });
    for (const end of ["pointerup", "pointercancel", "lostpointercapture"]) {
      well.addEventListener(end, () => move(0, 0, 1));
    }
  };
  pulled(pad, (right, up, reach) => { hand[0] = right / reach; hand[1] = up / reach; });
  pulled(lever, (right, up) => { hand[2] = Math.max(-1, Math.min(1, up)); });

  const letGo = () => { pressed.clear(); hand.fill(0); };
  const writes = (target) => target instanceof HTMLElement &&
    (target.isContentEditable || target.matches("textarea, select, input:not([type=checkbox], [type=radio])"));
  addEventListener("keydown", (event) => {
    const key = event.key.toLowerCase();
    if (!steering || !(key in KEYS) || event.ctrlKey || event.metaKey || event.altKey || writes(event.target)) return;
    pressed.set(event.code, key);
  });
  addEventListener("keyup", (event) => pressed.delete(event.code));
  addEventListener("blur", letGo);
  document.addEventListener("visibilitychange", letGo);

  const ofGamepads = () => {
    const total = [0, 0, 0];
    let name = "";
    for (const gamepad of navigator.getGamepads()) {
      if (!gamepad || !gamepad.connected) continue;
      name = gamepad.id;
      const [x = 0, y = 0] = gamepad.axes;
      const push = Math.hypot(x, y);
      if (push > DEAD_ZONE) {
        const grown = (push - DEAD_ZONE) / (1 - DEAD_ZONE) / push;
        total[0] += x * grown;
        total[1] -= y * grown;
      }
      // The triggers of a pad with the standard layout; its first two buttons on any.
      const value = (button) => (gamepad.buttons[button] || { value: 0 }).value;
      const triggers = gamepad.mapping === "standard" ? value(7) - value(6) : 0;
      total[2] += triggers + value(0) - value(1);
    }
    return [total, name];
  };

  const pushed = () => {
    const [total, name] = ofGamepads();
    hand.forEach((push, axis) => { total[axis] += push; });
    for (const key of new Set(pressed.values())) total[KEYS[key][0]] += KEYS[key][1];
    const reach = Math.max(1, Math.hypot(total[0], total[1]));
    total[0] /= reach;
    total[1] /= reach;
    total[2] = Math.max(-1, Math.min(1, total[2]));
    keys.textContent = name ? `gamepad: ${name}` : "I K J L turn · R on · F back · or a gamepad";
    return total;
  };

  const show = (answer) => {
    steering = answer.steering;
    if (!steering) letGo();
    root.style.display = steering ? "flex" : "none";
    words.textContent = answer.words;
    warning.textContent = answer.warning;
  };

  const open = (now) => {
    if (now - openedAt < AGAIN) return;
    openedAt = now;
    socket = new WebSocket(`ws://${location.host}/hognose`);
    socket.onmessage = (event) => show(JSON.parse(event.data));
    socket.onclose = () => { socket = null; show({ steering: false, words: "", warning: "" }); };
  };

  setInterval(() => {
    const now = performance.now();
    if (!socket) { open(now); return; }
    if (socket.readyState !== WebSocket.OPEN || socket.bufferedAmount > 0) return;
    const deflection = steering ? pushed() : [0, 0, 0];
    const span = (PAD - KNOB) / 2;
    padKnob.style.transform = `translate(${span * deflection[0]}px, ${-span * deflection[1]}px)`;
    leverKnob.style.transform = `translate(0, ${-span * deflection[2]}px)`;
    const text = JSON.stringify(deflection.map((push) => Number(push.toFixed(3))));
    if (text === sent && now - sentAt < (steering ? BEAT : IDLE)) return;
    sent = text;
    sentAt = now;
    socket.send(text);
  }, OFTEN);
})();
