"use strict";
// the stock within the box that is cut: six sides of heights, each ray with what it shows from when on
function camrobStock(stock, group) {
  const NONE = 65535, STEPS = 65534, BLOCK = 8, LEVEL = 1e-3;
  let stride = 1;
  const raw = new THREE.Color("#b98d5a"), fresh = new THREE.Color("#ead2a4");
  const corners = new Float32Array(stock.vertices);
  const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
  corners.forEach((v, k) => { low[k % 3] = Math.min(low[k % 3], v); high[k % 3] = Math.max(high[k % 3], v); });
  // flat faces, lit as those of the cell's bodies are, by pixels, as a corner belongs to several: for less than three's own take
  const cutLook = new THREE.ShaderMaterial({
    side: THREE.DoubleSide,
    vertexShader: `
      attribute vec3 color; varying vec3 paint, place;
      void main() {
        vec4 at = modelMatrix * vec4(position, 1.0);
        paint = color; place = at.xyz;
        gl_Position = projectionMatrix * viewMatrix * at;
      }`,
    fragmentShader: `
      varying vec3 paint, place;
      void main() {
        vec3 n = normalize(cross(dFdx(place), dFdy(place)));
        float light = 0.43 + 0.67 * max(0.0, dot(n, normalize(vec3(0.4, -0.5, 1.0)))) + 0.16 * max(0.0, dot(n, normalize(vec3(-0.6, 0.7, 0.3))));
        gl_FragColor = vec4(pow(min(vec3(1.0), paint * light), vec3(1.0 / 2.2)), 1.0);
      }`,
  });
  // what is inside the box is shown by the rays
  group.add(camrobFlat(corners, stock.faces, raw, stock.sides && [stock.lower, stock.upper]));
  if (!stock.sides) return { at() {}, face() {}, coarsen() {} };

  const events = [];
  const sides = stock.sides.map((side, number) => {
    const [U, V] = side.size, n = U * V, S = side.stages;
    const summed = (values) => {
      for (let k = n; k < values.length; k++) values[k] = (values[k] + values[k - n]) & 65535;
      return values;
    };
    const height = summed(side.height), far = summed(side.far), since = side.since;
    const d = side.axis, u = (d + 1) % 3, v = (d + 2) % 3;
    // rays that meet the stock's own box; beyond them the surface goes on to the box's edge, or to the stock's
    const span = (axis, first, count) => {
      const inside = (k) => { const x = first + k * stock.pitch; return x > low[axis] && x < high[axis]; };
      let a = 0, b = count - 1;
      while (a < b && !inside(a)) a++;
      while (b > a && !inside(b)) b--;
      const places = [Math.max(stock.lower[axis], low[axis])], from = [a];
      for (let k = a; k <= b; k++) { places.push(first + k * stock.pitch); from.push(k); }
      places.push(Math.min(stock.upper[axis], high[axis])); from.push(b);
      return { places, from, a, b };
    };
    const us = span(u, side.first[0], U), vs = span(v, side.first[1], V);
    const A = us.places.length, B = vs.places.length;
    const position = new Float32Array(3 * A * B), color = new Float32Array(3 * A * B), index = new Uint32Array(6 * (A - 1) * (B - 1));
    const blockRows = Math.ceil((A - 1) / BLOCK), blockColumns = Math.ceil((B - 1) / BLOCK), blocks = new Array(blockRows * blockColumns);
    const stage = new Uint8Array(n);
    for (let k = 0; k < S; k++)
      for (let r = 0; r < n; r++) if (since[k * n + r] !== NONE) events.push({ t: since[k * n + r] / STEPS * stock.end, side: number, ray: r, to: k + 1, from: 0 });
    const geometry = new THREE.BufferGeometry();
    ["position", "color"].forEach((name) => {
      const attribute = new THREE.BufferAttribute(name === "position" ? position : color, 3);
      attribute.setUsage(THREE.DynamicDrawUsage); geometry.setAttribute(name, attribute);
    });
    geometry.setIndex(new THREE.BufferAttribute(index, 1).setUsage(THREE.DynamicDrawUsage));
    const mesh = new THREE.Mesh(geometry, cutLook);
    mesh.frustumCulled = false;
    group.add(mesh);
    const depth = stock.upper[d] - stock.lower[d];
    const rayOf = (i, j) => us.from[i] * V + vs.from[j];
    const at = (values, ray) => { const h = values[stage[ray] * n + ray]; return h === NONE ? NaN : stock.lower[d] + depth * h / STEPS; };
    const steep = 2 * stock.pitch;

    function vertex(i, j) {
      const k = i * B + j, ray = rayOf(i, j), h = at(height, ray), c = stage[ray] ? fresh : raw;
      position[3 * k + u] = us.places[i]; position[3 * k + v] = vs.places[j]; position[3 * k + d] = h;
      color[3 * k] = c.r; color[3 * k + 1] = c.g; color[3 * k + 2] = c.b;
    }
    function quad(out, i, j, i1, j1) {
      const four = [i * B + j, i * B + j1, i1 * B + j, i1 * B + j1];
      let least = Infinity, most = -Infinity, top = 0;
      for (let c = 0; c < 4; c++) {
        const h = position[3 * four[c] + d] * side.facing;
        if (Number.isNaN(h)) return;
        if (h < least) least = h;
        if (h > most) { most = h; top = c; }
      }
      if (most - least > steep) { // a wall only where material stands below the higher ray's surface
        const end = at(far, rayOf(top >> 1 ? i1 : i, top & 1 ? j1 : j)) * side.facing;
        if (end > least + stock.pitch && end < most) return;
      }
      out.push(four[0], four[2], four[1], four[1], four[2], four[3]);
    }
    // triangles of a block of rays: two where it is level, else those of each `stride` rays
    function block(number) {
      const i0 = Math.floor(number / blockColumns) * BLOCK, j0 = (number % blockColumns) * BLOCK;
      const i1 = Math.min(i0 + BLOCK, A - 1), j1 = Math.min(j0 + BLOCK, B - 1), out = [], level = position[3 * (i0 * B + j0) + d];
      let even = true;
      for (let i = i0; even && i <= i1; i++) for (let j = j0; even && j <= j1; j++) even = Math.abs(position[3 * (i * B + j) + d] - level) < LEVEL;
      const by = even ? BLOCK : stride;
      for (let i = i0; i < i1; i += by) for (let j = j0; j < j1; j += by) quad(out, i, j, Math.min(i + by, i1), Math.min(j + by, j1));
      blocks[number] = out;
    }
    for (let i = 0; i < A; i++) for (let j = 0; j < B; j++) vertex(i, j);
    const stale = new Set(blocks.keys());
    const own = { stage, first: 0, last: A - 1 };
    own.face = (eye) => { mesh.visible = side.facing > 0 ? eye[d] > stock.lower[d] : eye[d] < stock.upper[d]; };
    own.set = (ray, to) => {
      stage[ray] = to;
      const i = Math.floor(ray / V) - us.a + 1, j = ray % V - vs.a + 1; // its vertex; borders copy their neighbours
      if (i < 1 || j < 1 || i > A - 2 || j > B - 2) return;
      const is = [i], js = [j];
      if (i === 1) is.push(0); if (i === A - 2) is.push(A - 1);
      if (j === 1) js.push(0); if (j === B - 2) js.push(B - 1);
      is.forEach((a) => js.forEach((b) => {
        vertex(a, b);
        own.first = Math.min(own.first, a); own.last = Math.max(own.last, a);
        for (const x of [a - 1, a]) for (const y of [b - 1, b]) // the blocks that it is a corner of
          if (x >= 0 && y >= 0 && x < A - 1 && y < B - 1) stale.add(Math.floor(x / BLOCK) * blockColumns + Math.floor(y / BLOCK));
      }));
    };
    own.coarsen = () => { for (const number of blocks.keys()) stale.add(number); };
    own.upload = () => {
      if (!stale.size) return;
      stale.forEach(block); stale.clear();
      let n = 0;
      for (const triangles of blocks) { index.set(triangles, n); n += triangles.length; }
      geometry.setDrawRange(0, n);
      const { position, color } = geometry.attributes, rows = own.last - own.first + 1;
      [[position, own.first * 3 * B, rows * 3 * B], [color, own.first * 3 * B, rows * 3 * B], [geometry.index, 0, n]].forEach(([attribute, from, count]) => {
        if (count <= 0) return;
        attribute.clearUpdateRanges(); attribute.addUpdateRange(from, count); attribute.needsUpdate = true;
      });
      own.first = A; own.last = -1;
    };
    return own;
  });
  events.sort((a, b) => a.t - b.t || a.to - b.to);
  const last = sides.map((s) => new Uint8Array(s.stage.length));
  events.forEach((e) => { e.from = last[e.side][e.ray]; last[e.side][e.ray] = e.to; });
  let done = 0;
  return {
    at(t) {
      while (done < events.length && events[done].t <= t) { const e = events[done++]; sides[e.side].set(e.ray, e.to); }
      while (done > 0 && events[done - 1].t > t) { const e = events[--done]; sides[e.side].set(e.ray, e.from); }
      sides.forEach((s) => s.upload());
    },
    // rays that a pixel of so many mm can't tell apart are drawn as one, and at least so many together
    coarsen(mm, least) {
      let by = Math.max(1, least);
      while (2 * by <= BLOCK && 2 * by * stock.pitch <= mm) by *= 2;
      if (by !== stride) { stride = by; sides.forEach((s) => s.coarsen()); }
    },
    // world_T_part: where the part is; eye: in `world`, from where a side that looks away is not drawn
    face(world_T_part, eye) {
      const seen = eye.clone().applyMatrix4(world_T_part.clone().invert()).toArray();
      sides.forEach((s) => s.face(seen));
    },
  };
}
