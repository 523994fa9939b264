// What a browser finds wrong with a page once it is drawn, for tests: told in the body's data.
(async () => {
  while (document.body.dataset.ready !== "1") await new Promise((go) => setTimeout(go, 50));
  const first = document.querySelector("main section, main .cards, main nav, main .verdict");
  const wide = document.documentElement.clientWidth, faults = [];
  const name = (e) => e.tagName + "#" + e.id + ": " + (e.textContent || "").trim().slice(0, 40);
  const held = (e) => { for (let p = e.parentElement; p; p = p.parentElement) if (getComputedStyle(p).overflowX !== "visible") return true; };
  const light = (c) => c.slice(0, 3).map((v) => v / 255).map((v) => (v <= 0.03928 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4))
    .reduce((sum, v, k) => sum + v * [0.2126, 0.7152, 0.0722][k], 0);
  const rgba = (text) => { const found = text.match(/[\d.]+/g).map(Number); return found.length < 4 ? [...found, 1] : found; };
  const ground = (e) => { for (let p = e; p; p = p.parentElement) { const c = rgba(getComputedStyle(p).backgroundColor); if (c[3] === 1) return c; } };
  if (!first.classList.contains("verdict")) faults.push("no verdict first: " + name(first));
  for (const e of document.querySelectorAll("main, main *")) {
    const box = e.getBoundingClientRect();
    if (!box.width) continue;
    if (box.right > wide + 1 && !held(e)) faults.push("beyond the edge: " + name(e));
    const words = [...e.childNodes].some((n) => n.nodeType === 3 && n.textContent.trim());
    if (!words) continue;
    const style = getComputedStyle(e), a = light(rgba(e instanceof SVGElement ? style.fill : style.color)), b = light(ground(e));
    if ((Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05) < READABLE) faults.push("faint: " + name(e));
  }
  for (const e of document.querySelectorAll("main img, main svg, main canvas"))
    if (!e.closest("[alt], [aria-label]")) faults.push("no name: " + name(e));
  for (const e of document.querySelectorAll("main input, main select, main button"))
    if (!(e.textContent.trim() && e.tagName === "BUTTON") && !e.getAttribute("aria-label") && !e.closest("label")) faults.push("no label: " + name(e));
  for (const e of document.querySelectorAll(".scroll"))
    if (e.tabIndex < 0 && (e.scrollWidth > e.clientWidth || e.scrollHeight > e.clientHeight)) faults.push("not by keys: " + name(e));
  for (const e of document.querySelectorAll(".scroll"))
    if (!SIDEWAYS && e.scrollWidth > e.clientWidth) faults.push("only by scrolling: " + name(e));
  for (const e of document.querySelectorAll(".chart .xtitle, .chart .ytitle")) if (!e.textContent.trim()) faults.push("axis without words");
  document.body.dataset.faults = JSON.stringify(faults);
})();
