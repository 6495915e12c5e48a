"use strict";
/* The clock of the page: play, pause, seek; everything that shows the time listens to it. */

class Player {
  constructor(data, duration) {
    this.phases = data.phases;
    this.duration = duration;
    this.now = 0;
    this.speed = 1;
    this.playing = false;
    this.listeners = [];
  }

  listen(callback) {
    this.listeners.push(callback);
    callback(this);
  }

  tell() {
    for (const callback of this.listeners) callback(this);
  }

  /* Index of the phase that runs at this moment; -1 without phases. */
  get phase() {
    let found = this.phases.length ? 0 : -1;
    this.phases.forEach(([start], index) => { if (start <= this.now) found = index; });
    return found;
  }

  get atEnd() {
    return this.now >= this.duration;
  }

  seek(time) {
    const wanted = Number(time);
    this.now = Number.isFinite(wanted) ? Math.min(this.duration, Math.max(0, wanted)) : 0;
    this.tell();
  }

  play() {
    if (this.playing || this.duration <= 0) return;
    if (this.atEnd) this.now = 0;
    this.playing = true;
    let last = performance.now();
    const tick = (stamp) => {
      if (!this.playing) return;
      const passed = Math.max(0, Math.min(0.25, (stamp - last) / 1000));
      last = stamp;
      this.now = Math.min(this.duration, this.now + passed * this.speed);
      if (this.atEnd) this.playing = false;
      this.tell();
      if (this.playing) requestAnimationFrame(tick);
    };
    this.tell();
    requestAnimationFrame(tick);
  }

  pause() {
    this.playing = false;
    this.tell();
  }

  toggle() {
    if (this.playing) this.pause(); else this.play();
  }

  nextPhase() {
    const later = this.phases.find(([start]) => start > this.now + 1e-6);
    this.seek(later ? later[0] : this.duration);
  }

  previousPhase() {
    const earlier = this.phases.filter(([start]) => start < this.now - 0.15);
    this.seek(earlier.length ? earlier[earlier.length - 1][0] : 0);
  }
}
