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
  const clouds = ((await block("clouds")) || []).map((cloud) => camrobCloud(cloud));
  let player = null;
  const drawn = camrobCharts(names, (x) => { if (player) player.goToLength(x); });
  const recolor = () => { drawn.recolor(); clouds.forEach((cloud) => cloud.draw()); if (player) player.recolor(); };
  // paper is white, whatever the screen is
  const paper = (on) => { document.documentElement.classList.toggle("paper", on); recolor(); if (on) drawn.frame(); else drawn.unframe(); };
  addEventListener("beforeprint", () => paper(true)); // before the player's own, which copies its picture
  addEventListener("afterprint", () => paper(false));
  if (scene) {
    try {
      player = camrobPlayer(scene, drawn.place, drawn.mark);
    } catch (error) { // no WebGL: the charts are there all the same
      document.getElementById("view").textContent = "The 3D view can't be drawn here: " + error.message;
    }
  }
  // of charts that one chooses from, those chosen; the others when they are
  const waiting = new Map();
  for (const chart of charts) {
    const choice = document.getElementById(chart.id).closest(".choice");
    if (choice) waiting.set(choice, [...(waiting.get(choice) || []), chart]); else await drawn.draw(chart);
  }
  for (const chooser of document.querySelectorAll(".choose")) {
    const lists = [...chooser.querySelectorAll("select")], choices = [...chooser.parentElement.querySelectorAll(".choice")];
    const chosen = async () => {
      const wanted = lists.map((list) => list.value).join(" ");
      for (const choice of choices) {
        choice.hidden = choice.dataset.choice !== wanted;
        if (choice.hidden) continue;
        const first = waiting.get(choice) || [];
        waiting.delete(choice);
        for (const chart of first) await drawn.draw(chart);
      }
    };
    lists.forEach((list) => list.addEventListener("change", chosen));
    await chosen();
  }
  // tables that scroll can be scrolled by keys
  const reach = () => document.querySelectorAll(".scroll").forEach((frame) => {
    frame.tabIndex = frame.scrollWidth > frame.clientWidth || frame.scrollHeight > frame.clientHeight ? 0 : -1;
  });
  reach();
  addEventListener("resize", reach);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", recolor);
  document.body.dataset.ready = "1";
})();
