// Draws what comes over the WebSocket: states, pictures with the numbers that belong on them, and
// facts about the run. Everything is kept in rings; what is hidden or paused is not drawn.
(function () {
  "use strict";
  const { $, css, setText, setStatus, setLines, sized } = Page;
  const SPAN_S = 10, MOST_STATES = 1500, MOST_PATH = 6000;
  const AXIS = ["#ff3b3b", "#35e06a", "#4b9bff"];

  let setup = null, facts = null, link = null, paused = false, dirty = true;
  // Of each body its states, its path, and what of them is shown while paused; of each camera the
  // newest picture, and the bytes of the next one.
  let bodies = new Map(), cameras = new Map();
  const body = () => bodies.get($("body").value), camera = () => cameras.get($("camera").value);
  const view = { turn: 0, tilt: 0, zoom: 1 };

  // ---- what comes ----
  function lose(event) {
    setStatus("lost", event.code === 1001 ? "ended" : "no connection");
    $("verdict").textContent = event.code === 1001 ? "The run has ended." : "The program does not answer; trying again.";
  }

  function takeText(message) {
    if (message.type === "setup") {
      if (paused) togglePause();
      setup = message; facts = null;
      bodies = new Map(message.bodies.map((name) => [name, { states: [], path: [], shown: null }]));
      cameras = new Map(message.cameras.map((of) => [of.name, { ...of, picture: null, waiting: null, decoding: false }]));
      offer("body", message.bodies);
      offer("camera", message.cameras.map((of) => of.name));
      $("dataset").textContent = message.dataset;
      $("record").hidden = !message.can_record;
      tellCamera();
      fit();
    } else if (message.type === "history") {
      message.states.forEach(takeState);
    } else if (message.type === "state") {
      takeState(message);
    } else if (message.type === "facts") {
      facts = message;
      tellFacts();
    }
    dirty = true;
  }

  // The names to choose from, where there are several.
  function offer(id, names) {
    const before = $(id).value;
    $(id).replaceChildren(...names.map((name) => Object.assign(document.createElement("option"), { textContent: name })));
    if (names.includes(before)) $(id).value = before;
    $(id).hidden = names.length < 2;
  }
  function tellCamera() {
    setText("camera-name", ($("camera").hidden ? $("camera").value + " " : "") + (camera().stands ? "stands" : "on " + setup.bodies[0]));
  }

  function takeState(state) {
    if (!bodies.has(state.body)) return;
    const { states, path } = bodies.get(state.body);
    if (state.position !== null) {
      state.attitude = attitude(state);
      if (setup.tags.every((tag) => tag.on)) grow(state.position);
      const last = path[path.length - 1];
      if (!last || state.t - last[3] > 0.02) path.push([...state.position, state.t]);
      if (path.length > MOST_PATH) path.splice(0, path.length, ...path.filter((_, i) => i % 2 === 1));
    }
    states.push(state);
    if (states.length > MOST_STATES) states.splice(0, states.length - MOST_STATES);
  }

  async function takePicture(numbers) {
    const of = cameras.get(numbers.camera);
    if (!of || of.name !== $("camera").value) return;  // nobody looks at it
    await Page.show(of, numbers, () => paused);
    dirty = true;
  }

  // Roll, pitch and yaw (turns about z, then y, then x) in degrees, with their standard deviations
  // from the covariance of the attitude in the body.
  function attitude(state) {
    const [x, y, z, w] = state.orientation, c = state.covariance;
    const roll = Math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y));
    const pitch = Math.asin(Math.max(-1, Math.min(1, 2 * (w * y - z * x))));
    const yaw = Math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z));
    const cov = [[c[0], c[1], c[2]], [c[1], c[12], c[13]], [c[2], c[13], c[23]]];
    const sr = Math.sin(roll), cr = Math.cos(roll), tp = Math.tan(pitch), cp = Math.cos(pitch);
    const rows = [[1, sr * tp, cr * tp], [0, cr, -sr], [0, sr / cp, cr / cp]];
    const deg = 180 / Math.PI;
    const sigma = rows.map((r) => {
      let v = 0;
      for (let i = 0; i < 3; i++) for (let j = 0; j < 3; j++) v += r[i] * cov[i][j] * r[j];
      return deg * Math.sqrt(Math.max(v, 0));
    });
    return { value: [deg * roll, deg * pitch, deg * yaw], sigma };
  }

  const SERIES = {
    position: (s) => ({ value: s.position, sigma: s.sigma.slice(3, 6) }),
    attitude: (s) => s.attitude,
    velocity: (s) => ({ value: s.linear_velocity, sigma: s.sigma.slice(6, 9) }),
    rates: (s) => ({ value: s.angular_velocity, sigma: s.sigma.slice(9, 12) }),
  };

  // ---- words ----
  const STATUS = {
    ok: "ok", hurried: "hurried", predicted: "predicted", ambiguous: "ambiguous", no_fix: "no fix",
  };

  function tellFacts() {
    setText("verdict", facts.verdict);
    setText("rate", facts.rate_hz.toFixed(1) + " Hz");
    setText("latency", facts.latency_ms.p50.toFixed(1) + " ms, " + facts.latency_ms.p99.toFixed(1) + " ms");
    setLines("aside", facts.set_aside.map((tag) => "tag " + tag.id + " is set aside in " + Math.round(100 * tag.share) + " % of the frames that see it: it " + tag.why));
    const r = facts.recording;
    if (!r) return;
    $("record").setAttribute("aria-pressed", String(r.on));
    setText("record", r.on ? "Stop recording" : "Record");
    setText("recording", (r.on ? "" : "paused, ") + r.frames + " images in " + r.folder + (r.dropped ? ", " + r.dropped + " lost" : "") + (r.problem ? ": " + r.problem : ""));
  }

  function tellState(shown) {
    const s = shown[shown.length - 1];
    if (!s) return;
    if (link.isOpen()) setStatus(s.status, (STATUS[s.status] || s.status) + (paused ? ", paused" : ""));
    setText("time", s.t.toFixed(2) + " s");
    setText("dropped", String(s.frames_dropped));
    setText("tags", s.n_tags + ", " + s.n_tracks);
    const cells = document.querySelectorAll("#numbers td");
    Object.values(SERIES).forEach((of, k) => {
      const v = s.position === null ? null : of(s);
      for (let i = 0; i < 3; i++) {
        const digits = k === 1 ? 2 : 4;
        cells[6 * k + i].textContent = v ? v.value[i].toFixed(digits) : "–";
        cells[6 * k + 3 + i].textContent = v ? (3 * v.sigma[i]).toPrecision(2) : "–";
      }
    });
  }

  function describe(shown) {
    const s = shown[shown.length - 1];
    if (!s) return;
    const picture = camera().picture, seen = picture ? picture.seen : [];
    $("view").setAttribute("aria-label", "The image of " + $("camera").value + " with " + seen.length + " tags, " + seen.filter((t) => t.used).length + " of them used");
    const at = s.position ? "at " + s.position.map((v) => v.toFixed(2)).join(", ") + " metres" : "not known";
    $("path").setAttribute("aria-label", "The path over the map; " + (setup.bodies.length > 1 ? $("body").value : "the body") + " is " + at);
    for (const canvas of document.querySelectorAll(".plot")) {
      const v = s.position ? SERIES[canvas.dataset.plot](s).value.map((x) => x.toFixed(2)).join(", ") : "not known";
      canvas.setAttribute("aria-label", canvas.dataset.plot + " over the last " + SPAN_S + " seconds, now " + v);
    }
  }

  // ---- pictures ----
  function drawView() {
    const picture = setup && camera().picture;
    if (!picture) return;
    const { g, h, scale, at, quad } = Page.drawImage($("view"), picture);
    const seen = new Set(picture.seen.map((tag) => tag.id));
    for (const tag of picture.map) quad(tag.corners, "#ffa02e", 1.2);
    for (const tag of picture.seen) quad(tag.corners, tag.used ? "#3bd65a" : "#ff5a4d", tag.used ? 1.6 : 3);
    const axes = (points, width) => {
      for (let i = 3; i > 0; i--) {
        g.strokeStyle = AXIS[i - 1]; g.lineWidth = width; g.beginPath();
        g.moveTo(...at(points, 0)); g.lineTo(...at(points, i)); g.stroke();
      }
    };
    for (const tag of picture.map) if (tag.axes && seen.has(tag.id)) axes(tag.axes, 2);
    for (const points of picture.frames) axes(points, 4);
    g.font = "600 " + Math.round(6 * scale + 4) + "px system-ui, sans-serif";
    g.textAlign = "center";
    for (const tag of picture.seen) {
      const x = (tag.corners[0] + tag.corners[2] + tag.corners[4] + tag.corners[6]) / 4, y = Math.max(tag.corners[1], tag.corners[3], tag.corners[5], tag.corners[7]);
      g.lineWidth = 3; g.strokeStyle = "#000"; g.fillStyle = tag.used ? "#3bd65a" : "#ff5a4d";
      const place = [scale * (x + 0.5), Math.min(h - 3, scale * (y + 0.5) + 7 * scale)];
      g.strokeText(tag.id, ...place); g.fillText(tag.id, ...place);
    }
  }

  // ---- the path ----
  // What is in sight: the tags that stand; where none does, the cameras that do and all positions.
  let frame = { centre: [0, 0, 0], size: 1 }, low, high;
  function fit() {
    low = [Infinity, Infinity, Infinity]; high = low.map((v) => -v);
    for (const tag of setup.tags) if (!tag.on) [0, 3, 6, 9].forEach((i) => grow(tag.corners.slice(i, i + 3)));
    if (low[0] > high[0]) for (const of of setup.cameras) if (of.stands) grow(of.stands);
  }
  function grow(p) {
    low = low.map((v, k) => Math.min(v, p[k])); high = high.map((v, k) => Math.max(v, p[k]));
    frame = { centre: low.map((v, k) => (v + high[k]) / 2), size: 1.25 * Math.max(0.2, Math.hypot(...low.map((v, k) => high[k] - v))) };
  }
  function rotation(q4) {  // its columns: the body's axes in the world
    const [x, y, z, q] = q4;
    return [[1 - 2 * (y * y + z * z), 2 * (x * y + z * q), 2 * (x * z - y * q)], [2 * (x * y - z * q), 1 - 2 * (x * x + z * z), 2 * (y * z + x * q)], [2 * (x * z + y * q), 2 * (y * z - x * q), 1 - 2 * (x * x + y * y)]];
  }
  const lastOf = (name) => { const of = bodies.get(name), shown = of.shown || of.states; return shown[shown.length - 1]; };
  // Corners in the world of each tag whose place is known.
  function placedTags() {
    const out = [];
    for (const tag of setup.tags) {
      const corners = [0, 3, 6, 9].map((i) => tag.corners.slice(i, i + 3));
      const s = tag.on && lastOf(tag.on);
      if (tag.on && (!s || !s.position)) continue;
      const r = tag.on && rotation(s.orientation);
      out.push({ id: tag.id, corners: tag.on ? corners.map((c) => s.position.map((v, k) => v + r[0][k] * c[0] + r[1][k] * c[1] + r[2][k] * c[2])) : corners });
    }
    return out;
  }
  function drawPath() {
    if (!setup) return;
    const { g, w, h } = sized($("path"));
    g.clearRect(0, 0, w, h);
    const unit = (Math.min(w, h) * view.zoom) / frame.size;
    const ct = Math.cos(view.turn), st = Math.sin(view.turn), ce = Math.cos(view.tilt), se = Math.sin(view.tilt);
    const to = (p) => {
      const d = [p[0] - frame.centre[0], p[1] - frame.centre[1], p[2] - frame.centre[2]];
      const x = ct * d[0] - st * d[1], y = st * d[0] + ct * d[1];
      return [w / 2 + unit * x, h / 2 - unit * (ce * y + se * d[2])];
    };
    const line = (points, colour, width) => {
      g.strokeStyle = colour; g.lineWidth = width; g.beginPath();
      points.forEach((p, i) => g[i ? "lineTo" : "moveTo"](...to(p)));
      g.stroke();
    };
    g.fillStyle = css("--tag"); g.strokeStyle = css("--line"); g.lineWidth = 1;
    const tags = placedTags();
    for (const tag of tags) {
      g.beginPath();
      tag.corners.forEach((c, i) => g[i ? "lineTo" : "moveTo"](...to(c)));
      g.closePath(); g.fill(); g.stroke();
    }
    const colours = [css("--x"), css("--y"), css("--z")], faint = css("--faint");
    const side = tags.length ? Math.hypot(...[0, 1, 2].map((k) => tags[0].corners[1][k] - tags[0].corners[0][k])) : 0;
    if (side * unit > 16) {
      g.fillStyle = faint; g.font = Math.min(14, 0.4 * side * unit) + "px system-ui, sans-serif"; g.textAlign = "center"; g.textBaseline = "middle";
      for (const tag of tags) g.fillText(tag.id, ...to([0, 1, 2].map((k) => (tag.corners[0][k] + tag.corners[2][k]) / 2)));
    }
    const ends = (origin, axes, length, width) => axes.forEach((a, k) => line([origin, origin.map((v, i) => v + length * a[i])], colours[k], width));
    ends([0, 0, 0], [[1, 0, 0], [0, 1, 0], [0, 0, 1]], 0.12 * frame.size, 1.5);
    const label = (text, p, dx) => { g.fillStyle = css("--text"); g.font = "12px system-ui, sans-serif"; g.textAlign = "left"; g.textBaseline = "middle"; g.fillText(text, to(p)[0] + dx, to(p)[1]); };
    for (const of of setup.cameras) {
      if (!of.stands) continue;
      const [x, y] = to(of.stands);
      g.strokeStyle = faint; g.lineWidth = 2; g.strokeRect(x - 4, y - 4, 8, 8);
      label(of.name, of.stands, 8);
    }
    for (const [name, of] of bodies) {
      const s = lastOf(name), chosen = name === $("body").value;
      line(s ? of.path.filter((p) => p[3] <= s.t) : [], chosen ? css("--path") : faint, chosen ? 1.6 : 1);
      if (!s || !s.position) continue;
      ends(s.position, rotation(s.orientation), 0.09 * frame.size, chosen ? 3 : 2);
      const radius = 3 * Math.max(s.sigma[3], s.sigma[4]) * unit;
      if (radius > 3) { g.strokeStyle = css("--path"); g.lineWidth = 1; g.beginPath(); g.arc(...to(s.position), radius, 0, 7); g.stroke(); }
      if (bodies.size > 1) label(name, s.position, 10);
    }
    const metre = niceStep(frame.size / view.zoom / 4);
    g.strokeStyle = faint; g.lineWidth = 2; g.beginPath(); g.moveTo(10, h - 12); g.lineTo(10 + metre * unit, h - 12); g.stroke();
    g.fillStyle = faint; g.font = "12px system-ui, sans-serif"; g.textAlign = "left"; g.textBaseline = "alphabetic"; g.fillText(metre + " m", 12, h - 17);
  }

  // ---- plots ----
  function niceStep(rough) {
    const power = Math.pow(10, Math.floor(Math.log10(rough)));
    const n = rough / power;
    return Number(((n < 1.5 ? 1 : n < 3.5 ? 2 : n < 7.5 ? 5 : 10) * power).toPrecision(3));
  }
  function drawPlot(canvas, shown) {
    const { g, w, h } = sized(canvas, 170);
    g.clearRect(0, 0, w, h);
    const of = SERIES[canvas.dataset.plot];
    const end = shown.length ? shown[shown.length - 1].t : 0;
    const values = shown.filter((s) => s.t > end - SPAN_S).map((s) => ({ t: s.t, v: s.position === null ? null : of(s) }));
    let low = Infinity, high = -Infinity;
    for (const { v } of values) {
      if (!v) continue;
      for (let i = 0; i < 3; i++) { low = Math.min(low, v.value[i]); high = Math.max(high, v.value[i]); }
    }
    if (low > high) return;
    let most = 0;  // wide bands may go off the plot, but most do not
    const bands = values.flatMap(({ v }) => (v ? v.sigma : [])).sort((a, b) => a - b);
    if (bands.length) most = 3 * bands[Math.floor(0.9 * (bands.length - 1))];
    const room = Math.max(0.05 * (high - low), Math.min(most, 3 * (high - low)), 1e-6 * Math.abs(high), 1e-9);
    low -= room; high += room;
    const left = 46, right = 22, top = 6, bottom = 18;
    const x = (t) => left + ((t - end + SPAN_S) / SPAN_S) * (w - left - right), y = (v) => top + ((high - v) / (high - low)) * (h - top - bottom);
    g.font = "11px system-ui, sans-serif"; g.textBaseline = "middle"; g.textAlign = "right"; g.lineWidth = 1;
    const step = niceStep((high - low) / 4), digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
    for (let v = Math.ceil(low / step) * step; v <= high; v += step) {
      g.strokeStyle = css("--line"); g.beginPath(); g.moveTo(left, y(v)); g.lineTo(w - right, y(v)); g.stroke();
      g.fillStyle = css("--faint"); g.fillText(v.toFixed(digits), left - 5, y(v));
    }
    g.textAlign = "center";
    for (let k = 0; k <= SPAN_S; k += 2) g.fillText(k === SPAN_S ? "now" : k - SPAN_S + " s", x(end - SPAN_S + k), h - 7);
    g.save(); g.beginPath(); g.rect(left, top, w - left - right, h - top - bottom); g.clip();
    ["--x", "--y", "--z"].forEach((name, i) => {
      const colour = css(name);
      const runs = [[]];
      for (const p of values) {
        const run = runs[runs.length - 1], before = run[run.length - 1];
        if (!p.v || (before && (p.t - before.t > 0.5 || Math.abs(p.v.value[i] - before.v.value[i]) > 180))) runs.push([]);
        if (p.v) runs[runs.length - 1].push(p);
      }
      for (const run of runs) {
        g.fillStyle = colour; g.globalAlpha = 0.22; g.beginPath();
        run.forEach((p, k) => g[k ? "lineTo" : "moveTo"](x(p.t), y(p.v.value[i] + 3 * p.v.sigma[i])));
        run.slice().reverse().forEach((p) => g.lineTo(x(p.t), y(p.v.value[i] - 3 * p.v.sigma[i])));
        g.fill(); g.globalAlpha = 1; g.strokeStyle = colour; g.lineWidth = 1.5; g.setLineDash([[], [6, 2], [2, 2]][i]); g.beginPath();
        run.forEach((p, k) => g[k ? "lineTo" : "moveTo"](x(p.t), y(p.v.value[i])));
        g.stroke(); g.setLineDash([]);
      }
    });
    g.restore();
    const last = values[values.length - 1];
    if (last && last.v) {
      const names = canvas.dataset.plot === "attitude" ? ["r", "p", "y"] : ["x", "y", "z"];
      const places = last.v.value.map((v, i) => ({ i, y: Math.min(h - bottom - 4, Math.max(top + 5, y(v))) })).sort((a, b) => a.y - b.y);
      places.forEach((p, k) => { if (k && p.y - places[k - 1].y < 11) p.y = places[k - 1].y + 11; });
      g.textAlign = "left"; g.font = "600 12px system-ui, sans-serif";
      for (const p of places) { g.fillStyle = css(["--x", "--y", "--z"][p.i]); g.fillText(names[p.i], w - right + 6, p.y); }
    }
  }

  // ---- drawing, when there is anything new, at the screen's pace ----
  let drawn = 0, described = -1e9;
  function draw(now) {
    requestAnimationFrame(draw);
    if (!dirty || now - drawn < 30) return;
    dirty = false;
    drawn = now;
    if (!setup) return;
    const shown = body().shown || body().states;
    drawView();
    drawPath();
    document.querySelectorAll(".plot").forEach((canvas) => drawPlot(canvas, shown));
    tellState(shown);
    if (shown.length && now - described > 2000) { described = now; describe(shown); }
  }

  // ---- what the person does ----
  function togglePause() {
    paused = !paused;
    for (const of of bodies.values()) of.shown = paused ? of.states.slice() : null;
    $("pause").setAttribute("aria-pressed", String(paused));
    setText("pause", paused ? "Go on" : "Pause");
    dirty = true;
  }
  function toggleRecord() {
    if (!setup || !setup.can_record || !link.isOpen()) return;
    const on = $("record").getAttribute("aria-pressed") !== "true";
    link.socket.send(JSON.stringify({ type: "record", on }));
  }
  const TURN = Math.PI / 12;
  const VIEW = {
    in: () => (view.zoom = Math.min(50, 1.25 * view.zoom)), out: () => (view.zoom = Math.max(0.1, view.zoom / 1.25)),
    left: () => (view.turn += TURN), right: () => (view.turn -= TURN),
    tilt: () => (view.tilt = view.tilt > 1.2 ? 0 : view.tilt + TURN), untilt: () => (view.tilt = Math.max(0, view.tilt - TURN)),
    above: () => Object.assign(view, { turn: 0, tilt: 0, zoom: 1 }),
  };
  const look = (how) => { VIEW[how](); dirty = true; };
  function next(id) {
    if ($(id).hidden) return;
    $(id).selectedIndex = ($(id).selectedIndex + 1) % $(id).length;
    chosen();
  }
  function chosen() {
    if (setup) tellCamera();
    described = -1e9;
    dirty = true;
  }
  $("body").onchange = $("camera").onchange = chosen;
  $("pause").onclick = togglePause;
  $("record").onclick = toggleRecord;
  document.querySelectorAll("[data-view]").forEach((b) => (b.onclick = () => look(b.dataset.view)));
  document.addEventListener("keydown", (e) => {
    if (e.ctrlKey || e.metaKey || e.altKey || e.target.tagName === "SELECT") return;
    if (e.key === "p") togglePause();
    if (e.key === "r") toggleRecord();
    if (e.key === "b") next("body");
    if (e.key === "c") next("camera");
  });
  const KEYS = { ArrowLeft: "left", ArrowRight: "right", ArrowUp: "tilt", ArrowDown: "untilt", "+": "in", "=": "in", "-": "out", 0: "above" };
  $("path").addEventListener("keydown", (e) => {
    if (!KEYS[e.key] || e.ctrlKey || e.metaKey) return;
    look(KEYS[e.key]);
    e.preventDefault();
  });
  $("path").addEventListener("wheel", (e) => {
    if (document.activeElement !== $("path")) return;
    look(e.deltaY < 0 ? "in" : "out");
    e.preventDefault();
  }, { passive: false });
  let drag = null;
  $("path").addEventListener("pointerdown", (e) => { drag = [e.clientX, e.clientY]; e.target.setPointerCapture(e.pointerId); });
  $("path").addEventListener("pointermove", (e) => {
    if (!drag) return;
    view.turn -= (e.clientX - drag[0]) / 150;
    view.tilt = Math.max(0, Math.min(1.4, view.tilt + (e.clientY - drag[1]) / 150));
    drag = [e.clientX, e.clientY];
    dirty = true;
  });
  ["pointerup", "pointercancel"].forEach((name) => $("path").addEventListener(name, () => (drag = null)));
  addEventListener("resize", () => (dirty = true));
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => (dirty = true));
  link = Page.connect({ text: takeText, picture: takePicture, lost: lose });
  requestAnimationFrame(draw);
})();
