// The bar of the player: play, time, speed.
import { button, make, slider } from "./elements.js";
import { short } from "./plots.js";

const PLAY = "▶";
const PAUSE = "❚❚";

export function bar(player, parent) {
  const { motion } = player;
  const play = button(PLAY, "play or pause (space)", () => player.play());
  play.className = "play";
  const time = slider(0, 1, "any", 0, "time (arrow keys step by frames)", (share) =>
    player.seek(motion.start + share * (motion.end - motion.start)),
  );
  time.className = "time";
  time.setAttribute("aria-label", "time");
  const now = make("output", { className: "now" });
  const speed = slider(-6, 2, 0.01, Math.log10(player.speed), "speed (+ and −)", (power) => {
    const near = Math.round(3 * power) / 3; // 1, 2, 5, 10, …
    setSpeed(Math.abs(near - power) < 0.05 ? rounded(10 ** near) : Number((10 ** power).toPrecision(2)));
  });
  speed.className = "speed";
  speed.setAttribute("aria-label", "speed");
  const pace = make("output", { className: "pace" });
  parent.append(play, time, now, speed, pace);

  function setSpeed(value) {
    player.speed = value;
    update();
  }
  function update() {
    const span = motion.end - motion.start;
    play.textContent = player.playing ? PAUSE : PLAY;
    play.setAttribute("aria-label", player.playing ? "pause" : "play");
    time.value = span > 0 ? (player.now - motion.start) / span : 0;
    const digits = Math.max(0, Math.min(9, 3 - Math.floor(Math.log10(span || 1))));
    now.textContent = `${player.now.toFixed(digits)} s`;
    speed.value = Math.log10(player.speed);
    pace.textContent = `${short(player.speed)} ×`;
  }
  player.listeners.push(update);
  update();
  return {
    // The next round number above or below.
    faster(direction) {
      setSpeed(rounded(10 ** ((Math.round(3 * Math.log10(player.speed)) + direction) / 3)));
    },
  };
}

function rounded(value) {
  const power = 10 ** Math.floor(Math.log10(value) + 1e-9);
  return Number(
    (
      [1, 2, 5, 10].reduce((a, b) =>
        Math.abs(Math.log((b * power) / value)) < Math.abs(Math.log((a * power) / value)) ? b : a,
      ) * power
    ).toPrecision(3),
  );
}
