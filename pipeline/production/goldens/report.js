"use strict";
const views = [...document.querySelectorAll(".view")];
let blinking = 0;

function show(view, mode) {
  view.dataset.mode = mode;
  for (const button of view.querySelectorAll("[data-mode]")) {
    button.classList.toggle("on", button.dataset.mode === mode);
  }
}

function blink(pace) {
  clearInterval(blinking);
  blinking = setInterval(() => {
    for (const view of views) view.classList.toggle("second");
  }, pace);
}

for (const view of views) {
  show(view, view.dataset.mode);
  for (const button of view.querySelectorAll("button[data-mode]")) {
    button.addEventListener("click", () => show(view, button.dataset.mode));
  }
  view.querySelector(".boxed").addEventListener("change", (event) => {
    view.classList.toggle("plain", !event.target.checked);
  });
  const edge = view.querySelector(".edge");
  const move = () => view.style.setProperty("--edge", edge.value + "%");
  edge.addEventListener("input", move);
  view.querySelector(".stage").addEventListener("pointermove", (event) => {
    if (view.dataset.mode !== "swipe") return;
    const box = event.currentTarget.getBoundingClientRect();
    edge.value = String(Math.round((100 * (event.clientX - box.left)) / box.width));
    move();
  });
}

const pace = document.getElementById("pace");
pace.addEventListener("input", () => {
  document.getElementById("pace-told").textContent = pace.value + " ms";
  blink(Number(pace.value));
});
blink(Number(pace.value));

document.getElementById("failures").addEventListener("change", (event) => {
  document.body.classList.toggle("failures", event.target.checked);
});
document.getElementById("zoom").addEventListener("change", (event) => {
  document.documentElement.style.setProperty("--zoom", event.target.value);
});
for (const button of document.querySelectorAll(".copy")) {
  button.addEventListener("click", () => {
    const range = document.createRange();
    range.selectNodeContents(button.previousElementSibling);
    getSelection().removeAllRanges();
    getSelection().addRange(range);
    // Pages from files may not use the newer way of copying.
    button.textContent = document.execCommand("copy") ? "copied" : "marked";
  });
}
