// What was made, as files: the browser saves films and tables, and the scene is written beside the opened file.

/** Kinds of files that the browser saves, with what they are. */
const EXPORTS = { toml: "scene file", gif: "film", html: "page", csv: "table", svg: "figure (SVG)", png: "figure (PNG)" };

/** Let the browser save a file: name, media type, and content in base64. */
function downloadFile(file) {
  const bytes = Uint8Array.from(atob(file.content), (letter) => letter.charCodeAt(0));
  const address = URL.createObjectURL(new Blob([bytes], { type: file.type }));
  const link = makeNode("a");
  Object.assign(link, { href: address, download: file.name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(address), 1000);
}

/** The colours that the page shows at present. */
function shownTheme() {
  return find("theme").getAttribute("aria-pressed") === "true" ? "dark" : "light";
}

/** What saves: `show(state)` knows the name of the file, `hear(answer)` what became of a request. */
function makeSaving(send) {
  const node = makeNode("div", "saving");
  const name = makeNode("input");
  Object.assign(name, { type: "text", spellcheck: false });
  name.setAttribute("aria-label", "name of the scene file");
  const said = makeNode("span", "said");
  said.setAttribute("role", "status");
  const overwrite = makeButton("Overwrite", () => save(true));
  overwrite.hidden = true;
  const save = (overwrites) => send({ action: "save", name: name.value.trim(), overwrites });
  const line = makeNode("p");
  line.append(makeButton("Save", () => save(false), "into the folder of the opened file"), name, said, overwrite);
  const exported = makeNode("p", "", "Take along: ");
  for (const [ending, words] of Object.entries(EXPORTS)) {
    const ask = () => {
      tell(`The ${words} is being made.`);
      send({ action: "export", ending, theme: shownTheme() });
    };
    const button = makeButton(words, ask);
    button.dataset.ending = ending;
    exported.append(button, " ");
  }
  node.append(line, exported);
  const tell = (text, isQuestion = false) => {
    said.textContent = text;
    overwrite.hidden = !isQuestion;
  };
  name.addEventListener("input", () => tell(""));
  return {
    node,
    show: (state) => {
      if (!name.value) name.value = state.fileName;
    },
    hear: (answer) => {
      if (answer.file) {
        downloadFile(answer.file);
        tell(`${answer.file.name} is made.`);
      } else if ("saved" in answer) {
        tell(answer.question ? `${answer.question} Overwrite it?` : answer.saved, Boolean(answer.question));
      }
    },
  };
}
