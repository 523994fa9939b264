"use strict";
// Draws the page's charts. Nothing here comes from a file that was read: text arrives as data, escaped.
// an array of the page's data, as pack.py wrote it
function camrobArray(bytes, [at, length, count, columns, step, whole]) {
  const out = new (whole ? Int32Array : Float64Array)(count * columns), inverse = Math.round(1 / step);
  const most = Math.abs(inverse * step - 1) < 1e-9 ? inverse : 0; // a division gives the decimal that was meant
  let k = at;
  for (let column = 0; column < columns; column++) {
    for (let row = 0, steps = 0; row < count; row++) {
      let code = 0, byte = 128;
      for (let place = 1; byte & 128; place *= 128) { byte = bytes[k++]; code += (byte & 127) * place; }
      if (code) steps += code % 2 ? (code - 1) / 2 : -code / 2;
      out[row * columns + column] = code ? (most ? steps / most : steps * step) : NaN;
    }
  }
  if (k !== at + length) throw new Error("the page's data are damaged");
  return out;
}
// lines of a program, as pack.py parted them into their words and their numbers
function camrobLines({ forms, decimals, form, numbers }) {
  const words = forms.map((text) => text.split("\0")), next = forms.map(() => 0);
  return Array.from(form, (f) => {
    let line = words[f][0];
    decimals[f].forEach((places, k) => { line += (numbers[f][next[f]++] / 10 ** places).toFixed(places) + words[f][k + 1]; });
    return line;
  });
}
const camrobColor = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

// colours of 1/k_F from 0 to its highest: reds below the threshold (a share), amber at it, greens to blue above; made(hex) is a
// colour, mixed(a, b, share) one between two
function camrobScale(threshold, made, mixed) {
  const t = Math.min(0.95, Math.max(0.05, threshold));
  const scale = [[0, "#67001f"], [0.7 * t, "#d6302b"], [t, "#f5a623"], [t + 0.3 * (1 - t), "#35a883"], [1, "#2166ac"]].map(([x, c]) => [x, made(c)]);
  return (share) => {
    const x = Math.min(1, Math.max(0, share));
    let k = 1;
    while (k < scale.length - 1 && scale[k][0] < x) k++;
    const [x0, a] = scale[k - 1], [x1, b] = scale[k];
    return mixed(a, b, Math.min(1, Math.max(0, (x - x0) / (x1 - x0))));
  };
}

// names: of the regions by their numbers; onPick(x): somebody clicked at x of a chart along the path
function camrobCharts(names, onPick) {
  const css = camrobColor;
  const regionName = (index) => (index < 0 ? "between regions" : names[index] || "region " + index);
  const place = (line, region) => (line > 0 ? "CL line " + line + " · " : "") + regionName(region);

  // ---- look: colours of the page, light or dark, in every picture
  function theme() {
    const title = { font: { size: 13 } };
    const axis = { gridcolor: css("--grid"), linecolor: css("--line"), tickcolor: css("--line"), showline: true, exponentformat: "power", title };
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
  const every = []; // with those whose x is no length or time that others share
  const drawn = [];
  let zooming = false;
  // lines of charts that nobody sees aren't moved
  const onScreen = new Map();
  const looked = new IntersectionObserver((entries) => entries.forEach((entry) => {
    const own = onScreen.get(entry.target);
    own.seen = entry.isIntersecting;
    if (own.seen) markIn(own);
  }), { rootMargin: "200px" });

  // a map's picture: 1/k_F in colours, what can't be in greys
  function painted(map) {
    const canvas = document.createElement("canvas");
    canvas.width = map.columns; canvas.height = map.rows;
    const context = canvas.getContext("2d"), image = context.createImageData(map.columns, map.rows);
    const rgb = (text) => [1, 3, 5].map((k) => parseInt(text.slice(k, k + 2), 16));
    const scale = camrobScale(map.threshold, rgb, (a, b, share) => a.map((v, c) => v + share * (b[c] - v)));
    const codes = { 301: rgb(css("--map-reach")), 302: rgb(css("--map-limit")), 303: rgb(css("--map-elsewhere")), 304: rgb(css("--map-touch")) };
    map.codes.forEach((value, n) => {
      image.data.set([...(codes[value] || scale(value / map.steps)), 255], 4 * n);
    });
    context.putImageData(image, 0, 0);
    return canvas.toDataURL();
  }
  // the pictures of a chart's maps, in the colours of now; ends: where its x axes end before anybody zooms
  const images = (maps, ends) => maps.map((map) => ({
    source: painted(map), xref: "x" + map.axes, yref: "y" + map.axes, x: 0, y: map.high, sizex: ends[map.axes],
    sizey: map.high - map.low, sizing: "stretch", layer: "below", xanchor: "left", yanchor: "top",
  }));

  function drawChart(chart) {
    const element = document.getElementById(chart.id);
    const maps = chart.maps || [], ends = {};
    maps.forEach((map) => { ends[map.axes] = chart.layout["xaxis" + map.axes].range[1]; });
    chart.layout.images = images(maps, ends);
    chart.traces.forEach((trace) => {
      if (!trace.cl) return;
      trace.text = Array.from(trace.cl.line, (value, k) => place(value, trace.cl.region[k]));
      delete trace.cl;
    });
    chart.layout.template = theme();
    return Plotly.newPlot(element, chart.traces, chart.layout, config).then(() => {
      every.push({ element, recolor: () => (maps.length ? { images: images(maps, ends) } : {}) });
      if (chart.own) return; // its x is no length or time that the others share
      const xs = Object.keys(chart.layout).filter((key) => /^xaxis\d*$/.test(key));
      const lines = xs.map(() => element.appendChild(document.createElement("div")));
      lines.forEach((line) => { line.className = "cursor"; });
      const own = { element, xs, lines, ruler: chart.ruler || "", seen: true };
      drawn.push(own);
      onScreen.set(element, own);
      looked.observe(element);
      element.on("plotly_relayout", (change) => sameZoom(element, change));
      element.on("plotly_afterplot", () => markIn(own));
      if (!own.ruler) pickable(own);
      markIn(own);
    });
  }

  // a click anywhere in a subplot, not a drag, picks its x
  function pickable(own) {
    let pressed = [0, 0];
    own.element.addEventListener("mousedown", (event) => { pressed = [event.clientX, event.clientY]; }, true);
    own.element.addEventListener("click", (event) => {
      if (Math.hypot(event.clientX - pressed[0], event.clientY - pressed[1]) > 3) return;
      const box = own.element.getBoundingClientRect(), px = event.clientX - box.left, py = event.clientY - box.top;
      own.xs.forEach((name) => {
        const x = own.element._fullLayout[name], y = own.element._fullLayout["y" + name.slice(1)];
        const at = px - x._offset, up = py - y._offset;
        if (at >= 0 && at <= x._length && up >= 0 && up <= y._length) onPick(x.p2l(at));
      });
    }, true);
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

  // where the player is, as a line over each subplot: moved without drawing anything anew
  let marked = null;
  function markIn(own) {
    const full = own.element._fullLayout;
    own.xs.forEach((name, k) => {
      const x = full[name], y = full["y" + name.slice(1)];
      const at = marked === null || own.ruler || !x || !y ? -1 : x.l2p(marked);
      const line = own.lines[k];
      line.style.display = at >= 0 && at <= x._length ? "block" : "none";
      if (!(at >= 0)) return;
      line.style.transform = "translate(" + (x._offset + at).toFixed(1) + "px," + y._offset + "px)";
      line.style.height = y._length + "px";
    });
  }
  function mark(s) {
    marked = s;
    drawn.filter((own) => own.seen).forEach(markIn);
  }

  // paper is narrower than the screen: a chart shrinks as a picture, in the frame that it was drawn in
  function frame() {
    every.forEach(({ element }) => {
      const { width, height } = element._fullLayout;
      element.querySelectorAll(".main-svg").forEach((svg) => svg.setAttribute("viewBox", `0 0 ${width} ${height}`));
      [element, element.querySelector(".svg-container")].forEach((box) => { box.style.aspectRatio = width + "/" + height; });
    });
  }
  function unframe() {
    every.forEach(({ element }) => {
      element.querySelectorAll(".main-svg").forEach((svg) => svg.removeAttribute("viewBox"));
      [element, element.querySelector(".svg-container")].forEach((box) => { box.style.aspectRatio = ""; });
    });
  }

  return {
    draw: drawChart, mark, place, frame, unframe,
    recolor: () => every.forEach(({ element, recolor }) => Plotly.relayout(element, { template: theme(), ...recolor() })),
  };
}
