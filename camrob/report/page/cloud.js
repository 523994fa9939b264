"use strict";
// Points in space, coloured by a value: drawn by the processor, at once and on any machine, and printed as they are seen.

// one cloud of the page's data (cloud.py) in its place
function camrobCloud(cloud) {
  const element = document.getElementById(cloud.id), canvas = document.createElement("canvas"), said = document.createElement("p");
  canvas.tabIndex = 0;
  canvas.setAttribute("role", "img");
  canvas.setAttribute("aria-label", element.getAttribute("aria-label") + "; arrow keys turn it, + and - bring it nearer");
  said.className = "said";
  element.append(canvas, said);
  const context = canvas.getContext("2d"), { points, values } = cloud, N = values.length;
  const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
  for (let k = 0; k < points.length; k++) { low[k % 3] = Math.min(low[k % 3], points[k]); high[k % 3] = Math.max(high[k % 3], points[k]); }
  const middle = low.map((v, d) => 0.5 * (v + high[d]));

  // ---- colours: as bytes, by 256 steps
  const rgb = (text) => [1, 3, 5].map((k) => parseInt(text.slice(k, k + 2), 16));
  const stops = cloud.scale.map(([at, color]) => [at, rgb(color)]), shades = new Uint32Array(256);
  for (let n = 0; n < 256; n++) {
    const x = n / 255;
    let k = 1;
    while (k < stops.length - 1 && stops[k][0] < x) k++;
    const share = (x - stops[k - 1][0]) / (stops[k][0] - stops[k - 1][0]);
    const [r, g, b] = stops[k][1].map((v, c) => Math.round(stops[k - 1][1][c] + share * (v - stops[k - 1][1][c])));
    shades[n] = 0xff000000 | (b << 16) | (g << 8) | r;
  }
  const color = Float64Array.from(values, (v) => Math.round(255 * Math.min(1, Math.max(0, (v - cloud.low) / (cloud.high - cloud.low)))));

  // ---- the view: from the direction (turn, rise), parallel, `zoom` times what just fits
  const [ex, ey, ez] = cloud.eye;
  let turn = Math.atan2(ey, ex), rise = Math.atan2(ez, Math.hypot(ex, ey)), zoom = 1, fit = 1, seen = null;
  const axes = () => {
    const c = Math.cos(turn), s = Math.sin(turn), cr = Math.cos(rise), sr = Math.sin(rise);
    return { right: [-s, c, 0], up: [-c * sr, -s * sr, cr], to: [c * cr, s * cr, sr] };
  };
  const dot = (a, p) => a[0] * (p[0] - middle[0]) + a[1] * (p[1] - middle[1]) + a[2] * (p[2] - middle[2]);
  const corner = (n) => [0, 1, 2].map((d) => ((n >> d) & 1 ? high[d] : low[d]));
  const aside = 84, above = 50; // px for the figures at the edges
  function fitted() {
    const { right, up } = axes();
    let across = 1e-9, tall = 1e-9;
    for (let n = 0; n < 8; n++) { across = Math.max(across, Math.abs(dot(right, corner(n)))); tall = Math.max(tall, Math.abs(dot(up, corner(n)))); }
    fit = Math.min((0.5 * canvas.clientWidth - aside) / across, (0.5 * canvas.clientHeight - above) / tall);
  }

  function draw() {
    const dots = Math.min(2, window.devicePixelRatio || 1), w = Math.round(canvas.clientWidth * dots), h = Math.round(canvas.clientHeight * dots);
    if (!w || !h) return;
    canvas.width = w; canvas.height = h;
    const { right, up, to } = axes(), scale = fit * zoom * dots, radius = Math.max(1, Math.round(1.2 * dots));
    const image = context.createImageData(w, h), pixels = new Uint32Array(image.data.buffer);
    const depth = new Float32Array(w * h).fill(-Infinity);
    seen = new Int32Array(w * h).fill(-1);
    for (let k = 0; k < N; k++) {
      if (Number.isNaN(color[k])) continue;
      const x = points[3 * k] - middle[0], y = points[3 * k + 1] - middle[1], z = points[3 * k + 2] - middle[2];
      const u = Math.round(0.5 * w + scale * (right[0] * x + right[1] * y)), v = Math.round(0.5 * h - scale * (up[0] * x + up[1] * y + up[2] * z));
      if (u < radius || v < radius || u >= w - radius || v >= h - radius) continue;
      const near = to[0] * x + to[1] * y + to[2] * z, shade = shades[color[k]];
      for (let b = v - radius; b <= v + radius; b++) for (let n = b * w + u - radius; n <= b * w + u + radius; n++)
        if (near > depth[n]) { depth[n] = near; pixels[n] = shade; seen[n] = k; }
    }
    context.putImageData(image, 0, 0);
    context.globalCompositeOperation = "destination-over"; // behind the points
    frame((p) => [0.5 * w + scale * dot(right, p), 0.5 * h - scale * dot(up, p)], dots);
    context.globalCompositeOperation = "source-over";
  }

  // ---- the room round the points: its floor, one upright edge, and figures along those edges that are seen farthest out
  function frame(place, dots) {
    context.strokeStyle = camrobColor("--line"); context.lineWidth = dots;
    context.fillStyle = camrobColor("--soft"); context.font = 12 * dots + "px system-ui, sans-serif";
    context.textAlign = "center"; context.textBaseline = "middle";
    const line = (a, b) => { context.beginPath(); context.moveTo(...place(a)); context.lineTo(...place(b)); context.stroke(); };
    [[0, 1], [1, 3], [3, 2], [2, 0]].forEach(([a, b]) => line(corner(a), corner(b)));
    const heart = place(middle);
    const edges = [ // of each axis: the bits of the corners that its edge may begin at, and what is sought
      { d: 0, from: [0, 2], sort: (p) => p[1] }, { d: 1, from: [0, 1], sort: (p) => p[1] }, { d: 2, from: [0, 1, 2, 3], sort: (p) => -p[0] },
    ];
    for (const { d, from, sort } of edges) {
      const ends = from.map((n) => [corner(n), corner(n | (1 << d))]);
      const value = ([a, b]) => sort(place(a)) + sort(place(b));
      const [a, b] = ends.reduce((best, e) => (value(e) > value(best) ? e : best));
      if (d === 2) line(a, b);
      const pa = place(a), pb = place(b), long = Math.hypot(pb[0] - pa[0], pb[1] - pa[1]), span = high[d] - low[d];
      const most = Math.floor(long / (58 * dots));
      const out = [0.5 * (pa[0] + pb[0]) - heart[0], 0.5 * (pa[1] + pb[1]) - heart[1]], size = Math.hypot(...out) || 1;
      const beside = (p, far) => [p[0] + (out[0] / size) * far * dots, p[1] + (out[1] / size) * far * dots];
      context.fillText("xyz"[d] + " [mm]", ...beside([0.5 * (pa[0] + pb[0]), 0.5 * (pa[1] + pb[1])], most ? 34 + 24 * Math.abs(out[0]) / size : 24));
      if (!most || !(span > 0)) continue;
      const raw = span / most, power = 10 ** Math.floor(Math.log10(raw)), step = [1, 2, 5, 10].find((m) => m * power >= raw) * power;
      for (let t = Math.ceil(low[d] / step) * step; t <= high[d] + 1e-9 * span; t += step) {
        const share = (t - low[d]) / span, p = [pa[0] + share * (pb[0] - pa[0]), pa[1] + share * (pb[1] - pa[1])];
        const digits = Math.max(0, -Math.floor(Math.log10(step)));
        context.fillText((Math.abs(t) < 1e-9 * span ? 0 : t).toFixed(digits).replace("-", "−"), ...beside(p, 14));
      }
    }
  }

  // ---- hands
  let asked = false;
  const again = () => { if (!asked) { asked = true; requestAnimationFrame(() => { asked = false; draw(); }); } };
  function turned(by, up) { turn -= by; rise = Math.min(1.57, Math.max(-1.57, rise + up)); again(); }
  let held = null;
  canvas.addEventListener("pointerdown", (event) => { held = [event.clientX, event.clientY]; canvas.setPointerCapture(event.pointerId); });
  canvas.addEventListener("pointerup", () => { held = null; });
  canvas.addEventListener("pointermove", (event) => {
    if (held) { turned(0.008 * (event.clientX - held[0]), 0.008 * (event.clientY - held[1])); held = [event.clientX, event.clientY]; return; }
    const box = canvas.getBoundingClientRect(), dots = canvas.width / box.width;
    const k = seen ? seen[Math.floor((event.clientY - box.top) * dots) * canvas.width + Math.floor((event.clientX - box.left) * dots)] : -1;
    said.textContent = k >= 0 ? words(k) : "";
  });
  const words = (k) => cloud.label + " " + values[k].toFixed(3).replace("-", "−") + " mm at " +
    [0, 1, 2].map((d) => points[3 * k + d].toFixed(1).replace("-", "−")).join(", ") + " mm" +
    (cloud.line && cloud.line[k] > 0 ? ", line " + cloud.line[k] : "") + (cloud.sources.length > 1 ? ", " + cloud.sources[cloud.source[k]] : "");
  canvas.addEventListener("wheel", (event) => { // the page scrolls on, unless the picture was chosen
    if (document.activeElement !== canvas) return;
    event.preventDefault(); zoom *= Math.exp(-0.0015 * event.deltaY); again();
  }, { passive: false });
  canvas.addEventListener("keydown", (event) => {
    const turns = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, -0.1], ArrowDown: [0, 0.1] }[event.key];
    const nearer = { "+": 1.15, "=": 1.15, "-": 1 / 1.15 }[event.key];
    if (!turns && !nearer) return;
    event.preventDefault();
    if (nearer) { zoom *= nearer; again(); } else turned(...turns);
  });
  canvas.addEventListener("dblclick", () => { turn = Math.atan2(ey, ex); rise = Math.atan2(ez, Math.hypot(ex, ey)); zoom = 1; again(); });
  new ResizeObserver(() => { fitted(); draw(); }).observe(canvas);
  fitted(); draw();
  return { draw };
}
