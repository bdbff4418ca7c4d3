// Locks: which quantities a drag leaves as they are.

const locked = new Set();

/** The effects of a grip that no lock forbids. */
function freeEffects(grip) {
  return grip.effects.filter(([key]) => !locked.has(key));
}

/** A lock beside every quantity that a drag can change. */
function showLocks(state) {
  for (const key of new Set(state.grips.flatMap((grip) => grip.effects.map(([one]) => one)))) {
    const row = document.getElementById(`value of ${key}`)?.closest(".quantity");
    if (!row || row.querySelector(".lock")) continue;
    const lock = makeButton("lock", () => {
      if (!locked.delete(key)) locked.add(key);
      write();
    });
    lock.className = "lock";
    lock.title = "a locked value is not changed by a drag";
    const write = () => lock.setAttribute("aria-pressed", String(locked.has(key)));
    write();
    row.querySelector("label").after(lock);
  }
}
