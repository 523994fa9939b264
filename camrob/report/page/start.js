"use strict";
// Unpacks libraries and data, draws the charts, and starts the player.
(async function () {
  async function unpacked(element) {
    const bytes = Uint8Array.from(atob(element.textContent), (c) => c.charCodeAt(0));
    return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip")));
  }
  async function block(id) {
    const element = document.getElementById(id);
    if (!element) return null;
    if (element.type !== "application/gzip") return JSON.parse(element.textContent);
    const bytes = new Uint8Array(await (await unpacked(element)).arrayBuffer()), end = bytes.indexOf(0);
    const text = new TextDecoder().decode(bytes.subarray(0, end)), arrays = bytes.subarray(end + 1);
    return JSON.parse(text, (key, value) => (value && value.$ ? camrobArray(arrays, value.$) : value));
  }
  if (!window.DecompressionStream) {
    const note = document.createElement("p");
    note.textContent = "The pictures of this page need a browser of 2023 or newer (Chrome 80, Firefox 113, Safari 16.4).";
    document.querySelector("main").prepend(note);
    return;
  }
  for (const library of document.querySelectorAll("script.library")) {
    const script = document.createElement("script");
    script.textContent = await (await unpacked(library)).text();
    document.head.append(script);
    library.remove();
  }
  const names = (await block("names")) || {};
  const scene = await block("scene");
  const charts = (await block("charts")) || [];
  let player = null;
  const drawn = camrobCharts(names, (x) => { if (player) player.goToLength(x); });
  if (scene) {
    try {
      player = camrobPlayer(scene, drawn.place, drawn.mark);
    } catch (error) { // no WebGL: the charts are there all the same
      document.getElementById("view").textContent = "The 3D view can't be drawn here: " + error.message;
    }
  }
  for (const chart of charts) await drawn.draw(chart);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { drawn.recolor(); if (player) player.recolor(); });
  document.body.dataset.ready = "1";
})();
