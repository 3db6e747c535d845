"use strict";
(() => {
  const page = document.documentElement;
  page.classList.add("moves");
  for (const stage of document.querySelectorAll(".stage")) {
    const range = stage.parentNode.querySelector("input");
    const rest = stage.style.getPropertyValue("--at");
    const wipe = (part) => stage.style.setProperty("--at", part + "%");
    stage.addEventListener("pointermove", (event) => {
      const box = stage.getBoundingClientRect();
      const part = Math.min(Math.max((event.clientX - box.left) / box.width, 0), 1) * 100;
      wipe(part);
      if (range) range.value = part;
    });
    if (range) range.addEventListener("input", () => wipe(range.value));
    else stage.addEventListener("pointerleave", () => stage.style.setProperty("--at", rest));
  }
  const button = document.getElementById("blink");
  const toggle = () => button.setAttribute("aria-pressed", page.classList.toggle("blinks"));
  if (document.querySelector(".stage")) button.hidden = false;
  button.addEventListener("click", toggle);
  document.addEventListener("keydown", (event) => {
    if (event.key.toLowerCase() === "b" && !event.ctrlKey && !event.metaKey && !event.altKey) toggle();
  });
})();
