// What is asked for when its heading is opened: the events of a valve with Zeuner's diagram, and the assemblies.

/** A section that asks when it is opened, and again when the run is another one: `show(state)`, `hear(answer)`. */
function makeInspection(name, heading, ask, fill) {
  const node = makeNode("details", "inspection");
  node.hidden = true;
  const content = makeNode("div");
  node.append(makeNode("summary", "", heading), content);
  let asked = -1;
  let number = 0;
  const request = () => {
    if (node.hidden || !node.open || asked === number) return;
    asked = number;
    ask();
  };
  node.addEventListener("toggle", request);
  return {
    node,
    show: (state) => {
      if (!state.inspections) return;
      node.hidden = !state.inspections.includes(name);
      number = state.number;
      request();
    },
    hear: (answer) => {
      if (answer[name]) fill(content, answer[name]);
    },
  };
}

/** The events of a valve. */
function makeValveSection(send) {
  const fill = (content, valve) => {
    const picture = makeNode("img");
    picture.src = `data:image/png;base64,${valve.picture}`;
    picture.alt = "Zeuner’s diagram of the valve, with its events and steam phases";
    content.replaceChildren(makeNode("pre", "", valve.timing), picture);
  };
  return makeInspection("valve", "Valve events", () => send({ action: "valve", theme: shownTheme() }), fill);
}

/** The ways in which the joints close, of which another one may be taken. */
function makeAssemblySection(send) {
  const fill = (content, found) => {
    const choice = makeNode("select");
    choice.setAttribute("aria-label", "assembly");
    for (let number = 1; number <= found.count; number += 1) {
      const option = makeNode("option", "", `assembly ${number}`);
      option.value = number;
      option.selected = number === found.taken;
      choice.append(option);
    }
    choice.addEventListener("change", () => send({ action: "assemble", assembly: Number(choice.value) }));
    content.replaceChildren(choice, makeNode("pre", "", found.text));
  };
  return makeInspection("assemblies", "Assemblies", () => send({ action: "assemblies" }), fill);
}
