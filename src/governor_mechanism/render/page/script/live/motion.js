// A motion that goes on: the page asks for its next piece as the clock needs it, and shows what was computed.

/** Time (s of film) that is asked for at once, and that is computed ahead of the clock. */
const PIECE_LENGTH = 0.4;
const AHEAD = 0.5;
/** Time (s of film) after which a change acts: about what an answer takes, so that the clock does not wait for it. */
const LEAD = 0.08;
/** Largest number of pieces that can be scrubbed back to. */
const MAX_PIECES = 300;

/** The motion of a page; `send(message)` asks for more, `on.hear(motion)` hears of every piece, `on.showFrames(frames)` when one is shown. */
function makeMotion(page, send, on) {
  const tab = crypto.getRandomValues(new Uint32Array(2)).join("");
  const motion = { isOn: false };
  let pieces = [];
  let number = 0;
  let isWaiting = false;
  let asksAgain = false;
  let isOver = false;

  const ask = (time, isNew = false) => {
    isWaiting = true;
    asksAgain = false;
    number += 1;
    send({ action: "extend", tab, time, duration: PIECE_LENGTH * page.player.rate(), isNew, number });
  };
  const timeOfChange = () => Math.min(page.player.time + (page.player.isPlaying ? LEAD * page.player.rate() : 0), page.span.stop);

  /** Show the piece in which the clock is, and ask for the next one in time. */
  page.beforeRefresh = () => {
    if (!motion.isOn || !pieces.length) return;
    const { time, isPlaying } = page.player;
    const piece = pieces.find((one) => time < one.stop) || pieces[pieces.length - 1];
    page.player.time = Math.min(time, page.span.stop);
    if (piece.data !== page.data) {
      if (piece.frames) on.showFrames(piece.frames);
      showKeepingEquilibria(page, piece.data);
    }
    if (isPlaying && !isWaiting && !isOver && page.span.stop - time < AHEAD * page.player.rate()) ask(page.span.stop);
  };

  /** Let the motion go on from a time of what is shown. */
  motion.start = (time) => {
    pieces = time > page.data.times.start && !motion.isOn ? [{ start: page.data.times.start, stop: time, data: page.data }] : [];
    motion.isOn = true;
    isOver = false;
    page.goesOn = true;
    page.player.pause();
    ask(time, true);
  };
  motion.stop = () => {
    motion.isOn = false;
    page.goesOn = false;
    number += 1;
    isWaiting = false;
  };
  /** What is computed ahead is out of date: go on from the present state. */
  motion.change = () => {
    if (!motion.isOn) return;
    isOver = false;
    if (isWaiting) asksAgain = true;
    else ask(timeOfChange());
  };
  motion.hear = (answer) => {
    if (!motion.isOn || answer.number !== number) return;
    isWaiting = false;
    if (answer.refused) {
      isOver = true;
      page.goesOn = false;
      on.hear(answer);
      return;
    }
    const isFirst = !pieces.some((one) => one.isPiece);
    pieces = answer.note ? [] : pieces.filter((one) => one.start < answer.start).map((one) => ({ ...one, stop: Math.min(one.stop, answer.start) }));
    pieces.push({ start: answer.start, stop: answer.stop, data: decodeData(answer.data), frames: answer.frames, isPiece: true });
    pieces = pieces.slice(-MAX_PIECES);
    isOver = answer.isOver;
    page.goesOn = !isOver;
    showPlots(page, answer.plots);
    if (answer.note) page.player.time = answer.start;
    setSpan(page, pieces[0].start, answer.stop);
    on.hear(answer);
    if (isFirst) page.player.play();
    if (asksAgain) ask(timeOfChange());
  };
  return motion;
}

/** Show drawings, and keep the curve of the equilibria below them. */
function showKeepingEquilibria(page, data) {
  const equilibria = document.getElementById("equilibria");
  showPictures(page, data);
  if (equilibria) find("stage").append(equilibria);
}
