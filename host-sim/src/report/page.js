"use strict";
(() => {
  const root = document.documentElement;
  const colour = (name) => getComputedStyle(root).getPropertyValue("--" + name).trim();
  const element = (id) => document.getElementById(id);
  const charts = [];

  // The finger: a stiff tail, three arcs of constant length, a stiff head.
  const motion = data.motion;
  let show = () => {};
  if (motion) {
    const svg = element("live"), slider = element("time"), label = element("now"), button = element("play");
    const along = (from, length, bend) => {
      const half = bend / 2;
      const chord = Math.abs(half) < 1e-9 ? length : (length * Math.sin(half)) / half;
      return { x: from.x + chord * Math.cos(from.t + half), y: from.y + chord * Math.sin(from.t + half), t: from.t + bend };
    };
    const path = (from, length, bend, name, width) => {
      let points = "";
      for (let i = 0; i <= 16; i++) {
        const at = along(from, (length * i) / 16, (bend * i) / 16);
        points += at.x.toFixed(2) + "," + at.y.toFixed(2) + " ";
      }
      return `<polyline points="${points}" fill="none" style="stroke:var(--${name})" stroke-width="${width}" stroke-linejoin="round"/>`;
    };
    const digits = (value, unit) => (value === null ? "–" : value.toFixed(0) + unit);
    show = (index) => {
      const frame = motion.frames[index];
      let at = { x: 0, y: 0, t: 0 };
      let drawn = path(at, END_MM, 0, "end", 22.5);
      at = along(at, END_MM, 0);
      ["proximal", "middle", "distal"].forEach((name, k) => {
        const bend = ((frame[k] ?? 0) * Math.PI) / 180;
        drawn += path(at, CHAMBER_MM, bend, name, 22.5) + path(at, CHAMBER_MM, bend, "fibre", 1.2);
        at = along(at, CHAMBER_MM, bend);
      });
      svg.innerHTML = drawn + path(at, END_MM, 0, "end", 22.5);
      slider.value = index;
      label.textContent = ((motion.start_ms + index * motion.step_ms) / 1000).toFixed(1) + " s   "
        + frame.slice(0, 3).map((v) => digits(v, "°")).join(" · ") + "   "
        + frame.slice(3).map((v) => digits(v, "")).join(" · ") + " kPa";
    };
    slider.max = motion.frames.length - 1;
    slider.oninput = () => show(+slider.value);
    let timer = null;
    button.onclick = () => {
      if (timer) {
        clearInterval(timer);
        timer = null;
      } else {
        timer = setInterval(() => show((+slider.value + 1) % motion.frames.length), motion.step_ms);
      }
      button.textContent = timer ? "Pause" : "Play";
    };
    show(0);
  }
  const showAt = (seconds) => {
    if (motion) {
      const index = Math.floor((seconds * 1000 - motion.start_ms) / motion.step_ms);
      show(Math.min(Math.max(index, 0), motion.frames.length - 1));
    }
  };

  // What all plots share: one cursor, one stretch of time, faults shaded.
  const start = data.bends.times[0], end = Math.max(data.bends.times[data.bends.times.length - 1], start + 0.001);
  const shown = () => {
    const x = charts[0].scales.x;
    const zoomed = x.min > start || x.max < end;
    element("shown").textContent = x.min.toFixed(2) + " s to " + x.max.toFixed(2) + " s" + (zoomed ? "" : ": the whole run");
    element("whole").disabled = !zoomed;
  };
  const hooks = {
    setScale: [(u, key) => {
      if (key !== "x" || charts.length === 0) return;
      const { min, max } = u.scales.x;
      for (const other of charts) {
        const x = other.scales.x;
        if (other !== u && (x.min !== min || x.max !== max)) other.setScale("x", { min, max });
      }
      shown();
    }],
    setCursor: [(u) => {
      if (u.cursor.event && u.cursor.left >= 0) showAt(u.posToVal(u.cursor.left, "x"));
    }],
    drawClear: [(u) => {
      const { ctx, bbox } = u;
      ctx.save();
      ctx.fillStyle = colour("fault");
      for (const fault of data.faults) {
        const left = Math.max(u.valToPos(fault.from_s, "x", true), bbox.left);
        const right = Math.min(u.valToPos(fault.to_s, "x", true), bbox.left + bbox.width);
        if (right > left) ctx.fillRect(left, bbox.top, right - left, bbox.height);
      }
      ctx.restore();
    }],
  };
  const axis = (more) => ({
    stroke: () => colour("soft"), grid: { stroke: () => colour("line"), width: 1 }, ticks: { stroke: () => colour("line"), width: 1 },
    font: "12px system-ui, sans-serif", labelFont: "12px system-ui, sans-serif", ...more,
  });
  const decimals = (step) => Math.max(0, Math.ceil(-Math.log10(step) - 1e-9));
  const options = (place, title, height, more) => ({
    title, height, width: Math.max(place.clientWidth, 320), hooks, ...more,
    cursor: {
      sync: { key: "time", filters: { pub: (kind) => !["mousedown", "mouseup", "dblclick"].includes(kind) } },
      drag: { x: true, y: false, dist: 4 }, focus: { prox: 24 }, ...more.cursor,
    },
    focus: { alpha: 0.35 },
    scales: { x: { time: false, range: (u, min, max) => (min === null ? [start, end] : [Math.max(min, start), Math.min(max, end)]) }, y: more.y },
    axes: [
      axis({ size: 34, values: (u, splits, i, space, step) => splits.map((v) => v.toFixed(decimals(step)) + " s") }),
      axis({ size: 100, ...more.axis }),
    ],
  });

  const lines = (place, plot, height) => {
    const whole = (u) => u.scales.x.min === null || u.scales.x.min === undefined || (u.scales.x.min <= start && u.scales.x.max >= end);
    // Zoomed in time, the values shown take the whole height.
    const range = (u, min, max) => {
      if (min === null || whole(u)) return plot.range;
      const room = Math.max((max - min) * 0.1, 0.5);
      return [min - room, max + room];
    };
    const value = (u, v) => (v === null || v === undefined ? "–" : v.toFixed(2) + (plot.unit === "degrees" ? "°" : " " + plot.unit));
    const series = plot.names.map((label, i) => ({
      label, value, stroke: () => colour(plot.colours[i]), width: plot.widths[i] * 0.75, spanGaps: false, points: { show: false },
    }));
    return new uPlot(options(place, plot.title, height, {
      y: { range }, axis: { label: plot.unit, labelSize: 18, size: 82 },
      series: [{ label: "time", value: (u, v) => (v === null ? "–" : v.toFixed(3) + " s") }, ...series],
    }), [plot.times, ...plot.values], place);
  };

  const bars = (place, timing, height) => {
    const rows = timing.names.length, base = (i) => rows - 1 - i + 0.15;
    const before = (u, index, closest, seconds) => (closest > 0 && timing.times[closest] > seconds ? closest - 1 : closest);
    const series = timing.names.map((label, i) => ({
      label, value: (u, v) => (v === null || v === undefined ? "–" : v > base(i) ? "yes" : "no"),
      stroke: () => colour(timing.colours[i]), fill: () => colour(timing.colours[i]), fillTo: () => base(i), width: 1,
      paths: uPlot.paths.stepped({ align: 1 }), points: { show: false },
    }));
    const at = timing.names.map((name, i) => rows - 0.5 - i);
    return new uPlot(options(place, "pump and valves", height, {
      y: { range: () => [0, rows] }, cursor: { dataIdx: before, focus: { prox: -1 } },
      axis: { splits: () => at, values: () => timing.names, grid: { show: false }, ticks: { show: false } },
      series: [{ label: "since", value: (u, v) => (v === null ? "–" : v.toFixed(3) + " s") }, ...series],
    }), [timing.times, ...timing.states.map((states, i) => states.map((on) => base(i) + 0.7 * on))], place);
  };

  const places = [
    ...data.pressures.map((plot, i) => [element("pressure-" + i), (place) => lines(place, plot, 240)]),
    [element("timing"), (place) => bars(place, data.timing, 240)],
    [element("bend"), (place) => lines(place, data.bends, 300)],
  ];
  const build = () => {
    const x = charts.length > 0 ? charts[0].scales.x : { min: start, max: end };
    const range = { min: x.min, max: x.max };
    charts.splice(0).forEach((chart) => chart.destroy());
    const built = places.map(([place, make]) => make(place));
    charts.push(...built);
    charts.forEach((chart) => chart.setScale("x", range));
  };
  build();
  element("whole").onclick = () => charts[0].setScale("x", { min: start, max: end });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", build);
  addEventListener("resize", () => charts.forEach((chart, i) => {
    chart.setSize({ width: Math.max(places[i][0].clientWidth, 320), height: chart.height });
  }));
  // For the console.
  window.report = { charts, data };
})();
