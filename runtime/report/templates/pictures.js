"use strict";
/* What is written into the 3-D view and taken out of it: names, stills, films, a strip for print. */

class Names {
  /* `all` by the check box, one under the pointer; long names are cut by the style. */
  constructor(scene, layer, tip) {
    this.scene = scene;
    this.tip = tip;
    this.on = false;
    const { names } = scene.data;
    this.objects = new Map(Object.entries(names).map(([name, path]) => [scene.node(path), name]));
    const shown = Object.entries(names).filter(([, path]) => !path.includes("/effector")).map(([name]) => name);
    this.labels = shown.map((name) => {
      const label = document.createElement("span");
      label.textContent = name;
      label.dir = "auto";
      label.hidden = true;
      layer.append(label);
      return { name, label };
    });
    scene.viewer.controls.addEventListener("change", () => this.draw());
    scene.pane.addEventListener("pointermove", (event) => this.point(event));
    scene.pane.addEventListener("pointerleave", () => { tip.hidden = true; });
  }

  draw() {
    for (const { name, label } of this.labels) {
      const [x, y] = this.on ? this.scene.onScreen(name) : [2, 2];
      label.hidden = Math.abs(x) > 1 || Math.abs(y) > 1;
      label.style.left = 50 * (x + 1) + "%";
      label.style.top = 50 * (1 - y) + "%";
    }
  }

  /* The thing under the pointer, of what is drawn. */
  point(event) {
    const { THREE } = MeshCat;
    const box = this.scene.pane.getBoundingClientRect();
    const x = event.clientX - box.left, y = event.clientY - box.top;
    const ray = new THREE.Raycaster();
    ray.setFromCamera(new THREE.Vector2((2 * x) / box.width - 1, 1 - (2 * y) / box.height), this.scene.viewer.camera);
    const hit = ray.intersectObject(this.scene.viewer.scene, true).find(({ object }) => object.isMesh && this.named(object));
    this.tip.hidden = !hit;
    if (!hit) return;
    this.tip.textContent = this.named(hit.object);
    this.tip.style.left = x + "px";
    this.tip.style.top = y + "px";
  }

  named(object) {
    for (let at = object; at; at = at.parent) {
      if (this.objects.has(at)) return this.objects.get(at);
    }
    return null;
  }
}

function save(blob, name) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

function fileName(ending) {
  return (document.querySelector("h1")?.textContent || "replay").replace(/[^\w-]+/g, "_").slice(0, 60) + ending;
}

const MARGIN = 300;  // ms: what a film shows of its first and its last picture

function startSaving(scene, player, still, film) {
  const { viewer } = scene;
  const canvas = viewer.renderer.domElement;
  still.addEventListener("click", () => {
    viewer.renderer.render(viewer.scene, viewer.camera);
    canvas.toBlob((blob) => save(blob, fileName("-" + player.now.toFixed(2) + "s.png")));
  });
  film.hidden = typeof MediaRecorder === "undefined" || !canvas.captureStream;
  let recorder = null;
  film.addEventListener("click", () => {
    if (recorder) { player.pause(); return; }
    const parts = [];
    recorder = new MediaRecorder(canvas.captureStream(30));
    recorder.addEventListener("dataavailable", (event) => parts.push(event.data));
    recorder.addEventListener("stop", () => {
      save(new Blob(parts, { type: recorder.mimeType }), fileName(recorder.mimeType.includes("mp4") ? ".mp4" : ".webm"));
      recorder = null;
      film.textContent = "Record film";
    });
    film.textContent = "Stop recording";
    if (player.atEnd) player.seek(0);
    recorder.start();
    setTimeout(() => player.play(), MARGIN);
  });
  let ending = 0;
  player.listen(() => {
    if (!recorder || player.playing || !player.now || ending) return;
    ending = setTimeout(() => { ending = 0; recorder.stop(); }, MARGIN);
  });
}

const MOST_STILLS = 24;

/* One picture per switch, for paper; of many phases some, evenly. */
function drawStills(scene, player, strip) {
  const { viewer } = scene;
  const before = player.now;
  const source = viewer.renderer.domElement;
  const phases = scene.data.phases;
  const step = Math.max(1, Math.ceil(phases.length / MOST_STILLS));
  strip.replaceChildren();
  phases.forEach(([, end, action], index) => {
    if ((phases.length - 1 - index) % step) return;
    player.seek(end);
    viewer.renderer.render(viewer.scene, viewer.camera);
    const picture = document.createElement("canvas");
    picture.width = 640;
    picture.height = Math.round((640 * source.height) / source.width);
    picture.getContext("2d").drawImage(source, 0, 0, picture.width, picture.height);
    const figure = document.createElement("figure"), caption = document.createElement("figcaption");
    caption.textContent = action + ", " + end.toFixed(2) + " s";
    figure.append(picture, caption);
    strip.append(figure);
  });
  player.seek(before);
  viewer.renderer.render(viewer.scene, viewer.camera);
}
