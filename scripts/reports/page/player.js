// The clock of the replay: it runs, stands, or is put somewhere.
Swarm.Player = class {
  constructor(replay, onChange) {
    this.replay = replay;
    this.onChange = onChange;
    this.time = 0;
    this.speed = 1;
    this.isPlaying = false;
    this.last = null;
  }

  seek(time) {
    this.time = Math.max(0, Math.min(this.replay.duration, time));
    this.onChange();
  }

  // Go to the next frame, or with -1 to the one before.
  step(frames) {
    this.pause();
    const frame = this.replay.frameAt(this.time);
    this.seek(this.replay.timeOf(frames > 0 ? Math.floor(frame + 1e-6) + frames : Math.ceil(frame - 1e-6) + frames));
  }

  play() {
    if (this.isPlaying || this.replay.duration <= 0) return;
    if (this.time >= this.replay.duration) this.time = 0;
    this.isPlaying = true;
    this.last = null;
    requestAnimationFrame((now) => this.advance(now));
    this.onChange();
  }

  pause() {
    this.isPlaying = false;
    this.onChange();
  }

  toggle() {
    if (this.isPlaying) this.pause();
    else this.play();
  }

  advance(now) {
    if (!this.isPlaying) return;
    if (this.last !== null) this.time += (this.speed * (now - this.last)) / 1000;
    this.last = now;
    if (this.time >= this.replay.duration) {
      this.time = this.replay.duration;
      this.isPlaying = false;
    }
    this.onChange();
    if (this.isPlaying) requestAnimationFrame((later) => this.advance(later));
  }
};
