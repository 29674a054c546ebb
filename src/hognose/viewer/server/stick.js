// The stick that steers the nose: a pad and a lever on the screen, held keys, and a gamepad. What they push is sent
// through a websocket; the answer says whether somebody steers, and what to show beside the stick.
"use strict";
(() => {
  const PAD = 132, KNOB = 44, DEAD_ZONE = 0.12;
  const MOST_PADS = 4, LONGEST_NAME = 120;
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
    #hognose-stick .said { max-width: 330px; pointer-events: none; padding: 8px 10px; border-radius: 6px; background: rgba(28, 33, 38, .72); }
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
  lever.setAttribute("aria-label", "lever: up drives the nose forward, down back");
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

  // Browsers call the same gamepad differently, but most tell its maker and model, each four hexadecimal digits.
  const keyOf = (id) => {
    const found = /(?:^|Vendor: *)([0-9a-f]{4})(?:-|.*Product: *)([0-9a-f]{4})/i.exec(id);
    return (found ? `${found[1]}:${found[2]}`.toLowerCase() : id).slice(0, LONGEST_NAME);
  };

  // What gamepads push: one that the browser lists twice is one, and the stronger of its pushes counts. The program
  // takes each once too, since every page on this machine sees the same gamepads.
  const ofGamepads = () => {
    const pads = {}, names = [];
    for (const gamepad of navigator.getGamepads()) {
      if (!gamepad || !gamepad.connected) continue;
      const push = [0, 0, 0];
      const [x = 0, y = 0] = gamepad.axes;
      const reach = Math.hypot(x, y);
      if (reach > DEAD_ZONE) {
        const grown = (reach - DEAD_ZONE) / (1 - DEAD_ZONE) / reach;
        push[0] = x * grown;
        push[1] = -y * grown;
      }
      // The triggers of a pad with the standard layout; its first two buttons on any.
      const value = (button) => (gamepad.buttons[button] || { value: 0 }).value;
      const triggers = gamepad.mapping === "standard" ? value(7) - value(6) : 0;
      push[2] = triggers + value(0) - value(1);
      const key = keyOf(gamepad.id), other = pads[key];
      if (!other && names.push(gamepad.id) > MOST_PADS) break;
      pads[key] = other && Math.hypot(...other) > Math.hypot(...push) ? other : push;
    }
    return [pads, names];
  };

  // All that is pushed here, by hand and by gamepads, within the stick's circle and the lever's ends.
  const together = (pushes) => {
    const total = [0, 1, 2].map((axis) => pushes.reduce((sum, push) => sum + push[axis], 0));
    const reach = Math.max(1, Math.hypot(total[0], total[1]));
    return [total[0] / reach, total[1] / reach, Math.max(-1, Math.min(1, total[2]))];
  };

  const rounded = (push) => push.map((value) => Number(value.toFixed(3)));

  const pushed = () => {
    const byHand = [...hand];
    for (const key of new Set(pressed.values())) byHand[KEYS[key][0]] += KEYS[key][1];
    const [pads, names] = ofGamepads();
    for (const key of Object.keys(pads)) pads[key] = rounded(together([pads[key]]));
    keys.textContent = names.length ? `gamepad: ${names.join(", ")}` : "I K J L turn · R forward · F back · or a gamepad";
    return { hand: rounded(together([byHand])), gamepads: pads };
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
    // A page that nobody sees has let go of everything: what a gamepad said last there may be long past.
    const deflection = steering && !document.hidden ? pushed() : { hand: [0, 0, 0], gamepads: {} };
    const shown = together([deflection.hand, ...Object.values(deflection.gamepads)]);
    const span = (PAD - KNOB) / 2;
    padKnob.style.transform = `translate(${span * shown[0]}px, ${-span * shown[1]}px)`;
    leverKnob.style.transform = `translate(0, ${-span * shown[2]}px)`;
    const text = JSON.stringify(deflection);
    if (text === sent && now - sentAt < (steering ? BEAT : IDLE)) return;
    sent = text;
    sentAt = now;
    socket.send(text);
  }, OFTEN);
})();
