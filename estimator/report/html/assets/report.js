// Draws the plots of the page from the data embedded in it. One switch and one time window serve
// all plots: hiding a series hides it everywhere, zooming one plot zooms all.
(function () {
  "use strict";
  const data = JSON.parse(document.getElementById("data").textContent);
  const hidden = new Set();
  const graphs = [];        // {graph, element, plot, visible, stale}
  let timeWindow = null;    // [from, to] in s, null for everything
  let syncing = false;

  const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  const colour = (slot) => css("--s" + (slot % 10));
  const format = (x) => (x === 0 ? "0" : Number(x.toPrecision(4)).toString());

  // Rows as dygraphs wants them: [t, [low, middle, high], ...]; null breaks a line, or is bridged
  // where the plot says that its series have stamps of their own.
  function rows(plot) {
    return plot.t.map((t, i) => {
      const row = [t];
      for (const s of plot.series) {
        const v = s.v[i], w = s.w && s.w[i] !== null ? s.w[i] : 0;
        row.push(v === null ? (plot.connect ? [null, null, null] : [NaN, NaN, NaN])
                            : [v - w, v, v + w]);
      }
      return row;
    });
  }

  // One finger scrolls the page; two zoom the plot.
  function interactionModel() {
    const usual = Dygraph.defaultInteractionModel;
    return Object.assign({}, usual, {
      touchstart: (e, g, c) => { if (e.touches.length > 1) usual.touchstart(e, g, c); },
      touchmove: (e, g, c) => { if (e.touches.length > 1 && c.initialTouches) usual.touchmove(e, g, c); },
      touchend: (e, g, c) => { if (c.initialTouches) usual.touchend(e, g, c); },
      dblclick: () => setWindow(null),
    });
  }

  // Heights of the series shown in the time window, and of nine tenths of their bands: a band may be
  // as wide as the world where an estimate has only begun. Where the plot says so, of all values but
  // the highest twentieth.
  function heights(plot) {
    const [from, to] = timeWindow || [-Infinity, Infinity];
    let low = Infinity, high = -Infinity;
    const lows = [], highs = [], values = [];
    for (const s of plot.series) {
      if (hidden.has(s.slot)) continue;
      for (let i = 0; i < plot.t.length; i++) {
        const v = s.v[i], w = s.w ? s.w[i] : null;
        if (v === null || plot.t[i] < from || plot.t[i] > to) continue;
        low = Math.min(low, v);
        high = Math.max(high, v);
        values.push(v);
        if (w !== null) { lows.push(v - w); highs.push(v + w); }
      }
    }
    if (low > high) return null;
    if (lows.length > 0) {
      lows.sort((a, b) => a - b);
      highs.sort((a, b) => a - b);
      low = Math.min(low, lows[Math.floor(0.05 * lows.length)]);
      high = Math.max(high, highs[Math.floor(0.95 * (highs.length - 1))]);
    }
    if (plot.trim) {
      values.sort((a, b) => a - b);
      high = Math.max(low, 1.1 * values[Math.floor(0.95 * (values.length - 1))]);
    }
    const margin = 0.06 * (high - low) || 0.5;
    return [low - margin, high + margin];
  }

  function share(graph, initial) {
    if (initial || syncing) return;
    const range = graph.xAxisRange(), all = graph.xAxisExtremes();
    const whole = range[0] <= all[0] && range[1] >= all[1];
    const wanted = whole ? null : [range[0], range[1]];
    if (JSON.stringify(wanted) !== JSON.stringify(timeWindow)) setWindow(wanted);
  }

  function setWindow(wanted) {
    timeWindow = wanted;
    for (const g of graphs) g.stale = true;
    refresh();
  }

  function refresh() {
    syncing = true;
    for (const g of graphs) {
      if (!g.stale || !g.visible || !g.graph) continue;
      g.stale = false;
      g.graph.updateOptions({ dateWindow: timeWindow, valueRange: heights(g.plot) });
    }
    syncing = false;
  }

  function visibility(plot) {
    return plot.series.map((s) => !hidden.has(s.slot));
  }

  function looks(plot) {
    return {
      colors: plot.series.map((s) => colour(s.slot)),
      gridLineColor: css("--line"),
      axisLineColor: css("--line"),
    };
  }

  function draw(entry) {
    const plot = entry.plot;
    const values = entry.element.querySelector(".values");
    const options = Object.assign(looks(plot), {
      labels: ["t"].concat(plot.series.map((s, i) => i + ": " + data.slots[s.slot])),
      customBars: true,
      connectSeparatedPoints: plot.connect,
      fillAlpha: 0.18,
      strokeWidth: 1.4,
      highlightCircleSize: 3,
      legend: "never",
      visibility: visibility(plot),
      dateWindow: timeWindow,
      valueRange: heights(plot),
      interactionModel: interactionModel(),
      axes: {
        x: { pixelsPerLabel: 60, axisLabelFormatter: (x) => format(x) + " s" },
        y: { pixelsPerLabel: 28, axisLabelWidth: 58, axisLabelFormatter: format },
      },
      drawCallback: share,
      highlightCallback: (e, x, points) => {
        values.textContent = format(x) + " s: " + points.map((p) => format(p.yval)).join(", ");
      },
      unhighlightCallback: () => { values.textContent = ""; },
    });
    entry.graph = new Dygraph(entry.element.querySelector(".canvas"), rows(plot), options);
    entry.stale = false;
  }

  function legends() {
    for (const legend of document.querySelectorAll(".legend")) {
      for (const button of legend.querySelectorAll("button")) {
        const slot = Number(button.dataset.slot);
        button.style.setProperty("--c", "var(--s" + (slot % 10) + ")");
        button.addEventListener("click", () => toggle(slot));
      }
    }
  }

  function toggle(slot) {
    if (hidden.has(slot)) hidden.delete(slot); else hidden.add(slot);
    for (const button of document.querySelectorAll('.legend button[data-slot="' + slot + '"]')) {
      button.setAttribute("aria-pressed", String(!hidden.has(slot)));
    }
    for (const path of document.querySelectorAll('svg .path[data-slot="' + slot + '"]')) {
      path.style.display = hidden.has(slot) ? "none" : "";
    }
    syncing = true;
    for (const g of graphs) {
      if (g.graph && g.plot.series.some((s) => s.slot === slot)) {
        g.graph.updateOptions({ visibility: visibility(g.plot), valueRange: heights(g.plot) });
      }
    }
    syncing = false;
  }

  // Plots are drawn when they come into view; those in view from the start at once, and all of them
  // before the page is printed.
  function watch() {
    const observer = new IntersectionObserver((entries) => {
      for (const seen of entries) {
        const entry = graphs.find((g) => g.element === seen.target);
        entry.visible = seen.isIntersecting;
        if (entry.visible && !entry.graph) draw(entry);
      }
      refresh();
    }, { rootMargin: "300px" });
    for (const element of document.querySelectorAll(".plot")) {
      graphs.push({ element: element, plot: data.plots[Number(element.dataset.plot)], graph: null,
                    visible: false, stale: false });
      observer.observe(element);
    }
    for (const entry of graphs) {
      entry.visible = entry.element.getBoundingClientRect().top < innerHeight + 300;
      if (entry.visible) draw(entry);
    }
    addEventListener("beforeprint", () => {
      for (const entry of graphs) if (!entry.graph) draw(entry);
    });
  }

  // The picture from above: wheel zooms at the pointer, drag moves, double-click shows all.
  function zoomable(svg) {
    const whole = svg.getAttribute("viewBox").split(" ").map(Number);
    let box = whole.slice(), from = null;
    const show = () => svg.setAttribute("viewBox", box.join(" "));
    const at = (e) => {
      const p = new DOMPoint(e.clientX, e.clientY).matrixTransform(svg.getScreenCTM().inverse());
      return [p.x, p.y];
    };
    svg.addEventListener("wheel", (e) => {
      if (!e.ctrlKey && !e.shiftKey && box[2] === whole[2] && e.deltaY > 0) return;
      e.preventDefault();
      const [x, y] = at(e), f = Math.min(Math.exp(0.0015 * e.deltaY), whole[2] / box[2]);
      box = [x - f * (x - box[0]), y - f * (y - box[1]), f * box[2], f * box[3]];
      show();
    }, { passive: false });
    svg.addEventListener("pointerdown", (e) => { if (e.pointerType === "mouse") from = at(e); });
    window.addEventListener("pointerup", () => { from = null; });
    svg.addEventListener("pointermove", (e) => {
      if (!from) return;
      const [x, y] = at(e);
      box[0] += from[0] - x;
      box[1] += from[1] - y;
      show();
    });
    svg.addEventListener("dblclick", () => { box = whole.slice(); show(); });
  }

  legends();
  watch();
  for (const svg of document.querySelectorAll("svg.zoomable")) zoomable(svg);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
    for (const g of graphs) if (g.graph) g.graph.updateOptions(looks(g.plot));
  });
})();
