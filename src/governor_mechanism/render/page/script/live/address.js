// The changes in the address of the page: a link to it opens the scene with them.

/** Read the changes of the address, once: values by key. */
function readAddress() {
  const values = [...new URLSearchParams(location.hash.slice(1))].map(([key, value]) => [key, Number(value)]);
  return Object.fromEntries(values.filter(([, value]) => Number.isFinite(value)));
}

/** Keep the address of the page that of its changes: `show(state)`. */
function makeAddress(change) {
  const isServed = location.protocol.startsWith("http");
  let asked = isServed ? readAddress() : {};
  const show = (state) => {
    if (!isServed || !state.changes) return;
    const values = Object.fromEntries(state.quantities.map((one) => [one.key, one.value]));
    const wanted = Object.entries(asked).filter(([key, value]) => key in values && values[key] !== value);
    asked = {};
    if (wanted.length) {
      change(Object.fromEntries(wanted), true);
      return;
    }
    const hash = new URLSearchParams(Object.entries(state.changes)).toString();
    if (hash !== location.hash.slice(1)) history.replaceState(null, "", hash ? `#${hash}` : location.pathname);
  };
  return { show };
}
