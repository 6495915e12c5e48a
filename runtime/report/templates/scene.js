"use strict";
/* The 3-D scene: meshcat's viewer filled from recorded commands, moved by the page. World frame: z up, metres. */

function decodeBytes(text) {
  const raw = atob(text);
  const bytes = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; i++) bytes[i] = raw.charCodeAt(i);
  return bytes;
}

function unzipped(text) {
  if (typeof DecompressionStream === "undefined") throw new Error("this browser cannot unpack what is drawn");
  return new Response(new Blob([decodeBytes(text)]).stream().pipeThrough(new DecompressionStream("gzip")));
}

/* Poses, frame by frame and sample by sample, from their differences in steps. */
async function unpackPoses({ steps, rows }) {
  if (!rows) return new Float32Array(0);
  const sizes = new Float64Array(decodeBytes(steps).buffer);
  const bytes = new Uint8Array(await unzipped(rows).arrayBuffer());
  const count = bytes.length / 4, perFrame = count / (sizes.length / 7);
  const poses = new Float32Array(count), sums = new Int32Array(7);
  for (let i = 0; i < count; i++) {
    const column = i % 7;
    if (i % perFrame < 7) sums[column] = 0;
    sums[column] += bytes[i] | (bytes[count + i] << 8) | (bytes[2 * count + i] << 16) | (bytes[3 * count + i] << 24);
    poses[i] = sums[column] * sizes[7 * Math.floor(i / perFrame) + column];
  }
  return poses;
}

/* Unpacks meshcat's viewer and runs it; the policy of the page lets this very script pass. */
async function loadViewer() {
  const script = document.createElement("script");
  script.textContent = await unzipped(document.getElementById("viewer-code").textContent).text();
  document.head.append(script);
  if (typeof MeshCat === "undefined") throw new Error("the viewer did not start");
}

const TAIL_SECONDS = 3, TAIL_STEPS = 6;

function mixWithWhite(colour, share) {
  const part = (at) => {
    const value = parseInt(colour.slice(at, at + 2), 16);
    return Math.round(value + (255 - value) * share);
  };
  return (part(1) << 16) | (part(3) << 8) | part(5);
}

/* Index of the last time stamp that is not after `time`, and the share of the way to the next one. */
function locate(times, time) {
  let low = 0, high = times.length - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (times[middle] <= time) low = middle; else high = middle - 1;
  }
  const next = Math.min(low + 1, times.length - 1);
  const span = times[next] - times[low];
  return { low, next, share: span > 0 ? Math.min(1, Math.max(0, (time - times[low]) / span)) : 0 };
}

class ReplayScene {
  constructor(data, pane, poses) {
    this.data = data;
    this.pane = pane;
    this.times = new Float64Array(decodeBytes(data.times).buffer);
    this.poses = poses;
    this.viewer = new MeshCat.Viewer(pane);
    window.onload = null;
    const resize = this.viewer.set_3d_pane_size.bind(this.viewer);
    this.viewer.set_3d_pane_size = () => resize(pane.clientWidth || 1, pane.clientHeight || 1);
    for (const command of data.commands) this.viewer.handle_command_bytearray(decodeBytes(command));
    this.frames = data.frames.map((path) => this.node(path));
    const modules = this.frames.filter((_, index) => data.frames[index].startsWith("module"));
    this.followed = modules.length ? modules : this.frames;
    this.painted = data.paint.map(([path, module, share]) =>
      ({ material: this.node(path + "/<object>").material, module, share }));
    this.light();
    this.restore = [];
    if (!data.still) this.drawTraces();
    this.setBackground();
    this.setUpCamera();
  }

  node(path) {
    return this.viewer.scene_tree.find(["meshcat", ...path.split("/")]).object;
  }

  light() {
    const { THREE } = MeshCat;
    const { centre, radius } = this.bounds();
    const sun = new THREE.DirectionalLight(0xffffff, 0.62);
    sun.position.set(centre[0] - 0.35 * radius, centre[1] - 0.6 * radius, centre[2] + 2 * radius);
    sun.target.position.set(...centre);
    sun.castShadow = true;
    sun.shadow.mapSize.set(1024, 1024);
    sun.shadow.bias = -0.0006;
    sun.shadow.normalBias = 0.006;
    const reach = 1.3 * radius;
    Object.assign(sun.shadow.camera, { left: -reach, right: reach, top: reach, bottom: -reach, near: 0.01, far: 5 * radius });
    sun.shadow.camera.updateProjectionMatrix();
    this.viewer.set_object(["Lights", "Sun"], sun);
    this.viewer.scene.add(sun.target);
    this.viewer.set_property(["Lights", "AmbientLight", "<object>"], "intensity", 0.5);
    this.viewer.set_property(["Lights", "FillLight", "<object>"], "intensity", 0.2);
  }

  /* Ball around everything that the camera must see. */
  bounds() {
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    for (const ball of this.data.view.balls) {
      for (let k = 0; k < 3; k++) {
        low[k] = Math.min(low[k], ball[k] - ball[3]);
        high[k] = Math.max(high[k], ball[k] + ball[3]);
      }
    }
    const centre = low.map((value, k) => (value + high[k]) / 2);
    return { centre, radius: Math.max(0.5, Math.hypot(...low.map((value, k) => high[k] - value)) / 2) };
  }

  /* The way of every effector: pale as a whole, and behind the effector the last seconds, fading in steps. */
  drawTraces() {
    const { THREE } = MeshCat;
    this.traces = new THREE.Group();
    this.tails = [];
    const count = this.times.length;
    this.stride = Math.max(1, Math.floor(count / 1200));
    for (const path of Object.values(this.data.names)) {
      const cut = path.lastIndexOf("/effector");
      const frame = cut < 0 ? -1 : this.data.frames.indexOf(path.slice(0, cut));
      if (frame < 0) continue;
      const offset = this.node(path).position;
      const points = [];
      for (let i = 0; i < count; i += this.stride) {
        const p = this.poses.subarray(7 * (frame * count + i));
        const turned = offset.clone().applyQuaternion(new THREE.Quaternion(p[3], p[4], p[5], p[6]));
        points.push(turned.add(new THREE.Vector3(p[0], p[1], p[2])));
      }
      const module = Number(path.slice(6, path.indexOf("/")));
      const color = this.data.palette[module % this.data.palette.length];
      const whole = new THREE.BufferGeometry().setFromPoints(points);
      const line = (geometry, opacity) => new THREE.Line(geometry, new THREE.LineBasicMaterial({ color, transparent: true, opacity }));
      this.traces.add(line(whole, 0.22));
      for (let step = 0; step < TAIL_STEPS; step++) {
        const part = new THREE.BufferGeometry();
        part.setAttribute("position", whole.getAttribute("position"));
        const tail = line(part, 0.22 + 0.78 * (1 - step / TAIL_STEPS));
        tail.frustumCulled = false;
        this.tails.push({ geometry: part, step });
        this.traces.add(tail);
      }
    }
    this.viewer.set_object(["meshcat", "traces"], this.traces);
  }

  /* Each piece of a tail covers its share of the last seconds. */
  moveTails(time) {
    const at = (moment) => Math.floor(locate(this.times, moment).low / this.stride);
    const ends = Array.from({ length: TAIL_STEPS + 1 }, (_, k) => at(Math.max(0, time - (k * TAIL_SECONDS) / TAIL_STEPS)));
    for (const { geometry, step } of this.tails) geometry.setDrawRange(ends[step + 1], ends[step] - ends[step + 1] + 1);
  }

  setBackground() {
    const dark = window.matchMedia("(prefers-color-scheme: dark)");
    const apply = () => {
      this.viewer.set_property(["Background"], "top_color", dark.matches ? [0.13, 0.15, 0.18] : [0.93, 0.95, 0.97]);
      this.viewer.set_property(["Background"], "bottom_color", dark.matches ? [0.07, 0.08, 0.1] : [0.8, 0.83, 0.87]);
      this.viewer.set_dirty();
    };
    dark.addEventListener("change", apply);
    apply();
  }

  setUpCamera() {
    const { viewer, pane } = this;
    this.moved = false;
    this.following = false;
    viewer.camera.fov = 34;
    viewer.controls.enableZoom = false;
    viewer.controls.addEventListener("start", () => { this.moved = true; });
    pane.addEventListener("pointerdown", () => pane.focus({ preventScroll: true }));
    pane.addEventListener("focus", () => { viewer.controls.enableZoom = true; });
    pane.addEventListener("blur", () => { viewer.controls.enableZoom = false; });
    new ResizeObserver(() => {
      viewer.set_3d_pane_size();
      if (!this.moved) this.showWhole();
    }).observe(pane);
    viewer.set_3d_pane_size();
    this.showWhole();
  }

  /* The nearest camera, from the given direction, that has every ball inside the picture. */
  showWhole(direction = this.data.view.direction) {
    const { THREE } = MeshCat;
    const { camera, controls } = this.viewer;
    const back = new THREE.Vector3(...direction).normalize();
    const right = new THREE.Vector3(0, 0, 1).cross(back).normalize();
    const up = back.clone().cross(right);
    const slopeUp = Math.tan((camera.fov * Math.PI) / 360) * 0.92;
    const slopes = [slopeUp * camera.aspect, slopeUp];
    const extremes = [[-Infinity, -Infinity], [-Infinity, -Infinity]];
    let nearest = -Infinity, farthest = Infinity;
    for (const [x, y, z, radius] of this.data.view.balls) {
      const point = new THREE.Vector3(x, y, z);
      const depth = point.dot(back);
      nearest = Math.max(nearest, depth + radius);
      farthest = Math.min(farthest, depth - radius);
      [point.dot(right), point.dot(up)].forEach((side, k) => {
        const pad = radius * Math.hypot(1, slopes[k]);
        extremes[k][0] = Math.max(extremes[k][0], side + slopes[k] * depth + pad);
        extremes[k][1] = Math.max(extremes[k][1], -side + slopes[k] * depth + pad);
      });
    }
    const across = extremes.map(([plus, minus]) => (plus - minus) / 2);
    const away = Math.max(...extremes.map(([plus, minus], k) => (plus + minus) / (2 * slopes[k])), nearest + 0.3);
    const middle = (nearest + farthest) / 2;
    const at = (depth) => {
      const p = new THREE.Vector3().addScaledVector(right, across[0]).addScaledVector(up, across[1]).addScaledVector(back, depth);
      return new THREE.Vector3(p.x, p.z, -p.y);
    };
    camera.position.copy(at(away));
    camera.far = 20 * (away - farthest);
    controls.target.copy(at(middle));
    controls.update();
    this.moved = false;
    this.viewer.set_dirty();
  }

  showFrom(side) {
    const [x, y] = this.data.view.direction;
    this.showWhole(side === "above" ? [0, -0.001, 1] : [x, y, 0.02]);
    this.moved = true;
  }

  follow(on) {
    this.following = on;
    if (!on) { this.showWhole(); return; }
    const { camera, controls } = this.viewer;
    const offset = camera.position.clone().sub(controls.target);
    this.moved = true;
    controls.target.copy(this.movingCentre());
    const centre = this.middle();
    const spread = Math.max(0, ...this.followed.map((frame) => frame.position.distanceTo(centre)));
    camera.position.copy(controls.target).add(offset.clampLength(0, 1.5 + 3.2 * spread));
    this.viewer.set_dirty();
  }

  /* Mean place of the modules that move, in the world; and the same for the camera, whose y is up. */
  middle() {
    const sum = new MeshCat.THREE.Vector3();
    for (const frame of this.followed) sum.add(frame.position);
    return this.followed.length ? sum.divideScalar(this.followed.length) : sum.set(...this.bounds().centre);
  }

  movingCentre() {
    const { x, y, z } = this.middle();
    return new MeshCat.THREE.Vector3(x, z, -y);
  }

  show(time, colours, mark) {
    const { low, next, share: passed } = locate(this.times, time);
    const share = this.data.still ? 0 : passed;
    const count = this.times.length;
    const before = this.following ? this.movingCentre() : null;
    this.frames.forEach((object, frame) => {
      const a = 7 * (frame * count + low), b = 7 * (frame * count + next), p = this.poses;
      const mix = (k, sign) => p[a + k] * (1 - share) + sign * p[b + k] * share;
      object.position.set(mix(0, 1), mix(1, 1), mix(2, 1));
      const dot = p[a + 3] * p[b + 3] + p[a + 4] * p[b + 4] + p[a + 5] * p[b + 5] + p[a + 6] * p[b + 6];
      const sign = dot < 0 ? -1 : 1;
      object.quaternion.set(mix(3, sign), mix(4, sign), mix(5, sign), mix(6, sign)).normalize();
    });
    if (before) {
      const shift = this.movingCentre().sub(before);
      this.viewer.camera.position.add(shift);
      this.viewer.controls.target.add(shift);
    }
    this.restore.forEach((undo) => undo());
    if (colours && colours !== this.colours) {
      this.colours = colours;
      for (const part of this.painted) part.material.color.setHex(mixWithWhite(colours[part.module], part.share));
    }
    this.restore = mark ? this.markFault(...mark) : [];
    if (this.tails) this.moveTails(time);
    this.viewer.set_dirty();
  }

  /* Paints things in the colour of what is at fault, and dots the line between two of them; gives how to undo it. */
  markFault(paths, apart) {
    const { THREE } = MeshCat;
    const undo = [];
    for (const path of paths) {
      this.node(path).traverse(({ isMesh, material }) => {
        if (!isMesh) return;
        const before = { hex: material.color.getHex(), opacity: material.opacity, transparent: material.transparent };
        undo.push(() => {
          material.color.setHex(before.hex);
          Object.assign(material, { opacity: before.opacity, transparent: before.transparent });
        });
        material.color.set(this.data.fault);
        Object.assign(material, { opacity: 0.8, transparent: true });
      });
    }
    if (apart.length) {
      const [from, to] = apart.map((name) => new THREE.Vector3(...this.pose(name).slice(0, 3)));
      const size = 0.007 * this.bounds().radius;
      const count = Math.max(2, Math.min(200, Math.round(from.distanceTo(to) / (3.5 * size))));
      const dots = new THREE.Group();
      const form = new THREE.SphereGeometry(size, 12, 8);
      const paint = new THREE.MeshBasicMaterial({ color: this.data.fault, depthTest: false });
      for (let i = 0; i <= count; i++) {
        const dot = new THREE.Mesh(form, paint);
        dot.position.lerpVectors(from, to, i / count);
        dot.renderOrder = 1;
        dots.add(dot);
      }
      this.viewer.set_object(["meshcat", "apart"], dots);
      undo.push(() => this.viewer.delete_path(["meshcat", "apart"]));
    }
    return undo;
  }

  /* Where the origin of a drawn object lies in the picture: across and up, -1 to 1. */
  onScreen(name) {
    const { THREE } = MeshCat;
    this.viewer.scene.updateMatrixWorld();
    const place = new THREE.Vector3().setFromMatrixPosition(this.node(this.data.names[name]).matrixWorld);
    const seen = place.project(this.viewer.camera);
    return [seen.x, seen.y];
  }

  /* Pose of a drawn object as it stands in the scene now: x, y, z, qx, qy, qz, qw in the world frame. */
  pose(name) {
    if (!Object.hasOwn(this.data.names, name)) return null;
    const { THREE } = MeshCat;
    const object = this.node(this.data.names[name]);
    object.updateWorldMatrix(true, false);
    this.viewer.scene.updateMatrixWorld();
    const matrix = this.viewer.scene.matrixWorld.clone().invert().multiply(object.matrixWorld);
    const position = new THREE.Vector3(), turn = new THREE.Quaternion();
    matrix.decompose(position, turn, new THREE.Vector3());
    return [...position.toArray(), ...turn.toArray()];
  }
}
