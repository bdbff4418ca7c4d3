// The clock of the page: which time of the run is shown, whether it runs, and how fast.

/** Speeds relative to the one at first. */
const SPEEDS = [0.1, 0.2, 0.5, 1, 2, 4];
const FIRST_SPEED = 3;
/** Longest step of the clock, in s: after a pause of the browser the run goes on where it was. */
const LONGEST_STEP = 0.1;
/** Pause (s of film) at the end before the run begins again. */
const END_PAUSE = 1;

/** The clock of a page; it calls `onChange` whenever what is shown changes. At the end of a motion that goes on it waits for more. */
function makePlayer(page, onChange) {
  const player = { time: 0, isPlaying: false, speedIndex: FIRST_SPEED };
  let last = null;
  let waited = 0;

  player.rate = () => SPEEDS[player.speedIndex] / page.data.slowDown;

  const advance = (now) => {
    if (!player.isPlaying) return;
    const step = last === null ? 0 : Math.min((now - last) / 1000, LONGEST_STEP);
    last = now;
    const { start, stop } = page.span;
    if (player.time < stop || page.goesOn) {
      player.time = Math.min(player.time + step * player.rate(), stop);
      waited = 0;
    } else {
      waited += step;
      if (waited > END_PAUSE) player.time = start;
    }
    onChange();
    requestAnimationFrame(advance);
  };

  player.play = () => {
    const { start, stop } = page.span;
    if (player.isPlaying || stop <= start) return;
    if (player.time >= stop && !page.goesOn) player.time = start;
    player.isPlaying = true;
    last = null;
    requestAnimationFrame(advance);
    onChange();
  };
  player.pause = () => {
    player.isPlaying = false;
    onChange();
  };
  player.toggle = () => (player.isPlaying ? player.pause() : player.play());
  player.seek = (time) => {
    const { start, stop } = page.span;
    player.time = Math.min(Math.max(time, start), stop);
    waited = 0;
    onChange();
  };
  player.setSpeed = (index) => {
    player.speedIndex = Math.min(Math.max(index, 0), SPEEDS.length - 1);
    onChange();
  };
  return player;
}

/** How fast a run is shown, in words; `rate` is in seconds of the run per second. */
function describeRate(rate) {
  const round = (value) => Number(value.toPrecision(3));
  if (Math.abs(rate - 1) < 1e-9) return "true time";
  return rate < 1 ? `slowed ${round(1 / rate)}×` : `sped up ${round(rate)}×`;
}
