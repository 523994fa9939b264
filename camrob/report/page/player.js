"use strict";
// The player: the robot at true time, the stock as it is cut, what the program says there. Lengths in mm, times in s.

// the chain, walked as camrob.kinematics.frames walks it
function camrobChain(chain) {
  const rows = (m) => new THREE.Matrix4().set(...m, 0, 0, 0, 1);
  const first = rows(chain.first), floor = rows(chain.floor), root = rows(chain.root), flange = rows(chain.flange), tool = rows(chain.tool);
  const joints = chain.joints.map((j) => ({ name: j.name, prismatic: j.prismatic, before: rows(j.before), after: rows(j.after) }));
  const T = new THREE.Matrix4(), move = new THREE.Matrix4();
  const frames = { world: new THREE.Matrix4(), base: new THREE.Matrix4(), root: new THREE.Matrix4(), flange: new THREE.Matrix4(), tool: new THREE.Matrix4() };
  joints.forEach((j) => { frames[j.name] = new THREE.Matrix4(); });

  // frames seen from `base`, but for `base` itself, which is seen from `world`; q from `at` on
  return function walk(q, at) {
    T.copy(first);
    if (chain.arm[0] === 0) frames.root.copy(first).multiply(root);
    joints.forEach((j, k) => {
      const value = q[at + k];
      if (j.prismatic) move.makeTranslation(0, 0, value); else move.makeRotationZ(value);
      T.multiply(j.before).multiply(move).multiply(j.after);
      frames[j.name].copy(T);
      if (k === chain.arm[0] - 1) frames.root.copy(T).multiply(root);
      if (k === chain.arm[1]) {
        frames.flange.copy(T).multiply(flange);
        T.multiply(flange).multiply(tool);
        if (!chain.roll) { frames.tool.copy(T); T.copy(frames[j.name]); }
      }
    });
    if (chain.roll) frames.tool.copy(T);
    if (chain.workpiece < 0) frames.base.identity();
    else frames.base.copy(frames[joints[chain.workpiece].name]).invert().premultiply(floor);
    return frames;
  };
}

// a body's flat faces, lit where their corners are: cheaper than by pixels, for machines that draw without a graphics card; what
// lies within `box` (its lowest and highest corner), where one is given, is left out
function camrobFlat(vertices, faces, color, box) {
  const indexed = new THREE.BufferGeometry();
  indexed.setAttribute("position", new THREE.BufferAttribute(vertices, 3));
  indexed.setIndex(new THREE.BufferAttribute(new Uint32Array(faces), 1));
  const geometry = indexed.toNonIndexed();
  geometry.computeVertexNormals();
  const material = new THREE.ShaderMaterial({
    side: THREE.DoubleSide,
    uniforms: {
      color: { value: new THREE.Color(color) },
      ...(box && { lower: { value: new THREE.Vector3(...box[0]) }, upper: { value: new THREE.Vector3(...box[1]) } }),
    },
    vertexShader: `
      uniform vec3 color; varying vec3 lit, place;
      void main() {
        place = position;
        vec4 at = modelMatrix * vec4(position, 1.0);
        vec3 n = normalize(mat3(modelMatrix) * normal);
        if (dot(n, cameraPosition - at.xyz) < 0.0) n = -n;
        float light = 0.43 + 0.67 * max(0.0, dot(n, normalize(vec3(0.4, -0.5, 1.0)))) + 0.16 * max(0.0, dot(n, normalize(vec3(-0.6, 0.7, 0.3))));
        lit = pow(min(vec3(1.0), color * light), vec3(1.0 / 2.2));
        gl_Position = projectionMatrix * viewMatrix * at;
      }`,
    fragmentShader: box ? `
      uniform vec3 lower, upper; varying vec3 lit, place;
      void main() {
        if (all(greaterThan(place, lower)) && all(lessThan(place, upper))) discard;
        gl_FragColor = vec4(lit, 1.0);
      }` : "varying vec3 lit; void main() { gl_FragColor = vec4(lit, 1.0); }",
  });
  return new THREE.Mesh(geometry, material);
}

// place(line, region): where that is, in words; mark(s): show it in the charts
function camrobPlayer(scene, place, mark) {
  const get = (id) => document.getElementById(id);
  const run = scene.run, K = run.count, J = scene.chain.joints.length;
  const lines = run.said && camrobLines(run.said);
  const { q, t: time, s: length, kf, line, region, cut } = run;
  const end = time[K - 1] || 0, walk = camrobChain(scene.chain);
  const view = get("view");
  const renderer = new THREE.WebGLRenderer({ antialias: false, alpha: true, powerPreference: "high-performance" });
  view.append(renderer.domElement);
  const world = new THREE.Scene(), camera = new THREE.PerspectiveCamera(32, 1, 10, 60000);
  camera.up.set(0, 0, 1);
  const controls = new THREE.OrbitControls(camera, renderer.domElement);

  // ---- bodies, each in its frame's group
  const groups = {};
  const groupOf = (name) => {
    if (!groups[name]) { groups[name] = new THREE.Group(); groups[name].matrixAutoUpdate = false; world.add(groups[name]); }
    return groups[name];
  };
  let part = null;
  const named = {};
  scene.bodies.forEach((body) => {
    const mesh = camrobFlat(new Float32Array(body.vertices), body.faces, body.color);
    mesh.userData.color = body.color;
    (named[body.name] = named[body.name] || []).push(mesh);
    if (body.role === "part") part = mesh;
    groupOf(body.frame).add(mesh);
  });
  const base = groupOf("base");
  let stock = null;
  const stockGroup = new THREE.Group();
  if (scene.stock) {
    stockGroup.matrixAutoUpdate = false;
    stockGroup.matrix.set(...scene.stock.pose, 0, 0, 0, 1);
    base.add(stockGroup);
    stock = camrobStock(scene.stock, stockGroup);
    if (part) part.visible = false;
  }

  // ---- the path: thin all along, thick as far as the tool has come
  const tips = new Float32Array(3 * K), colors = new Float32Array(3 * K);
  const air = new THREE.Color("#8a93a0"), p = new THREE.Vector3();
  const colored = new THREE.Color();
  const colorOf = camrobScale(scene.threshold / scene.highest, (c) => new THREE.Color(c), (a, b, share) => colored.copy(a).lerp(b, share));
  for (let k = 0; k < K; k++) {
    p.setFromMatrixPosition(walk(q, k * J).tool);
    tips.set([p.x, p.y, p.z], 3 * k);
    const c = cut[k] ? colorOf(kf[k] / scene.highest) : air;
    colors.set([c.r, c.g, c.b], 3 * k);
  }
  const path = camrobPath(tips, colors, cut, base);
  const tip = new THREE.Mesh(new THREE.SphereGeometry(1, 12, 8), new THREE.MeshBasicMaterial({ color: camrobColor("--text") }));
  base.add(tip);

  // ---- where it is
  let now = 0, k0 = 0, playing = false, before = 0, dirty = true;
  const posture = new Float32Array(J);
  function sampleAt(t) {
    let a = 0, b = K - 1;
    while (b - a > 1) { const m = (a + b) >> 1; if (time[m] <= t) a = m; else b = m; }
    return a;
  }
  function show() {
    k0 = sampleAt(now);
    const k1 = Math.min(k0 + 1, K - 1), span = time[k1] - time[k0], x = span > 0 ? Math.min(1, Math.max(0, (now - time[k0]) / span)) : now >= time[k1] ? 1 : 0;
    for (let j = 0; j < J; j++) posture[j] = q[k0 * J + j] + x * (q[k1 * J + j] - q[k0 * J + j]);
    const frames = walk(posture, 0);
    tip.position.setFromMatrixPosition(frames.tool);
    view.dataset.tip = tip.position.toArray().map((v) => v.toFixed(3)).join(" "); // in `base`, for whoever checks the walk
    for (const name in groups) {
      const matrix = groups[name].matrix;
      if (name === "world") matrix.identity(); else if (name === "base") matrix.copy(frames.base); else matrix.multiplyMatrices(frames.base, frames[name]);
      groups[name].matrixWorldNeedsUpdate = true;
    }
    if (stock) { stock.at(now); stock.face(new THREE.Matrix4().multiplyMatrices(frames.base, stockGroup.matrix), camera.position); }
    const s = length[k0] + x * (length[k1] - length[k0]), near = x > 0.5 ? k1 : k0;
    path.at(near);
    mark(s);
    if (playing && performance.now() - worded < 100) return; // nobody reads faster, and the browser sets words for longer than it draws the cell
    worded = performance.now();
    readout(near, s);
  }

  // ---- words beside the picture; names, remarks and lines were escaped when the page was written
  const clock = (t) => {
    const whole = Math.max(0, t), minutes = Math.floor(whole / 60);
    return minutes + ":" + (whole - 60 * minutes).toFixed(1).padStart(4, "0");
  };
  const rows = run.axes.map((axis, n) => {
    const row = get("axis-" + n);
    return { value: row.querySelector(".v"), mark: row.querySelector("i"), gauge: row.querySelector(".gauge") };
  });
  const where = get("where"), said = get("said"), slider = get("time"), clockText = get("clock");
  // the two bodies that are nearest to each other, where that was reckoned: in words, and tinted where they are close
  const close = run.near;
  const nearText = get("nearest"), tint = new THREE.Color("#d43a2f");
  let tinted = [];
  function nearest() {
    let a = 0, b = close.t.length - 1;
    while (b - a > 1) { const m = (a + b) >> 1; if (close.t[m] <= now) a = m; else b = m; }
    const k = close.t[b] - now < now - close.t[a] ? b : a, mm = close.mm[k], pair = run.near.pairs[close.pair[k]];
    nearText.innerHTML = pair[0] + " and " + pair[1] + ': <span class="' + (mm < 20 ? "low" : "") + '">' + mm.toFixed(0) + " mm</span>";
    const share = Math.max(0, Math.min(1, (100 - mm) / 80)); // from 100 mm on, wholly at 20
    tinted.forEach((mesh) => mesh.material.uniforms.color.value.set(mesh.userData.color));
    tinted = share > 0 ? pair.flatMap((name) => named[name] || []) : [];
    tinted.forEach((mesh) => mesh.material.uniforms.color.value.lerp(tint, share));
  }
  let shownAt = -1, worded = 0; // worded: when the words were set last, ms
  function readout(near, s) {
    if (close) nearest();
    if (near !== shownAt) {
      shownAt = near;
      const remark = run.remarks[near];
      where.innerHTML = "<b>" + (remark || place(0, region[near])) + "</b><br>" +
        (line[near] > 0 ? "CL line " + line[near] : run.unlined[cut[near]]) + "<br>" +
        s.toLocaleString("en", { maximumFractionDigits: 0 }) + " mm along the path<br>" +
        (remark ? "" : '1/k<sub>F</sub> <span class="' + (kf[near] < scene.threshold ? "low" : "") + '">' + kf[near].toFixed(3) + "</span>");
      if (said) said.innerHTML = lines[near] || "&nbsp;";
    }
    run.axes.forEach((axis, n) => {
      const value = axis.factor * posture[axis.joint] + axis.offset, row = rows[n];
      row.value.textContent = value.toFixed(axis.unit === "mm" ? 1 : 2).replace("-", "−") + (axis.unit === "mm" ? " mm" : "°");
      const [low, high] = axis.limits;
      if (low === null || high === null) return;
      const share = Math.min(1, Math.max(0, (value - low) / (high - low)));
      row.mark.style.left = 100 * share + "%";
      row.gauge.classList.toggle("near", Math.min(share, 1 - share) < 0.03);
    });
    clockText.textContent = clock(now) + " / " + clock(end);
    slider.value = String(end > 0 ? Math.round(10000 * now / end) : 0);
  }

  // ---- frames: drawn where something changed, timed for whoever asks (document.body.dataset)
  const spent = [], dots = Math.min(2, window.devicePixelRatio || 1);
  let ease = 0, waited = 0; // 0: as fine as can be; 1, 2: fewer rays of the stock; 3: fewer pixels, too
  let fine = false, touched = 0; // fine: at rest, with twice the pixels that the screen shows
  function sharpen() { renderer.setPixelRatio(fine ? 2 * dots : ease === 3 ? 0.6 * dots : dots); dirty = true; }
  function touch() { touched = performance.now(); dirty = true; if (fine) { fine = false; sharpen(); } }
  function easeTo(to) {
    if (to === ease) return;
    ease = to; waited = 30;
    sharpen();
  }
  function frame(stamp) {
    requestAnimationFrame(frame);
    const begin = performance.now();
    if (playing) { // coarser where the machine can't draw 25 pictures a second
      waited = 0.8 * waited + 0.2 * (stamp - before);
      if (waited > 40 && ease < 3) easeTo(ease + 1);
      now += Number(get("speed").value) * Math.min(0.25, (stamp - before) / 1000);
      if (now >= end) { now = end; play(false); }
      dirty = true;
    } else if (!fine && stamp - touched > 250) { fine = true; sharpen(); }
    before = stamp;
    if (!dirty) return;
    dirty = false;
    detail();
    show();
    tip.scale.setScalar(0.0035 * camera.position.distanceTo(controls.target));
    renderer.render(world, camera);
    if (!playing) return;
    spent.push(performance.now() - begin);
    if (spent.length > 600) spent.shift();
    document.body.dataset.frameMs = (spent.reduce((a, b) => a + b, 0) / spent.length).toFixed(2);
    document.body.dataset.frames = String(Number(document.body.dataset.frames || 0) + 1);
  }
  // what is finer than the picture is not drawn
  function detail() {
    const away = camera.position.distanceTo(controls.target), mm = 2 * away * Math.tan(0.5 * camera.fov * Math.PI / 180) / view.clientHeight;
    path.scale(mm, view.clientWidth, view.clientHeight);
    if (stock) stock.coarsen(mm, Math.min(4, 1 << ease));
  }
  function go(t) { now = Math.min(end, Math.max(0, t)); touch(); }
  function play(on) {
    playing = on; touch();
    if (!on) easeTo(0);
    if (on && now >= end) now = 0;
    get("play").textContent = on ? "Stop" : "Play";
  }
  function step(by) { play(false); go(time[Math.min(K - 1, Math.max(0, sampleAt(now + 1e-9) + by))]); }
  function goToLength(s) {
    let best = 0;
    for (let k = 1; k < K; k++) if (Math.abs(length[k] - s) < Math.abs(length[best] - s)) best = k;
    play(false); go(time[best]);
  }

  // ---- the camera
  const look = new THREE.Vector3(...scene.look), low = new THREE.Vector3(...scene.view[0]), high = new THREE.Vector3(...scene.view[1]);
  function see(middle, size, eye) {
    controls.target.copy(middle);
    camera.position.copy(middle).addScaledVector(eye, size / (2 * Math.tan(0.5 * camera.fov * Math.PI / 180)));
    controls.update(); touch();
  }
  // as near as the room that is shown, box and all, fits
  function seeCell() {
    const middle = low.clone().add(high).multiplyScalar(0.5), to = look.clone().normalize();
    const right = new THREE.Vector3(0, 0, 1).cross(to).normalize(), up = to.clone().cross(right), tall = Math.tan(0.5 * camera.fov * Math.PI / 180);
    let away = 0;
    for (let n = 0; n < 8; n++) {
      p.set(n & 1 ? high.x : low.x, n & 2 ? high.y : low.y, n & 4 ? high.z : low.z).sub(middle);
      away = Math.max(away, p.dot(to) + Math.max(Math.abs(p.dot(up)) / tall, Math.abs(p.dot(right)) / (tall * camera.aspect)));
    }
    see(middle, 2 * tall * away, look.clone().normalize());
  }
  function seePart() {
    show(); // frames of now
    const a = new THREE.Vector3(Infinity, Infinity, Infinity), b = a.clone().negate();
    const some = cut.some((v) => v);
    for (let k = 0; k < K; k++) if (cut[k] || !some) { p.fromArray(tips, 3 * k).applyMatrix4(base.matrix); a.min(p); b.max(p); }
    see(a.clone().add(b).multiplyScalar(0.5), Math.max(60, 1.15 * a.distanceTo(b)), look.clone().setZ(1.1).normalize());
  }
  function resize() {
    const width = view.clientWidth, height = view.clientHeight;
    sharpen();
    renderer.setSize(width, height);
    camera.aspect = width / height; camera.updateProjectionMatrix(); dirty = true;
  }

  // paper shows no WebGL: it gets a copy of the picture
  const paper = document.createElement("canvas");
  addEventListener("beforeprint", () => {
    const drawn = renderer.domElement;
    detail(); show(); renderer.render(world, camera);
    paper.width = drawn.width; paper.height = drawn.height;
    paper.getContext("2d").drawImage(drawn, 0, 0);
    drawn.replaceWith(paper);
  });
  addEventListener("afterprint", () => paper.replaceWith(renderer.domElement));

  controls.addEventListener("change", touch);
  new ResizeObserver(resize).observe(view);
  slider.addEventListener("input", () => { play(false); go(end * Number(slider.value) / 10000); });
  get("play").addEventListener("click", () => play(!playing));
  get("back").addEventListener("click", () => step(-1));
  get("forth").addEventListener("click", () => step(1));
  get("see-cell").addEventListener("click", seeCell);
  get("see-part").addEventListener("click", seePart);
  [["show-stock", (on) => { stockGroup.visible = on; }], ["show-part", (on) => { part.visible = on; }], ["show-path", (on) => path.show(on)]]
    .forEach(([id, act]) => { const box = get(id); if (box) box.addEventListener("change", () => { act(box.checked); dirty = true; }); });
  const ray = new THREE.Raycaster();
  let pressed = null;
  renderer.domElement.addEventListener("pointerdown", (event) => { pressed = [event.clientX, event.clientY]; });
  renderer.domElement.addEventListener("click", (event) => { // on the path: go there
    if (!pressed || Math.hypot(event.clientX - pressed[0], event.clientY - pressed[1]) > 3) return;
    const r = renderer.domElement.getBoundingClientRect();
    ray.setFromCamera(new THREE.Vector2(2 * (event.clientX - r.left) / r.width - 1, 1 - 2 * (event.clientY - r.top) / r.height), camera);
    ray.params.Line.threshold = 0.006 * camera.position.distanceTo(controls.target);
    const hit = ray.intersectObject(path.whole)[0];
    if (hit) { play(false); go(time[path.nearest(hit.point.applyMatrix4(base.matrixWorld.clone().invert()))]); }
  });
  const speed = get("speed");
  speed.value = ["1", "2", "5", "10", "20", "50", "100"].find((v) => end / Number(v) <= 60) || "100";
  // places that this page or another one leads to: #cl-line=N of the CL file, #program-line=N of the program
  function goToPlace() {
    const [, what, number] = location.hash.match(/^#(cl-line|program-line)=(\d+)$/) || [];
    if (!what) return;
    const lineOf = what === "cl-line" ? (k) => line[k] : (k) => (lines ? Number((lines[k].match(/ (\d+): /) || [])[1]) : NaN);
    let best = -1;
    for (let k = 0; k < K; k++) { // the line itself, or the next one that moves
      const n = lineOf(k);
      if (n >= number && (best < 0 || n < lineOf(best))) best = k;
    }
    if (best >= 0) { play(false); go(time[best]); }
    view.scrollIntoView({ block: "center" });
  }
  addEventListener("hashchange", goToPlace);
  resize(); seeCell(); goToPlace(); requestAnimationFrame(frame);
  return { goToLength, recolor: () => { tip.material.color.set(camrobColor("--text")); dirty = true; } };
}
