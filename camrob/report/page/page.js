"use strict";
// Draws the page from its data blocks. Nothing here comes from a file that was read: text arrives as data, escaped.
(function () {
  const block = (id) => {
    const element = document.getElementById(id);
    return element ? JSON.parse(element.textContent) : null;
  };
  const names = block("names") || {};
  const charts = block("charts") || [];
  const scene = block("scene");
  const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

  function unpack(packed) {
    const bytes = Uint8Array.from(atob(packed.bdata), (c) => c.charCodeAt(0));
    return packed.dtype === "f4" ? new Float32Array(bytes.buffer) : new Int32Array(bytes.buffer);
  }
  const regionName = (index) => (index < 0 ? "between regions" : names[index] || "region " + index);
  const place = (line, region) => (line > 0 ? "CL line " + line + " · " : "") + regionName(region);

  // ---- look: colours of the page, light or dark, in every picture
  function theme() {
    const title = { font: { size: 13 } };
    const axis = { gridcolor: css("--grid"), linecolor: css("--line"), tickcolor: css("--line"), showline: true, title };
    const solid = { gridcolor: css("--grid"), color: css("--soft"), showbackground: false, zerolinecolor: css("--grid"), title };
    return {
      layout: {
        paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)",
        font: { color: css("--text"), size: 13, family: 'system-ui, "Segoe UI", Roboto, Arial, sans-serif' },
        hoverlabel: { bgcolor: css("--panel"), bordercolor: css("--line"), font: { color: css("--text") } },
        modebar: { bgcolor: "rgba(0,0,0,0)", color: css("--soft"), activecolor: css("--accent") },
        xaxis: axis, yaxis: axis, scene: { xaxis: solid, yaxis: solid, zaxis: solid },
      },
    };
  }
  const config = {
    responsive: true, displaylogo: false, showTips: false, showSendToCloud: false, plotlyServerURL: "",
    modeBarButtonsToRemove: ["lasso2d", "select2d", "autoScale2d", "sendDataToCloud", "sendChartToCloud", "tableRotation"],
  };

  // ---- charts along the path
  const drawn = [];
  let zooming = false;

  function drawChart(chart) {
    const element = document.getElementById(chart.id);
    chart.traces.forEach((trace) => {
      if (!trace.cl) return;
      const line = unpack(trace.cl.line);
      const region = unpack(trace.cl.region);
      trace.text = Array.from(line, (value, k) => place(value, region[k]));
      delete trace.cl;
    });
    chart.layout.template = theme();
    const bands = (chart.layout.shapes || []).length;
    return Plotly.newPlot(element, chart.traces, chart.layout, config).then(() => {
      if (chart.own) return; // its x is no length or time that the others share
      const xs = Object.keys(chart.layout).filter((key) => /^xaxis\d*$/.test(key));
      drawn.push({ element, bands, xs, ruler: chart.ruler || "" });
      element.on("plotly_relayout", (change) => sameZoom(element, change));
      element.on("plotly_click", (event) => goNear(event.points[0].x));
    });
  }

  function sameZoom(source, change) {
    if (zooming) return;
    const key = Object.keys(change).find((name) => /^xaxis\d*\.(range|autorange)/.test(name));
    if (!key) return;
    zooming = true;
    const update = { "xaxis.range": source.layout[key.split(".")[0]].range.slice() };
    // charts over the same length are zoomed together; those of another ruler measure something else
    const ruler = drawn.find((d) => d.element === source).ruler;
    Promise.all(drawn.filter((d) => d.element !== source && d.ruler === ruler).map((d) => Plotly.relayout(d.element, update)))
      .then(() => { zooming = false; }, () => { zooming = false; });
  }

  function markCharts(s) {
    drawn.forEach(({ element, bands, xs }) => {
      const shapes = element.layout.shapes.slice(0, bands);
      xs.forEach((x) => {
        const id = x.slice(5);
        shapes.push({
          type: "line", xref: "x" + id, yref: "y" + id + " domain", x0: s, x1: s, y0: 0, y1: 1,
          line: { color: css("--soft"), width: 1.2, dash: "dot" },
        });
      });
      Plotly.relayout(element, { shapes });
    });
  }

  // ---- 3D view
  const view = document.getElementById("view");
  let matrices, stopS, stopLine, stopRegion, stopKf, stopAxes, meshes, track, scaleOf;
  let current = 0;
  let pending = false;
  let timer = null;

  function moved(vertices, stop, frame, out) {
    const o = (stop * scene.frames.length + frame) * 12;
    const m = matrices;
    const n = vertices.length / 3;
    for (let k = 0; k < n; k++) {
      const x = vertices[3 * k], y = vertices[3 * k + 1], z = vertices[3 * k + 2];
      out.x[k] = m[o] * x + m[o + 1] * y + m[o + 2] * z + m[o + 3];
      out.y[k] = m[o + 4] * x + m[o + 5] * y + m[o + 6] * z + m[o + 7];
      out.z[k] = m[o + 8] * x + m[o + 9] * y + m[o + 10] * z + m[o + 11];
    }
    return out;
  }
  const room = (n) => ({ x: new Float32Array(n), y: new Float32Array(n), z: new Float32Array(n) });

  // bodies of one colour that move together are one mesh
  function mergeBodies() {
    const groups = new Map();
    scene.bodies.forEach((body) => {
      const key = body.color + "/" + body.frame + (body.role === "part" ? "/part" : "");
      if (!groups.has(key)) groups.set(key, { color: body.color, role: body.role, frame: body.frame, names: [], v: [], f: [], count: 0 });
      const group = groups.get(key);
      const vertices = unpack(body.vertices);
      const faces = unpack(body.faces);
      for (let k = 0; k < vertices.length; k++) group.v.push(vertices[k]);
      for (let k = 0; k < faces.length; k++) group.f.push(faces[k] + group.count);
      group.count += vertices.length / 3;
      group.names.push(body.name);
    });
    return Array.from(groups.values());
  }

  function meshTrace(group, stop) {
    const at = moved(group.v, stop, group.frame, room(group.count));
    const pick = (offset) => Int32Array.from({ length: group.f.length / 3 }, (_, k) => group.f[3 * k + offset]);
    const part = group.role === "part";
    return {
      type: "mesh3d", x: at.x, y: at.y, z: at.z, i: pick(0), j: pick(1), k: pick(2), color: group.color, flatshading: true,
      lighting: { ambient: 0.66, diffuse: 0.5, specular: 0.12, roughness: 0.8, fresnel: 0.05 },
      lightposition: { x: 4000, y: -3000, z: 9000 }, showscale: false, showlegend: false,
      hoverinfo: part ? "skip" : "text", text: group.names.join(", "),
    };
  }

  // colours of 1/k_F: reds below the threshold, amber at it, greens to blue above
  function kfScale() {
    const t = Math.min(0.95, Math.max(0.05, scene.threshold / scene.highest));
    return [[0, "#67001f"], [0.7 * t, "#d6302b"], [t, "#f5a623"], [t + 0.3 * (1 - t), "#35a883"], [1, "#2166ac"]];
  }

  function readPath() {
    const p = unpack(scene.path.p), kf = unpack(scene.path.kf), line = unpack(scene.path.line);
    const region = unpack(scene.path.region), cut = unpack(scene.path.cut);
    const cutting = { p: [], kf: [], text: [] };
    const air = { p: [], text: [] };
    const put = (to, k, gap) => {
      to.p.push(gap ? NaN : p[3 * k], gap ? NaN : p[3 * k + 1], gap ? NaN : p[3 * k + 2]);
      if (to.kf) to.kf.push(kf[k]);
      to.text.push(gap ? "" : place(line[k], region[k]) + "<br>1/k<sub>F</sub> " + kf[k].toFixed(3));
    };
    for (let k = 0; k < cut.length; k++) {
      const to = cut[k] ? cutting : air;
      if (k > 0 && cut[k] !== cut[k - 1]) { put(to, k, true); put(to, k - 1, false); }
      put(to, k, false);
    }
    return { cutting, air };
  }

  function pathTraces(stop) {
    const a = moved(track.cutting.p, stop, scaleOf.base, room(track.cutting.kf.length));
    const b = moved(track.air.p, stop, scaleOf.base, room(track.air.text.length));
    const hover = { hovertemplate: "%{text}<extra></extra>", showlegend: false };
    const bar = {
      title: { text: "1/k<sub>F</sub>", side: "top" }, thickness: 14, len: 0.72, x: 0.99, xanchor: "right", tickformat: ".1f", outlinewidth: 0,
    };
    return [
      { type: "scatter3d", mode: track.cutting.kf.length > 1 ? "lines" : "markers", x: a.x, y: a.y, z: a.z, text: track.cutting.text, ...hover,
        line: { width: 4, color: track.cutting.kf, colorscale: kfScale(), cmin: 0, cmax: scene.highest, showscale: true, colorbar: bar },
        marker: {
          size: 5, color: track.cutting.kf, colorscale: kfScale(), cmin: 0, cmax: scene.highest,
          showscale: track.cutting.kf.length === 1, colorbar: bar,
        } },
      { type: "scatter3d", mode: "lines", x: b.x, y: b.y, z: b.z, text: track.air.text, ...hover, line: { width: 2, color: "#8a93a0" } },
      { type: "scatter3d", mode: "markers", ...tip(stop), hoverinfo: "skip", showlegend: false, marker: { size: 6, color: "#111", line: { color: "#fff", width: 2 } } },
    ];
  }

  function tip(stop) {
    const o = (stop * scene.frames.length + scaleOf.tool) * 12;
    return { x: [matrices[o + 3]], y: [matrices[o + 7]], z: [matrices[o + 11]] };
  }

  function cameras() {
    const [low, high] = scene.view;
    const span = low.map((v, k) => high[k] - v);
    const unit = Math.cbrt(span[0] * span[1] * span[2]);
    const middle = low.map((v, k) => 0.5 * (v + high[k]));
    const points = track.cutting.p.length ? track.cutting.p : track.air.p;
    const at = moved(points, current, scaleOf.base, room(points.length / 3));
    const range = ["x", "y", "z"].map((c) => {
      let a = Infinity, b = -Infinity;
      at[c].forEach((v) => { if (v < a) a = v; if (v > b) b = v; });
      return [a, b];
    });
    const center = range.map(([a, b], k) => (0.5 * (a + b) - middle[k]) / unit);
    const size = Math.max(120, Math.hypot(...range.map(([a, b]) => b - a)));
    const point = (v) => ({ x: v[0], y: v[1], z: v[2] });
    const turn = scene.look, whole = Math.hypot(...span) / unit;
    return {
      cell: { center: { x: 0, y: 0, z: -0.1 }, eye: point(turn.map((v) => v * whole * 1.12)), up: { x: 0, y: 0, z: 1 } },
      part: { center: point(center), eye: point(turn.map((v, k) => center[k] + v * 1.5 * size / unit)), up: { x: 0, y: 0, z: 1 } },
      aspect: point(span.map((v) => v / unit)),
    };
  }

  function drawScene() {
    scaleOf = { base: scene.frames.indexOf("base"), tool: scene.frames.indexOf("tool") };
    const stops = scene.stops;
    matrices = unpack(stops.matrices); stopS = unpack(stops.s); stopLine = unpack(stops.line);
    stopRegion = unpack(stops.region); stopKf = unpack(stops.kf); stopAxes = unpack(stops.axes);
    meshes = mergeBodies();
    track = readPath();
    const camera = cameras();
    const [low, high] = scene.view;
    const axis = (name, k) => ({ title: { text: name + " [mm]" }, range: [low[k], high[k]], showspikes: false, nticks: 6, tickformat: ",~f" });
    const layout = {
      template: theme(), margin: { l: 0, r: 0, t: 0, b: 0 }, showlegend: false,
      scene: {
        xaxis: axis("x", 0), yaxis: axis("y", 1), zaxis: axis("z", 2), aspectmode: "manual", aspectratio: camera.aspect, camera: camera.cell,
      },
    };
    const traces = [...meshes.map((group) => meshTrace(group, 0)), ...pathTraces(0)];
    return Plotly.newPlot(view, traces, layout, config);
  }

  function showStop() {
    pending = false;
    const update = { x: [], y: [], z: [] };
    const add = (at) => { update.x.push(at.x); update.y.push(at.y); update.z.push(at.z); };
    meshes.forEach((group) => add(moved(group.v, current, group.frame, room(group.count))));
    pathTraces(current).forEach(add);
    Plotly.restyle(view, update);
    readout();
    markCharts(stopS[current]);
  }

  function readout() {
    const where = document.getElementById("where");
    const remark = scene.stops.remarks[current];
    const kf = stopKf[current];
    // names and remarks were escaped when the page was written
    where.innerHTML = "<b>" + (remark || regionName(stopRegion[current])) + "</b><br>" +
      (stopLine[current] > 0 ? "CL line " + stopLine[current] : "camrob's own move through air") + "<br>" +
      stopS[current].toLocaleString("en", { maximumFractionDigits: 0 }) + " mm along the path<br>" +
      (remark ? "" : '1/k<sub>F</sub> <span class="' + (kf < scene.threshold ? "low" : "") + '">' + kf.toFixed(3) + "</span>");
    scene.axes.forEach((axis, k) => {
      const value = stopAxes[current * scene.axes.length + k];
      const row = document.getElementById("axis-" + k);
      row.querySelector(".v").textContent = value.toFixed(axis.unit === "mm" ? 1 : 2).replace("-", "−") + (axis.unit === "mm" ? " mm" : "°");
      const [low, high] = axis.limits;
      if (low === null || high === null) return;
      const share = Math.min(1, Math.max(0, (value - low) / (high - low)));
      row.querySelector("i").style.left = 100 * share + "%";
      row.querySelector(".gauge").classList.toggle("near", Math.min(share, 1 - share) < 0.03);
    });
  }

  function go(stop) {
    current = Math.min(scene.stops.count - 1, Math.max(0, stop));
    document.getElementById("stop").value = String(current);
    if (!pending) { pending = true; requestAnimationFrame(showStop); }
  }

  function goNear(s) {
    if (!scene || !stopS.length) return;
    let best = 0;
    stopS.forEach((value, k) => { if (Math.abs(value - s) < Math.abs(stopS[best] - s)) best = k; });
    go(best);
  }

  function controls() {
    const slider = document.getElementById("stop");
    slider.max = String(scene.stops.count - 1);
    slider.addEventListener("input", () => go(Number(slider.value)));
    const play = document.getElementById("play");
    play.addEventListener("click", () => {
      if (timer) { clearInterval(timer); timer = null; play.textContent = "Play"; return; }
      play.textContent = "Stop";
      timer = setInterval(() => go(current + 1 >= scene.stops.count ? 0 : current + 1), 150);
    });
    document.getElementById("see-cell").addEventListener("click", () => Plotly.relayout(view, { "scene.camera": cameras().cell }));
    document.getElementById("see-part").addEventListener("click", () => Plotly.relayout(view, { "scene.camera": cameras().part }));
  }

  // ---- start
  let ready = Promise.resolve();
  if (scene) ready = drawScene().then(() => { controls(); readout(); });
  charts.forEach((chart) => { ready = ready.then(() => drawChart(chart)); });
  ready.then(() => { document.body.dataset.ready = "1"; });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
    const update = { template: theme() };
    if (scene) Plotly.relayout(view, update);
    drawn.forEach(({ element }) => Plotly.relayout(element, update));
  });
})();
