// What the answer of the server shows beside the drawing: readings, equilibria, facts.

/** The readings at one time, with their estimates. */
function showReadings(table, readings, when) {
  table.replaceChildren();
  const caption = table.createCaption();
  caption.textContent = when;
  for (const one of readings) {
    const row = table.insertRow();
    row.append(makeNode("th", "", one.words), makeNode("td", "", one.text));
    row.lastChild.dataset.reading = one.name;
    row.lastChild.dataset.value = one.value;
    row.append(makeNode("td", "estimate", one.estimate));
  }
}

/** The curve of the equilibria below the drawing, with what it says in words. */
function showEquilibria(equilibria) {
  document.getElementById("equilibria")?.remove();
  if (!equilibria) return;
  const figure = makeNode("figure");
  figure.id = "equilibria";
  // The picture is made by the server from numbers and names that are escaped there.
  figure.innerHTML = equilibria.picture;
  figure.append(makeNode("figcaption", "", equilibria.sentences));
  find("stage").append(figure);
}

/** Names and texts as a list of terms. */
function showFacts(section, facts) {
  const list = section.querySelector("dl");
  if (!list) return;
  list.replaceChildren(
    ...facts.map(([name, text]) => {
      const entry = makeNode("div");
      entry.append(makeNode("dt", "", name), makeNode("dd", "", text));
      return entry;
    }),
  );
}
