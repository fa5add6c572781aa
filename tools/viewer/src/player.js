// Time that runs: play, pause, speed, steps.

export class Player {
  constructor(motion) {
    this.motion = motion;
    this.playing = false;
    this.speed = usualSpeed(motion.end - motion.start, motion.fastest());
    this.listeners = [];
  }

  get now() {
    return this.motion.now;
  }

  seek(t) {
    this.motion.moveTo(t);
    for (const listener of this.listeners) listener();
  }

  play(on = !this.playing) {
    if (on && this.now >= this.motion.end) this.seek(this.motion.start);
    this.playing = on;
    for (const listener of this.listeners) listener();
  }

  // To another frame.
  step(frames) {
    const { time } = this.motion;
    const [i, s] = this.motion.locate(this.now);
    const from = s > 0.999 ? i + 1 : s > 0.001 && frames < 0 ? i + 1 : i;
    this.play(false);
    this.seek(time[Math.min(Math.max(from + frames, 0), time.length - 1)]);
  }

  // The clock of the page went on by so many seconds; at the end it begins again.
  tick(seconds) {
    if (!this.playing) return;
    const span = this.motion.end - this.motion.start;
    let t = this.now + this.speed * Math.min(seconds, 0.1);
    if (t > this.motion.end) t = span > 0 ? this.motion.start + ((t - this.motion.start) % span) : this.motion.start;
    this.seek(t);
  }
}

const SEEN = 30; // rad/s of the picture: what turns faster cannot be seen

// Real time, but a short or a long run takes about ten seconds, and what spins turns so slowly that one sees it.
export function usualSpeed(span, spin = 0) {
  const pace = (span >= 1.5 && span <= 40) || span <= 0 ? 1 : span / 10;
  const wanted = Math.min(pace, spin > 0 ? SEEN / spin : pace);
  if (wanted === 1) return 1;
  const power = 10 ** Math.floor(Math.log10(wanted));
  return [5, 2, 1].find((k) => k * power <= wanted * 1.0001) * power;
}
