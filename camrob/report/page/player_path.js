"use strict";
// The path of the tool: thin all along, thick as far as the tool has come, with as many pieces as a screen can show.

// tips: mm in the group's frame, colors of 0..1, three a sample; cut: whether the tool comes to a sample cutting
function camrobPath(tips, colors, cut, group) {
  const K = tips.length / 3, WIDTH = 3; // px
  const thin = new THREE.BufferGeometry();
  thin.setAttribute("position", new THREE.BufferAttribute(tips, 3));
  thin.setAttribute("color", new THREE.BufferAttribute(colors, 3));
  const whole = new THREE.Line(thin, new THREE.LineBasicMaterial({ vertexColors: true, transparent: true, opacity: 0.55 }));
  // of each piece one rectangle as wide on the screen as asked: a third of the corners of three's own, which has round ends
  const resolution = new THREE.Vector2(1, 1);
  const material = new THREE.ShaderMaterial({
    side: THREE.DoubleSide,
    uniforms: { resolution: { value: resolution } },
    vertexShader: `
      attribute vec3 instanceStart, instanceEnd, instanceColorStart; uniform vec2 resolution; varying vec3 seen;
      void main() {
        mat4 m = projectionMatrix * modelViewMatrix;
        vec4 a = m * vec4(instanceStart, 1.0), b = m * vec4(instanceEnd, 1.0);
        vec2 along = (b.xy / b.w - a.xy / a.w) * resolution;
        vec2 aside = dot(along, along) > 0.0 ? normalize(vec2(-along.y, along.x)) : vec2(1.0, 0.0);
        gl_Position = position.y > 0.5 ? b : a;
        gl_Position.xy += aside * (position.x * ${WIDTH.toFixed(1)} * gl_Position.w) / resolution;
        seen = pow(instanceColorStart, vec3(1.0 / 2.2));
      }`,
    fragmentShader: "varying vec3 seen; void main() { gl_FragColor = vec4(seen, 1.0); }",
  });
  const gone = new THREE.Mesh(new THREE.LineSegmentsGeometry(), material);
  gone.frustumCulled = whole.frustumCulled = false;
  group.add(whole, gone);

  let spacing = 0, ends = []; // ends: the samples that the thick pieces end in
  // pieces shorter than this, mm, are joined to the next
  function build(least) {
    const kept = [0];
    for (let k = 1, last = 0; k < K; k++) {
      const far = Math.hypot(tips[3 * k] - tips[3 * last], tips[3 * k + 1] - tips[3 * last + 1], tips[3 * k + 2] - tips[3 * last + 2]);
      if (far >= least || k === K - 1 || cut[k] !== cut[k + 1]) { kept.push(k); last = k; }
    }
    thin.setIndex(kept);
    const pairs = [];
    for (let n = 1; n < kept.length; n++) if (cut[kept[n]]) pairs.push([kept[n - 1], kept[n]]);
    ends = pairs.map(([, k]) => k);
    const ofPairs = (values, first, second) => {
      const out = new Float32Array(6 * Math.max(pairs.length, 1));
      pairs.forEach((pair, n) => [first, second].forEach((which, c) => {
        for (let d = 0; d < 3; d++) out[6 * n + 3 * c + d] = values[3 * pair[which] + d];
      }));
      return out;
    };
    gone.geometry.dispose();
    gone.geometry = new THREE.LineSegmentsGeometry().setPositions(ofPairs(tips, 0, 1)).setColors(ofPairs(colors, 1, 1));
    gone.geometry.setIndex([2, 4, 3, 4, 5, 3]);
    gone.geometry.instanceCount = 0;
  }

  return {
    whole,
    // how many mm a pixel is where the path lies: only then is it known what can be told apart
    scale(mm, width, height) {
      resolution.set(width, height);
      const wanted = 2 ** Math.floor(Math.log2(Math.max(mm, 1e-6)));
      if (wanted !== spacing) { spacing = wanted; build(spacing); }
    },
    // thick as far as sample k
    at(k) {
      let reached = 0, beyond = ends.length;
      while (reached < beyond) { const m = (reached + beyond) >> 1; if (ends[m] <= k) reached = m + 1; else beyond = m; }
      gone.geometry.instanceCount = reached;
    },
    show(on) { whole.visible = on; gone.visible = on; },
    // the sample that is nearest to a point of the group's frame
    nearest(p) {
      let best = 0, least = Infinity;
      for (let k = 0; k < K; k++) {
        const far = (tips[3 * k] - p.x) ** 2 + (tips[3 * k + 1] - p.y) ** 2 + (tips[3 * k + 2] - p.z) ** 2;
        if (far < least) { least = far; best = k; }
      }
      return best;
    },
  };
}
