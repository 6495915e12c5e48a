// Both replays of a comparison follow one clock.
"use strict";
{
  const slider = document.getElementById("both-time");
  const button = document.getElementById("both-play");
  const now = document.getElementById("both-now");
  const frames = [...document.querySelectorAll("iframe")];
  const total = Number(slider.max);
  let last = null;

  function seek(time) {
    slider.value = time;
    now.textContent = `${time.toFixed(2)} s`;
    for (const frame of frames) {
      const replay = frame.contentWindow && frame.contentWindow.tamplang;
      if (replay) replay.seek(time);
    }
  }

  function step(stamp) {
    if (last === null) return;
    const time = Math.min(total, Number(slider.value) + (stamp - last) / 1000);
    last = stamp;
    seek(time);
    if (time < total) requestAnimationFrame(step);
    else stop();
  }

  function stop() {
    last = null;
    button.textContent = "Play both";
  }

  button.addEventListener("click", () => {
    if (last !== null) return stop();
    if (Number(slider.value) >= total) seek(0);
    button.textContent = "Pause both";
    last = performance.now();
    requestAnimationFrame(step);
  });
  slider.addEventListener("input", () => seek(Number(slider.value)));
}
