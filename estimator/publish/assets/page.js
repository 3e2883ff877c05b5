// What the pages have in common: words, the WebSocket, and an image's own pixels on a canvas.
const Page = (function () {
  "use strict";
  const $ = (id) => document.getElementById(id);
  const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

  function setText(id, text) {
    if ($(id).textContent !== text) $(id).textContent = text;
  }
  function setStatus(status, text) {
    $("status").dataset.status = status;
    setText("status", text);
  }
  // A list's lines, where they are others; hidden without any.
  function setLines(id, lines) {
    const list = $(id);
    if (list.dataset.lines === lines.join("\n")) return;
    list.dataset.lines = lines.join("\n");
    list.replaceChildren(...lines.map((line) => Object.assign(document.createElement("li"), { textContent: line })));
    list.hidden = lines.length === 0;
  }

  // Messages of the program, JSON and pictures, on a connection that is made anew each second until `lost` says false.
  function connect({ text, picture, lost }) {
    const link = { socket: null, isOpen: () => link.socket.readyState === 1 };
    function open() {
      const scheme = location.protocol === "https:" ? "wss://" : "ws://";
      link.socket = new WebSocket(scheme + location.host + "/" + location.search, "tagtwist.live.v1");
      link.socket.binaryType = "arraybuffer";
      link.socket.onmessage = (event) => (typeof event.data === "string" ? text(JSON.parse(event.data)) : picture(numbersOf(event.data)));
      link.socket.onclose = (event) => { if (lost(event) !== false) setTimeout(open, 1000); };
    }
    open();
    return link;
  }
  // A picture's numbers, with its JPEG, which may be empty.
  function numbersOf(bytes) {
    const length = new DataView(bytes).getUint32(0, true);
    const numbers = JSON.parse(new TextDecoder().decode(new Uint8Array(bytes, 4, length)));
    numbers.jpeg = new Uint8Array(bytes, 4 + length);
    return numbers;
  }
  // One picture is decoded at a time, of those that come meanwhile the newest. `of`: {picture, waiting, decoding}; its
  // picture stays while `stays` says so.
  async function show(of, numbers, stays) {
    of.waiting = numbers;
    if (of.decoding) return;
    of.decoding = true;
    while (of.waiting) {
      const next = of.waiting;
      of.waiting = null;
      next.bitmap = next.jpeg.length ? await createImageBitmap(new Blob([next.jpeg], { type: "image/jpeg" })) : null;
      const old = stays() && of.picture ? next : of.picture;
      if (old !== next) of.picture = next;
      if (old && old.bitmap) old.bitmap.close();
    }
    of.decoding = false;
  }

  // The canvas has the image's own pixels, a whole number of them each. Returns where to draw: `at` is of corners u, v, ...
  function drawImage(canvas, picture) {
    const scale = Math.max(1, Math.ceil(720 / picture.width));
    const w = scale * picture.width, h = scale * picture.height;
    size(canvas, w, h);
    const g = canvas.getContext("2d");
    g.imageSmoothingEnabled = false;
    g.fillStyle = "#000";
    g.fillRect(0, 0, w, h);
    if (picture.bitmap) g.drawImage(picture.bitmap, 0, 0, w, h);
    canvas.dataset.t = picture.t;
    canvas.dataset.scale = scale;
    const at = (points, i) => [scale * (points[2 * i] + 0.5), scale * (points[2 * i + 1] + 0.5)];
    const quad = (points, colour, width) => {
      g.strokeStyle = colour; g.lineWidth = width; g.beginPath();
      for (let i = 0; i < 4; i++) g[i ? "lineTo" : "moveTo"](...at(points, i));
      g.closePath(); g.stroke();
    };
    return { g, w, h, scale, at, quad };
  }
  function size(canvas, w, h) {
    if (canvas.width !== w || canvas.height !== h) { canvas.width = w; canvas.height = h; canvas.style.aspectRatio = w + " / " + h; }
  }
  // A canvas of the screen's pixels, drawn on in those of the page.
  function sized(canvas, height) {
    const ratio = window.devicePixelRatio || 1;
    const w = Math.max(1, Math.round(canvas.clientWidth * ratio)), h = Math.max(1, Math.round((height || canvas.clientHeight) * ratio));
    if (canvas.width !== w || canvas.height !== h) { canvas.width = w; canvas.height = h; }
    const g = canvas.getContext("2d");
    g.setTransform(ratio, 0, 0, ratio, 0, 0);
    return { g, w: w / ratio, h: h / ratio };
  }

  return { $, css, setText, setStatus, setLines, connect, show, drawImage, size, sized };
})();
