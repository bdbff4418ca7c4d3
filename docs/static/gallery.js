// The gallery: films instead of posters where asked for, and cards that fit what is chosen.
"use strict";

const stillness = matchMedia("(prefers-reduced-motion: reduce)");
const choices = document.querySelector(".choices");
const cards = [...document.querySelectorAll("article.scene")];

/** Shows the film of a card, which is loaded then, or its poster. */
function show(button, isFilm) {
  const picture = button.querySelector("img");
  picture.dataset.poster ??= picture.getAttribute("src");
  const source = isFilm ? button.dataset.film : picture.dataset.poster;
  if (picture.getAttribute("src") !== source) picture.src = source;
  button.setAttribute("aria-pressed", isFilm);
}

for (const button of document.querySelectorAll("article.scene > button")) {
  const isMouse = (event) => event.pointerType === "mouse";
  button.addEventListener("pointerenter", (event) => isMouse(event) && show(button, true));
  button.addEventListener("pointerleave", (event) => isMouse(event) && show(button, false));
  // With the keyboard alone: the film of the card on which the focus is.
  button.addEventListener("focus", () => button.matches(":focus-visible") && !stillness.matches && show(button, true));
  button.addEventListener("blur", () => show(button, false));
  button.addEventListener("click", (event) => {
    if (event.pointerType !== "mouse") show(button, button.getAttribute("aria-pressed") !== "true");
  });
}

/** Hides the cards that do not fit, and headings without cards. */
function choose() {
  const wanted = [...choices.querySelectorAll("select")].filter((list) => list.value);
  const fits = (card) => wanted.every((list) => card.dataset[list.dataset.filter].split("|").includes(list.value));
  for (const card of cards) card.hidden = !fits(card);
  for (const group of document.querySelectorAll(".cards")) {
    group.closest("section").hidden = !group.querySelector(".scene:not([hidden])");
  }
  const count = cards.filter((card) => !card.hidden).length;
  choices.querySelector("output").textContent = count === 1 ? "1 scene" : `${count} scenes`;
}

choices.addEventListener("change", choose);
choices.addEventListener("submit", (event) => event.preventDefault());
choose(); // the browser keeps what was chosen when one comes back
