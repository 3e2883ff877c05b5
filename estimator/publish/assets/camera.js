// Draws what comes over the WebSocket while a camera is calibrated: pictures with the corners found, and what is known.
(function () {
  "use strict";
  const { $, css, setText, setStatus, setLines } = Page;

  let setup = null, facts = null;
  const camera = { picture: null, waiting: null, decoding: false };
  let paused = false, shows = true, dirty = true, described = -1e9;

  // ---- what comes ----
  function lose() {
    if (facts && facts.verdict) return false;  // it has said its last word
    setStatus("lost", "no connection");
    setText("words", "The program does not answer; trying again.");
    return true;
  }
  function takeText(message) {
    if (message.type === "setup") {
      setup = message;
      setText("recording", setup.recording);
    } else if (message.type === "facts") {
      facts = message;
      tell();
    }
    dirty = true;
  }
  async function takePicture(numbers) {
    await Page.show(camera, numbers, () => paused);
    dirty = true;
  }

  // ---- words ----
  function cell(tag, text) { return Object.assign(document.createElement(tag), { textContent: text }); }

  function tell() {
    const verdict = facts.verdict;
    if (verdict) setStatus(verdict.good ? "ok" : "no_fix", verdict.good ? "good" : "not good");
    else setStatus("predicted", facts.calibrating ? "calibrating" : "looking");
    // "12 frames kept; what is missing; ...": what comes first is told with the numbers.
    const parts = (verdict ? verdict.text.replace(/^(not )?good: /, "") : facts.words).split("; ").filter((part) => !/frames kept$/.test(part));
    setText("words", parts.length > 1 ? "Show next:" : parts[0] || "");
    setLines("next", parts.length > 1 ? parts : []);
    setText("kept", String(facts.kept));
    setText("covered-share", Math.round(100 * facts.covered) + " % of the cells");
    const last = facts.known[facts.known.length - 1], first = facts.known[0];
    $("none").hidden = Boolean(last);
    if (!last) return;
    const before = new Map(first.numbers.map((number) => [number.name, number]));
    $("rows").replaceChildren(...last.numbers.map((number) => {
      const row = document.createElement("tr"), name = cell("th", number.name + (number.unit ? " [" + number.unit + "]" : ""));
      name.scope = "row";
      const old = before.get(number.name);
      row.append(name, cell("td", number.value.toPrecision(7)), cell("td", number.sigma.toPrecision(2)), cell("td", old ? old.sigma.toPrecision(2) : "–"));
      return row;
    }));
  }

  const THIRDS = ["upper left", "top", "upper right", "left", "middle", "right", "lower left", "bottom", "lower right"];
  function uncovered() {
    const all = Array(9).fill(0), none = Array(9).fill(0);
    facts.cells.forEach((n, i) => {
      const third = 3 * Math.floor((3 * Math.floor(i / setup.columns)) / setup.rows) + Math.floor((3 * (i % setup.columns)) / setup.columns);
      all[third]++;
      if (n === 0) none[third]++;
    });
    return THIRDS.filter((_, i) => 2 * none[i] > all[i]);
  }
  function describe() {
    $("view").setAttribute("aria-label", "The camera's image with " + (camera.picture ? camera.picture.seen.length : 0) + " tags");
    if (!facts) return;
    const where = uncovered();
    $("cover").setAttribute("aria-label", Math.round(100 * facts.covered) + " % of the image's cells saw corners" + (where.length ? "; few at its " + where.join(", ") : ""));
    const last = facts.known[facts.known.length - 1];
    if (last) $("sigmas").setAttribute("aria-label", "Standard deviations, now " + last.numbers.map((n) => n.name + " " + n.sigma.toPrecision(2) + " " + n.unit).join(", "));
  }

  // ---- pictures ----
  function cells(draw, w, h) {
    const { columns, rows } = setup;
    facts.cells.forEach((n, i) => draw(n, (w * (i % columns)) / columns, (h * Math.floor(i / columns)) / rows, w / columns, h / rows));
  }
  function drawView() {
    if (!camera.picture) return;
    const { g, w, h, scale, at, quad } = Page.drawImage($("view"), camera.picture);
    if (shows && facts && !facts.verdict) {
      g.fillStyle = "rgba(255, 90, 77, 0.22)";
      cells((n, x, y, cw, ch) => n === 0 && g.fillRect(x, y, cw, ch), w, h);
    }
    for (const { corners } of camera.picture.seen) {
      quad(corners, "#3bd65a", 2);
      g.fillStyle = "#3bd65a";
      for (let i = 0; i < 4; i++) { g.beginPath(); g.arc(...at(corners, i), 2 + scale, 0, 7); g.fill(); }
    }
  }
  function drawCover() {
    if (!facts) return;
    const canvas = $("cover"), picture = camera.picture, w = 720, h = picture ? Math.round((720 * picture.height) / picture.width) : 540;
    Page.size(canvas, w, h);
    const g = canvas.getContext("2d");
    g.clearRect(0, 0, w, h);
    g.font = "600 20px system-ui, sans-serif"; g.textAlign = "center"; g.textBaseline = "middle"; g.lineWidth = 1;
    const good = css("--good"), bad = css("--bad"), line = css("--line"), text = css("--text");
    cells((n, x, y, cw, ch) => {
      g.globalAlpha = n === 0 ? 0.3 : Math.min(1, 0.15 + 0.2 * Math.log10(1 + n)); g.fillStyle = n === 0 ? bad : good;
      g.fillRect(x, y, cw, ch);
      g.globalAlpha = 1; g.strokeStyle = line; g.strokeRect(x, y, cw, ch);
      g.fillStyle = text; g.fillText(String(n), x + cw / 2, y + ch / 2);
    }, w, h);
  }
  function drawSigmas() {
    const { g, w, h } = Page.sized($("sigmas"), 170);
    g.clearRect(0, 0, w, h);
    if (!facts || !facts.known.length) return;
    const first = new Map(facts.known[0].numbers.map((n) => [n.name, n.sigma]));
    const left = 46, right = 62, top = 8, bottom = 18;
    const lines = [...first.keys()].map((name) => facts.known.map((known) => {
      const now = known.numbers.find((n) => n.name === name);
      return now ? [known.kept, now.sigma / first.get(name)] : null;
    }).filter(Boolean)).map((points, i) => ({ name: [...first.keys()][i], points }));
    const all = lines.flatMap((l) => l.points.map((p) => p[1]));
    const low = Math.log10(Math.min(0.5, ...all)), high = Math.log10(Math.max(1.2, ...all));
    const from = facts.known[0].kept, to = Math.max(from + 1, facts.known[facts.known.length - 1].kept);
    const x = (kept) => left + ((kept - from) / (to - from)) * (w - left - right), y = (v) => top + ((high - Math.log10(v)) / (high - low)) * (h - top - bottom);
    g.font = "11px system-ui, sans-serif"; g.textBaseline = "middle"; g.textAlign = "right"; g.lineWidth = 1;
    for (const v of [0.001, 0.01, 0.1, 0.2, 0.5, 1, 2, 5, 10]) {
      if (Math.log10(v) < low || Math.log10(v) > high) continue;
      g.strokeStyle = css("--line"); g.beginPath(); g.moveTo(left, y(v)); g.lineTo(w - right, y(v)); g.stroke();
      g.fillStyle = css("--faint"); g.fillText(v, left - 5, y(v));
    }
    g.textAlign = "center"; g.fillStyle = css("--faint");
    g.fillText(from + " frames", x(from) + 20, h - 7); g.fillText(String(facts.known[facts.known.length - 1].kept), x(to), h - 7);
    const colours = [css("--x"), css("--y"), css("--z"), css("--path"), css("--fair"), css("--faint")], ends = [];
    lines.forEach(({ name, points }, i) => {
      g.strokeStyle = g.fillStyle = colours[i % colours.length]; g.lineWidth = 1.5; g.setLineDash([[], [6, 2], [2, 2]][Math.floor(i / 2) % 3]); g.beginPath();
      points.forEach((p, k) => g[k ? "lineTo" : "moveTo"](x(p[0]), y(p[1])));
      g.stroke(); g.setLineDash([]);
      const last = points[points.length - 1];
      g.beginPath(); g.arc(x(last[0]), y(last[1]), 2.5, 0, 7); g.fill();
      ends.push({ name, colour: colours[i % colours.length], y: y(last[1]) });
    });
    ends.sort((a, b) => a.y - b.y).forEach((e, k, es) => { if (k && e.y - es[k - 1].y < 12) e.y = es[k - 1].y + 12; });
    const over = ends.length ? Math.max(0, ends[ends.length - 1].y - (h - 8)) : 0;
    g.textAlign = "left"; g.font = "600 12px system-ui, sans-serif";
    for (const e of ends) { g.fillStyle = e.colour; g.fillText(e.name, w - right + 6, e.y - over); }
  }

  // ---- drawing, when there is anything new, at the screen's pace ----
  let drawn = 0;
  function draw(now) {
    requestAnimationFrame(draw);
    if (!dirty || !setup || now - drawn < 30) return;
    dirty = false;
    drawn = now;
    drawView();
    drawCover();
    drawSigmas();
    if (now - described > 2000) { described = now; describe(); }
  }

  // ---- what the person does ----
  function togglePause() {
    paused = !paused;
    $("pause").setAttribute("aria-pressed", String(paused));
    setText("pause", paused ? "Go on" : "Pause");
  }
  function toggleCells() {
    shows = !shows;
    $("covered-toggle").setAttribute("aria-pressed", String(shows));
    dirty = true;
  }
  $("pause").onclick = togglePause;
  $("covered-toggle").onclick = toggleCells;
  document.addEventListener("keydown", (e) => {
    if (e.ctrlKey || e.metaKey || e.altKey) return;
    if (e.key === "p") togglePause();
    if (e.key === "c") toggleCells();
  });
  addEventListener("resize", () => (dirty = true));
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => (dirty = true));
  Page.connect({ text: takeText, picture: takePicture, lost: lose });
  requestAnimationFrame(draw);
})();
