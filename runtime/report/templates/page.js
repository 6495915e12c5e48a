"use strict";
(async () => {
  const data = JSON.parse(document.getElementById("replay-data").textContent);
  const get = (id) => document.getElementById(id);
  const all = (selector) => [...document.querySelectorAll(selector)];
  const scrub = get("scrub");
  const player = new Player(data, Number(scrub.max));
  let scene = null;

  async function startScene() {
    try {
      await loadViewer();
      scene = new ReplayScene(data, get("pane"), await unpackPoses(data.poses));
    } catch (error) {
      get("trouble").hidden = false;
      get("trouble").textContent = "The 3-D view needs WebGL, which this browser does not offer: " + error.message;
      return;
    }
    player.listen(() => {
      const last = data.colours.length - 1;
      const mark = data.marks ? data.marks[player.phase] : null;
      scene.show(player.now, data.colours[player.atEnd || player.phase < 0 ? last : player.phase], mark);
    });
    get("follow").addEventListener("change", (event) => scene.follow(event.target.checked));
    get("traces").addEventListener("change", (event) => {
      scene.traces.visible = event.target.checked;
      scene.viewer.set_dirty();
    });
    get("whole").addEventListener("click", () => {
      get("follow").checked = false;
      scene.follow(false);
    });
    for (const side of ["above", "side"]) get(side).addEventListener("click", () => {
      get("follow").checked = false;
      scene.following = false;
      scene.showFrom(side);
    });
    const names = new Names(scene, get("labels"), get("tip"));
    get("names").addEventListener("change", (event) => { names.on = event.target.checked; names.draw(); });
    player.listen(() => { if (names.on) names.draw(); });
    startSaving(scene, player, get("still"), get("film"));
    window.addEventListener("beforeprint", () => {
      if (data.still) scene.viewer.render(); else drawStills(scene, player, get("stills"));
    });
    const farAway = 6;  // metres: beyond this a module in the whole scene is too small to see
    if (scene.bounds().radius > farAway) {
      get("follow").checked = true;
      scene.follow(true);
    }
  }

  function startControls() {
    scrub.addEventListener("input", () => player.seek(scrub.value));
    get("play").addEventListener("click", () => player.toggle());
    get("previous").addEventListener("click", () => player.previousPhase());
    get("next").addEventListener("click", () => player.nextPhase());
    get("speed").addEventListener("change", (event) => { player.speed = Number(event.target.value); });
    for (const block of all("button.block"))
      block.addEventListener("click", () => player.seek(data.phases[Number(block.dataset.phase)][0]));
    for (const button of all("[data-seek]")) {
      button.addEventListener("click", () => {
        player.seek(button.dataset.seek);
        get("replay").scrollIntoView({ block: "start" });
      });
    }
    player.listen(() => {
      scrub.value = player.now;
      scrub.setAttribute("aria-valuetext", player.now.toFixed(2) + " seconds");
      get("clock").textContent = player.now.toFixed(2) + " / " + player.duration.toFixed(2) + " s";
      get("play").textContent = player.playing ? "Pause" : "Play";
      const [, , action, robots] = data.phases[player.phase] || [0, 0, "", ""];
      get("caption").textContent = action + (robots ? "  ·  joined: " + robots : "");
      if (get("cursor")) get("cursor").style.left = (player.duration ? (100 * player.now) / player.duration : 0) + "%";
    });
  }

  function startMoment() {
    const button = get("moment");
    button.addEventListener("click", () => {
      const link = location.href.replace(/#.*$/, "") + "#t=" + player.now.toFixed(2);
      if (location.protocol !== "about:") location.hash = "t=" + player.now.toFixed(2);
      if (navigator.clipboard) navigator.clipboard.writeText(link).then(() => { button.textContent = "Copied"; }, () => {});
    });
    player.listen(() => { button.textContent = "Link here"; });
  }

  function startKeys() {
    const actions = {
      " ": () => player.toggle(),
      ArrowLeft: () => player.previousPhase(),
      ArrowRight: () => player.nextPhase(),
      ",": () => player.seek(player.now - 0.1),
      ".": () => player.seek(player.now + 0.1),
      Home: () => player.seek(0),
      End: () => player.seek(player.duration),
    };
    document.addEventListener("keydown", (event) => {
      const busy = event.target.closest("input, select, textarea, a, summary, button");
      if (busy && (event.key === " " || busy.matches("input, select, textarea"))) return;
      const action = event.ctrlKey || event.altKey || event.metaKey ? undefined : actions[event.key];
      if (!action) return;
      event.preventDefault();
      action();
    });
  }

  function startHighlights() {
    const marked = all("[data-phase]");
    let shown = null;
    player.listen(() => {
      if (shown === player.phase) return;
      shown = player.phase;
      for (const element of marked) element.classList.toggle("now", Number(element.dataset.phase) === shown);
      const strip = get("timeline");
      const block = document.querySelector("button.block.now");
      if (!strip || !block) return;
      if (strip.scrollWidth > strip.clientWidth) strip.scrollLeft = block.offsetLeft - strip.clientWidth / 3;
    });
  }

  function startPlots() {
    const times = new Float64Array(decodeBytes(data.times).buffer);
    const tracks = data.joints.map((text) => new Float32Array(decodeBytes(text).buffer));
    const plots = all(".plot[data-track]").map((figure) => {
      const svg = figure.querySelector("svg");
      svg.addEventListener("click", (event) => {
        const box = svg.getBoundingClientRect();
        player.seek(((event.clientX - box.left) / box.width) * player.duration);
      });
      return {
        cursor: figure.querySelector(".cursor"), value: figure.querySelector(".value"), unit: figure.dataset.unit,
        track: tracks[Number(figure.dataset.track)], column: Number(figure.dataset.column),
      };
    });
    player.listen(() => {
      const { low, next, share } = locate(times, player.now);
      const across = player.duration ? (1000 * player.now) / player.duration : 0;
      for (const plot of plots) {
        const columns = plot.track.length / times.length;
        const value = plot.track[low * columns + plot.column] * (1 - share) + plot.track[next * columns + plot.column] * share;
        plot.cursor.setAttribute("x1", across);
        plot.cursor.setAttribute("x2", across);
        plot.value.textContent = value.toFixed(2) + " " + plot.unit;
      }
    });
  }

  function startLoads() {
    const lines = all(".plot.timed").map((figure) => {
      const svg = figure.querySelector("svg");
      svg.addEventListener("click", (event) => {
        const box = svg.getBoundingClientRect();
        player.seek(((event.clientX - box.left) / box.width) * player.duration);
      });
      return figure.querySelector(".cursor");
    });
    const pictures = all(".above figure").map((figure) => ({
      start: Number(figure.dataset.start), end: Number(figure.dataset.end),
      parts: [...figure.querySelectorAll("[data-lines]")].map((part) => ({ part, lines: part.dataset.lines.split("|") })),
      rings: [...figure.querySelectorAll(".mass")].map((ring) => ({
        ring, way: ring.dataset.way.trim().split(" ").map((point) => point.split(",").map(Number)),
      })),
    }));
    player.listen(() => {
      const across = player.duration ? (1000 * player.now) / player.duration : 0;
      for (const line of lines) {
        line.setAttribute("x1", across);
        line.setAttribute("x2", across);
      }
      for (const { start, end, parts, rings } of pictures) {
        const inside = player.now >= start && player.now <= end && end > start;
        const share = inside ? (player.now - start) / (end - start) : 1;
        for (const { part, lines } of parts) part.setAttribute("points", lines[Math.round(share * (lines.length - 1))]);
        for (const { ring, way } of rings) {
          const at = share * (way.length - 1);
          const low = Math.min(Math.floor(at), way.length - 1), high = Math.min(low + 1, way.length - 1);
          ring.setAttribute("cx", way[low][0] + (at - low) * (way[high][0] - way[low][0]));
          ring.setAttribute("cy", way[low][1] + (at - low) * (way[high][1] - way[low][1]));
        }
      }
    });
  }

  function startTree() {
    const rows = all(".tree li");
    if (!rows.length) return;
    const depth = rows.map((row) => Number(row.dataset.depth));
    const folded = new Set();
    const words = () => get("tree-filter").value.trim().toLowerCase();
    const draw = () => {
      const wanted = words();
      let hiddenBelow = Infinity;
      rows.forEach((row, index) => {
        if (depth[index] <= hiddenBelow) hiddenBelow = Infinity;
        const inside = hiddenBelow === Infinity;
        if (inside && folded.has(index)) hiddenBelow = depth[index];
        row.hidden = wanted ? !row.textContent.toLowerCase().includes(wanted) : !inside;
        const fold = row.querySelector(".fold");
        if (!fold) return;
        fold.setAttribute("aria-expanded", String(!folded.has(index)));
        fold.textContent = folded.has(index) ? "▸" : "▾";
      });
    };
    const aroundPlan = () => {
      folded.clear();
      rows.forEach((row, index) => { if (!row.classList.contains("chosen")) folded.add(index); });
      draw();
    };
    rows.forEach((row, index) => {
      const fold = row.querySelector(".fold");
      if (!fold) return;
      fold.addEventListener("click", () => {
        if (!folded.delete(index)) folded.add(index);
        draw();
      });
    });
    get("tree-filter").addEventListener("input", draw);
    get("tree-plan").addEventListener("click", aroundPlan);
    get("tree-all").addEventListener("click", () => { folded.clear(); draw(); });
    if (rows.length > 60 && document.querySelector(".tree li.chosen")) aroundPlan(); else draw();
  }

  /* `#t=12.5` is a moment of the replay. */
  function openTarget() {
    const moment = /^#t=(\d+(?:\.\d*)?)$/.exec(location.hash);
    if (moment) {
      player.pause();
      player.seek(moment[1]);
      get("replay").scrollIntoView({ block: "start" });
      return;
    }
    const target = location.hash.length > 1 ? document.getElementById(decodeURIComponent(location.hash.slice(1))) : null;
    if (!target) return;
    const closed = target.closest("details:not([open])");
    if (closed) closed.open = true;
    target.scrollIntoView({ block: target.matches(".row") ? "center" : "start" });
  }

  await startScene();
  startControls();
  startMoment();
  startKeys();
  startHighlights();
  startPlots();
  startLoads();
  startTree();
  if (data.still) player.seek(1);
  window.addEventListener("hashchange", openTarget);
  openTarget();
  window.tamplang = {
    seek: (time) => player.seek(time),
    time: () => player.now,
    pose: (name) => (scene ? scene.pose(name) : null),
    onScreen: (name) => (scene ? scene.onScreen(name) : null),
    names: () => Object.keys(data.names),
  };
})();
