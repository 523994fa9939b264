"use strict";
// Draws the page's charts. Nothing here comes from a file that was read: text arrives as data, escaped.
function camrobUnpack(packed) {
  const kinds = { f4: Float32Array, i4: Int32Array, u2: Uint16Array };
  return new kinds[packed.dtype](Uint8Array.from(atob(packed.bdata), (c) => c.charCodeAt(0)).buffer);
}
const camrobColor = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

// names: of the regions by their numbers; onPick(x): somebody clicked at x of a chart along the path
function camrobCharts(names, onPick) {
  const css = camrobColor, unpack = camrobUnpack;
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
    return Plotly.newPlot(element, chart.traces, chart.layout, config).then(() => {
      if (chart.own) return; // its x is no length or time that the others share
      const xs = Object.keys(chart.layout).filter((key) => /^xaxis\d*$/.test(key));
      const lines = xs.map(() => element.appendChild(document.createElement("div")));
      lines.forEach((line) => { line.className = "cursor"; });
      const own = { element, xs, lines, ruler: chart.ruler || "" };
      drawn.push(own);
      element.on("plotly_relayout", (change) => sameZoom(element, change));
      element.on("plotly_afterplot", () => markIn(own));
      element.on("plotly_click", (event) => { if (!own.ruler) onPick(event.points[0].x); });
      markIn(own);
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
    drawn.forEach(markIn);
  }

  return {
    draw: drawChart, mark, place,
    recolor: () => drawn.forEach(({ element }) => Plotly.relayout(element, { template: theme() })),
  };
}
